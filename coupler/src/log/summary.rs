//! The contents of a log in numbers.

use std::collections::BTreeMap;
use std::path::Path;

use protocol::{Frame, Kind};

use super::entry::{Entry, Exchange, kind_name};
use super::error::LogError;
use super::hash::ExchangeHasher;
use super::provenance::Provenance;
use super::read::{read, recover};

/// A log in numbers.
#[derive(Debug)]
pub struct LogSummary {
    /// The run that the log belongs to.
    pub provenance: Provenance,
    /// In the order of their first message.
    pub streams: Vec<Stream>,
    /// Size of the file (bytes).
    pub file_bytes: u64,
    /// Blocks that ended: windows, and before them the handshake of a coupled run.
    pub windows: u64,
    /// The last of them.
    pub last_window: Option<u64>,
    /// Lengths and repeats of the windows.
    pub stats: WindowStats,
    /// The first number that is not finite, and its place.
    pub non_finite: Option<NonFinite>,
    /// `hashes.exchange`, to be compared with the run's summary.
    pub hash: String,
    /// Damage that ended a recovered log before its end.
    pub damage: Option<LogError>,
}

/// Lengths and repeats of the windows of a log.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct WindowStats {
    /// Windows by the number of their last iteration.
    pub by_iterations: BTreeMap<u32, u64>,
    /// Windows by the explicit steps that they stand for.
    pub by_substeps: BTreeMap<u32, u64>,
    /// Simulated time at the end of the last one (s).
    pub end_s: f64,
    /// Of the block at hand: last iteration, substeps and end of what was committed or done alone.
    open: Option<(u32, u32, f64)>,
}

impl WindowStats {
    /// A window ends with a commit, or is done alone.
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

/// All messages of one kind between two.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Stream {
    /// Name of the interface.
    pub interface: String,
    /// Their sender.
    pub sender: String,
    /// Their receiver.
    pub receiver: String,
    /// [`protocol::Kind`] as its number.
    pub kind: u32,
    /// Their number.
    pub messages: u64,
    /// Bytes of their payloads.
    pub bytes: u64,
    /// Window of the first.
    pub first_window: u64,
    /// Window of the last.
    pub last_window: u64,
}

impl Stream {
    /// The name of its channel in the log.
    pub fn topic(&self) -> String {
        format!(
            "{}/{}/{}",
            self.interface,
            self.sender,
            kind_name(self.kind)
        )
    }
}

/// A number that is not finite, and where it was.
#[derive(Clone, Debug, PartialEq)]
pub struct NonFinite {
    /// The channel.
    pub topic: String,
    /// The window.
    pub window: u64,
    /// Repeat of the window.
    pub iteration: u32,
    /// Entry of the payload.
    pub index: usize,
    /// The number.
    pub value: f64,
}

/// Reads a whole log; with `tolerant`, as much of it as can be read.
pub fn summarize(path: &Path, tolerant: bool) -> Result<LogSummary, LogError> {
    let mut log = if tolerant {
        recover(path)?
    } else {
        read(path)?
    };
    let mut summary = LogSummary {
        provenance: log.provenance().clone(),
        streams: Vec::new(),
        file_bytes: std::fs::metadata(path).map_or(0, |file| file.len()),
        windows: 0,
        last_window: None,
        stats: WindowStats::default(),
        non_finite: None,
        hash: String::new(),
        damage: None,
    };
    let mut hasher = ExchangeHasher::new();
    for entry in &mut log {
        match entry? {
            Entry::Exchange(exchange) => {
                hasher.add(&exchange.interface, &exchange.sender, &exchange.frame);
                summary.stats.see(&exchange.frame);
                summary.count(&exchange);
            }
            Entry::WindowEnd(window) => {
                hasher.end_window();
                summary.stats.end();
                summary.windows += 1;
                summary.last_window = Some(window);
            }
        }
    }
    summary.hash = hasher.finish();
    summary.damage = log.take_damage();
    Ok(summary)
}

impl LogSummary {
    fn count(&mut self, exchange: &Exchange) {
        let header = &exchange.frame.header;
        let same = |stream: &Stream| {
            stream.kind == header.kind
                && stream.sender == exchange.sender
                && stream.receiver == exchange.receiver
                && stream.interface == exchange.interface
        };
        let index = self.streams.iter().position(same).unwrap_or_else(|| {
            self.streams.push(Stream {
                interface: exchange.interface.clone(),
                sender: exchange.sender.clone(),
                receiver: exchange.receiver.clone(),
                kind: header.kind,
                messages: 0,
                bytes: 0,
                first_window: header.window,
                last_window: header.window,
            });
            self.streams.len() - 1
        });
        let stream = &mut self.streams[index];
        stream.messages += 1;
        stream.bytes += 8 * exchange.frame.payload.len() as u64;
        stream.last_window = header.window;
        if self.non_finite.is_none() {
            self.non_finite = first_non_finite(&exchange.frame).map(|(index, value)| NonFinite {
                topic: stream.topic(),
                window: header.window,
                iteration: header.iteration,
                index,
                value,
            });
        }
    }
}

/// Texts are not in the way: no eight bytes of UTF-8 make a double that is not finite.
fn first_non_finite(frame: &Frame) -> Option<(usize, f64)> {
    let mut values = frame.payload.iter().copied().enumerate();
    values.find(|(_, value)| !value.is_finite())
}
