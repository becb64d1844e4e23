"""Fields of runs as VTK reads them, against what `summary.json` tells.

check README RUN ...    steps, times, files, arrays and ranges of each run
same RUN RUN            the files of two runs, byte by byte
vtkhdf RUN RUN          the steps and arrays of the files of VTKHDF of the second run, bit by bit those of the series of the first
none RUN                a run that was told to write none
views FOLDER ...        pictures that show something
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
# Ends of the names of arrays that have a unit.
UNITS = ("_m", "_m_per_s", "_rad_per_s", "_pa", "_n", "_s")
# Arrays without one.
DIMENSIONLESS = {"node_status", "status", "partner", "adhesion", "body", "wheel", "glued", "cluster", "coordination", "agglomerate_grains", "plastic_strain"}
# Arrays that a run must have, by the part.
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
    """A departure, with its place."""


def require(holds, text):
    if not holds:
        raise Wrong(text)


def sets(path):
    """Time, name of the part and file of each set of a collection; no part twice at a time."""
    found = [
        (float(s.get("timestep")), s.get("name"), path.parent / s.get("file"))
        for s in ElementTree.parse(path).getroot().iter("DataSet")
    ]
    keys = [(time, name) for time, name, _ in found]
    require(len(set(keys)) == len(keys), f"{path}: a part stands twice at a time")
    require(keys == sorted(keys, key=lambda key: key[0]), f"{path}: times do not rise")
    return found


def read(path):
    """The dataset of a file; whatever VTK complains about is an error."""
    messages = vtkStringOutputWindow()
    vtkOutputWindow.SetInstance(messages)
    reader = READERS[path.suffix]()
    reader.SetFileName(str(path))
    reader.Update()
    said = messages.GetOutput().strip()
    require(not said and reader.GetErrorCode() == 0, f"{path}: VTK says {said or reader.GetErrorCode()}")
    data = reader.GetOutput()
    require(data.GetNumberOfPoints() > 0, f"{path}: no points")
    require(all(map(math.isfinite, data.GetBounds())), f"{path}: points are no numbers")
    for cell in range(data.GetNumberOfCells()):
        ids = data.GetCell(cell).GetPointIds()
        for k in range(ids.GetNumberOfIds()):
            require(0 <= ids.GetId(k) < data.GetNumberOfPoints(), f"{path}: cell {cell} names a point that is none")
    return data


def arrays(data):
    """All data arrays of points and cells by name."""
    both = [data.GetPointData(), data.GetCellData()]
    return {group.GetArrayName(k): group.GetArray(k) for group in both for k in range(group.GetNumberOfArrays())}


def appended(path):
    """The bytes of each array behind the markup, which must follow each other without a gap: VTK does not look at lengths, and
    shifted numbers may well have the same range."""
    markup, raw = path.read_bytes().split(b'<AppendedData encoding="raw">\n_', 1)
    blocks, end = [], 0
    for tag in re.findall(r"<DataArray ([^>]*)>", markup.decode()):
        tag = dict(re.findall(r'(\w+)="([^"]*)"', tag))
        require(int(tag["offset"]) == end, f"{path}: {tag['Name']} has the offset {tag['offset']}, the array before ends at {end}")
        length = int.from_bytes(raw[end : end + 8], "little")
        blocks.append((tag["Name"], raw[end + 8 : end + 8 + length]))
        end += 8 + length
    require(raw[end:].strip().startswith(b"</AppendedData>"), f"{path}: {len(raw)} bytes behind the markup, its arrays have {end}")
    return blocks


def ranges_told(path):
    """Ranges of the data arrays in the markup of a file; none of an empty one."""
    markup = path.read_bytes().split(b"<AppendedData")[0].decode()
    data = "".join(re.findall(r"<(?:Point|Cell)Data>(.*?)</(?:Point|Cell)Data>", markup, re.DOTALL))
    tags = [dict(re.findall(r'(\w+)="([^"]*)"', tag)) for tag in re.findall(r"<DataArray ([^>]*)>", data)]
    return {tag["Name"]: [float(tag["RangeMin"]), float(tag["RangeMax"])] if "RangeMin" in tag else None for tag in tags}


def close(a, b):
    return all(math.isclose(x, y, rel_tol=1e-14) for x, y in zip(a, b, strict=True))


def check_file(path):
    """Finite arrays with the ranges that the file tells; their names and VTK's ranges."""
    told = ranges_told(path)
    seen = {}
    data = read(path)
    found, bytes_of = arrays(data), dict(appended(path))
    for name, array in [("points", data.GetPoints().GetData()), *found.items()]:
        require(vtk_to_numpy(array).tobytes() == bytes_of[name], f"{path}: VTK reads other bytes as {name} than the file holds")
    require(found.keys() == told.keys(), f"{path}: VTK finds {sorted(found)} of the arrays {sorted(told)}")
    for name, array in found.items():
        values = vtk_to_numpy(array)
        require(all(map(math.isfinite, values.ravel())), f"{path}: {name} has values that are no numbers")
        known = name.endswith(UNITS) or name in DIMENSIONLESS
        require(known, f"{path}: {name} has no unit at its end")
        if array.GetNumberOfTuples() == 0:
            continue
        seen[name] = list(array.GetRange(-1 if array.GetNumberOfComponents() > 1 else 0))
        require(told[name], f"{path}: {name} comes without a range")
        require(close(seen[name], told[name]), f"{path}: {name} ranges over {seen[name]}, its author says {told[name]}")
    return seen


def check(run, documented):
    """One run."""
    fields = json.loads((run / "summary.json").read_text())["fields"]
    whole = sets(run / "fields.pvd")
    times = list(dict.fromkeys(time for time, _, _ in whole))
    require(times == fields["times_s"], f"{run}: fields.pvd has the times {times}, summary.json {fields['times_s']}")
    files = [path for _, _, path in whole]
    require(len(files) == fields["files"], f"{run}: {len(files)} files, summary.json tells {fields['files']}")
    size = sum(path.stat().st_size for path in files)
    require(size == fields["bytes"], f"{run}: {size} bytes, summary.json tells {fields['bytes']}")
    last, seen = {}, {}
    for time, part, path in whole:
        last[part] = check_file(path)
        seen.setdefault(part, []).append((time, path))
    for part, own in seen.items():
        listed = [(time, path) for time, _, path in sets(run / "fields" / f"{part}.pvd")]
        require(listed == own, f"{run}: {part}.pvd lists other files than fields.pvd")
    require(last.keys() == fields["last"].keys(), f"{run}: parts {sorted(last)}, summary.json has {sorted(fields['last'])}")
    for part, ranges in last.items():
        told = fields["last"][part]
        require(ranges.keys() == told.keys(), f"{run}: {part} has {sorted(ranges)}, summary.json {sorted(told)}")
        for name, span in ranges.items():
            require(close(span, told[name]), f"{run}: {part} {name} {span}, summary.json tells {told[name]}")
            require(name in documented, f"{run}: {name} does not stand in the table of arrays")
    for part, names in EXPECTED.get(run.name, {}).items():
        missing = names - last.get(part, {}).keys()
        require(not missing, f"{run}: {part} lacks {sorted(missing)}")
    print(f"{run.name}: {len(times)} steps of {len(last)} parts, {len(files)} files, {size} bytes")


def same(one, other):
    """The same files with the same bytes, but for what names the run."""
    names = [sorted(p.name for p in (run / "fields").iterdir()) for run in (one, other)]
    require(names[0] == names[1], f"{one} and {other}: {set(names[0]) ^ set(names[1])} is in one of them only")
    for name in ["fields.pvd", *(f"fields/{name}" for name in names[0])]:
        require((one / name).read_bytes() == (other / name).read_bytes(), f"{name} differs in {one} and {other}")
    print(f"{one.name}, {other.name}: {len(names[0]) + 1} files, the same bytes")


def mesh(data):
    """Points and cells as arrays: of polygons all kinds of cells."""
    found = {"points": data.GetPoints().GetData()}
    kinds = ("Verts", "Lines", "Polys", "Strips") if data.IsA("vtkPolyData") else ("Cells",)
    for kind in kinds:
        cells = getattr(data, f"Get{kind}")()
        found |= {f"{kind} connectivity": cells.GetConnectivityArray(), f"{kind} offsets": cells.GetOffsetsArray()}
    return found


def whole(data):
    """All arrays of a dataset, mesh included, as NumPy has them."""
    found = {name: vtk_to_numpy(array) for name, array in [*mesh(data).items(), *arrays(data).items()]}
    return {**found, "types": np.array([data.GetCellType(cell) for cell in range(data.GetNumberOfCells())])}


def vtkhdf(series, gathered):
    """The same steps with the same points, cells and data, types of their numbers included."""
    folder = gathered / "fields"
    left = [path.name for path in folder.iterdir() if path.suffix in READERS or path.suffix in (".pvd", ".part")]
    require(not left and not (gathered / "fields.pvd").exists(), f"{gathered}: {left or 'fields.pvd'} beside the files of VTKHDF")
    told = json.loads((gathered / "summary.json").read_text())["fields"]
    paths = sorted(folder.glob("*.vtkhdf"), key=lambda path: path.stem)
    size = sum(path.stat().st_size for path in paths)
    require([len(paths), size] == [told["files"], told["bytes"]], f"{gathered}: {len(paths)} files of {size} bytes, summary.json tells {told['files']} of {told['bytes']}")
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
        # One step is none to VTK.
        temporal = bool(reader.GetHasTemporalData()) == (len(own) > 1)
        require(temporal and reader.GetNumberOfSteps() == len(own), f"{path}: {reader.GetNumberOfSteps()} steps, the series has {len(own)}")
        # From the end to the start as well: a step does not depend on the one that was read before.
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
                # Cells of one kind may be counted in fewer bits; their numbers are whole.
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
    """No file, and no word of any."""
    left = list((run / "fields").iterdir()) + list(run.glob("*.pvd"))
    require(not left, f"{run}: {left} with run.output.fields = false")
    require("fields" not in json.loads((run / "summary.json").read_text()), f"{run}: summary.json tells of fields")
    print(f"{run.name}: no fields")


def views(folder):
    """Pictures with more than a background."""
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
