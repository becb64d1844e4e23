"""The examples on real runs: `python protocol/python/tests/figures.py`, with matplotlib, and for the class `Rerun` rerun-sdk.

Not part of the main test command, which needs neither.
"""

import json
import os
import subprocess
import sys
import unittest

from program import PROGRAM, ROOT, Program

import thirdbody

EXAMPLES = ROOT / "protocol" / "python" / "examples"
#: A coarse rail, one cycle, moments every quarter cycle.
RAIL = {
    "participant.rail.config.mesh.size_m": 0.4e-3,
    "participant.rail.config.mesh.side_columns": 20,
    "participant.rail.config.mesh.depth_rows": 12,
    "participant.rail.config.wheel.cycles": 1.0,
    "run.output.fields_every_s": 8.333333333e-4,
}


def script(path, *words):
    """A script that must succeed; returns what it printed."""
    environment = {**os.environ, "THIRDBODY": PROGRAM}
    done = subprocess.run([sys.executable, str(path), *map(str, words)], env=environment, capture_output=True, text=True)
    if done.returncode:
        raise AssertionError(done.stdout + done.stderr)
    return done.stdout


class Figures(Program):
    def test_figures_with_data_are_drawn_and_the_others_are_named(self):
        from matplotlib import image

        thirdbody.run(ROOT / "scenarios" / "wheel-rail-fe-small", RAIL, out=self.work / "fe", program=PROGRAM)
        said = script(EXAMPLES / "paper_figures.py", self.work / "fe", "--out", self.work / "figures")
        drawn = sorted(path.name for path in (self.work / "figures").iterdir())
        self.assertEqual([int(name.split("-")[2]) for name in drawn], [4, 5, 6, 7, 8], said)
        for name in drawn:
            pixels = image.imread(str(self.work / "figures" / name))[..., :3]
            self.assertGreater(float(pixels.std()), 0.05, f"{name} is blank")
        for words in ("figure 1 left out: no flows", "figure 9 left out: no grains", "figure 10 left out: no grains"):
            self.assertIn(words, said)

    def test_the_notebook_runs_on_a_run_of_quick(self):
        thirdbody.run(ROOT / "scenarios" / "quick", out=self.work / "quick", program=PROGRAM)
        notebook = EXAMPLES / "first-look.ipynb"
        self.assertLess(notebook.stat().st_size, 200_000)
        cells = json.loads(notebook.read_text(encoding="utf-8"))["cells"]
        code = "\n".join("".join(cell["source"]) for cell in cells if cell["cell_type"] == "code")
        file = self.work / "first_look.py"
        file.write_text("import matplotlib\nmatplotlib.use('Agg')\n" + code + "\nprint(len(pyplot.get_fignums()), 'figures')\n")
        os.environ["RUN"] = str(self.work / "quick")
        self.addCleanup(os.environ.pop, "RUN")
        self.assertIn("3 figures", script(file))


class Rerun(Program):
    def test_a_run_becomes_a_file_that_rerun_accepts(self):
        thirdbody.run(ROOT / "scenarios" / "quick", {"run.end_s": 2e-4}, out=self.work / "short", program=PROGRAM)
        file = self.work / "short.rrd"
        script(ROOT / "scenarios" / "to_rerun.py", self.work / "short", "--save", file)
        rerun = [sys.executable, "-m", "rerun", "rrd"]
        verified = subprocess.run([*rerun, "verify", str(file)], capture_output=True, text=True)
        self.assertEqual(verified.returncode, 0, verified.stderr)
        stats = subprocess.run([*rerun, "stats", str(file)], capture_output=True, text=True).stdout
        for entity in ("/scene/rail", "/scene/third-body", "/scene/forces/layer-base", "/signals/interface_fy_n"):
            self.assertIn(entity, stats)


if __name__ == "__main__":
    unittest.main()
