"""A continuum: forces go in, displacements come out."""

from __future__ import annotations

from typing import Any, Dict, List, Sequence

import numpy as np

from .node import Window
from .solver import Solver


class Continuum(Solver):
    """The side of an interface that is driven by forces.

    A subclass gives `points`, `rest`, `step` and `displacement`; this class brings repeats, columns by probing, the work of the
    interface, checkpoints and checks. Arrays of a state that was returned are read-only: `step` makes new ones.
    """

    kind = "continuum"
    sets: Sequence[str] = ("top",)

    #: Length of the window (s) that `step` is in, for solvers without own step.
    window_s = 0.0

    def step(self, state: Any, force: np.ndarray, n: int) -> Any:
        """The state `n` own steps later under a constant force on each point (N), rows of (x, y).

        An explicit integrator whose accelerations are part of the state computes them anew under this force: it jumps from
        one window to the next.
        """
        raise NotImplementedError

    def displacement(self, state: Any) -> np.ndarray:
        """Displacement of each point since the start (m), rows of (x, y)."""
        raise NotImplementedError

    def _offers(self) -> Dict[str, bool]:
        return {"advance": True, "columns": self.rollback, "alone": True}

    def columns(self, substeps: int) -> np.ndarray:
        """C (m/N) by a run from the start for each component, less one without force. Override it where it can be had for less."""
        rest = self._frozen(self.rest())

        def end(force: np.ndarray) -> np.ndarray:
            state = self.step(rest, self._spread(force), substeps)
            return self._gather(self.displacement(state), "displacement()")

        size = 2 * self._selected.size
        unloaded = end(np.zeros(size))
        columns = np.empty((size, size), order="F")
        for component in range(size):
            unit = np.zeros(size)
            unit[component] = 1.0
            columns[:, component] = end(unit) - unloaded
        return columns

    def advance(self, window: Window, force: np.ndarray) -> np.ndarray:
        self.window_s = window.length_s
        state = self._frozen(self.step(self.state, self._spread(force), window.substeps))
        before = self._gather(self.displacement(self.state), "displacement()")
        increment = self._gather(self.displacement(state), "displacement()") - before
        self._candidate = (window[:1] + window[2:], state, float(np.add.reduce(force * increment)))
        return increment

    def commit(self, window: Window, displacement: np.ndarray) -> List[float]:
        _, state, work = self._accept(window)
        return self._keep(state, work, window.substeps)

    def advance_alone(self, window: Window) -> List[float]:
        self.window_s = window.length_s
        none = np.zeros((len(self._rows), 2))
        return self._keep(self._frozen(self.step(self.state, none, window.substeps)), 0.0, window.substeps)
