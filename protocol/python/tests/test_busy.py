"""Busy times: a long run keeps the same slots as in Rust."""

import unittest

from thirdbody.busy import SLOT_NS, SPANS, BusyTimes, kept_before_ns


class Busy(unittest.TestCase):
    def test_slots_whose_number_is_a_multiple_are_kept(self):
        self.assertEqual(kept_before_ns(10 * SLOT_NS + 7, 1), 10 * SLOT_NS + 7)
        self.assertEqual(kept_before_ns(10 * SLOT_NS + 7, 4), 3 * SLOT_NS)
        self.assertEqual(kept_before_ns(8 * SLOT_NS + 7, 4), 2 * SLOT_NS + 7)

    def test_long_runs_keep_few_spans_and_the_share_of_their_time(self):
        busy = BusyTimes()
        spans, step = 10 * SPANS, SLOT_NS // 8
        for at in range(spans):
            busy.add((at * step, at * step + step // 4))
        self.assertLessEqual(len(busy.spans_ns), SPANS)
        self.assertGreater(busy.every, 4)
        worked = sum(kept_before_ns(end, busy.every) - kept_before_ns(start, busy.every) for start, end in busy.spans_ns)
        self.assertEqual(4 * worked, kept_before_ns(spans * step, busy.every))


if __name__ == "__main__":
    unittest.main()
