//! The fields that participants wrote, for the pictures.

use std::path::Path;

use coordinator::error::Error;
pub use coordinator::output::vtk_arrays::read;

pub use coordinator::output::vtk_arrays::Arrays;

/// The numbers of an array; none where a file does not hold it.
pub fn numbers<'a>(arrays: &'a Arrays, name: &str) -> &'a [f64] {
    arrays.get(name).map_or(&[], Vec::as_slice)
}

/// Reads the fields of the first participant, by the names of the files, that wrote such a file at this moment.
pub fn read_first(run: &Path, moment: &str, extension: &str) -> Result<Option<Arrays>, Error> {
    let ending = format!("-{moment}.{extension}");
    let entries = std::fs::read_dir(run.join("fields")).into_iter();
    let paths = entries.flatten().flatten().map(|entry| entry.path());
    let found = paths.filter(|path| path.to_string_lossy().ends_with(&ending));
    found.min().map(|path| read(&path)).transpose()
}

/// The fields of every participant that wrote such a file at this moment, in the order of their names.
pub fn read_all(run: &Path, moment: &str, extension: &str) -> Result<Vec<(String, Arrays)>, Error> {
    let ending = format!("-{moment}.{extension}");
    let entries = std::fs::read_dir(run.join("fields")).into_iter();
    let names = entries.flatten().flatten().map(|entry| entry.file_name());
    let names = names.filter_map(|name| Some(name.to_str()?.strip_suffix(&ending)?.to_string()));
    let mut names: Vec<String> = names.collect();
    names.sort();
    let of = |name: String| {
        let arrays = read(&run.join("fields").join(format!("{name}{ending}")))?;
        Ok((name, arrays))
    };
    names.into_iter().map(of).collect()
}
