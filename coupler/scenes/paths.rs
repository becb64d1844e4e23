//! Files of a folder, for the build scripts of this crate and of the program.

use std::fs;
use std::path::{Path, PathBuf};

/// All files of a folder, or the file itself, sorted by name.
pub fn paths(path: &Path) -> Vec<PathBuf> {
    if !path.is_dir() {
        return vec![path.into()];
    }
    let entries = fs::read_dir(path).into_iter().flatten().flatten();
    let mut below: Vec<PathBuf> = entries.map(|entry| entry.path()).collect();
    below.sort();
    below.iter().flat_map(|path| paths(path)).collect()
}
