//! Results with their units, in groups, a sentence each: those of RESULTS.md.

use super::page::table;
use super::units::{with_unit_of, words};
use draw::svg::escape;
use runs::files::RunFiles;

/// The page that names and explains all results.
const PAGE: &str = include_str!("../../RESULTS.md");

/// A result as the page explains it.
struct Entry {
    group: &'static str,
    /// Its name, which may begin with `<set>`.
    name: &'static str,
    sentence: &'static str,
}

/// The entries of the page, in its order.
fn entries() -> Vec<Entry> {
    let mut group = "";
    let mut all = Vec::new();
    for line in PAGE.lines() {
        if let Some(title) = line.strip_prefix("## ") {
            group = title;
        } else if let Some((name, sentence)) =
            line.strip_prefix("- `").and_then(|l| l.split_once("`: "))
        {
            all.push(Entry {
                group,
                name,
                sentence,
            });
        }
    }
    all
}

/// The heading below which are no results but the columns of signals.csv.
const SIGNALS: &str = "Signals";

/// The names of all results that the page explains, some with a `<set>` in front.
pub fn names() -> Vec<&'static str> {
    let results = entries().into_iter().filter(|entry| entry.group != SIGNALS);
    results.map(|entry| entry.name).collect()
}

/// The names of those that need a full cycle of a wheel.
pub fn of_full_cycles() -> Vec<&'static str> {
    let of_cycles =
        |entry: &Entry| entry.group.starts_with("Cycles") || entry.sentence.contains("full cycle");
    let entries = entries().into_iter().filter(of_cycles);
    entries.map(|entry| entry.name).collect()
}

/// The entry of RESULTS.md for a result or a signal, whether or not the name of its participant stands before it.
pub fn explained(name: &str) -> Option<String> {
    let entries = entries();
    let entry = &entries[number(&entries, name)?];
    let kind = ["result", "signal"][usize::from(entry.group == SIGNALS)];
    Some(format!("{name} (a {kind}): {}", entry.sentence))
}

impl Entry {
    fn explains(&self, name: &str) -> bool {
        match self.name.strip_prefix("<set>") {
            Some(ending) => name.len() > ending.len() && name.ends_with(ending),
            None => name == self.name,
        }
    }
}

/// Number of the entry that explains a result, whether or not the name of its participant or interface stands before it; exact names come
/// before patterns.
fn number(entries: &[Entry], name: &str) -> Option<usize> {
    let last = name.rsplit('.').next()?;
    let exact = |name: &str| entries.iter().position(|entry| entry.name == name);
    let pattern = |name: &str| entries.iter().position(|entry| entry.explains(name));
    exact(name)
        .or_else(|| exact(last))
        .or_else(|| pattern(last))
}

/// Group for results that the page does not know, which come from foreign solvers.
const OTHERS: &str = "Others";

/// Results of one heading of the page.
pub(super) struct ResultGroup<'a> {
    pub(super) title: &'static str,
    /// Name, value and sentence of each.
    pub(super) results: Vec<(&'a str, f64, &'static str)>,
}

/// The results of a run as the page orders them.
pub(super) fn groups(run: &RunFiles) -> Vec<ResultGroup<'_>> {
    let entries = entries();
    let place = |name: &str| number(&entries, name).unwrap_or(entries.len());
    let known = run.entries("results");
    let known = known.filter_map(|(name, value)| Some((place(name), &**name, value.as_f64()?)));
    let mut known: Vec<(usize, &str, f64)> = known.collect();
    known.sort_by_key(|(place, name, _)| (*place, *name));
    let title = |place: usize| entries.get(place).map_or(OTHERS, |entry| entry.group);
    let sentence = |place: usize| entries.get(place).map_or("", |entry| entry.sentence);
    let groups = known
        .chunk_by(|a, b| title(a.0) == title(b.0))
        .map(|group| {
            let results = group.iter();
            let results = results.map(|(place, name, value)| (*name, *value, sentence(*place)));
            ResultGroup {
                title: title(group[0].0),
                results: results.collect(),
            }
        });
    groups.collect()
}

/// Tables of the results of a run, a group each.
pub(super) fn grouped(run: &RunFiles) -> String {
    let mut html = String::new();
    for group in groups(run) {
        let rows = group.results.iter().map(|(name, value, sentence)| {
            [
                escape(&words(name)),
                escape(&with_unit_of(name, *value)),
                escape(sentence),
                format!("<code>{}</code>", escape(name)),
            ]
        });
        html += &format!("<h3>{}</h3>", escape(group.title));
        html += &table(["result", "value", "", "name"], &[1], rows);
    }
    html
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_stand_once_and_patterns_come_after_exact_names() {
        let entries = entries();
        assert!(entries.len() > 80, "{}", entries.len());
        for entry in &entries {
            let same = entries
                .iter()
                .filter(|other| other.name == entry.name)
                .count();
            assert_eq!(same, 1, "{}", entry.name);
            assert!(entry.sentence.ends_with('.'), "{}", entry.name);
        }
        let name_of = |name: &str| number(&entries, name).map(|number| entries[number].name);
        assert_eq!(name_of("interface_force_n"), Some("interface_force_n"));
        assert_eq!(name_of("punch_reaction_y_n"), Some("<set>_reaction_y_n"));
        assert_eq!(name_of("approach_m"), Some("approach_m"));
        assert_eq!(name_of("third-body-2.disks"), Some("disks"));
        assert_eq!(name_of("temperature_k"), None);
    }
}
