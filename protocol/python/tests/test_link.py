"""A frame of any length that is cut off continues where it was."""

import unittest

from thirdbody.link import SAMPLE_DOUBLES, Link, LinkError, LinkFull
from thirdbody.serve import Server
from thirdbody.wire import Header

LENGTHS = (0, 1, 16_383, 16_384, 16_385, 32_767, 32_768, 32_769, 65_535, 65_536, 65_537, 81_920, 300_000)


class Slow(Link):
    """A link whose other end takes a sample only at every third attempt."""

    def __init__(self):
        self._connected, self._begun, self._attempts = True, None, 0
        self.taken = []

    def _send_sample(self, header, part, deadline):
        self._attempts += 1
        if self._attempts % 3:
            raise LinkFull("the coordinator took no frame in time")
        self.taken.append(part)


def payload(length):
    return b"".join(i.to_bytes(8, "little") for i in range(length))


class CutOff(unittest.TestCase):
    def test_a_server_sends_every_length(self):
        session = {"run_id": 1, "idle_deadline_s": 60.0}
        for length in LENGTHS:
            link = Slow()
            Server(session, link)._send("Motion", payload(length))
            self.assertEqual(b"".join(link.taken), payload(length), length)
            full = [len(part) == 8 * SAMPLE_DOUBLES for part in link.taken]
            self.assertEqual(full, [True] * (length // SAMPLE_DOUBLES) + [False], length)

    def test_patience_ends(self):
        link = Slow()
        link._send_sample = lambda *_: Slow._send_sample(Slow(), *_)
        with self.assertRaises(LinkFull):
            Server({"run_id": 1, "idle_deadline_s": 2.5}, link)._send("Motion", b"")

    def test_only_the_rest_of_a_frame_can_follow_its_beginning(self):
        link = Slow()
        link._attempts = 2
        with self.assertRaises(LinkFull):
            link.send(Header(window=1), payload(20_000), 1.0)
        with self.assertRaisesRegex(LinkError, "only its rest"):
            link.send(Header(window=2), b"", 1.0)


if __name__ == "__main__":
    unittest.main()
