//! What a reader can check a table (CSV) by: `tables` of summary.json, and of each checkpoint.

use std::fs;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

/// A table as it was written.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Written {
    /// Its size.
    pub bytes: u64,
    /// Lines below the header.
    pub rows: u64,
    /// blake3 of all bytes, in hexadecimal.
    pub blake3: String,
}

/// The same of a table that still grows.
#[derive(Clone, Debug, Default)]
pub struct Growing {
    lines: u64,
    hasher: blake3::Hasher,
}

impl Growing {
    /// Adds what was appended.
    pub fn add(&mut self, text: &[u8]) {
        self.lines += text.iter().filter(|byte| **byte == b'\n').count() as u64;
        self.hasher.update(text);
    }

    /// The table up to here.
    pub fn written(&self) -> Written {
        Written {
            bytes: self.hasher.count(),
            rows: self.lines.saturating_sub(1),
            blake3: self.hasher.finalize().to_hex().to_string(),
        }
    }
}

impl Written {
    /// A whole table.
    pub fn of(text: &[u8]) -> Written {
        let mut table = Growing::default();
        table.add(text);
        table.written()
    }
}

/// The tables of a run directory, by their paths in it. One that cannot be read is left out.
pub fn tables(run: &Path) -> Vec<(String, Written)> {
    let fields = names(run.join("fields")).map(|name| format!("fields/{name}"));
    let all = names(run.into()).chain(fields);
    let read = |name: String| Some((Written::of(&fs::read(run.join(&name)).ok()?), name));
    let tables = all.filter(|name| name.ends_with(".csv")).filter_map(read);
    tables.map(|(table, name)| (name, table)).collect()
}

/// blake3 of what a file holds, in hexadecimal; none of one that cannot be read.
pub fn content_hash(path: &Path) -> Option<String> {
    let bytes = fs::read(path).ok()?;
    Some(blake3::hash(&bytes).to_hex().to_string())
}

/// Names of the files of a folder.
pub fn names(folder: PathBuf) -> impl Iterator<Item = String> {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    entries.map(|entry| entry.file_name().to_string_lossy().into_owned())
}
