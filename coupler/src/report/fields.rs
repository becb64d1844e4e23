//! The fields that participants wrote, for the pictures.

use std::path::Path;

use crate::error::Error;
use crate::output::vtk_arrays::read;

pub use crate::output::vtk_arrays::Arrays;

/// The numbers of an array; none where a file does not hold it.
pub fn numbers<'a>(arrays: &'a Arrays, name: &str) -> &'a [f64] {
    arrays.get(name).map_or(&[], Vec::as_slice)
}

/// A moment at which all participants wrote their fields.
pub struct Moment {
    /// Its name in the files.
    pub name: String,
    /// Its name in captions, to follow `at the`.
    pub words: String,
}

/// Reads the fields of the first participant, by the names of the files, that wrote such a file at this moment.
pub fn read_first(run: &Path, moment: &str, extension: &str) -> Result<Option<Arrays>, Error> {
    let ending = format!("-{moment}.{extension}");
    let entries = std::fs::read_dir(run.join("fields")).into_iter();
    let paths = entries.flatten().flatten().map(|entry| entry.path());
    let found = paths.filter(|path| path.to_string_lossy().ends_with(&ending));
    found.min().map(|path| read(&path)).transpose()
}
