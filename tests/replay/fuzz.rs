//! Damaged logs: for any damage, reading gives an error or exactly the written messages, never a panic and never another stream.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};

use exchange_log::{Entry, LogError, Provenance};
use harness::runs::{Left, run_in_process};

use crate::scenario;

/// A log of a plastic bar with repeats and halved windows, written by a run in several chunks.
fn real_log() -> (Left, Vec<u8>) {
    let sets = ["run.end_s=90.0", "run.output.flush_every_windows=5"];
    let left = run_in_process(&scenario(), &sets)
        .expect("it is valid")
        .completed();
    let bytes = std::fs::read(left.scratch.path().join("exchange.mcap")).expect("the run wrote it");
    (left, bytes)
}

/// Messages that a reader got, and the damage that was reported to it.
struct Got {
    provenance: Provenance,
    entries: Vec<Entry>,
    damage: Option<LogError>,
}

fn strictly(path: &Path) -> Result<Got, LogError> {
    let log = exchange_log::read(path)?;
    let mut got = Got {
        provenance: log.provenance.clone(),
        entries: Vec::new(),
        damage: None,
    };
    for entry in log {
        match entry {
            Ok(entry) => got.entries.push(entry),
            Err(error) => got.damage = Some(error),
        }
    }
    Ok(got)
}

fn tolerantly(path: &Path) -> Result<Got, LogError> {
    let mut log = exchange_log::recover(path)?;
    let mut got = Got {
        provenance: log.provenance.clone(),
        entries: Vec::new(),
        damage: None,
    };
    for entry in &mut log {
        got.entries.push(entry?);
    }
    got.damage = log.damage.as_ref().map(|error| LogError::Write {
        path: path.into(),
        why: error.to_string(),
    });
    Ok(got)
}

type Way = fn(&Path) -> Result<Got, LogError>;

/// Reads bytes in every way and compares with the written messages. Returns whether damage was reported.
fn judge(path: &Path, bytes: &[u8], whole: &Got, what: &str) -> bool {
    std::fs::write(path, bytes).expect("the folder is writable");
    let ways: [(&str, Way); 2] = [("read", strictly), ("recover", tolerantly)];
    let mut reported = false;
    for (name, way) in ways {
        let result = catch_unwind(AssertUnwindSafe(|| way(path)));
        let Ok(result) = result else {
            panic!("{name} panics: {what}");
        };
        // A file whose very beginning is damaged is refused as a whole.
        let Ok(got) = result else {
            reported = true;
            continue;
        };
        let begins = got.entries.len() <= whole.entries.len()
            && got.entries == whole.entries[..got.entries.len()];
        assert!(begins, "{name} gives another stream: {what}");
        if got.damage.is_some() {
            reported = true;
            continue;
        }
        assert_eq!(got.entries.len(), whole.entries.len(), "{name}: {what}");
        assert!(got.provenance == whole.provenance, "{name}: {what}");
    }
    // The reader of `inspect --recover`.
    let summary = catch_unwind(AssertUnwindSafe(|| exchange_log::summarize(path, true)));
    assert!(summary.is_ok(), "inspect panics: {what}");
    reported
}

#[test]
fn ten_thousand_flipped_bits_never_give_another_stream() {
    let (left, bytes) = real_log();
    let path = left.scratch.path().join("damaged.mcap");
    let whole = strictly(&left.scratch.path().join("exchange.mcap")).expect("it is sound");
    assert!(whole.damage.is_none() && whole.entries.len() > 100);
    assert!(!judge(&path, &bytes, &whole, "nothing was changed"));
    // A linear congruential generator (Knuth 1997, vol. 2, 3.3.4).
    let mut random = 6u64;
    let mut reported = 0;
    for _ in 0..10_000 {
        random = random
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        let bit = (random >> 16) as usize % (8 * bytes.len());
        let mut damaged = bytes.clone();
        damaged[bit / 8] ^= 1 << (bit % 8);
        reported += usize::from(judge(&path, &damaged, &whole, &format!("bit {bit}")));
    }
    println!(
        "{} bytes: {reported} of 10 000 flipped bits were reported",
        bytes.len()
    );
    assert_eq!(reported, 10_000, "every bit is under a checksum");
}

/// Ends of records: kind, length in eight bytes, data (MCAP 0, "Records").
pub(crate) fn record_ends(bytes: &[u8]) -> Vec<usize> {
    const MAGIC: usize = 8;
    let mut ends = vec![MAGIC];
    let mut at = MAGIC;
    while at + 9 < bytes.len() - MAGIC {
        let length = u64::from_le_bytes(bytes[at + 1..at + 9].try_into().expect("eight bytes"));
        at += 9 + length as usize;
        ends.push(at);
    }
    assert_eq!(at, bytes.len() - MAGIC, "the records fill the file");
    ends
}

#[test]
fn a_log_cut_at_any_record_gives_its_valid_beginning() {
    let (left, bytes) = real_log();
    let path: PathBuf = left.scratch.path().join("cut.mcap");
    let whole = strictly(&left.scratch.path().join("exchange.mcap")).expect("it is sound");
    let ends = record_ends(&bytes);
    assert!(ends.len() > 20, "{}", ends.len());
    let mut lengths = Vec::new();
    for end in ends {
        for length in [end - 1, end, end + 1, end + 9] {
            let what = format!("cut to {length} of {}", bytes.len());
            assert!(
                judge(&path, &bytes[..length.min(bytes.len() - 1)], &whole, &what),
                "{what}"
            );
        }
        std::fs::write(&path, &bytes[..end]).expect("the folder is writable");
        lengths.push(tolerantly(&path).map_or(0, |got| got.entries.len()));
    }
    assert!(
        lengths.is_sorted(),
        "a longer file never gives fewer messages: {lengths:?}"
    );
    assert_eq!(lengths.last(), Some(&whole.entries.len()));
}
