"""The built program, for tests."""

import os
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[3]
PROGRAM = os.environ.get("THIRDBODY") or str(ROOT / "target" / "release" / "thirdbody")


class Program(unittest.TestCase):
    """Tests in their own folder; `python3` is the Python that runs them."""

    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.work = Path(cls.folder.name)
        (cls.work / "bin").mkdir()
        (cls.work / "bin" / "python3").symlink_to(sys.executable)
        os.environ["PATH"] = f"{Path(sys.executable).parent}:{cls.work / 'bin'}:{os.environ['PATH']}"
        if not Path(PROGRAM).is_file():
            raise AssertionError(f"{PROGRAM} is missing: cargo build --release --bin thirdbody")

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def start(self, *words):
        """Runs a subcommand that may fail."""
        return subprocess.run([PROGRAM, *map(str, words)], cwd=self.work, capture_output=True, text=True)

    def verb(self, *words):
        """Runs a subcommand that must succeed."""
        done = self.start(*words)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        return done
