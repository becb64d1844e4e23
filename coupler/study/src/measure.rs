//! Measures: a run as one number, and its distance from the reference.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use runs::curve::Curve;
use runs::files::RunFiles;
use runs::steps::Steps;
use runs::table::Table;

/// A measure of a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Measure {
    /// Name in the columns `value_<name>` and, with a reference, `error_<name>`.
    pub name: String,
    /// `signals.NAME`, `profile.NAME` or `results.NAME`; `profile.traction_pa` is the vector of pressure and shear.
    pub of: String,
    /// The norm; `at` for a result.
    #[serde(default)]
    pub norm: Norm,
    /// Instant of a signal with the norm `at` (s).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub at_s: Option<f64>,
    /// Width of the bins over which a traction is averaged (m).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bin_m: Option<f64>,
}

/// The name of the vector of `pressure_pa` and `shear_pa` in a profile.
pub const TRACTION: &str = "traction_pa";

/// Norm of numbers; distances are relative to the reference's norm.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "lowercase")]
pub enum Norm {
    /// Root of the mean square.
    L2,
    /// Largest.
    Max,
    /// At an instant, or of a result.
    #[default]
    At,
}

/// Numbers that a run is compared with.
#[derive(Clone, Copy, Debug)]
pub enum ReferenceNumbers<'a> {
    /// Numbers of another run.
    Run(&'a RunFiles),
    /// Exact numbers, by the measure's name.
    Values(&'a BTreeMap<String, f64>),
    /// The reference is missing.
    Nothing,
}

/// Refuses a name that is no plain file name and no name of a column.
pub fn plain(key: &str, name: &str) -> Result<(), String> {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_.".contains(c);
    if name.is_empty() || name.starts_with('.') || !name.chars().all(plain) {
        return Err(format!(
            "{key}: must be letters, digits, `-`, `_` and `.`, got `{name}`"
        ));
    }
    Ok(())
}

/// A part of the reference in per cent, with two digits.
pub fn percent(part: f64) -> String {
    let percent = 100.0 * part;
    if percent == 0.0 {
        return "0".into();
    }
    let digits = 1 - percent.abs().log10().floor() as i32;
    if (0..=4).contains(&digits) {
        return format!("{percent:.0$}", digits as usize);
    }
    if digits < 0 {
        return format!("{percent:.0}");
    }
    format!("{percent:.1e}")
}

/// Errors in words, each with the name of its measure.
pub fn named_errors(measures: &[Measure], errors: &[f64]) -> String {
    let all = measures.iter().zip(errors);
    let all = all.map(|(measure, error)| format!("{} {} %", measure.name, percent(*error)));
    Vec::from_iter(all).join(", ")
}

impl Measure {
    /// A measure with the usual norm: L2 for a signal or a traction, the number itself for a result.
    pub fn new(name: &str, of: String) -> Measure {
        let is_result = of.starts_with("results.");
        Measure {
            name: name.into(),
            norm: if is_result { Norm::At } else { Norm::L2 },
            of,
            at_s: None,
            bin_m: None,
        }
    }

    /// The table, and the name in it.
    pub fn table(&self) -> Option<(&str, &str)> {
        let (table, name) = self.of.split_once('.')?;
        let known = ["signals", "profile", "results"].contains(&table);
        (known && !name.is_empty()).then_some((table, name))
    }

    /// The new name of a result that is measured under an old name, which the next release drops.
    pub fn renamed(&self) -> Option<&'static str> {
        match self.of.as_str() {
            "results.friction_coefficient" => Some("results.traction_ratio_mean"),
            "results.cycle_friction_coefficient" => Some("results.cycle_traction_ratio"),
            "results.all_cycles_friction_coefficient" => Some("results.all_cycles_traction_ratio"),
            _ => None,
        }
    }

    /// Refuses a norm that does not fit, and a result without an exact value if the reference consists of exact values.
    pub(super) fn check(&self, exact: Option<&BTreeMap<String, f64>>) -> Result<(), String> {
        plain("name", &self.name)?;
        let unknown =
            |of| format!("`of` must be signals.NAME, profile.NAME or results.NAME, got `{of}`");
        let (table, _) = self.table().ok_or_else(|| unknown(&self.of))?;
        let fits = match table {
            "results" => self.norm == Norm::At && self.at_s.is_none(),
            "signals" => (self.norm == Norm::At) == self.at_s.is_some(),
            _ => self.norm != Norm::At && self.at_s.is_none(),
        };
        if !fits {
            let why = "a result has the norm `at`, a signal `l2`, `max` or `at` with `at_s`, a traction `l2` or `max`";
            return Err(why.into());
        }
        let is_width = |bin: f64| table == "profile" && bin > 0.0 && bin.is_finite();
        if !self.bin_m.is_none_or(is_width) {
            return Err("`bin_m` is the positive width of the bins of a traction".into());
        }
        match exact {
            Some(_) if table != "results" => Err("a reference by value is for results only".into()),
            Some(exact) if !exact.contains_key(&self.name) => {
                Err("reference.value has no number of this name".into())
            }
            _ => Ok(()),
        }
    }

    /// True for a measure of a result.
    pub fn is_result(&self) -> bool {
        self.table().is_some_and(|(table, _)| table == "results")
    }

    /// The value in a run: the result, the signal at its instant, or the size of a signal or traction, which is its root mean square or its
    /// largest absolute number. Or the reason why it is missing.
    pub fn number(&self, run: &RunFiles) -> Result<f64, String> {
        let (table, name) = self.table().ok_or("`of` names no table")?;
        let of_curve = |own: Curve| {
            let zeros = vec![0.0; own.y.len()];
            own.distance(&Curve { y: &zeros, ..own })
        };
        let size = match (table, self.at_s) {
            ("results", _) => return result(run, name),
            ("signals", Some(at)) => {
                let own = column(&run.signals, "t_s", name)?;
                return own.at(at).ok_or(format!("nothing at {at:e} s"));
            }
            ("signals", None) => of_curve(column(&run.signals, "t_s", name)?)?,
            _ => {
                let own = steps(run, name)?;
                own.distance(&own.zero(), self.bin_m)?
            }
        };
        Ok(match self.norm {
            Norm::Max => size.max,
            Norm::L2 | Norm::At => size.rms,
        })
    }

    /// The distance of a run from the reference, relative to the reference; or the reason why it is missing. With the norm `at` it has the
    /// sign of the deviation.
    pub fn deviation(&self, run: &RunFiles, held: ReferenceNumbers) -> Result<f64, String> {
        let (table, name) = self.table().ok_or("`of` names no table")?;
        let reference = match held {
            ReferenceNumbers::Nothing => return Err("the reference has not completed".into()),
            ReferenceNumbers::Values(values) => {
                let exact = *values.get(&self.name).ok_or("no exact value")?;
                return relative(result(run, name)?, exact);
            }
            ReferenceNumbers::Run(reference) => reference,
        };
        let found = match (table, self.at_s) {
            ("results", _) | (_, Some(_)) => {
                return relative(self.number(run)?, self.number(reference)?);
            }
            ("signals", None) => {
                let [own, other] = [run, reference].map(|run| column(&run.signals, "t_s", name));
                own?.distance(&other?)?
            }
            _ => steps(run, name)?.distance(&steps(reference, name)?, self.bin_m)?,
        };
        let relative = match self.norm {
            Norm::Max => found.max_rel,
            Norm::L2 | Norm::At => found.l2_rel,
        };
        relative.ok_or("the reference is 0 throughout".into())
    }
}

fn steps(run: &RunFiles, name: &str) -> Result<Steps, String> {
    let table = run.profile.as_ref().ok_or("there is no profile.csv")?;
    let column = |name| column(table, "x_m", name);
    let steps = if name == TRACTION {
        let [pressure, shear] = [column("pressure_pa")?, column("shear_pa")?];
        let vectors = pressure.y.iter().zip(shear.y);
        Steps::of_vectors(pressure.x, vectors.map(|(p, t)| [*p, *t]))
    } else {
        let curve = column(name)?;
        Steps::around(curve.x, curve.y)
    };
    steps.ok_or("there are no numbers".into())
}

/// A column over the column `along`. A signal has its whole name, or its name without the participant if only one participant has it: a
/// run of one solver has no names before its signals.
fn column<'a>(table: &'a Table, along: &str, name: &str) -> Result<Curve<'a>, String> {
    let missing = || format!("no column `{name}`");
    let own = table.name_of(name, table).ok_or_else(missing)?;
    Ok(Curve {
        x: table.get(along).ok_or_else(missing)?,
        y: table.get(own).ok_or_else(missing)?,
    })
}

fn result(run: &RunFiles, name: &str) -> Result<f64, String> {
    let found = run.results().get(name).copied();
    found.ok_or(format!("no result `{name}`"))
}

/// (a - b) / |b|.
fn relative(number: f64, reference: f64) -> Result<f64, String> {
    let error = (number - reference) / reference.abs();
    if error.is_finite() {
        return Ok(error);
    }
    Err(format!(
        "{number:e} has no relative distance from {reference:e}"
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn finished(signals: &str, result: f64) -> RunFiles {
        RunFiles {
            summary: serde_json::json!({ "results": { "depth_m": result } }),
            signals: Table::parse(signals).expect("a table"),
            profile: Some(Table::parse("x_m,p_pa\n0,1\n1,1\n").expect("a table")),
            ..RunFiles::default()
        }
    }

    fn measure(of: &str, norm: &str, more: &str) -> Measure {
        let text = format!("name = \"m\"\nof = \"{of}\"\nnorm = \"{norm}\"\n{more}");
        toml::from_str(&text).expect("a measure")
    }

    #[test]
    fn a_signal_of_one_participant_is_found_without_its_name() {
        let of = |text: &str, name: &str| {
            let table = Table::parse(text).expect("a table");
            column(&table, "t_s", name).map(|curve| curve.y[0])
        };
        assert_eq!(
            of("t_s,wheel_y_m,a.wheel_y_m\n0,1,2\n", "wheel_y_m"),
            Ok(1.0)
        );
        assert_eq!(of("t_s,a.wheel_y_m\n0,2\n", "wheel_y_m"), Ok(2.0));
        assert_eq!(
            of("t_s,a.y_m,b.y_m\n0,1,2\n", "y_m"),
            Err("no column `y_m`".into())
        );
        assert_eq!(
            of("t_s,a.xy_m\n0,1\n", "y_m"),
            Err("no column `y_m`".into())
        );
    }

    /// y = 1 + t against 2 on [0, 1]: d^2 integrates to 1/3, the reference to 4.
    #[test]
    fn errors_follow_their_norms() {
        let run = finished("t_s,y\n0,1\n1,2\n", 1.5);
        let reference = finished("t_s,y\n0,2\n1,2\n", 1.0);
        let of = |measure: &Measure| measure.deviation(&run, ReferenceNumbers::Run(&reference));
        let l2 = of(&measure("signals.y", "l2", "")).expect("it has one");
        assert!((l2 - (1f64 / 12.0).sqrt()).abs() < 1e-15);
        assert_eq!(of(&measure("signals.y", "max", "")), Ok(0.5));
        assert_eq!(of(&measure("signals.y", "at", "at_s = 0.5")), Ok(-0.25));
        assert_eq!(of(&measure("results.depth_m", "at", "")), Ok(0.5));
        assert_eq!(of(&measure("profile.p_pa", "l2", "")), Ok(0.0));
        let vector = |shear: &str| RunFiles {
            profile: Table::parse(&format!(
                "x_m,pressure_pa,shear_pa\n0,4,{shear}\n1,4,{shear}\n"
            ))
            .ok(),
            ..RunFiles::default()
        };
        let traction = measure("profile.traction_pa", "l2", "");
        let (sheared, reference_vector) = (vector("0"), vector("3"));
        let found = traction.deviation(&sheared, ReferenceNumbers::Run(&reference_vector));
        assert_eq!(
            found,
            Ok(0.6),
            "3 Pa of shear are missing in a vector of 5 Pa"
        );
        let pressure = measure("profile.pressure_pa", "l2", "");
        let found = pressure.deviation(&sheared, ReferenceNumbers::Run(&reference_vector));
        assert_eq!(found, Ok(0.0));
        let missing = of(&measure("signals.z", "l2", ""));
        assert_eq!(missing, Err("no column `z`".into()));
        let exact = BTreeMap::from([("m".to_string(), 3.0)]);
        let closed =
            measure("results.depth_m", "at", "").deviation(&run, ReferenceNumbers::Values(&exact));
        assert_eq!(closed, Ok(-0.5));
        let none = measure("results.depth_m", "at", "").deviation(&run, ReferenceNumbers::Nothing);
        assert!(none.is_err());
    }
}
