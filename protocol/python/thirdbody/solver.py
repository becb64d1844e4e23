"""The common base of `Continuum` and `GrainLayer`: sets, states, reports, checkpoints."""

from __future__ import annotations

from typing import Any, Dict, List, Optional, Sequence, Tuple

import numpy as np

from .config import Config, Setting
from .errors import ConfigurationError, Diverged, ProtocolError
from .node import Description, Node, Outcome, Points, Term, Window, capabilities
from .state import all_finite, digest, freeze, from_bytes, to_bytes

ROLES = ("work", "stored", "dissipated")


class Solver(Node):
    """A solver whose methods take and return its state. Subclass `Continuum` or `GrainLayer`, not this."""

    #: Name of the solver in descriptions.
    kind = "foreign"
    #: Name and version of the software.
    software = "thirdbody (Python)"
    #: Sets that an interface can name.
    sets: Sequence[str] = ()
    #: Mean outward unit normal of each set: coupled sets must face each other.
    outward: Dict[str, Any] = {}
    #: Period (m) of a set along x, with no point of the set twice; a set that is missing has ends.
    period_m: Dict[str, float] = {}
    #: Own step (s); None for a solver that takes the window as its step.
    step_s: Optional[float] = None
    #: The longest stable step (s), or window of a solver without its own step, and the name of that bound.
    step_limit_s: Optional[float] = None
    step_limit_name = ""
    #: End of the load history (s), if the solver has one.
    end_s: Optional[float] = None
    #: Parts of the load history: `{"name", "t0_s", "t1_s", "sampled", "picture"}`.
    phases: Sequence[Dict[str, Any]] = ()
    #: Inertia behind the points of a layer, for predictions of stability (WIRE.md, `backing`).
    backing: Optional[Dict[str, Any]] = None
    #: Advice to the user before a long run.
    warnings: Sequence[str] = ()
    #: False for a solver that can neither copy its state nor return to it: it works only with staggered schemes.
    rollback = True

    def __init__(self, config: Config, setting: Setting) -> None:
        """Reads the configuration; subclasses that need keys extend this."""
        self.config = config
        self.setting = setting

    # The solver's part.

    def points(self, set_name: str) -> Points:
        """The points of a set."""
        raise NotImplementedError

    def rest(self) -> Any:
        """The state at the start of the run."""
        raise NotImplementedError

    def energy(self, state: Any) -> Optional[Dict[str, Dict[str, float]]]:
        """Energies since the start (J) by their role in the balance: `{"work": {...}, "stored": {...}, "dissipated": {...}}`.

        This class adds the interface work. `None` means that the solver keeps no ledger.
        """
        return None

    def signals(self, state: Any) -> Dict[str, float]:
        """Values for signals.csv, unit in the name."""
        return {}

    def results(self, state: Any) -> Dict[str, float]:
        """Results of the run, unit in the name."""
        return {}

    def held_load(self, state: Any) -> Optional[Tuple[float, float]]:
        """The load held in the sampled phase, and the mean of the force that it exerted (N, downwards). The coupler compares the force
        through the interface with both."""
        return None

    def snapshot(self, name: str) -> None:
        """Writes the fields of `self.state` below `self.setting.fields`."""

    # The base's part.

    def begin(self) -> None:
        """Sets the initial state; called once, before the greeting is answered."""
        self.state: Any = self._frozen(self.rest())
        self.steps = 0
        self.interface_work_j = 0.0
        self._coupled: List[str] = []
        self._rows = np.empty((0, 5))
        self._selected: Any = slice(0, 0)
        self._size = 0
        self._candidate: Any = None
        energies = self.energy(self.state)
        self._terms: List[Term] = []
        if energies is not None:
            unknown = set(energies) - set(ROLES)
            if unknown:
                raise ConfigurationError(f"energy() must give work, stored and dissipated, not {sorted(unknown)}")
            self._terms = [Term("interface_work", "interface_work")]
            self._terms += [Term(name, role) for role in ROLES for name in energies.get(role, {})]
        self._signals = list(self.signals(self.state))

    def _frozen(self, state: Any) -> Any:
        return freeze(state) if self.rollback else state

    def describe(self) -> Description:
        return Description(
            kind=self.kind,
            software=self.software,
            capabilities=capabilities(checkpoint=self.rollback, resume=self.rollback, **self._offers()),
            step_s=self.step_s,
            step_limit_s=self.step_limit_s,
            step_limit_name=self.step_limit_name,
            end_s=self.end_s,
            phases=[dict(phase) for phase in self.phases],
            sets=list(self.sets),
            signals=self._signals,
            ledger=self._terms,
            warnings=list(self.warnings),
            backing=self.backing,
            outward={name: tuple(map(float, normal)) for name, normal in self.outward.items()},
            period_m={name: float(length) for name, length in self.period_m.items()},
        )

    def _offers(self) -> Dict[str, bool]:
        raise NotImplementedError

    def couple(self, set_name: str) -> Points:
        if set_name not in self.sets:
            raise ConfigurationError(f"no set `{set_name}`; this participant has {', '.join(self.sets) or 'none'}")
        points = self.points(set_name)
        rows = points.rows(set_name)
        self._coupled.append(set_name)
        self._rows = np.concatenate([self._rows, rows])
        self._selected = slice(0, len(self._rows))
        self._size = 2 * len(self._rows)
        return Points(*rows.T)

    def select(self, points: np.ndarray) -> None:
        if points.size and (points.min() < 0 or points.max() >= len(self._rows)):
            raise ProtocolError(f"point {points.max()} of {len(self._rows)} was selected")
        # Neighbours are taken as one slice, at a tenth of the cost of picking them one by one.
        run = points.size > 0 and np.array_equal(points, np.arange(points[0], points[0] + points.size))
        self._selected = slice(int(points[0]), int(points[-1]) + 1) if run else points
        self._size = 2 * points.size

    @property
    def components(self) -> np.ndarray:
        """Indices of the exchanged components among the components of all coupled points."""
        return np.arange(2 * len(self._rows)).reshape(-1, 2)[self._selected].reshape(-1)

    def _still(self) -> np.ndarray:
        """Zeros for all coupled points, or for the points of all sets if no set is coupled."""
        count = len(self._rows) or sum(len(self.points(name).rows(name)) for name in self.sets)
        return np.zeros((count, 2))

    def _spread(self, numbers: np.ndarray) -> np.ndarray:
        """Values of the exchanged components as rows of all coupled points; the others are zero."""
        if numbers.size != self._size:
            raise ProtocolError(f"{numbers.size} numbers arrived for {self._size // 2} points")
        if self._size == 2 * len(self._rows) and isinstance(self._selected, slice):
            return numbers.reshape(-1, 2)
        rows = np.zeros((len(self._rows), 2))
        rows[self._selected] = numbers.reshape(-1, 2)
        return rows

    def _gather(self, rows: Any, what: str) -> np.ndarray:
        """The exchanged components of rows of all coupled points."""
        if np.iscomplexobj(rows):
            raise ConfigurationError(f"{what} holds complex numbers, and the protocol exchanges real ones: return the real part")
        rows = np.asarray(rows, dtype=float)
        if rows.shape != (len(self._rows), 2):
            raise ConfigurationError(f"{what} has the shape {rows.shape} instead of {(len(self._rows), 2)}: a row for each point")
        numbers = rows[self._selected].reshape(-1)
        if not all_finite(numbers):
            raise Diverged(f"{what} holds {numbers[~np.isfinite(numbers)][0]}: this solver diverged; lower its step or the window")
        return numbers

    def _accept(self, window: Window) -> Any:
        """The candidate for the committed window."""
        if self._candidate is None or self._candidate[0] != window[:1] + window[2:]:
            raise ProtocolError(f"window {window.index} is committed, but the last request was for another window")
        return self._candidate

    def _keep(self, state: Any, work_j: float, steps: int) -> List[float]:
        self.state, self._candidate = state, None
        self.interface_work_j += work_j
        self.steps += steps
        return self._report()

    def _report(self) -> List[float]:
        signals = self.signals(self.state)
        if list(signals) != self._signals:
            raise ConfigurationError(f"signals() gave {list(signals)}, at the start {self._signals}")
        numbers = [float(value) for value in signals.values()]
        if self._terms:
            energies = self.energy(self.state) or {}
            own = {name: joules for role in ROLES for name, joules in energies.get(role, {}).items()}
            numbers += [self.interface_work_j] + [float(own[term.name]) for term in self._terms[1:]]
        return numbers

    def _kept(self) -> Dict[str, Any]:
        """Everything that can change a later bit."""
        return {"state": self.state, "steps": self.steps, "interface_work_j": self.interface_work_j}

    def checkpoint(self) -> bytes:
        return to_bytes(self._kept())

    def restore(self, state: bytes) -> None:
        self._take_up(from_bytes(state))

    def _take_up(self, kept: Dict[str, Any]) -> None:
        self.state = self._frozen(kept["state"])
        self.steps = kept["steps"]
        self.interface_work_j = kept["interface_work_j"]
        self._candidate = None

    def finish(self) -> Outcome:
        try:
            state_hash = digest(self._kept())
        except ConfigurationError:
            if self.rollback:
                raise
            state_hash = ""
        results = {name: float(value) for name, value in self.results(self.state).items()}
        held = self.held_load(self.state)
        return Outcome(self.steps, state_hash, {"steps": float(self.steps)}, results, held_load=held)
