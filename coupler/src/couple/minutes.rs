//! The minutes of a conversation: the log and the hash of what was said.

use std::time::{Duration, Instant};

use crate::error::Error;
use crate::log::{Exchange, ExchangeHasher, LogStats, Recorder};

/// Doubles that may wait for the end of their window.
const WAITING_DOUBLES: usize = 1 << 17;

/// What was said in a window is hashed and logged when it ends: the participants are then at work on the next one, so that
/// nobody waits for it.
pub(super) struct Minutes {
    waiting: Vec<Exchange>,
    waiting_doubles: usize,
    hasher: ExchangeHasher,
    hash_wall: Duration,
    recorder: Option<Recorder>,
    blocks: u64,
}

/// What a conversation leaves.
#[derive(Clone, Debug)]
pub struct Closed {
    /// `hashes.exchange`.
    pub hash: String,
    /// Wall-clock time that it took.
    pub hash_wall: Duration,
    /// The log, if there is one.
    pub log: Option<LogStats>,
}

impl Minutes {
    pub(super) fn new(recorder: Option<Recorder>) -> Minutes {
        Minutes {
            waiting: Vec::new(),
            waiting_doubles: 0,
            hasher: ExchangeHasher::new(),
            hash_wall: Duration::ZERO,
            recorder,
            blocks: 0,
        }
    }

    /// Blocks that ended.
    pub(super) fn blocks(&self) -> u64 {
        self.blocks
    }

    pub(super) fn add(&mut self, exchange: Exchange) -> Result<(), Error> {
        self.waiting_doubles += exchange.frame.payload.len();
        self.waiting.push(exchange);
        match self.waiting_doubles < WAITING_DOUBLES {
            true => Ok(()),
            false => self.write_down(None),
        }
    }

    pub(super) fn end_window(&mut self, window: u64) -> Result<(), Error> {
        self.blocks += 1;
        self.write_down(Some(window))
    }

    /// Sees that the log is on the disk; returns how many blocks it holds.
    pub(super) fn sync(&mut self) -> Result<u64, Error> {
        self.write_down(None)?;
        if let Some(recorder) = &mut self.recorder {
            recorder.sync()?;
        }
        Ok(self.blocks)
    }

    /// Completes both; what was said in a window that did not end is in them.
    pub(super) fn close(&mut self) -> Result<Closed, Error> {
        let written = self.write_down(None);
        let start = Instant::now();
        let hash = std::mem::take(&mut self.hasher).finish();
        let hash_wall = self.hash_wall + start.elapsed();
        let log = self.recorder.take().map(Recorder::finish).transpose()?;
        written?;
        Ok(Closed {
            hash,
            hash_wall,
            log,
        })
    }

    /// Hashes and logs what waits, and the end of a window if it is one.
    fn write_down(&mut self, window: Option<u64>) -> Result<(), Error> {
        self.waiting_doubles = 0;
        let waiting = std::mem::take(&mut self.waiting);
        let start = Instant::now();
        for exchange in &waiting {
            let (interface, sender) = (&exchange.interface, &exchange.sender);
            self.hasher.add(interface, sender, &exchange.frame);
        }
        if window.is_some() {
            self.hasher.end_window();
        }
        self.hash_wall += start.elapsed();
        match &mut self.recorder {
            Some(recorder) => Ok(recorder.record(waiting, window)?),
            None => Ok(()),
        }
    }
}
