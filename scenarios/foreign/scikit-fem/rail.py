"""A rail in equilibrium by scikit-fem: bilinear quadrilaterals, plane strain, clamped below, a crown above; with `heat`, its temperatures."""

import numpy as np
import skfem
import skfem.models.elasticity as elasticity
import thirdbody
from scipy.sparse import diags
from scipy.sparse.linalg import splu
from skfem.models.poisson import laplace, unit_load


class Rail(thirdbody.LinearEquilibrium):
    kind = "scikit-fem"
    software = f"scikit-fem {skfem.__version__}"
    outward = {"top": (0.0, 1.0)}

    def __init__(self, config, setting):
        super().__init__(config, setting)
        x, y, quads = thirdbody.crowned_grid(config)
        mesh = skfem.MeshQuad(np.stack([x.reshape(-1), y.reshape(-1)]), quads.T)
        basis = skfem.Basis(mesh, skfem.ElementVector(skfem.ElementQuad1()), intorder=3)
        young, poisson = config.number("young_pa", above=0), config.number("poisson")
        stiffness = elasticity.linear_elasticity(*elasticity.lame_parameters(young, poisson)).assemble(basis)
        free = basis.complement_dofs(basis.get_dofs(nodes=np.arange(x.shape[1])))
        top = np.arange(x.size)[-x.shape[1] :]
        self.x, self.y = x[-1], y[-1]
        # Only the compliance of the upper edge: nothing else is loaded or needed.
        dofs = np.searchsorted(free, basis.nodal_dofs[:, top].T.reshape(-1))
        self.compliance = self.compliance_of(splu(stiffness[free][:, free].tocsc()).solve, free.size, dofs) / setting.thickness_m
        if config.get("heat", None) is not None:
            self.conduct(config, mesh, top)

    def conduct(self, config, mesh, top):
        """C (J/K) and K (W/K) of a rail that is insulated but for the heat that enters.

        All integrals are sums over the corners of the elements, so C is lumped, and in rectangles heat flows along edges only: no
        temperature leaves the range of its neighbours. With Gauss points, a node beside a heated one at the flat elements of the sides
        becomes colder by up to a sixth of the rise.
        """
        heat, thickness = config.table("heat"), self.setting.thickness_m
        corners = np.array([[0.0, 1.0, 1.0, 0.0], [0.0, 0.0, 1.0, 1.0]]), np.full(4, 0.25)
        basis = skfem.Basis(mesh, skfem.ElementQuad1(), quadrature=corners)
        per_volume = config.number("density_kg_per_m3", above=0) * heat.number("capacity_j_per_kg_k", above=0)
        self.start_k = heat.number("start_k", above=0)
        self.capacity = thickness * per_volume * unit_load.assemble(basis)
        self.conduction = thickness * heat.number("conductivity_w_per_m_k", above=0) * laplace.assemble(basis)
        self.heated, self.factored_s = basis.nodal_dofs[0, top], 0.0

    def warm(self, rise, heat, time_s):
        """Backward Euler, (C + h K) T' = C T + Q: the flux jumps from one exchange to the next."""
        if time_s != self.factored_s:
            self.factored_s, self.factors = time_s, splu((diags(self.capacity) + time_s * self.conduction).tocsc())
        return self.factors.solve(self.capacity * rise + heat)


thirdbody.participate(Rail)
