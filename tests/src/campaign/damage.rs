//! Logs, checkpoints and tables that differ from what their run wrote.

use std::fs;
use std::path::Path;

use super::row::{FaultOutcome, FaultResult, Wrong};
use super::trial::FaultTrial;
use coordinator::run::checkpoint::{FOLDER, file};
use lab::random::Random;
use scenario::error::Error;

/// Bytes before the first record of a log.
const MAGIC: usize = 8;

/// Bytes of kind and length before the data of a record.
const FRAMING: usize = 9;

/// Kind of a chunk of messages.
const CHUNK: u8 = 6;

/// Damage to a file.
#[derive(Clone, Copy)]
enum Harm {
    Flip,
    Cut,
    Repeat,
}

/// Flips a bit of the log of a run, cuts the log off, or repeats one of its chunks. Right: `inspect`, `replay` and `resume` each
/// end with code 6, or give the hashes and messages of the undamaged log.
pub fn log(trial: &mut FaultTrial) -> FaultResult {
    whole(trial)?;
    let path = trial.path("out/exchange.mcap");
    let harms = [Harm::Flip, Harm::Cut, Harm::Repeat];
    harm(&path, harms[(trial.index % 3) as usize], &mut trial.random)?;
    let mut detected = false;
    for words in [
        &["inspect", "out"][..],
        &["replay", "out"],
        &["resume", "out", "--out", "again", "--json"],
    ] {
        let code = trial.verb(words)?;
        let text = fs::read_to_string(trial.path("stdout")).unwrap_or_default();
        let right = match (code, words[0]) {
            (Some(6), _) => true,
            (Some(0), "inspect") => text.contains(exchange(trial)),
            (Some(0), "replay") => !text.contains("departs") && text.contains("identical"),
            // Too little of the log is left for a comparison, and the message says so.
            (Some(8), "replay") => text.contains("nothing was compared"),
            (Some(0), _) => trial.is_bit_equal("again").is_ok(),
            _ => false,
        };
        if !right {
            let said = trial.said();
            return Err(format!("{words:?} ended with {code:?}: {text} {said}").into());
        }
        detected |= code == Some(6);
    }
    let word = if detected { "detected" } else { "harmless" };
    Ok(FaultOutcome::of(word))
}

/// Flips a bit of the newest checkpoint or cuts it off; in every other trial, of all checkpoints. Right: `resume` uses an older one or
/// begins again, to the bits of the undisturbed run, and says so; or it refuses by name (code 2) a checkpoint that claims another
/// version.
pub fn checkpoint(trial: &mut FaultTrial) -> FaultResult {
    whole(trial)?;
    let all = file::list(&trial.path("out").join(FOLDER));
    let skipped = match trial.index % 2 {
        0 => 0,
        _ => all.len().saturating_sub(1),
    };
    for found in &all[skipped..] {
        let harms = [Harm::Flip, Harm::Cut];
        let chosen = harms[trial.random.below(2) as usize];
        harm(&found.path, chosen, &mut trial.random)?;
    }
    let code = trial.verb(&["resume", "out", "--out", "again", "--json"])?;
    let said = trial.said();
    let named = said.contains("checkpoint");
    let word = match code {
        Some(0) if named => {
            trial.is_bit_equal("again")?;
            "resumed"
        }
        Some(2) if named => "refused",
        _ => return Err(format!("resume ended with {code:?}: {said}").into()),
    };
    Ok(FaultOutcome::of(word))
}

/// Flips a bit of the signals of a run, or cuts them off. Right: `report` ends with code 6 and names the table, and `resume` gives the
/// tables of the undisturbed run, or names the table that it cannot continue.
pub fn table(trial: &mut FaultTrial) -> FaultResult {
    whole(trial)?;
    let written = trial.json("out/summary.json")["tables"].clone();
    let harms = [Harm::Flip, Harm::Cut];
    let chosen = harms[(trial.index % 2) as usize];
    harm(&trial.path("out/signals.csv"), chosen, &mut trial.random)?;
    let code = trial.verb(&["report", "out"])?;
    if code != Some(6) || !trial.said().contains("signals.csv") {
        return Err(format!("report ended with {code:?}: {}", trial.said()).into());
    }
    let code = trial.verb(&["resume", "out", "--out", "again", "--json"])?;
    let said = trial.said();
    match code {
        Some(0) if trial.json("again/summary.json")["tables"] == written => {
            trial.is_bit_equal("again")?;
            Ok(FaultOutcome::of("resumed"))
        }
        Some(2) if said.contains("signals.csv") => Ok(FaultOutcome::of("refused")),
        _ => Err(format!("resume ended with {code:?}: {said}").into()),
    }
}

/// Lets a run complete, bit-equal.
fn whole(trial: &mut FaultTrial) -> Result<(), Wrong> {
    trial.start(&[])?;
    trial.end()?;
    trial.is_bit_equal("out")
}

/// The hash of the whole exchange.
fn exchange<'a>(trial: &FaultTrial<'a>) -> &'a str {
    trial.undisturbed.hashes[0].as_str().unwrap_or("none")
}

fn harm(path: &Path, harm: Harm, random: &mut Random) -> Result<(), Error> {
    let mut bytes = fs::read(path).map_err(Error::input(path.display()))?;
    match harm {
        Harm::Flip => {
            let place = random.below(bytes.len() as u64) as usize;
            bytes[place] ^= 1 << random.below(8);
        }
        Harm::Cut => bytes.truncate(random.below(bytes.len() as u64) as usize),
        Harm::Repeat => {
            let chunks = chunks(&bytes);
            let (start, end) = chunks[random.below(chunks.len() as u64) as usize];
            bytes = [&bytes[..end], &bytes[start..]].concat();
        }
    }
    fs::write(path, bytes).map_err(Error::output(path.display()))
}

/// Start and end of each chunk of a log.
fn chunks(bytes: &[u8]) -> Vec<(usize, usize)> {
    let mut found = Vec::new();
    let mut start = MAGIC;
    while let Some(length) = bytes.get(start + 1..start + FRAMING) {
        let length = u64::from_le_bytes(length.try_into().expect("eight bytes"));
        let end = start + FRAMING + length as usize;
        if bytes[start] == CHUNK && end <= bytes.len() {
            found.push((start, end));
        }
        start = end;
    }
    found
}
