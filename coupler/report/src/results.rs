//! Results with their units, in groups, each with a sentence.

use super::page::table;
use draw::svg::escape;
use draw::units::{with_unit_of, words};
use kit::results::{ResultKind, results};
use runs::files::RunFiles;

/// The groups, in the order of a report.
pub const GROUPS: [&str; 13] = [
    "Load and approach",
    "Friction and sliding",
    "Rolling",
    "Cycles of the wheel on grains",
    "Grains",
    "Bonds",
    "Heat",
    "Flows of third body",
    "Profiles across a layer",
    "Forces and places of sets",
    "Quality of the solution",
    "Signals",
    "Signals of the ledger",
];

/// All results and signals, group by group.
pub fn entries() -> Vec<ResultKind> {
    let mut all = results();
    all.sort_by_key(|entry| GROUPS.iter().position(|group| *group == entry.group));
    all
}

/// True for a column of signals.csv, which is no result.
fn is_signal(entry: &ResultKind) -> bool {
    entry.group.starts_with("Signals")
}

/// The names of all results, some with the prefix `<set>`.
pub fn names() -> Vec<String> {
    let results = entries().into_iter().filter(|entry| !is_signal(entry));
    results.map(|entry| entry.name).collect()
}

/// True for an old name of another result, named with or without its participant.
pub fn is_old(name: &str) -> bool {
    let entries = entries();
    number(&entries, name).is_some_and(|k| entries[k].sentence.starts_with("Old name of "))
}

/// The names of the results that need a full cycle of a wheel.
pub fn of_full_cycles() -> Vec<String> {
    let of_cycles = |entry: &ResultKind| {
        entry.group.starts_with("Cycles") || entry.sentence.contains("full cycle")
    };
    let entries = entries().into_iter().filter(of_cycles);
    entries.map(|entry| entry.name).collect()
}

/// The meaning of a result or a signal, named with or without its participant.
pub fn explained(name: &str) -> Option<String> {
    let entries = entries();
    let entry = &entries[number(&entries, name)?];
    let kind = ["result", "signal"][usize::from(is_signal(entry))];
    Some(format!("{name} (a {kind}): {}", entry.sentence))
}

/// True if the entry explains a name; `<set>` stands for any beginning.
fn explains(entry: &ResultKind, name: &str) -> bool {
    match entry.name.strip_prefix("<set>") {
        Some(ending) => name.len() > ending.len() && name.ends_with(ending),
        None => name == entry.name,
    }
}

/// Index of the entry that explains a result, named with or without its participant or interface; exact names take precedence over
/// patterns.
fn number(entries: &[ResultKind], name: &str) -> Option<usize> {
    let last = name.rsplit('.').next()?;
    let exact = |name: &str| entries.iter().position(|entry| entry.name == name);
    let pattern = |name: &str| entries.iter().position(|entry| explains(entry, name));
    exact(name)
        .or_else(|| exact(last))
        .or_else(|| pattern(last))
}

/// Group for results of foreign solvers, which have no entry.
const OTHERS: &str = "Others";

/// Results of one group.
pub(super) struct ResultGroup<'a> {
    pub(super) title: String,
    /// Name, value and sentence of each.
    pub(super) results: Vec<(&'a str, f64, String)>,
}

/// The results of a run, group by group.
pub(super) fn groups(run: &RunFiles) -> Vec<ResultGroup<'_>> {
    let entries = entries();
    let place = |name: &str| number(&entries, name).unwrap_or(entries.len());
    let known = run.entries("results");
    let known = known.filter_map(|(name, value)| Some((place(name), &**name, value.as_f64()?)));
    let mut known: Vec<(usize, &str, f64)> = known.collect();
    known.sort_by_key(|(place, name, _)| (*place, *name));
    let title = |place: usize| entries.get(place).map_or(OTHERS, |entry| &entry.group);
    let sentence = |place: usize| {
        let entry = entries.get(place);
        entry.map_or(String::new(), |entry| entry.sentence.clone())
    };
    let groups = known.chunk_by(|a, b| title(a.0) == title(b.0));
    let groups = groups.map(|group| {
        let results = group.iter();
        let results = results.map(|(place, name, value)| (*name, *value, sentence(*place)));
        ResultGroup {
            title: title(group[0].0).into(),
            results: results.collect(),
        }
    });
    groups.collect()
}

/// Tables of the results of a run, one per group.
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
        html += &format!("<h3>{}</h3>", escape(&group.title));
        html += &table(["result", "value", "", "name"], &[1], rows);
    }
    html
}
