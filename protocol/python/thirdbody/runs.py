"""Runs from Python: starting them, and reading their results."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import warnings
from concurrent.futures import ThreadPoolExecutor
from functools import cached_property
from pathlib import Path
from typing import Any, Callable, Dict, List, Mapping, Optional, Sequence, Tuple, Union

import numpy as np

from .exchange import Interface, read_interface
from .fields import Fields
from .program import find_program
from .table import Results, Table, read_table

#: Called with each progress object of the program.
Progress = Callable[[Dict[str, Any]], None]


class SuspectRun(UserWarning):
    """A run that completed with an implausible result."""


class RunError(Exception):
    """A run that did not complete; `code` is its exit code (the manual, page `reference/errors`), `run` its directory, if there is one."""

    def __init__(self, message: str, code: int, run: Optional[Run] = None) -> None:
        super().__init__(message)
        self.code = code
        self.run = run


class Run:
    """A run directory. A run that was killed or still runs has the files that it has written so far; its `status` is `unfinished`."""

    def __init__(self, path: Union[str, Path]) -> None:
        #: Its folder; the target of `runs/latest` at the time of opening.
        self.path = Path(path).resolve()
        if not self.path.is_dir():
            raise FileNotFoundError(f"{path} is not a folder: give a run directory, such as runs/latest")
        if not (self.path / "manifest.json").is_file() and not (self.path / "summary.json").is_file():
            raise FileNotFoundError(f"{path} holds neither summary.json nor manifest.json: it is not a run directory")

    @cached_property
    def summary(self) -> Dict[str, Any]:
        """The file summary.json; empty while the run has not ended."""
        path = self.path / "summary.json"
        return _json(path) if path.is_file() else {}

    @property
    def status(self) -> str:
        """`completed`, `suspect`, or how else it ended; `unfinished` if it was killed or still runs."""
        return str(self.summary.get("status", "unfinished"))

    @property
    def trusted(self) -> bool:
        """True for a run that completed and is not suspect."""
        return self.status == "completed"

    @property
    def results(self) -> Dict[str, float]:
        """Results by name, unit in the name."""
        return Results(self._ended("results"))

    @property
    def warnings(self) -> List[Dict[str, Any]]:
        """Implausible results: `code`, `where`, `text`, and `value` and `bound` if the check has them."""
        return list(self._ended("warnings"))

    @cached_property
    def manifest(self) -> Dict[str, Any]:
        """The file manifest.json: versions, seed, threads, host."""
        return _json(self._file("manifest.json"))

    @cached_property
    def scenario(self) -> Dict[str, Any]:
        """The file scenario.toml: all keys of the run, overrides included."""
        return read_toml(self._file("scenario.toml"))

    @property
    def participants(self) -> List[str]:
        """Names of the participants, in the order of the scenario."""
        return [str(one["name"]) for one in self.scenario["participant"]]

    @property
    def interfaces(self) -> List[str]:
        """Names of the interfaces; empty for a solver that ran alone."""
        return [str(one["name"]) for one in self.scenario.get("interface", [])]

    @cached_property
    def signals(self) -> Table:
        """Columns of signals.csv by name, `t_s` first; `signals.to_pandas()` is a DataFrame."""
        return self.table("signals.csv")

    @property
    def profile(self) -> Table:
        """Columns of profile.csv: traction along the contact at the end of the hold or of the run."""
        profiles = sorted(path.stem[len("profile-") :] for path in self.path.glob("profile-*.csv"))
        if profiles and not (self.path / "profile.csv").is_file():
            raise FileNotFoundError(f"{self.path} has a profile of each interface: profile_of(name), names: {', '.join(profiles)}")
        return self.table("profile.csv")

    def profile_of(self, interface: str) -> Table:
        """The profile of one of several interfaces."""
        return self.table(f"profile-{interface}.csv")

    def interface(self, name: Optional[str] = None) -> Interface:
        """The exchange at an interface, window by window, from exchange.mcap; a single interface needs no name."""
        known = self.interfaces
        if name is None and len(known) == 1:
            name = known[0]
        if name not in known:
            named = f"interfaces: {', '.join(known)}" if known else "its one solver ran alone"
            raise KeyError(f"{self.path} has no interface `{name}`; {named}")
        log = self.path / "exchange.mcap"
        if not log.is_file():
            why = "run.output.exchange = false switched it off" if not self._logged() else "it was removed"
            raise FileNotFoundError(f"{log} is missing: {why}; run the scenario again with run.output.exchange = true")
        joined = next(one for one in self.scenario["interface"] if one["name"] == name)
        # A set's name has no dot; a participant's name may have one.
        between = [str(end).rpartition(".")[0] for end in joined["between"]]
        return read_interface(log, name, between)

    def fields(self, participant: Optional[str] = None) -> Fields:
        """The moments at which a participant wrote its fields; a single participant needs no name."""
        known = self.participants
        if participant is None and len(known) == 1:
            participant = known[0]
        if participant not in known:
            raise KeyError(f"{self.path} has no participant `{participant}`; participants: {', '.join(known)}")
        return Fields(self.path, participant)

    def report(self, *, movie: bool = False, compare: Optional[Union[str, Path, Run]] = None, program: Optional[str] = None) -> Path:
        """Draws the run, over the run `compare` if given, or writes its movie, and returns the page."""
        command = [_program(program), "report", str(self.path), "--quiet"] + (["--movie"] if movie else [])
        if compare is not None:
            command += ["--compare", str(compare.path if isinstance(compare, Run) else compare)]
        _done(command)
        return self.path / ("movie.html" if movie else "report.html")

    def resume(self, *, out: Optional[Union[str, Path]] = None, threads: Optional[int] = None, program: Optional[str] = None,
               progress: Optional[Progress] = None) -> Run:
        """Resumes a run that was interrupted or killed, in a new folder."""
        return _run(["resume", str(self.path)], out, threads, program, progress)

    def table(self, name: str) -> Table:
        """Columns of a table of the run: numbers if all values of a column are numbers, texts otherwise."""
        return read_table(self._file(name))

    def frame(self, name: str = "signals.csv") -> Any:
        """A table of the run as a pandas DataFrame."""
        return self.table(name).to_pandas()

    def _logged(self) -> bool:
        return bool(self.scenario["run"].get("output", {}).get("exchange", True))

    def _file(self, name: str) -> Path:
        path = self.path / name
        if not path.is_file():
            there = ", ".join(sorted(one.name for one in self.path.iterdir()))
            raise FileNotFoundError(f"{path} is missing; status of the run: {self.status}; its files: {there}")
        return path

    def _ended(self, key: str) -> Any:
        if not self.summary:
            raise ValueError(f"{self.path} has no {key}: it was killed or still runs, `thirdbody resume` continues it; signals and fields can be read")
        return self.summary[key]

    def __repr__(self) -> str:
        return f"Run({str(self.path)!r}, {self.status})"


def _json(path: Path) -> Dict[str, Any]:
    try:
        return dict(json.loads(path.read_text(encoding="utf-8")))
    except ValueError as error:
        raise ValueError(f"{path} is not JSON: {error}; it is damaged") from error


def read_toml_text(text: str) -> Dict[str, Any]:
    """The keys in a TOML text."""
    try:
        import tomllib
    except ImportError:
        try:
            import tomli as tomllib
        except ImportError as error:
            raise ImportError("to read TOML: Python 3.11 or newer, or pip install tomli") from error
    return dict(tomllib.loads(text))


def read_toml(path: Path) -> Dict[str, Any]:
    """The keys in a TOML file."""
    try:
        return read_toml_text(path.read_text(encoding="utf-8"))
    except ValueError as error:
        raise ValueError(f"{path} is not TOML: {error}; it is damaged") from error


def load(run_dir: Union[str, Path]) -> Run:
    """Opens a run directory: `load("runs/latest")`. Its parts are read on first use."""
    return Run(run_dir)


class Study:
    """The folder of a study: its runs and their measures."""

    def __init__(self, path: Union[str, Path]) -> None:
        self.path = Path(path).resolve()
        results = self.path / "results.csv"
        if not results.is_file():
            raise FileNotFoundError(f"{path} holds no results.csv: give the folder of a study, such as runs/study-NAME, after `study collect`")
        #: A row for each run: keys by their names, `value_<measure>`, costs, `warnings` and, with a reference, `error_<measure>`.
        self.table = read_table(results)

    def values(self, measure: str) -> np.ndarray:
        """The values of a measure in all runs, in the order of the table; NaN where it is missing."""
        return self.table.column(f"value_{measure}")

    def run(self, row: int) -> Run:
        """The run of a row."""
        return Run(self.path / "tasks" / str(self.table["id"][row]) / "run")

    def __repr__(self) -> str:
        return f"Study({str(self.path)!r}, {len(self.table['id'])} rows)"


def load_study(folder: Union[str, Path]) -> Study:
    """Opens the folder of a study: `load_study("runs/study-friction")`."""
    return Study(folder)


def study(file: Union[str, Path], set: Optional[Mapping[str, Any]] = None, *, small: bool = False, out: Union[str, Path],
          jobs: Optional[int] = None, program: Optional[str] = None, progress: Optional[Progress] = None) -> Study:
    """Does all runs of a study that are not done yet, and opens its folder."""
    command = [_program(program), "study", "run", str(file), "--out", str(out)] + _keys(set) + (["--small"] if small else [])
    if jobs is not None:
        command += ["--jobs", str(jobs)]
    _done(command, progress)
    return Study(out)


def run(
    scenario: Union[str, Path],
    set: Optional[Mapping[str, Any]] = None,
    *,
    out: Optional[Union[str, Path]] = None,
    exist: str = "new",
    threads: Optional[int] = None,
    program: Optional[str] = None,
    progress: Optional[Progress] = None,
) -> Run:
    """Runs a scenario and returns its run directory. `set` overrides keys; `program` is `thirdbody`, by default from the environment
    variable THIRDBODY, of the same wheel, or on PATH. A suspect run is returned with a `SuspectRun` warning (`run.trusted` is False); a
    run that ended in an error raises `RunError`.

    If `out` already holds a run, `exist` decides: `new` refuses, `replace` removes it first, and `keep` returns it if it completed and
    has the same scenario and keys. `progress` is called with each progress object of the program (the manual, "Progress for
    programs")."""
    if exist not in ("new", "replace", "keep"):
        raise ValueError(f"exist={exist!r}: it is \"new\", \"replace\" or \"keep\"")
    if exist != "new":
        if out is None:
            raise ValueError(f"exist={exist!r} needs out=, the folder of the run")
        if Path(out).is_dir() and any(Path(out).iterdir()):
            there = Run(out)
            if exist == "keep":
                return _kept(there, scenario, set or {})
            shutil.rmtree(there.path)
    return _run(["run", str(scenario)] + _keys(set), out, threads, program, progress)


def sweep(
    scenario: Union[str, Path],
    sets: Sequence[Mapping[str, Any]],
    *,
    out: Union[str, Path],
    exist: str = "new",
    jobs: Optional[int] = None,
    program: Optional[str] = None,
) -> List[Run]:
    """Runs a scenario with each of these overrides, `jobs` at a time on one thread each (by default one job per core), in
    `out`/0, `out`/1 and so on. Raises the first `RunError` once all have ended; the other runs are in their folders."""
    def one(number: int) -> Union[Run, RunError]:
        try:
            return run(scenario, sets[number], out=Path(out) / str(number), exist=exist, threads=1, program=program)
        except RunError as error:
            return error

    with ThreadPoolExecutor(jobs or os.cpu_count()) as pool:
        ended = list(pool.map(one, range(len(sets))))
    for end in ended:
        if isinstance(end, RunError):
            raise end
    return [end for end in ended if isinstance(end, Run)]


class Seeds:
    """Runs of a scene that differ by their seeds: `runs`, and `means`, of each result its mean, half of the 95 % interval and values."""

    def __init__(self, folder: Union[str, Path]) -> None:
        self.path = Path(folder)
        ensemble = _json(self.path / "means.json")
        self.runs: List[Run] = [Run(Path(run["path"])) for run in ensemble["runs"] if run["exit_code"] == 0]
        self.means: Dict[str, Dict[str, Any]] = ensemble["results"]


def seeds(scenario: Union[str, Path], count: int, set: Optional[Mapping[str, Any]] = None, *, out: Union[str, Path],
          program: Optional[str] = None, progress: Optional[Progress] = None) -> Seeds:
    """Runs a scene under `count` seeds, from its own on, side by side on the cores. The folder `out` may have some of them already. Runs
    that fail or are suspect are left out, with a `SuspectRun` warning."""
    command = [_program(program), "run", str(scenario), "--seeds", str(count), "--out", str(out), "--json"] + _keys(set)
    _done(command, progress, (0, 8))
    ensemble = Seeds(out)
    if len(ensemble.runs) < count:
        warnings.warn(f"{out}: {len(ensemble.runs)} of {count} runs completed and can be trusted", SuspectRun, stacklevel=2)
    return ensemble


def _kept(run: Run, scenario: Union[str, Path], keys: Mapping[str, Any]) -> Run:
    """The run, if it completed and has this scenario with these keys."""
    changed = {key: read_toml_text(f"value = {new}")["value"] for key, (_, new) in run.manifest["changed"].items()}
    wanted = {key: read_toml_text(f"value = {toml_value(value)}")["value"] for key, value in keys.items()}
    wanted = {key: value for key, value in wanted.items() if key in changed or _at(run.scenario, key) != value}
    made_of = str(run.manifest["scenario_file"]).replace(" (built in)", "")
    file = Path(made_of)
    places = (Path(scenario), Path(scenario) / "scenario.toml", Path("scenarios") / scenario / "scenario.toml")
    same = made_of == str(scenario) or file.resolve() in [place.resolve() for place in places]
    newer = file.is_file() and file.stat().st_mtime > (run.path / "manifest.json").stat().st_mtime
    if run.status in ("completed", "suspect") and same and not newer and changed == wanted:
        return _judged(run)
    why = f"it is of {made_of}, changed by {changed}, {run.status}" + (", and its scenario is newer" if newer else "")
    raise FileExistsError(f"{run.path} holds another run: {why}; take exist=\"replace\", or another folder")


def _at(keys: Any, path: str) -> Any:
    """The value at a dotted key; the name of a participant or interface picks it in its list."""
    for part in path.split("."):
        keys = {one["name"]: one for one in keys} if isinstance(keys, list) else keys
        keys = keys.get(part) if isinstance(keys, dict) else None
    return keys


def _judged(run: Run) -> Run:
    if not run.trusted:
        texts = "; ".join(str(one["text"]) for one in run.warnings)
        warnings.warn(f"{run.path} is {run.status}: {texts}", SuspectRun, stacklevel=4)
    return run


def _program(program: Optional[str]) -> str:
    found = find_program(program)
    if found is None:
        raise FileNotFoundError("no program `thirdbody` beside this Python or on PATH: give program=, or its path in THIRDBODY")
    return found


def _keys(keys: Optional[Mapping[str, Any]]) -> List[str]:
    return [word for key, value in (keys or {}).items() for word in ("--set", f"{key}={toml_value(value)}")]


def _done(command: List[str], progress: Optional[Progress] = None, fine: Sequence[int] = (0,)) -> Tuple[int, str]:
    """Runs a command; returns its exit code and its message on stderr, or raises `RunError`."""
    if progress is None:
        done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, encoding="utf-8", errors="replace")
        code, said = done.returncode, done.stderr.strip()
    else:
        said = ""
        with subprocess.Popen(command + ["--json-lines"], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, encoding="utf-8", errors="replace") as child:
            for line in child.stderr or ():
                event = json.loads(line)
                said = str(event.get("text", said))
                progress(event)
        code = child.returncode
    if code not in fine:
        raise RunError(said, code)
    return code, said


def _run(words: List[str], out: Optional[Union[str, Path]], threads: Optional[int], program: Optional[str], progress: Optional[Progress]) -> Run:
    command = [_program(program)] + words + ["--json"]
    if out is not None:
        command += ["--out", str(out)]
    if threads is not None:
        command += ["--threads", str(threads)]
    code, said = _done(command, progress, range(-256, 256))
    place = Path(out) if out is not None else Path("runs") / "latest"
    left = Run(place.resolve()) if (place / "summary.json").is_file() else None
    if code not in (0, 8) or left is None:
        raise RunError(left.summary["message"] if left is not None and left.summary["message"] else said, code, left)
    return _judged(left)


def toml_value(value: Any) -> str:
    """A value in TOML."""
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
