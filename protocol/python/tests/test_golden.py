"""The golden transcript: a creeping bed of three springs answers byte by byte as in Rust."""

import json
import unittest
from collections import deque
from pathlib import Path

import numpy as np

import thirdbody
from thirdbody.serve import Server
from thirdbody.wire import Frame, Header, opened

TRANSCRIPT = Path(__file__).resolve().parents[2] / "golden" / "bed.txt"


class Bed(thirdbody.Continuum):
    kind = "bed"
    software = "golden bed"
    step_s = 0.5
    outward = {"top": (0.0, 1.0)}

    def __init__(self, config, setting):
        super().__init__(config, setting)
        self.stiffness = np.array(config.get("stiffness_n_per_m"))[:, None]

    def points(self, set_name):
        return thirdbody.Points([0.0, 0.25, 0.5], [0.0, 0.0, 0.0])

    def rest(self):
        return np.zeros((3, 2))

    def step(self, state, force, n):
        for _ in range(n):
            state = state + 0.125 * (force / self.stiffness - state)
        return state

    def displacement(self, state):
        return state

    def energy(self, state):
        return {"stored": {"springs": (0.5 * self.stiffness * state * state).sum()}}

    def signals(self, state):
        return {"sinking_m": -state[1, 1]}

    def results(self, state):
        return self.signals(state)


class Script:
    """A link that sends the recorded requests, and keeps the answers."""

    def __init__(self, requests):
        self.requests = deque(requests)
        self.answers = []

    def receive(self, patience_s):
        return self.requests.popleft() if self.requests else None

    def send(self, header, payload, patience_s):
        self.answers.append(Frame(header, payload))

    def clock_ahead_ns(self):
        return 0


def transcript():
    """Requests and answers in the file."""
    said = {">": [], "<": []}
    for line in TRANSCRIPT.read_text(encoding="utf-8").splitlines():
        if line.startswith("#"):
            continue
        mark, word, header, payload = line.split()
        frame = Frame(Header.unpack(bytes.fromhex(header)), b"" if payload == "-" else bytes.fromhex(payload))
        assert frame.word == word, line
        said[mark].append(frame)
    return said[">"], said["<"]


def session():
    return {
        "protocol": 2,
        "run_id": 0x0123456789ABCDEF,
        "scenario_hash": "5c" * 32,
        "coordinator_pid": 1,
        "transport": {"kind": "shm"},
        "setting": {"participant": "bed", "seed": 7, "thickness_m": 1e-3, "threads": 1, "fields": None},
        "idle_deadline_s": 0.1,
        "config": {"stiffness_n_per_m": [1e6, 2e6, 4e6]},
    }


def filled_up(document, pattern):
    """A document with the optional keys filled in."""
    if isinstance(document, dict) and isinstance(pattern, dict):
        return {**pattern, **{key: filled_up(value, pattern.get(key)) for key, value in document.items()}}
    return document


class Golden(unittest.TestCase):
    def test_every_answer_is_the_recorded_one(self):
        requests, written = transcript()
        script = Script(requests)
        Server(session(), script).serve(Bed)
        self.assertEqual(len(script.answers), len(written))
        for turn, (ours, theirs) in enumerate(zip(script.answers, written)):
            self.assertIsNone(opened(ours.header, ours.payload, turn))
            self.assertEqual(ours.word, theirs.word)
            if ours.word not in ("Welcome", "Finished"):
                self.assertEqual(ours, theirs, ours.word)
                continue
            self.assertEqual(ours.header[:8], theirs.header[:8])
            ours, theirs = json.loads(ours.text), json.loads(theirs.text)
            for key in ("pid", "cpu_s", "solve_wall_s", "setup_wall_s", "wait_s", "peak_rss_bytes"):
                self.assertEqual(key in ours, key in theirs)
                ours.pop(key, None), theirs.pop(key, None)
            # A program for a single host leaves these out.
            self.assertEqual((ours.pop("host", ""), ours.pop("apart", False)), ("", False))
            if "outcome" in ours:
                # The transcript comes from a program that leaves it out.
                self.assertEqual(ours.pop("busy")["every"], 1)
                self.assertEqual(len(ours["outcome"].pop("state_hash")), 64)
                theirs["outcome"].pop("state_hash")
            self.assertEqual(filled_up(json.loads(json.dumps(ours)), theirs), theirs)

    def test_a_damaged_frame_and_one_out_of_turn_are_refused(self):
        requests, _ = transcript()
        header, payload = requests[5]
        self.assertIsNone(opened(header, payload, 5))
        self.assertIn("message 5", opened(header, payload, 4))
        self.assertIn("damaged", opened(header._replace(window=9), payload, 5))
        self.assertIn("damaged", opened(header, payload[:-1] + b"\x7f", 5))
        self.assertIn("doubles", opened(header, payload[:-8], 5))

    def test_a_request_of_another_run_ends_with_a_fault(self):
        requests, _ = transcript()
        script = Script(requests)
        other = {**session(), "run_id": 1}
        with self.assertRaises(thirdbody.ProtocolError):
            Server(other, script).serve(Bed)
        fault = json.loads(script.answers[-1].text)
        self.assertEqual(fault["code"], "protocol")


if __name__ == "__main__":
    unittest.main()
