//! Parts of the committed pages that come from the tables beside the code. `cargo run --release -p tests --bin pages` writes them,
//! and a test compares the pages with them.

use std::path::{Path, PathBuf};

use kit::FindingKind;
use kit::finding::finding_kinds;
use kit::results::ResultKind;
use scenario::error::{Explanation, explanations};
use scenes::listing::{Listed, listing};

use super::reference::{keys, verbs};

/// Opens a written part in a page: `<!-- list: scenes -->`.
const OPEN: &str = "<!-- list: ";

/// Closes it.
const CLOSE: &str = "<!-- end of list -->";

/// The pages with such parts, from the root of the repository.
const PAGES: [&str; 9] = [
    "scenarios/README.md",
    "scenarios/book/src/reference/errors.md",
    "scenarios/book/src/reference/findings.md",
    "scenarios/book/src/reference/results.md",
    "scenarios/book/src/reference/verbs.md",
    "scenarios/book/src/reference/keys.md",
    "scenarios/book/src/reference/keys-fem.md",
    "scenarios/book/src/reference/keys-dem.md",
    "scenarios/book/src/reference/keys-interface.md",
];

/// A page as it is and as it should be.
pub struct Page {
    /// Its file.
    pub path: PathBuf,
    /// Its text.
    pub stands: String,
    /// The text with all parts written anew.
    pub written: String,
}

/// All pages with written parts.
///
/// # Panics
/// A page is missing, or has a part without an end or without a list.
pub fn pages() -> Vec<Page> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let page = |name: &str| {
        let path = root.join(name);
        let stands = std::fs::read_to_string(&path).expect("the page is committed");
        let written = rewrite(&stands);
        Page {
            path,
            stands,
            written,
        }
    };
    PAGES.map(page).into()
}

/// A page with the text of each part replaced by its list.
fn rewrite(page: &str) -> String {
    let mut parts = page.split(OPEN);
    let mut text = parts.next().unwrap_or_default().to_string();
    for part in parts {
        let (name, rest) = part.split_once(" -->\n").expect("a part has a name");
        let (_, after) = rest.split_once(CLOSE).expect("a part is closed");
        text += &format!("{OPEN}{name} -->\n{}{CLOSE}{after}", list(name));
    }
    text
}

/// The list of a name.
fn list(name: &str) -> String {
    let of = |study: bool| {
        listing()
            .into_iter()
            .filter(move |one| one.name.starts_with("studies/") == study)
    };
    match name {
        "scenes" => table("| scene | what it shows | time |", of(false)),
        "studies" => table("| study | what it varies | time, `--small` |", of(true)),
        "bounds" => bounds(),
        "errors" => entries(|explanation| explanation.exit_code.is_some()),
        "warnings" => entries(|explanation| explanation.exit_code.is_none()),
        "results" => results(),
        "verbs" => verbs(&coupler::cli::command()),
        name if name.starts_with("keys ") => keys(&name["keys ".len()..]),
        other => panic!("no list is called {other}"),
    }
}

/// The bounds of all checks, the coupler's first.
fn bounds() -> String {
    let heading =
        "| key | value that is judged | bounds | valid | wrong |\n|---|---|---|---|---|\n"
            .to_string();
    let mut kinds = finding_kinds();
    kinds.retain(|kind| !kind.key.is_empty());
    kinds.sort_by_key(|kind| std::cmp::Reverse(kind.tables[0]));
    let row = |kind: &&FindingKind| {
        let key = match kind.tables {
            ["run"] => format!("`run.plausible.{}`", kind.key),
            tables => format!("{} `plausible.{}`", tables.join(", "), kind.key),
        };
        let [judged, valid, wrong] =
            ["Judged", "Valid", "Wrong"].map(|point| kind.point(point).replace('|', "\\|"));
        let [warn, suspect] = kind.bounds_in_words();
        format!(
            "| {key} | {} | {warn}, {suspect} | {} | {} |\n",
            judged,
            valid.trim_end_matches('.'),
            wrong.trim_end_matches('.')
        )
    };
    heading + &kinds.iter().map(row).collect::<String>()
}

/// Entries of codes.
fn entries(of: impl Fn(&Explanation) -> bool) -> String {
    let entries = explanations().into_iter().filter(of);
    let entry = |entry: Explanation| format!("### `{}`\n\n{}\n", entry.code, entry.text());
    format!("\n{}", entries.map(entry).collect::<String>())
}

/// All results and signals, group by group.
fn results() -> String {
    let all = report::results::entries();
    let groups = all.chunk_by(|a, b| a.group == b.group);
    let group = |group: &[ResultKind]| {
        let line = |one: &ResultKind| format!("- `{}`: {}\n", one.name, one.sentence);
        let lines: String = group.iter().map(line).collect();
        format!("\n## {}\n\n{lines}", group[0].group)
    };
    groups.map(group).collect::<String>() + "\n"
}

/// A table of scenes or studies: folder by folder, the shortest first.
fn table(heading: &str, listed: impl Iterator<Item = Listed>) -> String {
    let mut listed: Vec<Listed> = listed.collect();
    let folder = |one: &Listed| {
        one.name
            .rsplit_once('/')
            .map(|(folder, _)| folder.to_string())
    };
    for of_folder in listed.chunk_by_mut(|a, b| folder(a) == folder(b)) {
        of_folder.sort_by_key(|one| seconds(&one.about.time));
    }
    let scenarios = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenarios");
    let row = |one: &Listed| {
        let page = format!("{}/README.md", one.name);
        let name = match scenarios.join(&page).is_file() {
            true => format!("[`{}`]({page})", one.name),
            false => format!("`{}`", one.name),
        };
        format!("| {name} | {} | {} |\n", one.about.shows, one.about.time)
    };
    let rows: String = listed.iter().map(row).collect();
    format!("{heading}\n|---|---|---|\n{rows}")
}

/// The first time in words, in seconds: `14 to 30 min`; a time without a number comes first.
fn seconds(time: &str) -> u64 {
    let mut words = time.split([' ', ',']);
    let number = words.by_ref().find_map(|word| word.parse::<u64>().ok());
    let unit = words.find_map(|word| match word {
        "s" => Some(1),
        "min" => Some(60),
        "h" | "hour" | "hours" => Some(3600),
        _ => None,
    });
    number.unwrap_or(0) * unit.unwrap_or(1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pages_match_the_tables_beside_the_code() {
        for page in pages() {
            assert!(
                page.stands == page.written,
                "{}: `cargo run --release -p tests --bin pages` writes it anew",
                page.path.display()
            );
        }
    }

    #[test]
    fn every_scene_on_the_disk_is_inside_the_program() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenarios");
        let inside = std::fs::read_dir(folder).expect("it is there").flatten();
        let scenes = inside.filter(|entry| entry.path().join("scenario.toml").is_file());
        for scene in scenes {
            let name = scene.file_name().to_string_lossy().into_owned();
            let known = listing().iter().any(|one| one.name == name);
            assert!(known, "`{name}` is new: touch coupler/scenes/build.rs");
        }
    }

    #[test]
    fn times_in_words_are_ordered() {
        let times = [
            "a few seconds",
            "3 s",
            "under 1 min, 1 min whole",
            "14 to 30 min",
        ];
        assert_eq!(times.map(seconds), [0, 3, 60, 840]);
    }
}
