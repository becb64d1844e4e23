//! Time from a request of the coupler to the answer of a node, over shared memory.

use std::path::Path;
use std::process::Command;
use std::time::Duration;

use protocol::link::shm::{ShmLink, WaitMode};
use protocol::participate::{ParticipateError, read_session};
use protocol::{Frame, Header, Kind, Link, PROTOCOL_VERSION, Session, Setting, Transport};
use serde::Serialize;
use serde_json::Value;

use super::time_turns;
use coordinator::participants::OtherEnd;
use coordinator::participants::process::{SharedMemory, spawn};
use kit::scratch::Scratch;
use scenario::error::{Error, Refusal};

/// Number of frames before timing starts.
const WARM_UP: usize = 500;
/// Number of timed frames.
const TIMED: usize = 5_000;
const PATIENCE: Duration = Duration::from_secs(5);

/// One row of the table.
#[derive(Clone, Debug, Serialize)]
pub struct ExchangeRow {
    /// Doubles in the request, and also in the answer.
    pub doubles: usize,
    /// Wait mode of both ends: `poll` or `event`.
    pub mode: &'static str,
    /// Processes: the coupler and one node, or the coupler and two nodes that get requests in turn.
    pub processes: usize,
    /// Median round trip (us).
    pub p50_us: f64,
    /// 99th percentile (us).
    pub p99_us: f64,
}

/// Measures all rows: 100, 1 000 and 10 000 doubles, both wait modes, two and three processes. `program` is this program, whose hidden
/// verb `bench echo` is the other end.
pub fn bench(program: &Path) -> Result<Vec<ExchangeRow>, Error> {
    let mut rows = Vec::new();
    for processes in [2, 3] {
        for (mode, wait) in [("poll", WaitMode::Poll), ("event", WaitMode::Event)] {
            let mut bench = Bench::start(program, processes - 1, mode, wait)?;
            for doubles in [100, 1_000, 10_000] {
                let frame = Frame::new(Header::of(Kind::Advance), vec![0.5; doubles]);
                let (p50_us, p99_us) = time_turns(WARM_UP, TIMED, |turn| {
                    bench.round_trip(turn % (processes - 1), &frame)
                })?;
                rows.push(ExchangeRow {
                    doubles,
                    mode,
                    processes,
                    p50_us,
                    p99_us,
                });
            }
        }
    }
    Ok(rows)
}

/// Answers every frame with its own payload, until the other end goes away.
pub fn echo() -> Result<(), ParticipateError> {
    let session = read_session()?;
    let signal = nix::sys::signal::Signal::SIGKILL;
    protocol::participate::end_with_coordinator(&session, signal)?;
    let Transport::Shm { root, prefix } = &session.transport else {
        return Err(ParticipateError::NoChannel);
    };
    let mut link = ShmLink::participant(root, prefix, &session.setting.participant, PATIENCE)?;
    while let Some(frame) = link.receive(PATIENCE)? {
        if frame.kind().is_ok_and(|kind| kind == Kind::Finish) {
            break;
        }
        link.send(&frame, PATIENCE)?;
    }
    Ok(())
}

/// Links and processes of one set-up. Dropping it ends and removes them, in the order of the fields.
struct Bench {
    links: Vec<ShmLink>,
    lives: Vec<OtherEnd>,
    memory: SharedMemory,
    /// Folder of the sessions and texts of the other ends.
    folder: Scratch,
}

impl Bench {
    fn start(program: &Path, nodes: usize, mode: &str, wait: WaitMode) -> Result<Bench, Error> {
        let run_id = nodes as u64 * 2 + u64::from(mode == "poll");
        let mut bench = Bench {
            links: Vec::new(),
            lives: Vec::new(),
            memory: SharedMemory::new(run_id),
            folder: Scratch::new("bench-exchange", run_id),
        };
        let folder = bench.folder.path();
        std::fs::create_dir_all(folder).map_err(Error::output(folder.display()))?;
        for index in 0..nodes {
            let name = format!("echo-{index}");
            let SharedMemory { root, prefix, .. } = &bench.memory;
            let link = ShmLink::coordinator(root, prefix, &name, wait)
                .map_err(|error| Refusal::Benchmark(error.to_string()))?;
            let mut command = Command::new(program);
            let session = bench.session(&name);
            command.args(["bench", "echo"]);
            let child = spawn(command, &session, bench.folder.path())?;
            bench.links.push(link);
            bench.lives.push(OtherEnd::Process(child));
        }
        Ok(bench)
    }

    fn session(&self, name: &str) -> Session {
        Session {
            protocol: PROTOCOL_VERSION,
            run_id: 0,
            scenario_hash: String::new(),
            coordinator_pid: std::process::id(),
            setting: Setting {
                participant: name.to_string(),
                seed: 0,
                thickness_m: 1.0,
                threads: 1,
                fields: None,
                cache: None,
            },
            transport: Transport::Shm {
                root: self.memory.root.clone(),
                prefix: self.memory.prefix.clone(),
            },
            idle_deadline_s: PATIENCE.as_secs_f64(),
            config: Value::Null,
        }
    }

    fn round_trip(&mut self, index: usize, frame: &Frame) -> Result<(), Error> {
        let link = &mut self.links[index];
        let fault = |why: String| Error::Protocol {
            peer: format!("echo-{index}"),
            phase: "in the benchmark".into(),
            why,
        };
        let sent = link.send(frame, PATIENCE);
        let answer = sent.and_then(|()| link.receive(PATIENCE));
        let answer = answer.map_err(|error| fault(error.to_string()))?;
        let answer = answer.ok_or_else(|| fault("no answer came".into()))?;
        if answer.verify().is_err() || answer.payload.len() != frame.payload.len() {
            return Err(fault("the answer is not the request".into()));
        }
        Ok(())
    }
}

impl Drop for Bench {
    fn drop(&mut self) {
        let goodbye = Frame::new(Header::of(Kind::Finish), Vec::new());
        for link in &mut self.links {
            let _ = link.send(&goodbye, Duration::from_millis(100));
        }
    }
}
