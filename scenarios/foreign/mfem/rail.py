"""A rail in equilibrium by MFEM: quadrilaterals of any order under a curved crown, plane strain, clamped below.

Shape and displacement have the same order: all nodes of the crown lie on the circle.

To the coupler the surface consists of straight lines between the exchanged nodes, inner nodes of edges included. So a force on a node
stands for a traction that falls to zero at both neighbours, and the rail must apply this traction. As nodal forces, a uniform pressure
would be 1/2 : 1/2 at corners and middles, where biquadratic elements need 1/3 : 2/3 (the surface would be wavy by 3 %).
"""

import mfem
import mfem.ser as mf
import numpy as np
import thirdbody
from scipy.sparse import csr_matrix
from scipy.sparse.linalg import splu


class Rail(thirdbody.LinearEquilibrium):
    kind = "mfem"
    software = f"MFEM by PyMFEM {mfem.__version__}"
    outward = {"top": (0.0, 1.0)}

    def __init__(self, config, setting):
        super().__init__(config, setting)
        order = config.integer("order", above=0)
        young, poisson = config.number("young_pa", above=0), config.number("poisson")
        x, y, _ = thirdbody.crowned_grid(config, order)
        # Cells have unit length first, so that columns and rows identify their nodes.
        cells = [(nodes - 1) // order for nodes in x.shape[::-1]]
        mesh = mf.Mesh.MakeCartesian2D(*cells, mf.Element.QUADRILATERAL, True, *map(float, cells))
        mesh.SetCurvature(order)
        place = mesh.GetNodes().GetDataArray().reshape(-1, 2)
        column, row = (np.unique(np.round(along, 6), return_inverse=True)[1] for along in place.T)
        place[:] = np.stack([x[row, column], y[row, column]], axis=1)
        space = mf.FiniteElementSpace(mesh, mf.H1_FECollection(order, 2), 2, mf.Ordering.byVDIM)
        shear = young / (2.0 * (1.0 + poisson))
        lame = mf.ConstantCoefficient(2.0 * shear * poisson / (1.0 - 2.0 * poisson)), mf.ConstantCoefficient(shear)
        form = mf.BilinearForm(space)
        form.AddDomainIntegrator(mf.ElasticityIntegrator(*lame))
        form.Assemble()
        form.Finalize()
        matrix = form.SpMat()
        stiffness = csr_matrix((matrix.GetDataArray(), matrix.GetJArray(), matrix.GetIArray()))
        free = np.flatnonzero(np.repeat(row > 0, 2))
        top = np.flatnonzero(row == row.max())
        top = top[np.argsort(column[top])]
        self.x, self.y = place[top].T.copy()
        # Only the compliance of the upper edge: nothing else is loaded or needed.
        dofs = np.searchsorted(free, (2 * top[:, None] + [0, 1]).reshape(-1))
        nodal = self.compliance_of(splu(stiffness[free][:, free].tocsc()).solve, free.size, dofs) / setting.thickness_m
        share = np.kron(thirdbody.traction_matrix(self.x, order), np.eye(2))
        self.compliance = share @ nodal @ share.T


thirdbody.participate(Rail)
