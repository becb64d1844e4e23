//! `expected.toml`: the expected results of a scene, and their sources.

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
    /// Folder of the scenario, relative to this file; by default the file's own folder.
    pub scene: Option<PathBuf>,
    /// Text for the page of the suite, above the cases; words between backticks become code.
    #[serde(default)]
    pub text: String,
    /// Runs of the scene, each with its expectations.
    pub case: Vec<SuiteCase>,
}

/// One run, or one run per seed.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SuiteCase {
    /// Name that states the claim.
    pub name: String,
    /// Author, year, equation, or table of the numbers.
    pub source: String,
    /// Folder of its scenario, if it differs from the file's.
    pub scene: Option<PathBuf>,
    /// True for a long case, which runs only with `--full`.
    #[serde(default)]
    pub full: bool,
    /// Overrides of the scene, as with `--set`.
    #[serde(default)]
    pub set: Vec<String>,
    /// Seeds of the runs; the scene's seed if empty. All expectations must hold for each seed.
    #[serde(default)]
    pub seeds: Vec<u64>,
    /// Overrides of a second run, in addition to the first: a finer step or mesh, another element or solver. Numbers without an expected
    /// value, or with a norm, are compared with this run.
    pub reference: Option<Vec<String>>,
    /// Folder of the scenario of that run, if it differs. The run then has only the overrides in `reference`, and in a case with `first` also
    /// the overrides of its variation and the seed.
    pub reference_scene: Option<PathBuf>,
    /// Runs that come first, in this order: later runs and the case take numbers from them.
    #[serde(default)]
    pub first: Vec<First>,
    /// Keys whose values come from the first runs.
    #[serde(default)]
    pub take: Vec<Take>,
    /// Variations: the case runs once with each; if empty, once without.
    #[serde(default)]
    pub vary: Vec<Variation>,
    /// Expected exit code of the run.
    #[serde(default)]
    pub exit_code: i32,
    /// Words that the message must contain.
    #[serde(default)]
    pub says: Vec<String>,
    /// Codes of the expected warnings, each once, in any order.
    #[serde(default)]
    pub warns: Vec<String>,
    /// Codes of warnings that depend on chance: they are allowed, and reported with the numbers.
    #[serde(default)]
    pub may_warn: Vec<String>,
    /// Text about the case, for the page.
    #[serde(default)]
    pub text: String,
    /// File names of pictures from the report of its first run, for the page.
    #[serde(default)]
    pub pictures: Vec<String>,
    /// Expected numbers.
    #[serde(default)]
    pub number: Vec<Number>,
}

/// A run that comes before its case.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct First {
    /// Name by which other runs take numbers from it.
    pub name: String,
    /// Its scenario, relative to the file; if absent, the case's scenario with its overrides and variation.
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
    /// Factor of the product, in the remaining unit; 1 if absent.
    pub factor: Option<f64>,
    /// Exponents by name of the run and path of the number: `rail.results.p0_pa`.
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
    /// Path of the number: in summary.json, `cost.<wall_s | cpu_s | peak_rss_bytes>` of all processes,
    /// `signals.<column>.<last | max | min | mean | t_max | t_min>`, where `<a>+<b>` is the sum of two columns, or, with `norm`,
    /// `profile.<column>` or `signals.<column>`.
    pub path: String,
    /// The quantity in words; the path if absent.
    pub of: Option<String>,
    /// Expected value; if absent, the value of the case's reference.
    pub expected: Option<f64>,
    /// Allowed distance relative to the value.
    pub tolerance_rel: Option<f64>,
    /// Allowed distance.
    pub tolerance_abs: Option<f64>,
    /// Instead of a distance, smallest and largest ratio to the value, for a trend that was published without numbers.
    pub ratio: Option<[f64; 2]>,
    /// The number is the relative distance of a traction or signal from the reference, in this norm.
    pub norm: Option<Norm>,
    /// Width of the bins over which the traction is averaged (m).
    pub bin_m: Option<f64>,
    /// Published value, if another value is expected here.
    pub published: Option<f64>,
    /// Predicted or calibrated, for a number with a published value.
    pub basis: Option<Basis>,
    /// True for a number that is reported but not judged: a cost, or a number that depends too much on chance.
    #[serde(default)]
    pub reported: bool,
}

/// Kind of agreement with a published number.
#[derive(Clone, Copy, Debug, Deserialize, Serialize, PartialEq, Eq)]
#[serde(rename_all = "lowercase")]
pub enum Basis {
    /// No parameter was chosen for it.
    Predicted,
    /// A parameter that the publication does not give was chosen so that this number, or a number that it depends on, agrees.
    Calibrated,
}

impl fmt::Display for Basis {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        self.serialize(formatter)
    }
}

impl Number {
    /// True if a number is close enough to the expected one.
    pub fn holds(&self, ours: f64, expected: f64) -> bool {
        if let Some([least, largest]) = self.ratio {
            return (least..=largest).contains(&(ours / expected));
        }
        (ours - expected).abs() <= self.allowed(expected)
    }

    /// Allowed distance from this value, in its unit.
    pub(super) fn allowed(&self, expected: f64) -> f64 {
        let relative = self.tolerance_rel.unwrap_or(0.0) * expected.abs();
        relative.max(self.tolerance_abs.unwrap_or(0.0))
    }

    /// Its value in a run; with a norm, the distance from the reference.
    pub(super) fn value(&self, run: &RunFiles, reference: Option<&RunFiles>) -> Option<f64> {
        if let Some(norm) = self.norm {
            let measure = Measure {
                norm,
                bin_m: self.bin_m,
                ..Measure::new("", self.path.clone())
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
        // True for a number that is compared with a run.
        let is_open = |of: &Number| of.norm.is_some() || of.expected.is_none() && !of.reported;
        let open = case.number.iter().any(is_open);
        let problem = match &case.reference {
            None if case.reference_scene.is_some() => {
                "reference_scene without reference; write reference = [] if it has no overrides"
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

/// The case of each variation; its overrides also apply to a reference with its own scenario.
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
