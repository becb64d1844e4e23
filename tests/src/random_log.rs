//! Exchange logs of random messages, written through the recorder as in a run, with lz4 and checksums.

use std::path::Path;

use exchange_log::{Entry, Exchange, LogError, LogStats, Provenance, Recorder, read};
use lab::random::Random;
use protocol::{Frame, Header, Kind};

/// Messages per window, as with one continuum and one layer.
const PER_WINDOW: usize = 10;
/// Windows between two flushes, as in a run.
const FLUSH_EVERY: u64 = 100;

/// Different messages of `doubles` doubles, as many as fit a chunk, so that none compresses as a copy of another. Random mantissas do
/// not compress.
pub fn frames(doubles: usize) -> Vec<Frame> {
    let mut random = Random::new(1);
    let mut frame = |_| {
        let payload = (0..doubles).map(|_| random.share() - 0.5).collect();
        Frame::new(Header::of(Kind::Motion), payload)
    };
    (0..(200_000 / doubles).max(20)).map(&mut frame).collect()
}

/// Writes `messages` messages, each a copy of one of the frames.
pub fn write(path: &Path, frames: &[Frame], messages: usize) -> Result<LogStats, LogError> {
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
    recorder.finish()
}

/// Reads a log with every checksum verified, and counts its messages.
pub fn count(path: &Path) -> Result<u64, LogError> {
    let mut found = 0;
    for entry in read(path)? {
        found += u64::from(matches!(entry?, Entry::Exchange(_)));
    }
    Ok(found)
}
