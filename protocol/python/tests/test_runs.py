"""Coupled runs of the built program with participants in Python: `cargo build --release --bin thirdbody` first."""

import unittest
import warnings

import numpy as np
from program import PROGRAM, ROOT, Program

import thirdbody

WINKLER = ROOT / "scenarios" / "foreign" / "winkler"

LAYER = '''
import numpy as np
import thirdbody

class Springs(thirdbody.GrainLayer):
    """A row of points on springs that are pressed down by a ramp."""
    kind = "springs"
    outward = {{"base": (0.0, -1.0)}}
    end_s = 4e-5

    def __init__(self, config, setting):
        super().__init__(config, setting)
        self.x = np.linspace(-1.8e-3, 1.8e-3, 10)

    def points(self, set_name):
        return thirdbody.Points(self.x, 0.0 * self.x)

    def rest(self):
        return {{"u": np.zeros((10, 2)), "t": 0.0}}

    def step(self, state, velocity, window_s):
        u, t = state["u"] + window_s * velocity, state["t"] + window_s
        pressed = np.array([0.0, -1e-8 * min(t / 1e-5, 1.0)])
        return {{"u": u, "t": t}}, {stiffness} * (pressed - u)

thirdbody.participate(Springs)
'''

STRIP = '''
[run]
name = "springs-on-a-strip"
thickness_m = 1e-3

[[participant]]
name = "strip"
kind = "fem"
[participant.config]
base = "roller"
sides = "fixed_x"
mesh = {{ width_m = 4e-3, height_m = 1.2e-3, size_m = 0.4e-3 }}
material = {{ young_pa = 102.5e9, poisson = 0.3, density_kg_per_m3 = 7800.0 }}
time = {{ step_s = "auto", damping = 0.75, mass_damping_per_s = 1e6 }}

[[participant]]
name = "springs"
kind = "springs"
command = ["python3", "springs.py"]

[[interface]]
name = "join"
between = ["strip.top", "springs.base"]
scheme = "{scheme}"
substeps = 5
tolerance_rel = 1e-9
repeats_max = 50
'''


class Runs(Program):
    def test_a_bed_of_springs_carries_the_wheel_and_repeats_every_bit(self):
        keys = {"run.end_s": 2e-4, "run.checkpoint_every_windows": 100}
        run = thirdbody.run(WINKLER, keys, out=self.work / "winkler", program=PROGRAM)
        self.assertEqual(run.status, "completed", run.warnings)
        rail = run.summary["participants"]["rail"]
        self.assertLess(rail["interface_work_rel"], 1e-12)
        self.assertLess(rail["energy_balance_rel"], 0.01)
        signals = run.signals
        self.assertEqual(list(signals)[0], "t_s")
        self.assertTrue(np.all(np.diff(signals["t_s"]) > 0))
        said = self.verb("replay", "winkler", "--allow-commands").stdout
        self.assertEqual(said.count("bitwise identical"), 3, said)
        self.verb("resume", "winkler", "--allow-commands", "--out", "resumed")
        resumed = thirdbody.load(self.work / "resumed")
        self.assertEqual(resumed.summary["hashes"], run.summary["hashes"])

    def springs(self, name, stiffness, scheme="dual-schur"):
        folder = self.work / name
        folder.mkdir()
        (folder / "scenario.toml").write_text(STRIP.format(scheme=scheme))
        (folder / "springs.py").write_text(LAYER.format(stiffness=stiffness))
        return folder

    def test_a_layer_in_python_presses_a_strip_as_springs_in_series_do(self):
        # Ten springs of k, pressed by 1e-8 m, on a strip whose top sinks by F h / (M A): M = E (1 - nu) / ((1 + nu) (1 - 2 nu)).
        k, pressed = 5e7, 1e-8
        modulus = 102.5e9 * 0.7 / (1.3 * 0.4)
        strip = modulus * 4e-3 * 1e-3 / 1.2e-3
        exact = pressed / (1.0 / (10.0 * k) + 1.0 / strip)
        runs = {}
        for scheme in ("dual-schur", "velocity", "fixed-point-serial"):
            folder = self.springs(f"springs-{scheme}", k, scheme)
            runs[scheme] = run = thirdbody.run(folder, out=self.work / f"{scheme}-run", program=PROGRAM)
            self.assertEqual(run.status, "completed", run.warnings)
        for scheme, signals in [(scheme, run.signals) for scheme, run in runs.items()]:
            with self.subTest(scheme):
                self.assertAlmostEqual(-signals["interface_fy_n"][-1] / exact, 1.0, delta=1e-3)
                sinking = -signals["strip.surface_mean_uy_m"][-1]
                self.assertAlmostEqual(sinking * strip / exact, 1.0, delta=1e-3)

    def test_seeds_side_by_side_are_single_runs_with_their_mean(self):
        both = thirdbody.seeds("layer-alone", 2, {"run.seed": 4}, out=self.work / "seeds", program=PROGRAM)
        alone = thirdbody.run("layer-alone", {"run.seed": 5}, out=self.work / "fifth", program=PROGRAM)
        self.assertEqual(both.runs[1].summary["hashes"], alone.summary["hashes"])
        values = [run.results["approach_m"] for run in both.runs]
        self.assertEqual(both.means["approach_m"]["values"], values)
        self.assertAlmostEqual(both.means["approach_m"]["mean"] / np.mean(values), 1.0, delta=1e-12)

    def test_a_load_that_is_held_is_compared_with_the_force_of_the_interface(self):
        folder = self.work / "held"
        folder.mkdir()
        sampled = '    end_s = 4e-5\n    phases = [{"name": "hold", "t0_s": 2e-5, "t1_s": 4e-5, "sampled": True}]\n'
        held = "    def held_load(self, state):\n        return 1e3, 1e3\n\nthirdbody.participate"
        layer = LAYER.format(stiffness="1e7").replace("    end_s = 4e-5\n", sampled).replace("thirdbody.participate", held)
        (folder / "springs.py").write_text(layer)
        (folder / "scenario.toml").write_text(STRIP.format(scheme="dual-schur"))
        run = thirdbody.run(folder, out=self.work / "held-run", program=PROGRAM)
        self.assertEqual(run.status, "suspect")
        self.assertIn("force_balance", [warning["code"] for warning in run.warnings])

    def test_a_layer_in_python_on_a_bed_in_python(self):
        # Eleven springs k_b below the nodes, ten springs k pressed by d: (K_b + N^T k N) u = N^T k d.
        k, pressed, below = 5e7, 1e-8, 1e14 * 0.4e-3 * 1e-3
        nodes, points = np.linspace(-2e-3, 2e-3, 11), np.linspace(-1.8e-3, 1.8e-3, 10)
        shape = np.clip(1.0 - np.abs(points[:, None] - nodes) / 0.4e-3, 0.0, None)
        sunk = np.linalg.solve(below * np.eye(11) + k * shape.T @ shape, k * pressed * shape.sum(axis=0))
        folder = self.springs("two", k)
        (folder / "rail.py").write_text((WINKLER / "rail.py").read_text())
        text = (folder / "scenario.toml").read_text()
        start, end = text.index('kind = "fem"'), text.index("[[participant]]\nname = \"springs\"")
        bed = """kind = "winkler"
command = ["python3", "rail.py"]
[participant.config]
step_s = 2e-8
spacing_m = 0.4e-3
width_m = 4e-3
crown_radius_m = 1e3
stiffness_pa_per_m = 1e14
mass_kg_per_m2 = 1.5

"""
        (folder / "scenario.toml").write_text(text[:start] + bed + text[end:] + 'mapping = "linear"\n')
        run = thirdbody.run(folder, out=self.work / "two-run", program=PROGRAM)
        self.assertEqual(run.status, "completed", run.warnings)
        force = -run.signals["interface_fy_n"][-1]
        self.assertAlmostEqual(force / (below * sunk.sum()), 1.0, delta=1e-6)

    def test_a_rail_of_scikit_fem_is_the_built_in_one_in_equilibrium(self):
        runs = [
            thirdbody.run(ROOT / "scenarios" / scene, {"run.end_s": 9.1e-4}, out=self.work / scene, program=PROGRAM)
            for scene in ("quick", "foreign/scikit-fem")
        ]
        self.assertEqual([run.status for run in runs], ["completed", "completed"], runs[1].warnings)
        for result, bound in (("approach_m", 2e-3), ("interface_force_n", 1e-3)):
            ours, theirs = (run.results[result] for run in runs)
            self.assertAlmostEqual(theirs / ours, 1.0, delta=bound, msg=result)
        # The mesh of the package is the mesh of the built-in rail.
        participants = {participant["name"]: participant["config"] for participant in runs[0].scenario["participant"]}
        x, y, quads = thirdbody.crowned_grid(thirdbody.Config(participants["rail"]["mesh"]))
        own = np.stack([x.reshape(-1), y.reshape(-1)], axis=1)
        points = next(iter(runs[0].fields("rail")))["points_m"][:, :2]
        self.assertEqual(len(points), len(own))
        order, other = (np.lexsort(np.round(places, 9).T) for places in (own, points))
        self.assertLess(np.abs(own[order] - points[other]).max(), 1e-15)
        corners = own[quads]
        along, up = (corners[:, k + 1] - corners[:, k] for k in (0, 1))
        self.assertGreater((along[:, 0] * up[:, 1] - along[:, 1] * up[:, 0]).min(), 0.0)

    def test_modes_of_scikit_fem_carry_the_traction_of_the_built_in_ones(self):
        # Modes of the package move exactly over a window: the built-in ones take 900 steps in it, without numerical damping.
        rail = "participant.rail.config."
        keys = {rail + "element": "q4_2x2", rail + "reduced.modes": 50, rail + "reduced.near_m": 1.0, rail + "time.damping": 0.5}
        keys.update({rail + "time.step_s": 6.8e-10, "interface.layer-base.substeps": 900})
        runs = [
            thirdbody.run(scene, {"run.end_s": 9.1e-4, **own}, out=self.work / out, program=PROGRAM)
            for scene, own, out in (("quick-bonded", keys, "own"), (ROOT / "scenarios/foreign/scikit-fem/modes.toml", {}, "modes"))
        ]
        self.assertEqual([run.status for run in runs], ["completed", "completed"], runs[1].warnings)
        for column in ("pressure_pa", "shear_pa"):
            own, other = (np.asarray(run.profile[column]) for run in runs)
            self.assertLess(np.linalg.norm(own - other), 1e-6 * np.linalg.norm(own), column)

    def test_a_study_is_read_run_by_run(self):
        text = (
            '[study]\nname = "s"\nscenario = "layer-alone"\nset = ["participant.third-body.config.wheel.cycles=0.0"]\n'
            '[[vary]]\nkey = "participant.third-body.config.wheel.load_n"\nvalues = [4000.0, 8000.0]\n'
            '[[measure]]\nname = "approach"\nof = "results.approach_m"\n'
        )
        (self.work / "study.toml").write_text(text, encoding="utf-8")
        study = thirdbody.study(self.work / "study.toml", out=self.work / "study", program=PROGRAM)
        loads = study.table["participant.third-body.config.wheel.load_n"]
        self.assertEqual(list(loads), [4000.0, 8000.0])
        approaches = study.values("approach")
        self.assertEqual(list(approaches), [study.run(row).results["approach_m"] for row in (0, 1)])
        self.assertLess(approaches[0], approaches[1])
        with self.assertRaises(FileNotFoundError):
            thirdbody.load_study(self.work)

    def test_the_wheel_is_among_the_contacts_by_name(self):
        keys = {"participant.third-body.config.wheel.cycles": 0.0}
        run = thirdbody.run("layer-alone", keys, out=self.work / "layer", program=PROGRAM)
        field = run.fields()[-1]
        on_wheel = field["face_partner"] == "wheel"
        # The wheel is flat, so the force on it is along y. The grains of its contacts touch it.
        force = field["face_force_n"][on_wheel, 0].sum()
        self.assertAlmostEqual(force / run.signals.column("wheel_fn_n")[-1], 1.0, delta=1e-9)
        touched = field["points_m"][field["face_grain"][on_wheel], 1] + field["radius_m"][field["face_grain"][on_wheel]]
        self.assertLess(np.abs(touched + field["face_gap_m"][on_wheel] - field["face_point_m"][on_wheel, 1]).max(), 1e-12)

    def test_a_folder_that_holds_a_run_is_kept_replaced_or_refused(self):
        out, events = self.work / "cell", []
        first = thirdbody.run("quick", {"run.end_s": 2e-4}, out=out, program=PROGRAM, progress=events.append)
        self.assertTrue(first.trusted)
        self.assertEqual([one["done_rel"] for one in events if one["event"] == "progress"][-1], 1.0)
        kept = thirdbody.run("quick", {"run.end_s": 2e-4}, out=out, exist="keep", program=PROGRAM)
        self.assertEqual(kept.manifest["run_id"], first.manifest["run_id"])
        with self.assertRaisesRegex(FileExistsError, "run.end_s"):
            thirdbody.run("quick", {"run.end_s": 3e-4}, out=out, exist="keep", program=PROGRAM)
        with self.assertRaisesRegex(thirdbody.RunError, "not empty"):
            thirdbody.run("quick", {"run.end_s": 2e-4}, out=out, program=PROGRAM)
        new = thirdbody.run("quick", {"run.end_s": 2e-4}, out=out, exist="replace", program=PROGRAM)
        self.assertNotEqual(new.manifest["run_id"], first.manifest["run_id"])
        (self.work / "else").mkdir()
        (self.work / "else" / "diary.txt").write_text("not a run")
        with self.assertRaises(FileNotFoundError):
            thirdbody.run("quick", out=self.work / "else", exist="replace", program=PROGRAM)
        self.assertTrue((self.work / "else" / "diary.txt").is_file())

    def test_a_suspect_run_warns(self):
        keys = {"run.end_s": 2e-4, "run.plausible": {"energy_balance_rel": [0.0, 0.0]}}
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            run = thirdbody.run("quick", keys, out=self.work / "suspect", program=PROGRAM)
        self.assertFalse(run.trusted)
        self.assertEqual([one.category for one in caught], [thirdbody.SuspectRun])
        self.assertEqual(caught[0].filename, __file__)

    def test_a_sweep_is_its_single_runs(self):
        keys = [{"run.end_s": 2e-4, "run.seed": seed} for seed in (1, 2)]
        runs = thirdbody.sweep("quick", keys, out=self.work / "sweep", program=PROGRAM)
        alone = thirdbody.run("quick", keys[1], out=self.work / "alone", program=PROGRAM)
        self.assertEqual(runs[1].summary["hashes"], alone.summary["hashes"])
        self.assertNotEqual(runs[0].summary["hashes"], alone.summary["hashes"])
        self.assertTrue(runs[0].report(program=PROGRAM).is_file())
        with self.assertRaises(thirdbody.RunError):
            thirdbody.sweep("quick", [{"run.seed": -1}, keys[0]], out=self.work / "wrong", program=PROGRAM)
        self.assertEqual(thirdbody.load(self.work / "wrong" / "1").status, "completed")

    def test_the_error_names_a_mistake_in_the_solver(self):
        folder = self.springs("mistake", "undefined_name")
        with self.assertRaises(thirdbody.RunError) as caught:
            thirdbody.run(folder, out=self.work / "mistake-run", program=PROGRAM)
        self.assertEqual(caught.exception.code, 2)
        self.assertIn("NameError", str(caught.exception))
        log = (self.work / "mistake-run" / "logs" / "springs.log").read_text()
        self.assertIn("Traceback", log)

    def test_the_error_names_an_unknown_key(self):
        with self.assertRaises(thirdbody.RunError) as caught:
            thirdbody.run(WINKLER, {"participant.rail.config.spacing": 1.0}, out=self.work / "key", program=PROGRAM)
        self.assertEqual(caught.exception.code, 2)
        self.assertIn("`rail`", str(caught.exception))
        self.assertIn("did you mean `spacing_m`", str(caught.exception))


if __name__ == "__main__":
    unittest.main()
