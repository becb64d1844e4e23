//! The exchange journal: log and hash of all frames with interface data.

use std::path::Path;
use std::time::{Duration, Instant};

use exchange_log::{Entry, Exchange, ExchangeHasher, LogStats, Recorder, recover};
use scenario::error::{Refusal, Result};

/// Number of doubles that may wait to be logged.
const WAITING_DOUBLES: usize = 1 << 17;

/// Log and hash of an exchange. The messages of a window are hashed and logged while contacts are solved in the next
/// one, so that no process waits for it, or at the end of the next one.
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
    /// Wall-clock time for the hash.
    pub hash_wall: Duration,
    /// The log, if there is one.
    pub log: Option<LogStats>,
}

impl Journal {
    /// An empty journal; without a recorder it only hashes.
    pub fn new(recorder: Option<Recorder>) -> Journal {
        Journal {
            recorder,
            ..Journal::default()
        }
    }

    /// Begins with the first `blocks` of the log of another run, which this run resumes. Returns the messages of the
    /// first block, the handshake of a coupled run.
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

    /// Writes the log to the disk; returns its number of blocks.
    pub fn sync(&mut self) -> Result<u64> {
        self.write_down()?;
        self.recorder.as_mut().map_or(Ok(()), Recorder::sync)?;
        Ok(self.blocks)
    }

    /// Completes log and hash, which include the messages of an unfinished window.
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

    /// Hashes and logs the waiting messages.
    pub fn write_down(&mut self) -> Result<()> {
        self.waiting_doubles = 0;
        let waiting = std::mem::take(&mut self.waiting);
        let start = Instant::now();
        for entry in &waiting {
            self.hasher.add_entry(entry);
        }
        self.hash_wall += start.elapsed();
        let recorder = self.recorder.as_mut();
        Ok(recorder.map_or(Ok(()), |recorder| recorder.record(waiting))?)
    }
}

#[cfg(test)]
mod tests {
    use std::thread::sleep;

    use exchange_log::Provenance;
    use kit::scratch::Scratch;
    use protocol::{Frame, Header, Kind};

    use super::*;

    fn message(iteration: u32) -> Exchange {
        let header = Header {
            iteration,
            ..Header::of(Kind::Report)
        };
        Exchange {
            frame: Frame::new(header, vec![1.0]),
            ..Exchange::default()
        }
    }

    /// A solver that runs alone gives the coordinator no contact solves during which to write.
    #[test]
    fn a_window_is_logged_when_the_next_one_ends() {
        let scratch = Scratch::new("journal", std::process::id().into());
        std::fs::create_dir_all(scratch.path()).expect("it can be made");
        let log = scratch.path().join("exchange.mcap");
        let recorder = Recorder::create(&log, &Provenance::default(), 1);
        let mut journal = Journal::new(Some(recorder.expect("it is created")));
        for window in [0, 1] {
            journal.add(message(0)).expect("it is added");
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

    /// The message of a window sorts before the messages of the previous one, so that it must not be hashed among them.
    #[test]
    fn messages_are_hashed_in_their_windows_at_any_time_of_logging() {
        let [mut at_once, mut late] = [Journal::new(None), Journal::new(None)];
        let mut hasher = ExchangeHasher::default();
        for window in 0..4 {
            let message = message(9 - window);
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
