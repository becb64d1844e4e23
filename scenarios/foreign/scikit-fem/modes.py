"""A rail in motion as its lowest modes: bilinear quadrilaterals by scikit-fem, plane strain, clamped below, a crown above."""

import numpy as np
import skfem
import skfem.models.elasticity as elasticity
import thirdbody


class Rail(thirdbody.Modal):
    kind = "modes"
    software = f"scikit-fem {skfem.__version__}"
    outward = {"top": (0.0, 1.0)}

    def __init__(self, config, setting):
        super().__init__(config, setting)
        self.modes = config.integer("modes", above=0)
        x, y, quads = thirdbody.crowned_grid(config)
        mesh = skfem.MeshQuad(np.stack([x.reshape(-1), y.reshape(-1)]), quads.T)
        basis = skfem.Basis(mesh, skfem.ElementVector(skfem.ElementQuad1()), intorder=3)
        lame = elasticity.lame_parameters(config.number("young_pa", above=0), config.number("poisson"))
        stiffness = setting.thickness_m * elasticity.linear_elasticity(*lame).assemble(basis)
        # A quarter of each element at each of its corners.
        across = mesh.p[:, quads[:, 2:]] - mesh.p[:, quads[:, :2]]
        quarter = 0.125 * (across[0, :, 0] * across[1, :, 1] - across[1, :, 0] * across[0, :, 1])
        mass = np.empty(basis.N)
        mass[basis.nodal_dofs] = setting.thickness_m * np.bincount(quads.reshape(-1), np.repeat(quarter, 4))
        free = basis.complement_dofs(basis.get_dofs(nodes=np.arange(x.shape[1])))
        self.stiffness, self.mass = stiffness[free][:, free], config.number("density_kg_per_m3", above=0) * mass[free]
        top = np.arange(x.size)[-x.shape[1] :]
        self.x, self.y, self.coupled = x[-1], y[-1], np.searchsorted(free, basis.nodal_dofs[:, top].T.reshape(-1))


thirdbody.participate(Rail)
