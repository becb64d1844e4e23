"""The akantu rail compared with the built-in one; scenarios/foreign/akantu/scenario.toml describes how to install akantu."""

import json
import unittest

import numpy as np
from adapters import FOREIGN, Adapter

import thirdbody

LAYER = "participant.third-body.config"
RAIL = "participant.rail.config"

#: The built-in rail with the element of akantu.
SAME_ELEMENT = {f"{RAIL}.element": "q4_2x2"}
#: Contacts are solved so accurately that two runs differ only by their rails.
EXACT = {f"{LAYER}.solver.tolerance": 1e-9, f"{LAYER}.solver.max_iterations": 20000}
#: The load comes faster and is held for a shorter time than in the scene; the plausibility checks still pass.
FAST = {f"{LAYER}.wheel.ramp_s": 2e-4, f"{LAYER}.wheel.hold_s": 1.5e-4, "run.end_s": 3.6e-4}


class Akantu(Adapter):
    def assert_same(self, theirs, ours):
        # In elements that are not parallelograms masses are lumped differently, by up to 1e-6 here. Measured with damping 0.75: 1.6e-6,
        # 7e-5 (13 N across, 1 070 N down), 1.1e-7 and 3e-9. A rail whose graded rows start with another size is 3e-4 off.
        bounds = {"interface_fy_n": 1e-5, "interface_fx_n": 5e-4, "rail.strain_j": 2e-6, "rail.numerical_loss_j": 2e-8}
        for column, bound in bounds.items():
            scale = np.abs(ours.signals["rail.strain_j" if column.endswith("_j") else column]).max()
            self.assertLess(np.abs(theirs.signals[column] - ours.signals[column]).max(), bound * scale, column)
        rail = theirs.summary["participants"]["rail"]
        self.assertLess(max(rail["energy_balance_rel"], rail["interface_work_rel"]), 1e-12)

    def test_it_is_the_built_in_rail_with_the_same_element_and_repeats_every_bit(self):
        keys = {**EXACT, "run.end_s": 6e-5}
        ours = self.run_of("quick", {**keys, **SAME_ELEMENT}, "built-in")
        theirs = self.run_of("foreign/akantu", {**keys, "run.checkpoint_every_windows": 60}, "akantu")
        self.assert_same(theirs, ours)
        self.assert_repeats(theirs)

    def test_central_differences_are_the_built_in_rail_without_damping(self):
        keys = {**EXACT, "run.end_s": 3e-5}
        ours = self.run_of("quick", {**keys, **SAME_ELEMENT, f"{RAIL}.time.damping": 0.5}, "undamped")
        self.assert_same(self.run_of("foreign/akantu", {**keys, f"{RAIL}.damping": 0.5}, "central"), ours)

    def test_a_held_load_is_carried_as_by_the_built_in_rail(self):
        theirs = self.run_of("foreign/akantu", FAST, "held")
        # Measured: 3e-5, 5e-5 and 0.36 % with the same element; a contact tolerance of 2e-5 instead of 1e-4 changes the scene by
        # 7e-5, 4e-5 and 0.2 %. With the one-point element of `quick`: 9e-4, 9e-5 and 1.4 %.
        for name, keys, bounds in (("same", SAME_ELEMENT, (3e-4, 2e-4, 0.01)), ("one-point", {}, (2e-3, 5e-4, 0.03))):
            ours = self.run_of("quick", {**FAST, **keys}, name)
            compared = json.loads(self.verb("compare", "held", name, "--json").stdout)
            for result, bound in zip(("approach_m", "interface_force_n"), bounds):
                self.assertAlmostEqual(theirs.results[result] / ours.results[result], 1.0, delta=bound, msg=f"{result}, {name}")
            self.assertLess(compared["profile"]["pressure_pa"]["l2_rel"], bounds[2], name)

    def test_conform_breaks_no_rule(self):
        done = self.start("conform", "--scenario", FOREIGN / "akantu", "--participant", "rail", "--json")
        rows = json.loads(done.stdout)["results"]
        self.assertEqual({row["rule"]: row["why"] for row in rows if row["verdict"] != "holds"}.keys(), {"velocity", "heat"}, done.stdout)
        self.assertEqual((done.returncode, len(rows)), (0, 27))

    def test_a_step_that_is_too_long_is_refused(self):
        # The stability limit is 7.25e-8 s, or 8.88e-8 s without damping.
        for keys, words in (({f"{RAIL}.step_s": 7.3e-8}, "stability limit"), ({f"{RAIL}.damping": 0.4}, "not between 0.5 and 1")):
            with self.assertRaises(thirdbody.RunError) as caught:
                self.run_of("foreign/akantu", keys, f"refused-{len(words)}")
            self.assertEqual(caught.exception.code, 2)
            self.assertIn(words, str(caught.exception))

    def test_the_error_names_a_killed_rail(self):
        self.assert_kill_is_named(FOREIGN / "akantu", "rail.py", "rail")


if __name__ == "__main__":
    unittest.main()
