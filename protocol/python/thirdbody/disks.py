"""A layer of disks under a flat wheel, with the grains, law and load of a scene of the built-in grains, but another solver."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any, Dict, Mapping, Optional, Sequence, Tuple

import numpy as np

from .config import Config, Setting
from .errors import ConfigurationError
from .layer import GrainLayer
from .node import Points
from .runs import read_toml


def turned(vectors: np.ndarray) -> np.ndarray:
    """Rows of (x, y), turned left by a right angle."""
    return vectors[:, ::-1] * [-1.0, 1.0]


class DiskLayer(GrainLayer):
    """A subclass defines `step` with explicit sub-steps. `pace` gives the sub-steps, `load` the load on the wheel, `contacts` the touching
    disks, and `booked` completes the new state.

    `twin` is the scene of the built-in grains, `step_s` the longest sub-step, `drag_per_s` the rate at which a drag reduces velocities.
    Springs are the same at all contacts, for any radii: kn = contact_stiffness_pa x thickness (N/m), kt = tangential_stiffness_ratio x kn,
    and |shear| <= friction x pressure. Disks are in order of x, loose ones first; the wheel is the disk after the last.

    A state has the entries of `rest`: displacement, velocity and spin of the disks, height and speed of the wheel, the result of
    `contacts`, the forces on the wheel and on the glued disks, and sums since the start. A subclass may keep more.
    """

    outward = {"base": (0.0, -1.0)}

    def __init__(self, config: Config, setting: Setting) -> None:
        super().__init__(config, setting)
        self.step_most_s, self.drag_per_s = config.number("step_s", above=0), config.number("drag_per_s", above=0)
        grains = _twin(Path(config.get("twin")), setting.participant)
        law, wheel, sample = grains.table("law"), grains.table("wheel"), grains.table("sample")
        if law.get("kind") != "coulomb" or sample.get("kind") != "disks":
            raise ConfigurationError("participant.config.twin: its law is not `coulomb` or its sample is not a list of disks")
        if wheel.number("radius_m") or wheel.number("cycles", 0.0):
            raise ConfigurationError("participant.config.twin: its wheel is round or moves sideways, which this layer cannot do")
        self.friction, self.kn = law.number("friction"), law.number("contact_stiffness_pa", above=0) * setting.thickness_m
        self.kt = law.number("tangential_stiffness_ratio", above=0) * self.kn
        self.load_n, self.wheel_mass = wheel.number("load_n", above=0), wheel.number("mass_kg", above=0)
        self.ramp_s, self.hold_s = wheel.number("ramp_s", above=0), wheel.number("hold_s", above=0)
        self.end_s = self.ramp_s + self.hold_s
        self.phases = [
            {"name": "ramp", "t0_s": 0.0, "t1_s": self.ramp_s},
            {"name": "hold", "t0_s": self.ramp_s, "t1_s": self.end_s, "sampled": True},
        ]
        disks = sorted(map(_disk, enumerate(sample.get("disks"))))
        glued, x, y, self.radius = np.array(disks).T
        self.centre, self.count, self.free = np.stack([x, y], axis=1), len(disks), int((glued == 0.0).sum())
        self.top = float((y + self.radius)[: self.free].max())
        # Glued disks have no mass.
        area = np.where(glued == 0.0, math.pi * self.radius**2, 0.0)
        self.mass = grains.number("density_kg_per_m3", above=0) * grains.number("mass_scale", above=0) * setting.thickness_m * area
        self.inertia = 0.5 * self.mass * self.radius**2
        grains.require_all_read()

    def points(self, set_name: str) -> Points:
        x, y = self.centre[self.free :].T
        return Points(x, y, radius_m=self.radius[self.free :])

    def rest(self) -> Dict[str, Any]:
        still = np.zeros((self.count, 2))
        return {
            "time_s": 0.0, "u": still, "v": still, "spin": still[:, 0].copy(), "height": self.top, "speed": 0.0,
            **self.contacts(still, self.top, {}), "on_wheel": 0.0, "on_base": still[self.free :].copy(),
            "wheel_load": 0.0, "friction": 0.0, "drag": 0.0, "held": np.zeros(4),
        }

    def pace(self, window_s: float) -> Tuple[int, float, float]:
        """The number of sub-steps of a window, their length (s), and the share of all velocities that the drag leaves. The drag
        acts once, at the start of the window, so that the window's answer to the motion below has no jumps."""
        steps = math.ceil(window_s / self.step_most_s - 1e-9)
        return steps, window_s / steps, math.exp(-self.drag_per_s * window_s)

    def load(self, time_s: float) -> float:
        """Load that presses the wheel down (N)."""
        return self.load_n * min(1.0, time_s / self.ramp_s)

    def contacts(self, u: np.ndarray, height: float, force: Mapping[Tuple[int, int], Any]) -> Dict[str, np.ndarray]:
        """All touching pairs, in order, except pairs of glued disks: the normal from the second to the first, the pressure, and the shear
        force on the first along the normal turned left. `force` gives the force on the first (N) by pair; a missing pair has no shear."""
        place = self.centre + u
        rows = np.argsort(place[:, 0], kind="stable")
        x = place[rows, 0]
        # Only disks that are near enough in x can touch: from a disk to the last such disk to its right.
        near = np.searchsorted(x, x + 2.0 * self.radius.max()) - np.arange(self.count) - 1
        left = np.repeat(np.arange(self.count), near)
        right = left + 1 + np.arange(left.size) - np.repeat(np.cumsum(near) - near, near)
        pairs = np.sort(np.stack([rows[left], rows[right]], axis=1), axis=1)
        apart = place[pairs[:, 0]] - place[pairs[:, 1]]
        overlap = self.radius[pairs].sum(axis=1) - np.hypot(*apart.T)
        touch = (overlap > 0.0) & (pairs[:, 0] < self.free)
        under = place[:, 1] + self.radius - height
        below = np.flatnonzero(under > 0.0)
        pairs = np.concatenate([pairs[touch], np.stack([below, np.full(below.size, self.count)], axis=1)])
        normal = np.concatenate([apart[touch] / np.hypot(*apart[touch].T)[:, None], np.tile([0.0, -1.0], (below.size, 1))])
        order = np.lexsort(pairs.T[::-1])
        pairs, normal, overlap = pairs[order], normal[order], np.append(overlap[touch], under[below])[order]
        on_first = np.array([force.get(pair, (0.0, 0.0)) for pair in zip(*pairs.T.tolist())]).reshape(-1, 2)
        return {"pairs": pairs, "normal": normal, "pressure": self.kn * overlap, "shear": (on_first * turned(normal)).sum(axis=1)}

    def booked(self, new: Dict[str, Any], state: Mapping[str, Any], window_s: float, work: float, friction: float) -> Dict[str, Any]:
        """A new state with its time and sums; in this window the load did `work` and friction dissipated `friction` (J)."""
        new["time_s"] = state["time_s"] + window_s
        new["wheel_load"], new["friction"] = state["wheel_load"] + work, state["friction"] + friction
        new["drag"] = state["drag"] + (1.0 - self.pace(window_s)[2] ** 2) * self.kinetic(state)
        # Over the second half of the hold: windows, height of the wheel, force on it and on the base.
        held = new["time_s"] > self.end_s - 0.5 * self.hold_s
        new["held"] = state["held"] + float(held) * np.array([1.0, new["height"], new["on_wheel"], new["on_base"][:, 1].sum()])
        return new

    def tangent(self, states: Sequence[Any], window_s: float) -> np.ndarray:
        """Stiffness of the contacts of the glued disks; in the mean over a window they are pressed half as far as at its end. It counts
        all contacts of all repeats as sticking: too high a stiffness makes slow steps, too low a stiffness makes a cycle."""
        touching = {}
        for state in reversed(states):
            for disk, other in ((1, 0), (0, 1)):
                rows = np.flatnonzero((state["pairs"][:, disk] >= self.free) & (state["pairs"][:, disk] < self.count))
                numbers = state["pairs"][rows][:, [disk, other]] - [self.free, 0]
                touching.update(zip(map(tuple, numbers.tolist()), state["normal"][rows]))
        stiffness = np.zeros((self.count - self.free, 2) * 2)
        for (disk, _), n in sorted(touching.items(), key=lambda contact: contact[0]):
            stiffness[disk, :, disk] += self.kt * np.eye(2) + (self.kn - self.kt) * np.outer(n, n)
        return 0.5 * window_s * stiffness.reshape(2 * len(stiffness), -1)

    def glue(self, state: Any, displacement: np.ndarray) -> Any:
        return {**state, "u": np.concatenate([state["u"][: self.free], displacement])}

    def kinetic(self, state: Mapping[str, Any]) -> float:
        """Kinetic energy of loose disks and wheel (J)."""
        disks = self.mass @ (state["v"] ** 2).sum(axis=1) + self.inertia @ state["spin"] ** 2
        return 0.5 * float(disks + self.wheel_mass * state["speed"] ** 2)

    def energy(self, state: Any) -> Dict[str, Dict[str, float]]:
        springs = 0.5 * float((state["pressure"] ** 2).sum() / self.kn + (state["shear"] ** 2).sum() / self.kt)
        return {
            "work": {"wheel_load": state["wheel_load"]},
            "stored": {"kinetic": self.kinetic(state), "springs": springs},
            "dissipated": {"friction": state["friction"], "drag": state["drag"]},
        }

    def signals(self, state: Any) -> Dict[str, float]:
        return {
            "wheel_y_m": state["height"], "wheel_fn_n": state["on_wheel"],
            "glued_fx_n": state["on_base"][:, 0].sum(), "glued_fy_n": state["on_base"][:, 1].sum(),
            "contacts": float(len(state["pairs"])), "speed_max_m_per_s": np.hypot(*state["v"][: self.free].T).max(),
        }

    def held_load(self, state: Any) -> Optional[Tuple[float, float]]:
        count, _, on_wheel, _ = state["held"]
        return (self.load_n, on_wheel / count) if count else None

    def results(self, state: Any) -> Dict[str, float]:
        count, height, on_wheel, on_base = state["held"]
        if count == 0.0:
            return {}
        return {"approach_m": self.top - height / count, "wheel_force_n": on_wheel / count, "boundary_force_n": -on_base / count}


def _twin(path: Path, participant: str) -> Config:
    """The configuration of the built-in grains with the participant's name."""
    try:
        grains = [other["config"] for other in read_toml(path)["participant"] if other["name"] == participant]
    except OSError as error:
        raise ConfigurationError(f"participant.config.twin: {error}") from error
    if not grains:
        raise ConfigurationError(f"participant.config.twin: {path} has no participant `{participant}`")
    twin = Config(grains[0], ".twin")
    for key in ("solver", "time", "plausible"):
        # The solution and the checks of the built-in grains.
        twin.get(key, None)
    return twin


def _disk(numbered: Tuple[int, Any]) -> Tuple[bool, float, float, float]:
    """Whether a disk is glued, its centre and its radius."""
    disk = Config(numbered[1], f".twin.sample.disks[{numbered[0]}]")
    read = bool(disk.get("glued", False)), disk.number("x_m"), disk.number("y_m"), disk.number("radius_m", above=0)
    disk.require_all_read()
    return read
