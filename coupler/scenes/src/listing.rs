//! The list of the built-in scenes and studies.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{SCENE, STUDY, files_of, names, text};

/// The table `[about]` of a scene or a study describes it to readers; no run depends on it.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct About {
    /// Purpose of the scene, in a line or two.
    pub shows: String,
    /// Wall-clock time on two cores, in words.
    pub time: String,
    /// Search words: solvers (`fem`, `dem`, `coupled`, `foreign`) and subjects.
    #[serde(default)]
    pub tags: Vec<String>,
}

/// A scene or a study.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Listed {
    /// Name that verbs accept.
    pub name: String,
    /// Its description.
    #[serde(flatten)]
    pub about: About,
    /// Programs that it starts in addition to the shipped solvers.
    pub starts: Vec<String>,
    /// Its files.
    pub files: Vec<&'static str>,
}

/// Folders of scenes in the order of the list; scenes without a folder come first.
const FOLDERS: [&str; 7] = [
    "foreign",
    "verification",
    "rolling",
    "heat",
    "benchmarks",
    "extremes",
    "studies",
];

/// All scenes and studies by folder and name, as their tables `[about]` describe them.
pub fn listing() -> Vec<Listed> {
    let mut listed: Vec<Listed> = names().into_iter().map(entry).collect();
    let folder = |one: &Listed| {
        let (folder, _) = one.name.split_once('/')?;
        FOLDERS.iter().position(|known| *known == folder)
    };
    listed.sort_by_key(folder);
    listed
}

fn entry(name: &str) -> Listed {
    let own = [SCENE, STUDY].map(|file| text(&format!("{name}/{file}")));
    let own = own.into_iter().flatten().next().unwrap_or_default();
    let table: toml::Table = own.parse().unwrap_or_default();
    let about = table.get("about").cloned();
    Listed {
        name: name.into(),
        about: about
            .and_then(|about| about.try_into().ok())
            .unwrap_or_default(),
        starts: programs(&table),
        files: files_of(name).into_iter().map(|(file, _)| file).collect(),
    }
}

/// The programs that a scenario's participants name.
fn programs(scenario: &toml::Table) -> Vec<String> {
    let participants = scenario.get("participant").and_then(toml::Value::as_array);
    let commands = participants.into_iter().flatten();
    let programs = commands.filter_map(|participant| participant.get("command")?.get(0)?.as_str());
    programs.map(String::from).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_scene_and_every_study_describes_itself() {
        let listed = listing();
        assert!(listed.len() > 40, "{listed:?}");
        for one in &listed {
            let about = &one.about;
            assert!(
                about.shows.len() > 10 && about.shows.ends_with('.'),
                "{one:?}"
            );
            assert!(!about.time.is_empty() && !about.tags.is_empty(), "{one:?}");
        }
        assert!(!listed[0].name.contains('/'), "{:?}", listed[0]);
    }

    #[test]
    fn an_entry_has_the_programs_and_files_of_its_scene() {
        let winkler = entry("foreign/winkler");
        assert_eq!(winkler.starts, ["python3"]);
        assert_eq!(winkler.files, ["rail.py", "scenario.toml"]);
        assert_eq!(winkler.about.time, "4 s");
    }

    /// Files that a scene names must be built into the program too.
    #[test]
    fn files_that_scenes_name_are_shipped() {
        for (name, file) in names().into_iter().flat_map(|n| [(n, SCENE), (n, STUDY)]) {
            let Some(own) = text(&format!("{name}/{file}")) else {
                continue;
            };
            let files = files_of(name);
            let words = own
                .lines()
                .filter(|line| !line.starts_with('#'))
                .flat_map(|l| l.split('"'));
            for word in words.filter(|word| word.ends_with(".msh") || word.ends_with(".py")) {
                assert!(
                    files.iter().any(|(file, _)| *file == word),
                    "{name}: {word}"
                );
            }
        }
    }
}
