//! Reading the VTK XML files that participants write (ASCII data arrays).

use std::collections::BTreeMap;
use std::path::Path;

use crate::error::{Error, Refusal};

/// The data arrays of a file by their names; `points` are the coordinates.
pub type Arrays = BTreeMap<String, Vec<f64>>;

/// Reads every ASCII data array of a VTK XML file. Arrays that share a name (connectivity of several kinds
/// of cells) keep the last one's numbers.
fn read(path: &Path) -> Result<Arrays, Error> {
    let text = std::fs::read_to_string(path).map_err(Error::input(path.display()))?;
    let mut arrays = Arrays::new();
    for part in text.split("<DataArray ").skip(1) {
        let (head, rest) = part
            .split_once('>')
            .ok_or_else(|| damaged(path, "an unfinished DataArray"))?;
        let name =
            attribute(head, "Name").ok_or_else(|| damaged(path, "a DataArray without a name"))?;
        let body = rest.split("</DataArray>").next().unwrap_or_default();
        let numbers: Result<Vec<f64>, _> = body.split_ascii_whitespace().map(str::parse).collect();
        let numbers =
            numbers.map_err(|_| damaged(path, &format!("array {name} is not ASCII numbers")))?;
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
pub fn read_first(run: &Path, moment: &Moment, extension: &str) -> Result<Option<Arrays>, Error> {
    let ending = format!("-{}.{extension}", moment.name);
    let entries = std::fs::read_dir(run.join("fields")).into_iter();
    let found = entries
        .flatten()
        .flatten()
        .map(|entry| entry.path())
        .filter(|path| path.to_string_lossy().ends_with(&ending));
    found.min().map(|path| read(&path)).transpose()
}

fn attribute<'a>(head: &'a str, name: &str) -> Option<&'a str> {
    head.split(&format!("{name}=\"")).nth(1)?.split('"').next()
}

fn damaged(path: &Path, why: &str) -> Error {
    Refusal::file(path, format!("{why}; run the scenario again")).into()
}
