"""A layer of grains: velocities of its glued points go in, forces on them come out."""

from __future__ import annotations

from typing import Any, Dict, List, Sequence, Tuple

import numpy as np

from .config import Config, Setting
from .errors import ConfigurationError
from .node import Window
from .solver import Solver

#: Residual of the boundary's equation to which a window on a compliant one is repeated, over its largest velocity.
TOLERANCE = 1e-9
#: Repeats of a window before it counts as not converged.
REPEATS = 60
#: Windows before that the first guess of the next is made with.
REUSED = 4


class GrainLayer(Solver):
    """The side of an interface that is driven by the motion of its glued points.

    A subclass gives `points`, `rest` and `step`. On a compliant boundary the velocity depends on the answer, v = a + W p with the
    impulse p: this class finds it by repeating the window (IQN-ILS, Degroote, Bathe and Vierendeels 2009). A solver that knows
    better overrides `solve`; one whose windows are too dear to be repeated says `compliant = False` and is coupled by a scheme with
    a rigid boundary.
    """

    kind = "grain-layer"
    sets: Sequence[str] = ("base",)
    #: False: windows on a rigid boundary only.
    compliant = True

    def step(self, state: Any, velocity: np.ndarray, window_s: float) -> Tuple[Any, np.ndarray]:
        """The state a window later while the glued points go at these constant velocities (m/s), rows of (x, y), and the mean
        force of the layer on each of them (N)."""
        raise NotImplementedError

    def glue(self, state: Any, displacement: np.ndarray) -> Any:
        """The state with its glued points where the coupler has them (m, since the start), rows of (x, y). By default they stay
        where `step` moved them, which is the same but for the gap that the scheme leaves."""
        return state

    def __init__(self, config: Config, setting: Setting) -> None:
        super().__init__(config, setting)
        self._window_s = 0.0
        self._compliance = np.empty((0, 0))
        self._pairs: List[Tuple[np.ndarray, np.ndarray]] = []

    def _offers(self) -> Dict[str, bool]:
        return {"compliant_boundary": self.compliant and self.rollback, "rigid_boundary": True, "alone": True}

    def set_boundary(self, window_s: float, compliance: np.ndarray) -> None:
        size = self._size
        compliance = compliance.reshape((size, size), order="F")
        if not self.compliant and compliance.any():
            raise ConfigurationError(
                'this participant takes a rigid boundary only: choose scheme = "staggered-serial" or "fixed-point-serial"'
            )
        self._window_s, self._compliance, self._pairs = window_s, compliance, []

    def _run(self, velocity: np.ndarray, window_s: float) -> Tuple[Any, np.ndarray]:
        state, force = self.step(self.state, self._spread(velocity), window_s)
        return self._frozen(state), self._gather(force, "the force of step()")

    def solve(self, window: Window, free_velocity: np.ndarray) -> Tuple[np.ndarray, np.ndarray, int, float, bool]:
        length = window.length_s
        if self._compliance.any():
            velocity, force, state, repeats, residual = self._balance(free_velocity, length)
        else:
            velocity, repeats, residual = free_velocity.copy(), 1, 0.0
            state, force = self._run(velocity, length)
        work = -length * float(np.add.reduce(force * velocity))
        self._candidate = (window[:1] + window[2:], state, work)
        return force, velocity, repeats, residual, residual <= TOLERANCE

    def _balance(self, free: np.ndarray, length: float) -> Tuple[np.ndarray, np.ndarray, Any, int, float]:
        """Solves v = a + W H F(v)."""
        velocity = free.copy()
        inputs: List[np.ndarray] = []
        outputs: List[np.ndarray] = []
        fresh: List[Tuple[np.ndarray, np.ndarray]] = []
        repeat = 0
        while True:
            repeat += 1
            state, force = self._run(velocity, length)
            image = free + length * (self._compliance * force).sum(axis=1)
            residual = image - velocity
            size = max(np.abs(free).max(), np.abs(image).max(), 1e-300)
            relative = float(np.abs(residual).max() / size)
            if relative <= TOLERANCE or repeat >= REPEATS:
                self._pairs = (fresh + self._pairs)[: REUSED * REPEATS]
                return velocity, force, state, repeat, relative
            if inputs:
                fresh.insert(0, (residual - inputs[-1], image - outputs[-1]))
            inputs.append(residual)
            outputs.append(image)
            velocity = image + self._correction(residual, fresh + self._pairs)

    @staticmethod
    def _correction(residual: np.ndarray, pairs: List[Tuple[np.ndarray, np.ndarray]]) -> np.ndarray:
        """What least squares over differences of residuals and images add to the next guess."""
        if not pairs:
            return np.zeros_like(residual)
        differences = np.array([pair[0] for pair in pairs[: residual.size]]).T
        images = np.array([pair[1] for pair in pairs[: residual.size]]).T
        weights = np.linalg.lstsq(differences, -residual, rcond=1e-10)[0]
        return images @ weights

    def commit(self, window: Window, displacement: np.ndarray) -> List[float]:
        _, state, work = self._accept(window)
        if displacement.size:
            state = self._frozen(self.glue(state, self._spread(displacement)))
        return self._keep(state, work, 1)

    def advance_alone(self, window: Window) -> List[float]:
        state, _ = self.step(self.state, self._still(), window.length_s)
        return self._keep(self._frozen(state), 0.0, 1)
