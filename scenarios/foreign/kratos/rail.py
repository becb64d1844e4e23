"""A rail by Kratos Multiphysics: bilinear quadrilaterals of small strain, plane strain, clamped below, a crown above.

Kratos has the mesh, the elements and the material, and assembles stiffness and lumped mass. Newmark's scheme advances time, one step per
window. The force of a window is constant from its start, so the initial acceleration follows from the new force: a state consists only of
displacement and velocity.
"""

import importlib.metadata
import os

# The bits of a sum must not depend on the number of threads.
os.environ["OMP_NUM_THREADS"] = "1"
import KratosMultiphysics as Kratos  # noqa: E402
import KratosMultiphysics.StructuralMechanicsApplication as Structural  # noqa: E402
import numpy as np  # noqa: E402
import thirdbody  # noqa: E402
from KratosMultiphysics.scipy_conversion_tools import to_csr  # noqa: E402
from scipy.sparse import diags  # noqa: E402
from scipy.sparse.linalg import splu  # noqa: E402

Kratos.Logger.GetDefaultOutput().SetSeverity(Kratos.Logger.Severity.WARNING)


class Rail(thirdbody.Continuum):
    kind = "kratos-fe"
    software = f"Kratos Multiphysics {importlib.metadata.version('KratosMultiphysics')}"
    outward = {"top": (0.0, 1.0)}

    def __init__(self, config, setting):
        super().__init__(config, setting)
        self.gamma = config.number("damping")
        if not 0.5 <= self.gamma <= 1.0:
            raise thirdbody.ConfigurationError(f"participant.config.damping: {self.gamma} is not between 0.5 and 1")
        self.beta = 0.25 * (self.gamma + 0.5) ** 2
        self.model = Kratos.Model()
        self.part = self.model.CreateModelPart("rail")
        self.factors = {}
        self.read_material(config, setting.thickness_m, self.read_mesh(config))
        self.assemble()

    def read_mesh(self, config):
        x, y, quads = thirdbody.crowned_grid(config)
        # Rows from below: the lowest row is clamped, the highest row coupled.
        self.number = np.arange(1, x.size + 1).reshape(x.shape)
        self.x, self.y = x[-1], y[-1]
        self.part.AddNodalSolutionStepVariable(Kratos.DISPLACEMENT)
        for number, node_x, node_y in zip(self.number.flat, x.flat, y.flat):
            self.part.CreateNewNode(int(number), node_x, node_y, 0.0)
        for component in (Kratos.DISPLACEMENT_X, Kratos.DISPLACEMENT_Y):
            Kratos.VariableUtils().AddDof(component, self.part)
            for number in self.number[0]:
                self.part.GetNode(int(number)).Fix(component)
        return quads

    def read_material(self, config, thickness_m, quads):
        material = self.part.CreateNewProperties(1)
        material[Kratos.YOUNG_MODULUS], material[Kratos.POISSON_RATIO] = config.number("young_pa", above=0), config.number("poisson")
        material[Kratos.DENSITY], material[Kratos.THICKNESS] = config.number("density_kg_per_m3", above=0), thickness_m
        material[Kratos.CONSTITUTIVE_LAW] = Structural.LinearElasticPlaneStrain2DLaw()
        for element, nodes in enumerate((quads + 1).tolist(), 1):
            self.part.CreateNewElement("SmallDisplacementElement2D4N", element, nodes, material)

    def assemble(self):
        """Stiffness and lumped mass of the free components, by Kratos."""
        self.part.ProcessInfo[Kratos.DOMAIN_SIZE] = 2
        self.part.ProcessInfo[Kratos.COMPUTE_LUMPED_MASS_MATRIX] = True
        scheme = Structural.EigensolverDynamicScheme()
        builder = Kratos.ResidualBasedEliminationBuilderAndSolver(Kratos.LinearSolver())
        strategy = Kratos.ResidualBasedLinearStrategy(self.part, scheme, builder, False, False, False, False)
        strategy.Initialize()
        strategy.InitializeSolutionStep()
        matrix, space = strategy.GetSystemMatrix(), Kratos.SparseSpace()
        right_side = space.CreateEmptyVectorPointer()
        space.ResizeVector(right_side, space.Size1(matrix))
        built = []
        for level in (1, 2):
            self.part.ProcessInfo[Structural.BUILD_LEVEL] = level
            space.SetToZeroMatrix(matrix)
            builder.Build(scheme, self.part, matrix, right_side)
            built.append(to_csr(matrix).copy())
        self.mass, self.stiffness = built[0].diagonal(), built[1]
        top = [self.part.GetNode(int(number)) for number in self.number[-1]]
        self.top = np.array([[node.GetDof(v).EquationId for v in (Kratos.DISPLACEMENT_X, Kratos.DISPLACEMENT_Y)] for node in top])

    def points(self, set_name):
        return thirdbody.Points(self.x, self.y, mass_kg=self.mass[self.top[:, 1]])

    def rest(self):
        return {"u": np.zeros_like(self.mass), "v": np.zeros_like(self.mass), "dissipated_j": 0.0}

    def nominal(self, window_s):
        """The window length without its last digits, so that the factors serve all windows of this length."""
        return float(f"{window_s:.9e}")

    def solve(self, h, right_side):
        """(M + beta h^2 K)^-1 times `right_side`, by the factors for this window."""
        if h not in self.factors:
            matrix = (diags(self.mass) + self.beta * h**2 * self.stiffness).tocsc()
            self.factors[h] = splu(matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
        return self.factors[h].solve(right_side)

    def step(self, state, force, n):
        u, v, h = state["u"], state["v"], self.nominal(self.window_s)
        load = np.zeros_like(u)
        load[self.top] = force
        a = (load - self.stiffness @ u) / self.mass
        ahead = u + h * v + h**2 * (0.5 - self.beta) * a
        new_a = self.solve(h, load - self.stiffness @ ahead)
        new_v = v + h * ((1.0 - self.gamma) * a + self.gamma * new_a)
        # The energy that the scheme dissipates: work minus the increments of strain and kinetic energy, by algebra, not by difference.
        mean_v, mean_a, change = 0.5 * (v + new_v), 0.5 * (a + new_a), self.mass * (new_a - a)
        lost = h**2 * (self.beta - 0.5 * self.gamma) * (mean_a @ change) - h * (self.gamma - 0.5) * (mean_v @ change)
        return {"u": ahead + self.beta * h**2 * new_a, "v": new_v, "dissipated_j": state["dissipated_j"] + float(lost)}

    def displacement(self, state):
        return state["u"][self.top]

    def energy(self, state):
        strain, kinetic = 0.5 * float(state["u"] @ (self.stiffness @ state["u"])), 0.5 * float(self.mass @ state["v"] ** 2)
        return {"stored": {"strain": strain, "kinetic": kinetic}, "dissipated": {"numerical": state["dissipated_j"]}}

    def columns(self, window):
        loads = np.zeros((self.mass.size, self.components.size))
        loads[self.top.reshape(-1)[self.components], np.arange(self.components.size)] = 1.0
        h = self.nominal(window.length_s)
        ahead = h**2 * (0.5 - self.beta) * loads / self.mass[:, None]
        columns = ahead + self.beta * h**2 * self.solve(h, loads - self.stiffness @ ahead)
        return columns[self.top.reshape(-1)[self.components]]


thirdbody.participate(Rail)
