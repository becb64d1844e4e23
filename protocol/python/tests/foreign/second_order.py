"""Rails in equilibrium with curved second-order elements, under the layer of `quick`."""

import json
import os

import numpy as np
from adapters import FOREIGN, SCENARIOS, adapter
from program import PROGRAM

import thirdbody
from thirdbody.config import Config

END = {"run.end_s": 9.1e-4}

#: The run ends before the wheel's motion, which gives a warning.
EARLY = ["unreached"]

#: The settlement (m) of a rail with elements of 0.2 mm; elements of 0.4 mm give 102.4142 um, bilinear ones of 0.4 mm 101.922 (-0.48 %).
SETTLEMENT_M = 102.4177e-6


def settled(module, order, size, columns, rows):
    """Mean settlement (m), weighted by the pressure, below an elliptic pressure of 8 kN on 6.4 mm."""
    config = Config({
        "order": order, "size_m": size,
        "crown_radius_m": 0.3, "width_m": 65e-3, "height_m": 20e-3, "fine_width_m": 22.4e-3, "fine_depth_m": 1.6e-3,
        "side_columns": columns, "depth_rows": rows, "young_pa": 102.5e9, "poisson": 0.3,
    })
    rail = module.Rail(config, thirdbody.Setting("rail", 1, 1e-3, 1, None))
    s = 3.2e-3 * (np.arange(20000) + 0.5 - 10000) / 10000
    load = np.sqrt(1.0 - (s / 3.2e-3) ** 2)
    load *= 8000.0 / load.sum()
    # The coupler's interpolation: hats between the nodes.
    right = np.searchsorted(rail.x, s)
    share = (s - rail.x[right - 1]) / (rail.x[right] - rail.x[right - 1])
    force = np.zeros((rail.x.size, 2))
    np.add.at(force[:, 1], right - 1, -load * (1.0 - share))
    np.add.at(force[:, 1], right, -load * share)
    sunk = rail.step(rail.rest(), force, 1)["u"][:, 1]
    return rail, -float(np.interp(s, rail.x, sunk) @ load) / 8000.0


class SecondOrder:
    """The tests of the rail in the folder `code` of a subclass."""

    code = ""

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        os.environ["OMP_NUM_THREADS"] = "1"
        cls.scene = FOREIGN / cls.code
        cls.rail = thirdbody.run(cls.scene, {**END, "run.checkpoint_every_windows": 700}, out=cls.work / "rail", program=PROGRAM)

    def test_it_carries_the_layer_as_the_built_in_rail_does(self):
        quick = thirdbody.run(SCENARIOS / "quick", END, out=self.work / "quick", program=PROGRAM)
        for run in (self.rail, quick):
            self.assertEqual((run.status, [warning["code"] for warning in run.warnings]), ("completed", EARLY))
        # Measured: 0.10 % (the built-in elements are too stiff by 0.17 %, these by 0.08 %) and 0.008 % (one rail is dynamic).
        for result, bound in (("approach_m", 2e-3), ("interface_force_n", 2e-4)):
            self.assertAlmostEqual(self.rail.results[result] / quick.results[result], 1.0, delta=bound, msg=result)
        said = json.loads(self.verb("compare", "rail", "quick", "--bin-m", "1e-3", "--json").stdout)
        # Measured: 0.5 %, for a loose layer; the nodes are equally far apart.
        self.assertLess(said["profile"]["pressure_pa"]["l2_rel"], 0.015)
        self.assertLess(self.rail.summary["participants"]["rail"]["interface_work_rel"], 1e-12)

    def test_it_repeats_and_resumes_every_bit(self):
        self.assert_repeats(self.rail)

    def test_it_breaks_no_rule(self):
        # All 23 applicable rules hold, in a minute or more. This tests only the rule about rail.py's own part, its columns: each rule
        # starts the rail anew, with seconds of imports and set-up.
        done = self.start("conform", "--scenario", self.scene, "--participant", "rail", "--only", "columns")
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertGreaterEqual(done.stdout.count(" holds "), 6, done.stdout)

    def test_the_error_of_second_order_elements_falls_with_the_third_power_of_their_size(self):
        module, errors = adapter(self.scene / "rail.py"), []
        for size, columns, rows in ((1.6e-3, 5, 3), (0.8e-3, 10, 5), (0.4e-3, 20, 10)):
            rail, sunk = settled(module, 2, size, columns, rows)
            errors.append(abs(sunk / SETTLEMENT_M - 1.0))
            # The crown is the circle at the middles of the edges, too.
            np.testing.assert_allclose(np.hypot(rail.x, rail.y + 0.3), 0.3, rtol=1e-14)
            self.assertLess(np.abs(rail.compliance - rail.compliance.T).max(), 1e-12 * rail.compliance.max())
        self.assertLess(errors[1], 5e-4)
        self.assertGreater(errors[0] / errors[1], 4.0)
        self.assertGreater(errors[1] / errors[2], 4.0)

    def test_the_error_names_a_killed_rail(self):
        self.assert_kill_is_named(self.scene, "rail.py", "rail")
