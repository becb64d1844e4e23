//! `thirdbody new`: a copy of a shipped scene, to be changed.

use std::fs;
use std::path::{Path, PathBuf};

use super::common::{VerbResult, print};
use coordinator::error::{Error, Refusal};
use scenes::{STUDY, kept};

/// Arguments of `new`.
#[derive(Debug, clap::Args)]
pub struct NewArguments {
    /// A scene or a study that `thirdbody scenes` lists.
    name: String,
    /// A new or an empty folder; by default the last part of the name, here.
    dir: Option<PathBuf>,
}

/// Copies a scene or a study with its comments and the files beside it, and says what to do next.
pub fn new(arguments: &NewArguments) -> VerbResult {
    let name = known(&arguments.name)?;
    let files = scenes::files_of(&name);
    if files.iter().any(|(file, _)| *file == "Cargo.toml") {
        let problem = "is a crate that needs the source tree around it: `thirdbody new-node rust NAME` writes one like it that finds what it needs";
        return Err(Refusal::argument(name, problem).into());
    }
    let last = Path::new(&name).file_name().map(PathBuf::from);
    let folder = arguments.dir.clone().or(last).unwrap_or_default();
    require_empty(&folder)?;
    kept::write(&files, &folder)?;
    rename(&name, &folder)?;
    for (file, _) in &files {
        print(&folder.join(file).display().to_string())?;
    }
    print(&next(&files, &folder))?;
    Ok(0)
}

/// Names the run of a copied scene after its folder, and keeps the name of the scene that it is a copy of.
fn rename(scene: &str, folder: &Path) -> Result<(), Error> {
    let path = folder.join("scenario.toml");
    let name = folder.file_name().and_then(|name| name.to_str());
    let (Some(name), Ok(text)) = (name, fs::read_to_string(&path)) else {
        return Ok(());
    };
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_.".contains(c);
    let first = text.lines().find(|line| line.starts_with("name = "));
    let (Some(line), true) = (first, name.chars().all(plain)) else {
        return Ok(());
    };
    if line == format!("name = \"{name}\"") {
        return Ok(());
    }
    let new = format!("name = \"{name}\"\nderived_from = \"{scene}\"");
    fs::write(&path, text.replacen(line, &new, 1)).map_err(Error::output(path.display()))
}

/// The folder of a scene or a study among the shipped ones.
fn known(name: &str) -> Result<String, Error> {
    let plain = name.trim_end_matches('/');
    if scenes::names().contains(&plain) {
        return Ok(plain.into());
    }
    scenes::study_folder(plain).ok_or_else(|| {
        let meant = scenes::meant(plain, false).or_else(|| scenes::meant(plain, true));
        let meant = meant.map(|near| format!("; did you mean `{near}`?"));
        let problem = format!(
            "is no scene or study that `thirdbody scenes` lists{}",
            meant.unwrap_or_default()
        );
        Refusal::argument(name, problem).into()
    })
}

fn require_empty(folder: &Path) -> Result<(), Error> {
    let empty = match fs::read_dir(folder) {
        Ok(mut entries) => entries.next().is_none(),
        Err(_) => !folder.exists(),
    };
    if empty {
        return Ok(());
    }
    let problem = "is there and not empty: nothing is overwritten, give another folder as the second argument";
    Err(Refusal::file(folder, problem).into())
}

/// The commands that come next.
fn next(files: &[(&str, &[u8])], folder: &Path) -> String {
    // A name alone could be that of a shipped scene, but a folder of that name goes before it.
    let place = folder.display();
    if files.iter().any(|(file, _)| *file == STUDY) {
        return format!(
            "next: edit {place}/{STUDY}, then\n  thirdbody study plan {place} --small\n  thirdbody study run {place} --small"
        );
    }
    format!(
        "next: edit {place}/scenario.toml, then\n  thirdbody check {place}\n  thirdbody run {place}\n  thirdbody report runs/latest"
    )
}
