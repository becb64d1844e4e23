"""A layer of disks read from the scene of the built-in grains: contacts, stiffness, ledger, refusals."""

import math
import tempfile
import unittest
from pathlib import Path

import numpy as np

import thirdbody
from thirdbody import Config, ConfigurationError, Setting

H = math.sqrt(3.0) * 1e-3
#: Positions of disks of 1 mm, and whether they are glued: a loose one on two glued ones, one on its top, one without contact.
DISKS = [(0.0, 0.0, True), (2e-3, 0.0, True), (1e-3, H, False), (1e-3, 2e-3 + H, False), (4e-3, 2e-3, False)]
TWIN = """
[[participant]]
name = "grains"
[participant.config]
density_kg_per_m3 = 8000.0
mass_scale = 10.0
law = { kind = "coulomb", friction = 0.3, contact_stiffness_pa = 2e9, tangential_stiffness_ratio = 0.5 }
solver = { kind = "nsgs" }
wheel = { load_n = 4.0, mass_kg = 0.01, radius_m = 0.0, ramp_s = 1e-3, hold_s = 2e-3 }
sample = { kind = "disks", disks = [
"""
#: Normal and tangential stiffness (N/m), radius (m).
KN, KT, R = 2e6, 1e6, 1e-3


class Column(thirdbody.DiskLayer):
    """Symplectic Euler without friction."""

    def step(self, state, velocity, window_s):
        steps, dt, kept = self.pace(window_s)
        u, v = state["u"], np.concatenate([kept * state["v"][: self.free], velocity])
        height, speed, work, mean = state["height"], kept * state["speed"], 0.0, 0.0
        for k in range(steps):
            on_disks, on_wheel = self.forces(u, height)
            v = v + dt * np.concatenate([on_disks[: self.free] / self.mass[: self.free, None], 0.0 * velocity])
            speed += dt * (on_wheel - self.load(state["time_s"] + (k + 0.5) * dt)) / self.wheel_mass
            u, height, mean = u + dt * v, height + dt * speed, mean + on_disks[self.free :] / steps
            work -= dt * speed * self.load(state["time_s"] + (k + 0.5) * dt)
        on_disks, on_wheel = self.forces(u, height)
        new = {**state, "u": u, "v": v, "height": height, "speed": speed, **self.contacts(u, height, {})}
        new.update(on_wheel=on_wheel, on_base=on_disks[self.free :])
        return self.booked(new, state, window_s, work, 0.0), mean

    def forces(self, u, height):
        """The forces on all disks, and the force on the wheel."""
        found, force = self.contacts(u, height, {}), np.zeros((self.count + 1, 2))
        for (first, second), on_first in zip(found["pairs"], found["pressure"][:, None] * found["normal"]):
            force[first] += on_first
            force[second] -= on_first
        return force[:-1], force[-1, 1]


class Disks(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.path = Path(folder.name) / "twin.toml"

    def layer(self, disks=DISKS, participant="grains", changed=("", ""), drag_per_s=2000.0):
        rows = [f"{{ x_m = {x!r}, y_m = {y!r}, radius_m = {R!r}, glued = {str(glued).lower()} }},\n" for x, y, glued in disks]
        self.path.write_text((TWIN + "".join(rows) + "] }\n").replace(*changed))
        config = Config({"twin": str(self.path), "step_s": 1e-6, "drag_per_s": drag_per_s})
        return Column(config, Setting(participant, 1, 1e-3, 1, None))

    def test_contacts_follow_from_positions_and_radii(self):
        layer = self.layer()
        self.assertEqual((layer.count, layer.free, layer.kn, layer.kt), (5, 3, KN, KT))
        np.testing.assert_allclose(layer.mass, 8e4 * 1e-3 * math.pi * R**2 * np.array([1.0, 1.0, 1.0, 0.0, 0.0]))
        np.testing.assert_allclose(layer.inertia, 0.5 * layer.mass * R**2)
        self.assertEqual(layer.points("base").rows("base")[:, :2].tolist(), [[0.0, 0.0], [2e-3, 0.0]])
        # Loose disks come first: 0 on the glued 3 and 4, and 1 on 0 under the wheel, which is 5.
        u = np.zeros((5, 2))
        u[:2, 1] = -1e-6, -3e-6
        force = {(0, 1): (3.0, 9.0), (1, 5): (2.0, -8.0)}
        found = layer.contacts(u, layer.top - 5e-6, force)
        self.assertEqual(found["pairs"].tolist(), [[0, 1], [0, 3], [0, 4], [1, 5]])
        slope = math.sqrt(0.75)
        np.testing.assert_allclose(found["normal"], [[0.0, -1.0], [0.5, slope], [-0.5, slope], [0.0, -1.0]], atol=1e-3)
        np.testing.assert_allclose(found["pressure"], KN * np.array([2e-6, slope * 1e-6, slope * 1e-6, 2e-6]), rtol=1e-3)
        # Downwards, turned left, is to the right.
        np.testing.assert_allclose(found["shear"], [3.0, 0.0, 0.0, 2.0], atol=1e-12)

    def test_no_contact_is_missed_and_none_found_twice(self):
        places = np.random.default_rng(3).uniform(0.0, 20e-3, size=(120, 2))
        layer = self.layer([(x, y, row % 4 == 0) for row, (x, y) in enumerate(places.tolist())])
        found = layer.contacts(np.zeros((120, 2)), 19e-3, {})["pairs"].tolist()
        near = np.hypot(*(layer.centre[:, None] - layer.centre).T) < 2.0 * R
        wanted = [[a, b] for a in range(120) for b in range(a + 1, 120) if near[a, b] and a < layer.free]
        wanted += [[a, 120] for a in range(120) if layer.centre[a, 1] + R > 19e-3]
        self.assertEqual(found, sorted(wanted))
        self.assertGreater(len(found), 100)

    def test_the_tangent_includes_all_contacts_of_the_glued_disks(self):
        layer = self.layer()
        states = [layer.rest(), layer.rest()]
        for state, side in zip(states, (1e-6, -1e-6)):
            u = np.zeros((5, 2))
            u[0] = side, 0.0
            state.update(layer.contacts(u, layer.top, {}))
        self.assertEqual([state["pairs"].tolist() for state in states], [[[0, 4]], [[0, 3]]])
        tangent = layer.tangent(states, 0.5)
        np.testing.assert_allclose(tangent, tangent.T)
        # kt + (kn - kt) n n for n = (+-1/2, sqrt(3/4)), times half of the window.
        cross = 0.25 * math.sqrt(0.75) * 0.5 * (KN - KT)
        diagonal = 0.25 * (KT + (KN - KT) * np.array([0.25, 0.75, 0.25, 0.75]))
        np.testing.assert_allclose(np.diag(tangent), diagonal, rtol=1e-3)
        np.testing.assert_allclose([tangent[0, 1], tangent[2, 3], tangent[0, 2]], [cross, -cross, 0.0], rtol=1e-3)
        self.assertGreater(np.linalg.eigvalsh(tangent).min(), 0.0)

    def test_the_ledger_closes_and_the_load_is_carried(self):
        layer = self.layer()
        state, still = layer.rest(), np.zeros((2, 2))
        drag = 0.0
        for _ in range(300):
            drag += (1.0 - math.exp(-2.0 * 2000.0 * 1e-5)) * layer.kinetic(state)
            state, _ = layer.step(state, still, 1e-5)
        energy = layer.energy(state)
        work, stored = energy["work"]["wheel_load"], sum(energy["stored"].values())
        self.assertEqual(energy["dissipated"]["friction"], 0.0)
        self.assertAlmostEqual(energy["dissipated"]["drag"] / drag, 1.0, delta=1e-12)
        self.assertGreater(drag, 0.05 * work)
        # Measured: 0.08 %, half of it with half the step.
        self.assertAlmostEqual((stored + drag) / work, 1.0, delta=0.002)
        load, carried = layer.held_load(state)
        self.assertEqual(load, 4.0)
        results = layer.results(state)
        self.assertEqual(results["wheel_force_n"], carried)
        # The wheel on one disk, this on a second, this on two at 30 degrees. Measured: 0.09 % and 0.1 % apart.
        self.assertAlmostEqual(results["boundary_force_n"] / 4.0, 1.0, delta=0.005)
        self.assertAlmostEqual(results["approach_m"] / (4.0 / KN * (2.0 + 1.0 / 1.5)), 1.0, delta=0.005)

    def test_a_scene_that_it_cannot_reproduce_is_refused(self):
        for changed, words in (
            (("radius_m = 0.0", "radius_m = 0.3"), "twin: its wheel is round"),
            (('"coulomb"', '"cohesive"'), "twin: its law is not `coulomb`"),
            (("friction = 0.3", "friction = 0.3, cohesion_n = 1.0"), "twin.law.cohesion_n: no such key"),
            (("mass_scale = 10.0", "mass_scale = 10.0\nflow = {}"), "twin.flow: no such key"),
            (("glued = false", "glued = false, vx_m_per_s = 1.0"), r"twin.sample.disks\[2\].vx_m_per_s: no such key"),
            (("hold_s = 2e-3", "hold_s = 0.0"), "twin.wheel.hold_s: 0.0 is not above 0"),
        ):
            with self.assertRaisesRegex(ConfigurationError, words):
                self.layer(changed=changed)
        with self.assertRaisesRegex(ConfigurationError, "no participant `sand`"):
            self.layer(participant="sand")
        with self.assertRaisesRegex(ConfigurationError, "config.twin: .*No such file"):
            Column(Config({"twin": "missing.toml", "step_s": 1e-6, "drag_per_s": 1.0}), Setting("grains", 1, 1e-3, 1, None))


if __name__ == "__main__":
    unittest.main()
