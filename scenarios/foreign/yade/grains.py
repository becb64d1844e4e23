"""A layer of disks under a flat wheel by YADE: explicit, on sub-steps of the window, with a drag on all velocities.

Grains, contact law and load are read from the twin scene, which runs the built-in grains. A disk is a sphere that moves in the
plane and turns about z, with the mass and the inertia of a disk. Both codes have the same springs at every contact, wheel and glued
disks included, whatever the radii: kn = contact_stiffness_pa x thickness (N/m), kt = tangential_stiffness_ratio x kn, and
|shear| <= friction x normal force. YADE is given kn and kt, instead of making them from moduli and radii.
"""

import functools
import glob
import math
import os
import sys
import tomllib

import numpy as np
import thirdbody

os.environ["OMP_NUM_THREADS"] = "1"
# The link from dist-packages to here is broken in Debian 12.
sys.path += glob.glob("/usr/lib/*/yade-double/py")
import yade  # noqa: E402
from yade import O, utils  # noqa: E402

# YADE makes a folder for itself, which stays where the process is ended by a signal.
os.rmdir(os.path.dirname(O.tmpFilename()))


def plane(vector):
    """x and y of a vector of YADE."""
    return vector[0], vector[1]


class Grains(thirdbody.GrainLayer):
    kind = "yade"
    software = f"YADE {yade.config.version}"
    outward = {"base": (0.0, -1.0)}
    secants = 8
    repeats_max = 100

    def __init__(self, config, setting):
        super().__init__(config, setting)
        self.step_most_s = config.number("step_s", above=0)
        self.drag_per_s = config.number("drag_per_s", above=0)
        with open(config.get("twin"), "rb") as file:
            twin = next(p for p in tomllib.load(file)["participant"] if p["name"] == setting.participant)["config"]
        self.law, self.wheel = twin["law"], twin["wheel"]
        if self.wheel.get("radius_m") or self.wheel.get("cycles"):
            raise thirdbody.ConfigurationError("participant.config.twin: its wheel is round or moves sideways, this one cannot")
        self.end_s = self.wheel["ramp_s"] + self.wheel["hold_s"]
        self.phases = [
            {"name": "ramp", "t0_s": 0.0, "t1_s": self.wheel["ramp_s"]},
            {"name": "hold", "t0_s": self.wheel["ramp_s"], "t1_s": self.end_s, "sampled": True},
        ]
        disks = sorted(twin["sample"]["disks"], key=lambda disk: (disk.get("glued", False), disk["x_m"]))
        self.centre = np.array([[disk["x_m"], disk["y_m"]] for disk in disks])
        self.radius = np.array([disk["radius_m"] for disk in disks])
        self.free = sum(not disk.get("glued", False) for disk in disks)
        per_area = twin["density_kg_per_m3"] * twin["mass_scale"] * setting.thickness_m
        # Disks, then the wheel; glued disks have no mass.
        self.mass = np.append(per_area * math.pi * self.radius**2, self.wheel["mass_kg"])
        self.mass[self.free : -1] = 0.0
        self.inertia = np.append(0.5 * self.mass[:-1] * self.radius**2, 0.0)
        self.kn = self.law["contact_stiffness_pa"] * setting.thickness_m
        self.kt = self.law["tangential_stiffness_ratio"] * self.kn
        self.build()

    def build(self):
        """The scene of YADE; whatever moves in it is put there by `put`."""
        friction = math.atan(self.law["friction"])
        O.materials.append(yade.FrictMat(frictionAngle=friction))
        for row, radius in enumerate(self.radius):
            glued = row >= self.free
            # Glued disks do not touch each other.
            O.bodies.append(utils.sphere((*self.centre[row], 0.0), radius, mask=3 if glued else 1))
        O.bodies.append(utils.wall(0.0, 1, sense=-1))
        for row, body in enumerate(O.bodies):
            body.state.mass = self.mass[row] or 1.0
            body.state.inertia = [self.inertia[row] or 1.0] * 3
            body.state.blockedDOFs = "zXY" if row < self.free else "xyzXYZ"
        O.bodies[len(self.radius)].state.blockedDOFs = "xzXYZ"
        self.states = [body.state for body in O.bodies]
        same = functools.partial(yade.MatchMaker, algo="val")
        self.contact = yade.Law2_ScGeom_FrictPhys_CundallStrack(neverErase=True, traceEnergy=True)
        # Bodies are moved first and then meet, so that places and forces of a state are of one time. Boxes without margin are
        # sorted in each step, and contacts are summed in the order of their bodies: a step depends on the state alone.
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

    def points(self, set_name):
        x, y = self.centre[self.free :].T
        return thirdbody.Points(x, y, radius_m=self.radius[self.free :])

    def rest(self):
        top = (self.centre[:, 1] + self.radius)[: self.free].max()
        x = np.append(self.centre, [[0.0, top]], axis=0)
        nothing = np.empty((0, 2))
        return {
            "time_s": 0.0, "x": x, "v": np.zeros_like(x), "spin": np.zeros(len(x)), "force": np.zeros_like(x),
            "torque": np.zeros(len(x)), "pairs": nothing.astype(int), "normal": nothing, "shear": nothing, "pressure": np.empty(0),
            "wheel_load": 0.0, "friction": 0.0, "drag": 0.0, "held": np.zeros(4),
        }

    def put(self, state):
        """Makes a state that of YADE. A contact remembers its shear force, and the normal that this lies across."""
        # reset() leaves what was not summed over threads yet.
        O.forces.f(0, sync=True)
        O.forces.reset()
        rows = (state[name].tolist() for name in ("x", "v", "spin", "force", "torque"))
        for row, (x, v, spin, force, torque) in enumerate(zip(*rows)):
            body = self.states[row]
            body.pos, body.vel, body.angVel = (*x, 0.0), (*v, 0.0), (0.0, 0.0, spin)
            O.forces.addF(row, (*force, 0.0))
            O.forces.addT(row, (0.0, 0.0, torque))
        for contact in O.interactions:
            if contact.isReal:
                contact.phys.shearForce = (0.0, 0.0, 0.0)
        for (a, b), normal, shear in zip(*(state[name].tolist() for name in ("pairs", "normal", "shear"))):
            if not (O.interactions.has(a, b) and O.interactions[a, b].isReal):
                utils.createInteraction(a, b)
            contact = O.interactions[a, b]
            contact.geom.normal, contact.phys.shearForce = (*normal, 0.0), (*shear, 0.0)

    def take(self):
        """The state of YADE."""
        pairs, contacts = [], []
        for contact in O.interactions:
            force = contact.phys.normalForce.norm() if contact.isReal else 0.0
            if force > 0.0:
                pairs.append((contact.id1, contact.id2))
                contacts.append((*plane(contact.geom.normal), *plane(contact.phys.shearForce), force))
        pairs = np.array(pairs, dtype=int).reshape(-1, 2)
        order = np.lexsort(pairs.T[::-1])
        contacts = np.array(contacts).reshape(-1, 5)[order]
        bodies = range(len(self.states))
        return {
            "x": np.array([plane(body.pos) for body in self.states]), "v": np.array([plane(body.vel) for body in self.states]),
            "spin": np.array([body.angVel[2] for body in self.states]), "pairs": pairs[order],
            "force": np.array([plane(O.forces.f(row)) for row in bodies]),
            "torque": np.array([O.forces.t(row)[2] for row in bodies]),
            "normal": contacts[:, :2], "shear": contacts[:, 2:4], "pressure": contacts[:, 4],
        }

    def step(self, state, velocity, window_s):
        steps = math.ceil(window_s / self.step_most_s - 1e-9)
        O.dt = dt = window_s / steps
        # Drag takes its share of all velocities at once. YADE's own damping jumps where a grain turns around, and the answer
        # of a window to the motion below would, too.
        kept = math.exp(-self.drag_per_s * window_s)
        self.put({**state, "v": kept * state["v"], "spin": kept * state["spin"]})
        for body, v in zip(self.states[self.free : -1], velocity.tolist()):
            body.vel = (*v, 0.0)
        self.contact.initPlasticDissipation(0.0)
        wheel, glued = len(self.radius), range(self.free, len(self.radius))
        # The mean force by the trapezoidal rule: its work is that of the springs, but for the square of the sub-step.
        force, work = 0.5 * state["force"][self.free : -1], 0.0
        for k in range(steps):
            load = self.wheel["load_n"] * min(1.0, (state["time_s"] + (k + 0.5) * dt) / self.wheel["ramp_s"])
            O.forces.addF(wheel, (0.0, -load, 0.0))
            O.step()
            force += [plane(O.forces.f(row)) for row in glued]
            work -= load * dt * self.states[wheel].vel[1]
        new = self.take()
        force -= 0.5 * new["force"][self.free : -1]
        new["time_s"] = state["time_s"] + window_s
        new["wheel_load"] = state["wheel_load"] + work
        new["friction"] = state["friction"] + self.contact.plasticDissipation()
        new["drag"] = state["drag"] + (1.0 - kept**2) * self.kinetic(state)
        # Sums over the second half of the hold: windows, height of the wheel, force on it and on the base.
        held = new["time_s"] > self.end_s - 0.5 * self.wheel["hold_s"]
        reading = [1.0, new["x"][-1, 1], new["force"][-1, 1], new["force"][self.free : -1, 1].sum()]
        new["held"] = state["held"] + float(held) * np.array(reading)
        return new, force / steps

    def tangent(self, states, window_s):
        """Stiffness of the contacts of the glued disks, pressed half as far in the mean over a window as at its end: of all that there
        were in a repeat, as if none slid, for too much of it makes slow steps and too little a cycle."""
        touching = {}
        for state in reversed(states):
            touching.update(self.touching(state))
        stiffness = np.zeros((len(self.radius) - self.free, 2) * 2)
        for (disk, _), n in sorted(touching.items(), key=lambda contact: contact[0]):
            stiffness[disk, :, disk] += self.kt * np.eye(2) + (self.kn - self.kt) * np.outer(n, n)
        return 0.5 * window_s * stiffness.reshape(2 * len(stiffness), -1)

    def touching(self, state):
        """Normals of the contacts of glued disks, by the disk and what it touches."""
        found = {}
        for (a, b), normal in zip(state["pairs"].tolist(), state["normal"]):
            for disk, other in ((a, b), (b, a)):
                if self.free <= disk < len(self.radius):
                    found[disk - self.free, other] = normal
        return found

    def glue(self, state, displacement):
        x = state["x"].copy()
        x[self.free : -1] = self.centre[self.free :] + displacement
        return {**state, "x": x}

    def kinetic(self, state):
        return 0.5 * float(self.mass @ (state["v"] ** 2).sum(axis=1) + self.inertia @ state["spin"] ** 2)

    def energy(self, state):
        springs = 0.5 * float((state["pressure"] ** 2).sum() / self.kn + (state["shear"] ** 2).sum() / self.kt)
        return {
            "work": {"wheel_load": state["wheel_load"]},
            "stored": {"kinetic": self.kinetic(state), "springs": springs},
            "dissipated": {"friction": state["friction"], "drag": state["drag"]},
        }

    def signals(self, state):
        return {
            "wheel_y_m": state["x"][-1, 1], "wheel_fn_n": state["force"][-1, 1],
            "glued_fx_n": state["force"][self.free : -1, 0].sum(), "glued_fy_n": state["force"][self.free : -1, 1].sum(),
            "contacts": float(len(state["pairs"])), "speed_max_m_per_s": np.hypot(*state["v"][: self.free].T).max(),
        }

    def held_load(self, state):
        count, _, on_wheel, _ = state["held"]
        return (self.wheel["load_n"], on_wheel / count) if count else None

    def results(self, state):
        count, height, on_wheel, on_base = state["held"]
        if count == 0.0:
            return {}
        start = self.rest()["x"][-1, 1]
        return {"approach_m": start - height / count, "wheel_force_n": on_wheel / count, "boundary_force_n": -on_base / count}


thirdbody.participate(Grains)
