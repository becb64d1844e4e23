"""A layer of disks under a flat wheel by YADE: explicit, on sub-steps of the window, with a drag on all velocities.

Grains, contact law and load come from the twin scene, which runs the built-in grains. A disk is a sphere that moves in the plane and
turns about z, with the mass and the inertia of a disk. YADE gets kn and kt directly, and does not compute them from moduli and radii.
"""

import functools
import glob
import math
import os
import sys

import numpy as np
import thirdbody
from thirdbody.disks import turned

os.environ["OMP_NUM_THREADS"] = "1"
# The link from dist-packages to here is broken in Debian 12.
sys.path += glob.glob("/usr/lib/*/yade-double/py")
import yade  # noqa: E402
from yade import O, utils  # noqa: E402

# YADE makes a folder for itself, which would stay if a signal ended the process.
os.rmdir(os.path.dirname(O.tmpFilename()))


def plane(vector):
    """x and y of a vector of YADE."""
    return vector[0], vector[1]


class Grains(thirdbody.DiskLayer):
    kind = "yade"
    software = f"YADE {yade.config.version}"
    secants = 8
    repeats_max = 100

    def __init__(self, config, setting):
        super().__init__(config, setting)
        friction = math.atan(self.friction)
        O.materials.append(yade.FrictMat(frictionAngle=friction))
        for row, radius in enumerate(self.radius):
            # Glued disks do not touch each other.
            O.bodies.append(utils.sphere((*self.centre[row], 0.0), radius, mask=1 if row < self.free else 3))
        O.bodies.append(utils.wall(0.0, 1, sense=-1))
        # The masses of glued disks do not count.
        masses, inertias = np.append(self.mass, self.wheel_mass), np.append(self.inertia, 0.0)
        for row, body in enumerate(O.bodies):
            body.state.mass, body.state.inertia = masses[row] or 1.0, [inertias[row] or 1.0] * 3
            body.state.blockedDOFs = "zXY" if row < self.free else "xyzXYZ"
        O.bodies[self.count].state.blockedDOFs = "xzXYZ"
        self.states = [body.state for body in O.bodies]
        same = functools.partial(yade.MatchMaker, algo="val")
        self.contact = yade.Law2_ScGeom_FrictPhys_CundallStrack(neverErase=True, traceEnergy=True)
        # Bodies move first and then interact, so that positions and forces of a state belong to one time. Boxes without margin are
        # sorted in each step, and contacts are summed in the order of their bodies: a step depends only on the state.
        O.engines = [
            yade.NewtonIntegrator(damping=0.0, warnNoForceReset=False),
            yade.ForceResetter(),
            yade.InsertionSortCollider([yade.Bo1_Sphere_Aabb(), yade.Bo1_Wall_Aabb()], verletDist=0.0, avoidSelfInteractionMask=2),
            yade.InteractionLoop(
                [yade.Ig2_Sphere_Sphere_ScGeom(), yade.Ig2_Wall_Sphere_ScGeom()],
                [yade.Ip2_FrictMat_FrictMat_FrictPhys(kn=same(val=self.kn), ks=same(val=self.kt), frictAngle=same(val=friction))],
                [self.contact],
                loopOnSortedInteractions=True,
            ),
        ]

    def rest(self):
        # Forces and torques on the bodies in YADE's next step, the wheel last.
        return {**super().rest(), "force": np.zeros((self.count + 1, 2)), "torque": np.zeros(self.count + 1)}

    def put(self, state, velocity, kept):
        """Sets YADE's state. A contact remembers its shear force, and the normal that the shear force is perpendicular to."""
        # reset() leaves forces that were not summed over threads yet.
        O.forces.f(0, sync=True)
        O.forces.reset()
        place = np.append(self.centre + state["u"], [[0.0, state["height"]]], axis=0)
        v = np.concatenate([kept * state["v"][: self.free], velocity, [[0.0, kept * state["speed"]]]])
        rows = place, v, np.append(kept * state["spin"], 0.0), state["force"], state["torque"]
        for row, (x, v, spin, force, torque) in enumerate(zip(*(values.tolist() for values in rows))):
            body = self.states[row]
            body.pos, body.vel, body.angVel = (*x, 0.0), (*v, 0.0), (0.0, 0.0, spin)
            O.forces.addF(row, (*force, 0.0))
            O.forces.addT(row, (0.0, 0.0, torque))
        for contact in O.interactions:
            if contact.isReal:
                contact.phys.shearForce = (0.0, 0.0, 0.0)
        vectors = np.stack([state["normal"], state["shear"][:, None] * turned(state["normal"])], axis=1)
        for (a, b), vector in zip(state["pairs"].tolist(), np.pad(vectors, [(0, 0), (0, 0), (0, 1)])):
            if not (O.interactions.has(a, b) and O.interactions[a, b].isReal):
                utils.createInteraction(a, b)
            contact = O.interactions[a, b]
            # Both point towards YADE's second body and act on it.
            contact.geom.normal, contact.phys.shearForce = (vector if contact.id2 == a else -vector).tolist()

    def take(self):
        """YADE's state."""
        shear = {}
        for contact in O.interactions:
            if contact.isReal:
                first, second = sorted((contact.id1, contact.id2))
                on_second_body = np.array(plane(contact.phys.shearForce))
                shear[first, second] = on_second_body if contact.id2 == first else -on_second_body
        place, v = (np.array([plane(row) for row in rows]) for rows in zip(*((body.pos, body.vel) for body in self.states)))
        spin, rows = np.array([body.angVel[2] for body in self.states]), range(self.count + 1)
        force, torque = np.array([plane(O.forces.f(row)) for row in rows]), np.array([O.forces.t(row)[2] for row in rows])
        u, height, speed = place[:-1] - self.centre, float(place[-1, 1]), float(v[-1, 1])
        return {
            "u": u, "v": v[:-1], "spin": spin[:-1], "height": height, "speed": speed, **self.contacts(u, height, shear),
            "on_wheel": float(force[-1, 1]), "on_base": force[self.free : -1], "force": force, "torque": torque,
        }

    def step(self, state, velocity, window_s):
        # YADE's own damping jumps when a grain reverses, and so would the window's answer to the motion below.
        steps, O.dt, kept = self.pace(window_s)
        self.put(state, velocity, kept)
        self.contact.initPlasticDissipation(0.0)
        # The mean force by the trapezoidal rule: its work is the work of the springs up to the square of the sub-step.
        force, work = 0.5 * state["on_base"], 0.0
        for k in range(steps):
            load = self.load(state["time_s"] + (k + 0.5) * O.dt)
            O.forces.addF(self.count, (0.0, -load, 0.0))
            O.step()
            force += [plane(O.forces.f(row)) for row in range(self.free, self.count)]
            work -= load * O.dt * self.states[self.count].vel[1]
        new = self.take()
        force -= 0.5 * new["on_base"]
        return self.booked(new, state, window_s, work, self.contact.plasticDissipation()), force / steps


thirdbody.participate(Grains)
