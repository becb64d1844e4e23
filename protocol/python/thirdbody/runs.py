"""Runs from Python: starting them, and reading what they left."""

from __future__ import annotations

import csv
import json
import os
import shutil
import subprocess
from pathlib import Path
from typing import Any, Dict, List, Mapping, Optional, Sequence, Union

import numpy as np


class RunError(Exception):
    """A run that did not complete; `code` is its exit code (README, "Exit codes"), `run` what it left, if it left anything."""

    def __init__(self, message: str, code: int, run: Optional[Run] = None) -> None:
        super().__init__(message)
        self.code = code
        self.run = run


class Run:
    """A run directory."""

    def __init__(self, path: Union[str, Path]) -> None:
        self.path = Path(path)
        summary = self.path / "summary.json"
        if not summary.is_file():
            raise FileNotFoundError(f"{self.path} holds no summary.json: it is no run directory, or its run has not ended")
        #: The file summary.json.
        self.summary: Dict[str, Any] = json.loads(summary.read_text(encoding="utf-8"))

    @property
    def status(self) -> str:
        """`completed`, `suspect`, or how else it ended."""
        return str(self.summary["status"])

    @property
    def results(self) -> Dict[str, float]:
        """Results by name, unit in the name."""
        return dict(self.summary["results"])

    @property
    def warnings(self) -> List[Dict[str, Any]]:
        """What is not plausible: `code`, `where`, `text`, and `value` and `bound` where a check has them."""
        return list(self.summary["warnings"])

    @property
    def manifest(self) -> Dict[str, Any]:
        """The file manifest.json."""
        text = (self.path / "manifest.json").read_text(encoding="utf-8")
        return dict(json.loads(text))

    def signals(self) -> Dict[str, np.ndarray]:
        """Columns of signals.csv by name, `t_s` first."""
        return self.table("signals.csv")

    def profile(self, interface: Optional[str] = None) -> Dict[str, np.ndarray]:
        """Columns of profile.csv, or of the profile of one of several interfaces."""
        return self.table("profile.csv" if interface is None else f"profile-{interface}.csv")

    def table(self, name: str) -> Dict[str, np.ndarray]:
        """Columns of a table of the run; numbers where all of a column are numbers, texts otherwise."""
        with open(self.path / name, newline="", encoding="utf-8") as file:
            rows = list(csv.reader(file))
        columns = zip(*rows[1:]) if len(rows) > 1 else [()] * len(rows[0])
        return {name: _column(values) for name, values in zip(rows[0], columns)}

    def frame(self, name: str = "signals.csv") -> Any:
        """A table of the run as a pandas DataFrame."""
        import pandas

        return pandas.DataFrame(self.table(name))

    def __repr__(self) -> str:
        return f"Run({str(self.path)!r}, {self.status})"


def _column(values: Sequence[str]) -> np.ndarray:
    try:
        return np.array([float(value) if value else np.nan for value in values])
    except ValueError:
        return np.array(values)


def load(run_dir: Union[str, Path]) -> Run:
    """Reads a run directory."""
    return Run(run_dir)


def run(
    scenario: Union[str, Path],
    set: Optional[Mapping[str, Any]] = None,
    *,
    out: Optional[Union[str, Path]] = None,
    threads: Optional[int] = None,
    program: Optional[str] = None,
) -> Run:
    """Runs a scenario and reads what it left. `set` overrides keys; `program` is `thirdbody`, by default that of the environment
    variable THIRDBODY or on PATH. A run that is suspect is returned; one that ended in an error raises `RunError`."""
    program = program or os.environ.get("THIRDBODY") or shutil.which("thirdbody")
    if program is None:
        raise FileNotFoundError("no program `thirdbody` on PATH: give program=, or its path in THIRDBODY")
    command = [program, "run", str(scenario), "--json"]
    for key, value in (set or {}).items():
        command += ["--set", f"{key}={toml_value(value)}"]
    if out is not None:
        command += ["--out", str(out)]
    if threads is not None:
        command += ["--threads", str(threads)]
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, encoding="utf-8", errors="replace")
    place = Path(out) if out is not None else Path("runs") / "latest"
    left = Run(place.resolve()) if (place / "summary.json").is_file() else None
    if done.returncode not in (0, 8) or left is None:
        said = left.summary["message"] if left is not None and left.summary["message"] else done.stderr.strip()
        raise RunError(said, done.returncode, left)
    return left


def toml_value(value: Any) -> str:
    """A value as TOML writes it."""
    if isinstance(value, (bool, np.bool_)):
        return "true" if value else "false"
    if isinstance(value, (int, np.integer)):
        return str(int(value))
    if isinstance(value, (float, np.floating)):
        return repr(float(value))
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False)
    if isinstance(value, (list, tuple, np.ndarray)):
        return "[" + ", ".join(toml_value(item) for item in value) + "]"
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{key} = {toml_value(item)}" for key, item in value.items()) + " }"
    raise TypeError(f"{value!r} cannot be a value of a scenario")
