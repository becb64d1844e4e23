"""A layer of disks under a flat wheel by the DEM of Kratos: explicit, on sub-steps of the window, with a drag on all velocities.

Kratos has no call that sets a contact's history, its shear force. `put` therefore makes the particles anew, without traces of an earlier
try, and sets as their last displacement one that stretches the new springs to those forces. The wheel is a rigid edge of Kratos that this
adapter moves. A disk is a Kratos particle that moves in the plane and turns about z, with the mass and the inertia of a disk. The
cylinders of Kratos move in the same way, but do not report the work of friction.
"""

import importlib.metadata
import os
import types

# The bits of a sum must not depend on the number of threads.
os.environ["OMP_NUM_THREADS"] = "1"
import KratosMultiphysics as Kratos  # noqa: E402
import KratosMultiphysics.DEMApplication as Dem  # noqa: E402
import numpy as np  # noqa: E402
import thirdbody  # noqa: E402
from KratosMultiphysics.DEMApplication import DEM_procedures, dem_default_input_parameters  # noqa: E402
from thirdbody.disks import turned  # noqa: E402

Kratos.Logger.GetDefaultOutput().SetSeverity(Kratos.Logger.Severity.WARNING)
SEARCHES = '{"do_search_dem_neighbours": true, "do_search_fem_neighbours": true, "RemoveBallsInitiallyTouchingWalls": false}'
#: More than the approach of disks and wheel in a window (m): neighbours are searched once per window.
MARGIN_M = 3e-7


class Grains(thirdbody.DiskLayer):
    kind = "kratos-dem"
    software = f"Kratos Multiphysics {importlib.metadata.version('KratosDEMApplication')}"
    tolerance, secants, repeats_max = 1e-7, 20, 100

    def __init__(self, config, setting):
        super().__init__(config, setting)
        # The strategy keeps only addresses, so the model must live as long as this object.
        self.model, self.all = Kratos.Model(), Kratos.VariableUtils()
        parts = [self.model.CreateModelPart(name) for name in ("disks", "wheel", "contacts", "inlet", "clusters")]
        parameters = dem_default_input_parameters.GetDefaultInputParameters()
        kratos = DEM_procedures.Procedures(parameters)
        kratos.solver = types.SimpleNamespace(poisson_ratio_option=False)
        for part in parts:
            for add in (kratos.AddCommonVariables, kratos.AddSpheresVariables, kratos.AddRigidFaceVariables):
                add(part, parameters)
        self.part, wall, self.pairs, *_ = parts
        self.add_disks(wall.CreateNewProperties(3))
        self.wheel_nodes = [wall.CreateNewNode(n, 2.0 * x, self.top, 0.0) for n, x in enumerate(np.sort(self.centre[:, 0])[[0, -1]], 1)]
        wall.CreateNewCondition("RigidEdge2D2N", 1, [1, 2], wall.GetProperties(3))
        self.info = self.part.ProcessInfo
        self.info[Kratos.DOMAIN_SIZE], self.info[Dem.ROTATION_OPTION], self.info[Dem.CONTACT_MESH_OPTION] = 2, 1, 1
        self.info[Kratos.SEARCH_RADIUS_INCREMENT] = self.info[Kratos.SEARCH_RADIUS_INCREMENT_FOR_WALLS] = MARGIN_M
        settings = Dem.ExplicitSolverSettings()
        for name, part in zip(("r", "fem", "contact", "inlet", "cluster"), parts):
            setattr(settings, f"{name}_model_part", part)
        tools = Dem.ParticleCreatorDestructor(), Dem.DEM_FEM_Search(), Dem.OMP_DEMSearch(), Kratos.Parameters(SEARCHES)
        self.kratos = Dem.ExplicitSolverStrategy(settings, self.step_most_s, 10**9, 1.0, 1, *tools)

    def add_disks(self, wheel):
        """Nodes and laws of the disks."""
        self.kinds, scheme = [self.part.CreateNewProperties(number) for number in (1, 2)], Dem.SymplecticEulerScheme()
        for kind in self.kinds:
            # `put` sets mass and inertia. The modulus only makes two disks share their overlap equally.
            kind[Dem.PARTICLE_DENSITY], kind[Kratos.YOUNG_MODULUS] = 1.0, self.kn
            scheme.SetTranslationalIntegrationSchemeInProperties(kind, False)
            scheme.SetRotationalIntegrationSchemeInProperties(kind, False)
            for other in (*self.kinds, wheel):
                law = Kratos.Properties(other.Id)
                law[Dem.K_NORMAL], law[Dem.K_TANGENTIAL] = self.kn, self.kt
                law[Dem.STATIC_FRICTION] = law[Dem.DYNAMIC_FRICTION] = self.friction
                law[Dem.FRICTION_DECAY], law[Dem.COEFFICIENT_OF_RESTITUTION], law[Dem.DAMPING_GAMMA] = 0.0, 1.0, 0.0
                # Glued disks do not touch each other.
                form = Dem.DEM_D_void() if kind.Id == other.Id == 2 else Dem.DEM_D_Linear_Custom_Constants()
                form.SetConstitutiveLawInProperties(law, False)
                kind.AddSubProperties(law)
        for row, (x, y, radius) in enumerate(zip(*self.centre.T, self.radius)):
            node, glued = self.part.CreateNewNode(row + 1, x, y, 0.0), row >= self.free
            node.SetSolutionStepValue(Kratos.RADIUS, radius)
            for name in (f"{kind}VELOCITY_{axis}" for kind in ("", "ANGULAR_") for axis in "XYZ"):
                node.AddDof(getattr(Kratos, name))
                if glued or name not in ("VELOCITY_X", "VELOCITY_Y", "ANGULAR_VELOCITY_Z"):
                    node.Fix(getattr(Kratos, name))

    def get(self, variable, *axes):
        return np.array(self.all.GetSolutionStepValuesVector(self.part.Nodes, variable, 0, 3)).reshape(-1, 3)[:, axes]

    def set(self, variable, values, *axes):
        vector = np.zeros((self.count, 3))
        vector[:, axes] = values
        self.all.SetSolutionStepValuesVector(self.part.Nodes, variable, Kratos.Vector(vector.reshape(-1)), 0)

    def put(self, state, velocity, kept):
        self.all.SetCurrentPositionsVector(self.part.Nodes, Kratos.Vector(np.pad(self.centre + state["u"], [(0, 0), (0, 1)]).reshape(-1)))
        self.set(Kratos.DISPLACEMENT, state["u"], 0, 1)
        self.all.SetFlag(Kratos.TO_ERASE, True, self.part.Elements)
        self.part.RemoveElements(Kratos.TO_ERASE)
        for row in range(self.count):
            self.part.CreateNewElement("SphericParticle3D", row + 1, [row + 1], self.kinds[row >= self.free])
        self.wheel_nodes[0].Y = self.wheel_nodes[1].Y = state["height"]
        self.kratos.Initialize()
        for variable, values in ((Kratos.NODAL_MASS, self.mass), (Dem.PARTICLE_MOMENT_OF_INERTIA, self.inertia)):
            self.all.SetSolutionStepValuesVector(self.part.Nodes, variable, Kratos.Vector(values + (values == 0.0)), 0)
        self.set(Kratos.VELOCITY, np.concatenate([kept * state["v"][: self.free], velocity]), 0, 1)
        self.set(Kratos.ANGULAR_VELOCITY, kept * state["spin"][:, None], 2)
        self.set(Dem.DELTA_DISPLACEMENT, self.stretch(state), 0, 1)

    def stretch(self, state):
        """The smallest displacements d of the disks that stretch new springs to a state's shear forces: -kt (d_first - d_second) . t."""
        across = np.zeros((len(state["pairs"]), self.count + 1, 2))
        for side, disks in zip((1.0, -1.0), state["pairs"].T):
            across[np.arange(disks.size), disks] = side * turned(state["normal"])
        across, wanted = across[:, : self.count].reshape(-1, 2 * self.count), -state["shear"] / self.kt
        motion = across.T @ np.linalg.solve(across @ across.T, wanted)
        if np.abs(across @ motion - wanted).max(initial=0.0) > 1e-9 * np.abs(wanted).max(initial=0.0):
            raise thirdbody.Diverged("no motion of the disks stretches the springs to their shear forces: too many contacts per disk")
        return motion.reshape(-1, 2)

    def step(self, state, velocity, window_s):
        steps, dt, kept = self.pace(window_s)
        self.put(state, velocity, kept)
        height, speed, force, work = state["height"], kept * state["speed"], 0.0, 0.0
        # Kratos computes forces, then moves; the last step has zero length and gives a list of contacts. The trapezoidal rule gives
        # the mean force: its work is the work of the springs up to the square of the sub-step.
        for k in range(steps + 1):
            self.info[Kratos.DELTA_TIME], self.info[Dem.IS_TIME_TO_PRINT] = dt if k < steps else 0.0, k == steps
            self.kratos.SolveSolutionStep()
            wheel, base = self.get(Dem.RIGID_ELEMENT_FORCE, 0, 1), self.get(Dem.CONTACT_FORCES, 0, 1)[self.free :]
            force = force + (0.5 if k in (0, steps) else 1.0) * base
            if k < steps:
                load = self.load(state["time_s"] + (k + 0.5) * dt)
                speed += dt * (float(wheel[:, 1].sum()) - load) / self.wheel_mass
                height, work = height + dt * speed, work - load * dt * speed
                self.wheel_nodes[0].Y = self.wheel_nodes[1].Y = height
        u = self.get(Kratos.DISPLACEMENT, 0, 1)
        new = {
            "u": u, "v": self.get(Kratos.VELOCITY, 0, 1), "spin": self.get(Kratos.ANGULAR_VELOCITY, 2)[:, 0], "speed": speed,
            "height": height, "on_base": base, "on_wheel": float(wheel[:, 1].sum()), **self.contacts(u, height, self.forces(-wheel)),
        }
        friction = Dem.SphericElementGlobalPhysicsCalculator(self.part).CalculateInelasticFrictionalEnergy(self.part)
        return self.booked(new, state, window_s, work, friction), force / steps

    def forces(self, from_wheel):
        """The force on the first of each pair of neighbours, and the wheel's force on each disk."""
        self.kratos.PrepareContactElementsForPrinting()
        pairs = Kratos.TensorAdaptors.ConnectivityIdsTensorAdaptor(self.pairs.Elements)
        on_first = Kratos.TensorAdaptors.VariableTensorAdaptor(self.pairs.Elements, Dem.GLOBAL_CONTACT_FORCE)
        pairs.CollectData(), on_first.CollectData()
        numbers = [*map(tuple, (pairs.data - 1).tolist()), *((disk, self.count) for disk in range(self.count))]
        return dict(zip(numbers, [*on_first.data[:, :2], *from_wheel]))


thirdbody.participate(Grains)
