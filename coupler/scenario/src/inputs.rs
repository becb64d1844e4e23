//! Hashes of the files that a scenario names, as a run read them.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use crate::content::{changed, content_hash};
use crate::error::{Refusal, Result};
use crate::load::{Loaded, of_manifest};

/// Key of the manifest for the hashes of the files that a run read.
pub const INPUTS_KEY: &str = "inputs";

impl Loaded {
    /// The files that keys and commands of participants name, with the blake3 of their contents.
    pub fn inputs(&self) -> BTreeMap<String, String> {
        let participants = self.scenario.participant.iter();
        let words = participants.flat_map(|participant| participant.command.iter().flatten());
        let programs = words.map(|word| self.folder.join(word));
        let files = programs.chain(self.files.iter().map(PathBuf::from));
        let held = files.map(|file| (file.display().to_string(), content_hash(&file)));
        held.filter_map(|(file, hash)| Some((file, hash?)))
            .collect()
    }
}

/// Refuses to continue a run whose input files have changed since it read them.
pub fn refuse_changed_inputs(run: &Path) -> Result<()> {
    let manifest = run.join("manifest.json");
    let text = fs::read_to_string(&manifest).unwrap_or_default();
    let hashes: Option<BTreeMap<String, String>> = of_manifest(&text, INPUTS_KEY);
    let hashes = hashes.ok_or_else(|| {
        let path = manifest.display();
        Refusal::checkpoint(format!("{path} lacks the hashes of the files that the run read (`{INPUTS_KEY}`): restore it, or run the scenario from its start"))
    })?;
    changed(&hashes, Path::new("")).map_or(Ok(()), |path| {
        let hash = &hashes[path];
        Err(Refusal::checkpoint(format!("{path} has changed since the run read it (blake3 {hash}): put that file back, or run the scenario from its start")).into())
    })
}
