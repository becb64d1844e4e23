"""The figures of the paper (Renouf, Saulot, Berthier 2006) from runs: paper_figures.py RUN [RUN ...] --out DIR.

Needs matplotlib: pip install './protocol/python[figures]'. A figure without data in a run is left out; the script prints why.
Maps over a cycle need moments within it: run with --set run.output.fields_every_s=8.333333333e-4, a quarter of a cycle of 300 Hz.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any, Callable, Dict, List, NamedTuple, Tuple

import matplotlib
import numpy as np
import thirdbody

matplotlib.use("Agg")
from matplotlib import pyplot
from matplotlib.collections import EllipseCollection, PolyCollection

MM = 1e3
MPA = 1e-6
# Its lightness increases steadily, so the colours also work in grey.
COLOURS = "cividis"


View = Tuple[Tuple[float, float], Tuple[float, float]]


class Missing(Exception):
    """The reason why a figure is left out."""


class Shot(NamedTuple):
    """Fields of one kind at one moment."""

    field: thirdbody.Field
    #: The wheel's displacement then (m).
    wheel_x_m: float


class Scene:
    """The data of a run that figures need."""

    def __init__(self, run: thirdbody.Run) -> None:
        self.run = run
        fields: Dict[str, thirdbody.Fields] = {}
        for name in run.participants:
            try:
                fields[name] = run.fields(name)
            except FileNotFoundError:
                continue
        kinds = [("body", "quads"), ("grains", "radius_m")]
        self.fields = {kind: one for kind, key in kinds for one in fields.values() if len(one) and key in one[0]}

    def signal(self, name: str) -> np.ndarray:
        """A signal of any participant."""
        if not self.run.signals.has(name):
            raise Missing(f"no signal `{name}`")
        return self.run.signals.column(name)

    def moments(self, kind: str) -> thirdbody.Fields:
        """The moments of the first body of elements, or of the grains."""
        if kind not in self.fields:
            raise Missing("no body of finite elements" if kind == "body" else "no grains")
        return self.fields[kind]

    def start_s(self) -> float:
        """The time at which the wheel begins to move."""
        moving = np.flatnonzero(np.abs(self.signal("wheel_x_m")) > 1e-3 * self.amplitude_m())
        return float(self.run.signals["t_s"][max(moving[0] - 1, 0)])

    def amplitude_m(self) -> float:
        """The largest displacement of the wheel."""
        amplitude = float(np.abs(self.signal("wheel_x_m")).max())
        if amplitude == 0.0:
            raise Missing("the wheel does not move")
        return amplitude

    def hold(self, kind: str) -> thirdbody.Field:
        """Fields under the load, before the wheel moves."""
        moments = self.moments(kind)
        if "hold" in moments.names:
            return moments["hold"]
        raise Missing("no fields at the end of the hold")

    def shots(self, kind: str) -> List[Shot]:
        """The moments while the wheel moves."""
        moments, signals = self.moments(kind), self.run.signals
        start_s = self.start_s()
        places = [place for place, t_s in enumerate(moments.t_s) if t_s > 1.0001 * start_s and moments.names[place] != "end"]
        wheel = self.signal("wheel_x_m")
        return [Shot(moments[place], float(np.interp(moments.t_s[place], signals["t_s"], wheel))) for place in places]

    def shot(self, kind: str, share: float, words: str) -> Shot:
        """The last moment at which the wheel is at this share of its amplitude."""
        amplitude = self.amplitude_m()
        found = [one for one in self.shots(kind) if abs(one.wheel_x_m - share * amplitude) < 0.05 * amplitude]
        if not found:
            raise Missing(f"no fields {words}: run with --set run.output.fields_every_s of a quarter of a cycle")
        return found[-1]


def circuit(scene: Scene) -> pyplot.Figure:
    """Figure 1: the tribological circuit with its flows (ug)."""
    results = scene.run.results
    names = {"q_source_kg", "q_ejected_kg", "q_left_by_zone_kg", "q_recirculated_kg", "q_wear_kg", "q_internal_abs_kg", "q_external_kg"}
    if not names <= set(results):
        raise Missing("no flows of third body: it takes grains with `flow = { wear_s = .. }`")
    ug = {name: _amount(1e9 * results[name]) for name in names}
    figure, axes = pyplot.subplots(figsize=(7.5, 3.6), layout="constrained")
    axes.set(xlim=(0, 10), ylim=(0, 5))
    axes.axis("off")
    boxes = {"first bodies": (2.6, 4.5), f"third body in the contact\n$Q_i$ across x = 0: {ug['q_internal_abs_kg']}": (2.6, 2.2), "outside the contact": (8.4, 2.2), "worn": (8.4, 0.4)}
    for words, place in boxes.items():
        axes.text(*place, words, ha="center", va="center", bbox={"boxstyle": "round,pad=0.5", "facecolor": "white"})
    left = _amount(1e9 * (results["q_ejected_kg"] + results["q_left_by_zone_kg"]))
    arrows: List[Tuple[Tuple[float, float], Tuple[float, float], str, Tuple[float, float]]] = [
        ((2.6, 4.1), (2.6, 2.8), f"$Q_s$ detached\n{ug['q_source_kg']}", (2.75, 3.35)),
        ((4.9, 2.4), (6.9, 2.4), f"left\n{left}", (5.5, 2.95)),
        ((6.9, 2.0), (4.9, 2.0), f"$Q_r$ came back\n{ug['q_recirculated_kg']}", (5.2, 1.45)),
        ((8.4, 1.8), (8.4, 0.8), f"$Q_w$ worn\n{ug['q_wear_kg']}", (8.55, 1.3)),
        ((2.6, 0.6), (2.6, 1.6), f"$Q_e$ fed in\n{ug['q_external_kg']}", (2.75, 1.05)),
    ]
    for start, end, words, place in arrows:
        axes.annotate("", xy=end, xytext=start, arrowprops={"arrowstyle": "-|>", "color": "black"})
        axes.text(*place, words, va="center")
    axes.set_title(f"Tribological circuit until t = {MM * scene.run.summary['sim_time_s']:.3g} ms")
    return figure


def _amount(ug: float) -> str:
    """A mass with its unit."""
    return f"{ug:,.0f} µg".replace(",", " ") if ug >= 100 else f"{ug:.3g} µg"


def pressure(scene: Scene) -> pyplot.Figure:
    """Figure 4: hydrostatic pressure under the load, with one colour scale for elements and one for grains."""
    kinds = [kind for kind in ("body", "grains") if kind in scene.fields]
    fields = {kind: scene.hold(kind) for kind in kinds}
    if not fields:
        raise Missing("no fields")
    keys = {"body": "hydrostatic_pressure_pa", "grains": "pressure_pa"}
    values = {kind: MPA * field[keys[kind]] for kind, field in fields.items()}
    views = [_view(kind, field, values[kind]) for kind, field in fields.items()]
    figure, rows = _panels(views)
    for axes, view, (kind, field) in zip(rows, views, fields.items()):
        title = "elements" if kind == "body" else "grains"
        limits = None if kind == "body" else (0.0, float(np.percentile(values[kind][_inside(field, view)], 99)))
        _map(axes, kind, field, values[kind], "p (MPa)", view, limits)
        axes.set_title(f"Hydrostatic pressure under the load, {title}: largest {values[kind].max():.0f} MPa")
    return figure


def status(scene: Scene) -> pyplot.Figure:
    """Figure 5: status of the contact nodes and |u| at the highest velocity of the wheel and at a reversal."""
    if "node_status" not in scene.hold("body"):
        raise Missing("no status of nodes: the wheel does not press on the finite elements")
    shots = [scene.shot("body", 0.0, "at the highest velocity"), scene.shot("body", 1.0, "at a reversal")]
    view = _view("body", shots[0].field, shots[0].field["hydrostatic_pressure_pa"])
    lengths = [1e6 * np.linalg.norm(shot.field["displacement_m"], axis=1) for shot in shots]
    limits = (0.0, max(float(length.max()) for length in lengths))
    figure, grid = pyplot.subplots(2, 2, figsize=(9.5, 6.0), layout="constrained", height_ratios=[1, 3])
    for column, (shot, length, words) in enumerate(zip(shots, lengths, ("highest velocity", "reversal"))):
        field = shot.field
        top, node_status = grid[0, column], field["node_status"]
        for value, mark, name in ((0, "|", "open"), (1, "o", "stick"), (2, "x", "slip")):
            chosen = node_status == value
            x = MM * (field["points_m"] + field["displacement_m"])[chosen, 0]
            top.plot(x, np.full(x.shape, value), mark, color="black", markersize=4, label=name, fillstyle="none")
        top.set(yticks=[0, 1, 2], yticklabels=["open", "stick", "slip"], ylim=(-0.5, 2.5), xlim=view[0], xlabel="x (mm)")
        top.set_title(f"{words}: t = {MM * field.time_s:.3f} ms, $A_w$ = {MM * shot.wheel_x_m:+.3f} mm")
        corners = field["quads"]
        _map(grid[1, column], "body", field, length[corners].mean(axis=1), "|u| (µm)", view, limits)
    return figure


def sliding_time(scene: Scene) -> pyplot.Figure:
    """Figure 6: the share of sliding nodes over time, with the size of the wheel's displacement."""
    sn, t_s, wheel = scene.signal("sn_pct"), scene.run.signals["t_s"], scene.signal("wheel_x_m")
    shown = t_s >= scene.start_s()
    figure, axes = pyplot.subplots(figsize=(7.5, 3.4), layout="constrained")
    (share,) = axes.plot(MM * t_s[shown], sn[shown], color="black", linewidth=0.8, label="$S_n$")
    other = axes.twinx()
    (size,) = other.plot(MM * t_s[shown], MM * np.abs(wheel[shown]), color="0.55", linestyle="--", label="$|A_w|$")
    axes.set(xlabel="t (ms)", ylabel="sliding nodes $S_n$ (%)", ylim=(-2, 118))
    other.set(ylabel="$|A_w|$ (mm)", ylim=(-0.02 * MM * scene.amplitude_m(), 1.18 * MM * scene.amplitude_m()))
    axes.legend(handles=[share, size], loc="upper center", ncols=2, frameon=False)
    return figure


def sliding_velocity(scene: Scene) -> pyplot.Figure:
    """Figure 7: the share of sliding nodes over the wheel's velocity."""
    sn, t_s, wheel = scene.signal("sn_pct"), scene.run.signals["t_s"], scene.signal("wheel_x_m")
    shown = t_s >= scene.start_s()
    velocity = np.gradient(wheel, t_s) if not scene.run.signals.has("wheel_vx_m_per_s") else scene.signal("wheel_vx_m_per_s")
    figure, axes = pyplot.subplots(figsize=(5.5, 4.2), layout="constrained")
    axes.plot(MM * velocity[shown], sn[shown], ".", color="black", markersize=2, alpha=0.5)
    axes.set(xlabel="velocity of the wheel (mm/s)", ylabel="sliding nodes $S_n$ (%)", ylim=(-2, 102))
    return figure


def height(scene: Scene) -> pyplot.Figure:
    """Figure 8: the height of the wheel over its displacement."""
    wheel_x, wheel_y, t_s = scene.signal("wheel_x_m"), scene.signal("wheel_y_m"), scene.run.signals["t_s"]
    shown = t_s >= scene.start_s()
    rise = 1e6 * (wheel_y[shown] - wheel_y[shown][0])
    figure, axes = pyplot.subplots(figsize=(5.5, 4.2), layout="constrained")
    axes.plot(MM * wheel_x[shown], rise, color="black", linewidth=0.8)
    title = ""
    if "grains" in scene.fields:
        radius = scene.fields["grains"][0]["radius_m"]
        title = f"mean radius of the grains {1e6 * radius[radius > 0].mean():.0f} µm"
    axes.set(xlabel="$A_w$ (mm)", ylabel="rise of the wheel since it moves (µm)", title=title)
    return figure


def grain_displacement(scene: Scene) -> pyplot.Figure:
    """Figure 9: displacement of the grains since the hold, with the wheel furthest out and in the middle."""
    hold = scene.hold("grains")
    shots = [scene.shot("grains", share, words) for share, words in ((1.0, "at +A"), (0.0, "at A_w = 0"), (-1.0, "at -A"))]
    moved = []
    for shot in shots:
        if len(shot.field["points_m"]) != len(hold["points_m"]):
            raise Missing("grains were fed in since the hold and have no displacement")
        moved.append(1e6 * (shot.field["points_m"][:, 0] - hold["points_m"][:, 0]))
    view = _view("grains", hold, hold["pressure_pa"])
    # A few detached grains move much further than all others.
    shares = [np.percentile(np.abs(one[_inside(shot.field, view)]), 98) for shot, one in zip(shots, moved)]
    largest = float(max(shares))
    figure, rows = _panels([view] * 3)
    for axes, shot, values in zip(rows, shots, moved):
        _map(axes, "grains", shot.field, values, "$u_x$ (µm)", view, (-largest, largest))
        axes.set_title(f"Displacement since the hold, $A_w$ = {MM * shot.wheel_x_m:+.3f} mm, t = {MM * shot.field.time_s:.3f} ms")
    return figure


def grain_velocity(scene: Scene) -> pyplot.Figure:
    """Figure 10: velocities of the grains when the wheel is fastest."""
    shot = scene.shot("grains", 0.0, "at A_w = 0")
    field = shot.field
    speed = MM * np.linalg.norm(field["velocity_m_per_s"], axis=1)
    hold = scene.hold("grains")
    view = _view("grains", hold, hold["pressure_pa"])
    inside = _inside(field, view)
    largest = float(np.percentile(speed[inside], 98))
    figure, (axes,) = _panels([view])
    _map(axes, "grains", field, speed, "|v| (mm/s)", view, (0.0, largest))
    x, y = (MM * field["points_m"]).T
    chosen = np.flatnonzero(inside)[:: max(1, int(inside.sum()) // 300)]
    # All arrows have one length: the figure is about directions where the field vanishes.
    direction = field["velocity_m_per_s"][chosen] / np.maximum(np.linalg.norm(field["velocity_m_per_s"][chosen], axis=1), 1e-300)[:, None]
    axes.quiver(x[chosen], y[chosen], *direction.T, color="white", edgecolor="black", linewidth=0.4, width=0.003, scale=60, headwidth=4)
    axes.set_title(f"Velocity of the grains, $A_w$ = {MM * shot.wheel_x_m:+.4f} mm, t = {MM * field.time_s:.3f} ms (arrows: direction)")
    return figure


def _view(kind: str, field: thirdbody.Field, values: np.ndarray) -> View:
    """Limits (mm) of x and y around the loaded part, no higher than 0.6 of their width."""
    points = MM * field["points_m"]
    centres = points[field["quads"]].mean(axis=1) if kind == "body" else points
    # A single grain may carry many times the load of its neighbours.
    loaded = centres[values > 0.15 * np.percentile(values, 99.5)]
    low, high = loaded.min(axis=0), loaded.max(axis=0)
    pad = 0.1 * (high[0] - low[0])
    x = (low[0] - pad, high[0] + pad)
    top = points[:, 1].max() + 0.02 * (x[1] - x[0])
    return x, (max(points[:, 1].min() - 0.1 * pad, top - 0.6 * (x[1] - x[0])), top)


def _inside(field: thirdbody.Field, view: View) -> np.ndarray:
    """The grains of a view, without the wheel's and without grains that are not fed in yet."""
    points = MM * field["points_m"]
    shown = field["radius_m"] > 0
    for k in range(2):
        shown &= (points[:, k] > view[k][0]) & (points[:, k] < view[k][1])
    return shown & (field["wheel"] == 0) if "wheel" in field else shown


def _map(axes: Any, kind: str, field: thirdbody.Field, values: np.ndarray, label: str, view: View, limits: Any = None) -> None:
    """Elements or grains, coloured by values."""
    points = MM * (field["points_m"] + field["displacement_m"] if kind == "body" else field["points_m"])
    if kind == "body":
        drawn = PolyCollection(points[field["quads"]], array=values, cmap=COLOURS, edgecolors="face", linewidths=0.1)
    else:
        sizes = 2 * MM * field["radius_m"]
        drawn = EllipseCollection(sizes, sizes, np.zeros(len(sizes)), units="xy", offsets=points, transOffset=axes.transData, array=values, cmap=COLOURS)
        drawn.set_edgecolor("black")
        drawn.set_linewidth(0.15)
    if limits is not None:
        drawn.set_clim(*limits)
    axes.add_collection(drawn)
    axes.set(xlim=view[0], ylim=view[1], aspect="equal", xlabel="x (mm)", ylabel="y (mm)")
    extend = "neither" if limits is None else "both" if limits[0] < 0.0 else "max"
    axes.figure.colorbar(drawn, ax=axes, label=label, extend=extend, location="bottom", aspect=50)


def _panels(views: List[View]) -> Tuple[Any, List[Any]]:
    """Maps below each other, with the heights of their views."""
    width = 7.5
    heights = [max(0.88 * width * (y[1] - y[0]) / (x[1] - x[0]), 0.6) + 1.9 for x, y in views]
    figure, rows = pyplot.subplots(len(views), 1, figsize=(width, sum(heights)), height_ratios=heights, squeeze=False, layout="constrained")
    return figure, list(rows[:, 0])


FIGURES: List[Tuple[int, str, Callable[[Scene], Any]]] = [
    (1, "circuit", circuit), (4, "pressure", pressure), (5, "status", status), (6, "sliding-over-time", sliding_time),
    (7, "sliding-over-velocity", sliding_velocity), (8, "wheel-height", height), (9, "grain-displacement", grain_displacement),
    (10, "grain-velocity", grain_velocity),
]


def draw(run: thirdbody.Run, out: Path) -> int:
    """Draws the figures that the run has data for; returns their number."""
    name = run.path.name
    print(f"{name}: {run.status}")
    scene, count = Scene(run), 0
    for number, words, drawn in FIGURES:
        try:
            figure = drawn(scene)
        except (Missing, FileNotFoundError, ValueError) as reason:
            print(f"  figure {number} left out: {reason}")
            continue
        path = out / f"{name}-figure-{number:02}-{words}.png"
        figure.savefig(path, dpi=150, bbox_inches="tight")
        pyplot.close(figure)
        print(f"  figure {number}: {path}")
        count += 1
    return count


def main() -> int:
    """Exit code 1 if nothing could be drawn."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("run", nargs="+", help="run directories")
    parser.add_argument("--out", required=True, type=Path, help="folder of the pictures")
    arguments = parser.parse_args()
    arguments.out.mkdir(parents=True, exist_ok=True)
    return 0 if sum(draw(thirdbody.load(run), arguments.out) for run in arguments.run) else 1


if __name__ == "__main__":
    sys.exit(main())
