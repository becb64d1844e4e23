//! Size, rows and hash of each table (CSV), for checks by a reader: `tables` of summary.json and of each checkpoint.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use scenario::content::{content_hash, contents};
use serde::{Deserialize, Serialize};

/// A table as the run wrote it.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Written {
    /// Its size.
    pub bytes: u64,
    /// Lines below the header.
    pub rows: u64,
    /// blake3 of all bytes, in hexadecimal.
    pub blake3: String,
}

/// The same for a table that is still growing.
#[derive(Clone, Debug, Default)]
pub struct Growing {
    lines: u64,
    hasher: blake3::Hasher,
}

impl Growing {
    /// Adds the appended text.
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
    /// A complete table.
    pub fn of(text: &[u8]) -> Written {
        let mut table = Growing::default();
        table.add(text);
        table.written()
    }
}

/// Adds the unknown tables of a run directory, by their paths in it. Unreadable tables are left out.
pub fn add_tables(run: &Path, known: &mut BTreeMap<String, Written>) {
    let fields = names(run.join("fields")).map(|name| format!("fields/{name}"));
    for name in names(run.into()).chain(fields) {
        if name.ends_with(".csv") && !known.contains_key(&name) {
            let table = contents(&run.join(&name)).map(|text| Written::of(&text));
            known.extend(table.map(|table| (name, table)));
        }
    }
}

/// Hashes (blake3, in hexadecimal) of the field files of a run directory, by their paths in it.
pub fn field_hashes(run: &Path) -> BTreeMap<String, String> {
    let fields =
        names(run.join("fields")).filter(|name| name.ends_with(".vtu") || name.ends_with(".vtp"));
    let fields = fields.map(|name| format!("fields/{name}"));
    let hashes = fields.filter_map(|name| Some((content_hash(&run.join(&name))?, name)));
    hashes.map(|(hash, name)| (name, hash)).collect()
}

/// Names of the files of a folder.
pub fn names(folder: PathBuf) -> impl Iterator<Item = String> {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    entries.map(|entry| entry.file_name().to_string_lossy().into_owned())
}
