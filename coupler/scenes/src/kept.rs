//! Files of built-in scenes on the disk.

use std::env;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use super::FILES;
use thiserror::Error;

/// Reasons why the files of a scene cannot be written to the disk.
#[derive(Debug, Error)]
#[allow(missing_docs)]
pub enum KeptError {
    #[error("the files of the scene `{scene}` have no cache")]
    NoCache { scene: String },
    #[error("{}: {source}", path.display())]
    Write { path: PathBuf, source: io::Error },
}

/// Folder that keeps them; `None` if nothing is kept.
static BELOW: OnceLock<Option<PathBuf>> = OnceLock::new();

/// Sets the folder that keeps the files, or `None`. Only the first call has an effect.
pub fn keep_below(folder: Option<PathBuf>) {
    let _ = BELOW.set(folder);
}

/// The folder of this program in the user's cache (XDG Base Directory Specification 0.8).
pub fn user_cache() -> Option<PathBuf> {
    // The specification says to ignore relative paths.
    let folder = |name: &str| {
        let path = env::var_os(name).map(PathBuf::from);
        path.filter(|path| path.is_absolute())
    };
    let cache = folder("XDG_CACHE_HOME").or_else(|| Some(folder("HOME")?.join(".cache")));
    cache.map(|cache| cache.join("thirdbody"))
}

/// A folder in the cache with all files, named by the hash of their contents: a run that is resumed or repeated finds them again.
/// Missing and damaged files are written.
///
/// # Errors
/// There is no cache, or the cache cannot be written.
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

/// Writes files into a folder; files that already have the right content stay.
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
        // Another run may do the same, so each run renames a file of its own.
        let part = path.with_extension(format!("part-{}", std::process::id()));
        fs::create_dir_all(beside)
            .and_then(|()| fs::write(&part, content))
            .and_then(|()| fs::rename(&part, &path))
            .map_err(|source| KeptError::Write { path, source })?;
    }
    Ok(())
}
