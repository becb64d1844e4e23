"""A linear continuum that is always in equilibrium."""

from __future__ import annotations

from typing import Any, Callable, Dict

import numpy as np

from .continuum import Continuum
from .node import Points, Window


class LinearEquilibrium(Continuum):
    """A body whose points move by a compliance times the present forces on them. A subclass sets `x`, `y` and `compliance`."""

    #: Positions of the points (m).
    x: np.ndarray
    y: np.ndarray
    #: Displacement of each component, x and y point by point, under a unit force on each (m/N), 2n x 2n.
    compliance: np.ndarray

    @staticmethod
    def compliance_of(solve: Callable[[np.ndarray], np.ndarray], unknowns: int, coupled: np.ndarray) -> np.ndarray:
        """The columns and rows `coupled` of the inverse of a stiffness matrix with `unknowns` rows; `solve` takes right-hand sides."""
        loads = np.zeros((unknowns, coupled.size))
        loads[coupled, np.arange(coupled.size)] = 1.0
        return solve(loads)[coupled]

    def points(self, set_name: str) -> Points:
        return Points(self.x, self.y)

    def rest(self) -> Any:
        return {"u": np.zeros((self.x.size, 2)), "stored_j": 0.0}

    def step(self, state: Any, force: np.ndarray, n: int) -> Any:
        u = (self.compliance @ force.reshape(-1)).reshape(-1, 2)
        return {"u": u, "stored_j": 0.5 * float((force * u).sum())}

    def displacement(self, state: Any) -> np.ndarray:
        return state["u"]

    def energy(self, state: Any) -> Dict[str, Dict[str, float]]:
        return {"stored": {"strain": state["stored_j"]}}

    def columns(self, window: Window) -> np.ndarray:
        return self.compliance[np.ix_(self.components, self.components)]
