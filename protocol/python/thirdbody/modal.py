"""A supported linear body in motion as its lowest modes and its static flexibility."""

from __future__ import annotations

from typing import Any, Dict

import numpy as np

from .continuum import Continuum
from .node import Points, Window


class Modal(Continuum):
    """A body that its stiffness and its masses describe: u = Phi eta + F_res lambda, with each mode moved exactly over a window.

    F_res is the static flexibility of all modes that are left out, so a constant force gives K^-1 lambda. A subclass sets the
    arrays below in `__init__`. It needs SciPy.
    """

    #: Number of modes.
    modes = 50
    #: Positions of the points (m).
    x: np.ndarray
    y: np.ndarray
    #: Sparse stiffness matrix (N/m) of the unknowns, positive definite.
    stiffness: Any
    #: Lumped mass (kg) of each unknown.
    mass: np.ndarray
    #: Unknown of each component of the points (x0, y0, x1, y1, ...).
    coupled: np.ndarray

    def _prepare(self) -> None:
        from scipy.linalg import eigh
        from scipy.sparse import csc_matrix, diags
        from scipy.sparse.linalg import eigsh, splu

        stiffness, size = csc_matrix(self.stiffness), self.mass.size
        loads = np.zeros((size, self.coupled.size))
        loads[self.coupled, np.arange(self.coupled.size)] = 1.0
        flexibility = splu(stiffness).solve(loads)[self.coupled]
        if self.modes < size - 1:
            # The same start in every run, for the same bits.
            squares, shapes = eigsh(stiffness, self.modes, diags(self.mass).tocsc(), sigma=0.0, v0=np.linspace(1.0, 2.0, size))
        else:
            squares, shapes = eigh(stiffness.toarray(), np.diag(self.mass))
        self._omega, self._shapes = np.sqrt(squares), shapes[self.coupled]
        residual = flexibility - (self._shapes / squares) @ self._shapes.T
        self._residual = 0.5 * (residual + residual.T)

    def points(self, set_name: str) -> Points:
        return Points(self.x, self.y)

    def rest(self) -> Any:
        self._prepare()
        none, still = np.zeros(self._omega.size), np.zeros(self.coupled.size)
        return {"eta": none, "velocity": none, "force": still, "lost_j": 0.0}

    def step(self, state: Any, force: np.ndarray, n: int) -> Any:
        force, omega, angle = force.reshape(-1), self._omega, self._omega * self.window_s
        still = self._shapes.T @ force / omega**2
        swing = state["eta"] - still
        jump = force - state["force"]
        return {
            "eta": still + swing * np.cos(angle) + state["velocity"] / omega * np.sin(angle),
            "velocity": state["velocity"] * np.cos(angle) - omega * swing * np.sin(angle),
            "force": force,
            "lost_j": state["lost_j"] + 0.5 * float(jump @ self._residual @ jump),
        }

    def displacement(self, state: Any) -> np.ndarray:
        return (self._shapes @ state["eta"] + self._residual @ state["force"]).reshape(-1, 2)

    def energy(self, state: Any) -> Dict[str, Dict[str, float]]:
        swing, force = self._omega * state["eta"], state["force"]
        strain = 0.5 * float(swing @ swing + force @ self._residual @ force)
        kinetic = 0.5 * float(state["velocity"] @ state["velocity"])
        return {"stored": {"strain": strain, "kinetic": kinetic}, "dissipated": {"residual_loss": state["lost_j"]}}

    def columns(self, window: Window) -> np.ndarray:
        grown = (1.0 - np.cos(self._omega * window.length_s)) / self._omega**2
        compliance = (self._shapes * grown) @ self._shapes.T + self._residual
        return compliance[np.ix_(self.components, self.components)]
