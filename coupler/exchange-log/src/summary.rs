//! The contents of a log in numbers.

use std::collections::BTreeMap;
use std::path::Path;

use protocol::{Frame, Kind};
use serde::{Serialize, Serializer};

use super::entry::{Entry, Exchange};
use super::error::LogError;
use super::hash::ExchangeHasher;
use super::provenance::Provenance;
use super::read::LogFile;

/// A log in numbers.
#[derive(Debug, Default)]
pub struct LogSummary {
    /// The run that the log belongs to.
    pub provenance: Provenance,
    /// Streams in the order of their first message.
    pub streams: Vec<Stream>,
    /// Size of the file (bytes).
    pub file_bytes: u64,
    /// Number of complete blocks: windows, and before them the handshake of a coupled run.
    pub windows: u64,
    /// The last complete window.
    pub last_window: Option<u64>,
    /// Lengths and repeats of the windows.
    pub stats: WindowStats,
    /// The first NaN or infinite number, and its position.
    pub non_finite: Option<NonFinite>,
    /// `hashes.exchange`, to compare with the run's summary.
    pub hash: String,
    /// Damage that ended a recovered log before its end.
    pub damage: Option<LogError>,
}

/// Lengths and repeats of the windows of a log.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct WindowStats {
    /// Number of windows by their last iteration.
    pub by_iterations: BTreeMap<u32, u64>,
    /// Number of windows by their explicit steps.
    pub by_substeps: BTreeMap<u32, u64>,
    /// Simulated time at the end of the last window (s).
    pub end_s: f64,
    /// Last iteration, substeps and end of the current window, once it is committed or done alone.
    open: Option<(u32, u32, f64)>,
}

impl WindowStats {
    /// Records the end of a window: a commit, or an advance alone.
    fn see(&mut self, frame: &Frame) {
        if let Ok(Kind::Commit | Kind::AdvanceAlone) = frame.kind() {
            let header = &frame.header;
            self.open = Some((header.iteration, header.substeps, header.t1_s));
        }
    }

    fn end(&mut self) {
        if let Some((iteration, substeps, end_s)) = self.open.take() {
            *self.by_iterations.entry(iteration).or_default() += 1;
            *self.by_substeps.entry(substeps).or_default() += 1;
            self.end_s = end_s;
        }
    }
}

/// All messages of one kind from a sender to a receiver.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Stream {
    /// Name of its channel in the log.
    pub topic: String,
    /// Name of the interface.
    pub interface: String,
    /// Sender.
    pub sender: String,
    /// Receiver.
    pub receiver: String,
    /// Number of messages.
    pub messages: u64,
    /// Bytes of all payloads.
    #[serde(rename = "payload_bytes")]
    pub bytes: u64,
    /// Window of the first message.
    pub first_window: u64,
    /// Window of the last message.
    pub last_window: u64,
}

/// A NaN or infinite number, and its position.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct NonFinite {
    /// The channel.
    pub topic: String,
    /// The window.
    pub window: u64,
    /// Repeat of the window.
    pub iteration: u32,
    /// Entry of the payload.
    pub entry: usize,
    /// The number; as text in JSON, which has no such numbers.
    #[serde(serialize_with = "as_text")]
    pub value: f64,
}

fn as_text<S: Serializer>(value: &f64, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_str(value)
}

/// Reads a whole log; with `tolerant`, its readable part.
pub fn summarize(path: &Path, tolerant: bool) -> Result<LogSummary, LogError> {
    let mut log = LogFile::open(path, tolerant)?;
    let mut summary = LogSummary {
        provenance: log.provenance.clone(),
        file_bytes: std::fs::metadata(path).map_or(0, |file| file.len()),
        ..LogSummary::default()
    };
    let mut hasher = ExchangeHasher::default();
    for entry in &mut log {
        let entry = entry?;
        hasher.add_entry(&entry);
        match entry {
            Entry::Exchange(exchange) => {
                summary.stats.see(&exchange.frame);
                summary.count(&exchange);
            }
            Entry::WindowEnd(window) => {
                summary.stats.end();
                summary.windows += 1;
                summary.last_window = Some(window);
            }
        }
    }
    summary.hash = hasher.finish();
    summary.damage = log.damage;
    Ok(summary)
}

impl LogSummary {
    fn count(&mut self, exchange: &Exchange) {
        let (frame, topic) = (&exchange.frame, exchange.topic());
        let (header, receiver) = (&frame.header, &exchange.receiver);
        let same = |stream: &Stream| stream.topic == topic && stream.receiver == *receiver;
        let index = self.streams.iter().position(same).unwrap_or_else(|| {
            self.streams.push(Stream {
                topic: topic.clone(),
                interface: exchange.interface.clone(),
                sender: exchange.sender.clone(),
                receiver: receiver.clone(),
                first_window: header.window,
                ..Stream::default()
            });
            self.streams.len() - 1
        });
        let stream = &mut self.streams[index];
        stream.messages += 1;
        stream.bytes += 8 * frame.payload.len() as u64;
        stream.last_window = header.window;
        // Texts cannot trigger this: no eight bytes of UTF-8 form a NaN or an infinity.
        let odd = frame.payload.iter().position(|value| !value.is_finite());
        if let Some(entry) = odd.filter(|_| self.non_finite.is_none()) {
            self.non_finite = Some(NonFinite {
                topic,
                window: header.window,
                iteration: header.iteration,
                entry,
                value: frame.payload[entry],
            });
        }
    }
}
