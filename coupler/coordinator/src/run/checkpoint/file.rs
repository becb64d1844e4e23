//! A checkpoint on the disk: `checkpoints/<window>.checkpoint`, with the number of completed windows in twelve digits.
//!
//! The file holds [`MAGIC`], the blake3 of all that follows, then [`About`] and [`Checkpoint`] (postcard).

use std::fs;
use std::path::{Path, PathBuf};

use thiserror::Error;

use super::content::{About, Checkpoint};
use scenario::error::{Refusal, Result};

/// First bytes of the file: name and version of its format.
pub const MAGIC: &[u8] = b"thirdbody.checkpoint/4\n";

const HASH_BYTES: usize = blake3::OUT_LEN;
const ENDING: &str = "checkpoint";

/// A checkpoint that cannot be used.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("checkpoint {}: {why}", .path.display())]
pub struct Unusable {
    /// The file.
    pub path: PathBuf,
    /// The reason.
    pub why: String,
    /// True if it is sound, but of another scenario or version, as are then all others of its run.
    pub foreign: bool,
}

/// A checkpoint file by its name.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CheckpointFile {
    /// Completed windows.
    pub window: u64,
    /// The file.
    pub path: PathBuf,
}

/// The checkpoints of a folder, oldest first. Unfinished files have another ending and are left out.
pub fn list(folder: &Path) -> Vec<CheckpointFile> {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let checkpoints = entries.filter_map(|entry| {
        let path = entry.path();
        let window = path.file_stem()?.to_str()?.parse().ok()?;
        (path.extension()? == ENDING).then_some(CheckpointFile { window, path })
    });
    let mut found = Vec::from_iter(checkpoints);
    found.sort_by_key(|found| found.window);
    found
}

/// Path of the checkpoint after this number of windows.
pub fn path(folder: &Path, window: u64) -> PathBuf {
    folder.join(format!("{window:012}.{ENDING}"))
}

/// The bytes of a file.
pub fn encode(about: &About, checkpoint: &Checkpoint) -> Result<Vec<u8>> {
    let broken = |error: postcard::Error| {
        Refusal::checkpoint(format!("the run's state cannot be encoded: {error}"))
    };
    let mut bytes = MAGIC.to_vec();
    bytes.extend([0; HASH_BYTES]);
    bytes = postcard::to_extend(about, bytes).map_err(broken)?;
    bytes = postcard::to_extend(checkpoint, bytes).map_err(broken)?;
    let start = MAGIC.len() + HASH_BYTES;
    let hash = blake3::hash(&bytes[start..]);
    bytes[MAGIC.len()..start].copy_from_slice(hash.as_bytes());
    Ok(bytes)
}

/// Reads a checkpoint that must agree with `expected`, except for the participants.
pub fn read(path: &Path, expected: &About) -> Result<(About, Checkpoint), Unusable> {
    let unusable = |why: String, foreign: bool| {
        let path = path.into();
        Unusable { path, why, foreign }
    };
    let damaged = |why: &str| unusable(why.into(), false);
    let bytes = fs::read(path).map_err(|error| damaged(&error.to_string()))?;
    let format = MAGIC.iter().position(|byte| *byte == b'/').unwrap_or(0);
    if bytes.len() < MAGIC.len() + HASH_BYTES || bytes[..format] != MAGIC[..format] {
        return Err(damaged("it is cut off, or not a checkpoint"));
    }
    let (magic, rest) = bytes.split_at(MAGIC.len());
    if magic != MAGIC {
        let [theirs, ours] = [magic, MAGIC].map(String::from_utf8_lossy);
        let (theirs, ours) = (theirs.trim_end(), ours.trim_end());
        let why = format!("its format is `{theirs}`, but this build reads `{ours}`");
        return Err(unusable(why, true));
    }
    let (hash, body) = rest.split_at(HASH_BYTES);
    if blake3::hash(body).as_bytes() != hash {
        let why = "its content does not match its hash: it was cut off or damaged";
        return Err(damaged(why));
    }
    let other = |error: postcard::Error| {
        unusable(format!("it was written by another build: {error}"), true)
    };
    let (about, body) = postcard::take_from_bytes::<About>(body).map_err(other)?;
    if let Some(why) = differs(&about, expected) {
        return Err(unusable(why, true));
    }
    let (checkpoint, left) = postcard::take_from_bytes::<Checkpoint>(body).map_err(other)?;
    match left {
        [] => Ok((about, checkpoint)),
        _ => Err(other(postcard::Error::SerdeDeCustom)),
    }
}

/// The first difference between two checkpoints.
fn differs(theirs: &About, ours: &About) -> Option<String> {
    let claims = |of: &About| {
        let (software, scenario) = (of.software.clone(), of.scenario_hash.clone());
        [software, scenario, of.protocol.to_string()]
    };
    let verbs = [
        "was written by",
        "belongs to scenario",
        "speaks protocol version",
    ];
    let mut pairs = verbs.into_iter().zip(claims(theirs)).zip(claims(ours));
    let ((verb, theirs), ours) = pairs.find(|((_, theirs), ours)| theirs != ours)?;
    Some(format!("it {verb} {theirs}, but this is {ours}"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::OutputState;
    use crate::run::position::{GroupPosition, RunPosition};
    use kit::scratch::Scratch;
    use runs::run_dir::write_whole;

    fn about() -> About {
        About {
            software: "thirdbody 1".into(),
            protocol: 1,
            scenario_hash: "abc".into(),
            participants: vec![("rail".into(), "fem 1".into())],
        }
    }

    fn checkpoint() -> Checkpoint {
        Checkpoint {
            position: RunPosition {
                windows: 12,
                t_s: 0.1,
                groups: vec![GroupPosition {
                    window: 12,
                    step: 80,
                    rest: Some(3),
                }],
                over: false,
            },
            log_blocks: 13,
            nodes: vec![vec![1, 2, 3]],
            couplings: Vec::new(),
            outputs: OutputState::default(),
        }
    }

    fn written(name: &str) -> (Scratch, PathBuf, Vec<u8>) {
        let scratch = Scratch::new(name, 1);
        fs::create_dir_all(scratch.path()).expect("the temporary folder is writable");
        let path = path(scratch.path(), 12);
        let bytes = encode(&about(), &checkpoint()).expect("plain numbers");
        write_whole(&path, &bytes).expect("the folder is writable");
        (scratch, path, bytes)
    }

    #[test]
    fn a_checkpoint_is_read_back_and_every_cut_and_flipped_bit_is_detected() {
        let (scratch, path, bytes) = written("checkpoint-bits");
        assert_eq!(list(scratch.path())[0].window, 12);
        let (_, back) = read(&path, &about()).expect("it is whole");
        assert_eq!(back.position, checkpoint().position);
        assert_eq!(back.nodes, checkpoint().nodes);
        for length in 0..bytes.len() {
            fs::write(&path, &bytes[..length]).expect("writable");
            assert!(read(&path, &about()).is_err(), "cut to {length}");
        }
        for bit in 0..8 * bytes.len() {
            let mut flipped = bytes.clone();
            flipped[bit / 8] ^= 1 << (bit % 8);
            fs::write(&path, &flipped).expect("writable");
            assert!(read(&path, &about()).is_err(), "bit {bit}");
        }
    }

    #[test]
    fn another_version_and_another_scenario_are_reported() {
        let (_scratch, path, mut bytes) = written("checkpoint-names");
        let newer = About {
            software: "thirdbody 2".into(),
            ..about()
        };
        let error = read(&path, &newer).expect_err("it is of version 1");
        assert!(
            error.foreign && error.why.contains("thirdbody 1"),
            "{error}"
        );
        let other = About {
            scenario_hash: "xyz".into(),
            ..about()
        };
        let error = read(&path, &other).expect_err("it is of scenario abc");
        assert!(
            error.foreign && error.why.contains("scenario abc"),
            "{error}"
        );
        bytes[MAGIC.len() - 2] = b'9';
        fs::write(&path, &bytes).expect("writable");
        let error = read(&path, &about()).expect_err("it is of format 9");
        assert!(
            error.foreign && error.why.contains("checkpoint/9"),
            "{error}"
        );
    }
}
