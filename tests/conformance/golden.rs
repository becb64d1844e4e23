//! The golden transcript: a whole conversation with a small participant, byte by byte.
//!
//! `protocol/golden/bed.txt` holds the frames of coordinator and participant on a link, as a test for programs in other languages such
//! as `protocol/python`. Problem: a bed of three springs that creeps, k du/dn = (F - k u) / 8 per step. Exact: the bytes.
//! `THIRDBODY_GOLDEN=write cargo test --release -p tests --test conformance golden` writes the file anew after a change of the protocol.

use std::collections::VecDeque;
use std::path::Path;
use std::time::Duration;

use protocol::frame::packed;
use protocol::serve::{Farewell, Hello, Welcome};
use protocol::{
    Capabilities, Description, Frame, Header, Kind, Link, LinkError, Node, NodeError, Outcome,
    PROTOCOL_VERSION, Role, Session, Setting, Surface, Term, Transport, Window, serve,
};
use serde_json::json;

const RUN: u64 = 0x0123_4567_89ab_cdef;

/// Springs in x and y under three points; the states are displacements.
struct Bed {
    stiffness: Vec<f64>,
    committed: Vec<f64>,
    candidate: Vec<f64>,
    work: f64,
    candidate_work: f64,
    steps: u64,
    selected: Vec<usize>,
}

impl Bed {
    /// The state of all points, selected or not.
    fn after(&self, start: &[f64], force: &[f64], substeps: u32) -> Vec<f64> {
        let mut state = start.to_vec();
        for _ in 0..substeps {
            for (i, u) in state.iter_mut().enumerate() {
                *u += 0.125 * (force[i] / self.stiffness[i] - *u);
            }
        }
        state
    }

    fn spread(&self, numbers: &[f64]) -> Vec<f64> {
        let mut all = vec![0.0; 6];
        for (at, point) in self.selected.iter().enumerate() {
            all[2 * point..2 * point + 2].copy_from_slice(&numbers[2 * at..2 * at + 2]);
        }
        all
    }

    fn increments(&self, end: &[f64], start: &[f64]) -> Vec<f64> {
        let of = |component: usize| end[component] - start[component];
        let points = self.selected.iter();
        points
            .flat_map(|point| [of(2 * point), of(2 * point + 1)])
            .collect()
    }
}

impl Node for Bed {
    fn describe(&self) -> Description {
        let term = |name: &str, role| Term {
            name: name.into(),
            role,
        };
        Description {
            kind: "bed".into(),
            software: "golden bed".into(),
            capabilities: Capabilities {
                rollback: true,
                advance: true,
                columns: true,
                alone: true,
                resume: true,
                ..Capabilities::default()
            },
            step_s: Some(0.5),
            sets: vec!["top".into()],
            signals: vec!["sinking_m".into()],
            ledger: vec![
                term("interface_work", Role::InterfaceWork),
                term("springs", Role::Stored),
            ],
            outward: [("top".to_string(), [0.0, 1.0])].into(),
            ..Description::default()
        }
    }

    fn couple(&mut self, _set: &str) -> Result<Surface, NodeError> {
        self.selected = vec![0, 1, 2];
        Ok(Surface {
            x_m: vec![0.0, 0.25, 0.5],
            y_m: vec![0.0; 3],
            mass_kg: vec![0.0; 3],
            radius_m: vec![0.0; 3],
            length_m: vec![0.125, 0.25, 0.125],
        })
    }

    fn select(&mut self, points: &[usize]) -> Result<(), NodeError> {
        self.selected = points.to_vec();
        Ok(())
    }

    fn columns(&mut self, window: &Window) -> Result<Vec<f64>, NodeError> {
        let rest = vec![0.0; 6];
        let column = |component: usize| {
            let mut unit = vec![0.0; 2 * self.selected.len()];
            unit[component] = 1.0;
            self.increments(
                &self.after(&rest, &self.spread(&unit), window.substeps),
                &rest,
            )
        };
        Ok((0..2 * self.selected.len()).flat_map(column).collect())
    }

    fn advance(&mut self, window: &Window, force: &[f64]) -> Result<Vec<f64>, NodeError> {
        self.candidate = self.after(&self.committed, &self.spread(force), window.substeps);
        let increments = self.increments(&self.candidate, &self.committed);
        let works = force.iter().zip(&increments).map(|(f, du)| f * du);
        self.candidate_work = works.reduce(|sum, work| sum + work).unwrap_or(0.0);
        Ok(increments)
    }

    fn commit(&mut self, window: &Window, _displacement: &[f64]) -> Result<Vec<f64>, NodeError> {
        self.committed.clone_from(&self.candidate);
        self.work += self.candidate_work;
        self.steps += u64::from(window.substeps);
        let energies = self
            .committed
            .iter()
            .zip(&self.stiffness)
            .map(|(u, k)| 0.5 * k * u * u);
        let stored = energies.reduce(|sum, energy| sum + energy).unwrap_or(0.0);
        Ok(vec![-self.committed[3], self.work, stored])
    }

    fn advance_alone(&mut self, window: &Window) -> Result<Vec<f64>, NodeError> {
        self.advance(window, &vec![0.0; 2 * self.selected.len()])?;
        self.commit(window, &[])
    }

    fn finish(&mut self) -> Result<Outcome, NodeError> {
        Ok(Outcome {
            steps: self.steps,
            work: [("steps".to_string(), self.steps as f64)].into(),
            results: [("sinking_m".to_string(), -self.committed[3])].into(),
            state_hash: "0".repeat(64),
            ..Outcome::default()
        })
    }
}

/// A link that sends the prepared requests and keeps the answers.
struct Script {
    requests: VecDeque<Frame>,
    answers: Vec<Frame>,
}

impl Link for &mut Script {
    fn send(&mut self, frame: &Frame, _patience: Duration) -> Result<(), LinkError> {
        self.answers.push(frame.clone());
        Ok(())
    }

    fn receive(&mut self, _patience: Duration) -> Result<Option<Frame>, LinkError> {
        Ok(self.requests.pop_front())
    }
}

fn session() -> Session {
    Session {
        protocol: PROTOCOL_VERSION,
        run_id: RUN,
        scenario_hash: "5c".repeat(32),
        coordinator_pid: 1,
        setting: Setting {
            participant: "bed".into(),
            seed: 7,
            thickness_m: 1e-3,
            threads: 1,
            fields: None,
            cache: None,
        },
        transport: Transport::Channel,
        idle_deadline_s: 10.0,
        config: json!({"stiffness_n_per_m": [1e6, 2e6, 4e6]}),
    }
}

/// All requests, in their turns.
fn requests() -> VecDeque<Frame> {
    let hello = Hello {
        protocol: PROTOCOL_VERSION,
        run_id: RUN,
        scenario_hash: session().scenario_hash,
        participant: "bed".into(),
        units: "SI".into(),
    };
    let header = |kind: Kind, window: u64, iteration: u32, substeps: u32| Header {
        run_id: RUN,
        interface: 0,
        window,
        iteration,
        step: 4 * window,
        substeps,
        t0_s: 2.0 * window as f64,
        t1_s: 2.0 * window as f64 + 0.5 * f64::from(substeps),
        ..Header::of(kind)
    };
    let text = |kind, text: &str| Frame::new(header(kind, 0, 0, 0), packed(text));
    let numbers = |kind, at: [u32; 3], payload: &[f64]| {
        Frame::new(
            header(kind, u64::from(at[0]), at[1], at[2]),
            payload.to_vec(),
        )
    };
    let greeting = serde_json::to_string(&hello).expect("plain data");
    let mut all = VecDeque::from([
        text(Kind::Hello, &greeting),
        text(Kind::Couple, "top"),
        numbers(Kind::Select, [0, 0, 0], &[0.0, 1.0]),
        numbers(Kind::Columns, [0, 0, 4], &[]),
        // A window that is repeated and accepted after the repeat.
        numbers(Kind::Advance, [0, 0, 4], &[0.0, -100.0, 10.0, -300.0]),
        numbers(Kind::Advance, [0, 1, 4], &[5.0, -110.0, -10.0, -310.0]),
        numbers(Kind::Commit, [0, 1, 4], &[]),
        // A window whose first request comes early; another request comes before its repeat.
        numbers(Kind::Advance, [1, 0, 4], &[5.0, -120.0, -10.0, -320.0]),
        text(Kind::Snapshot, "hold"),
        numbers(Kind::Advance, [1, 0, 4], &[6.0, -125.0, -11.0, -330.0]),
        // Its first half instead.
        numbers(Kind::Advance, [1, 1, 2], &[6.0, -125.0, -11.0, -330.0]),
        numbers(Kind::Commit, [1, 1, 2], &[]),
        numbers(Kind::AdvanceAlone, [2, 0, 3], &[]),
        text(Kind::Finish, ""),
    ]);
    for (turn, request) in all.iter_mut().enumerate() {
        if request.kind() == Ok(Kind::Finish) {
            *request = Frame::new(request.header, Vec::new());
        }
        request.stamp(turn as u64);
    }
    all
}

fn hex(bytes: impl IntoIterator<Item = u8>) -> String {
    bytes
        .into_iter()
        .map(|byte| format!("{byte:02x}"))
        .collect()
}

/// The 72 bytes of a header.
fn header_bytes(header: &Header) -> Vec<u8> {
    let mut bytes = Vec::new();
    bytes.extend(header.kind.to_le_bytes());
    bytes.extend(header.protocol.to_le_bytes());
    bytes.extend(header.run_id.to_le_bytes());
    bytes.extend(header.interface.to_le_bytes());
    bytes.extend(header.iteration.to_le_bytes());
    bytes.extend(header.window.to_le_bytes());
    bytes.extend(header.step.to_le_bytes());
    bytes.extend(header.substeps.to_le_bytes());
    bytes.extend(header.count.to_le_bytes());
    bytes.extend(header.t0_s.to_le_bytes());
    bytes.extend(header.t1_s.to_le_bytes());
    bytes.extend(header.checksum.to_le_bytes());
    bytes
}

fn line(from: char, frame: &Frame) -> String {
    let word = frame.kind().map_or("?", Kind::word);
    let payload = frame.payload.iter().flat_map(|value| value.to_le_bytes());
    let payload = hex(payload);
    let payload = if payload.is_empty() { "-" } else { &payload };
    format!(
        "{from} {word} {} {payload}\n",
        hex(header_bytes(&frame.header))
    )
}

/// An answer without the parts that differ between two programs: process, times, memory. Texts are compared as documents.
fn comparable(frame: &Frame) -> (Header, Vec<u64>, serde_json::Value) {
    let bits = |frame: &Frame| frame.payload.iter().map(|value| value.to_bits()).collect();
    let document = match frame.kind() {
        Ok(Kind::Welcome) => {
            let text = frame.text().expect("a text");
            let welcome: Welcome = serde_json::from_str(&text).expect("a greeting");
            json!(Welcome { pid: 0, ..welcome })
        }
        Ok(Kind::Finished) => {
            let text = frame.text().expect("a text");
            let farewell: Farewell = serde_json::from_str(&text).expect("a farewell");
            let outcome = farewell.outcome;
            json!(Farewell {
                outcome,
                ..Farewell::default()
            })
        }
        _ => return (frame.header, bits(frame), serde_json::Value::Null),
    };
    let header = Header {
        count: 0,
        checksum: 0,
        ..frame.header
    };
    (header, Vec::new(), document)
}

/// The conversation with a bed served in this process.
fn spoken() -> (Vec<Frame>, Vec<Frame>) {
    let mut script = Script {
        requests: requests(),
        answers: Vec::new(),
    };
    let asked: Vec<Frame> = script.requests.iter().cloned().collect();
    serve(&session(), &mut &mut script, |session| {
        let stiffness = session.config["stiffness_n_per_m"]
            .as_array()
            .expect("a list")
            .iter();
        let stiffness = stiffness.map(|k| k.as_f64().expect("a number"));
        Ok(Box::new(Bed {
            stiffness: stiffness.flat_map(|k| [k, k]).collect(),
            committed: vec![0.0; 6],
            candidate: vec![0.0; 6],
            work: 0.0,
            candidate_work: 0.0,
            steps: 0,
            selected: Vec::new(),
        }))
    })
    .expect("the conversation is whole");
    (asked, script.answers)
}

fn frame_of(words: &str) -> (char, Frame) {
    let words: Vec<&str> = words.split_ascii_whitespace().collect();
    let bytes = |text: &str| -> Vec<u8> {
        let pairs = (0..text.len() / 2).map(|at| &text[2 * at..2 * at + 2]);
        pairs
            .map(|pair| u8::from_str_radix(pair, 16).expect("hexadecimal"))
            .collect()
    };
    let header = bytes(words[2]);
    let u32_at = |at: usize| u32::from_le_bytes(header[at..at + 4].try_into().expect("four"));
    let u64_at = |at: usize| u64::from_le_bytes(header[at..at + 8].try_into().expect("eight"));
    let payload = if words[3] == "-" {
        Vec::new()
    } else {
        bytes(words[3])
    };
    let doubles = payload.chunks_exact(8);
    let frame = Frame {
        header: Header {
            kind: u32_at(0),
            protocol: u32_at(4),
            run_id: u64_at(8),
            interface: u32_at(16),
            iteration: u32_at(20),
            window: u64_at(24),
            step: u64_at(32),
            substeps: u32_at(40),
            count: u32_at(44),
            t0_s: f64::from_bits(u64_at(48)),
            t1_s: f64::from_bits(u64_at(56)),
            checksum: u64_at(64),
        },
        payload: doubles
            .map(|eight| f64::from_le_bytes(eight.try_into().expect("eight")))
            .collect(),
    };
    (words[0].chars().next().expect("a mark"), frame)
}

#[test]
fn coordinator_and_participant_exchange_the_golden_bytes() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../protocol/golden/bed.txt");
    let (asked, answered) = spoken();
    assert_eq!(asked.len(), answered.len());
    if std::env::var("THIRDBODY_GOLDEN").is_ok_and(|what| what == "write") {
        let mut text = String::from(
            "# The golden transcript (WIRE.md): > from the coordinator, < from the participant; word, header, payload (- for none).\n",
        );
        for (request, answer) in asked.iter().zip(&answered) {
            text += &line('>', request);
            text += &line('<', answer);
        }
        std::fs::write(&path, text).expect("the tree is writable");
    }
    let text = std::fs::read_to_string(&path).expect("it is part of the tree");
    let lines = text.lines().filter(|line| !line.starts_with('#'));
    let written: Vec<(char, Frame)> = lines.map(frame_of).collect();
    let both = asked.iter().zip(&answered);
    let spoken: Vec<(char, &Frame)> = both.flat_map(|(q, a)| [('>', q), ('<', a)]).collect();
    assert_eq!(written.len(), spoken.len());
    for ((mark, theirs), (ours_mark, ours)) in written.iter().zip(spoken) {
        assert_eq!(*mark, ours_mark);
        assert_eq!(comparable(theirs), comparable(ours), "{:?}", ours.kind());
    }
}
