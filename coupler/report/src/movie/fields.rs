//! The fields that a run wrote: their participants and moments.

use std::collections::BTreeSet;
use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use runs::fields::{Arrays, read};
use runs::scene::Setup;
use scenario::error::{Error, Refusal};

/// Ends of the names of files of contacts between grains, and of interfaces.
const CONTACTS: &str = "-contacts";
const INTERFACE: &str = "-interface";
/// Arrays of the contacts: the indices of both grains, and data.
const OF_CONTACTS: [&str; 3] = ["connectivity", "force_n", "adhesion"];

/// A moment at which fields were written.
#[derive(Clone, Debug, PartialEq)]
pub struct FieldMoment {
    /// Its name in the files.
    pub name: String,
    /// Simulated time (s), if the run recorded it.
    pub time_s: Option<f64>,
}

/// The fields of a participant.
#[derive(Clone, Debug, PartialEq)]
pub struct FieldSource {
    /// Name of the participant.
    pub participant: String,
    /// True for grains, false for a mesh.
    pub grains: bool,
}

/// All fields of a run.
#[derive(Debug)]
pub struct FieldFiles {
    folder: PathBuf,
    /// Participants that wrote fields.
    pub sources: Vec<FieldSource>,
    /// The moments in their order.
    pub moments: Vec<FieldMoment>,
}

/// Names of the files of a participant, with the time of each (s).
type Files = Vec<(String, Option<f64>)>;

impl FieldFiles {
    /// The fields in a run directory.
    ///
    /// # Errors
    /// There are no fields.
    pub fn of(run: &Path, setup: &Setup) -> Result<FieldFiles, Error> {
        let mut record = FieldFiles {
            folder: run.join("fields"),
            sources: Vec::new(),
            moments: Vec::new(),
        };
        let present = record.present();
        for participant in participants(&present, setup) {
            let files = record.files(&participant, &present, setup);
            record.add(&participant, files);
        }
        record.put_in_order();
        if record.moments.is_empty() {
            let problem = "holds no fields (*.vtu, *.vtp) to show. Run the scenario to the end of a phase of its load, or with --set run.output.fields_every_s=5e-5; a foreign participant may write no fields, and VTKHDF files (run.output.fields_format) are not read";
            return Err(Refusal::file(&record.folder, problem).into());
        }
        Ok(record)
    }

    /// Reads the fields of a participant at a moment, if it wrote any.
    ///
    /// # Errors
    /// The file cannot be read, or has no end, because its writer was killed.
    pub fn read(
        &self,
        source: &FieldSource,
        moment: &FieldMoment,
    ) -> Result<Option<Arrays>, Error> {
        let stem = format!("{}-{}", source.participant, moment.name);
        let there = |file: String| Some(self.folder.join(file)).filter(|path| path.is_file());
        let extension = if source.grains { "vtp" } else { "vtu" };
        let Some(path) = there(format!("{stem}.{extension}")) else {
            return Ok(None);
        };
        let mut arrays = read_whole(&path)?;
        if let Some(path) = there(format!("{stem}{CONTACTS}.vtp")).filter(|_| source.grains) {
            let mut contacts = read_whole(&path)?;
            for name in OF_CONTACTS {
                arrays.remove(name);
                arrays.extend(contacts.remove_entry(name));
            }
        }
        Ok(Some(arrays))
    }

    /// Sorted names of all files in the folder.
    fn present(&self) -> BTreeSet<String> {
        let entries = std::fs::read_dir(&self.folder).into_iter().flatten();
        let names = entries.flatten().map(|entry| entry.file_name());
        names.filter_map(|name| name.into_string().ok()).collect()
    }

    /// The files of a participant: the files in its collection, or without a collection (a killed run) the files that bear its name.
    fn files(&self, participant: &str, present: &BTreeSet<String>, setup: &Setup) -> Files {
        let collection = self.folder.join(format!("{participant}.pvd"));
        if let Ok(text) = std::fs::read_to_string(collection) {
            let listed = text.split("<DataSet ").skip(1).filter_map(entry);
            return listed.filter(|(file, _)| present.contains(file)).collect();
        }
        let longer = |file: &str| {
            let others = setup.participants.iter();
            let mut others = others.filter(|p| p.len() > participant.len());
            others.any(|other| file.starts_with(&format!("{other}-")))
        };
        let own = present.iter().filter(|file| !longer(file));
        let mut files: Vec<&String> = own.collect();
        let modified = |file: &&String| self.folder.join(file).metadata()?.modified();
        files.sort_by_key(|file| modified(file).ok());
        files.into_iter().map(|file| (file.clone(), None)).collect()
    }

    fn add(&mut self, participant: &str, files: Files) {
        for (file, time_s) in files {
            let stem = file.strip_prefix(&format!("{participant}-"));
            let Some((name, extension)) = stem.and_then(|stem| stem.rsplit_once('.')) else {
                continue;
            };
            let other = [CONTACTS, INTERFACE].iter().any(|end| name.ends_with(end));
            if other || !["vtu", "vtp"].contains(&extension) {
                continue;
            }
            let source = FieldSource {
                participant: participant.into(),
                grains: extension == "vtp",
            };
            if !self.sources.contains(&source) {
                self.sources.push(source);
            }
            if !self.moments.iter().any(|moment| moment.name == name) {
                let name = name.to_string();
                self.moments.push(FieldMoment { name, time_s });
            }
        }
    }

    /// Sorts moments by time and keeps the first of several at one time (the end of the last phase and of the run). Moments without a time
    /// stay as they were found.
    fn put_in_order(&mut self) {
        if self.moments.iter().all(|moment| moment.time_s.is_some()) {
            let time = |moment: &FieldMoment| moment.time_s.unwrap_or(f64::INFINITY);
            self.moments.sort_by(|a, b| time(a).total_cmp(&time(b)));
            self.moments.dedup_by_key(|moment| moment.time_s);
        }
    }
}

/// The arrays of a file that has an end.
fn read_whole(path: &Path) -> Result<Arrays, Error> {
    if !has_end(path).map_err(Error::input(path.display()))? {
        let problem = "ends in the middle: its run was interrupted or the disk was full";
        return Err(Refusal::file(path, problem).into());
    }
    read(path)
}

/// True for a file that ends with the closing tag of VTK.
fn has_end(path: &Path) -> std::io::Result<bool> {
    let mut file = File::open(path)?;
    let length = file.metadata()?.len();
    file.seek(SeekFrom::Start(length.saturating_sub(64)))?;
    let mut end = Vec::new();
    file.read_to_end(&mut end)?;
    Ok(end.trim_ascii_end().ends_with(b"</VTKFile>"))
}

/// The participants of the scenario, then others with a collection.
fn participants(present: &BTreeSet<String>, setup: &Setup) -> Vec<String> {
    let mut all = setup.participants.clone();
    let collections = present.iter().filter_map(|file| file.strip_suffix(".pvd"));
    let parts = |name: &&str| [CONTACTS, INTERFACE].iter().any(|end| name.ends_with(end));
    let known = |name: &&str| setup.participants.iter().any(|known| known == name);
    let others = collections.filter(|name| !parts(name) && !known(name));
    all.extend(others.map(String::from));
    all
}

/// File and time (s) of an entry of a collection.
fn entry(text: &str) -> Option<(String, Option<f64>)> {
    let value = |key: &str| Some(text.split_once(key)?.1.split_once('"')?.0);
    let file = value("file=\"")?.to_string();
    Some((file, value("timestep=\"")?.parse().ok()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use kit::scratch::Scratch;

    fn run(purpose: &str, files: &[(&str, &str)]) -> Scratch {
        let scratch = Scratch::new(purpose, 1);
        std::fs::create_dir_all(scratch.path().join("fields")).expect("a folder");
        for (file, text) in files {
            std::fs::write(scratch.path().join("fields").join(file), text).expect("a file");
        }
        scratch
    }

    fn names(record: &FieldFiles) -> Vec<(&str, Option<f64>)> {
        let moments = record.moments.iter();
        moments.map(|m| (m.name.as_str(), m.time_s)).collect()
    }

    #[test]
    fn moments_come_from_the_collections_by_time_and_once() {
        let set = |t: f64, file: &str| format!("<DataSet timestep=\"{t:e}\" file=\"{file}\"/>");
        let rail = [
            set(2e-3, "rail-hold.vtu"),
            set(3e-3, "rail-end.vtu"),
            set(1e-3, "rail-gone.vtu"),
            set(1e-3, "../rail-secret.vtu"),
        ];
        let layer = set(1e-3, "a-layer-hold-1.vtp");
        let run = run(
            "movie-listed",
            &[
                ("rail.pvd", &rail.concat()),
                ("a-layer.pvd", &layer),
                ("rail-hold.vtu", ""),
                ("rail-end.vtu", ""),
                ("a-layer-hold-1.vtp", ""),
            ],
        );
        let record = FieldFiles::of(run.path(), &Setup::default()).expect("it has fields");
        let expected = [("hold-1", 1e-3), ("hold", 2e-3), ("end", 3e-3)];
        assert_eq!(names(&record), expected.map(|(name, t)| (name, Some(t))));
        assert_eq!(record.sources.len(), 2);
    }

    #[test]
    fn a_killed_run_without_collections_has_the_files_that_exist() {
        let run = run(
            "movie-killed",
            &[("rail-ramp.vtu", ""), ("rail-b-ramp.vtu", "")],
        );
        let setup = Setup {
            participants: vec!["rail".into(), "rail-b".into()],
            ..Setup::default()
        };
        let record = FieldFiles::of(run.path(), &setup).expect("it has fields");
        assert_eq!(names(&record), [("ramp", None)]);
        let sources = record.sources.iter().map(|s| s.participant.as_str());
        assert_eq!(Vec::from_iter(sources), ["rail", "rail-b"]);
    }

    #[test]
    fn the_error_for_a_run_without_fields_says_what_to_do() {
        let run = run("movie-none", &[("rail-profile.csv", "")]);
        let error = FieldFiles::of(run.path(), &Setup::default()).expect_err("it has none");
        assert!(error.to_string().contains("fields_every_s=5e-5"), "{error}");
    }
}
