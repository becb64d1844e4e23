"""A participant with a coordinator on another host follows protocol/WIRE.md; the coordinator here is written from that page."""

import contextlib
import hashlib
import itertools
import json
import os
import queue
import signal
import socket
import struct
import subprocess
import sys
import threading
import time
import unittest
from pathlib import Path
from unittest import mock

import zenoh
from test_golden import Bed, session, transcript

from thirdbody.link import LinkError, LinkFull
from thirdbody.serve import Server, _connect
from thirdbody.wire import Frame, Header, opened, stamped

DEADLINE_S = 20.0
PIECE, PING, PONG, LEFT = range(4)
KEY = bytes(range(32))
#: The other host's clock is ten days ahead of ours.
AHEAD_NS = 10 * 86_400 * 10**9


def endpoint():
    """A free endpoint of this host."""
    with socket.socket() as found:
        found.bind(("127.0.0.1", 0))
        return f"tcp/127.0.0.1:{found.getsockname()[1]}"


def settings(listen=(), connect=()):
    """Zenoh settings, as a coordinator makes them."""
    return {
        "mode": "peer",
        "listen": {"endpoints": list(listen)},
        "connect": {
            "endpoints": list(connect), "timeout_ms": -1, "exit_on_failure": False,
            "retry": {"period_init_ms": 20, "period_max_ms": 100, "period_increase_factor": 2},
        },
        "scouting": {"multicast": {"enabled": False}, "gossip": {"enabled": False}},
        "open": {"return_conditions": {"connect_scouted": False}},
    }


class Coordinator:
    """Signs and reads messages. It takes pieces and answers pings, unless a test changes that."""

    def __init__(self, participant="bed"):
        self.endpoint = endpoint()
        self.session = {**session(), "idle_deadline_s": DEADLINE_S, "transport": {
            "kind": "zenoh", "config": settings(connect=[self.endpoint]), "key": KEY.hex(), "lost_after_s": DEADLINE_S,
        }}
        self.sent = self.received = self.taken = 0
        self.frames, self.arriving = queue.Queue(), b""
        #: Each message: purpose, number, received, taken, clock_ns, echo_ns.
        self.messages = queue.Queue()
        #: Numbers of pieces that do not arrive, once each.
        self.lost = set()
        self.mute = False
        #: Farewells that do not arrive.
        self.deaf_to_farewells = 0
        place = f"thirdbody/{self.session['run_id']:016x}/{participant}"
        self.zenoh = zenoh.open(zenoh.Config.from_json5(json.dumps(settings(listen=[self.endpoint]))))
        self.publisher = self.zenoh.declare_publisher(f"{place}/request", congestion_control=zenoh.CongestionControl.BLOCK)
        self.zenoh.declare_subscriber(f"{place}/answer", self.hear)

    def link(self, **transport):
        """The participant's end, to be closed."""
        self.session["transport"].update(transport)
        return _connect(self.session)

    def signed(self, purpose, number=0, clock_ns=0, echo_ns=0, content=b"", key=KEY, sender=b"q"):
        numbers = (purpose, number, self.received, self.taken, clock_ns or time.monotonic_ns() + AHEAD_NS, echo_ns)
        body = struct.pack("<6Q", *numbers) + content
        return hashlib.blake2b(sender + body, key=key, digest_size=32).digest() + body

    def publish(self, purpose, **numbers):
        self.publisher.put(self.signed(purpose, **numbers))

    def pieces(self, header, payload):
        """The signed pieces of a frame."""
        made = []
        for start in range(0, len(payload) + 1, 8 * 4096):
            self.sent += 1
            made.append(self.signed(PIECE, self.sent, content=header.pack() + payload[start : start + 8 * 4096]))
        return made

    def send(self, header, payload=b""):
        """All its pieces."""
        for piece in self.pieces(header, payload):
            self.publisher.put(piece)

    def hear(self, sample):
        message = sample.payload.to_bytes()
        if message[:32] != hashlib.blake2b(b"a" + message[32:], key=KEY, digest_size=32).digest():
            return
        numbers = purpose, number, _, _, clock_ns, _ = struct.unpack_from("<6Q", message, 32)
        if purpose == PIECE and number in self.lost:
            self.lost.discard(number)
            return
        if purpose == PIECE and number == self.received + 1:
            self.received += 1
            self.arriving += message[152:]
            if len(message) < 152 + 8 * 4096:
                self.frames.put(Frame(Header.unpack(message[80:152]), self.arriving))
                self.arriving = b""
        elif purpose == LEFT and self.deaf_to_farewells:
            self.deaf_to_farewells -= 1
        elif purpose in (PIECE, PING, LEFT) and not self.mute:
            # The test may be over.
            with contextlib.suppress(zenoh.ZError):
                self.publish(PONG, echo_ns=clock_ns)
        self.messages.put(numbers)

    def receive(self):
        """The next frame."""
        frame = self.frames.get(timeout=DEADLINE_S)
        self.taken += 1
        return frame

    def until(self, wanted):
        """The first wanted message, and the messages before it."""
        before = []
        while not wanted(*(message := self.messages.get(timeout=DEADLINE_S))):
            before.append(message)
        return message, before

    def meet(self):
        """Waits until the participant's pings arrive."""
        self.until(lambda purpose, *_: purpose == PING)

    def ping(self):
        """The answer to a ping, and the messages before it."""
        clock_ns = time.monotonic_ns() + AHEAD_NS
        self.publish(PING, clock_ns=clock_ns)
        return self.until(lambda purpose, *numbers: purpose == PONG and numbers[-1] == clock_ns)


def waiting(link, patience_s=DEADLINE_S):
    """A thread in which a participant waits for a frame, and a list for the frame or the error."""
    found = []

    def wait():
        try:
            found.append(link.receive(patience_s))
        except LinkError as error:
            found.append(error)

    thread = threading.Thread(target=wait, daemon=True)
    thread.start()
    return thread, found


class Network(unittest.TestCase):
    def setUp(self):
        self.coordinator = Coordinator()
        self.addCleanup(self.coordinator.zenoh.close)

    def connected(self, **transport):
        """A participant's end after both ends have received a message."""
        link = self.coordinator.link(**transport)
        self.addCleanup(link.close)
        thread, found = waiting(link)
        self.coordinator.meet()
        self.coordinator.send(Header(window=1))
        thread.join(DEADLINE_S)
        self.assertEqual(found, [Frame(Header(window=1), b"")])
        return link

    def heard(self, link):
        """A waiting participant's answer to a ping, its messages before it, and the frame it found."""
        thread, found = waiting(link)
        answer, before = self.coordinator.ping()
        self.coordinator.send(Header(window=9))
        thread.join(DEADLINE_S)
        return answer, before, found[0]

    def test_a_whole_conversation_is_the_recorded_one(self):
        requests, written = transcript()
        link = self.coordinator.link()
        server = Server(self.coordinator.session, link)

        def take_part():
            server.serve(Bed)
            link.close()

        thread = threading.Thread(target=take_part, daemon=True)
        thread.start()
        self.coordinator.meet()
        start_ns = time.monotonic_ns()
        for turn, (request, due) in enumerate(zip(requests, written)):
            self.coordinator.send(request.header, request.payload)
            answer = self.coordinator.receive()
            self.assertIsNone(opened(answer.header, answer.payload, turn))
            self.assertEqual(answer.word, due.word)
            if answer.word not in ("Welcome", "Finished"):
                self.assertEqual(answer, due)
        end_ns = time.monotonic_ns()
        spans_ns = json.loads(answer.text)["busy"]["spans_ns"]
        self.assertEqual(len(spans_ns), len(requests) - 1)
        times_ns = [at_ns - AHEAD_NS for span in spans_ns for at_ns in span]
        slack_ns = 10**9
        self.assertTrue(all(start_ns - slack_ns <= at_ns <= end_ns + slack_ns for at_ns in times_ns), times_ns)
        self.assertEqual(times_ns, sorted(times_ns))
        thread.join(DEADLINE_S)
        self.assertFalse(thread.is_alive())
        self.coordinator.until(lambda purpose, *_: purpose == LEFT)

    def test_the_quickest_round_trip_gives_the_clock(self):
        link = self.connected()
        self.assertLess(abs(link.clock_ahead_ns() + AHEAD_NS), 10**9)

    def test_a_lost_piece_is_sent_again_and_nothing_comes_twice(self):
        link = self.connected()
        payload = os.urandom(8 * 10_000)
        self.coordinator.lost = {2}
        link.send(Header(window=2), payload, DEADLINE_S)
        thread, found = waiting(link)
        self.assertEqual(self.coordinator.receive(), Frame(Header(window=2), payload))
        self.coordinator.send(Header(window=3))
        thread.join(DEADLINE_S)
        self.assertEqual(found, [Frame(Header(window=3), b"")])
        link.send(Header(window=4), b"", DEADLINE_S)
        self.assertEqual(self.coordinator.receive(), Frame(Header(window=4), b""))
        self.assertTrue(self.coordinator.frames.empty())
        # The first piece had been confirmed.
        numbers = [message[1] for message in self.coordinator.messages.queue if message[0] == PIECE]
        self.assertEqual(numbers[:4], [1, 3, 2, 3])

    def test_the_last_answer_is_sent_again_before_it_leaves(self):
        link = self.coordinator.link()
        thread, _ = waiting(link)
        self.coordinator.meet()
        self.coordinator.send(Header(window=1))
        thread.join(DEADLINE_S)
        self.coordinator.lost = {1}
        link.send(Header(window=2), b"", DEADLINE_S)
        link.close()
        self.assertEqual(self.coordinator.receive(), Frame(Header(window=2), b""))
        self.coordinator.until(lambda purpose, *_: purpose == LEFT)

    def test_it_repeats_its_farewell_until_it_is_heard(self):
        link = self.connected()
        self.coordinator.deaf_to_farewells = 3
        link.close()
        self.coordinator.zenoh.close()
        said = [purpose for purpose, *_ in self.coordinator.messages.queue]
        self.assertEqual(said.count(LEFT), 4)

    def test_it_leaves_a_coordinator_that_does_not_hear_its_farewell(self):
        link = self.connected()
        self.coordinator.mute = True
        start = time.monotonic()
        link.close()
        self.assertLess(time.monotonic() - start, 5.0)

    def test_frames_of_every_length_arrive_both_ways(self):
        link = self.connected()
        for window, length in enumerate((0, 1, 4095, 4096, 4097, 8192, 300_000)):
            header, payload = Header(window=window), os.urandom(8 * length)
            self.coordinator.send(header, payload)
            self.assertEqual(link.receive(DEADLINE_S), Frame(header, payload))
            link.send(header, payload, DEADLINE_S)
            self.assertEqual(self.coordinator.receive(), Frame(header, payload))

    def test_a_piece_that_comes_twice_is_taken_once(self):
        link = self.connected()
        [piece] = self.coordinator.pieces(Header(window=2), b"")
        [after] = self.coordinator.pieces(Header(window=3), b"")
        for message in (piece, piece, after, piece):
            self.coordinator.publisher.put(message)
        self.assertEqual([link.receive(DEADLINE_S).header.window for _ in range(2)], [2, 3])
        answer, before, found = self.heard(link)
        self.assertEqual(answer[2:4], (3, 3), "pieces received and frames taken")
        self.assertEqual(found.header.window, 9)
        again_ns = struct.unpack_from("<Q", piece, 64)[0]
        self.assertEqual(sum(message[0] == PONG and message[-1] == again_ns for message in before), 2)

    def test_a_piece_after_a_missing_one_waits_for_it(self):
        link = self.connected()
        pieces = self.coordinator.pieces(Header(window=2), bytes(8 * 4096))
        for message in pieces[1:] + pieces:
            self.coordinator.publisher.put(message)
        self.assertEqual(link.receive(DEADLINE_S), Frame(Header(window=2), bytes(8 * 4096)))

    def test_a_message_with_a_wrong_signature_is_ignored(self):
        link = self.connected()
        coordinator, number, header = self.coordinator, self.coordinator.sent + 1, Header(window=2).pack()
        damaged = bytearray(coordinator.signed(PIECE, number, content=header))
        damaged[-1] ^= 1
        for message in (
            coordinator.signed(PIECE, number, content=header, key=bytes(32)),
            coordinator.signed(PIECE, number, content=header, sender=b"a"),
            bytes(damaged),
            coordinator.signed(PING, key=bytes(32)),
            coordinator.signed(LEFT, sender=b"a"),
            coordinator.signed(PING)[:-8],
            b"",
        ):
            coordinator.publisher.put(message)
        answer, before, found = self.heard(link)
        self.assertEqual(answer[2:4], (1, 1), "pieces received and frames taken")
        self.assertNotIn(PONG, [message[0] for message in before])
        self.assertEqual(found.header.window, 9)

    def test_a_ping_that_came_before_is_not_answered(self):
        link = self.connected()
        ping = self.coordinator.signed(PING)
        for _ in range(3):
            self.coordinator.publisher.put(ping)
        _, before, _ = self.heard(link)
        self.assertEqual(sum(message[0] == PONG for message in before), 1)

    def test_a_ping_is_answered_while_the_solver_computes(self):
        answered = threading.Event()

        class Busy(Bed):
            def advance(self, window, force):
                end = time.monotonic() + DEADLINE_S
                while not answered.is_set():
                    assert time.monotonic() < end, "no ping was answered"
                return super().advance(window, force)

        requests, _ = transcript()
        link = self.coordinator.link()
        self.addCleanup(link.close)
        server = Server(self.coordinator.session, link)
        threading.Thread(target=server.serve, args=(Busy,), daemon=True).start()
        self.coordinator.meet()
        for request in requests:
            self.coordinator.send(request.header, request.payload)
            if request.word == "Advance":
                break
            self.coordinator.receive()
        # The request was received but not answered.
        while self.coordinator.ping()[0][2] < self.coordinator.sent:
            pass
        self.coordinator.ping()
        self.assertTrue(self.coordinator.frames.empty())
        answered.set()
        self.assertEqual(self.coordinator.receive().word, "Motion")

    def test_silence_ends_it(self):
        link = self.connected(lost_after_s=1.0)
        self.assertIsNone(link.receive(1.1), "an end that answers pings is alive")
        self.coordinator.mute = True
        start = time.monotonic()
        with self.assertRaisesRegex(LinkError, "no sign of life from the coordinator for 1.0 s"):
            link.receive(DEADLINE_S)
        self.assertGreaterEqual(time.monotonic() - start, 0.5)

    def test_time_in_which_it_was_stopped_does_not_count_as_silence(self):
        link = self.connected(lost_after_s=5.0)
        self.coordinator.mute = True
        stopped = mock.Mock(wraps=time, monotonic=itertools.count(0.0, 100.0).__next__)
        with mock.patch("thirdbody.network.time", stopped):
            self.assertIsNone(link.receive(0.6))

    def test_it_waits_for_a_coordinator_that_was_never_heard(self):
        link = self.coordinator.link(lost_after_s=0.1)
        self.addCleanup(link.close)
        self.coordinator.mute = True
        self.assertIsNone(link.receive(0.3))

    def test_it_does_not_wait_for_a_coordinator_that_leaves(self):
        link = self.connected()
        self.coordinator.send(Header(window=2))
        self.coordinator.publish(LEFT)
        self.assertEqual(link.receive(DEADLINE_S).header.window, 2, "a frame from before it left is received")
        with self.assertRaisesRegex(LinkError, "closed the connection"):
            link.receive(DEADLINE_S)
        # A leaving coordinator repeats its farewell until it is heard.
        self.coordinator.until(lambda purpose, *_: purpose == PONG)

    def test_a_third_frame_waits_until_the_first_is_taken(self):
        link = self.connected()
        for window in (2, 3):
            link.send(Header(window=window), b"", DEADLINE_S)
        with self.assertRaises(LinkFull):
            link.send(Header(window=4), b"", 0.1)
        self.coordinator.receive()
        link.send(Header(window=4), b"", DEADLINE_S)
        self.assertEqual([self.coordinator.receive().header.window for _ in range(2)], [3, 4])

    def test_without_zenoh_the_error_says_what_to_install(self):
        hidden = {"zenoh": None, "thirdbody.network": None}
        with mock.patch.dict(sys.modules, hidden), self.assertRaisesRegex(LinkError, r"pip install 'thirdbody\[network\]'"):
            _connect(self.coordinator.session)

    def test_an_endpoint_that_zenoh_refuses_is_an_error(self):
        with self.assertRaisesRegex(LinkError, "zenoh"):
            self.coordinator.link(config=settings(connect=["nonsense"]))


class Launched(unittest.TestCase):
    """A process that reads its session from standard input."""

    def setUp(self):
        self.coordinator = Coordinator()
        self.addCleanup(self.coordinator.zenoh.close)
        program = "import thirdbody; from test_golden import Bed; thirdbody.participate(Bed)"
        search = os.pathsep.join([str(Path(__file__).parent), *filter(None, sys.path)])
        self.process = subprocess.Popen(
            [sys.executable, "-c", program], stdin=subprocess.PIPE, stderr=subprocess.PIPE,
            # A signal would end a thread of NumPy, and with it the process, before our thread can take the signal.
            env={**os.environ, "THIRDBODY_SESSION": "-", "PYTHONPATH": search, "OPENBLAS_NUM_THREADS": "1"},
        )
        self.addCleanup(self.process.communicate)
        self.addCleanup(self.process.kill)

    def start(self):
        """Sends the session and waits for the first ping."""
        self.process.stdin.write(json.dumps(self.coordinator.session).encode() + b"\n")
        self.process.stdin.flush()
        self.coordinator.meet()

    def ended(self):
        """Its exit code and its output, after standard input is closed and it has ended."""
        _, text = self.process.communicate(timeout=DEADLINE_S)
        return self.process.returncode, text.decode()

    def test_it_takes_part_and_leaves(self):
        self.start()
        for request in transcript()[0]:
            self.coordinator.send(request.header, request.payload)
            answer = self.coordinator.receive()
        self.assertEqual(answer.word, "Finished")
        # Standard input stays open until it has ended.
        self.assertEqual(self.process.wait(DEADLINE_S), 0)
        self.coordinator.until(lambda purpose, *_: purpose == LEFT)

    def test_it_ends_with_standard_input(self):
        self.start()
        hello = transcript()[0][0]
        self.coordinator.send(hello.header, hello.payload)
        self.assertEqual(self.coordinator.receive().word, "Welcome")
        code, text = self.ended()
        self.assertEqual(code, 4)
        self.assertEqual(text, "standard input has ended, and with it the coordinator or the connection to it\n")

    def test_it_ends_on_a_signal(self):
        self.start()
        self.process.send_signal(signal.SIGTERM)
        self.assertIn(self.process.wait(DEADLINE_S), (128 + signal.SIGTERM, -signal.SIGTERM))

    def test_a_fault_arrives_before_it_leaves(self):
        self.start()
        self.coordinator.lost = {1}
        header = Header(kind=10, run_id=self.coordinator.session["run_id"])
        self.coordinator.send(stamped(header, b"", 0))
        self.assertEqual(self.coordinator.receive().word, "Fault")
        self.coordinator.until(lambda purpose, *_: purpose == LEFT)
        self.assertEqual(self.ended(), (4, "the first frame must be the greeting\n"))

    def test_the_error_names_a_missing_session(self):
        self.assertEqual(self.ended(), (1, "standard input ended before the session came\n"))


if __name__ == "__main__":
    unittest.main()
