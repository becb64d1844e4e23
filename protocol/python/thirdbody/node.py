"""A solver, request by request (protocol/WIRE.md, "Requests").

Most programs use `Continuum` or `GrainLayer`, which need only a few methods; `Node` is the whole conversation.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass, field
from typing import Any, Dict, List, NamedTuple, Optional, Sequence, Tuple

import numpy as np

from .errors import ConfigurationError


class Window(NamedTuple):
    """One coupling window. Time is counted in whole steps of the continuum."""

    index: int
    iteration: int
    step: int
    substeps: int
    t0_s: float
    t1_s: float

    @property
    def length_s(self) -> float:
        """Its length (s)."""
        return self.t1_s - self.t0_s


class Points(NamedTuple):
    """Points of a coupled set, one entry of each vector per point (m, kg)."""

    x_m: Any
    y_m: Any
    #: Lumped masses (kg); zero for glued disks.
    mass_kg: Any = 0.0
    #: Radii (m); zero for nodes of a mesh.
    radius_m: Any = 0.0
    #: Tributary lengths (m); by default half the way to each neighbour along the set.
    length_m: Any = None

    def rows(self, set_name: str) -> np.ndarray:
        """Rows of (x, y, mass, radius, length)."""
        x, y = (np.atleast_1d(np.asarray(v, dtype=float)) for v in (self.x_m, self.y_m))
        if x.ndim != 1 or x.shape != y.shape or not x.size:
            raise ConfigurationError(f"set `{set_name}`: x_m and y_m must be vectors of one length")
        length = self.length_m
        if length is None:
            if x.size < 2:
                raise ConfigurationError(f"set `{set_name}`: a single point needs its length_m")
            half = 0.5 * np.hypot(np.diff(x), np.diff(y))
            length = np.append(half, 0.0) + np.insert(half, 0, 0.0)
        columns = [x, y] + [np.broadcast_to(np.asarray(v, dtype=float), x.shape) for v in (self.mass_kg, self.radius_m, length)]
        rows = np.stack(columns, axis=1)
        if not np.isfinite(rows).all():
            raise ConfigurationError(f"set `{set_name}`: its points hold a value that is not finite")
        return rows


class Term(NamedTuple):
    """A term of the energy ledger: its name and its role in the balance work - stored - dissipated = 0."""

    name: str
    #: `interface_work`, `work`, `stored` or `dissipated`.
    role: str


@dataclass
class Description:
    """A node's description of itself at the handshake, as JSON."""

    kind: str
    software: str
    capabilities: Dict[str, bool]
    step_s: Optional[float] = None
    step_limit_s: Optional[float] = None
    step_limit_name: str = ""
    end_s: Optional[float] = None
    phases: List[Dict[str, Any]] = field(default_factory=list)
    moments: Dict[str, float] = field(default_factory=dict)
    sets: List[str] = field(default_factory=list)
    signals: List[str] = field(default_factory=list)
    ledger: List[Term] = field(default_factory=list)
    warnings: List[str] = field(default_factory=list)
    backing: Optional[Dict[str, Any]] = None
    outward: Dict[str, Tuple[float, float]] = field(default_factory=dict)
    period_m: Dict[str, float] = field(default_factory=dict)

    def document(self) -> Dict[str, Any]:
        """The description as a JSON object."""
        document = {**asdict(self), "ledger": [{"name": term.name, "role": term.role} for term in self.ledger]}
        # Empty moments are left out, as in other programs.
        return document if self.moments else {key: value for key, value in document.items() if key != "moments"}


#: The words of capabilities on the wire.
CAPABILITIES = ("checkpoint", "advance", "columns", "compliant_boundary", "rigid_boundary", "follow", "alone", "resume", "heat")


def capabilities(**offered: bool) -> Dict[str, bool]:
    """Capabilities by their words on the wire; the others are false, and `heat` is left out then."""
    unknown = set(offered) - set(CAPABILITIES)
    if unknown:
        raise ValueError(f"no such capabilities: {sorted(unknown)}")
    words = [word for word in CAPABILITIES if word != "heat" or offered.get(word)]
    return {word: bool(offered.get(word, False)) for word in words}


@dataclass
class Outcome:
    """Results of a run."""

    steps: int
    state_hash: str
    work: Dict[str, float] = field(default_factory=dict)
    results: Dict[str, float] = field(default_factory=dict)
    warnings: List[str] = field(default_factory=list)
    #: The held load, and the mean of the force that it exerted (N, downwards).
    held_load: Optional[Tuple[float, float]] = None


class Node:
    """A solver, seen from the coupler.

    Vectors over the exchanged points hold two components a point, `(x0, y0, x1, y1, ...)`, in SI units. Points of several coupled
    sets come one set after the other, in the order of the `couple` calls. Between two commits every request starts again from the
    last committed state, so the coupler can repeat a window as often as it wants.
    """

    def begin(self) -> None:
        """Called once, after the configuration is read and before the greeting is answered."""

    def describe(self) -> Description:
        """Kind, step, capabilities and reports."""
        raise NotImplementedError

    def couple(self, set_name: str) -> Points:
        """Couples a set and returns its points; called once per layer if a set of a continuum carries several."""
        raise NotImplementedError

    def select(self, points: np.ndarray) -> None:
        """Restricts the exchange to these points of all coupled sets; forces on all others are zero."""
        raise NotImplementedError

    def columns(self, window: Window) -> np.ndarray:
        """Condensed compliance (m/N): column j holds the increments of a first window like this one under 1 N in component j."""
        raise _unsupported("columns of its compliance")

    def impedance(self, window: Window) -> np.ndarray:
        """Impedance (kg/s): column j holds the reactions at the end of a window in which velocity j grows linearly to 1 m/s."""
        raise _unsupported("columns of its impedance")

    def set_boundary(self, window_s: float, compliance: np.ndarray) -> None:
        """Announces windows of `window_s` and W (1/kg) of the boundary: v = a + W p, with the impulses p (N s) on its points."""
        raise _unsupported("a boundary that carries its points")

    def advance(self, window: Window, force: np.ndarray) -> np.ndarray:
        """Increments (m) of a window under a constant force (N)."""
        raise _unsupported("a window under a given interface force")

    def follow(self, window: Window, velocity: np.ndarray) -> Tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Force at the end (N), increments (m) and work (J) of a window whose velocities change linearly to these (m/s)."""
        raise _unsupported("a window along a given velocity")

    def solve(self, window: Window, free_velocity: np.ndarray) -> Tuple[np.ndarray, np.ndarray, int, float, bool]:
        """Force on the boundary (N), its velocity (m/s), iterations, residual and whether the solver converged, for a = `free_velocity`."""
        raise _unsupported("a window on a boundary")

    def commit(self, window: Window, displacement: np.ndarray) -> Sequence[float]:
        """Makes the last answer the state; returns signals, then energies, in the order of the description."""
        raise NotImplementedError

    def take_heat(self, window: Window, heat: np.ndarray) -> np.ndarray:
        """Temperature (K) of each exchanged point of a continuum, after this heat (J) has entered there since the last call."""
        raise _unsupported("heat through its surface")

    def take_temperatures(self, window: Window, temperature: np.ndarray) -> np.ndarray:
        """Heat (J) that left at each glued point since the last call, then all heats per kelvin (J/K); the body has this temperature (K) now."""
        raise _unsupported("heat into its boundary")

    def advance_alone(self, window: Window) -> Sequence[float]:
        """Advances without an interface and commits."""
        raise _unsupported("running without an interface")

    def checkpoint(self) -> bytes:
        """The committed state as bytes."""
        raise _unsupported("a checkpoint of its state")

    def restore(self, state: bytes) -> None:
        """Makes the state of an earlier `checkpoint` the committed one."""
        raise _unsupported("a return to a checkpoint of its state")

    def snapshot(self, name: str) -> None:
        """Writes the fields of the committed state under this name."""

    def finish(self) -> Outcome:
        """Ends the run."""
        raise NotImplementedError


def _unsupported(what: str) -> ConfigurationError:
    return ConfigurationError(
        f"this participant does not offer {what}: choose another scheme or another participant"
    )
