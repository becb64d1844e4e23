"""A rail by akantu: explicit dynamics with lumped masses, bilinear quadrilaterals, plane strain, clamped below, a crown above.

akantu steps by central differences, which have no damping. `damping` = b adds the built-in rail's numerical damping, Newmark's scheme
with beta = 0 and gamma = b: v' = v + h [(1-b) a + b a'] is akantu's velocity plus h (b-1/2) (a'-a); 0.5 leaves akantu's step unchanged.
The energy that a window of such steps loses, with the internal force F and the masses M, is

    (b-1/2) h sum (F'-F) (v+v')/2 - (b h^2/4) (a_end M a_end - a_start M a_start).
"""

import tempfile

import akantu
import numpy as np
import thirdbody
from scipy.sparse import diags
from scipy.sparse.linalg import eigsh

QUADS = akantu._quadrangle_4
MATERIAL = "material elastic [\n name = rail\n rho = {!r}\n E = {!r}\n nu = {!r}\n Plane_Stress = 0\n]\n"


def akantu_mesh(nodes, quads):
    """An akantu mesh from nodes (m) and quadrilaterals."""
    mesh = akantu.Mesh(2)
    mesh.addConnectivityType(QUADS)
    access = akantu.MeshAccessor(mesh)
    access.resizeNodes(len(nodes))
    access.resizeConnectivity(len(quads), QUADS)
    mesh.getNodes()[:] = nodes
    mesh.getConnectivity(QUADS)[:] = quads
    access.makeReady()
    return mesh


class Rail(thirdbody.Continuum):
    kind = "akantu"
    software = f"akantu {akantu.getVersion()}"
    outward = {"top": (0.0, 1.0)}
    step_limit_name = "stability limit sqrt(2/damping)/omega_max"

    def __init__(self, config, setting):
        super().__init__(config, setting)
        self.thickness = setting.thickness_m
        self.step_s, self.damping = config.number("step_s", above=0), config.number("damping")
        if not 0.5 <= self.damping <= 1.0:
            raise thirdbody.ConfigurationError(f"participant.config.damping: {self.damping} is not between 0.5 and 1")
        x, y, quads = thirdbody.crowned_grid(config)
        self.mesh = akantu_mesh(np.stack([x.reshape(-1), y.reshape(-1)], axis=1), quads)
        # The lowest row is clamped, the highest row coupled.
        self.free, self.top = slice(x.shape[1], None), slice(-x.shape[1], None)
        # akantu reads materials only from a file.
        with tempfile.NamedTemporaryFile("w", suffix=".dat") as file:
            moduli = config.number("young_pa", above=0), config.number("poisson")
            file.write(MATERIAL.format(config.number("density_kg_per_m3", above=0), *moduli))
            file.flush()
            akantu.parseInput(file.name)
        self.model = akantu.SolidMechanicsModel(self.mesh)
        self.model.initFull(_analysis_method=akantu._explicit_lumped_mass)
        self.model.setTimeStep(self.step_s)
        self.model.assembleMassLumped()
        self.model.getBlockedDOFs()[: x.shape[1]] = True
        # These are akantu's own arrays. Forces and masses are per metre of thickness; the internal force acts on the nodes and is -F.
        self.u, self.v, self.a = self.model.getDisplacement(), self.model.getVelocity(), self.model.getAcceleration()
        self.internal, self.external, self.mass = self.model.getInternalForce(), self.model.getExternalForce(), self.model.getMass()
        self.step_limit_s = np.sqrt(2.0 / self.damping) / self.omega_max()

    def omega_max(self):
        """The largest angular frequency (1/s). akantu's own estimate of the stable step holds only for central differences."""
        self.model.assembleStiffnessMatrix()
        stiffness = akantu.AkantuSparseMatrix(self.model.getDOFManager().getMatrix("K")).tocsr()
        scale = self.mass[self.free].reshape(-1) ** -0.5
        matrix = diags(scale) @ stiffness[-scale.size :, -scale.size :] @ diags(scale)
        return np.sqrt(eigsh(matrix, k=1, which="LA", v0=np.cos(np.arange(scale.size)), return_eigenvectors=False)[0])

    def points(self, set_name):
        x, y = self.mesh.getNodes()[self.top].T
        return thirdbody.Points(x, y, mass_kg=self.thickness * self.mass[self.top, 0])

    def rest(self):
        state = {name: np.zeros_like(self.u) for name in ("u", "v", "internal")}
        return {**state, "strain_j": 0.0, "kinetic_j": 0.0, "lost_j": 0.0}

    def step(self, state, force, n):
        h, b = self.step_s, self.damping
        # An elastic body has no other history. Its internal force is kept to avoid computing it again.
        self.u[:], self.v[:], self.internal[:] = state["u"], state["v"], state["internal"]
        self.external[self.top] = force / self.thickness
        self.a[self.free] = ((self.external + self.internal) / self.mass)[self.free]
        lost = 0.25 * b * h**2 * np.vdot(self.a, self.mass * self.a)
        for _ in range(n):
            v, a, internal = self.v.copy(), self.a.copy(), self.internal.copy()
            self.model.solveStep()
            self.v += h * (b - 0.5) * (self.a - a)
            lost += (b - 0.5) * h * 0.5 * np.vdot(internal - self.internal, v + self.v)
        lost -= 0.25 * b * h**2 * np.vdot(self.a, self.mass * self.a)
        return {
            "u": self.u.copy(), "v": self.v.copy(), "internal": self.internal.copy(),
            "strain_j": self.thickness * self.model.getEnergy("potential"),
            "kinetic_j": self.thickness * self.model.getEnergy("kinetic"),
            "lost_j": state["lost_j"] + self.thickness * float(lost),
        }

    def displacement(self, state):
        return state["u"][self.top]

    def energy(self, state):
        stored = {"strain": state["strain_j"], "kinetic": state["kinetic_j"]}
        return {"stored": stored, "dissipated": {"numerical_loss": state["lost_j"]}}


thirdbody.participate(Rail)
