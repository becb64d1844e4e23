//! The list of the shipped scenes and studies.

use serde::Serialize;

use super::{SCENE, STUDY, files_of, names, text};

/// A scene or a study.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Listed {
    /// Name, as verbs take it.
    pub name: String,
    /// What it shows, in a line.
    pub shows: String,
    /// Time that it takes, in words.
    pub time: String,
    /// Programs that it starts beside the shipped solvers.
    pub starts: Vec<String>,
    /// Its files.
    pub files: Vec<&'static str>,
}

/// A line of the tables of scenes and of studies in `scenarios/README.md`.
struct Line {
    names: Vec<String>,
    shows: String,
    time: String,
}

/// All scenes and studies in the order of the tables of `scenarios/README.md`, which say what each shows and how long it takes. A scene
/// that shares its line with others is told by the first sentence of its own file instead.
pub fn listing() -> Vec<Listed> {
    let lines: Vec<Line> = text("README.md").into_iter().flat_map(table).collect();
    let mut left = names();
    let mut listed = Vec::new();
    for line in &lines {
        let means = |name: &str| line.names.iter().any(|pattern| matches(pattern, name));
        let (own, others): (Vec<&str>, Vec<&str>) = left.iter().partition(|name| means(name));
        let alone = own.len() == 1;
        listed.extend(own.into_iter().map(|name| entry(name, line, alone)));
        left = others;
    }
    listed
}

fn entry(name: &str, line: &Line, alone: bool) -> Listed {
    let files = files_of(name);
    let own = [SCENE, STUDY].map(|file| text(&format!("{name}/{file}")));
    let own = own.into_iter().flatten().next().unwrap_or_default();
    let said = if alone { None } else { first_sentence(own) };
    Listed {
        name: name.into(),
        shows: said.unwrap_or_else(|| line.shows.clone()),
        time: line.time.clone(),
        starts: programs(own),
        files: files.into_iter().map(|(file, _)| file).collect(),
    }
}

/// Rows of tables whose first cell begins with a name in backquotes; a name without a folder has that of the first one.
fn table(manual: &str) -> impl Iterator<Item = Line> {
    let rows = manual.lines().filter(|line| line.starts_with("| `"));
    rows.filter_map(|row| {
        let cells: Vec<&str> = row.trim_matches('|').split(" | ").map(str::trim).collect();
        let [names, shows, time] = cells[..] else {
            return None;
        };
        let names: Vec<&str> = names.split('`').skip(1).step_by(2).collect();
        let folder = names.first()?.rsplit_once('/').map(|(folder, _)| folder);
        let whole = |name: &&str| match folder {
            Some(folder) if !name.contains('/') => format!("{folder}/{name}"),
            _ => name.to_string(),
        };
        Some(Line {
            names: names.iter().map(whole).collect(),
            shows: shows.into(),
            time: time.into(),
        })
    })
}

fn matches(pattern: &str, name: &str) -> bool {
    match pattern.strip_suffix('*') {
        Some(folder) => name.starts_with(folder),
        None => pattern == name,
    }
}

/// The first sentence of the comment that a file opens with.
fn first_sentence(text: &str) -> Option<String> {
    let head = text.lines().map_while(|line| line.strip_prefix('#'));
    let head = head.map(str::trim).collect::<Vec<_>>().join(" ");
    let end = head.find(". ").map_or(head.len(), |end| end + 1);
    (end > 0).then(|| head[..end].to_string())
}

/// The programs that a scenario's participants name.
fn programs(scenario: &str) -> Vec<String> {
    let table: toml::Table = scenario.parse().unwrap_or_default();
    let participants = table.get("participant").and_then(toml::Value::as_array);
    let commands = participants.into_iter().flatten();
    let programs = commands.filter_map(|participant| participant.get("command")?.get(0)?.as_str());
    programs.map(String::from).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_scene_and_every_study_is_in_the_manual_once() {
        let listed = listing();
        let mut told: Vec<&str> = listed.iter().map(|one| one.name.as_str()).collect();
        told.sort_unstable();
        let mut names = names();
        names.sort_unstable();
        assert_eq!(
            told, names,
            "scenarios/README.md has another list of scenes"
        );
        assert!(names.len() > 40, "{names:?}");
        for one in &listed {
            assert!(one.shows.len() > 10 && !one.time.is_empty(), "{one:?}");
        }
    }

    #[test]
    fn a_line_tells_of_one_scene_and_several_of_themselves() {
        let listed = listing();
        let of = |name: &str| {
            listed
                .iter()
                .find(|one| one.name == name)
                .expect("it ships")
        };
        assert!(of("quick").shows.starts_with("The main job, small"));
        assert!(
            of("verification/bar-driven")
                .shows
                .starts_with("A bar, held laterally")
        );
        assert!(
            of("extremes/disks")
                .shows
                .starts_with("Two disks above a plane wall")
        );
        assert_eq!(of("foreign/winkler").starts, ["python3"]);
        assert_eq!(of("foreign/winkler").files, ["rail.py", "scenario.toml"]);
    }

    /// Whatever a scene names beside itself must be inside the program too.
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
