//! Files of shipped scenes on the disk.

use std::env;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use super::FILES;
use thiserror::Error;

/// Reasons for which the files of a scene cannot be put on the disk.
#[derive(Debug, Error)]
#[allow(missing_docs)]
pub enum KeptError {
    #[error("the files of the scene `{scene}` have no cache")]
    NoCache { scene: String },
    #[error("{}: {source}", path.display())]
    Write { path: PathBuf, source: io::Error },
}

/// Folder below which they are kept; none if nothing is.
static BELOW: OnceLock<Option<PathBuf>> = OnceLock::new();

/// Has them kept below this folder, or nowhere. The first word counts.
pub fn keep_below(folder: Option<PathBuf>) {
    let _ = BELOW.set(folder);
}

/// The folder of this program in the user's cache (XDG Base Directory Specification 0.8).
pub fn user_cache() -> Option<PathBuf> {
    // The specification has relative paths ignored.
    let folder = |name: &str| {
        let path = env::var_os(name).map(PathBuf::from);
        path.filter(|path| path.is_absolute())
    };
    let cache = folder("XDG_CACHE_HOME").or_else(|| Some(folder("HOME")?.join(".cache")));
    cache.map(|cache| cache.join("thirdbody"))
}

/// A folder with all files in the cache, named by the hash of what they hold, so that whoever goes on with a run or repeats it finds
/// them again. One that is missing or damaged is written.
///
/// # Errors
/// There is no cache, or it cannot be written.
pub fn all(wanted: &str) -> Result<PathBuf, KeptError> {
    let Some(below) = BELOW.get_or_init(user_cache) else {
        return Err(KeptError::NoCache {
            scene: wanted.into(),
        });
    };
    let mut hasher = blake3::Hasher::new();
    for (path, content) in FILES {
        for part in [path.as_bytes(), content] {
            hasher.update(&(part.len() as u64).to_le_bytes());
            hasher.update(part);
        }
    }
    let hash = hasher.finalize().to_hex();
    let folder = below.join(format!("scenes-{}", &hash[..16]));
    write(FILES, &folder)?;
    Ok(folder)
}

/// Writes files into a folder; those that are there as they should be stay.
///
/// # Errors
/// The folder cannot be written.
pub fn write(files: &[(&str, &[u8])], folder: &Path) -> Result<(), KeptError> {
    for (name, content) in files {
        let path = folder.join(name);
        if fs::read(&path).is_ok_and(|found| found == *content) {
            continue;
        }
        let beside = path.parent().unwrap_or(folder);
        // Another run may do the same: each renames a file of its own.
        let part = path.with_extension(format!("part-{}", std::process::id()));
        fs::create_dir_all(beside)
            .and_then(|()| fs::write(&part, content))
            .and_then(|()| fs::rename(&part, &path))
            .map_err(|source| KeptError::Write { path, source })?;
    }
    Ok(())
}
