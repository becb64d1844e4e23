//! Hashes of the files that a scenario names, as a run read them.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use crate::content::{changed, content_hash};
use crate::error::{Refusal, Result};
use crate::load::{Loaded, of_manifest};

/// Key of the manifest that keeps what the files of a run held.
pub const INPUTS_KEY: &str = "inputs";

impl Loaded {
    /// The files that the keys and the commands of participants name, with blake3 of what they hold.
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

/// Refuses to go on with a run whose files hold something else than when it read them.
pub fn refuse_changed_inputs(run: &Path) -> Result<()> {
    let manifest = run.join("manifest.json");
    let told = fs::read_to_string(&manifest).unwrap_or_default();
    let told: Option<BTreeMap<String, String>> = of_manifest(&told, INPUTS_KEY);
    let told = told.ok_or_else(|| {
        let path = manifest.display();
        Refusal::checkpoint(format!("{path} does not tell what the files that the run read held (`{INPUTS_KEY}`): put it back, or run the scenario from its start"))
    })?;
    changed(&told, Path::new("")).map_or(Ok(()), |path| {
        let hash = &told[path];
        Err(Refusal::checkpoint(format!("{path} is not what the run read, of blake3 {hash}: put that file back, or run the scenario from its start")).into())
    })
}
