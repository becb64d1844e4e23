//! Scenes and studies built into this program: they run anywhere, without the source tree.
//!
//! - [`listing`]: the list of them, each with its purpose and time from its table `[about]`;
//! - [`kept`]: their files on the disk, for programs that read them there.

use kit::keys::nearest;

pub mod kept;
pub mod listing;

/// All files that `build.rs` found, as paths below `scenarios/` with their contents.
pub const FILES: &[(&str, &[u8])] = include!(concat!(env!("OUT_DIR"), "/shipped.rs"));

/// File name of a scene.
pub const SCENE: &str = "scenario.toml";

/// File name of a study.
pub const STUDY: &str = "study.toml";

/// Folder of the studies.
const STUDIES: &str = "studies/";

/// The text of a file.
pub fn text(path: &str) -> Option<&'static str> {
    let (_, content) = FILES.iter().find(|(name, _)| *name == path)?;
    std::str::from_utf8(content).ok()
}

/// The file of the scene with this name: a scene's name (`quick`) or the path of a file (`foreign/yade/dem-node.toml`).
pub fn scene_file(name: &str) -> Option<String> {
    let name = name.trim_end_matches('/');
    let own = [format!("{name}/{SCENE}"), name.to_string()];
    let mut own = own.into_iter().filter(|path| path.ends_with(".toml"));
    own.find(|path| !path.starts_with(STUDIES) && text(path).is_some())
}

/// The folder of the study with this name, with or without `studies/`.
pub fn study_folder(name: &str) -> Option<String> {
    let name = name.trim_end_matches('/');
    let name = name.strip_prefix(STUDIES).unwrap_or(name);
    let folder = format!("{STUDIES}{name}");
    text(&format!("{folder}/{STUDY}"))
        .is_some()
        .then_some(folder)
}

/// Paths and texts of all files with this name in folders of studies.
pub fn of_studies(file: &str) -> impl Iterator<Item = (&'static str, &'static str)> {
    let paths = FILES.iter().map(|(path, _)| *path);
    let own = paths.filter(move |path| {
        let inside = path.strip_prefix(STUDIES);
        inside.is_some_and(|path| path.split_once('/').is_some_and(|(_, name)| name == file))
    });
    own.filter_map(|path| Some((path, text(path)?)))
}

/// The files below a folder, as paths from there. The expectations of validation are left out: they hold only for the unchanged scene.
pub fn files_of(folder: &str) -> Vec<(&'static str, &'static [u8])> {
    let inside = |(path, content): &(&'static str, &'static [u8])| {
        let path = path.strip_prefix(folder)?.strip_prefix('/')?;
        (path != "expected.toml").then_some((path, *content))
    };
    FILES.iter().filter_map(inside).collect()
}

/// True for a scene that reads only its own file.
pub fn stands_alone(scene_file: &str) -> bool {
    let folder = scene_file.rsplit_once('/').map_or("", |(folder, _)| folder);
    files_of(folder).len() == 1
}

/// Names of all scenes and studies.
pub fn names() -> Vec<&'static str> {
    let folder = |(path, _): &(&'static str, _)| {
        let (folder, file) = path.rsplit_once('/')?;
        [SCENE, STUDY].contains(&file).then_some(folder)
    };
    FILES.iter().filter_map(folder).collect()
}

/// The scene or study that a mistyped name most likely means, with or without its folder.
pub fn meant(name: &str, study: bool) -> Option<&'static str> {
    let name = name.trim_start_matches("scenarios/");
    let names = names().into_iter();
    let names: Vec<&str> = names
        .filter(|name| name.starts_with(STUDIES) == study)
        .collect();
    let last = |name: &&'static str| name.rsplit('/').next().unwrap_or(name);
    let short: Vec<&str> = names.iter().map(last).collect();
    let whole = |short: &str| names.iter().copied().find(|name| last(name) == short);
    nearest(name, &names).or_else(|| whole(nearest(name, &short)?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scenes_and_studies_go_by_their_folders() {
        assert_eq!(scene_file("quick").as_deref(), Some("quick/scenario.toml"));
        let other = "foreign/yade/dem-node.toml";
        assert_eq!(scene_file(other).as_deref(), Some(other));
        assert_eq!(scene_file("studies/fidelity/study.toml"), None);
        assert_eq!(scene_file("studies"), None);
        for name in ["fidelity", "studies/fidelity", "studies/fidelity/"] {
            assert_eq!(study_folder(name).as_deref(), Some("studies/fidelity"));
        }
        assert_eq!(study_folder("quick"), None);
    }

    #[test]
    fn a_mistyped_name_is_understood_without_its_folder() {
        assert_eq!(meant("quik", false), Some("quick"));
        assert_eq!(meant("winkler", false), Some("foreign/winkler"));
        assert_eq!(
            meant("tradeof-coupled", true),
            Some("studies/tradeoff-coupled")
        );
        assert_eq!(meant("something else altogether", false), None);
    }

    #[test]
    fn pictures_results_and_expectations_stay_behind() {
        let files = files_of("studies/quick-bonded");
        let names: Vec<&str> = files.iter().map(|(name, _)| *name).collect();
        assert_eq!(names, ["study.json", "study.toml"]);
        let mesh = files_of("verification/pressurised-cylinder");
        let names: Vec<&str> = mesh.iter().map(|(name, _)| *name).collect();
        assert_eq!(names, ["cylinder.msh", "scenario.toml"]);
    }
}
