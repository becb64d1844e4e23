"""States as plain data: frozen, as bytes, and as a hash.

A state may hold numbers, texts, bytes, numpy arrays, and lists, tuples and dictionaries of them. Its bytes are only data: reading
a checkpoint runs no code from it.
"""

from __future__ import annotations

import hashlib
import math
import struct
from typing import Any, List, Tuple

import numpy as np

from .errors import ConfigurationError


def freeze(state: Any) -> Any:
    """Makes every array of a state read-only, so that a step that forgets to copy fails at that line."""
    if isinstance(state, np.ndarray):
        state.flags.writeable = False
    elif isinstance(state, dict):
        for value in state.values():
            freeze(value)
    elif isinstance(state, (list, tuple)):
        for value in state:
            freeze(value)
    return state


def all_finite(numbers: np.ndarray) -> bool:
    """True if all numbers are finite; a finite sum shows it at once."""
    return math.isfinite(np.add.reduce(numbers)) or bool(np.isfinite(numbers).all())


def to_bytes(state: Any) -> bytes:
    """A state as bytes, the same for equal states."""
    parts: List[bytes] = []
    _write(state, parts, "state")
    return b"".join(parts)


def from_bytes(data: bytes) -> Any:
    """The reverse of `to_bytes`; its arrays are read-only."""
    try:
        state, end = _read(memoryview(data), 0)
    except (struct.error, IndexError, ValueError, UnicodeDecodeError) as error:
        raise ConfigurationError(f"the checkpoint of this participant is damaged: {error}") from error
    if end != len(data):
        raise ConfigurationError("the checkpoint of this participant is damaged: it is too long")
    return state


def digest(state: Any) -> str:
    """A hash of every number of a state, 64 hexadecimal digits."""
    return hashlib.blake2b(to_bytes(state), digest_size=32).hexdigest()


def _block(parts: List[bytes], tag: bytes, data: bytes) -> None:
    parts.append(tag + struct.pack("<Q", len(data)))
    parts.append(data)


def _write(value: Any, parts: List[bytes], place: str) -> None:
    if value is None or isinstance(value, (bool, np.bool_)):
        parts.append(b"n" if value is None else b"t" if value else b"f")
    elif isinstance(value, (int, np.integer)):
        _block(parts, b"i", str(int(value)).encode())
    elif isinstance(value, (float, np.floating)):
        parts.append(b"d" + struct.pack("<d", float(value)))
    elif isinstance(value, str):
        _block(parts, b"s", value.encode())
    elif isinstance(value, (bytes, bytearray)):
        _block(parts, b"b", bytes(value))
    elif isinstance(value, np.ndarray) and value.dtype.kind in "fiub":
        kind = value.dtype.newbyteorder("<")
        _block(parts, b"a", kind.str.encode())
        parts.append(struct.pack("<Q", value.ndim) + struct.pack(f"<{value.ndim}Q", *value.shape))
        parts.append(np.ascontiguousarray(value, dtype=kind).tobytes())
    elif isinstance(value, (list, tuple)):
        parts.append((b"l" if isinstance(value, list) else b"u") + struct.pack("<Q", len(value)))
        for index, item in enumerate(value):
            _write(item, parts, f"{place}[{index}]")
    elif isinstance(value, dict) and all(isinstance(key, str) for key in value):
        parts.append(b"m" + struct.pack("<Q", len(value)))
        for key in sorted(value):
            _block(parts, b"s", key.encode())
            _write(value[key], parts, f"{place}.{key}")
    else:
        raise ConfigurationError(
            f"{place} is a {type(value).__name__}: a state may hold numbers, texts, bytes, arrays of numbers, and lists, "
            "tuples and dictionaries of them"
        )


def _read_block(data: memoryview, at: int) -> Tuple[bytes, int]:
    (length,) = struct.unpack_from("<Q", data, at)
    end = at + 8 + length
    if end > len(data):
        raise ValueError("it is too short")
    return bytes(data[at + 8 : end]), end


def _read(data: memoryview, at: int) -> Tuple[Any, int]:
    tag = bytes(data[at : at + 1])
    at += 1
    if tag in (b"n", b"t", b"f"):
        return {b"n": None, b"t": True, b"f": False}[tag], at
    if tag == b"d":
        return struct.unpack_from("<d", data, at)[0], at + 8
    if tag in (b"i", b"s", b"b"):
        block, at = _read_block(data, at)
        return (int(block) if tag == b"i" else block.decode() if tag == b"s" else block), at
    if tag == b"a":
        kind, at = _read_block(data, at)
        (axes,) = struct.unpack_from("<Q", data, at)
        shape = struct.unpack_from(f"<{axes}Q", data, at + 8)
        at += 8 + 8 * axes
        dtype = np.dtype(kind.decode())
        count = int(np.prod(shape, dtype=np.uint64))
        array = np.frombuffer(data, dtype, count, at).reshape(shape)
        return array, at + count * dtype.itemsize
    if tag in (b"l", b"u", b"m"):
        (length,) = struct.unpack_from("<Q", data, at)
        at += 8
        items = []
        for _ in range(length):
            key = None
            if tag == b"m":
                key, at = _read(data, at)
            item, at = _read(data, at)
            items.append((key, item))
        if tag == b"m":
            return dict(items), at
        values = [item for _, item in items]
        return (values if tag == b"l" else tuple(values)), at
    raise ValueError(f"unknown part {tag!r} at byte {at - 1}")
