//! Folders that are removed with their owner.

use std::fs;
use std::path::{Path, PathBuf};

/// A path for a temporary run directory, which is removed on drop.
pub struct Scratch {
    path: PathBuf,
}

impl Scratch {
    /// A unique path below the system's temporary folder; nothing is created yet.
    pub fn new(purpose: &str, unique: u64) -> Scratch {
        Scratch::below(&std::env::temp_dir(), purpose, unique)
    }

    /// A unique path in memory, where no disk is involved.
    pub fn in_memory(purpose: &str, unique: u64) -> Scratch {
        Scratch::below(Path::new("/dev/shm"), purpose, unique)
    }

    fn below(folder: &Path, purpose: &str, unique: u64) -> Scratch {
        let name = format!("thirdbody-{purpose}-{}-{unique:016x}", std::process::id());
        Scratch {
            path: folder.join(name),
        }
    }

    /// Its path.
    pub fn path(&self) -> &Path {
        &self.path
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.path);
    }
}
