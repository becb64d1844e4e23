"""A rail in equilibrium by scikit-fem: bilinear quadrilaterals, plane strain, clamped below, a crown above."""

import numpy as np
import skfem
import skfem.models.elasticity as elasticity
import thirdbody
from scipy.sparse.linalg import splu


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


thirdbody.participate(Rail)
