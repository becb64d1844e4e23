"""Spans of time in which a process was at work, on the coordinator's clock: all processes of a host share one."""

import time
from typing import Any, Dict, List, Tuple

SLOT_NS = 1 << 22
SPANS = 1 << 17


class BusyTimes:
    """Spans of time (ns of the monotonic clock) in order. A long run keeps only spans that touch a slot of time whose
    number is a multiple of `every`; slots are counted on the common clock, so that all participants keep the same ones."""

    def __init__(self) -> None:
        #: Lead of this host's clock over the common one.
        self.ahead_ns = 0
        self.every = 1
        self.spans_ns: List[Tuple[int, int]] = []

    def until_now(self, start_ns: int) -> None:
        """Adds the span from `start_ns`, on this host's clock, until now."""
        self.add((start_ns - self.ahead_ns, time.monotonic_ns() - self.ahead_ns))

    def add(self, span: Tuple[int, int]) -> None:
        """Adds a span."""
        if not _touches(span, self.every):
            return
        self.spans_ns.append(span)
        while len(self.spans_ns) > SPANS:
            self.every *= 2
            self.spans_ns = [span for span in self.spans_ns if _touches(span, self.every)]

    def document(self) -> Dict[str, Any]:
        """The spans in the form of `Finished`."""
        return {"every": self.every, "spans_ns": self.spans_ns}


def kept_before_ns(at_ns: int, every: int) -> int:
    """Length of the kept slots before an instant."""
    periods, rest = divmod(at_ns, SLOT_NS * every)
    return periods * SLOT_NS + min(rest, SLOT_NS)


def _touches(span: Tuple[int, int], every: int) -> bool:
    return kept_before_ns(span[1], every) > kept_before_ns(span[0], every)
