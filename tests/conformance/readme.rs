//! Pages about the code: `protocol/README.md` names the file formats with the versions that the code writes, and every code of an
//! error or a warning has an explanation.

use std::collections::BTreeSet;
use std::path::Path;

use harness::source::{Sources, product_crates, read_sources};
use kit::finding::finding_kinds;
use report::results::{GROUPS, entries, explained, is_old};
use scenario::error::explanations;

/// Names of formats with their versions, `thirdbody.<format>/<version>`, in a text.
fn formats(text: &str) -> BTreeSet<&str> {
    let parts = text.match_indices("thirdbody.").map(|(at, _)| &text[at..]);
    let names = parts.map(|part| {
        let of_name = |c: char| c.is_ascii_alphanumeric() || "./_".contains(c);
        &part[..part.find(|c| !of_name(c)).unwrap_or(part.len())]
    });
    names.filter(|name| name.contains('/')).collect()
}

#[test]
fn the_page_names_the_versions_of_formats_that_the_code_writes() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let crates = product_crates().into_iter();
    let sources: Vec<Sources> = crates.map(|(_, folder)| read_sources(&folder)).collect();
    let texts = sources.iter().flat_map(|sources| sources.values());
    let written: BTreeSet<&str> = texts.flat_map(|text| formats(text)).collect();
    let readme = std::fs::read_to_string(root.join("protocol/README.md")).expect("it is text");
    let named = formats(&readme);
    assert!(
        named.len() >= 2,
        "the log's and the checkpoint's: {named:?}"
    );
    assert!(
        named.is_subset(&written),
        "{named:?} are named, {written:?} are written"
    );
}

#[test]
fn each_code_is_there_once_and_says_why_and_what_to_do() {
    let all = explanations();
    let codes: BTreeSet<&str> = all.iter().map(|explanation| explanation.code).collect();
    assert_eq!(codes.len(), all.len(), "a code is there twice");
    assert!(codes.len() > 100, "the findings of all crates: {codes:?}");
    for explanation in all {
        let (code, paragraphs) = (explanation.code, &explanation.paragraphs);
        assert!(explanation.line().len() > 10, "{code}");
        for head in ["- Why: ", "- Do: "] {
            let points = paragraphs.iter().filter(|point| point.starts_with(head));
            assert_eq!(points.count(), 1, "{code}: {head}");
        }
        let judged = paragraphs
            .iter()
            .any(|point| point.starts_with("- Judged: "));
        let bounded = paragraphs
            .iter()
            .any(|point| point.starts_with("- Bounds: "));
        assert_eq!(judged, bounded, "{code}");
    }
}

#[test]
fn each_key_of_bounds_is_of_one_kind_and_in_order() {
    let mut keys = BTreeSet::new();
    for kind in finding_kinds() {
        let [warn, suspect] = kind.bounds;
        assert!(warn <= suspect, "{}", kind.code);
        for table in kind.tables {
            assert!(keys.insert((table, kind.key)), "{table} {}", kind.key);
        }
    }
    assert!(keys.len() > 35, "{keys:?}");
}

#[test]
fn results_stand_once_in_a_group_of_the_report_and_patterns_come_last() {
    let entries = entries();
    assert!(entries.len() > 190, "{}", entries.len());
    let names: BTreeSet<&str> = entries.iter().map(|entry| entry.name.as_str()).collect();
    assert_eq!(names.len(), entries.len(), "a name is there twice");
    for entry in &entries {
        assert!(
            GROUPS.contains(&&*entry.group),
            "{}: {}",
            entry.name,
            entry.group
        );
        assert!(entry.sentence.ends_with('.'), "{}", entry.name);
    }
    let says = |name: &str, words: &str| {
        let said = explained(name).unwrap_or_default();
        assert!(said.contains(words), "{name}: {said}");
    };
    says("interface_force_n", "through the interface");
    says("punch_reaction_y_n", "the moved set exerts");
    says("approach_m", "Way of the wheel");
    says("third-body-2.disks", "Free disks");
    assert_eq!(explained("temperature_k"), None);
    assert!(["friction_coefficient", "layer.friction_coefficient"].map(is_old) == [true; 2]);
    assert!(!is_old("traction_ratio_mean"));
}

/// Longest glossary (words).
const GLOSSARY: usize = 60;

#[test]
fn the_glossary_is_short_and_says_each_word_once() {
    let page = include_str!("../../protocol/README.md");
    let (_, glossary) = page.split_once("## Glossary\n").expect("there is one");
    let glossary = glossary.split("\n## ").next().unwrap_or(glossary);
    let rows = glossary.lines().filter(|line| line.starts_with("| *"));
    let mut words: Vec<&str> = rows.filter_map(|row| row.split('*').nth(1)).collect();
    let all = words.len();
    assert!((20..=GLOSSARY).contains(&all), "{all} words");
    words.sort_unstable();
    words.dedup();
    assert_eq!(words.len(), all, "a word stands there twice");
}
