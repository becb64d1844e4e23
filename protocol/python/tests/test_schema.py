"""`thirdbody check --schema`, checked by an independent validator."""

import json
import subprocess
import sys
import unittest
from pathlib import Path

import jsonschema
from program import ROOT, Program

try:
    import tomllib
except ModuleNotFoundError:
    import tomli as tomllib

SCENES = ROOT / "scenarios"


class Schema(Program):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.schema = json.loads(cls("start").verb("check", "--schema").stdout)
        cls.validator = jsonschema.Draft202012Validator(cls.schema)

    def scenes(self):
        found = sorted(path for path in SCENES.rglob("scenario.toml") if "target" not in path.parts)
        self.assertGreater(len(found), 30)
        return found

    def lint(self, path, text):
        """Runs the linter that editors use; as in an editor, the scenario's first line names the schema."""
        path.write_text(text)
        words = [Path(sys.executable).parent / "taplo", "lint", path.name]
        return subprocess.run([str(word) for word in words], cwd=path.parent, capture_output=True, text=True)

    def test_it_is_a_schema_of_its_draft(self):
        jsonschema.Draft202012Validator.check_schema(self.schema)
        self.assertIn("2020-12", self.schema["$schema"])

    def test_every_shipped_scene_follows_it(self):
        for path in self.scenes():
            faults = [fault.message for fault in self.validator.iter_errors(tomllib.loads(path.read_text()))]
            self.assertEqual(faults, [], path)

    def test_unknown_keys_and_wrong_types_do_not(self):
        text = (SCENES / "quick" / "scenario.toml").read_text()
        for right, wrong in [
            ("thickness_m = 1e-3", "thikness_m = 1e-3"),
            ("crown_radius_m = 0.3 }", "crown_radus_m = 0.3 }"),
            ("substeps = 9", 'substeps = "nine"'),
            ("friction = 0.3", "friction = -0.3"),
            ('scheme = "dual-schur"', 'scheme = "dual-shur"'),
            ("pressure_pa = 1e9", ""),
        ]:
            self.assertEqual(text.count(right), 1, right)
            scenario = tomllib.loads(text.replace(right, wrong))
            self.assertFalse(self.validator.is_valid(scenario), wrong)

    def test_the_linter_of_editors_accepts_it(self):
        (self.work / "scenario.schema.json").write_text(json.dumps(self.schema))
        text = "#:schema ./scenario.schema.json\n" + (SCENES / "quick" / "scenario.toml").read_text()
        done = self.lint(self.work / "right.toml", text)
        self.assertEqual(done.returncode, 0, done.stderr)
        done = self.lint(self.work / "wrong.toml", text.replace("thickness_m = 1e-3", "thikness_m = 1e-3"))
        self.assertNotEqual(done.returncode, 0)
        self.assertIn("thikness_m", done.stderr)
        done = self.lint(self.work / "wrong.toml", text.replace("friction = 0.3", 'friction = "x"'))
        line = 1 + text[: text.index("friction = 0.3")].count("\n")
        self.assertIn(f"wrong.toml:{line}:", done.stderr, "the mark is on the key, not on its participant")


if __name__ == "__main__":
    unittest.main()
