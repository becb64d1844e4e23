"""A continuum: forces go in, displacements come out."""

from __future__ import annotations

from typing import Any, Dict, List, Optional, Sequence

import numpy as np

from .errors import Diverged, ProtocolError
from .node import Outcome, Window
from .solver import Solver
from .state import all_finite


class Continuum(Solver):
    """The side of an interface that receives forces.

    A subclass defines `points`, `rest`, `step` and `displacement`; this class provides repeats, columns by probing, the interface
    work, checkpoints and checks. Arrays of a returned state are read-only: `step` makes new ones.

    A body that takes heat also sets `start_k`, `capacity` and `heated`, and defines `warm`.
    """

    kind = "continuum"
    sets: Sequence[str] = ("top",)

    #: Length of the window (s) in which `step` is called, for solvers without their own step.
    window_s = 0.0

    #: Temperature at the start (K); None for a body that takes no heat.
    start_k: Optional[float] = None
    #: Heat capacity (J/K) of each temperature of the body.
    capacity: np.ndarray
    #: Index of each point's temperature among all.
    heated: np.ndarray

    #: The committed state with the displacement of its exchanged components.
    _before: Any = None

    def step(self, state: Any, force: np.ndarray, n: int) -> Any:
        """The state `n` own steps later under a constant force on each point (N), rows of (x, y).

        An explicit integrator with accelerations in its state computes them anew under this force, which jumps from one window
        to the next.
        """
        raise NotImplementedError

    def displacement(self, state: Any) -> np.ndarray:
        """Displacement of each point since the start (m), rows of (x, y)."""
        raise NotImplementedError

    def warm(self, rise: np.ndarray, heat: np.ndarray, time_s: float) -> np.ndarray:
        """Rises of all temperatures since the start (K) after `time_s`, in which this heat (J) enters at each of them.

        `rise` are the rises before. Equal times have the same bits, so that a solver can keep its factors.
        """
        raise NotImplementedError

    def begin(self) -> None:
        super().begin()
        if self.start_k is not None:
            # `heat` (J) changes the rises from `before` to `rise` (K) within `span_s`; `waited_s` is the time since then.
            none = np.zeros(self.capacity.size)
            sums = {"span_s": 0.0, "waited_s": 0.0, "entered_j": 0.0, "peak": 0.0}
            self._heat: Dict[str, Any] = {"before": none, "rise": none, "heat": none, **sums}

    def _offers(self) -> Dict[str, bool]:
        return {"advance": True, "columns": self.rollback, "alone": True, "heat": self.start_k is not None}

    def columns(self, window: Window) -> np.ndarray:
        """C (m/N) from one run per component from the start, minus a run without force. Override it if there is a cheaper way."""
        self.window_s = window.length_s
        rest = self._frozen(self.rest())

        def end(force: np.ndarray) -> np.ndarray:
            state = self.step(rest, self._spread(force), window.substeps)
            return self._gather(self.displacement(state), "displacement()")

        size = self._size
        unloaded = end(np.zeros(size))
        columns = np.empty((size, size), order="F")
        for component in range(size):
            unit = np.zeros(size)
            unit[component] = 1.0
            columns[:, component] = end(unit) - unloaded
        return columns

    def advance(self, window: Window, force: np.ndarray) -> np.ndarray:
        self.window_s = window.length_s
        if self._before is None or self._before[0] is not self.state:
            self._before = (self.state, self._gather(self.displacement(self.state), "displacement()").copy())
        state = self._frozen(self.step(self.state, self._spread(force), window.substeps))
        increment = self._gather(self.displacement(state), "displacement()") - self._before[1]
        self._candidate = (window[:1] + window[2:], state, (force, increment))
        return increment

    def commit(self, window: Window, displacement: np.ndarray) -> List[float]:
        _, state, (force, increment) = self._accept(window)
        self._before = None
        self._wait(window)
        return self._keep(state, float(np.add.reduce(force * increment)), window.substeps)

    def advance_alone(self, window: Window) -> List[float]:
        self.window_s = window.length_s
        self._wait(window)
        return self._keep(self._frozen(self.step(self.state, self._still(), window.substeps)), 0.0, window.substeps)

    def take_heat(self, window: Window, heat: np.ndarray) -> np.ndarray:
        if self.start_k is None:
            return super().take_heat(window, heat)
        if heat.size != self._size // 2:
            raise ProtocolError(f"heat of {heat.size} points arrived for {self._size // 2} points")
        last, rows = self._heat, np.zeros(len(self._rows))
        rows[self._selected] = heat
        entering = np.bincount(self.heated, rows, self.capacity.size)
        # Two requests at one time are one with the sum of their heat. Before the first window no time passes, so heat waits for the next.
        again = last["waited_s"] == 0.0
        if again or last["span_s"] == 0.0:
            entering += last["heat"]
        # Rounded: equal numbers of windows differ in the last bits.
        before, span_s = (last["before"], last["span_s"]) if again else (last["rise"], float(f"{last['waited_s']:.9g}"))
        rise = self.warm(before, entering, span_s) if span_s > 0.0 else before
        if not all_finite(rise):
            raise Diverged(f"warm() holds {rise[~np.isfinite(rise)][0]}: this solver diverged")
        surface = rise[self.heated]
        self._heat = self._frozen({
            "before": before, "rise": rise, "heat": entering, "span_s": span_s, "waited_s": 0.0,
            "entered_j": last["entered_j"] + float(heat.sum()), "peak": max(last["peak"], float(surface.max())),
        })
        return self.start_k + surface[self._selected]

    def _wait(self, window: Window) -> None:
        if self.start_k is not None:
            self._heat = {**self._heat, "waited_s": self._heat["waited_s"] + window.length_s}

    def _kept(self) -> Dict[str, Any]:
        return super()._kept() if self.start_k is None else {**super()._kept(), "heat": self._heat}

    def _take_up(self, kept: Dict[str, Any]) -> None:
        super()._take_up(kept)
        if self.start_k is not None:
            self._heat = kept["heat"]

    def finish(self) -> Outcome:
        outcome = super().finish()
        if self.start_k is not None:
            heat = self._heat
            entered = heat["entered_j"]
            stored = float(self.capacity @ heat["rise"]) + (0.0 if heat["span_s"] else float(heat["heat"].sum()))
            size = abs(entered) + abs(stored)
            outcome.results.update({
                "heat_interface_j": entered,
                "heat_stored_j": stored,
                "heat_balance_rel": abs(entered - stored) / size if size else 0.0,
                "surface_temperature_peak_k": self.start_k + heat["peak"],
            })
        return outcome
