"""Frames: a header of fixed layout and a payload of doubles (protocol/WIRE.md, "Frames")."""

from __future__ import annotations

import struct
from typing import NamedTuple, Optional

import numpy as np
import xxhash

PROTOCOL_VERSION = 2

KINDS = {
    1: "Hello", 2: "Welcome", 3: "Couple", 4: "Surface", 5: "Select", 6: "Columns", 7: "Compliance",
    8: "Wall", 9: "Ready", 10: "Advance", 11: "Motion", 12: "Solve", 13: "Force", 14: "Commit",
    15: "Report", 16: "March", 17: "Finish", 18: "Finished", 19: "Fault", 20: "Snapshot", 21: "Saved",
    22: "Checkpoint", 23: "State", 24: "Restore", 25: "Restored", 26: "Resist", 27: "Impedance",
    28: "Follow", 29: "Reaction", 30: "Heat", 31: "Temperatures", 32: "Surroundings", 33: "Given",
}
NUMBERS = {word: number for number, word in KINDS.items()}

#: kind, protocol, run_id, interface, iteration, window, step, substeps, count, t0_s, t1_s, checksum.
LAYOUT = struct.Struct("<IIQIIQQIIddQ")
_WIDE = struct.Struct("<QQQQQQQQQdd")
_MASK = (1 << 64) - 1


class WireError(Exception):
    """A frame that cannot be used."""


class Header(NamedTuple):
    """The header of a frame; times in seconds."""

    kind: int = 0
    protocol: int = PROTOCOL_VERSION
    run_id: int = 0
    interface: int = 0
    iteration: int = 0
    window: int = 0
    step: int = 0
    substeps: int = 0
    count: int = 0
    t0_s: float = 0.0
    t1_s: float = 0.0
    checksum: int = 0

    def pack(self) -> bytes:
        """Its 72 bytes."""
        return LAYOUT.pack(*self)

    @staticmethod
    def unpack(data: bytes) -> Header:
        """The reverse of `pack`."""
        return Header._make(LAYOUT.unpack(data))

    def own_checksum(self) -> int:
        """XXH3 of all fields but the checksum, eight bytes each."""
        return xxhash.xxh3_64_intdigest(_WIDE.pack(*self[:-1]))


class Frame(NamedTuple):
    """A header with its payload as little-endian bytes, eight to a double."""

    header: Header
    payload: bytes

    @property
    def word(self) -> str:
        """The word for its kind."""
        return KINDS.get(self.header.kind, f"kind {self.header.kind}")

    @property
    def doubles(self) -> np.ndarray:
        """The payload as read-only numbers."""
        return np.frombuffer(self.payload, dtype="<f8")

    @property
    def data(self) -> bytes:
        """The bytes from `pack_bytes`."""
        if not self.payload:
            raise WireError(f"the text of a {self.word} frame is empty")
        length = struct.unpack_from("<d", self.payload)[0]
        held = len(self.payload) - 8
        if not 0 <= length <= held:
            raise WireError(f"a {self.word} frame claims {length} bytes and holds {held}")
        return self.payload[8 : 8 + int(length)]

    @property
    def text(self) -> str:
        """The text from `pack_bytes`."""
        return self.data.decode("utf-8")


def pack_bytes(data: bytes) -> bytes:
    """The payload for bytes: their number as a double, then the bytes, padded with zeros."""
    return struct.pack("<d", len(data)) + data + bytes(-len(data) % 8)


def stamped(header: Header, payload: bytes, turn: int) -> Header:
    """The header of a frame that goes onto a link in this turn: count and checksum filled in."""
    fields = header[:8] + (len(payload) // 8,) + header[9:11]
    own = xxhash.xxh3_64_intdigest(_WIDE.pack(*fields))
    total = xxhash.xxh3_64_intdigest(payload) + own + turn
    return Header._make(fields + (total & _MASK,))


def opened(header: Header, payload: bytes, turn: int) -> Optional[str]:
    """The fault of a frame that arrived on a link in this turn, if it has one."""
    if 8 * header.count != len(payload):
        return f"the header says {header.count} doubles, the payload holds {len(payload) // 8}"
    due = (xxhash.xxh3_64_intdigest(payload) + header.own_checksum() + turn) & _MASK
    if due == header.checksum:
        return None
    other = (header.checksum - due + turn) & _MASK
    if other < 1 << 40:
        return (
            f"message {other} of this connection arrived instead of message {turn}: one was lost, "
            "repeated or overtaken"
        )
    return "the checksum does not fit: the message was damaged"
