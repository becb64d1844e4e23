"""Fields of runs as VTK reads them, compared with `summary.json`.

check README RUN ...    steps, times, files, arrays and ranges of each run
same RUN RUN            the files of two runs, byte by byte
vtkhdf RUN RUN          the steps and arrays of the second run's VTKHDF files, bit by bit equal to the series of the first
none RUN                a run with run.output.fields = false
views FOLDER ...        pictures that are not blank
"""

import json
import math
import re
import sys
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkOutputWindow, vtkStringOutputWindow
from vtkmodules.vtkIOHDF import vtkHDFReader
from vtkmodules.vtkIOXML import vtkXMLPolyDataReader, vtkXMLUnstructuredGridReader

READERS = {".vtu": vtkXMLUnstructuredGridReader, ".vtp": vtkXMLPolyDataReader}
# Endings of the names of arrays with a unit.
UNITS = ("_m", "_m_per_s", "_rad_per_s", "_pa", "_n", "_s")
# Arrays without a unit.
DIMENSIONLESS = {"node_status", "status", "partner", "adhesion", "body", "wheel", "glued", "cluster", "coordination", "agglomerate_grains", "plastic_strain"}
# Arrays that a run must have, by part.
EXPECTED = {
    "layer": {
        "rail": {"displacement_m", "velocity_m_per_s", "hydrostatic_pressure_pa", "sigma_xx_pa", "sigma_zz_pa"},
        "third-body": {"radius_m", "displacement_since_start_m", "velocity_m_per_s", "spin_rad_per_s", "pressure_pa", "coordination"},
        "third-body-contacts": {"force_n", "gap_m", "status", "partner"},
        "layer-base-interface": {"displacement_m", "traction_pa", "pressure_pa", "shear_pa"},
    },
    "bonds": {"third-body-contacts": {"force_n", "gap_m", "status", "partner", "adhesion"}},
    "wheel": {"rail": {"node_status", "contact_pressure_pa", "contact_shear_pa"}},
    "yields": {"block": {"plastic_strain"}},
    "flow": {"third-body": {"body", "detached_s"}},
    "walls": {},
}


class Wrong(Exception):
    """A difference, with its place."""


def require(holds, text):
    if not holds:
        raise Wrong(text)


def sets(path):
    """Time, part name and file of each set in a collection; no part twice at one time."""
    found = [
        (float(s.get("timestep")), s.get("name"), path.parent / s.get("file"))
        for s in ElementTree.parse(path).getroot().iter("DataSet")
    ]
    keys = [(time, name) for time, name, _ in found]
    require(len(set(keys)) == len(keys), f"{path}: a part appears twice at one time")
    require(keys == sorted(keys, key=lambda key: key[0]), f"{path}: times are not ascending")
    return found


def read(path):
    """The dataset of a file; any complaint of VTK is an error."""
    messages = vtkStringOutputWindow()
    vtkOutputWindow.SetInstance(messages)
    reader = READERS[path.suffix]()
    reader.SetFileName(str(path))
    reader.Update()
    said = messages.GetOutput().strip()
    require(not said and reader.GetErrorCode() == 0, f"{path}: VTK says {said or reader.GetErrorCode()}")
    data = reader.GetOutput()
    require(data.GetNumberOfPoints() > 0, f"{path}: no points")
    require(all(map(math.isfinite, data.GetBounds())), f"{path}: points are not finite")
    for cell in range(data.GetNumberOfCells()):
        ids = data.GetCell(cell).GetPointIds()
        for k in range(ids.GetNumberOfIds()):
            require(0 <= ids.GetId(k) < data.GetNumberOfPoints(), f"{path}: cell {cell} names a point that does not exist")
    return data


def arrays(data):
    """All data arrays of points and cells by name."""
    both = [data.GetPointData(), data.GetCellData()]
    return {group.GetArrayName(k): group.GetArray(k) for group in both for k in range(group.GetNumberOfArrays())}


def appended(path):
    """The bytes of each array after the markup. They must follow each other without a gap: VTK does not check lengths, and
    shifted numbers may have the same range."""
    markup, raw = path.read_bytes().split(b'<AppendedData encoding="raw">\n_', 1)
    blocks, end = [], 0
    for tag in re.findall(r"<DataArray ([^>]*)>", markup.decode()):
        tag = dict(re.findall(r'(\w+)="([^"]*)"', tag))
        require(int(tag["offset"]) == end, f"{path}: {tag['Name']} has the offset {tag['offset']}, the previous array ends at {end}")
        length = int.from_bytes(raw[end : end + 8], "little")
        blocks.append((tag["Name"], raw[end + 8 : end + 8 + length]))
        end += 8 + length
    require(raw[end:].strip().startswith(b"</AppendedData>"), f"{path}: {len(raw)} bytes after the markup, its arrays have {end}")
    return blocks


def stated_ranges(path):
    """Ranges of the data arrays in the markup of a file; `None` for an empty array."""
    markup = path.read_bytes().split(b"<AppendedData")[0].decode()
    data = "".join(re.findall(r"<(?:Point|Cell)Data>(.*?)</(?:Point|Cell)Data>", markup, re.DOTALL))
    tags = [dict(re.findall(r'(\w+)="([^"]*)"', tag)) for tag in re.findall(r"<DataArray ([^>]*)>", data)]
    return {tag["Name"]: [float(tag["RangeMin"]), float(tag["RangeMax"])] if "RangeMin" in tag else None for tag in tags}


def close(a, b):
    return all(math.isclose(x, y, rel_tol=1e-14) for x, y in zip(a, b, strict=True))


def check_file(path):
    """Checks that arrays are finite and have the ranges in the file; returns their names and VTK's ranges."""
    stated = stated_ranges(path)
    seen = {}
    data = read(path)
    found, bytes_of = arrays(data), dict(appended(path))
    for name, array in [("points", data.GetPoints().GetData()), *found.items()]:
        require(vtk_to_numpy(array).tobytes() == bytes_of[name], f"{path}: VTK's bytes of {name} differ from the file")
    require(found.keys() == stated.keys(), f"{path}: VTK finds {sorted(found)} of the arrays {sorted(stated)}")
    for name, array in found.items():
        values = vtk_to_numpy(array)
        require(all(map(math.isfinite, values.ravel())), f"{path}: {name} has values that are not finite")
        known = name.endswith(UNITS) or name in DIMENSIONLESS
        require(known, f"{path}: {name} has no unit at its end")
        if array.GetNumberOfTuples() == 0:
            continue
        seen[name] = list(array.GetRange(-1 if array.GetNumberOfComponents() > 1 else 0))
        require(stated[name], f"{path}: {name} has no range")
        require(close(seen[name], stated[name]), f"{path}: {name} ranges over {seen[name]}, the file says {stated[name]}")
    return seen


def check(run, documented):
    """Checks one run."""
    fields = json.loads((run / "summary.json").read_text())["fields"]
    whole = sets(run / "fields.pvd")
    times = list(dict.fromkeys(time for time, _, _ in whole))
    require(times == fields["times_s"], f"{run}: fields.pvd has the times {times}, summary.json {fields['times_s']}")
    files = [path for _, _, path in whole]
    require(len(files) == fields["files"], f"{run}: {len(files)} files, summary.json says {fields['files']}")
    size = sum(path.stat().st_size for path in files)
    require(size == fields["bytes"], f"{run}: {size} bytes, summary.json says {fields['bytes']}")
    last, seen = {}, {}
    for time, part, path in whole:
        last[part] = check_file(path)
        seen.setdefault(part, []).append((time, path))
    for part, own in seen.items():
        listed = [(time, path) for time, _, path in sets(run / "fields" / f"{part}.pvd")]
        require(listed == own, f"{run}: {part}.pvd lists other files than fields.pvd")
    require(last.keys() == fields["last"].keys(), f"{run}: parts {sorted(last)}, summary.json has {sorted(fields['last'])}")
    for part, ranges in last.items():
        stated = fields["last"][part]
        require(ranges.keys() == stated.keys(), f"{run}: {part} has {sorted(ranges)}, summary.json {sorted(stated)}")
        for name, span in ranges.items():
            require(close(span, stated[name]), f"{run}: {part} {name} {span}, summary.json says {stated[name]}")
            require(name in documented, f"{run}: {name} is missing in the table of arrays")
    for part, names in EXPECTED.get(run.name, {}).items():
        missing = names - last.get(part, {}).keys()
        require(not missing, f"{run}: {part} lacks {sorted(missing)}")
    print(f"{run.name}: {len(times)} steps of {len(last)} parts, {len(files)} files, {size} bytes")


def same(one, other):
    """Checks that two runs have the same files with the same bytes."""
    names = [sorted(p.name for p in (run / "fields").iterdir()) for run in (one, other)]
    require(names[0] == names[1], f"{one} and {other}: only one of them has {set(names[0]) ^ set(names[1])}")
    for name in ["fields.pvd", *(f"fields/{name}" for name in names[0])]:
        require((one / name).read_bytes() == (other / name).read_bytes(), f"{name} differs in {one} and {other}")
    print(f"{one.name}, {other.name}: {len(names[0]) + 1} files, the same bytes")


def mesh(data):
    """Points and cells as arrays; polygon data have several kinds of cells."""
    found = {"points": data.GetPoints().GetData()}
    kinds = ("Verts", "Lines", "Polys", "Strips") if data.IsA("vtkPolyData") else ("Cells",)
    for kind in kinds:
        cells = getattr(data, f"Get{kind}")()
        found |= {f"{kind} connectivity": cells.GetConnectivityArray(), f"{kind} offsets": cells.GetOffsetsArray()}
    return found


def whole(data):
    """All arrays of a dataset, mesh included, as NumPy arrays."""
    found = {name: vtk_to_numpy(array) for name, array in [*mesh(data).items(), *arrays(data).items()]}
    return {**found, "types": np.array([data.GetCellType(cell) for cell in range(data.GetNumberOfCells())])}


def vtkhdf(series, gathered):
    """Checks that both have the same steps with the same points, cells, data and number types."""
    folder = gathered / "fields"
    left = [path.name for path in folder.iterdir() if path.suffix in READERS or path.suffix in (".pvd", ".part")]
    require(not left and not (gathered / "fields.pvd").exists(), f"{gathered}: {left or 'fields.pvd'} beside the files of VTKHDF")
    stated = json.loads((gathered / "summary.json").read_text())["fields"]
    paths = sorted(folder.glob("*.vtkhdf"), key=lambda path: path.stem)
    size = sum(path.stat().st_size for path in paths)
    require([len(paths), size] == [stated["files"], stated["bytes"]], f"{gathered}: {len(paths)} files of {size} bytes, summary.json says {stated['files']} of {stated['bytes']}")
    expected = {}
    for time, part, path in sets(series / "fields.pvd"):
        expected.setdefault(part, []).append((time, path))
    require(sorted(expected) == [path.stem for path in paths], f"{gathered}: parts {[path.stem for path in paths]}, the series has {sorted(expected)}")
    compared = 0
    for path in paths:
        messages = vtkStringOutputWindow()
        vtkOutputWindow.SetInstance(messages)
        reader = vtkHDFReader()
        reader.SetFileName(str(path))
        reader.UpdateInformation()
        own = expected[path.stem]
        # To VTK a single step is not temporal data.
        temporal = bool(reader.GetHasTemporalData()) == (len(own) > 1)
        require(temporal and reader.GetNumberOfSteps() == len(own), f"{path}: {reader.GetNumberOfSteps()} steps, the series has {len(own)}")
        # Also from the end to the start: a step must not depend on the step read before.
        for step in [*range(len(own)), *reversed(range(len(own)))]:
            time, xml = own[step]
            reader.SetStep(step)
            reader.Update()
            require(len(own) == 1 or reader.GetTimeValue() == time, f"{path}: step {step} is at {reader.GetTimeValue()}, {xml.name} at {time}")
            ours, theirs = whole(read(xml)), whole(reader.GetOutput())
            require(ours.keys() == theirs.keys(), f"{path}, step {step}: {sorted(theirs)}, {xml.name} has {sorted(ours)}")
            for name, values in ours.items():
                other = theirs[name]
                alike = (values.dtype, values.shape) == (other.dtype, other.shape)
                # Cells of one kind may be counted in fewer bits; their numbers are integers.
                alike = alike or " " in name and values.shape == other.shape
                require(alike, f"{path}, step {step}: {name} is {other.dtype} {other.shape}, in {xml.name} {values.dtype} {values.shape}")
                bits = values.tobytes() == other.astype(values.dtype).tobytes()
                require(bits, f"{path}, step {step}: {name} differs from {xml.name}")
                compared += 1
        said = messages.GetOutput().strip()
        require(not said and reader.GetErrorCode() == 0, f"{path}: VTK says {said or reader.GetErrorCode()}")
    before = json.loads((series / "summary.json").read_text())["fields"]
    print(f"{gathered.name}: {compared} arrays as in {before['files']} files of {before['bytes']} bytes, in {len(paths)} of {size}")


def none(run):
    """Checks that a run has no field files and does not mention any."""
    left = list((run / "fields").iterdir()) + list(run.glob("*.pvd"))
    require(not left, f"{run}: {left} with run.output.fields = false")
    require("fields" not in json.loads((run / "summary.json").read_text()), f"{run}: summary.json mentions fields")
    print(f"{run.name}: no fields")


def views(folder):
    """Checks that pictures have more than a background."""
    from vtkmodules.vtkIOImage import vtkPNGReader

    pictures = sorted(folder.glob("*.png"))
    require(len(pictures) >= 2, f"{folder}: {len(pictures)} pictures")
    for picture in pictures:
        reader = vtkPNGReader()
        reader.SetFileName(str(picture))
        reader.Update()
        colours = {tuple(pixel) for pixel in vtk_to_numpy(reader.GetOutput().GetPointData().GetScalars())[::7]}
        require(len(colours) > 50, f"{picture}: {len(colours)} colours, so nothing is drawn")
    print(f"{folder.name}: {', '.join(picture.stem for picture in pictures)}")


def main(verb, *words):
    paths = [Path(word) for word in words]
    if verb == "check":
        section = paths[0].read_text().split("\n## Fields\n")[1].split("\n## ")[0]
        documented = set(re.findall(r"`(\w+)`", section))
        for run in paths[1:]:
            check(run, documented)
    elif verb in ("same", "vtkhdf"):
        {"same": same, "vtkhdf": vtkhdf}[verb](*paths)
    else:
        for path in paths:
            {"none": none, "views": views}[verb](path)


try:
    main(*sys.argv[1:])
except Wrong as wrong:
    sys.exit(f"tests/vtk/check: {wrong}")
