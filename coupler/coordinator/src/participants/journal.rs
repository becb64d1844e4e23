//! The exchange journal: log and hash of all frames that carry interface data.

use std::path::Path;
use std::time::{Duration, Instant};

use exchange_log::{Entry, Exchange, ExchangeHasher, LogStats, Recorder, recover};
use scenario::error::{Refusal, Result};

/// Doubles that may wait to be written down.
const WAITING_DOUBLES: usize = 1 << 17;

/// Log and hash of an exchange. The messages of a window are hashed and logged while contacts are solved in the next one, so that nobody
/// waits for it, or when that ends.
#[derive(Default)]
pub struct Journal {
    waiting: Vec<Entry>,
    waiting_doubles: usize,
    hasher: ExchangeHasher,
    hash_wall: Duration,
    recorder: Option<Recorder>,
    blocks: u64,
}

/// A finished journal.
#[derive(Clone, Debug)]
pub struct Closed {
    /// `hashes.exchange`.
    pub hash: String,
    /// Wall-clock time that it took.
    pub hash_wall: Duration,
    /// The log, if there is one.
    pub log: Option<LogStats>,
}

impl Journal {
    /// An empty journal; it only hashes without a recorder.
    pub fn new(recorder: Option<Recorder>) -> Journal {
        Journal {
            recorder,
            ..Journal::default()
        }
    }

    /// Begins with the first `blocks` of the log of another run, which this one resumes. Returns the messages of the
    /// first of them, the handshake of a coupled run.
    pub fn carry_over(&mut self, log: &Path, blocks: u64) -> Result<Vec<Exchange>> {
        let mut first = Vec::new();
        for entry in recover(log)? {
            match entry? {
                Entry::Exchange(message) => {
                    if self.blocks == 0 {
                        first.push(message.clone());
                    }
                    self.add(message)?;
                }
                Entry::WindowEnd(window) => self.end_window(window)?,
            }
            if self.blocks == blocks {
                return Ok(first);
            }
        }
        let found = self.blocks;
        Err(Refusal::file(log, format!("{found} of {blocks} blocks can be read")).into())
    }

    /// Adds a message.
    pub fn add(&mut self, exchange: Exchange) -> Result<()> {
        self.waiting_doubles += exchange.frame.payload.len();
        self.waiting.push(Entry::Exchange(exchange));
        if self.waiting_doubles < WAITING_DOUBLES {
            return Ok(());
        }
        self.write_down()
    }

    /// Ends a block, the handshake or a window.
    pub fn end_window(&mut self, window: u64) -> Result<()> {
        let is_end = |entry: &Entry| matches!(entry, Entry::WindowEnd(_));
        if self.waiting.iter().any(is_end) {
            self.write_down()?;
        }
        self.blocks += 1;
        self.waiting.push(Entry::WindowEnd(window));
        Ok(())
    }

    /// Sees that the log is on the disk; returns how many blocks it holds.
    pub fn sync(&mut self) -> Result<u64> {
        self.write_down()?;
        if let Some(recorder) = &mut self.recorder {
            recorder.sync()?;
        }
        Ok(self.blocks)
    }

    /// Completes both; the messages of a window that did not end are in them.
    pub fn close(&mut self) -> Result<Closed> {
        let written = self.write_down();
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

    /// Hashes and logs what waits.
    pub fn write_down(&mut self) -> Result<()> {
        self.waiting_doubles = 0;
        let waiting = std::mem::take(&mut self.waiting);
        let start = Instant::now();
        waiting
            .iter()
            .for_each(|entry| self.hasher.add_entry(entry));
        self.hash_wall += start.elapsed();
        match &mut self.recorder {
            Some(recorder) => Ok(recorder.record(waiting)?),
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::thread::sleep;

    use exchange_log::Provenance;
    use kit::scratch::Scratch;
    use protocol::{Frame, Header, Kind};

    use super::*;

    fn said(iteration: u32) -> Exchange {
        let header = Header {
            iteration,
            ..Header::of(Kind::Report)
        };
        Exchange {
            frame: Frame::new(header, vec![1.0]),
            ..Exchange::default()
        }
    }

    /// A solver that runs alone solves no contacts for the coordinator to write meanwhile.
    #[test]
    fn a_window_is_on_its_way_to_the_log_when_the_next_one_ends() {
        let scratch = Scratch::new("journal", std::process::id().into());
        std::fs::create_dir_all(scratch.path()).expect("it can be made");
        let log = scratch.path().join("exchange.mcap");
        let recorder = Recorder::create(&log, &Provenance::default(), 1);
        let mut journal = Journal::new(Some(recorder.expect("it is created")));
        for window in [0, 1] {
            journal.add(said(0)).expect("it is added");
            journal.end_window(window).expect("it ends");
        }
        let start = Instant::now();
        let written = || {
            let entries: Vec<_> = recover(&log).expect("it is a log").flatten().collect();
            entries.contains(&Entry::WindowEnd(0))
        };
        while !written() {
            assert!(start.elapsed() < Duration::from_secs(20));
            sleep(Duration::from_millis(10));
        }
    }

    /// A message sorts before those of the window before its own, so that it must not come among them.
    #[test]
    fn messages_are_hashed_in_their_windows_whenever_they_are_written_down() {
        let [mut at_once, mut late] = [Journal::new(None), Journal::new(None)];
        let mut hasher = ExchangeHasher::default();
        for window in 0..4 {
            let message = said(9 - window);
            hasher.add_entry(&Entry::Exchange(message.clone()));
            hasher.end_window();
            for journal in [&mut at_once, &mut late] {
                journal.add(message.clone()).expect("it is added");
                journal.end_window(window.into()).expect("it ends");
            }
            at_once.write_down().expect("nothing is in its way");
        }
        let expected = hasher.finish();
        for mut journal in [at_once, late] {
            assert_eq!(journal.close().expect("it closes").hash, expected);
        }
    }
}
