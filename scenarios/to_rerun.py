"""A run for the Rerun viewer: to_rerun.py RUN [--save FILE.rrd]. Without --save the viewer opens.

Needs the package and Rerun: pip install ./protocol/python mcap rerun-sdk. The timeline `sim_time` has signals as curves, grains as disks,
bodies of elements as meshes coloured by hydrostatic pressure, and forces at the interfaces as arrows, in a layout of views. Lengths are
in millimetres; the longest arrow is a tenth of the interface.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Dict, List

import numpy as np
import rerun as rr
import rerun.blueprint as rrb
import thirdbody

MM = 1e3
TIME = "sim_time"
#: Most rows of signals, and windows of an interface, that are kept; longer ones are thinned out evenly.
ROWS = 2000
ARROW_MOMENTS = 300


def main() -> None:
    """Logs the run to a file or to a new viewer."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("run", type=Path, help="run directory")
    parser.add_argument("--save", type=Path, help="file.rrd, in place of the viewer")
    arguments = parser.parse_args()
    run = thirdbody.load(arguments.run)
    rr.init("thirdbody", recording_id=str(run.manifest["run_id"]))
    layout = blueprint(run)
    if arguments.save is None:
        rr.spawn(default_blueprint=layout)
    else:
        rr.save(arguments.save, default_blueprint=layout)
    # In a 2D view y points down, as in pictures. A view ignores the transform of its own origin, so its origin is one level above.
    rr.log("scene", rr.Transform3D(scale=[1.0, -1.0, 1.0]), static=True)
    rr.log("about", rr.TextDocument(about(run), media_type="text/markdown"), static=True)
    log_signals(run)
    for participant in run.participants:
        log_fields(run, participant)
    for name in run.interfaces:
        log_forces(run, name)


def blueprint(run: thirdbody.Run) -> rrb.Blueprint:
    """The scene at the top, curves grouped by quantity below."""
    curves = [
        rrb.TimeSeriesView(name=name, origin="signals", contents=[f"signals/{column.replace('.', '/')}" for column in columns])
        for name, columns in groups(run).items()
    ]
    scene = rrb.Horizontal(rrb.Spatial2DView(name="scene (mm)", origin="/", contents=["/scene/**"]), rrb.TextDocumentView(name="run", origin="about"), column_shares=[4, 1])
    return rrb.Blueprint(rrb.Vertical(scene, rrb.Grid(*curves), row_shares=[3, 2]), rrb.TimePanel(timeline=TIME), collapse_panels=True)


def groups(run: thirdbody.Run) -> Dict[str, List[str]]:
    """The signals of each view, by their units."""
    ends = {"forces (N)": ("_n",), "positions (m)": ("wheel_x_m", "wheel_y_m", "_uy_m"), "energies (J)": ("_j",), "sliding nodes (%)": ("_pct",),
            "flows (kg)": ("_kg",)}
    found = {name: [column for column in run.signals if column.endswith(end)] for name, end in ends.items()}
    return {name: columns for name, columns in found.items() if columns}


def about(run: thirdbody.Run) -> str:
    """Name, end and results of the run."""
    lines = [f"# {run.scenario['run']['name']}", f"`{run.path.name}`: {run.status}", ""]
    if run.summary:
        lines += [f"- `{name}` = {value:.6g}" for name, value in run.results.items()]
    return "\n".join(lines)


def log_signals(run: thirdbody.Run) -> None:
    """Each column of signals.csv as a curve."""
    every = max(1, len(run.signals["t_s"]) // ROWS)
    times = [rr.TimeColumn(TIME, duration=run.signals["t_s"][::every])]
    for name, values in run.signals.items():
        if name != "t_s" and values.dtype.kind == "f":
            rr.send_columns(f"signals/{name.replace('.', '/')}", indexes=times, columns=rr.Scalars.columns(scalars=values[::every]))


def log_fields(run: thirdbody.Run, participant: str) -> None:
    """Grains as disks or elements as a mesh, at each moment in the run."""
    try:
        fields = run.fields(participant)
    except FileNotFoundError as missing:
        print(f"no fields of {participant}: {missing}")
        return
    key = "pressure_pa" if "radius_m" in fields[0] else "hydrostatic_pressure_pa"
    largest = max(float(np.percentile(field[key], 99.5)) for field in fields) or 1.0
    for field in fields:
        rr.set_time(TIME, duration=field.time_s)
        colours = shades(field[key] / largest)
        if "radius_m" in field:
            rr.log(f"scene/{participant}", rr.Points2D(MM * field["points_m"], radii=MM * field["radius_m"], colors=colours))
        else:
            points = MM * (field["points_m"] + field["displacement_m"])
            corners = points[field["quads"]]
            outlines = np.concatenate([corners, corners[:, :1]], axis=1)
            rr.log(f"scene/{participant}", rr.LineStrips2D(outlines, colors=colours, draw_order=-1.0))


def log_forces(run: thirdbody.Run, name: str) -> None:
    """The forces at the points of an interface as arrows."""
    try:
        interface = run.interface(name)
    except (FileNotFoundError, ImportError) as missing:
        print(f"no forces at {name}: {missing}")
        return
    side = interface[next(iter(interface.sides))]
    sizes = np.linalg.norm(side.force_n, axis=2)
    span_m = np.ptp(side.points_m[:, 0])
    scale = MM * 0.1 * span_m / (sizes.max() or 1.0)
    for window in range(0, len(interface.t_s), max(1, len(interface.t_s) // ARROW_MOMENTS)):
        rr.set_time(TIME, duration=interface.t_s[window])
        tips = MM * (side.points_m + side.displacement_m[window])
        vectors = scale * side.force_n[window]
        rr.log(f"scene/forces/{name}", rr.Arrows2D(origins=tips - vectors, vectors=vectors, colors=[220, 60, 40]))


def shades(shares: np.ndarray) -> np.ndarray:
    """Colours (n x 3) from blue to yellow, with increasing lightness."""
    low, high = np.array([0.0, 34.0, 78.0]), np.array([254.0, 232.0, 56.0])
    return (low + np.clip(shares, 0.0, 1.0)[:, None] * (high - low)).astype(np.uint8)


if __name__ == "__main__":
    main()
