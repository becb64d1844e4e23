"""The participant's end of a connection to a coordinator on another host (protocol/WIRE.md, "Between hosts").

zenoh reconnects by itself, but does not repeat messages lost meanwhile, and any program that it lets in may publish. So this end numbers
pieces of frames, keeps them until the coordinator confirms them and repeats the missing ones; it signs every message.
"""

from __future__ import annotations

import contextlib
import hashlib
import hmac
import json
import math
import struct
import threading
import time
from collections import deque
from typing import Any, Callable, Deque, Dict, List, Optional, Tuple

import zenoh

from .link import LinkError, LinkFull
from .wire import LAYOUT, Frame, Header

PIECE, PING, PONG, LEFT = range(4)
PIECE_SIZE = 8 * 4096
WAITING_FRAMES = 2
#: Pause between two pings of a wait, and before the coordinator's first message.
PAUSE_S, SOON_S = 0.25, 20e-3
ROUND_TRIPS, LONGEST_TRIP_S = 9, 2.0
FAREWELLS = 50  # One second, with the pauses between them.
SIGNATURE_SIZE = 32
#: purpose, number, received, taken, clock_ns, echo_ns.
NUMBERS = struct.Struct("<6Q")
HEADER_AT = SIGNATURE_SIZE + NUMBERS.size
PAYLOAD_AT = HEADER_AT + LAYOUT.size


class NetworkLink:
    """Requests in, answers out; frames arrive in order, once and whole."""

    def __init__(self, transport: Dict[str, Any], run_id: int, participant: str) -> None:
        """Connects in the background: the first frame, or the first answered ping, waits for the connection."""
        key = bytes.fromhex(transport["key"])
        self._ours, self._theirs = (hashlib.blake2b(sender, key=key, digest_size=SIGNATURE_SIZE) for sender in (b"a", b"q"))
        self._lost_after_s = transport["lost_after_s"]
        # Number, piece, and the time at which zenoh took it.
        self._unconfirmed: Deque[List[Any]] = deque()
        self._sent_pieces = self._sent_frames = 0
        # Time spent waiting since the coordinator's last message (-inf before its first), and since the last ping.
        self._silent_s, self._unpinged_s = -math.inf, 0.0
        # The data from zenoh's thread, behind the lock of this condition.
        self._changed = threading.Condition(threading.Lock())
        self._arrived: Deque[Frame] = deque()
        self._arriving: List[memoryview] = []
        self._received = self._taken = self._confirmed_pieces = self._taken_frames = 0
        self._heard = self._left = False
        self._heard_ping_ns = self._heard_ns = self._heard_there_ns = 0
        self._round_trip: Optional[Tuple[int, int]] = None
        place = f"thirdbody/{run_id:016x}/{participant}"
        settings = {"priority": zenoh.Priority.REAL_TIME, "express": True}
        try:
            self._session = zenoh.open(zenoh.Config.from_json5(json.dumps(transport["config"])))
            declare = self._session.declare_publisher
            self._frames = declare(f"{place}/answer", congestion_control=zenoh.CongestionControl.BLOCK, **settings)
            self._signs = declare(f"{place}/answer", congestion_control=zenoh.CongestionControl.DROP, **settings)
            self._session.declare_subscriber(f"{place}/request", self._hear)
        except zenoh.ZError as error:
            raise LinkError(f"zenoh: {error}") from error

    def send(self, header: Header, payload: bytes, patience_s: float) -> None:
        """Sends one frame, in pieces that are kept until the coordinator confirms them."""
        if not self._wait(patience_s, lambda: self._sent_frames < self._taken_frames + WAITING_FRAMES):
            raise LinkFull("the coordinator took no frame in time")
        self._sent_frames += 1
        packed, doubles = header.pack(), memoryview(payload)
        # The last piece is shorter than the others, and may be empty.
        for start in range(0, len(payload) + 1, PIECE_SIZE):
            self._sent_pieces += 1
            content = packed, doubles[start : start + PIECE_SIZE]
            piece = zenoh.ZBytes(self._message(PIECE, self._sent_pieces, time.monotonic_ns(), self._heard_ns, *content))
            self._unconfirmed.append([self._sent_pieces, piece, 0])
            self._put(self._unconfirmed[-1])

    def receive(self, patience_s: float) -> Optional[Frame]:
        """The next frame, or `None` if it did not come in time."""
        return self._wait(patience_s, self._next_frame)

    def clock_ahead_ns(self) -> int:
        """Lead of this host's clock over the coordinator's; of several round trips the shortest gives the best value."""
        trips = []
        for _ in range(ROUND_TRIPS):
            self._ping()
            trips.append(self._wait(LONGEST_TRIP_S, lambda: self._round_trip) or (math.inf, 0))
        return min(trips)[1]

    def close(self) -> None:
        """Leaves once the coordinator has the last answer, which no other program could send again."""
        self._ping()
        with contextlib.suppress(LinkError):
            self._wait(self._lost_after_s, lambda: self._confirmed_pieces == self._sent_pieces)
            left_ns = time.monotonic_ns()
            # A closing session drops messages that zenoh has not sent yet.
            for _ in range(FAREWELLS):
                self._sign(LEFT, time.monotonic_ns(), self._heard_ns)
                if self._wait(SOON_S, lambda: self._heard_there_ns >= left_ns):
                    break
        self._session.close()

    def _put(self, unconfirmed: List[Any]) -> None:
        self._frames.put(unconfirmed[1])
        # A message sent later arrives later, or not at all.
        unconfirmed[2] = time.monotonic_ns()

    def _lost(self) -> List[List[Any]]:
        """Pieces that were sent before a message that the coordinator received, and that it did not receive."""
        return [piece for piece in self._unconfirmed if piece[0] > self._confirmed_pieces and piece[2] <= self._heard_there_ns]

    def _next_frame(self) -> Optional[Frame]:
        if not self._arrived:
            return None
        self._taken += 1
        return self._arrived.popleft()

    def _wait(self, patience_s: float, ready: Callable[[], Any]) -> Any:
        """The result of `ready`, or `None` when the patience ends; sends pings meanwhile."""
        while True:
            with self._changed:
                found = ready()
                if self._left and not found:
                    raise LinkError("the coordinator closed the connection")
                due_s = (PAUSE_S if self._silent_s >= 0.0 else SOON_S) - self._unpinged_s
                slice_s = min(due_s, patience_s)
                lost = self._lost()
                if not found and not lost and slice_s > 0.0:
                    start = time.monotonic()
                    self._changed.wait(slice_s)
                    # If it took longer, this process was stopped and was not waiting.
                    waited_s = min(time.monotonic() - start, slice_s)
                    patience_s -= waited_s
                    self._unpinged_s += waited_s
                    self._silent_s = 0.0 if self._heard else self._silent_s + waited_s
                    self._heard = False
                    continue
            while self._unconfirmed and self._unconfirmed[0][0] <= self._confirmed_pieces:
                self._unconfirmed.popleft()
            for piece in lost:
                self._put(piece)
            if found:
                return found
            if self._silent_s >= self._lost_after_s:
                raise LinkError(f"no sign of life from the coordinator for {self._lost_after_s:.1f} s")
            if patience_s <= 0.0:
                return None
            if due_s <= 0.0:
                self._ping()

    def _ping(self) -> None:
        self._unpinged_s, self._round_trip = 0.0, None
        self._sign(PING, time.monotonic_ns(), self._heard_ns)

    def _sign(self, purpose: int, clock_ns: int, echo_ns: int) -> None:
        # The other thread may have closed the session.
        with contextlib.suppress(zenoh.ZError):
            self._signs.put(self._message(purpose, self._sent_pieces, clock_ns, echo_ns))

    def _message(self, purpose: int, number: int, clock_ns: int, echo_ns: int, *content: bytes) -> bytes:
        parts = NUMBERS.pack(purpose, number, self._received, self._taken, clock_ns, echo_ns), *content
        signature = self._ours.copy()
        for part in parts:
            signature.update(part)
        return b"".join((signature.digest(), *parts))

    def _hear(self, sample: zenoh.Sample) -> None:
        """Takes a message in zenoh's thread, and answers at once if it must."""
        now_ns = time.monotonic_ns()
        message = memoryview(sample.payload.to_bytes())
        signature = self._theirs.copy()
        signature.update(message[SIGNATURE_SIZE:])
        if len(message) < HEADER_AT or not hmac.compare_digest(signature.digest(), message[:SIGNATURE_SIZE]):
            return
        purpose, number, received, taken, clock_ns, echo_ns = NUMBERS.unpack_from(message, SIGNATURE_SIZE)
        with self._changed:
            if purpose == PING and clock_ns <= self._heard_ping_ns:
                return
            due = number == self._received + 1
            if purpose == PIECE and due:
                self._take(message)
            elif purpose == PING:
                self._heard_ping_ns = clock_ns
            elif purpose == PONG:
                self._round_trip = now_ns - echo_ns, (echo_ns + now_ns) // 2 - clock_ns
            self._left |= purpose == LEFT
            # Pieces that were sent before a pong would have arrived.
            answered = purpose in (PING, LEFT) or (purpose == PIECE and not due) or (purpose == PONG and number > self._received)
            self._heard = True
            self._heard_ns = max(self._heard_ns, clock_ns)
            self._heard_there_ns = max(self._heard_there_ns, echo_ns)
            self._confirmed_pieces = max(self._confirmed_pieces, received)
            self._taken_frames = max(self._taken_frames, taken)
            self._changed.notify()
        if answered:
            self._sign(PONG, now_ns, clock_ns)

    def _take(self, message: memoryview) -> None:
        self._received += 1
        self._arriving.append(message[PAYLOAD_AT:])
        if len(message) < PAYLOAD_AT + PIECE_SIZE:
            self._arrived.append(Frame(Header.unpack(message[HEADER_AT:PAYLOAD_AT]), b"".join(self._arriving)))
            self._arriving.clear()
