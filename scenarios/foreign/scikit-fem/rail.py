"""A rail in equilibrium by scikit-fem: bilinear quadrilaterals, plane strain, clamped below, a crown above."""

import numpy as np
import skfem
import skfem.models.elasticity as elasticity
import thirdbody
from scipy.sparse.linalg import splu


def graded(length, fine, size, cells):
    """Places from 0 to `length`: `size` apart up to `fine`, then `cells` more that grow by one factor."""
    inner = np.linspace(0.0, fine, int(round(fine / size)) + 1)
    rest, low, high = length - fine, 1.0, 2.0
    for _ in range(100):
        factor = 0.5 * (low + high)
        total = size * sum(factor**k for k in range(1, cells + 1))
        low, high = (factor, high) if total < rest else (low, factor)
    return np.append(inner, fine + np.cumsum(size * factor ** np.arange(1, cells + 1)))


class Rail(thirdbody.Continuum):
    kind = "scikit-fem"
    software = f"scikit-fem {skfem.__version__}"
    outward = {"top": (0.0, 1.0)}

    def __init__(self, config, setting):
        super().__init__(config, setting)
        size, crown = config.number("size_m", above=0), config.number("crown_radius_m", above=0)
        width, height = config.number("width_m", above=0), config.number("height_m", above=0)
        fine = config.number("fine_width_m", above=0), config.number("fine_depth_m", above=0)
        right = graded(0.5 * width, 0.5 * fine[0], size, config.integer("side_columns", above=0))
        depth = graded(height, fine[1], size, config.integer("depth_rows", above=0))
        mesh = skfem.MeshQuad.init_tensor(np.append(-right[:0:-1], right), -depth[::-1])
        x, y = mesh.p
        # The crown takes its drop off every column, from nothing at the base.
        drop = crown - np.sqrt(crown**2 - x**2)
        mesh = skfem.MeshQuad(np.array([x, y - drop * (y + height) / height]), mesh.t)
        basis = skfem.Basis(mesh, skfem.ElementVector(skfem.ElementQuad1()), intorder=3)
        young, poisson = config.number("young_pa", above=0), config.number("poisson")
        stiffness = elasticity.linear_elasticity(*elasticity.lame_parameters(young, poisson)).assemble(basis)
        free = basis.complement_dofs(basis.get_dofs(lambda p: np.isclose(p[1], -height)))
        top = np.flatnonzero(np.isclose(y, 0.0))
        top = top[np.argsort(x[top])]
        self.x, self.y = mesh.p[:, top]
        # The compliance of the upper edge alone: nothing else is loaded or asked for.
        dofs = np.searchsorted(free, basis.nodal_dofs[:, top].T.reshape(-1))
        solve = splu(stiffness[free][:, free].tocsc())
        loads = np.zeros((free.size, dofs.size))
        loads[dofs, np.arange(dofs.size)] = 1.0
        self.compliance = solve.solve(loads)[dofs] / setting.thickness_m

    def points(self, set_name):
        return thirdbody.Points(self.x, self.y)

    def rest(self):
        return {"u": np.zeros((self.x.size, 2)), "stored_j": 0.0}

    def step(self, state, force, n):
        u = (self.compliance @ force.reshape(-1)).reshape(-1, 2)
        return {"u": u, "stored_j": 0.5 * float((force * u).sum())}

    def displacement(self, state):
        return state["u"]

    def energy(self, state):
        return {"stored": {"strain": state["stored_j"]}}

    def columns(self, window):
        return self.compliance[np.ix_(self.components, self.components)]


thirdbody.participate(Rail)
