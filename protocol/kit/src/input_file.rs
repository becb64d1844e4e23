//! Files that a scenario names.

use std::io;
use std::path::Path;

/// The bytes of a regular file; an error for folders, pipes and devices, and for more than `longest` bytes.
pub fn content(path: &Path, longest: u64) -> io::Result<Vec<u8>> {
    let file = std::fs::metadata(path)?;
    if !file.is_file() {
        return Err(io::Error::other("it is a folder, a pipe or a device"));
    }
    let length = file.len();
    if length > longest {
        let problem = format!("it has {length} bytes, more than {longest}");
        return Err(io::Error::other(problem));
    }
    std::fs::read(path)
}
