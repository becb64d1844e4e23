//! `validation.html`: what came out of a suite, case by case, with pictures of its runs.

use std::path::Path;

use draw::svg::escape;
use report::page::{Section, names, page, table};
use report::pictures;
use report::units::{four, with_unit_of};
use serde_json::Value;

use super::case::{Basis, Number};
use super::suite::{CaseOutcome, CaseRow};
use coordinator::error::Error;

/// Name of the page in the folder of the suite.
const PAGE: &str = "validation.html";

/// Writes the page of a suite into its folder and returns the name of the file. `command` is what makes it again.
///
/// # Errors
/// A run that a picture is of is damaged, or the page cannot be written.
pub fn write(
    folder: &Path,
    title: &str,
    command: &str,
    cases: &[CaseOutcome],
) -> Result<&'static str, Error> {
    let sections = cases
        .iter()
        .enumerate()
        .map(|(number, case)| section(number, case));
    let sections = sections.collect::<Result<Vec<Section>, Error>>()?;
    let rows = || cases.iter().flat_map(|case| &case.rows);
    let (judged, told) = rows().partition::<Vec<&CaseRow>, _>(|row| !row.told);
    let wrong = judged.iter().filter(|row| !row.holds).count();
    let class = if wrong == 0 { "completed" } else { "failed" };
    let cost = |name: &str| -> f64 {
        let runs = cases.iter().flat_map(|case| &case.runs);
        runs.filter_map(|run| run.cost().get(name).copied()).sum()
    };
    let head = format!(
        "<div class=\"verdict {class}\"><p>{} of {} rows hold; {} more are told and not judged. The runs took {} of wall-clock and {} of \
         processor time.</p></div><pre>{}</pre>",
        judged.len() - wrong,
        judged.len(),
        told.len(),
        minutes(cost("wall_s")),
        minutes(cost("cpu_s")),
        escape(command)
    );
    let path = folder.join(PAGE);
    std::fs::write(&path, page(title, &head, &sections)).map_err(Error::output(path.display()))?;
    Ok(PAGE)
}

fn minutes(seconds: f64) -> String {
    match seconds < 120.0 {
        true => format!("{} s", four(seconds)),
        false => format!("{} min", four(seconds / 60.0)),
    }
}

fn section(number: usize, outcome: &CaseOutcome) -> Result<Section, Error> {
    let paragraph = |text: &str| match text.is_empty() {
        true => String::new(),
        false => format!("<p>{}</p>", names(&escape(text))),
    };
    let case = &outcome.case;
    let source = paragraph(&format!("Expected by: {}.", case.source));
    // The end and the warnings come before the numbers, which a run that did not come to its end has none of.
    let ends = outcome.rows.len() - outcome.rows.len().saturating_sub(2);
    let (ends, numbers) = outcome.rows.split_at(ends);
    let ended = ends
        .iter()
        .map(|row| ended(&outcome.name, row))
        .collect::<String>();
    let rows = case
        .number
        .iter()
        .zip(numbers)
        .map(|(number, row)| cells(number, row));
    let head = [
        "quantity",
        "ours",
        "over seeds",
        "must be",
        "paper",
        "difference",
        "basis",
        "",
    ];
    let runs = outcome.runs.iter();
    let seeds: Vec<String> = case.seeds.iter().map(u64::to_string).collect();
    let seeds = match seeds.is_empty() {
        true => String::new(),
        false => format!(
            " Seeds {}; the median and, beside it, the least and the largest.",
            seeds.join(", ")
        ),
    };
    let cost: Vec<String> = runs
        .filter_map(|run| run.cost().get("cpu_s").copied())
        .map(minutes)
        .collect();
    let cost = paragraph(&format!(
        "Processor time of each run: {}.{seeds}",
        cost.join(", ")
    ));
    let mut maps = Vec::new();
    if let Some(run) = outcome.runs.first().filter(|_| !case.pictures.is_empty()) {
        maps = pictures(run, &case.pictures)?;
    }
    for picture in &mut maps {
        // Two runs have pictures of the same name.
        picture.file = format!("{number}-{}", picture.file);
    }
    Ok(Section {
        maps,
        ..Section::of_text(
            &outcome.name,
            [
                paragraph(&outcome.above),
                paragraph(&case.text),
                source,
                ended,
                table(head, &[1, 2, 3, 4, 5], rows),
                cost,
            ]
            .concat(),
        )
    })
}

/// An end or a set of warnings that is not as it must be, or warnings that may be there.
fn ended(case: &str, row: &CaseRow) -> String {
    let none = row.ours.as_array().is_none_or(Vec::is_empty);
    if row.holds && none {
        return String::new();
    }
    let what = row
        .name
        .strip_prefix(case)
        .unwrap_or(&row.name)
        .trim_start_matches(": ");
    let wrong = if row.holds {
        ""
    } else {
        " <b>does not hold</b>"
    };
    format!(
        "<p>{}{wrong}: {}</p>",
        escape(what),
        escape(&row.ours.to_string())
    )
}

fn cells(number: &Number, row: &CaseRow) -> [String; 8] {
    let (_, unit) = number.path.rsplit_once('.').unwrap_or_default();
    // Of a column of signals the last word is which of its values.
    let unit = match number
        .path
        .strip_prefix("signals.")
        .and_then(|path| path.rsplit_once('.'))
    {
        Some((column, _)) => column,
        None => unit,
    };
    let pure = number.norm.is_some();
    let show = |x: f64| match pure {
        true => four(x),
        false => with_unit_of(unit, x),
    };
    let shown = |value: &Value| value.as_f64().map_or("none".into(), show);
    let must = match (row.told, number.ratio) {
        (true, _) => String::new(),
        (_, Some([least, most])) => format!(
            "{} to {} times {}",
            four(least),
            four(most),
            shown(&row.expected)
        ),
        _ => {
            let expected = row.expected.as_f64().unwrap_or(f64::NAN);
            let relative = number.tolerance_rel.unwrap_or(0.0) * expected.abs();
            let allowed = protocol::larger(relative, number.tolerance_abs.unwrap_or(0.0));
            format!("{} ± {}", shown(&row.expected), show(allowed))
        }
    };
    let paper = row
        .published
        .or(row.expected.as_f64().filter(|_| row.basis.is_some()));
    let difference = row
        .ours
        .as_f64()
        .zip(paper)
        .map(|(ours, paper)| (ours - paper) / paper.abs());
    let difference = difference.filter(|part| part.is_finite());
    [
        names(&escape(number.of.as_ref().unwrap_or(&number.path))),
        shown(&row.ours),
        row.seeds
            .map_or(String::new(), |seeds| seeds.map(show).join(" to ")),
        must,
        paper.map_or(String::new(), show),
        difference.map_or(String::new(), |part| format!("{:+.1} %", 100.0 * part)),
        row.basis.map_or("", Basis::word).into(),
        match (row.told, row.holds) {
            (_, false) => "<b>does not hold</b>".into(),
            (true, _) => "told".into(),
            _ => "holds".into(),
        },
    ]
}
