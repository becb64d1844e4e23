//! Frames between processes, through shared memory (iceoryx2).
//!
//! Each participant has two publish-subscribe services, one per direction, with one publisher and one
//! subscriber each. The frame's header travels as the user header, its payload as a slice of doubles.
//! A frame that is longer than one sample travels as several, the last of them not full. So samples have
//! a fixed size, a 4 000 x 4 000 matrix needs no more shared memory than a greeting, and a container
//! with 64 MiB of `/dev/shm` is enough. Letting iceoryx2 grow its data segment instead was rejected: it
//! loses the sample when the sender leaves before the receiver has mapped the new segment.
//!
//! A waiting end polls for a while and then sleeps on an iceoryx2 event. If its waits are regular and no other program wants its
//! core, it is awake when the answer comes. The event is only a hint: the end sleeps in slices and looks again after each, so a
//! lost wake-up costs one slice and nothing hangs.
//!
//! The signal handlers of the process stay as they are: iceoryx2 installs its own only in waits that this
//! module does not use.
//!
//! - `services`: the iceoryx2 services and ports of a connection;
//! - `deadline`: the time that a call may take;
//! - `cleanup`: names of a run's files, and the removal of what dead runs left.

use std::path::Path;
use std::thread;
use std::time::Duration;

use iceoryx2::port::listener::ListenerWaitError;

use crate::frame::{Frame, Header};
use crate::link::waiting::Waiting;
use crate::link::{Link, LinkError};

mod cleanup;
mod deadline;
mod services;

pub use cleanup::{
    is_alive, left_by, mark_alive, remove_dead_runs, remove_run, run_prefix, run_root,
};
use deadline::Deadline;
use services::{Ports, SAMPLE_DOUBLES, Services, failed};

/// The most doubles that one frame can hold: 1 GiB, a square matrix of 11 585 rows.
pub const MAX_DOUBLES: usize = 1 << 27;

/// Longest sleep before looking again, with or without an event.
const SLICE: Duration = Duration::from_millis(20);

/// Shortest sleep: the system counts in microseconds, and zero means to sleep without end.
const SHORTEST: Duration = Duration::from_micros(1);

/// The way in which an end waits for the other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WaitMode {
    /// Polls for a while, yielding to other threads, and then sleeps.
    Poll,
    /// Sleeps almost at once, or yields for the expected length of the wait: right when processes share cores.
    Event,
    /// `Poll` if every process of the run can have a core to itself, `Event` otherwise.
    Auto {
        /// Processes of the run that compute or wait, the coordinator included.
        processes: usize,
    },
}

impl WaitMode {
    fn polls(self) -> bool {
        match self {
            WaitMode::Poll => true,
            WaitMode::Event => false,
            WaitMode::Auto { processes } => {
                processes <= thread::available_parallelism().map_or(1, usize::from)
            }
        }
    }
}

/// One end of a connection through shared memory. Its files disappear when both ends are dropped.
pub struct ShmLink {
    ports: Ports,
    waiting: Waiting,
    /// Both ports of the other end have been seen: from now on their absence means that it left.
    connected: bool,
    /// The frame whose sending ran out of patience half-way, and the number of its doubles that were sent. Only its rest can
    /// follow: the other end would take anything else for the rest.
    begun: Option<(Header, usize)>,
    /// Samples of a long frame that have arrived.
    arriving: Vec<f64>,
}

impl ShmLink {
    /// Creates the connection to a participant below `root`, with `prefix` before every name.
    pub fn coordinator(
        root: &Path,
        prefix: &str,
        participant: &str,
        wait: WaitMode,
    ) -> Result<ShmLink, LinkError> {
        let services = Services::new(root, prefix, participant)?;
        let polls = wait.polls();
        // The data services come last: the participant waits for them and then finds the others.
        let events = services.each_way(|way| services.create_event(way))?;
        let [request, answer] = services.each_way(|way| services.create_data(way, polls))?;
        Ok(ShmLink::new(
            services.ports(request, answer, events)?,
            polls,
        ))
    }

    /// Opens the connection that the coordinator has created or creates within `patience`.
    /// The participant uses the coordinator's wait mode.
    pub fn participant(
        root: &Path,
        prefix: &str,
        participant: &str,
        patience: Duration,
    ) -> Result<ShmLink, LinkError> {
        let services = Services::new(root, prefix, participant)?;
        let deadline = Deadline::new(patience);
        let [request, answer] = services.each_way(|way| services.open_data(way, &deadline))?;
        let [request_event, answer_event] = services.each_way(|way| services.open_event(way))?;
        let polls = services::polls(&request)?;
        let events = [answer_event, request_event];
        Ok(ShmLink::new(
            services.ports(answer, request, events)?,
            polls,
        ))
    }

    fn new(ports: Ports, polls: bool) -> ShmLink {
        ShmLink {
            ports,
            waiting: Waiting::new(polls),
            connected: false,
            begun: None,
            arriving: Vec::new(),
        }
    }

    /// Waits for both ports of the other end and connects to them, so that no frame is lost even if the other
    /// end sends it and leaves before we listen.
    fn connect(&mut self, deadline: &Deadline) -> Result<(), LinkError> {
        while !self.connected {
            if self.ports.other_is_there() {
                self.ports.subscriber.has_samples().map_err(failed)?;
                self.connected = true;
            } else {
                deadline.pause()?;
            }
        }
        Ok(())
    }

    /// True if the other end was dropped. A killed end goes unnoticed here: look at its process.
    fn has_left(&self) -> bool {
        self.connected && !self.ports.other_can_send()
    }

    fn send_sample(
        &mut self,
        header: Header,
        doubles: &[f64],
        deadline: &Deadline,
    ) -> Result<(), LinkError> {
        loop {
            let mut sample = self
                .ports
                .publisher
                .loan_slice_uninit(doubles.len())
                .map_err(failed)?;
            *sample.user_header_mut() = header;
            let receivers = sample.write_from_slice(doubles).send().map_err(failed)?;
            if receivers > 0 {
                // A failed wake-up delays the other end by at most a slice.
                let _ = self.ports.notifier.notify();
                return Ok(());
            }
            if self.has_left() {
                return Err(LinkError::Closed);
            }
            deadline.pause()?;
        }
    }

    /// The next frame, if it has arrived completely.
    fn take(&mut self) -> Result<Option<Frame>, LinkError> {
        while let Some(sample) = self.ports.subscriber.receive().map_err(failed)? {
            let doubles = sample.payload();
            let length = self.arriving.len() + doubles.len();
            if length > MAX_DOUBLES {
                return Err(too_long(length));
            }
            self.arriving.extend_from_slice(doubles);
            if doubles.len() < SAMPLE_DOUBLES {
                return Ok(Some(Frame {
                    header: *sample.user_header(),
                    payload: std::mem::take(&mut self.arriving),
                }));
            }
        }
        Ok(None)
    }

    fn sleep(&self, time: Duration) -> Result<(), LinkError> {
        match self
            .ports
            .listener
            .timed_wait(|_| {}, time.clamp(SHORTEST, SLICE))
        {
            Ok(_) | Err(ListenerWaitError::InterruptSignal) => Ok(()),
            Err(error) => Err(failed(error)),
        }
    }
}

impl Link for ShmLink {
    fn send(&mut self, frame: &Frame, patience: Duration) -> Result<(), LinkError> {
        let deadline = Deadline::new(patience);
        if frame.payload.len() > MAX_DOUBLES {
            return Err(too_long(frame.payload.len()));
        }
        let mut sent = match self.begun {
            None => 0,
            Some((header, sent)) if header == frame.header => sent,
            Some(_) => {
                return Err(failed(
                    "an earlier frame was sent only in part, and only its rest can follow",
                ));
            }
        };
        self.connect(&deadline)?;
        if self.has_left() {
            return Err(LinkError::Closed);
        }
        loop {
            let rest = &frame.payload[sent..];
            let sample = &rest[..rest.len().min(SAMPLE_DOUBLES)];
            self.send_sample(frame.header, sample, &deadline)?;
            sent += sample.len();
            let whole = sample.len() < SAMPLE_DOUBLES;
            self.begun = (!whole).then_some((frame.header, sent));
            if whole {
                return Ok(());
            }
        }
    }

    fn receive(&mut self, patience: Duration) -> Result<Option<Frame>, LinkError> {
        let deadline = Deadline::new(patience);
        self.waiting.begin();
        loop {
            if let Some(frame) = self.take()? {
                self.connected = true;
                self.waiting.arrived(&frame.header);
                return Ok(Some(frame));
            }
            if self.has_left() {
                // A frame from before it left may have arrived since we looked.
                return self.take()?.map(Some).ok_or(LinkError::Closed);
            }
            let left = deadline.left();
            if left.is_zero() {
                return Ok(None);
            }
            if !self.waiting.give_way() {
                self.sleep(left)?;
            }
        }
    }
}

fn too_long(doubles: usize) -> LinkError {
    LinkError::TooLong {
        doubles,
        capacity: MAX_DOUBLES,
    }
}
