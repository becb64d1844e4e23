"""The life of a participant: session, greeting, requests and answers, farewell (protocol/WIRE.md)."""

from __future__ import annotations

import contextlib
import ctypes
import json
import os
import resource
import signal
import sys
import threading
import time
import traceback
from pathlib import Path
from typing import Any, Callable, Dict, Optional

import numpy as np

from .busy import BusyTimes
from .config import Config, Setting
from .errors import ConfigurationError, Diverged, Fault, ProtocolError, code_of
from .link import Link, LinkError, LinkFull
from .node import Node, Window
from .state import all_finite
from .wire import NUMBERS, PROTOCOL_VERSION, Frame, Header, WireError, opened, pack_bytes, stamped

#: Longest wait of the link while no frame arrives (s).
SLICE_S = 1.0
#: Requests with texts or bytes, or without interface data.
_NOT_NUMBERS = {"Hello", "Couple", "Finish", "Snapshot", "Checkpoint", "Restore"}
_PR_SET_PDEATHSIG = 1


def participate(make: Callable[[Config, Setting], Node]) -> None:
    """Takes part in the run that the environment names, with the node that `make(config, setting)` returns; `make` may be a class.

    Ends the process: with 0 after a farewell, with 4 after a fault, and on SIGTERM, SIGINT and SIGHUP even during a computation.
    """
    path = os.environ.get("THIRDBODY_SESSION")
    if path is None:
        sys.exit("THIRDBODY_SESSION is not set: this program is a participant, `thirdbody run` launches it")
    text = sys.stdin.buffer.readline() if path == "-" else Path(path).read_bytes()
    if not text:
        sys.exit("standard input ended before the session came")
    session = json.loads(text)
    transport = session["transport"]
    if transport["kind"] not in ("shm", "zenoh"):
        sys.exit("the session asks for an in-process channel, but this participant is another process")
    _end_on_signals(session["coordinator_pid"], transport)
    served = threading.Event()
    if path == "-":
        _end_with_input(served)
    else:
        _end_with_coordinator(session["coordinator_pid"])
    try:
        link = _connect(session)
        try:
            Server(session, link).serve(make)
        finally:
            served.set()
            link.close()
    except (LinkError, Fault) as error:
        print(error, file=sys.stderr)
        sys.exit(4)


def _connect(session: Dict[str, Any]) -> Any:
    transport, participant = session["transport"], session["setting"]["participant"]
    if transport["kind"] == "shm":
        return Link(transport["root"], transport["prefix"], participant, session["idle_deadline_s"])
    try:
        from .network import NetworkLink
    except ImportError as error:
        raise LinkError(f"the coordinator is on another host, and zenoh is missing here ({error}): pip install 'thirdbody[network]'") from error
    return NetworkLink(transport, session["run_id"], participant)


def _is_apart(session: Dict[str, Any]) -> bool:
    """True if the process does not see the folder of its run because it is on another host."""
    try:
        return "mark" in session["transport"] and f"{session['run_id']:016x}" not in Path(session["transport"]["mark"]).read_text()
    except OSError:
        return True


def _message_of(error: Exception) -> str:
    """The error, and the line of the participant's own files where it occurred."""
    library = str(Path(__file__).parent)
    frames = traceback.extract_tb(error.__traceback__)
    own = [f for f in frames if "site-packages" not in f.filename and not f.filename.startswith(library)]
    place = f" ({Path(own[-1].filename).name}, line {own[-1].lineno}: {own[-1].line})" if own else ""
    cure = "; loads and states that come in are read-only: change a copy" if "read-only" in str(error) else ""
    return f"{type(error).__name__}: {error}{place}{cure}"


def _end_with_coordinator(coordinator: int) -> None:
    """Makes the system send SIGTERM when the coordinator ends for any reason."""
    ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGTERM)
    if os.getppid() != coordinator:
        sys.exit(f"the coordinator (process {coordinator}) has ended")


def _end_with_input(served: threading.Event) -> None:
    """Ends the process when standard input ends: then the coordinator has ended, or the connection through which it started this
    process. A process that has `served` ends by itself."""

    def wait() -> None:
        with contextlib.suppress(OSError):
            while os.read(0, 4096):
                pass
        if not served.is_set():
            os.write(2, b"standard input has ended, and with it the coordinator or the connection to it\n")
            os._exit(4)

    threading.Thread(target=wait, daemon=True).start()


def _end_on_signals(coordinator: int, transport: Dict[str, Any]) -> None:
    ends = {signal.SIGTERM, signal.SIGINT, signal.SIGHUP}
    signal.pthread_sigmask(signal.SIG_BLOCK, ends)

    def wait() -> None:
        number = signal.sigwait(ends)
        if transport["kind"] == "shm" and os.getppid() != coordinator:
            _remove_run(transport)
        os.write(2, f"ended by signal {int(number)}\n".encode())
        os._exit(128 + number)

    threading.Thread(target=wait, daemon=True).start()


def _remove_run(transport: Dict[str, str]) -> None:
    """Removes the files of a run without its coordinator from shared memory: no other process may be left to do it."""
    for place in ("/dev/shm", transport["root"]):
        for folder, _, names in os.walk(place):
            for name in names:
                if name.startswith(transport["prefix"]):
                    try:
                        os.remove(os.path.join(folder, name))
                    except OSError:
                        pass


class Server:
    """The loop that turns frames into calls of a node."""

    def __init__(self, session: Dict[str, Any], link: Any) -> None:
        """`link` has `receive(patience_s)`, `send(header, payload, patience_s)` and `clock_ahead_ns()`."""
        self._session = session
        self._link = link
        self._run_id = session["run_id"]
        self._patience_s = session["idle_deadline_s"]
        self._current = Header()
        self._turn = -1
        self._setup_s = self._solve_s = self._wait_s = 0.0
        self._busy = BusyTimes()

    def serve(self, make: Callable[[Config, Setting], Node]) -> None:
        """Serves until the farewell; reports a failure to the coordinator before raising it."""
        try:
            hello = self._receive()
            self._check_hello(hello)
            self._busy.ahead_ns = self._link.clock_ahead_ns()
            start = time.perf_counter()
            node = self._build(make)
            self._setup_s = time.perf_counter() - start
            self._send_json("Welcome", {
                "protocol": PROTOCOL_VERSION,
                "run_id": self._run_id,
                "scenario_hash": self._session["scenario_hash"],
                "units": "SI",
                "pid": os.getpid(),
                "host": os.uname().nodename if "mark" in self._session["transport"] else "",
                "apart": _is_apart(self._session),
                "description": node.describe().document(),
            })
            while self._answer(node, self._receive()):
                pass
        except LinkError:
            raise
        except Exception as error:
            code = code_of(error)
            if isinstance(error, Fault):
                message = str(error)
            else:
                traceback.print_exc()
                message = _message_of(error)
            self._send_json("Fault", {"code": code, "message": message})
            if isinstance(error, Fault):
                raise
            raise Fault(message) from error

    def _build(self, make: Callable[[Config, Setting], Node]) -> Node:
        shared = self._session["setting"]
        fields = shared.get("fields")
        setting = Setting(
            participant=shared["participant"],
            seed=shared["seed"],
            thickness_m=shared["thickness_m"],
            threads=shared["threads"],
            fields=Path(fields) if fields and not _is_apart(self._session) else None,
        )
        config = Config(self._session["config"] or {})
        node = make(config, setting)
        config.require_all_read()
        node.begin()
        return node

    def _hear(self) -> Frame:
        # Only calls that returned without a frame use up the patience: a process that was stopped itself was not waiting.
        left = self._patience_s
        while left > 0.0:
            slice_s = min(left, SLICE_S)
            frame: Optional[Frame] = self._link.receive(slice_s)
            if frame is not None:
                return frame
            left -= slice_s
        raise LinkError(
            f"no frame from the coordinator (process {self._session['coordinator_pid']}) for {self._patience_s:.1f} s"
        )

    def _receive(self) -> Frame:
        start = time.perf_counter()
        frame = self._hear()
        self._wait_s += time.perf_counter() - start
        self._current = frame.header
        self._turn += 1
        if frame.header.protocol != PROTOCOL_VERSION:
            raise ConfigurationError(
                f"the coordinator speaks protocol version {frame.header.protocol}, this participant speaks {PROTOCOL_VERSION}: "
                "install the Python package of the same release"
            )
        fault = opened(frame.header, frame.payload, self._turn)
        if fault is None and frame.header.run_id != self._run_id:
            fault = f"a frame of run {frame.header.run_id:016x} arrived in run {self._run_id:016x}"
        if fault is not None:
            raise ProtocolError(fault)
        return frame

    def _check_hello(self, frame: Frame) -> None:
        if frame.word != "Hello":
            raise ProtocolError("the first frame must be the greeting")
        hello = json.loads(frame.text)
        if hello["scenario_hash"] != self._session["scenario_hash"]:
            raise ConfigurationError(f"the coordinator runs scenario {hello['scenario_hash']}, this participant was launched with another")
        if hello["units"] != "SI":
            raise ConfigurationError(f"the coordinator speaks {hello['units']} units, this participant SI")

    def _send(self, word: str, payload: bytes) -> None:
        at = self._current
        header = Header(
            NUMBERS[word], PROTOCOL_VERSION, self._run_id, at.interface, at.iteration, at.window, at.step,
            at.substeps, 0, at.t0_s, at.t1_s,
        )
        stamp = stamped(header, payload, max(self._turn, 0))
        left = self._patience_s
        while True:
            slice_s = min(left, SLICE_S)
            try:
                return self._link.send(stamp, payload, slice_s)
            except LinkFull:
                left -= slice_s
                if left <= 0.0:
                    raise

    def _send_json(self, word: str, document: Dict[str, Any]) -> None:
        self._send(word, pack_bytes(json.dumps(document, allow_nan=False).encode("utf-8")))

    def _answer(self, node: Node, request: Frame) -> bool:
        """Answers a request; false after the last."""
        start, start_ns = time.perf_counter(), time.monotonic_ns()
        word, header = request.word, request.header
        window = Window(header.window, header.iteration, header.step, header.substeps, header.t0_s, header.t1_s)
        try:
            if word == "Advance":
                answer, payload = "Motion", _numbers(node.advance(window, _finite(request)))
            elif word == "Commit":
                answer, payload = "Report", _numbers(node.commit(window, _finite(request)))
            elif word == "Solve":
                force, velocity, repeats, residual, converged = node.solve(window, _finite(request))
                answer, payload = "Force", _numbers(np.concatenate([force, velocity, [repeats, residual, 1.0 if converged else 0.0]]))
            elif word == "Follow":
                answer, payload = "Reaction", _numbers(np.concatenate(node.follow(window, _finite(request))))
            elif word == "Heat":
                answer, payload = "Temperatures", _numbers(node.take_heat(window, _finite(request)))
            elif word == "Surroundings":
                answer, payload = "Given", _numbers(node.take_temperatures(window, _finite(request)))
            elif word == "March":
                answer, payload = "Report", _numbers(node.advance_alone(window))
            elif word == "Couple":
                answer, payload = "Surface", _numbers(node.couple(request.text).rows(request.text))
            elif word == "Select":
                node.select(_finite(request).astype(int))
                answer, payload = "Ready", b""
            elif word == "Columns":
                answer, payload = "Compliance", _columns(node.columns(window))
            elif word == "Resist":
                answer, payload = "Impedance", _columns(node.impedance(window))
            elif word == "Wall":
                numbers = _finite(request)
                node.set_boundary(float(numbers[0]), numbers[1:])
                answer, payload = "Ready", b""
            elif word == "Snapshot":
                node.snapshot(request.text)
                answer, payload = "Saved", b""
            elif word == "Checkpoint":
                answer, payload = "State", pack_bytes(node.checkpoint())
            elif word == "Restore":
                node.restore(request.data)
                answer, payload = "Restored", b""
            elif word == "Finish":
                outcome = node.finish()
                self._solve_s += time.perf_counter() - start
                self._busy.until_now(start_ns)
                self._send_json("Finished", self._farewell(outcome))
                return False
            else:
                raise ProtocolError(f"{word} is not a request that a participant can answer")
        except WireError as error:
            raise ProtocolError(str(error)) from error
        self._solve_s += time.perf_counter() - start
        self._busy.until_now(start_ns)
        self._send(answer, payload)
        return True

    def _farewell(self, outcome: Any) -> Dict[str, Any]:
        usage = resource.getrusage(resource.RUSAGE_SELF)
        warnings = list(outcome.warnings)
        results = {}
        for name, value in outcome.results.items():
            if np.isfinite(value):
                results[name] = value
            else:
                warnings.append(f"the result {name} is {value} and is left out")
        return {
            "outcome": {
                "steps": int(outcome.steps),
                "work": outcome.work,
                "results": results,
                "state_hash": outcome.state_hash,
                "warnings": warnings,
                "held_load": None if outcome.held_load is None else dict(zip(("wanted_n", "mean_n"), outcome.held_load)),
            },
            "cpu_s": usage.ru_utime + usage.ru_stime,
            "solve_wall_s": self._solve_s,
            "setup_wall_s": self._setup_s,
            "wait_s": self._wait_s,
            "peak_rss_bytes": 1024 * usage.ru_maxrss,
            "busy": self._busy.document(),
        }


def _numbers(values: Any) -> bytes:
    return np.ascontiguousarray(values, dtype="<f8").tobytes()


def _columns(matrix: np.ndarray) -> bytes:
    """A square matrix, column by column."""
    return np.asarray(matrix, dtype="<f8").tobytes(order="F")


def _finite(request: Frame) -> np.ndarray:
    """The numbers of a request; NaN and infinite ones would corrupt a solver without an error."""
    numbers = request.doubles
    if not all_finite(numbers):
        header = request.header
        raise Diverged(
            f"the {request.word} message of window {header.window}, iteration {header.iteration} holds a value that is not finite: "
            "the other side diverged; lower its step or the window"
        )
    return numbers
