//! Size, rows and hash of each table (CSV), by which its reader checks it: `tables` of summary.json, and of each checkpoint.

use std::collections::BTreeMap;
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

/// Adds the tables of a run directory that are not known yet, by their paths in it. One that cannot be read is left out.
pub fn add_tables(run: &Path, known: &mut BTreeMap<String, Written>) {
    let fields = names(run.join("fields")).map(|name| format!("fields/{name}"));
    for name in names(run.into()).chain(fields) {
        if name.ends_with(".csv") && !known.contains_key(&name) {
            let table = contents(&run.join(&name)).map(|text| Written::of(&text));
            known.extend(table.map(|table| (name, table)));
        }
    }
}

/// The bytes of a file; none of one that cannot be read, nor of a pipe or a device, which may have no end.
pub fn contents(path: &Path) -> Option<Vec<u8>> {
    path.is_file().then(|| fs::read(path).ok()).flatten()
}

/// blake3 of the [`contents`] of a file, in hexadecimal.
pub fn content_hash(path: &Path) -> Option<String> {
    contents(path).map(|bytes| blake3::hash(&bytes).to_hex().to_string())
}

/// The first of these files, absolute or in a folder, with another [`content_hash`] than the one beside its name.
pub fn changed<'a>(files: &'a BTreeMap<String, String>, folder: &Path) -> Option<&'a str> {
    let mut files = files.iter();
    let other = |(name, hash): &(&String, &String)| {
        content_hash(&folder.join(name)).as_ref() != Some(*hash)
    };
    files.find(other).map(|(name, _)| name.as_str())
}

/// Names of the files of a folder.
pub fn names(folder: PathBuf) -> impl Iterator<Item = String> {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    entries.map(|entry| entry.file_name().to_string_lossy().into_owned())
}

#[cfg(test)]
mod tests {
    use super::*;
    use kit::scratch::Scratch;

    /// A device has no end, and a file that is gone has changed.
    #[test]
    fn files_that_changed_are_found_and_devices_are_not_read() {
        assert_eq!(contents(Path::new("/dev/zero")), None);
        let scratch = Scratch::new("contents", 1);
        fs::create_dir_all(scratch.path()).expect("a folder");
        let file = scratch.path().join("grains");
        fs::write(&file, "1 2").expect("it is writable");
        let hash = content_hash(&file).expect("it is there");
        let files = BTreeMap::from([("grains".to_string(), hash)]);
        assert_eq!(changed(&files, scratch.path()), None);
        fs::write(&file, "1 3").expect("it is writable");
        assert_eq!(changed(&files, scratch.path()), Some("grains"));
        fs::remove_file(&file).expect("it is there");
        assert_eq!(changed(&files, scratch.path()), Some("grains"));
    }
}
