"""A layer of grains: velocities of its glued points go in, forces on them come out."""

from __future__ import annotations

from typing import Any, Dict, List, Optional, Sequence, Tuple

import numpy as np

from .errors import ConfigurationError
from .node import Window
from .solver import Solver


class GrainLayer(Solver):
    """The side of an interface that receives the motion of its glued points.

    A subclass defines `points`, `rest` and `step`. On a compliant boundary the velocity depends on the answer, v = a + W p with the
    impulse p. This class finds it by repeating the window (IQN-ILS, Degroote, Bathe and Vierendeels 2009), from the force of the
    last window and with the stiffness from `tangent`, if any. A solver whose windows are too expensive to repeat sets
    `compliant = False` and is coupled by a scheme with a rigid boundary.
    """

    kind = "grain-layer"
    sets: Sequence[str] = ("base",)
    #: False: windows on a rigid boundary only.
    compliant = True
    #: Residual of a compliant boundary's equation, over its largest velocity, at which repeats of a window stop.
    tolerance = 1e-9
    #: Repeats of a window before it counts as not converged.
    repeats_max = 60
    #: Repeats of the window that enter the next guess.
    secants = 40

    def step(self, state: Any, velocity: np.ndarray, window_s: float) -> Tuple[Any, np.ndarray]:
        """The state one window later, with the glued points at these constant velocities (m/s), rows of (x, y), and the mean
        force of the layer on each point (N)."""
        raise NotImplementedError

    def tangent(self, states: Sequence[Any], window_s: float) -> Optional[np.ndarray]:
        """-dF/dv (N s/m) over all components of all coupled points, for windows of stiff layers on compliant boundaries. `states`
        are the committed state and the results of this window's repeats. With `None` only the repeats determine it."""
        return None

    def glue(self, state: Any, displacement: np.ndarray) -> Any:
        """The state with its glued points at the coupler's displacements (m, since the start), rows of (x, y). By default they stay
        where `step` moved them, which differs only by the gap that the scheme leaves."""
        return state

    def begin(self) -> None:
        super().begin()
        self._compliance = np.empty((0, 0))
        self._force: Any = None

    def _kept(self) -> Dict[str, Any]:
        return {**super()._kept(), "force": self._force}

    def _take_up(self, kept: Dict[str, Any]) -> None:
        super()._take_up(kept)
        self._force = kept["force"]

    def _offers(self) -> Dict[str, bool]:
        return {"compliant_boundary": self.compliant and self.rollback, "rigid_boundary": True, "alone": True}

    def set_boundary(self, window_s: float, compliance: np.ndarray) -> None:
        size = self._size
        compliance = compliance.reshape((size, size), order="F")
        if not self.compliant and compliance.any():
            raise ConfigurationError(
                'this participant takes a rigid boundary only: choose scheme = "staggered-serial" or "fixed-point-serial"'
            )
        self._compliance = compliance

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
        self._candidate = (window[:1] + window[2:], state, (force, velocity))
        return force, velocity, repeats, residual, residual <= self.tolerance

    def _balance(self, free: np.ndarray, length: float) -> Tuple[np.ndarray, np.ndarray, Any, int, float]:
        """Solves v = a + W H F(v)."""
        mobility = length * self._compliance
        states = [self.state]
        tangent, inverse = self._inverse(None, np.eye(free.size), states, mobility, length)
        force = np.zeros_like(free) if self._force is None else self._force
        velocity = inverse @ (free + _times(mobility, force))
        tried: List[Tuple[np.ndarray, np.ndarray]] = []
        repeat = 0
        while True:
            repeat += 1
            state, force = self._run(velocity, length)
            residual = free + _times(mobility, force) - velocity
            size = max(np.abs(free).max(), np.abs(velocity).max(), 1e-300)
            relative = float(np.abs(residual).max() / size)
            if relative <= self.tolerance or repeat >= self.repeats_max:
                return velocity, force, state, repeat, relative
            states.append(state)
            known = inverse
            tangent, inverse = self._inverse(tangent, inverse, states, mobility, length)
            if inverse is not known:
                tried = []
            tried = [*tried[-self.secants :], (velocity, residual)]
            if len(tried) > 1:
                # The part of the residual that least squares over the differences between repeats explain.
                velocities, residuals = (np.diff(np.array(rows), axis=0).T for rows in zip(*tried))
                weights = np.linalg.lstsq(residuals, residual, rcond=1e-10)[0]
                velocity, residual = velocity - velocities @ weights, residual - residuals @ weights
            velocity = velocity + inverse @ residual

    def _inverse(
        self, known: Any, inverse: np.ndarray, states: Sequence[Any], mobility: np.ndarray, length: float
    ) -> Tuple[Any, np.ndarray]:
        """The tangent and (1 + W H K)^-1, computed anew if the tangent has changed."""
        tangent = self.tangent(states, length)
        if tangent is None or (known is not None and np.array_equal(tangent, known)):
            return tangent, inverse
        own = tangent[np.ix_(self.components, self.components)]
        return tangent, np.linalg.inv(np.eye(len(mobility)) + mobility @ own)

    def commit(self, window: Window, displacement: np.ndarray) -> List[float]:
        _, state, (force, velocity) = self._accept(window)
        if displacement.size:
            state = self._frozen(self.glue(state, self._spread(displacement)))
        self._force = force
        return self._keep(state, -window.length_s * float(np.add.reduce(force * velocity)), 1)

    def advance_alone(self, window: Window) -> List[float]:
        state, _ = self.step(self.state, self._still(), window.length_s)
        return self._keep(self._frozen(state), 0.0, 1)


def _times(matrix: np.ndarray, vector: np.ndarray) -> np.ndarray:
    """A product whose bits do not depend on the libraries' threads."""
    return (matrix * vector).sum(axis=1)
