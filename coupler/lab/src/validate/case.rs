//! `expected.toml`: what must come out of a scene, and who says so.

use std::collections::BTreeMap;
use std::fmt;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use runs::files::RunFiles;
use scenario::error::{Error, Refusal};
use scenario::load::from_toml;
use study::measure::{Measure, Norm, ReferenceNumbers};

use super::signals::of_signals;

/// The whole file.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Expected {
    /// Folder of the scenario, relative to this file; by default the file's own. Scenes that are run elsewhere need no copy.
    pub scene: Option<PathBuf>,
    /// Text for the page of the suite, above the cases; words between backticks are set as code.
    #[serde(default)]
    pub text: String,
    /// Runs of the scene, each with its expectations.
    pub case: Vec<SuiteCase>,
}

/// One run, or one for each of some seeds.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SuiteCase {
    /// Name that says what it shows.
    pub name: String,
    /// Author, year, equation, or the table that the numbers are from.
    pub source: String,
    /// Folder of its scenario, where it is not that of the file.
    pub scene: Option<PathBuf>,
    /// True for a case that takes long: it is run with `--full` only.
    #[serde(default)]
    pub full: bool,
    /// Overrides of the scene, as after `--set`.
    #[serde(default)]
    pub set: Vec<String>,
    /// Seeds with each of which the case is run; that of the scene if empty. What must hold must hold for each.
    #[serde(default)]
    pub seeds: Vec<u64>,
    /// Overrides of a second run, after those of the first, that numbers are held against which have none to expect, or a norm: a finer
    /// step or mesh, another element or solver.
    pub reference: Option<Vec<String>>,
    /// Folder of the scenario of that run, where it is another one: of the overrides it has those of `reference`, and of a case with `first`
    /// those of its variation and the seed.
    pub reference_scene: Option<PathBuf>,
    /// Runs that come first, in this order: what they give is taken by those after them and by the case.
    #[serde(default)]
    pub first: Vec<First>,
    /// Keys whose values come from the runs that come first.
    #[serde(default)]
    pub take: Vec<Take>,
    /// Variations: the case is run once with each. One case without, if empty.
    #[serde(default)]
    pub vary: Vec<Variation>,
    /// Exit code that the run must end with.
    #[serde(default)]
    pub exit_code: i32,
    /// Words that the message must hold.
    #[serde(default)]
    pub says: Vec<String>,
    /// Codes of the warnings that the run must end with, each once, in any order.
    #[serde(default)]
    pub warns: Vec<String>,
    /// Codes of warnings that a run may end with, as chance has it: with these numbers they are told.
    #[serde(default)]
    pub may_warn: Vec<String>,
    /// Text about the case, for the page.
    #[serde(default)]
    pub text: String,
    /// Pictures of the report of its first run that the page shows, by their file names.
    #[serde(default)]
    pub pictures: Vec<String>,
    /// Numbers that must come out.
    #[serde(default)]
    pub number: Vec<Number>,
}

/// A run that comes before its case.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct First {
    /// Name by which others take from it.
    pub name: String,
    /// Its scenario, relative to the file; that of the case, with its overrides and variation, if absent.
    pub scene: Option<PathBuf>,
    /// Its own overrides.
    #[serde(default)]
    pub set: Vec<String>,
    /// Keys whose values come from runs before it.
    #[serde(default)]
    pub take: Vec<Take>,
}

/// A key whose value is a product of powers of numbers of earlier runs.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Take {
    /// The key that is set.
    pub key: String,
    /// Factor before the product, in the unit that is left over; 1 if absent.
    pub factor: Option<f64>,
    /// Exponents, by name of the run and path of the number: `rail.results.p0_pa`.
    pub of: BTreeMap<String, f64>,
}

/// A variation of a case.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Variation {
    /// The difference, in words.
    pub name: String,
    /// Overrides.
    pub set: Vec<String>,
}

impl Take {
    /// The override `KEY=VALUE`; the error is the number that a run lacks.
    pub(super) fn of_runs(&self, runs: &[(String, RunFiles)]) -> Result<String, String> {
        let mut value = self.factor.unwrap_or(1.0);
        for (path, power) in &self.of {
            let (name, number) = path.split_once('.').unwrap_or((path, ""));
            let run = runs.iter().find(|(of, _)| of == name);
            let number = run.and_then(|(_, run)| run.number(number));
            value *= number.ok_or_else(|| path.clone())?.powf(*power);
        }
        Ok(format!("{}={value:e}", self.key))
    }
}

/// One number.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Number {
    /// Place of the number: a path in summary.json, `cost.<wall_s | cpu_s | peak_rss_bytes>` of all processes,
    /// `signals.<column>.<last | max | min | mean | t_max | t_min>`, where `<a>+<b>` is the sum of two columns, or, with `norm`,
    /// `profile.<column>` or `signals.<column>`.
    pub path: String,
    /// The quantity in words; the path if absent.
    pub of: Option<String>,
    /// Value that it must have; that of the case's reference if absent.
    pub expected: Option<f64>,
    /// Distance allowed, over the value.
    pub tolerance_rel: Option<f64>,
    /// Distance allowed.
    pub tolerance_abs: Option<f64>,
    /// In place of a distance, least and largest ratio to the value: of a trend that was published without numbers.
    pub ratio: Option<[f64; 2]>,
    /// The number is the distance of a traction or signal from that of the reference, relative to it, in this norm.
    pub norm: Option<Norm>,
    /// Width of the bins over which the traction is a mean (m).
    pub bin_m: Option<f64>,
    /// Published value, where another one must come out here.
    pub published: Option<f64>,
    /// Predicted or calibrated, of a number with a published value.
    pub basis: Option<Basis>,
    /// True for a number that is told and not judged: a cost, or one that chance has too much of.
    #[serde(default)]
    pub told: bool,
}

/// Agreement with a published number is one of these two.
#[derive(Clone, Copy, Debug, Deserialize, Serialize, PartialEq, Eq)]
#[serde(rename_all = "lowercase")]
pub enum Basis {
    /// Nothing was chosen for it.
    Predicted,
    /// A parameter that the publication does not give was chosen so that it, or one that it hangs on, comes out.
    Calibrated,
}

impl fmt::Display for Basis {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        self.serialize(formatter)
    }
}

impl Number {
    /// Tells if a number that came out is near enough to what is expected.
    pub fn holds(&self, ours: f64, expected: f64) -> bool {
        if let Some([least, largest]) = self.ratio {
            return (least..=largest).contains(&(ours / expected));
        }
        (ours - expected).abs() <= self.allowed(expected)
    }

    /// Distance from this value that is allowed, in its unit.
    pub(super) fn allowed(&self, expected: f64) -> f64 {
        let relative = self.tolerance_rel.unwrap_or(0.0) * expected.abs();
        relative.max(self.tolerance_abs.unwrap_or(0.0))
    }

    /// Its value in a run; a norm is of the distance from the reference.
    pub(super) fn value(&self, run: &RunFiles, reference: Option<&RunFiles>) -> Option<f64> {
        if let Some(norm) = self.norm {
            let measure = Measure {
                name: String::new(),
                of: self.path.clone(),
                norm,
                at_s: None,
                bin_m: self.bin_m,
            };
            let held = ReferenceNumbers::Run(reference?);
            return measure.deviation(run, held).ok();
        }
        match self.path.split_once('.') {
            Some(("signals", path)) => of_signals(&run.signals, path),
            Some(("cost", name)) => run.cost().get(name).copied(),
            _ => run.number(&self.path),
        }
    }
}

/// Reads `expected.toml`.
pub fn read(path: &Path) -> Result<Expected, Error> {
    let text = std::fs::read_to_string(path).map_err(Error::input(path.display()))?;
    let refuse = |why: String| Error::from(Refusal::file(path, why));
    let mut expected: Expected = from_toml(&text).map_err(refuse)?;
    for case in &expected.case {
        // True of what is held against a run.
        let is_open = |of: &Number| of.norm.is_some() || of.expected.is_none() && !of.told;
        let open = case.number.iter().any(is_open);
        let problem = match &case.reference {
            None if case.reference_scene.is_some() => {
                "reference_scene without reference; write reference = [] where it has no overrides"
            }
            reference if open != reference.is_some() => {
                "a reference goes with numbers without `expected`, or with a norm"
            }
            _ => continue,
        };
        return Err(refuse(format!("case `{}`: {problem}", case.name)));
    }
    expected.case = expected.case.into_iter().flat_map(varied).collect();
    Ok(expected)
}

/// The case of each variation; its overrides also go to a reference that has a scenario of its own.
fn varied(case: SuiteCase) -> Vec<SuiteCase> {
    if case.vary.is_empty() {
        return vec![case];
    }
    let variation = |of: &Variation| {
        let mut case = case.clone();
        case.name = format!("{}: {}", case.name, of.name);
        case.set.extend(of.set.clone());
        if let (Some(_), Some(reference)) = (&case.reference_scene, &mut case.reference) {
            reference.extend(of.set.clone());
        }
        case
    };
    case.vary.iter().map(variation).collect()
}
