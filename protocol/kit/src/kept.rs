//! Values that take long to compute, kept for later runs: a folder of files, each named by the hash of its recipe. A folder belongs to one build:
//! another build may compute other bits.
//!
//! A value from a file has the bits that its recipe makes. A damaged file is never used: the value is made again, with a warning.

use std::fs;
use std::io::{self, ErrorKind};
use std::path::Path;
use std::time::{Duration, Instant};

use protocol::checkpoint::{pack, unpack};
use serde::Serialize;
use serde::de::DeserializeOwned;

/// A value that took less time than this is not kept: making it again costs little more than reading it.
pub const WORTH: Duration = Duration::from_millis(100);
/// Bytes of the checksum in front of a file.
const CHECKSUM: usize = 32;

/// The folder of kept values, if any. It need not exist; nothing is kept without one.
#[derive(Clone, Copy)]
pub struct Store<'a> {
    /// The folder.
    pub folder: Option<&'a Path>,
    /// Least time of a computation that makes its result worth keeping.
    pub worth: Duration,
}

/// A value, and where it comes from.
pub struct Kept<T> {
    /// The value.
    pub value: T,
    /// blake3 of its recipe, in hexadecimal.
    pub hash: String,
    /// True if it was read from a file and not made anew.
    pub from_cache: bool,
    /// Faults of its file, which cost time only.
    pub warnings: Vec<String>,
}

impl Store<'_> {
    /// The value of this recipe, from its file or made. The recipe is everything that decides the bits of the value; files of a kind end with its `ending`,
    /// and warnings call the value by its `name`.
    pub fn value<T: Serialize + DeserializeOwned, E>(
        &self,
        [name, ending]: [&str; 2],
        recipe: &str,
        make: impl FnOnce() -> Result<T, E>,
    ) -> Result<Kept<T>, E> {
        let hash = blake3::hash(recipe.as_bytes()).to_hex().to_string();
        let file = self
            .folder
            .map(|folder| folder.join(format!("{hash}.{ending}")));
        let named = |path: &Path| format!("the {name} {}", path.display());
        let found = file.as_deref().map_or(Ok(None), |path| {
            read(path, recipe).map_err(|why| format!("{} {why}: it is made again", named(path)))
        });
        let (found, mut warnings) = match found {
            Ok(value) => (value, Vec::new()),
            Err(problem) => (None, vec![problem]),
        };
        let from_cache = found.is_some();
        let value = match found {
            Some(value) => value,
            None => {
                let start = Instant::now();
                let value = make()?;
                let keep = start.elapsed() >= self.worth || !warnings.is_empty();
                let failed = |path: &Path| {
                    let why = write(path, recipe, &value).err()?;
                    let path = named(path);
                    Some(format!(
                        "{path} cannot be kept: {why}; --cache DIR chooses another folder, --cache none switches it off"
                    ))
                };
                warnings.extend(file.as_deref().filter(|_| keep).and_then(failed));
                value
            }
        };
        Ok(Kept {
            value,
            hash,
            from_cache,
            warnings,
        })
    }
}

/// The value of a file; `None` without a file. The error states the file's fault.
fn read<T: DeserializeOwned>(path: &Path, recipe: &str) -> Result<Option<T>, String> {
    let bytes = match fs::read(path) {
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(None),
        read => read.map_err(|error| format!("cannot be read ({error})"))?,
    };
    let whole = bytes.split_at_checked(CHECKSUM);
    let whole = whole.filter(|(sum, content)| blake3::hash(content).as_bytes() == sum);
    let (_, content) = whole.ok_or("is damaged (wrong checksum)")?;
    let (own, value): (String, T) =
        unpack(content).map_err(|_| "is damaged (wrong content)".to_string())?;
    if own != recipe {
        return Err("has another recipe".into());
    }
    Ok(Some(value))
}

/// Writes a whole file, or leaves the existing one. The error states the reason.
fn write<T: Serialize>(path: &Path, recipe: &str, value: &T) -> Result<(), String> {
    let content = pack(&(recipe, value)).map_err(|error| error.message)?;
    let mut bytes = blake3::hash(&content).as_bytes().to_vec();
    bytes.extend(content);
    replace(path, &bytes).map_err(|error| error.to_string())
}

/// Writes under another name, then renames, which is atomic: no reader sees half a file, and the last of two writers wins.
fn replace(path: &Path, bytes: &[u8]) -> io::Result<()> {
    if let Some(folder) = path.parent() {
        fs::create_dir_all(folder)?;
    }
    let own = format!(
        "{}-{:?}.new",
        std::process::id(),
        std::thread::current().id()
    );
    let temporary = path.with_extension(own);
    let written = fs::write(&temporary, bytes).and_then(|()| fs::rename(&temporary, path));
    if written.is_err() {
        let _ = fs::remove_file(&temporary);
    }
    written
}
