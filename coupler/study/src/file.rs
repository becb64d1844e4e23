//! The study file: varied keys, reference, and measures.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::io;
use std::path::{Path, PathBuf};

use scenes::listing::About;
use serde::{Deserialize, Deserializer};

use super::measure::{Measure, percent, plain};
use scenario::error::{Error, Refusal};
use scenario::load::from_toml;
use scenario::overrides::{leaves, number};
use scenes::STUDY;

/// A study file.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StudyFile {
    /// Description of the study for its readers.
    pub about: Option<About>,
    /// The scenario and how it is run.
    pub study: StudyKeys,
    /// The small form, with `--small`.
    #[serde(default)]
    pub small: Small,
    /// The reference of all runs; without one the study shows how the measures depend on the keys.
    #[serde(default)]
    pub reference: Reference,
    /// The keys that are varied.
    pub vary: Vec<Vary>,
    /// The measures: distances from the reference, and values. A study without a reference may omit them.
    #[serde(default)]
    pub measure: Vec<Measure>,
    /// Curves of one measure over another, for curves.svg.
    #[serde(default)]
    pub curve: Vec<CurveConfig>,
}

/// The scene and the mode of the sweep.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StudyKeys {
    /// Name of the study, and of its folder.
    pub name: String,
    /// A scenario beside the study file, or as `run` finds it.
    pub scenario: String,
    /// Overrides of all runs, including the reference.
    #[serde(default)]
    pub set: Vec<String>,
    /// Threads per participant.
    #[serde(default = "one")]
    pub threads: u16,
    /// All combinations, or one key at a time.
    #[serde(default)]
    pub mode: Mode,
    /// Keep exchange logs and checkpoints of finished runs: half a gigabyte for a fine reference.
    #[serde(default)]
    pub keep_logs: bool,
}

fn one() -> u16 {
    1
}

/// Points of a sweep over several keys.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "kebab-case")]
pub enum Mode {
    /// All combinations, the last key changing first.
    #[default]
    Grid,
    /// The values of each key, with the reference's values of the others.
    OneAtATime,
}

/// A study that takes minutes.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Small {
    /// Further overrides of all runs.
    #[serde(default)]
    pub set: Vec<String>,
    /// Largest number of values of a key: the first, the last, and some between.
    pub limit: Option<usize>,
    /// Largest number of values of a key of the scene, the first ones.
    pub scenes: Option<usize>,
}

/// The reference: one of `set`, `run` and `value`, or none of them.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Reference {
    /// The scenario with these overrides.
    pub set: Option<Vec<String>>,
    /// A run directory, beside the study file unless absolute.
    pub run: Option<PathBuf>,
    /// The exact numbers of measures of results, by the measure's name.
    pub value: Option<BTreeMap<String, f64>>,
    /// Number of further references whose grains (or nodes, without grains) are displaced by 1e-12 of their size: their distance from the
    /// reference is noise. By default three with a `set`.
    pub perturb: Option<u64>,
}

impl Reference {
    /// True if a reference is given.
    pub fn is_given(&self) -> bool {
        self.set.is_some() || self.run.is_some() || self.value.is_some()
    }

    /// A floor of noise in words; it needs perturbed references.
    pub fn floor_words(&self, floor: f64) -> String {
        match self.perturbed() {
            0 => "not measured".into(),
            _ => format!("{} %", percent(floor)),
        }
    }

    /// Number of perturbed references.
    pub fn perturbed(&self) -> u64 {
        let own = if self.set.is_some() { PERTURBED } else { 0 };
        self.perturb.unwrap_or(own)
    }
}

/// Default number of perturbed references.
const PERTURBED: u64 = 3;

/// Largest number of runs of a study: planning this many tasks takes seconds.
pub(super) const MOST_RUNS: u64 = 100_000;

/// A key and its values, in one of four ways.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Vary {
    /// The key, as in `--set`; with `case` any name.
    pub key: String,
    /// True for a key of the scene, such as its seed or its load: the reference runs again for each of its values.
    #[serde(default)]
    pub scene: bool,
    /// A note for the reader, shown beside the result.
    #[serde(default)]
    pub note: String,
    /// The values one by one.
    values: Option<Vec<toml::Value>>,
    /// Numbers in a constant ratio.
    log: Option<LogRange>,
    /// Seeds 1 to this number.
    seeds: Option<u64>,
    /// Values that stand for overrides, or for another scenario. The key is then no key of a scenario.
    pub(super) case: Option<Vec<KeyValue>>,
}

/// Numbers in a constant ratio.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LogRange {
    from: f64,
    to: f64,
    count: usize,
}

/// One value of a key; as a case it may stand for several overrides.
#[derive(Clone, Debug, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct KeyValue {
    /// The value, as results.csv shows it; a number if values have an order.
    #[serde(rename = "value", deserialize_with = "shown_value")]
    pub text: String,
    /// Its overrides.
    #[serde(default)]
    pub set: Vec<String>,
    /// Another scenario that it stands for, found like the study's; `study.set`, `small.set` and the reference's overrides do not apply to it.
    pub scenario: Option<String>,
}

/// A table `[[curve]]` of a study file.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CurveConfig {
    /// Name of the measure along x.
    pub x: String,
    /// Name of the measure along y.
    pub y: String,
    /// Divisor of the numbers along x; 1 when absent.
    #[serde(default = "unit")]
    pub x_over: f64,
    /// Divisor of the numbers along y; 1 when absent.
    #[serde(default = "unit")]
    pub y_over: f64,
    /// Words along both axes.
    pub words: [String; 2],
    /// Words for the points of `reference`.
    pub reference_name: Option<String>,
    /// Points (x, y) of a known curve, in units of the axes.
    pub reference: Option<Vec<[f64; 2]>>,
}

fn unit() -> f64 {
    1.0
}

impl CurveConfig {
    /// Refuses a measure that the study does not have, a scale that is no number, and a reference without name or points.
    ///
    /// # Errors
    /// The measure or the key, and its fault.
    pub fn check(&self, measures: &[&str]) -> Result<(), String> {
        let mut names = [&self.x, &self.y].into_iter();
        if let Some(name) = names.find(|name| !measures.contains(&name.as_str())) {
            let known = measures.join(", ");
            return Err(format!(
                "curve: `{name}` is no measure of this study: {known}"
            ));
        }
        let scales = [("x_over", self.x_over), ("y_over", self.y_over)];
        let wrong = scales.into_iter().find(|(_, scale)| !scale.is_normal());
        if let Some((key, scale)) = wrong {
            return Err(format!(
                "curve.{key}: is {scale:?}, and must be a number other than 0"
            ));
        }
        let wrong = |points: &Vec<[f64; 2]>| {
            let mut numbers = points.as_flattened().iter();
            points.len() < 2 || numbers.any(|number| !number.is_finite())
        };
        let known = self.reference.as_ref();
        if known.is_some_and(wrong) || known.is_some() != self.reference_name.is_some() {
            return Err(
                "curve.reference: must be two or more points [x, y] of finite numbers, with curve.reference_name beside them".into(),
            );
        }
        Ok(())
    }
}

fn shown_value<'de, D: Deserializer<'de>>(value: D) -> Result<String, D::Error> {
    toml::Value::deserialize(value).map(|value| shown(&value))
}

impl StudyFile {
    /// The file of a study: the path itself, `study.toml` in that folder, or the file of a name under `scenarios/studies/`. Any other path may
    /// be the name of a shipped study.
    pub fn locate(path: &Path) -> PathBuf {
        let named = Path::new("scenarios/studies").join(path).join(STUDY);
        match path.exists() {
            true if path.is_dir() => path.join(STUDY),
            false if named.is_file() => named,
            _ => path.to_path_buf(),
        }
    }

    /// Reads a study, from its file, from `study.toml` in its folder, or a shipped one by its name.
    ///
    /// # Errors
    /// The file cannot be read, or one of its keys is unknown, missing or invalid.
    pub fn read(path: &Path) -> Result<StudyFile, Error> {
        let path = &StudyFile::locate(path);
        let text = shipped_or_read(path, STUDY).map_err(|error| no_study(path, error))?;
        StudyFile::parse(&text).map_err(|problem| Refusal::file(path, problem).into())
    }

    pub(super) fn parse(text: &str) -> Result<StudyFile, String> {
        let study: StudyFile = from_toml(text)?;
        study.check()?;
        Ok(study)
    }

    fn check(&self) -> Result<(), String> {
        plain("study.name", &self.study.name)?;
        if self.study.threads == 0 {
            return Err("study.threads: must be at least 1".into());
        }
        if self.vary.is_empty() || (self.measure.is_empty() && self.reference.is_given()) {
            return Err("at least one [[vary]] and one [[measure]] are needed".into());
        }
        for (index, vary) in self.vary.iter().enumerate() {
            let about = format!("vary.{index} (`{}`)", vary.key);
            let choices = vary.choices().map_err(|why| format!("{about}: {why}"))?;
            if choices.is_empty() {
                return Err(format!("{about}: has no values"));
            }
            // Rows are grouped by their values: equal values would count a run twice, or mix two runs.
            let numbers = choices.iter().map(|choice| as_number(&choice.text));
            let numbers = Vec::from_iter(numbers);
            twice(&about, numbers.iter().map(String::as_str)).map_err(|why| {
                format!("{why}: give each value once, and each case its own value")
            })?;
        }
        twice("vary", self.vary.iter().map(|vary| vary.key.as_str()))?;
        twice("measure", self.measure.iter().map(|m| m.name.as_str()))?;
        self.check_reference()?;
        for measure in &self.measure {
            let checked = measure.check(self.reference.value.as_ref());
            checked.map_err(|problem| format!("measure `{}`: {problem}", measure.name))?;
        }
        let names = Vec::from_iter(self.measure.iter().map(|m| m.name.as_str()));
        self.curve.iter().try_for_each(|curve| curve.check(&names))
    }

    fn check_reference(&self) -> Result<(), String> {
        let of = &self.reference;
        let given @ [set, run, value] = [of.set.is_some(), of.run.is_some(), of.value.is_some()];
        if given.iter().filter(|given| **given).count() > 1 {
            let why = "reference: give one of `set` (overrides of the scenario), `run` (a run directory) and `value` (exact numbers), or none";
            return Err(why.into());
        }
        if !set && of.perturbed() > 0 {
            return Err(
                "reference.perturb: is only for a reference that is a `set`; remove the key".into(),
            );
        }
        if (run || value) && self.vary.iter().any(|vary| vary.scene) {
            return Err("vary.scene: the reference runs again for each value of such a key, so it must be a `set`".into());
        }
        Ok(())
    }
}

/// Name and folder of the shipped study that this path names; `None` for a path that exists.
pub(super) fn shipped(path: &Path) -> Option<(&str, String)> {
    let name = path.to_str().filter(|_| !path.exists())?;
    Some((name, scenes::study_folder(name)?))
}

/// The text of a file of a study; a shipped study's if no path has that name.
pub(super) fn shipped_or_read(path: &Path, file: &str) -> io::Result<Cow<'static, str>> {
    let text = |(_, folder): (&str, String)| scenes::text(&format!("{folder}/{file}"));
    match shipped(path).and_then(text) {
        Some(text) => Ok(text.into()),
        None => std::fs::read_to_string(path).map(Cow::Owned),
    }
}

/// The error for a study that cannot be read; a missing name may be mistyped.
fn no_study(path: &Path, error: io::Error) -> Error {
    let missing = error.kind() == io::ErrorKind::NotFound;
    let meant = path.to_str().filter(|_| missing);
    let near = meant.and_then(|name| scenes::meant(name, true));
    let problem = match near {
        Some(near) => format!("there is no such study; did you mean `{near}`?"),
        None if missing => {
            "there is no such file, and no study that `thirdbody scenes` lists".into()
        }
        None => return Error::input(path.display())(error),
    };
    Refusal::file(path, problem).into()
}

/// A value with numbers in one form: `1`, `1.0` and `1e0` are the same.
fn as_number(text: &str) -> String {
    text.parse::<f64>()
        .map_or(text.into(), |number| number.to_string())
}

/// Refuses a name that is given twice.
fn twice<'a>(what: &str, names: impl Iterator<Item = &'a str>) -> Result<(), String> {
    let mut names: Vec<&str> = names.collect();
    names.sort_unstable();
    match names.windows(2).find(|pair| pair[0] == pair[1]) {
        Some(pair) => Err(format!("{what}: `{}` is given twice", pair[0])),
        None => Ok(()),
    }
}

impl Vary {
    /// True for seeds: statements about some of them hold for any.
    pub(super) fn is_seed(&self) -> bool {
        self.seeds.is_some() || self.key == "run.seed"
    }

    /// The values, or the reason why they are invalid.
    pub fn choices(&self) -> Result<Vec<KeyValue>, String> {
        let choice = |value: &toml::Value| KeyValue {
            text: shown(value),
            set: vec![format!("{}={value}", self.key)],
            scenario: None,
        };
        let counted = self.seeds.or(self.log.map(|log| log.count as u64));
        if let Some(count) = counted.filter(|count| *count > MOST_RUNS) {
            return Err(format!(
                "{count} values, and a study has at most {MOST_RUNS} runs"
            ));
        }
        let values: Vec<toml::Value> = match (&self.values, &self.log, self.seeds, &self.case) {
            (Some(values), None, None, None) => values.clone(),
            (None, Some(log), None, None) => log.numbers()?.into_iter().map(Into::into).collect(),
            (None, None, Some(count), None) => (1..=count as i64).map(Into::into).collect(),
            (None, None, None, Some(cases)) => return Ok(cases.clone()),
            _ => return Err("needs exactly one of `values`, `log`, `seeds` and `case`".into()),
        };
        Ok(values.iter().map(choice).collect())
    }
}

/// A value as a cell of a table shows it.
pub fn shown(value: &toml::Value) -> String {
    match value {
        toml::Value::String(text) => text.clone(),
        toml::Value::Float(number) if *number != 0.0 && !(1e-3..1e6).contains(&number.abs()) => {
            format!("{number:e}")
        }
        toml::Value::Float(number) => format!("{number}"),
        other => other.to_string(),
    }
}

/// The values of a table, each as a table of the study shows it, by their keys.
pub(super) fn shown_values(table: &toml::Table) -> BTreeMap<String, String> {
    let values = leaves(table).into_iter();
    values.map(|(key, value)| (key, shown(value))).collect()
}

impl LogRange {
    fn numbers(&self) -> Result<Vec<f64>, String> {
        let LogRange { from, to, count } = *self;
        let positive = |x: f64| x > 0.0 && x.is_finite();
        if !(positive(from) && positive(to) && count >= 2) {
            return Err(format!(
                "`log` needs positive ends and a count of 2 or more, got {from}, {to} and {count}"
            ));
        }
        let last = (count - 1) as f64;
        let number = |k: usize| match k {
            0 => from,
            k if k + 1 == count => to,
            k => from * (to / from).powf(k as f64 / last),
        };
        Ok((0..count).map(number).collect())
    }
}

/// A positive number.
pub(super) fn positive(value: &toml::Value) -> Option<f64> {
    number(value).filter(|number| *number > 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    const STUDY: &str = r#"
[study]
name = "steps"
scenario = "quick"
[reference]
set = ["run.seed=2"]
[[vary]]
key = "a"
log = { from = 1e-6, to = 1e-4, count = 3 }
[[measure]]
name = "height"
of = "signals.wheel_y_m"
norm = "at"
at_s = 1e-3
"#;

    fn choices(vary: &str) -> Vec<KeyValue> {
        let vary: Vary = toml::from_str(vary).expect("a varied key");
        vary.choices().expect("it has values")
    }

    #[test]
    fn a_range_in_a_constant_ratio_keeps_its_ends() {
        let study = StudyFile::parse(STUDY).expect("a study");
        let values = study.vary[0].choices().expect("a range");
        assert_eq!([&values[0].text, &values[2].text], ["1e-6", "1e-4"]);
        let middle: f64 = values[1].text.parse().expect("a number");
        assert!((middle - 1e-5).abs() < 1e-19);
        assert_eq!(study.reference.perturbed(), 3);
    }

    #[test]
    fn values_seeds_and_cases_have_their_overrides() {
        let words = choices("key = \"a.kind\"\nvalues = [\"pcg\", 1, 2.5e-9]");
        let found = words.iter().map(|c| (c.text.as_str(), c.set[0].as_str()));
        let expected = [
            ("pcg", "a.kind=\"pcg\""),
            ("1", "a.kind=1"),
            ("2.5e-9", "a.kind=0.0000000025"),
        ];
        assert!(found.eq(expected), "{words:?}");
        let seeds = choices("key = \"run.seed\"\nseeds = 2");
        assert_eq!(seeds[1].set, ["run.seed=2"]);
        let cases = choices("key = \"mesh\"\ncase = [{ value = 4e-4, set = [\"b=1\", \"c=2\"] }]");
        assert_eq!(
            (cases[0].text.as_str(), &cases[0].set[..]),
            ("4e-4", &["b=1".into(), "c=2".into()][..])
        );
    }

    #[test]
    fn errors_name_the_invalid_key() {
        let refused = |from: &str, to: &str| {
            StudyFile::parse(&STUDY.replace(from, to)).expect_err("it makes no sense")
        };
        assert!(refused("scenario =", "scene =").contains("scene"));
        assert!(refused("count = 3", "count = 1").contains("vary.0 (`a`)"));
        assert!(refused("at_s = 1e-3", "").contains("measure `height`"));
        assert!(refused("signals.", "signal.").contains("signal.wheel_y_m"));
        assert!(refused("\"steps\"", "\"a/b\"").contains("a/b"));
        let exact = refused("set = [\"run.seed=2\"]", "value = { height = 1.0 }");
        assert!(exact.contains("results only"), "{exact}");
        assert!(refused("log = {", "values = [1]\nlog = {").contains("exactly one"));
        assert!(refused("[reference]", "[reference]\nrun = \"a\"").contains("one of `set`"));
        let perturbed = refused("set = [\"run.seed=2\"]", "run = \"a\"\nperturb = 1");
        assert!(perturbed.contains("reference.perturb"), "{perturbed}");
        let scene = refused(
            "set = [\"run.seed=2\"]\n[[vary]]",
            "run = \"a\"\n[[vary]]\nscene = true",
        );
        assert!(scene.contains("vary.scene"), "{scene}");
        let again = STUDY.replace(
            "[[measure]]",
            "[[vary]]\nkey = \"a\"\nvalues = [1]\n[[measure]]",
        );
        assert!(
            StudyFile::parse(&again)
                .expect_err("twice")
                .contains("`a` is given twice")
        );
    }

    /// A repeated value would count a run twice in a mean; two cases of one value would be a mean of both.
    #[test]
    fn a_value_is_given_once() {
        let refused = |values: &str| {
            let study = STUDY.replace("log = { from = 1e-6, to = 1e-4, count = 3 }", values);
            StudyFile::parse(&study).err().unwrap_or_default()
        };
        for values in [
            "values = [1, 1, 1, 2, 2, 2]",
            "values = [0.1, 0.10]",
            "values = [1, 1.0]",
            "values = [1000000, 1e6]",
            "log = { from = 1.0, to = 1.0, count = 2 }",
            "case = [{ value = 1, set = [\"b=1000\"] }, { value = 1, set = [\"b=9000\"] }]",
        ] {
            let why = refused(values);
            assert!(
                why.contains("vary.0 (`a`): `") && why.contains("is given twice"),
                "{values}: {why}"
            );
        }
        assert_eq!(refused("values = [1, 2, \"x\", true]"), "");
    }
}
