//! Folders that go with whoever made them.

use std::fs;
use std::path::{Path, PathBuf};

/// A place for a run directory that nobody keeps; removed when dropped.
pub struct Scratch {
    path: PathBuf,
}

impl Scratch {
    /// A name of its own below the system's temporary folder; nothing is made yet.
    pub fn new(purpose: &str, unique: u64) -> Scratch {
        Scratch::below(&std::env::temp_dir(), purpose, unique)
    }

    /// The same in memory, where nothing waits for a disk.
    pub fn in_memory(purpose: &str, unique: u64) -> Scratch {
        Scratch::below(Path::new("/dev/shm"), purpose, unique)
    }

    fn below(folder: &Path, purpose: &str, unique: u64) -> Scratch {
        let name = format!("thirdbody-{purpose}-{}-{unique:016x}", std::process::id());
        Scratch {
            path: folder.join(name),
        }
    }

    /// Its place.
    pub fn path(&self) -> &Path {
        &self.path
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.path);
    }
}
