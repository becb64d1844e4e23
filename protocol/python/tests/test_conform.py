"""`thirdbody conform` on the shipped adapters, on the output of `new-node`, and on solvers with one fault each."""

import json
import subprocess
import unittest

from program import PROGRAM, ROOT, Program
from test_runs import LAYER, STRIP

import thirdbody

FOREIGN = ROOT / "scenarios" / "foreign"

#: A whole number of windows.
END_S = 300 * 6.12e-7

#: Line of the skeleton before which the methods of a fault are inserted.
METHOD = "    def results(self, state):"
ADVANCE = "    def advance(self, window, force):\n        increment = super().advance(window, force)\n        return "

#: Faults: the skeleton's text, its replacement, the broken rule.
HARMS = [
    ("away * left,", "away * left * 1.001**self.steps,", "substeps"),
    ('return {"stored"', 'return {"work"', "balance"),
    ('state["dissipated_j"] + dissipated}', 'float("nan")}', "report"),
    ("def displacement(self, state):", "def displacement(self, state, *_):\n        return -state['u']\n\n    def other(self, state):", "passive"),
    (METHOD, "    def columns(self, window):\n        return 2.0 * super().columns(window)\n\n" + METHOD, "columns"),
    (METHOD, ADVANCE + "increment + self.displacement(self.state).reshape(-1)[self.components]\n\n" + METHOD, "increments"),
    (METHOD, ADVANCE + "(1.01 if window.iteration else 1.0) * increment\n\n" + METHOD, "repeats"),
    (METHOD, "    def restore(self, state):\n        pass\n\n" + METHOD, "checkpoint"),
]


class Conform(Program):
    def conform(self, scenario, participant, *words):
        done = self.start("conform", "--scenario", scenario, "--participant", participant, "--json", *words)
        rows = json.loads(done.stdout)["results"]
        broken = {row["rule"]: row["why"] for row in rows if row["verdict"] == "broken"}
        self.assertEqual(done.returncode, 8 if broken else 0, done.stderr)
        return broken, {row["rule"]: row["verdict"] for row in rows}

    def test_the_shipped_adapters_break_no_rule(self):
        for scenario in ("winkler", "scikit-fem"):
            broken, verdicts = self.conform(FOREIGN / scenario, "rail")
            self.assertEqual(broken, {}, scenario)
            self.assertGreaterEqual(list(verdicts.values()).count("holds"), 20, scenario)

    def test_the_error_names_the_line_that_changes_a_load_in_place(self):
        self.verb("new", "foreign/winkler", "bed")
        path = self.work / "bed" / "rail.py"
        step = "        return force / self.stiffness"
        path.write_text(path.read_text().replace(step, "        force[:] = 0.0\n" + step))
        broken, verdicts = self.conform("bed", "rail")
        self.assertEqual(list(broken), ["lives"])
        for words in ("read-only", "(rail.py, line 29: force[:] = 0.0)", "change a copy"):
            self.assertIn(words, broken["lives"])

    def test_a_layer_breaks_no_rule(self):
        folder = self.work / "springs"
        folder.mkdir()
        (folder / "springs.py").write_text(LAYER.format(stiffness="1e7"))
        (folder / "scenario.toml").write_text(STRIP.format(scheme="dual-schur"))
        broken, verdicts = self.conform("springs", "springs")
        self.assertEqual(broken, {})
        self.assertEqual(verdicts["boundary"], "holds")

    def test_a_new_solver_in_python_conforms_and_runs(self):
        self.verb("new-node", "python", "my-rail")
        self.assertEqual(self.conform("my-rail", "rail")[0], {})
        run = thirdbody.run(self.work / "my-rail", {}, program=PROGRAM, out=self.work / "my-run")
        self.assertEqual((run.status, run.warnings), ("completed", []))
        self.assertGreater(run.results["deepest_m"], 0.0)
        again = self.start("new-node", "python", "my-rail")
        self.assertEqual(again.returncode, 2, again.stderr)

    def test_a_new_solver_in_rust_conforms_and_runs(self):
        self.verb("new-node", "rust", "my-bed")
        target = ROOT / "target" / "skeleton"
        build = ["cargo", "build", "--quiet", "--release", "--manifest-path", "my-bed/Cargo.toml", "--target-dir", str(target)]
        (self.work / "my-bed" / "Cargo.lock").write_bytes((ROOT / "Cargo.lock").read_bytes())
        done = subprocess.run(build, cwd=self.work, capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        (self.work / "my-bed" / "target").symlink_to(target)
        self.assertEqual(self.conform("my-bed", "rail")[0], {})
        run = thirdbody.run(self.work / "my-bed", {}, program=PROGRAM, out=self.work / "my-bed-run")
        self.assertEqual((run.status, run.warnings), ("completed", []))
        self.verb("new-node", "python", "same")
        same = thirdbody.run(self.work / "same", {}, program=PROGRAM, out=self.work / "same-run")
        # The same bed in two languages.
        self.assertAlmostEqual(run.results["deepest_m"] / same.results["deepest_m"], 1.0, delta=1e-9)

    def test_each_fault_of_a_solver_breaks_its_rule(self):
        self.verb("new-node", "python", "harmed")
        source = self.work / "harmed" / "node.py"
        sound = source.read_text()
        for before, after, rule in HARMS:
            self.assertIn(before, sound)
            source.write_text(sound.replace(before, after))
            broken, _ = self.conform("harmed", "rail", "--only", rule)
            self.assertIn(rule, broken, (after, broken))
        source.write_text(sound)


class Offers(Program):
    """Solvers with fewer capabilities, in the runs that they allow."""

    def rail(self, name, change, interface):
        self.verb("new-node", "python", name)
        source = self.work / name / "node.py"
        for before, after in change:
            text = source.read_text()
            self.assertIn(before, text)
            source.write_text(text.replace(before, after))
        scenario = self.work / name / "scenario.toml"
        text = scenario.read_text()
        for before, after in interface:
            self.assertIn(before, text)
            text = text.replace(before, after)
        scenario.write_text(text)
        return thirdbody.run(self.work / name, {"run.end_s": END_S}, program=PROGRAM, out=self.work / f"{name}-run")

    def test_a_solver_without_a_step_takes_the_window(self):
        plain = self.rail("plain", [], [])
        change = [
            ('self.step_s = config.number("step_s", above=0)', "pass"),
            ("n * self.step_s", "self.window_s"),
        ]
        interface = [("step_s = 6.8e-8\n", ""), ("substeps = 9\n", "window_s = 6.12e-7\n")]
        run = self.rail("no-step", change, interface)
        self.assertEqual(run.status, "completed")
        self.assertEqual(run.summary["windows"], plain.summary["windows"])
        self.assertAlmostEqual(run.results["deepest_m"] / plain.results["deepest_m"], 1.0, delta=1e-6)

    def test_a_solver_that_cannot_go_back_runs_staggered(self):
        change = [('outward = {"top"', 'rollback = False\n    outward = {"top"')]
        staggered = [('"dual-schur"', '"staggered-serial"\nunsafe_window = true'), ('"stop"', '"accept"')]
        with self.assertRaisesRegex(thirdbody.RunError, "staggered-serial"):
            self.rail("once-refused", change, [])
        run = self.rail("once", change, staggered)
        self.assertIn(run.status, ("completed", "suspect"))


if __name__ == "__main__":
    unittest.main()
