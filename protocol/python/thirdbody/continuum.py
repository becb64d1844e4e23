"""A continuum: forces go in, displacements come out."""

from __future__ import annotations

from typing import Any, Dict, List, Sequence

import numpy as np

from .node import Window
from .solver import Solver


class Continuum(Solver):
    """The side of an interface that receives forces.

    A subclass defines `points`, `rest`, `step` and `displacement`; this class provides repeats, columns by probing, the interface
    work, checkpoints and checks. Arrays of a returned state are read-only: `step` makes new ones.
    """

    kind = "continuum"
    sets: Sequence[str] = ("top",)

    #: Length of the window (s) in which `step` is called, for solvers without their own step.
    window_s = 0.0

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

    def _offers(self) -> Dict[str, bool]:
        return {"advance": True, "columns": self.rollback, "alone": True}

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
        return self._keep(state, float(np.add.reduce(force * increment)), window.substeps)

    def advance_alone(self, window: Window) -> List[float]:
        self.window_s = window.length_s
        return self._keep(self._frozen(self.step(self.state, self._still(), window.substeps)), 0.0, window.substeps)
