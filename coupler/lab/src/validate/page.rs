//! `validation.html`: the results of a suite, case by case, with pictures of its runs.

use std::path::Path;

use draw::svg::escape;
use draw::units::{four, with_unit_of};
use report::page::{Section, names, page, table};
use report::provenance::quoted;
use report::{pictures, save};

use super::case::Number;
use super::suite::{CaseOutcome, CaseRow};
use scenario::error::Error;

/// Name of the page in the folder of the suite.
const PAGE: &str = "validation.html";

/// Writes the page of a suite into its folder and returns the name of the file. `command` repeats the suite.
///
/// # Errors
/// A run with a picture is damaged, or the page cannot be written.
pub fn write(
    folder: &Path,
    title: &str,
    command: &str,
    cases: &[CaseOutcome],
) -> Result<&'static str, Error> {
    let sections = cases.iter().enumerate();
    let sections = sections.map(|(number, case)| section(number, case));
    let sections = sections.collect::<Result<Vec<Section>, Error>>()?;
    let rows = || cases.iter().flat_map(|case| &case.rows);
    let (judged, others) = rows().partition::<Vec<&CaseRow>, _>(|row| !row.reported);
    let wrong = judged.iter().filter(|row| !row.holds).count();
    let class = if wrong == 0 { "completed" } else { "failed" };
    let runs = || cases.iter().flat_map(|case| &case.runs).map(|(run, _)| run);
    let cost = |name| -> f64 { runs().filter_map(|run| run.cost().get(name).copied()).sum() };
    let manifest = runs().next().map(|run| run.manifest()).unwrap_or_default();
    let made_by = ["software", "build", "git", "processor", "cores"];
    let [software, build, git, processor, cores] = made_by.map(|key| {
        let text = manifest[key].as_str().map(String::from);
        escape(&text.unwrap_or(manifest[key].to_string()))
    });
    let head = format!(
        "<div class=\"verdict {class}\"><p>{} of {} rows hold; {} more are reported but not judged. The runs took {} of wall-clock and {} of \
        processor time.</p></div><pre>{}</pre><p>{software}, build {build}, git {git}; {processor}, {cores} cores.</p>",
        judged.len() - wrong,
        judged.len(),
        others.len(),
        minutes(cost("wall_s")),
        minutes(cost("cpu_s")),
        escape(command)
    );
    let path = folder.join(PAGE);
    save(&path, &page(title, &head, &sections))?;
    Ok(PAGE)
}

fn minutes(seconds: f64) -> String {
    match seconds {
        ..120.0 => format!("{} s", four(seconds)),
        _ => format!("{} min", four(seconds / 60.0)),
    }
}

fn section(number: usize, outcome: &CaseOutcome) -> Result<Section, Error> {
    let paragraph = |text: &str| {
        if text.is_empty() {
            String::new()
        } else {
            format!("<p>{}</p>", names(&escape(text)))
        }
    };
    let case = &outcome.case;
    // Exit code and warnings come before the numbers; a run that did not reach its end has no numbers.
    let (ends, numbers) = outcome.rows.split_at(outcome.rows.len().min(2));
    let ends = ends.iter().map(|row| ended(&outcome.name, row));
    let rows = case.number.iter().zip(numbers);
    let rows = rows.map(|(number, row)| cells(number, row));
    let runs = outcome.runs.iter();
    let cpu = runs.filter_map(|(run, _)| run.cost().get("cpu_s").copied());
    let mut parts = vec![
        paragraph(&outcome.above),
        paragraph(&case.text),
        paragraph(&format!("Expected by: {}.", case.source)),
        format!("<pre>{}</pre>", escape(&repeated(outcome))),
    ];
    parts.extend(ends);
    parts.push(table(HEAD, &[1, 2, 3, 4, 5], rows));
    let cpu = Vec::from_iter(cpu.map(minutes)).join(", ");
    parts.push(paragraph(&format!("Processor time of each run: {cpu}.")));
    let mut drawn = Section::default();
    if let Some((run, reference)) = outcome.runs.first().filter(|_| !case.pictures.is_empty()) {
        drawn = pictures(run, reference.as_ref(), &case.pictures)?;
        let all = || drawn.maps.iter().chain(&drawn.plots);
        let missing = case.pictures.iter();
        let missing = missing.filter(|file| all().all(|picture| picture.file != **file));
        parts.extend(missing.map(|file| paragraph(&format!("The run has no data for `{file}`."))));
    }
    for picture in drawn.maps.iter_mut().chain(&mut drawn.plots) {
        // Pictures of different cases have the same names.
        picture.file = format!("{number}-{}", picture.file);
    }
    Ok(Section {
        title: outcome.name.clone(),
        text: parts.concat(),
        ..drawn
    })
}

/// The table's head; with several seeds, `ours` is the median, and the next column has the smallest and the largest value.
const HEAD: [&str; 8] = [
    "quantity",
    "ours",
    "over seeds",
    "reference",
    "paper",
    "difference",
    "basis",
    "",
];

/// The command that runs the case again.
fn repeated(outcome: &CaseOutcome) -> String {
    let (case, scenario) = (&outcome.case, &outcome.scenario);
    // The path below the folder of the scenes, without the relative steps from the file of the suite.
    let mut name = Vec::new();
    let parts = scenario.components();
    for part in parts.filter_map(|part| part.as_os_str().to_str()) {
        match part {
            ".." => drop(name.pop()),
            "scenarios" => name.clear(),
            part => name.push(part),
        }
    }
    let mut set: Vec<String> = case.set.iter().map(|set| quoted(set)).collect();
    if !case.seeds.is_empty() {
        let seeds: Vec<String> = case.seeds.iter().map(u64::to_string).collect();
        set.push(format!("run.seed=S   # S = {}", seeds.join(", ")));
    }
    let set = set.iter().map(|set| format!(" \\\n    --set {set}"));
    let set: String = set.collect();
    format!("thirdbody run {}{set}", name.join("/"))
}

/// An unexpected exit code or set of warnings, or allowed warnings.
fn ended(case: &str, row: &CaseRow) -> String {
    let none = row.ours.as_array().is_none_or(Vec::is_empty);
    if row.holds && none {
        return String::new();
    }
    let what = row.name.strip_prefix(case).unwrap_or(&row.name);
    let what = escape(what.trim_start_matches(": "));
    let wrong = [" <b>does not hold</b>", ""][usize::from(row.holds)];
    format!("<p>{what}{wrong}: {}</p>", escape(&row.ours.to_string()))
}

/// The cells of a number, in SI units with prefixes by its name; a norm has no unit.
fn cells(number: &Number, row: &CaseRow) -> [String; 8] {
    // For signals, the last word selects a value of the column.
    let path = match number.path.rsplit_once('.') {
        Some((column, _)) if number.path.starts_with("signals.") => column,
        _ => &number.path,
    };
    let unit = if number.norm.is_some() { "" } else { path };
    let show = |x: f64| with_unit_of(unit, x);
    let (ours, expected) = (row.ours.as_f64(), row.expected.as_f64());
    let reference = expected.map_or(String::new(), |expected| match number.ratio {
        _ if row.reported => show(expected),
        Some([least, most]) => {
            format!("{} to {} times {}", four(least), four(most), show(expected))
        }
        None => format!("{} ± {}", show(expected), show(number.allowed(expected))),
    });
    let difference = ours.zip(row.published.or(expected));
    let difference = difference.map(|(ours, of)| 100.0 * (ours - of) / of.abs());
    let difference = difference.filter(|part| part.is_finite());
    let seeds = row.seeds.map(|seeds| seeds.map(show).join(" to "));
    let verdict = match (row.reported, row.holds) {
        (_, false) => "<b>does not hold</b>",
        (true, _) => "reported",
        _ => "holds",
    };
    [
        names(&escape(number.of.as_ref().unwrap_or(&number.path))),
        ours.map_or("none".into(), show),
        seeds.unwrap_or_default(),
        reference,
        row.published.map_or(String::new(), show),
        difference.map_or(String::new(), |part| format!("{part:+.1} %")),
        row.basis.map_or(String::new(), |basis| basis.to_string()),
        verdict.into(),
    ]
}
