"""Code that the tests of all adapters share."""

import importlib.util
import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from unittest import mock

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from program import PROGRAM, ROOT, Program  # noqa: E402

import thirdbody  # noqa: E402

SCENARIOS = ROOT / "scenarios"
FOREIGN = SCENARIOS / "foreign"


def adapter(path):
    """The module of an adapter, without taking part in a run."""
    spec = importlib.util.spec_from_file_location(f"{path.parent.name}_{path.stem}", path)
    module = importlib.util.module_from_spec(spec)
    with mock.patch.object(thirdbody, "participate", create=True):
        spec.loader.exec_module(module)
    return module


def children(pid):
    """Commands of a process's children, by process id."""
    listed = [path.read_text().split() for path in Path(f"/proc/{pid}/task").glob("*/children")]
    return {int(number): Path(f"/proc/{number}/cmdline").read_text().split("\0") for numbers in listed for number in numbers}


class Adapter(Program):
    def run_of(self, scene, keys, name, *warnings):
        run = thirdbody.run(SCENARIOS / scene, keys, out=self.work / name, program=PROGRAM)
        self.assertEqual(run.status, "completed", run.warnings)
        self.assertEqual({warning["code"] for warning in run.warnings} - {"unreached", *warnings}, set())
        return run

    def assert_repeats(self, run):
        """A run has the same bits when it is replayed, and when it resumes from a checkpoint."""
        said = self.verb("replay", run.path, "--allow-commands").stdout
        self.assertEqual(said.count("bitwise identical"), len(run.participants) + 1, said)
        resumed = f"{run.path}-resumed"
        self.verb("resume", run.path, "--allow-commands", "--out", resumed)
        self.assertEqual(thirdbody.load(resumed).summary["hashes"], run.summary["hashes"])

    def assert_kill_is_named(self, scene, program, participant):
        """A program that is killed in the middle of a run ends it, and the error names the program."""
        command = [PROGRAM, "run", str(scene), "--out", "killed"]
        run = subprocess.Popen(command, cwd=self.work, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        signals = self.work / "killed" / "signals.csv"
        while not (signals.is_file() and signals.stat().st_size > 10000):
            self.assertIsNone(run.poll(), "it ended by itself")
            time.sleep(0.05)
        (pid,) = (pid for pid, words in children(run.pid).items() if program in words)
        os.kill(pid, signal.SIGKILL)
        said = run.communicate(timeout=60)[1]
        self.assertEqual(run.returncode, 4, said)
        for words in ("lost participant", f"`{participant}`", "SIGKILL", "window"):
            self.assertIn(words, said)
