"""A rail in equilibrium by SfePy: biquadratic quadrilaterals under a curved crown, plane strain, clamped below.

SfePy uses straight cells. This adapter uses curved ones (isoparametric): the nine nodes of an element also define its shape, and the
nodes on the crown lie on the circle. SfePy computes all integrals over elements.

To the coupler the surface consists of straight lines between the exchanged nodes, middle nodes of edges included. So a force on a
node stands for a traction that falls to zero at both neighbours, and the rail must apply this traction. As nodal forces, a uniform
pressure would be 1/2 : 1/2 at corners and middles, where biquadratic elements need 1/3 : 2/3 (the surface would be wavy by 3 %).
"""

import numpy as np
import thirdbody
from scipy.sparse.linalg import splu
from sfepy import __version__
from sfepy.base.base import output
from sfepy.discrete import Equation, Equations, FieldVariable, Integral, Material, Problem
from sfepy.discrete.conditions import Conditions, EssentialBC
from sfepy.discrete.fem import FEDomain
from sfepy.discrete.fem.fields_nodal import H1NodalVolumeField
from sfepy.discrete.fem.mappings import FEMapping
from sfepy.mechanics.matcoefs import stiffness_from_youngpoisson
from sfepy.mesh.mesh_generators import gen_block_mesh
from sfepy.terms import Term

output.set_output(quiet=True)


class Curved(H1NodalVolumeField):
    """SfePy's nodal field on cells with the field's own curvature."""

    family_name = "curved_H1_lagrange"

    def create_mapping(self, region, integral, integration, return_mapping=True):
        points, values = self.get_qp("v", integral), self.eval_basis("v", 0, integral)
        mapping = FEMapping(self.coors, self.econn, poly_space=self.poly_space)
        return mapping.get_mapping(points.vals, points.weights, values, poly_space=self.poly_space), mapping


class Rail(thirdbody.LinearEquilibrium):
    kind = "sfepy"
    software = f"SfePy {__version__}"
    outward = {"top": (0.0, 1.0)}

    def __init__(self, config, setting):
        super().__init__(config, setting)
        x, y, _ = thirdbody.crowned_grid(config, order=2)
        # Cells have unit length first, so that columns and rows identify their nodes.
        nodes = np.array(x.shape[::-1]) // 2 + 1
        domain = FEDomain("rail", gen_block_mesh(nodes - 1, nodes, 0.5 * (nodes - 1), verbose=False))
        body = domain.create_region("body", "all")
        field = Curved("u", np.float64, "vector", body, approx_order=2)
        column, row = np.rint(2.0 * field.coors.T).astype(int)
        field.coors[:] = np.stack([x[row, column], y[row, column]], axis=1)
        u = FieldVariable("u", "unknown", field)
        v = FieldVariable("v", "test", field, primary_var_name="u")
        elastic = Material("elastic", D=stiffness_from_youngpoisson(2, config.number("young_pa", above=0), config.number("poisson")))
        term = Term.new("dw_lin_elastic(elastic.D, v, u)", Integral("i", order=4), body, elastic=elastic, v=v, u=u)
        problem = Problem("rail", equations=Equations([Equation("equilibrium", term)]))
        base = domain.create_region("base", "vertices in (y < 0.5)", "facet")
        problem.set_bcs(ebcs=Conditions([EssentialBC("clamped", base, {"u.all": 0.0})]))
        problem.time_update()
        problem.update_materials()
        stiffness = problem.equations.evaluate(mode="weak", dw_mode="matrix", asm_obj=problem.mtx_a)
        top = np.flatnonzero(row == row.max())
        top = top[np.argsort(column[top])]
        self.x, self.y = field.coors[top].T
        # Only the compliance of the upper edge: nothing else is loaded or needed.
        rows = u.eq_map.eq.reshape(-1, 2)[top].reshape(-1)
        nodal = self.compliance_of(splu(stiffness.tocsc()).solve, stiffness.shape[0], rows) / setting.thickness_m
        share = np.kron(thirdbody.traction_matrix(self.x, 2), np.eye(2))
        self.compliance = share @ nodal @ share.T


thirdbody.participate(Rail)
