//! Reading the VTK XML files that participants write (ASCII data arrays).

use std::collections::BTreeMap;
use std::path::Path;

use crate::error::{Error, Refusal};

/// The data arrays of a file by their names; `points` are the coordinates.
pub type Arrays = BTreeMap<String, Vec<f64>>;

/// The numbers of an array; none where a file does not hold it.
pub fn numbers<'a>(arrays: &'a Arrays, name: &str) -> &'a [f64] {
    arrays.get(name).map_or(&[], Vec::as_slice)
}

/// Reads every ASCII data array of a VTK XML file. Arrays that share a name (connectivity of several kinds
/// of cells) keep the last one's numbers.
pub fn read(path: &Path) -> Result<Arrays, Error> {
    let text = std::fs::read_to_string(path).map_err(Error::input(path.display()))?;
    let mut arrays = Arrays::new();
    for part in text.split("<DataArray ").skip(1) {
        let damaged = |why: &str| Refusal::file(path, format!("{why}; run the scenario again"));
        let (head, rest) = part
            .split_once('>')
            .ok_or_else(|| damaged("an unfinished DataArray"))?;
        let name = head
            .split("Name=\"")
            .nth(1)
            .and_then(|name| name.split('"').next());
        let name = name.ok_or_else(|| damaged("a DataArray without a name"))?;
        let body = rest.split("</DataArray>").next().unwrap_or_default();
        let numbers: Result<Vec<f64>, _> = body.split_ascii_whitespace().map(str::parse).collect();
        let numbers =
            numbers.map_err(|_| damaged(&format!("array {name} is not ASCII numbers")))?;
        arrays.insert(name.to_string(), numbers);
    }
    Ok(arrays)
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
