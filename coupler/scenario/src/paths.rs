//! The files that the solvers' own keys name.

use std::path::{Path, PathBuf};

use toml::{Table, Value};

/// Makes file names in texts below `participant.config` absolute, so that a solver finds the files in any folder and a
/// replay finds them again. Only the solvers know which keys hold files. A text counts as a file if it is the absolute
/// path of one, or if it has an extension and the file exists next to the scenario or, failing that, in the working
/// directory. Returns all of them.
pub(super) fn make_absolute(scenario: &mut Table, folder: &Path) -> Vec<String> {
    let mut found = Vec::new();
    let participants = scenario.get_mut("participant");
    let participants = participants.and_then(Value::as_array_mut);
    let each = participants.into_iter().flatten();
    for config in each.filter_map(|participant| participant.get_mut("config")) {
        anchor(config, folder, &mut found);
    }
    found
}

fn anchor(value: &mut Value, folder: &Path, found: &mut Vec<String>) {
    match value {
        Value::String(text) => {
            if let Some(path) = file(text, folder) {
                found.push(path.clone());
                *text = path;
            }
        }
        Value::Array(values) => {
            values
                .iter_mut()
                .for_each(|value| anchor(value, folder, found));
        }
        Value::Table(table) => {
            table
                .iter_mut()
                .for_each(|(_, value)| anchor(value, folder, found));
        }
        _ => {}
    }
}

fn file(text: &str, folder: &Path) -> Option<String> {
    let path = Path::new(text);
    if path.is_absolute() {
        return path.is_file().then(|| text.to_string());
    }
    path.extension()?;
    let candidates = [folder.join(path), PathBuf::from(path)];
    let found = candidates.into_iter().find(|path| path.is_file())?;
    let absolute = std::path::absolute(found).ok()?;
    absolute.into_os_string().into_string().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_files_of_solvers_become_absolute() {
        // Tests run in the folder of their crate, which has these files.
        let text = "[run]\nname = \"Cargo.toml\"\n[[participant]]\nconfig = { a = \"Cargo.toml\", b = [\"lib.rs\"], c = \"none.msh\", d = \"src\" }\n";
        let mut table: Table = text.parse().expect("it is TOML");
        make_absolute(&mut table, Path::new("src"));
        let config = &table["participant"][0]["config"];
        let here = Path::new(env!("CARGO_MANIFEST_DIR"));
        assert_eq!(
            config["a"].as_str().map(Path::new),
            Some(&*here.join("Cargo.toml"))
        );
        assert_eq!(
            config["b"][0].as_str().map(Path::new),
            Some(&*here.join("src/lib.rs"))
        );
        assert_eq!(config["c"].as_str(), Some("none.msh"));
        assert_eq!(config["d"].as_str(), Some("src"));
        assert_eq!(table["run"]["name"].as_str(), Some("Cargo.toml"));
    }
}
