//! The loop that turns frames into calls of a [`Node`].

use std::time::Duration;

use nix::sys::resource::{UsageWho, getrusage};
use nix::unistd::gethostname;
use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::busy::{BusyTimes, monotonic_ns};
use crate::cause::Cause;
use crate::frame::{Frame, FrameError, Header, Kind, PROTOCOL_VERSION, packed};
use crate::link::{Link, LinkError};
use crate::node::{BoundaryAnswer, Description, Node, NodeError, Outcome, Window};
use crate::session::{Session, Transport};

/// Longest call of a link while no frame arrives.
const SLICE: Duration = Duration::from_secs(1);

/// The coordinator's greeting.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Hello {
    /// Protocol version of the coordinator.
    pub protocol: u32,
    /// Identity of the run.
    pub run_id: u64,
    /// blake3 of the resolved scenario.
    pub scenario_hash: String,
    /// Name that the participant has in the scenario.
    pub participant: String,
    /// Always `SI`: metres, kilograms, seconds, newtons, joules.
    pub units: String,
}

/// The participant's answer to [`Hello`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Welcome {
    /// Protocol version of the participant.
    pub protocol: u32,
    /// Identity of the run that it was launched for.
    pub run_id: u64,
    /// blake3 of the scenario that it was launched with.
    pub scenario_hash: String,
    /// Units that it speaks.
    pub units: String,
    /// Its process.
    pub pid: u32,
    /// Its host, if it may run on another host than the coordinator.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub host: String,
    /// It does not see the files of the coordinator's host.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub apart: bool,
    /// The node's description of itself.
    pub description: Description,
}

/// The participant's answer to [`Kind::Finish`]: its results, and its times and memory.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Farewell {
    /// Results of the node.
    pub outcome: Outcome,
    /// Processor time (s), all threads of the process.
    pub cpu_s: f64,
    /// Wall-clock time inside the node (s), set-up excluded.
    pub solve_wall_s: f64,
    /// Wall-clock time of the set-up (s).
    pub setup_wall_s: f64,
    /// Wall-clock time of the rest, from the greeting on (s): waiting for requests, reading them, sending answers.
    pub wait_s: f64,
    /// Largest resident set of the process (bytes).
    pub peak_rss_bytes: u64,
    /// Times spent answering requests; empty for a program that does not report them.
    #[serde(default)]
    pub busy: BusyTimes,
}

/// The reason why a participant stopped serving.
#[derive(Debug, Error)]
#[allow(missing_docs)]
pub enum ServeError {
    #[error("link to the coordinator: {0}")]
    Link(#[from] LinkError),
    #[error("frame from the coordinator: {0}")]
    Frame(#[from] FrameError),
    #[error("{0}")]
    Node(#[from] NodeError),
    #[error(
        "no frame from the coordinator (process {pid}) for {seconds:.1} s: it has ended or is stopped"
    )]
    Silent { pid: u32, seconds: f64 },
}

/// Serves a node until the run is finished, the coordinator leaves, or something fails.
///
/// It checks the coordinator's greeting before it builds the node, so that a participant of another version is
/// refused before its set-up costs anything. It reports a failure to the coordinator before it returns the error.
pub fn serve<F>(session: &Session, link: &mut dyn Link, build: F) -> Result<(), ServeError>
where
    F: FnOnce(&Session) -> Result<Box<dyn Node>, NodeError>,
{
    let mut server = Server::new(session, link);
    let hello = server.receive()?;
    let built = check_hello(session, &hello).and_then(|()| build(session));
    let mut node = built.map_err(|error| server.fail(error))?;
    let span = server.lap();
    server.setup_ns = span[1] - span[0];
    server.send(Kind::Welcome, json(&welcome(session, node.describe())))?;
    loop {
        let request = server.receive()?;
        let answer = server
            .check_length(&request)
            .and_then(|()| answer(node.as_mut(), &request));
        let span = server.lap();
        server.solve_ns += span[1] - span[0];
        server.busy.add(span);
        match answer.map_err(|error| server.fail(error))? {
            Answer::Payload(kind, payload) => server.send(kind, payload)?,
            Answer::Outcome(outcome) => {
                let farewell = server.farewell(outcome);
                return server.send(Kind::Finished, json(&farewell));
            }
        }
    }
}

/// A value as JSON in a payload of text.
fn json<T: Serialize>(value: &T) -> Vec<f64> {
    packed(serde_json::to_vec(value).expect("our own types always serialise"))
}

struct Server<'a> {
    session: &'a Session,
    link: &'a mut dyn Link,
    /// Header of the request being answered: answers repeat its window, iteration and interface.
    current: Header,
    /// Requests so far. An answer has the turn of its request, the last one, counted from 0.
    requests: u64,
    /// Exchanged components, once points are selected.
    components: Option<usize>,
    /// Lead of our clock over the coordinator's (ns); spans are reported on the coordinator's clock.
    ahead_ns: i64,
    /// End of the last lap. Laps are contiguous, so no time is lost between them even on a busy machine.
    lapped_ns: u64,
    setup_ns: u64,
    solve_ns: u64,
    wait_ns: u64,
    busy: BusyTimes,
}

impl<'a> Server<'a> {
    fn new(session: &'a Session, link: &'a mut dyn Link) -> Server<'a> {
        let ahead_ns = link.round_trip().map_or(0, |trip| trip.offset_ns);
        Server {
            ahead_ns,
            session,
            link,
            current: Header::default(),
            requests: 0,
            components: None,
            lapped_ns: monotonic_ns().wrapping_add_signed(-ahead_ns),
            setup_ns: 0,
            solve_ns: 0,
            wait_ns: 0,
            busy: BusyTimes::default(),
        }
    }

    /// The span (ns) from the end of the last lap until now.
    fn lap(&mut self) -> [u64; 2] {
        let now_ns = monotonic_ns().wrapping_add_signed(-self.ahead_ns);
        let start_ns = std::mem::replace(&mut self.lapped_ns, now_ns);
        [start_ns, self.lapped_ns]
    }

    /// The next request, checked; damage and foreign frames are reported to the coordinator before the error is returned.
    fn receive(&mut self) -> Result<Frame, ServeError> {
        let mut frame = self.next_frame()?;
        self.current = frame.header;
        let turn = self.requests;
        self.requests += 1;
        // `check_hello` refuses another version.
        if frame.header.protocol == PROTOCOL_VERSION {
            let opened = frame.open(turn).map_err(unreadable);
            let (theirs, ours) = (frame.header.run_id, self.session.run_id);
            let checked = opened.and_then(|()| {
                (theirs == ours).then_some(()).ok_or_else(|| {
                    NodeError::protocol(format!(
                        "a frame of run {theirs:016x} arrived in run {ours:016x}: two runs share one transport prefix"
                    ))
                })
            });
            checked.map_err(|error| self.fail(error))?;
        }
        let [start_ns, end_ns] = self.lap();
        self.wait_ns += end_ns - start_ns;
        Ok(frame)
    }

    /// The next frame. Only calls that returned without a frame use up the patience: a process that was stopped itself
    /// was not waiting.
    fn next_frame(&mut self) -> Result<Frame, ServeError> {
        let patience = Duration::from_secs_f64(self.session.idle_deadline_s);
        let mut left = patience;
        while !left.is_zero() {
            let slice = left.min(SLICE);
            if let Some(frame) = self.link.receive(slice)? {
                return Ok(frame);
            }
            left -= slice;
        }
        Err(ServeError::Silent {
            pid: self.session.coordinator_pid,
            seconds: patience.as_secs_f64(),
        })
    }

    /// Refuses a load that does not have all exchanged components.
    fn check_length(&mut self, request: &Frame) -> Result<(), NodeError> {
        let length = request.payload.len();
        match request.kind() {
            Ok(Kind::Select) => self.components = Some(2 * length),
            Ok(kind @ (Kind::Advance | Kind::Solve | Kind::PrescribeVelocity)) => {
                if let Some(due) = self.components.filter(|due| *due != length) {
                    return Err(NodeError::protocol(format!(
                        "the {kind:?} message holds {length} numbers instead of {due}: two for each selected point"
                    )));
                }
            }
            Ok(kind @ (Kind::TakeHeat | Kind::TakeTemperatures)) => {
                if let Some(due) = self.components.filter(|due| *due != 2 * length) {
                    return Err(NodeError::protocol(format!(
                        "the {kind:?} message holds {length} numbers instead of {}: one for each selected point",
                        due / 2
                    )));
                }
            }
            _ => {}
        }
        Ok(())
    }

    /// Sends an answer, with the patience of [`Server::next_frame`].
    fn send(&mut self, kind: Kind, payload: Vec<f64>) -> Result<(), ServeError> {
        let header = Header {
            kind: kind as u32,
            protocol: PROTOCOL_VERSION,
            run_id: self.session.run_id,
            ..self.current
        };
        let mut frame = Frame::new(header, payload);
        frame.stamp(self.requests - 1);
        let patience = Duration::from_secs_f64(self.session.idle_deadline_s);
        let mut left = patience;
        while !left.is_zero() {
            let slice = left.min(SLICE);
            match self.link.send(&frame, slice) {
                Err(LinkError::Full { .. }) => left -= slice,
                sent => return Ok(sent?),
            }
        }
        let seconds = patience.as_secs_f64();
        Err(LinkError::Full { seconds }.into())
    }

    /// Reports an error to the coordinator; it ends this participant.
    fn fail(&mut self, error: NodeError) -> ServeError {
        let sent = self.send(Kind::Fault, json(&error));
        sent.err().unwrap_or(error.into())
    }

    fn farewell(&mut self, outcome: Outcome) -> Farewell {
        let usage = getrusage(UsageWho::RUSAGE_SELF).ok();
        let seconds = |t: nix::sys::time::TimeVal| t.tv_sec() as f64 + 1e-6 * t.tv_usec() as f64;
        Farewell {
            outcome,
            cpu_s: usage.map_or(0.0, |u| seconds(u.user_time()) + seconds(u.system_time())),
            solve_wall_s: 1e-9 * self.solve_ns as f64,
            setup_wall_s: 1e-9 * self.setup_ns as f64,
            wait_s: 1e-9 * self.wait_ns as f64,
            peak_rss_bytes: usage.map_or(0, |u| 1024 * u.max_rss().max(0) as u64),
            busy: std::mem::take(&mut self.busy),
        }
    }
}

fn welcome(session: &Session, description: Description) -> Welcome {
    let remote = matches!(session.transport, Transport::Zenoh { .. });
    let name = gethostname().ok().filter(|_| remote);
    Welcome {
        protocol: PROTOCOL_VERSION,
        run_id: session.run_id,
        scenario_hash: session.scenario_hash.clone(),
        units: "SI".into(),
        pid: std::process::id(),
        host: name.map_or_else(String::new, |name| name.to_string_lossy().into_owned()),
        apart: !session.sees_run(),
        description,
    }
}

fn check_hello(session: &Session, frame: &Frame) -> Result<(), NodeError> {
    let refuse = |message: String| Err(NodeError::of(Cause::OtherRelease, message));
    if frame.header.protocol != PROTOCOL_VERSION {
        return refuse(format!(
            "the coordinator speaks protocol version {}, this participant speaks {PROTOCOL_VERSION}: build both from the same release",
            frame.header.protocol
        ));
    }
    let hello: Hello = frame.text().map_err(unreadable).and_then(|text| {
        serde_json::from_str(&text).map_err(|error| {
            NodeError::protocol(format!(
                "the first frame must be the greeting, but it cannot be read: {error}"
            ))
        })
    })?;
    if hello.scenario_hash != session.scenario_hash {
        return refuse(format!(
            "the coordinator runs scenario {}, this participant was launched with {}",
            hello.scenario_hash, session.scenario_hash
        ));
    }
    if hello.units != "SI" {
        return refuse(format!(
            "the coordinator speaks {} units, this participant SI",
            hello.units
        ));
    }
    Ok(())
}

enum Answer {
    Payload(Kind, Vec<f64>),
    Outcome(Outcome),
}

/// Turns a request into a call of the node, and its result into the answer.
fn answer(node: &mut dyn Node, request: &Frame) -> Result<Answer, NodeError> {
    let kind = request.kind().map_err(unreadable)?;
    let window = window_of(&request.header);
    if kind.is_exchange() && kind != Kind::Couple {
        check_finite(kind, &window, &request.payload)?;
    }
    let numbers = &request.payload;
    let (kind, payload) = match kind {
        Kind::Couple => {
            let set = request.text().map_err(unreadable)?;
            (Kind::Surface, node.couple(&set)?.to_rows())
        }
        Kind::Select => {
            let points: Vec<usize> = numbers.iter().map(|index| *index as usize).collect();
            node.select(&points)?;
            (Kind::Ready, Vec::new())
        }
        Kind::Columns => (Kind::Compliance, node.columns(&window)?),
        Kind::CompliantBoundary => {
            let (window_s, compliance) = numbers
                .split_first()
                .ok_or_else(|| NodeError::protocol("the wall request is empty"))?;
            node.set_boundary(*window_s, compliance)?;
            (Kind::Ready, Vec::new())
        }
        Kind::Advance => (Kind::Motion, node.advance(&window, numbers)?),
        Kind::ImpedanceColumns => (Kind::Impedance, node.impedance(&window)?),
        Kind::PrescribeVelocity => {
            let reaction = node.prescribe_velocity(&window, numbers)?;
            let payload = [reaction.force, reaction.increment, reaction.work].concat();
            (Kind::Reaction, payload)
        }
        Kind::Solve => {
            let answer = node.solve(&window, numbers)?;
            (Kind::Force, pack_boundary_answer(answer))
        }
        Kind::Commit => (Kind::Report, node.commit(&window, numbers)?),
        Kind::TakeHeat => (Kind::Temperatures, node.take_heat(&window, numbers)?),
        Kind::TakeTemperatures => (Kind::HeatGiven, node.take_temperatures(&window, numbers)?),
        Kind::AdvanceAlone => (Kind::Report, node.advance_alone(&window)?),
        Kind::Snapshot => {
            let name = request.text().map_err(unreadable)?;
            node.snapshot(&name)?;
            (Kind::Saved, Vec::new())
        }
        Kind::Checkpoint => (Kind::State, packed(node.checkpoint()?)),
        Kind::Restore => {
            let state = request.bytes().map_err(unreadable)?;
            node.restore(&state)?;
            (Kind::Restored, Vec::new())
        }
        Kind::Finish => return Ok(Answer::Outcome(node.finish()?.with_finite_results())),
        other => {
            return Err(NodeError::protocol(format!(
                "{other:?} is not a request that a participant can answer"
            )));
        }
    };
    Ok(Answer::Payload(kind, payload))
}

fn unreadable(error: FrameError) -> NodeError {
    NodeError::protocol(error.to_string())
}

/// Refuses NaN and infinite numbers, which would corrupt a solver without an error.
fn check_finite(kind: Kind, window: &Window, payload: &[f64]) -> Result<(), NodeError> {
    match payload.iter().position(|value| !value.is_finite()) {
        None => Ok(()),
        Some(index) => {
            let message = format!(
                "the {kind:?} message of window {}, iteration {} holds {} at entry {index}: the other side diverged; lower its step or the window",
                window.index, window.iteration, payload[index]
            );
            Err(NodeError::of(Cause::InputNotFinite, message))
        }
    }
}

/// The window of a header.
pub fn window_of(header: &Header) -> Window {
    Window {
        index: header.window,
        iteration: header.iteration,
        step: header.step,
        substeps: header.substeps,
        t0_s: header.t0_s,
        t1_s: header.t1_s,
    }
}

fn pack_boundary_answer(answer: BoundaryAnswer) -> Vec<f64> {
    let mut payload = answer.force;
    payload.extend_from_slice(&answer.velocity);
    payload.push(answer.iterations as f64);
    payload.push(answer.residual);
    payload.push(if answer.converged { 1.0 } else { 0.0 });
    payload
}

/// The [`BoundaryAnswer`] in the 2 n + 3 numbers of a `Force` frame, for n interface components.
pub fn unpack_boundary_answer(payload: &[f64], components: usize) -> BoundaryAnswer {
    BoundaryAnswer {
        force: payload[..components].to_vec(),
        velocity: payload[components..2 * components].to_vec(),
        iterations: payload[2 * components] as u64,
        residual: payload[2 * components + 1],
        converged: payload[2 * components + 2] == 1.0,
    }
}
