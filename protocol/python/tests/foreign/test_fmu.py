"""A vehicle from co-simulation units (FMI 2.0, 3.0, and without state) above grains and a rail. Needs the wheel fmpy and a C compiler."""

import os
import shutil
import subprocess
import sys
import unittest

import numpy as np
from adapters import FOREIGN, Adapter
from program import PROGRAM

import thirdbody

SCENE = FOREIGN / "fmu"

#: Two contacts of each of ten columns in a row; the strip below them, held laterally: E (1 - nu) / ((1 + nu) (1 - 2 nu)) A / h (N/m).
COLUMNS = 10 * 2.255e11 * 1e-3 / 2
STRIP = 102.5e9 * 0.7 / (1.3 * 0.4) * 4e-3 * 1e-3 / 8e-3

#: The vehicle's masses (kg), spring (N/m), dashpot (N s/m), load (N), ramp (s).
WHEEL, BODY, SPRING, DASHPOT, LOAD, RAMP = 1.0, 4.0, 2e7, 8e3, 2e3, 1e-3

#: The vehicle above a rigid base in a scheme with repeats.
REPEATED = {
    "participant.vehicle.config.unit": "vehicle.fmu", "interface.above.scheme": "dual-schur", "interface.above.unsafe_window": False,
}


def exact(stiffness, t):
    """z_w, v_w, z_b, v_b of the vehicle on a spring: x' = A x + b load(t), in closed form for a ramp load."""
    a = np.array([
        [0.0, 1.0, 0.0, 0.0],
        [-(stiffness + SPRING) / WHEEL, -DASHPOT / WHEEL, SPRING / WHEEL, DASHPOT / WHEEL],
        [0.0, 0.0, 0.0, 1.0],
        [SPRING / BODY, DASHPOT / BODY, -SPRING / BODY, -DASHPOT / BODY],
    ])
    values, vectors = np.linalg.eig(a)
    once = np.linalg.solve(a, np.array([0.0, 0.0, 0.0, -LOAD / RAMP / BODY]))
    twice = np.linalg.solve(a, once)
    parts = vectors * np.linalg.solve(vectors, twice)

    def ramp(s):
        moved = (np.exp(np.multiply.outer(s, values)) @ parts.T).real - np.multiply.outer(s, once) - twice
        return np.where((s > 0.0)[:, None], moved, 0.0)

    return ramp(t) - ramp(t - RAMP)


def apart(values, reference):
    """Relative L2 norm of the difference from the reference."""
    return np.linalg.norm(values - reference) / np.linalg.norm(reference)


class Fmu(Adapter):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.scene = cls.work / "fmu"
        shutil.copytree(SCENE, cls.scene, ignore=shutil.ignore_patterns("*.fmu", "__pycache__"))
        subprocess.run([sys.executable, cls.scene / "build.py"], check=True)

    def run_of(self, scene, keys, name):
        run = thirdbody.run(self.scene / scene, keys, out=self.work / name, program=PROGRAM)
        self.assertEqual((run.status, run.warnings), ("completed", []), name)
        return run

    def errors(self, run, stiffness):
        """Errors of the wheel's position, the body's position, and the force through the contact."""
        moved = exact(stiffness, run.signals["t_s"])
        force = next(name for name in ("interface_fy_n", "above.interface_fy_n") if name in run.signals)
        return (
            apart(run.signals.column("wheel_z_m"), moved[:, 0]), apart(run.signals.column("body_z_m"), moved[:, 2]),
            apart(np.abs(run.signals[force]), -stiffness * moved[:, 0]),
        )

    def test_a_vehicle_on_grains_on_a_rail_moves_as_two_masses_on_springs_do(self):
        run = self.run_of("scenario.toml", {"run.end_s": 3e-3, "run.checkpoint_every_windows": 1200}, "rail")
        # Measured: 2.3e-4, 7.0e-5, 5.1e-4, from the window, the rail's damping and its inertia.
        for error, bound in zip(self.errors(run, 1.0 / (1.0 / COLUMNS + 1.0 / STRIP)), (4e-4, 1.5e-4, 8e-4)):
            self.assertLess(error, bound)
        vehicle = run.summary["participants"]["vehicle"]
        self.assertLess(vehicle["interface_work_rel"], 1e-12)
        # The error of the Runge-Kutta method.
        self.assertLess(vehicle["energy_balance_rel"], 1e-9)
        self.assert_repeats(run)

    def test_the_error_falls_with_the_window_and_does_not_depend_on_state_or_version(self):
        found = {}
        for step in (1.2e-6, 6e-7):
            keys = {"run.end_s": 2e-3, "participant.vehicle.config.step_s": step}
            for name, more in (("stateless", {}), ("repeated", REPEATED)):
                found[name, step] = self.run_of("stateless.toml", {**keys, **more}, f"{name}-{step}")
        for name in ("stateless", "repeated"):
            # Measured: 5.5e-4, 1.5e-5, 5.5e-4, of first order in the window and of opposite signs: staggered-serial uses the force of
            # the last window, dual-schur the force at the window's end.
            wide, narrow = (self.errors(found[name, step], COLUMNS) for step in (1.2e-6, 6e-7))
            for error, half, bound in zip(wide, narrow, (8e-4, 3e-5, 8e-4)):
                self.assertLess(error, bound)
                self.assertAlmostEqual(error / half, 2.0, delta=0.05)
        keys = {"run.end_s": 2e-3, **REPEATED, "participant.vehicle.config.unit": "vehicle-3.fmu"}
        three = self.run_of("stateless.toml", keys, "three")
        for name in ("wheel_z_m", "interface_fy_n"):
            np.testing.assert_array_equal(three.signals.column(name), found["repeated", 1.2e-6].signals.column(name))

    def test_a_unit_without_state_is_refused_where_windows_are_repeated(self):
        with self.assertRaisesRegex(thirdbody.RunError, "staggered-serial"):
            keys = {"interface.above.scheme": "dual-schur", "interface.above.unsafe_window": False}
            thirdbody.run(self.scene / "stateless.toml", keys, out=self.work / "refused", program=PROGRAM)

    def test_the_units_break_no_rule(self):
        text = (self.scene / "stateless.toml").read_text()
        (self.scene / "three.toml").write_text(text.replace("vehicle-stateless", "vehicle-3").replace("staggered-serial", "dual-schur"))
        # Every rule on the first unit; on the others only rules with another code path. Each rule starts the unit anew.
        some = {"scenario": ([], 23), "stateless": (["same-bits", "balance"], 7), "three": (["checkpoint"], 6)}
        for scene, (rules, held) in some.items():
            words = [word for rule in rules for word in ("--only", rule)]
            done = self.start("conform", "--scenario", self.scene / f"{scene}.toml", "--participant", "vehicle", *words)
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
            self.assertGreaterEqual(done.stdout.count(" holds "), held, done.stdout)

    def test_the_error_names_what_the_unit_does_not_have(self):
        for key, value, word in (
            ("participant.vehicle.config.start.body_z", 1.0, "body_z is a output"),
            ("participant.vehicle.config.start.mass", 1.0, "no real variable `mass`"),
            ("participant.vehicle.config.unit", "car.fmu", "car.fmu is missing"),
        ):
            with self.assertRaisesRegex(thirdbody.RunError, word) as caught:
                thirdbody.run(self.scene, {key: value}, out=self.work / f"mistake-{word[:3]}", program=PROGRAM)
            self.assertEqual(caught.exception.code, 2)

    def test_the_start_values_of_the_description_equal_the_code(self):
        import fmpy
        import fmpy.simulation
        import fmpy.validation

        for name in ("vehicle.fmu", "vehicle-3.fmu"):
            path = str(self.scene / name)
            self.assertEqual(fmpy.validation.validate_fmu(path), [], name)
            model = fmpy.read_model_description(path)
            unit = fmpy.simulation.instantiate_fmu(fmpy.extract(path, self.work / f"{name}-files"), model, "CoSimulation")
            read = unit.getReal if name == "vehicle.fmu" else unit.getFloat64
            for variable in model.modelVariables:
                if variable.start is not None:
                    self.assertEqual(read([variable.valueReference]), [float(variable.start)], variable.name)

    def test_the_error_names_a_killed_vehicle(self):
        self.assert_kill_is_named(self.scene, "unit.py", "vehicle")


if __name__ == "__main__":
    unittest.main()
