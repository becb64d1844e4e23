//! `timing.mcap`: the wall-clock times of the requests of a run, separate from the exchange, which is the same for equal runs.
//!
//! Each participant has two channels of JSON messages. `NAME/requests` contains the answered requests in order, as lists: `kind` (number of
//! [`protocol::Kind`]), `window`, `iteration`, and the times at which the coordinator sent a request, began to wait for its answer and had
//! the answer. `NAME/work`, one message at the end, is the participant's own report: its times at work, and its totals. Times are ns of the
//! monotonic clock of the coordinator's host.

use std::collections::BTreeMap;
use std::fmt::Display;
use std::fs::{self, File};
use std::io::BufWriter;
use std::path::Path;

use mcap::read::Options;
use mcap::records::MessageHeader;
use mcap::{Compression, McapError, MessageStream, WriteOptions, Writer};
use protocol::Header;
use protocol::busy::{BusyTimes, monotonic_ns};
use protocol::serve::Farewell;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use super::error::LogError;

/// Name of the file in a run directory.
pub const TIMING: &str = "timing.mcap";

/// Number of requests per message: about 40 kB of text.
const BATCH: usize = 512;

/// One answered request.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RequestTimes {
    /// Number of its [`protocol::Kind`].
    pub kind: u32,
    /// Its window.
    pub window: u64,
    /// Repeat of the window.
    pub iteration: u32,
    /// Time at which the coordinator sent it (ns).
    pub asked_ns: u64,
    /// Time at which the coordinator began to wait for the answer (ns).
    pub awaited_ns: u64,
    /// Time at which the coordinator had the answer (ns).
    pub answered_ns: u64,
}

impl RequestTimes {
    /// A request with this header, answered now.
    pub fn answered_now(header: &Header, asked_ns: u64, awaited_ns: u64) -> RequestTimes {
        RequestTimes {
            kind: header.kind,
            window: header.window,
            iteration: header.iteration,
            asked_ns,
            awaited_ns,
            answered_ns: monotonic_ns(),
        }
    }
}

/// Requests as lists, one entry per request.
#[derive(Serialize, Deserialize)]
struct Batch {
    kind: Vec<u32>,
    window: Vec<u64>,
    iteration: Vec<u32>,
    asked_ns: Vec<u64>,
    awaited_ns: Vec<u64>,
    answered_ns: Vec<u64>,
}

impl Batch {
    fn of(requests: &[RequestTimes]) -> Batch {
        let all = || requests.iter();
        Batch {
            kind: all().map(|one| one.kind).collect(),
            window: all().map(|one| one.window).collect(),
            iteration: all().map(|one| one.iteration).collect(),
            asked_ns: all().map(|one| one.asked_ns).collect(),
            awaited_ns: all().map(|one| one.awaited_ns).collect(),
            answered_ns: all().map(|one| one.answered_ns).collect(),
        }
    }

    /// The requests; `None` if the lists differ in length.
    fn requests(&self) -> Option<Vec<RequestTimes>> {
        let request = |at: usize| {
            Some(RequestTimes {
                kind: *self.kind.get(at)?,
                window: *self.window.get(at)?,
                iteration: *self.iteration.get(at)?,
                asked_ns: *self.asked_ns.get(at)?,
                awaited_ns: *self.awaited_ns.get(at)?,
                answered_ns: *self.answered_ns.get(at)?,
            })
        };
        (0..self.kind.len()).map(request).collect()
    }
}

/// The report of a participant about its own time.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct OwnTimes {
    /// Wall-clock time at work without set-up (s).
    pub solve_wall_s: f64,
    /// Wall-clock time of the set-up (s).
    pub setup_wall_s: f64,
    /// Wall-clock time of the rest (s).
    pub wait_s: f64,
    /// Time spans at work.
    pub busy: BusyTimes,
}

impl OwnTimes {
    /// The times in a farewell.
    pub fn of(farewell: &Farewell) -> OwnTimes {
        OwnTimes {
            solve_wall_s: farewell.solve_wall_s,
            setup_wall_s: farewell.setup_wall_s,
            wait_s: farewell.wait_s,
            busy: farewell.busy.clone(),
        }
    }
}

/// One participant in timing.mcap.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ParticipantTimes {
    /// Its name in the scenario.
    pub name: String,
    /// The answered requests, in order.
    pub requests: Vec<RequestTimes>,
    /// Its own report; `None` if the run ended before.
    pub own: Option<OwnTimes>,
}

/// Writes timing.mcap. Requests wait in memory until they form a batch.
pub struct TimingLog {
    writer: Writer<BufWriter<File>>,
    participants: Vec<Waiting>,
}

/// Channels of a participant, and its unwritten requests.
struct Waiting {
    channels: [u16; 2],
    requests: Vec<RequestTimes>,
}

impl TimingLog {
    /// Starts the file for participants with these names, replacing any file at `path`.
    pub fn create(path: &Path, names: &[&str]) -> Result<TimingLog, LogError> {
        let file = File::create(path).map_err(LogError::write(path))?;
        TimingLog::start(file, names).map_err(LogError::write(path))
    }

    fn start(file: File, names: &[&str]) -> Result<TimingLog, McapError> {
        // As in the exchange log, a killed writer leaves whole chunks.
        let options = WriteOptions::new()
            .profile("thirdbody")
            .compression(Some(Compression::Lz4))
            .chunk_size(Some(1 << 18))
            .disable_seeking(true);
        let mut writer = options.create(BufWriter::new(file))?;
        let mut channel = |name: &str, what: &str| {
            let topic = format!("{name}/{what}");
            writer.add_channel(0, &topic, "json", &BTreeMap::new())
        };
        let mut participants = Vec::new();
        for name in names {
            participants.push(Waiting {
                channels: [channel(name, REQUESTS)?, channel(name, WORK)?],
                requests: Vec::new(),
            });
        }
        Ok(TimingLog {
            writer,
            participants,
        })
    }

    /// Moves the answered requests of a participant into the log.
    pub fn add(
        &mut self,
        participant: usize,
        requests: &mut Vec<RequestTimes>,
    ) -> Result<(), McapError> {
        let waiting = &mut self.participants[participant].requests;
        waiting.append(requests);
        if waiting.len() < BATCH {
            return Ok(());
        }
        self.write_down(participant)
    }

    /// Adds a participant's own report, at the end.
    pub fn tell(&mut self, participant: usize, own: &OwnTimes) -> Result<(), McapError> {
        self.write_down(participant)?;
        self.put(self.participants[participant].channels[1], own)
    }

    /// Completes the file.
    pub fn finish(&mut self) -> Result<(), McapError> {
        (0..self.participants.len()).try_for_each(|participant| self.write_down(participant))?;
        self.writer.finish().map(|_| ())
    }

    fn write_down(&mut self, participant: usize) -> Result<(), McapError> {
        let waiting = &mut self.participants[participant];
        let channel = waiting.channels[0];
        let batch = Batch::of(&waiting.requests);
        waiting.requests.clear();
        if batch.kind.is_empty() {
            return Ok(());
        }
        self.put(channel, &batch)
    }

    fn put<T: Serialize>(&mut self, channel_id: u16, message: &T) -> Result<(), McapError> {
        let now = monotonic_ns();
        let header = MessageHeader {
            channel_id,
            sequence: 0,
            log_time: now,
            publish_time: now,
        };
        let text = serde_json::to_vec(message).expect("our own types always serialise");
        self.writer.write_to_known_channel(&header, &text)
    }
}

const REQUESTS: &str = "requests";
const WORK: &str = "work";

/// The contents of timing.mcap.
#[derive(Debug, Default)]
pub struct Timing {
    /// Participants, in the order of the scenario.
    pub participants: Vec<ParticipantTimes>,
    /// Reason why the file ends early: its writer was killed, or it is damaged.
    pub cut_off: Option<String>,
}

/// Reads the whole part of timing.mcap.
pub fn read(path: &Path) -> Result<Timing, LogError> {
    let bytes = fs::read(path).map_err(LogError::read(path))?;
    let stream = MessageStream::new_with_options(&bytes, Options::IgnoreEndMagic.into());
    let not_ours = |why: String| LogError::NotALog {
        path: path.into(),
        why,
        torn: false,
    };
    let mut timing = Timing::default();
    for message in stream.map_err(|error| not_ours(error.to_string()))? {
        let Ok(message) = message.inspect_err(|error| timing.cut_off = Some(error.to_string()))
        else {
            break;
        };
        let taken = timing.take(&message.channel.topic, &message.data);
        taken.map_err(not_ours)?;
    }
    Ok(timing)
}

impl Timing {
    fn take(&mut self, topic: &str, data: &[u8]) -> Result<(), String> {
        let unknown = || format!("it has a channel `{topic}`");
        let (name, what) = topic.rsplit_once('/').ok_or_else(unknown)?;
        let participant = self.participant(name);
        match what {
            REQUESTS => {
                let batch: Batch = parsed(topic, data)?;
                let uneven = || broken(topic, "its lists differ in length");
                let requests = batch.requests().ok_or_else(uneven)?;
                participant.requests.extend(requests);
            }
            WORK => participant.own = Some(parsed(topic, data)?),
            _ => return Err(unknown()),
        }
        Ok(())
    }

    fn participant(&mut self, name: &str) -> &mut ParticipantTimes {
        let known = self.participants.iter().position(|one| one.name == name);
        let at = known.unwrap_or(self.participants.len());
        if known.is_none() {
            self.participants.push(ParticipantTimes::default());
            self.participants[at].name = name.into();
        }
        &mut self.participants[at]
    }
}

fn parsed<T: DeserializeOwned>(topic: &str, data: &[u8]) -> Result<T, String> {
    serde_json::from_slice(data).map_err(|error| broken(topic, error))
}

fn broken(topic: &str, why: impl Display) -> String {
    format!("a message of `{topic}` cannot be read: {why}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use kit::scratch::Scratch;

    fn request(at: u64) -> RequestTimes {
        RequestTimes {
            kind: 7,
            window: at,
            iteration: at as u32 % 3,
            asked_ns: 100 * at,
            awaited_ns: 100 * at + 10,
            answered_ns: 100 * at + 90,
        }
    }

    fn written(folder: &Path, count: u64, own: &OwnTimes) -> Vec<u8> {
        let path = folder.join(TIMING);
        fs::create_dir_all(folder).expect("the folder can be made");
        let mut log = TimingLog::create(&path, &["rail", "third/body"]).expect("it can be written");
        for at in 0..count {
            log.add(0, &mut vec![request(at)]).expect("it takes them");
        }
        log.add(1, &mut vec![request(5)]).expect("it takes one");
        log.tell(1, own).expect("it takes the end");
        log.finish().expect("it can be closed");
        fs::read(path).expect("it was just written")
    }

    #[test]
    fn all_times_are_restored_in_order() {
        let scratch = Scratch::new("timing", 1);
        let own = OwnTimes {
            solve_wall_s: 0.25,
            busy: BusyTimes {
                every: 2,
                spans_ns: vec![[3, 9]],
            },
            ..OwnTimes::default()
        };
        let count = 3 * BATCH as u64 + 7;
        written(scratch.path(), count, &own);
        let timing = read(&scratch.path().join(TIMING)).expect("it is whole");
        assert_eq!(timing.cut_off, None);
        let by_name = |name| timing.participants.iter().find(|one| one.name == name);
        let rail = by_name("rail").expect("it is there");
        let all: Vec<RequestTimes> = (0..count).map(request).collect();
        assert_eq!((&rail.requests, &rail.own), (&all, &None));
        let layer = by_name("third/body").expect("it is there");
        assert_eq!(layer.requests, [request(5)]);
        assert_eq!(layer.own.as_ref(), Some(&own));
    }

    #[test]
    fn the_beginning_of_a_truncated_file_is_read() {
        let scratch = Scratch::new("timing", 2);
        let bytes = written(scratch.path(), 30_000, &OwnTimes::default());
        let path = scratch.path().join("torn.mcap");
        fs::write(&path, &bytes[..bytes.len() / 2]).expect("it can be written");
        let timing = read(&path).expect("its beginning is whole");
        assert!(timing.cut_off.is_some());
        let found = &timing.participants[0].requests;
        assert!(!found.is_empty() && found.len() < 30_000);
        assert!((0..).zip(found).all(|(at, one)| *one == request(at)));
    }
}
