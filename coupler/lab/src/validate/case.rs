//! `expected.toml`: what must come out of a scene, and who says so.

use std::path::{Path, PathBuf};

use serde::Deserialize;

use coordinator::error::{Error, Refusal};
use coordinator::scenario::load::from_toml;

/// The whole file.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Expected {
    /// Folder of the scenario, relative to this file; by default the file's own. Scenes that are run elsewhere need no copy.
    pub scene: Option<PathBuf>,
    /// Runs of the scene, each with its expectations.
    pub case: Vec<SuiteCase>,
}

/// One run.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SuiteCase {
    /// Name that says what it shows.
    pub name: String,
    /// Author, year, equation, or the table that the numbers are from.
    pub source: String,
    /// True for a case that takes long: it is run with `--full` only.
    #[serde(default)]
    pub full: bool,
    /// Overrides of the scene, as after `--set`.
    #[serde(default)]
    pub set: Vec<String>,
    /// Overrides of a second run, after those of the first, which gives the numbers that have none to expect: a finer step or
    /// mesh, another element or solver.
    pub reference: Option<Vec<String>>,
    /// Exit code that the run must end with.
    #[serde(default)]
    pub exit_code: i32,
    /// Words that the message must hold.
    #[serde(default)]
    pub says: Vec<String>,
    /// Codes of the warnings that the run must end with, each once, in any order.
    #[serde(default)]
    pub warns: Vec<String>,
    /// Numbers that must come out.
    #[serde(default)]
    pub number: Vec<Number>,
}

/// One number.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Number {
    /// Where the number is found: a path in summary.json, or `signals.<column>.<last | max | min | mean | t_max | t_min>`, where `<a>+<b>` is
    /// the sum of two columns.
    pub path: String,
    /// Value that it must have; that of the case's reference if absent.
    pub expected: Option<f64>,
    /// Distance allowed, over the value.
    pub tolerance_rel: Option<f64>,
    /// Distance allowed.
    pub tolerance_abs: Option<f64>,
    /// In place of a distance, least and largest ratio to the value: of a trend that was published without numbers.
    pub ratio: Option<[f64; 2]>,
}

impl Number {
    /// Tells if a number that came out is near enough to what is expected.
    pub fn holds(&self, ours: f64, expected: f64) -> bool {
        if let Some([least, largest]) = self.ratio {
            return (least..=largest).contains(&(ours / expected));
        }
        let relative = self.tolerance_rel.unwrap_or(0.0) * expected.abs();
        (ours - expected).abs() <= relative.max(self.tolerance_abs.unwrap_or(0.0))
    }
}

/// Reads `expected.toml`.
pub fn read(path: &Path) -> Result<Expected, Error> {
    let text = std::fs::read_to_string(path).map_err(Error::input(path.display()))?;
    let refuse = |why: String| Error::from(Refusal::file(path, why));
    let expected: Expected = from_toml(&text).map_err(refuse)?;
    for case in &expected.case {
        let open = case.number.iter().any(|number| number.expected.is_none());
        if open != case.reference.is_some() {
            let name = &case.name;
            let problem =
                format!("case `{name}`: a reference goes with numbers without `expected`");
            return Err(refuse(problem));
        }
    }
    Ok(expected)
}
