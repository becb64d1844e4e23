"""The exchange at an interface, window by window, from exchange.mcap.

The file is read with the `mcap` wheel if it is installed (`pip install mcap`; this needs nothing else and writes nothing),
otherwise through `thirdbody export`, which needs the program.
"""

from __future__ import annotations

import csv
import struct
import subprocess
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Dict, Iterator, List, NamedTuple, Optional, Sequence, Tuple, Union

import numpy as np

from .program import find_program

_COUPLER = "coupler"
_WANTED = {"Surface", "Select", "Advance", "Motion", "Solve", "Force", "Commit", "Follow", "Reaction"}


class Message(NamedTuple):
    """A message of the log."""

    kind: str
    sender: str
    receiver: str
    interfaces: List[str]
    window: int
    iteration: int
    t0_s: float
    t1_s: float
    numbers: np.ndarray


@dataclass
class Side:
    """A participant at an interface: arrays of windows x points x 2 (x, y), of the last repeat of each accepted window."""

    #: Its name.
    participant: str
    #: Undeformed positions of its points (m).
    points_m: np.ndarray
    #: Displacement since the start, at the end of the window (m).
    displacement_m: np.ndarray
    #: A layer's velocity at the end of the window, or a continuum's mean velocity over the window (m/s).
    velocity_m_per_s: np.ndarray
    #: The force on a continuum, or the force that a layer exerts (N).
    force_n: np.ndarray


class Interface:
    """The exchange at an interface. `sides[participant]` has the arrays, one row per window."""

    def __init__(self, name: str, windows: Sequence[Message], sides: Dict[str, Side], damage: Optional[str]) -> None:
        #: Its name in the scenario.
        self.name = name
        #: Numbers of the windows.
        self.window = np.array([one.window for one in windows], dtype=int)
        #: Start of each window (s).
        self.t0_s = np.array([one.t0_s for one in windows])
        #: End of each window (s).
        self.t_s = np.array([one.t1_s for one in windows])
        #: The participants.
        self.sides = sides
        #: Why the log ends early, if it does.
        self.damage = damage

    def __getitem__(self, participant: str) -> Side:
        if participant not in self.sides:
            raise KeyError(f"interface `{self.name}` joins {' and '.join(self.sides)}, not `{participant}`")
        return self.sides[participant]

    def __repr__(self) -> str:
        sides = ", ".join(f"{side.participant} {len(side.points_m)} points" for side in self.sides.values())
        return f"Interface({self.name!r}: {len(self.window)} windows; {sides})"


def read_interface(log: Path, name: str, between: Sequence[str], program: Optional[str] = None) -> Interface:
    """Reads one interface of a log; `between` are its participants."""
    streams: Dict[str, List[Message]] = {participant: [] for participant in between}
    damage = None
    for message in messages(log, program):
        if isinstance(message, str):
            damage = message
            continue
        participant = message.receiver if message.sender == _COUPLER else message.sender
        if name in message.interfaces and participant in streams:
            streams[participant].append(message)
    parts = {participant: _Stream(participant, name, stream) for participant, stream in streams.items()}
    accepted = [set(part.accepted) for part in parts.values()]
    common = sorted(set.intersection(*accepted)) if accepted else []
    windows = [next(iter(parts.values())).accepted[window] for window in common]
    return Interface(name, windows, {key: part.side(common) for key, part in parts.items()}, damage)


class _Stream:
    """The requests to one participant of an interface, and its answers."""

    def __init__(self, participant: str, interface: str, stream: List[Message]) -> None:
        self.participant = participant
        self.answers: Dict[int, Dict[str, np.ndarray]] = {}
        #: The message that accepted each window.
        self.accepted: Dict[int, Message] = {}
        surfaces: List[np.ndarray] = []
        selected: Optional[np.ndarray] = None
        for message in stream:
            if message.kind == "Surface":
                surfaces.append(message.numbers.reshape(-1, 5)[:, :2])
            elif message.kind == "Select":
                selected = message.numbers.astype(int)
            elif message.kind == "Commit":
                self.answers.setdefault(message.window, {})["Commit"] = message.numbers
                self.accepted[message.window] = message
            elif message.window not in self.accepted:
                self.answers.setdefault(message.window, {})[message.kind] = message.numbers
        points = np.concatenate(surfaces) if surfaces else np.zeros((0, 2))
        chosen = np.arange(len(points)) if selected is None else selected
        #: Exchanged points of all interfaces of the participant, and which of them belong to this interface.
        self.exchanged = len(chosen)
        self.own = np.ones(len(chosen), dtype=bool)
        names = next((one.interfaces for one in stream), [interface])
        if len(names) == len(surfaces):
            place = names.index(interface)
            first = sum(len(one) for one in surfaces[:place])
            self.own = (chosen >= first) & (chosen < first + len(surfaces[place]))
        self.points = points[chosen][self.own]

    def side(self, windows: Sequence[int]) -> Side:
        """The arrays for these windows."""
        count = len(self.points)
        force, velocity, displacement = (np.full((len(windows), count, 2), np.nan) for _ in range(3))
        total = np.zeros((count, 2))
        for place, window in enumerate(windows):
            accepted = self.accepted[window]
            span_s = accepted.t1_s - accepted.t0_s
            rows = {kind: self._rows(numbers) for kind, numbers in self.answers[window].items()}
            if "Force" in rows:
                force[place], velocity[place] = rows["Force"][:2]
                increment = span_s * velocity[place]
            elif "Reaction" in rows:
                force[place], increment = rows["Reaction"][:2]
                velocity[place] = increment / span_s
            else:
                force[place], increment = rows["Advance"][0], rows["Motion"][0]
                velocity[place] = increment / span_s
            held = rows["Commit"]
            total = held[0] if len(held) else total + increment
            displacement[place] = total
        return Side(self.participant, self.points, displacement, velocity, force)

    def _rows(self, numbers: np.ndarray) -> np.ndarray:
        """Vectors (k x points x 2) at the points of this interface, without the scalars that follow."""
        length = 2 * self.exchanged
        count = numbers.size // length if length else 0
        return numbers[: count * length].reshape(count, self.exchanged, 2)[:, self.own]


def messages(log: Path, program: Optional[str] = None) -> Iterator[Union[Message, str]]:
    """The messages of a log in order; the last item is a text if the log ends early."""
    try:
        from mcap.reader import make_reader  # noqa: F401
    except ImportError:
        yield from _exported(log, program)
        return
    yield from _read(log)


def _read(log: Path) -> Iterator[Union[Message, str]]:
    from mcap.exceptions import McapError
    from mcap.stream_reader import StreamReader

    channels: Dict[int, Tuple[str, List[str]]] = {}
    with open(log, "rb") as file:
        try:
            for record in StreamReader(file, validate_crcs=True).records:
                kind = type(record).__name__
                if kind == "Channel":
                    channels[record.id] = (record.topic.rpartition("/")[2], record.metadata.get("interface", "").split("+"))
                elif kind == "Message" and channels[record.channel_id][0] in _WANTED:
                    yield _decoded(*channels[record.channel_id], record.data)
        except (McapError, struct.error, RuntimeError, EOFError) as error:
            yield f"{log} ends early ({error}): it was cut off or is damaged; `thirdbody inspect` shows where"


def _decoded(kind: str, interfaces: List[str], data: bytes) -> Message:
    """A message thirdbody.Exchange in protobuf; the log contains its description."""
    fields: Dict[int, Any] = {}
    at = 0
    while at < len(data):
        key, at = _varint(data, at)
        number, wire = key >> 3, key & 7
        if wire == 0:
            fields[number], at = _varint(data, at)
        elif wire == 1:
            fields[number], at = struct.unpack_from("<d", data, at)[0], at + 8
        else:
            length, at = _varint(data, at)
            fields[number], at = data[at : at + length], at + length
    numbers = np.frombuffer(fields.get(12, b""), dtype="<f8")
    sender, receiver = (fields.get(number, b"").decode("utf-8") for number in (10, 11))
    window, iteration = fields.get(5, 0), fields.get(4, 0)
    return Message(kind, sender, receiver, interfaces, window, iteration, fields.get(8, 0.0), fields.get(9, 0.0), numbers)


def _varint(data: bytes, at: int) -> Tuple[int, int]:
    value = shift = 0
    while True:
        byte = data[at]
        value |= (byte & 0x7F) << shift
        at, shift = at + 1, shift + 7
        if byte < 0x80:
            return value, at


def _exported(log: Path, program: Optional[str]) -> Iterator[Union[Message, str]]:
    program = find_program(program)
    if program is None:
        raise ImportError(f"to read {log}: pip install mcap, or put the program `thirdbody` on PATH or into THIRDBODY")
    with tempfile.TemporaryDirectory() as folder:
        command = [program, "export", str(log), "--recover", "--out", folder]
        done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, encoding="utf-8", errors="replace")
        if done.returncode:
            raise ValueError(f"{log} cannot be exported: {done.stderr.strip()}")
        found = [one for path in sorted(Path(folder).glob("*.csv")) for one in _rows(path)]
        # One file per stream: a request comes before its answer, and both before the `Commit` of the window.
        order = {kind: place for place, kind in enumerate(("Surface", "Select", "Advance", "Solve", "Follow", "Motion", "Force", "Reaction", "Commit"))}
        found.sort(key=lambda one: (one.window, one.kind == "Commit", one.iteration, order[one.kind]))
        yield from found
        if "ends early" in done.stderr:
            yield done.stderr.strip()


def _rows(path: Path) -> Iterator[Message]:
    interface, sender, receiver, kind = path.stem.rsplit(".", 3)
    if kind not in _WANTED:
        return
    with open(path, newline="", encoding="utf-8") as file:
        rows = csv.reader(file)
        next(rows)
        for row in rows:
            numbers = np.array([float(value) for value in row[6:]])
            yield Message(kind, sender, receiver, interface.split("+"), int(row[0]), int(row[1]), float(row[4]), float(row[5]), numbers)
