//! Throughput of the exchange log: written through the recorder as in a run, lz4 and checksums included, and read back.

use std::path::Path;
use std::time::Instant;

use protocol::{Frame, Header, Kind};
use serde::Serialize;

use crate::random::Random;
use coordinator::run::session::fresh_run_id;
use exchange_log::{Entry, Exchange, LogStats, Provenance, Recorder, read};
use kit::scratch::Scratch;
use scenario::error::{Error, Refusal};

/// Doubles written for each row, 64 MB.
const DOUBLES: usize = 8_000_000;
/// Messages of a window, as of one continuum and one layer.
const PER_WINDOW: usize = 10;
/// Windows between two flushes, as in a run.
const FLUSH_EVERY: u64 = 100;

/// One row of the table. MB are 10^6 bytes of payload.
#[derive(Clone, Debug, Serialize)]
pub struct LogRow {
    /// Doubles in a message; their mantissas are random, so that nothing packs.
    pub doubles: usize,
    /// Messages.
    pub messages: u64,
    /// Payload written (MB/s), the end of the file included.
    pub write_mb_per_s: f64,
    /// Messages written (1/s).
    pub write_messages_per_s: f64,
    /// Payload read back with every checksum verified (MB/s).
    pub read_mb_per_s: f64,
    /// Messages read back (1/s).
    pub read_messages_per_s: f64,
    /// Bytes of the file for a byte of payload.
    pub file_over_payload: f64,
}

/// Messages of 100, 1 000 and 10 000 doubles, in the system's temporary folder.
pub fn bench() -> Result<Vec<LogRow>, Error> {
    let scratch = Scratch::new("bench-log", fresh_run_id());
    let folder = scratch.path();
    std::fs::create_dir_all(folder).map_err(Error::output(folder.display()))?;
    let path = folder.join("exchange.mcap");
    let sizes = [100, 1_000, 10_000].into_iter();
    sizes.map(|doubles| row(&path, doubles)).collect()
}

fn row(path: &Path, doubles: usize) -> Result<LogRow, Error> {
    let frames = frames(doubles);
    let start = Instant::now();
    let stats = write(path, &frames, DOUBLES / doubles)?;
    let write_s = start.elapsed().as_secs_f64();
    let start = Instant::now();
    let found = count(path)?;
    let read_s = start.elapsed().as_secs_f64();
    if found != stats.messages {
        let why = format!("{found} of {} messages were read back", stats.messages);
        return Err(Refusal::Benchmark(why).into());
    }
    let messages = stats.messages as f64;
    let payload_bytes = 8.0 * messages * doubles as f64;
    Ok(LogRow {
        doubles,
        messages: stats.messages,
        write_mb_per_s: 1e-6 * payload_bytes / write_s,
        write_messages_per_s: messages / write_s,
        read_mb_per_s: 1e-6 * payload_bytes / read_s,
        read_messages_per_s: messages / read_s,
        file_over_payload: stats.bytes as f64 / payload_bytes,
    })
}

/// Makes as many different messages as a chunk holds, so that none is packed as the copy of another.
fn frames(doubles: usize) -> Vec<Frame> {
    let mut random = Random::new(1);
    let mut frame = |_| {
        let payload = (0..doubles).map(|_| random.share() - 0.5).collect();
        Frame::new(Header::of(Kind::Motion), payload)
    };
    (0..(200_000 / doubles).max(20)).map(&mut frame).collect()
}

fn write(path: &Path, frames: &[Frame], messages: usize) -> Result<LogStats, Error> {
    let mut recorder = Recorder::create(path, &Provenance::default(), FLUSH_EVERY)?;
    let said: Vec<&Frame> = frames.iter().cycle().take(messages).collect();
    for (window, said) in (0..).zip(said.chunks(PER_WINDOW)) {
        let said = said.iter().map(|frame| {
            let mut frame = Frame::clone(frame);
            frame.header.window = window;
            Entry::Exchange(Exchange {
                interface: "layer-base".into(),
                sender: "rail".into(),
                receiver: "coupler".into(),
                frame,
            })
        });
        recorder.record(said.chain([Entry::WindowEnd(window)]).collect())?;
    }
    Ok(recorder.finish()?)
}

fn count(path: &Path) -> Result<u64, Error> {
    let mut found = 0;
    for entry in read(path)? {
        found += u64::from(matches!(entry?, Entry::Exchange(_)));
    }
    Ok(found)
}
