"""Fields of a participant from fields/*.vtu (bodies) and *.vtp (grains), read with only NumPy.

Data arrays in these VTK XML files have two forms: text between their tags (`format="ascii"`), or bytes after the `_` of
`<AppendedData encoding="raw">`, each array after its length.
"""

from __future__ import annotations

import re
import xml.etree.ElementTree as ElementTree
from pathlib import Path
from typing import Dict, Iterator, List, NamedTuple, Optional, Union

import numpy as np

_TYPES = {f"{kind}{8 * size}": np.dtype(f"<{letter}{size}")
          for kind, letter, sizes in (("Float", "f", (4, 8)), ("Int", "i", (1, 2, 4, 8)), ("UInt", "u", (1, 2, 4, 8)))
          for size in sizes}
_APPENDED = re.compile(rb"<AppendedData[^>]*>")


class Field(Dict[str, np.ndarray]):
    """The arrays of one moment by name, unit in the name, one row per point or cell.

    A body has `points_m` (n x 2, undeformed), `quads` (m x 4, indices of points), arrays of points such as `displacement_m` (n x 2)
    and of elements such as `hydrostatic_pressure_pa` (m). Grains have `points_m` (centres), `radius_m`, `velocity_m_per_s` and others
    per grain, `contacts` (c x 2, indices of grains) with `force_n` (c x 2: normal, tangential), `gap_m`, `status` (1 stick, 2 slip, 3
    bonded) and, for bonds, `adhesion`. Contacts of grains with other bodies have the same arrays with the prefix `face_`: `face_grain`
    (f), `face_partner` (f: `wheel`, `wall` or `surface`), `face_point_m` (f x 2, the contact points), `face_force_n`, `face_gap_m` etc.
    """

    def __init__(self, path: Path, time_s: float) -> None:
        super().__init__(read_vtk(path))
        contacts = path.with_name(f"{path.stem}-contacts.vtp")
        if path.suffix == ".vtp" and contacts.is_file():
            self.update(_contacts(read_vtk(contacts), len(self["points_m"])))
        #: The file.
        self.path = path
        #: Its time (s).
        self.time_s = time_s

    def __missing__(self, name: str) -> np.ndarray:
        raise KeyError(f"{self.path} has no array `{name}`; arrays: {', '.join(self)}")


class Moment(NamedTuple):
    """One moment at which a participant wrote its fields."""

    #: Its name in the files: `hold`, `cycling-1`.
    name: str
    #: Its time (s).
    time_s: float
    #: The file.
    path: Path


class Fields:
    """The moments at which a participant wrote its fields, in order of time. Each is read on first use."""

    def __init__(self, run: Path, participant: str) -> None:
        folder = run / "fields"
        listed = folder / f"{participant}.pvd"
        self.participant = participant
        if not listed.is_file():
            known = sorted(path.stem for path in folder.glob("*.pvd"))
            if (folder / f"{participant}.vtkhdf").is_file():
                hint = f"{participant}.vtkhdf beside it has these fields: h5py or VTK reads it; this package reads run.output.fields_format = \"vtk-xml\""
                raise FileNotFoundError(f"{listed} is missing; {hint}")
            hint = f"participants with fields: {', '.join(known)}" if known else "no participant wrote fields: the run ended before its first moment"
            raise FileNotFoundError(f"{listed} is missing; {hint}")
        tree = _parse(listed, listed.read_bytes())
        #: Name, time and file of each moment.
        self.moments: List[Moment] = [
            Moment(Path(one.attrib["file"]).stem[len(participant) + 1 :], float(one.attrib["timestep"]), folder / one.attrib["file"])
            for one in tree.iter("DataSet")
        ]

    @property
    def t_s(self) -> np.ndarray:
        """Their times (s)."""
        return np.array([moment.time_s for moment in self.moments])

    @property
    def names(self) -> List[str]:
        """Their names."""
        return [moment.name for moment in self.moments]

    def __len__(self) -> int:
        return len(self.moments)

    def __iter__(self) -> Iterator[Field]:
        return (self[place] for place in range(len(self)))

    def __getitem__(self, which: Union[int, str]) -> Field:
        """The arrays of a moment by its index or its name."""
        if isinstance(which, str):
            if which not in self.names:
                raise KeyError(f"no moment `{which}` of `{self.participant}`; moments: {', '.join(self.names)}")
            which = self.names.index(which)
        moment = self.moments[which]
        return Field(moment.path, moment.time_s)

    def nearest(self, t_s: float) -> Field:
        """The arrays of the moment nearest to a time (s); its `time_s` is the exact one."""
        return self[int(np.argmin(np.abs(self.t_s - t_s)))]

    def __repr__(self) -> str:
        return f"Fields({self.participant!r}: {', '.join(self.names)})"


#: Partners of grains by their numbers in a file.
_PARTNERS = np.array(["grain", "wheel", "wall", "surface"])


def _contacts(arrays: Dict[str, np.ndarray], grains: int) -> Dict[str, np.ndarray]:
    """The contacts in a file and their data: between grains, and with other bodies."""
    contacts = arrays.pop("contacts", np.zeros((0, 2), dtype=np.int64))
    points, partner = arrays.pop("points_m"), arrays.pop("partner", np.zeros(len(contacts), dtype=np.uint8))
    both = (contacts < grains).all(axis=1)
    faces = {f"face_{name}": values[~both] for name, values in arrays.items()}
    faces["face_grain"], faces["face_point_m"] = contacts[~both, 0], points[contacts[~both, 1]]
    faces["face_partner"] = _PARTNERS[partner[~both]]
    return {"contacts": contacts[both], **{name: values[both] for name, values in arrays.items()}, **faces}


def read_vtk(path: Path) -> Dict[str, np.ndarray]:
    """The arrays of a .vtu or .vtp file, by the names in `Field`."""
    data = path.read_bytes()
    text, appended = data, None
    found = _APPENDED.search(data)
    if found:
        if b'encoding="raw"' not in found.group():
            raise ValueError(f"{path}: its appended data are not raw; this reads ASCII and raw appended data")
        start = data.find(b"_", found.end())
        if start < 0:
            raise ValueError(f"{path}: its appended data are missing: the file was cut off")
        text, appended = data[: found.start()] + b"</VTKFile>", memoryview(data)[start + 1 :]
    root = _parse(path, text)
    if "compressor" in root.attrib or root.get("byte_order", "LittleEndian") != "LittleEndian":
        raise ValueError(f"{path}: it is compressed or big-endian; this reads plain little-endian data")
    piece = root.find("*/Piece")
    if piece is None:
        raise ValueError(f"{path}: it holds no piece of a mesh or of grains")
    reader = _Reader(path, appended, _TYPES[root.get("header_type", "UInt32")])
    return _arrays(piece, reader)


def _arrays(piece: ElementTree.Element, reader: _Reader) -> Dict[str, np.ndarray]:
    parts = {part.tag: {one.get("Name", ""): reader.array(one) for one in part} for part in piece}
    points = next(iter(parts["Points"].values()))
    arrays = {"points_m": points[:, :2]}
    vertices = 0
    if "Cells" in parts:
        arrays["quads"] = parts["Cells"]["connectivity"].reshape(-1, 4)
    if "Lines" in parts:
        arrays["contacts"] = parts["Lines"]["connectivity"].reshape(-1, 2)
        # Cells of vertices come before cells of lines.
        vertices = len(parts.get("Verts", {}).get("offsets", ()))
    for name, values in parts.get("PointData", {}).items():
        arrays[name] = values[:, :2] if values.ndim == 2 and values.shape[1] == 3 else values
    for name, values in parts.get("CellData", {}).items():
        arrays[name] = values[vertices:]
    return arrays


class _Reader:
    """Data arrays of a file, in either form."""

    def __init__(self, path: Path, appended: Optional[memoryview], header: np.dtype) -> None:
        self.path = path
        self.appended = appended
        self.header = header

    def array(self, element: ElementTree.Element) -> np.ndarray:
        """The numbers of a data array, n x components."""
        name, kind = element.get("Name"), element.get("type", "")
        if kind not in _TYPES:
            raise ValueError(f"{self.path}, array `{name}`: numbers of type `{kind}` are unknown")
        form = element.get("format")
        if form == "ascii":
            values = self._text(element, _TYPES[kind])
        elif form == "appended":
            values = self._bytes(element, _TYPES[kind])
        else:
            raise ValueError(f"{self.path}, array `{name}`: its format is `{form}`; this reads `ascii` and `appended`")
        components = int(element.get("NumberOfComponents", "1"))
        if len(values) % components:
            raise ValueError(f"{self.path}, array `{name}`: {len(values)} numbers do not make rows of {components}: the file is damaged")
        return values.reshape(-1, components) if components > 1 else values

    def _text(self, element: ElementTree.Element, kind: np.dtype) -> np.ndarray:
        words = (element.text or "").split()
        try:
            return np.array(words, dtype=kind) if kind.kind != "f" else np.array([float(word) for word in words], dtype=kind)
        except ValueError as error:
            raise ValueError(f"{self.path}, array `{element.get('Name')}` is not ASCII numbers: {error}") from error

    def _bytes(self, element: ElementTree.Element, kind: np.dtype) -> np.ndarray:
        offset, name = int(element.get("offset", "0")), element.get("Name")
        left = b"" if self.appended is None else self.appended[offset:]
        start = self.header.itemsize
        due = int(np.frombuffer(left[:start], dtype=self.header)[0]) if len(left) >= start else 0
        if len(left) < start + due or due % kind.itemsize:
            held = max(len(left) - start, 0)
            raise ValueError(
                f"{self.path}, array `{name}` at offset {offset}: {held} bytes instead of {due}: the file was cut off; run the scenario again"
            )
        return np.frombuffer(left[start : start + due], dtype=kind)


def _parse(path: Path, text: bytes) -> ElementTree.Element:
    # The tags before the appended data are still open: their closing tags were cut off with the data.
    try:
        return ElementTree.fromstring(text)
    except ElementTree.ParseError as error:
        raise ValueError(f"{path} cannot be read: {error}; the run was killed while it wrote it, or the file is damaged") from error
