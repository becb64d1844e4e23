//! `thirdbody compare`: a run against a reference run.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::PathBuf;

use serde_json::json;

use super::common::{VerbResult, print};
use draw::units::unit;
use report::results;
use runs::compare::{Compared, Comparison, NumberPair, OF_ONE, by_change, difference, ratio};
use runs::files::RunFiles;
use scenario::error::{Error, Refusal};
use study::file::StudyFile;
use study::measure::ReferenceNumbers;

/// Arguments of `compare`.
#[derive(Debug, clap::Args)]
pub struct CompareArguments {
    /// Run directory.
    run: PathBuf,
    /// Run directory of the reference.
    reference: PathBuf,
    /// Width of the bins over which tractions are averaged, in m (default: the segments of the reference's surface).
    #[arg(long, value_name = "M")]
    bin_m: Option<f64>,
    /// Compare the run's signal or traction OWN with the reference's OTHER; repeatable. Names that differ only in the participant match
    /// without it.
    #[arg(long = "map", value_name = "OWN=OTHER")]
    map: Vec<String>,
    /// Print the measures of this study first: a folder with study.toml, or the file.
    #[arg(long, value_name = "FOLDER")]
    study: Option<PathBuf>,
    /// Print everything that both runs have, not only differences above 0.1 %.
    #[arg(long)]
    all: bool,
    /// Print JSON, with everything that both runs have.
    #[arg(long)]
    json: bool,
}

/// Prints the distances of signals, tractions and results from the reference, and the costs of both runs.
pub fn compare(arguments: &CompareArguments) -> VerbResult {
    let is_length = |bin_m: f64| bin_m > 0.0 && bin_m.is_finite();
    if let Some(bin_m) = arguments.bin_m.filter(|bin_m| !is_length(*bin_m)) {
        let problem = format!("must be a positive length, got {bin_m}");
        return Err(Refusal::argument("--bin-m", problem).into());
    }
    let run = RunFiles::read(&arguments.run)?;
    let mut reference = RunFiles::read(&arguments.reference)?;
    for map in &arguments.map {
        rename(&run, &mut reference, map)?;
    }
    let mut comparison = Comparison::new(&run, &reference, arguments.bin_m);
    let measures = match &arguments.study {
        Some(study) => StudyFile::read(study)?.measure,
        None => Vec::new(),
    };
    let held = ReferenceNumbers::Run(&reference);
    let measured = measures.iter();
    let measured = measured.map(|m| (m.name.clone(), m.deviation(&run, held)));
    let measured = measured.map(|(name, found)| (name, found.map(f64::abs)));
    let measured: BTreeMap<String, Result<f64, String>> = measured.collect();
    if arguments.json {
        let mut json = comparison.json();
        for (name, found) in &measured {
            json["measures"][name] = match found {
                Ok(error) => json!({ "error": error }),
                Err(why) => json!({ "why": why }),
            };
        }
        return print(&json.to_string());
    }
    comparison.results.retain(|name, _| !results::is_old(name));
    let runs = [
        ("run", arguments.run.display(), &run),
        ("reference", arguments.reference.display(), &reference),
    ];
    let heads = runs.map(|(word, path, run)| format!("{word:<10}{path}: {}\n", run.text("status")));
    let errors = measured.iter().map(|(name, found)| match found {
        Ok(error) => format!("error_{name:<36}{error:>12.3e}\n"),
        Err(why) => format!("error_{name:<36}{why}\n"),
    });
    let tables = tables(&comparison, arguments.all);
    print(&(heads.concat() + &errors.collect::<String>() + &tables))
}

/// Renames a column of the reference to the run's name for it.
fn rename(run: &RunFiles, reference: &mut RunFiles, map: &str) -> Result<(), Error> {
    let refuse = |problem: &str| Error::from(Refusal::argument(format!("--map {map}"), problem));
    let (own, other) = map
        .split_once('=')
        .ok_or_else(|| refuse("must be OWN=OTHER, two columns of signals.csv or profile.csv"))?;
    let [unit, of_other] = [own, other].map(unit);
    if unit != of_other {
        return Err(refuse(&format!(
            "compares {own} in {unit:?} with {other} in {of_other:?}: name two columns of the same unit"
        )));
    }
    let mut tables = [Some(&run.signals), run.profile.as_ref()].into_iter();
    if !tables.any(|table| table.is_some_and(|table| table.get(own).is_some())) {
        return Err(refuse("the run has no such column"));
    }
    let tables = [Some(&mut reference.signals), reference.profile.as_mut()];
    let renamed = tables.map(|table| table.is_some_and(|table| table.rename(other, own)));
    if !renamed.contains(&true) {
        return Err(refuse("the reference has no such column"));
    }
    Ok(())
}

/// Relative distance from which a row is printed without `--all`.
const PRINTED: f64 = 1e-3;

fn tables(comparison: &Comparison, all: bool) -> String {
    let mut text = String::new();
    if comparison.same_exchange {
        text.push_str("the exchange is the same, bit for bit\n");
    }
    if !comparison.keys.is_empty() {
        let _ = writeln!(text, "\n{:<60}{:>20}{:>20}", "keys", "run", "reference");
        let shown = |value: &Option<String>| value.clone().unwrap_or("-".into());
        for (key, [reference, run]) in &comparison.keys {
            let [run, reference] = [run, reference].map(shown);
            let _ = writeln!(text, "  {key:<57} {run:>20} {reference:>19}");
        }
    }
    let moved = |compared: &Compared| match compared {
        Ok(d) => d.max > 0.0 && d.l2_rel.or(d.max_rel).is_none_or(|part| part >= PRINTED),
        Err(why) => !OF_ONE.contains(&why.as_str()),
    };
    let [mut signals, mut profile] = [comparison.signals.clone(), comparison.profile.clone()];
    for rows in [&mut signals, &mut profile] {
        rows.retain(|(_, compared)| all || moved(compared));
    }
    let mut results = comparison.results.clone();
    results.retain(|_, pair| all || difference(*pair).is_some_and(|part| part >= PRINTED));
    let rows = |of: &Comparison| of.signals.len() + of.profile.len() + of.results.len();
    let left = rows(comparison) - signals.len() - profile.len() - results.len();
    distances(&mut text, "signals over time", &signals);
    distances(&mut text, "tractions along the surface", &profile);
    pairs(&mut text, ["results", "rel"], &results, difference);
    pairs(&mut text, ["cost", "ratio"], &comparison.cost, ratio);
    if left > 0 {
        let _ = writeln!(
            text,
            "\n{left} signals, tractions and results differ by less than 0.1 %, or only one run has them; --all prints them"
        );
    }
    text.trim_end().to_string()
}

fn distances(text: &mut String, title: &str, rows: &[(String, Compared)]) {
    if rows.is_empty() {
        return;
    }
    let [rms, l2, max, max_rel] = ["rms of d", "L2 rel", "max of d", "max rel"];
    let _ = writeln!(text, "\n{title:<44}{rms:>12}{l2:>12}{max:>12}{max_rel:>12}");
    for (name, compared) in rows {
        let _ = match compared {
            Ok(d) => {
                let [l2, max] = [d.l2_rel, d.max_rel].map(relative);
                writeln!(
                    text,
                    "  {name:<42}{:>12.3e}{l2:>12}{:>12.3e}{max:>12}",
                    d.rms, d.max
                )
            }
            Err(why) => writeln!(text, "  {name:<42}{why}"),
        };
    }
}

/// Numbers of both runs, and the value of `of` for each pair.
fn pairs(
    text: &mut String,
    [title, last]: [&str; 2],
    rows: &BTreeMap<String, NumberPair>,
    of: fn(NumberPair) -> Option<f64>,
) {
    if rows.is_empty() {
        return;
    }
    let [run, reference] = ["run", "reference"];
    let _ = writeln!(text, "\n{title:<44}{run:>16}{reference:>16}{last:>12}");
    let printed = |number: Option<f64>| number.map_or("-".into(), |x| format!("{x:.6e}"));
    for (name, numbers) in by_change(rows) {
        let ([run, reference], last) = (numbers.map(printed), relative(of(numbers)));
        let _ = writeln!(text, "  {name:<42}{run:>16}{reference:>16}{last:>12}");
    }
}

fn relative(part: Option<f64>) -> String {
    part.map_or("-".into(), |part| format!("{part:.3e}"))
}
