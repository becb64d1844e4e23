//! Compares a run with a reference.

use std::cmp::Ordering;
use std::collections::BTreeMap;

use serde_json::{Value, json};

use super::curve::{Curve, Distance, part};
use super::files::RunFiles;
use super::steps::Steps;
use super::table::Table;
use scenario::overrides::{Changes, changes};

/// Column of the time in signals.csv, and of the position in profile.csv.
const TIME: &str = "t_s";
const POSITION: &str = "x_m";

/// Reasons why a column has no distance: only one run has it.
pub const OF_ONE: [&str; 2] = [
    "only the reference has it",
    "the reference does not have it",
];

/// A distance, or the reason why it is missing.
pub type Compared = Result<Distance, String>;

/// A number of the run and of the reference; either may lack it.
pub type NumberPair = [Option<f64>; 2];

/// Distances of a run from a reference.
#[derive(Clone, Debug)]
pub struct Comparison {
    /// True if all messages between the participants were the same, bit for bit.
    pub same_exchange: bool,
    /// Keys in which the scenarios differ: the value in the reference, and the value in the run.
    pub keys: Changes,
    /// Distances of all signals of both runs. The largest changes relative to their size come first, then signals that
    /// changed no more than their own scatter, then signals that cannot be compared.
    pub signals: Vec<(String, Compared)>,
    /// Distances of all tractions on the surface, in the same order.
    pub profile: Vec<(String, Compared)>,
    /// Results, by name.
    pub results: BTreeMap<String, NumberPair>,
    /// Costs, by name.
    pub cost: BTreeMap<String, NumberPair>,
}

impl Comparison {
    /// Compares two runs. Tractions are compared by their means over bins of this width (m), or over the segments of
    /// the reference.
    pub fn new(run: &RunFiles, reference: &RunFiles, bin_m: Option<f64>) -> Comparison {
        let profiles =
            [&run.profile, &reference.profile].map(|table| table.clone().unwrap_or_default());
        let [own, other] = &profiles;
        let exchanges = [run, reference].map(|run| run.hash("exchange"));
        Comparison {
            same_exchange: exchanges[0].is_some() && exchanges[0] == exchanges[1],
            keys: changes([&reference.scenario_table(), &run.scenario_table()]),
            signals: columns(&run.signals, &reference.signals, TIME, |x, y| {
                let [own, other] = [0, 1].map(|k| Curve { x: x[k], y: y[k] });
                own.distance(&other)
            }),
            profile: columns(own, other, POSITION, |x, [own, other]| {
                let steps = Steps::around(x[0], own).zip(Steps::around(x[1], other));
                let (own, other) = steps.ok_or("there are no numbers")?;
                own.distance(&other, bin_m)
            }),
            results: pairs(run.results(), reference.results()),
            cost: pairs(run.cost(), reference.cost()),
        }
    }

    /// As JSON. An entry that could not be compared has `why`.
    pub fn json(&self) -> Value {
        let distances = |all: &[(String, Compared)]| {
            let each = all.iter().map(|(name, compared)| {
                let value = match compared {
                    Ok(d) => json!({
                        "rms": d.rms, "l2_rel": d.l2_rel, "max": d.max, "max_rel": d.max_rel
                    }),
                    Err(why) => json!({ "why": why }),
                };
                (name.clone(), value)
            });
            Value::Object(each.collect())
        };
        let pairs =
            |all: &BTreeMap<String, NumberPair>, key: &str, of: fn(NumberPair) -> Option<f64>| {
                let each = all.iter().map(|(name, pair)| {
                    let [run, reference] = pair;
                    let value = json!({ "run": run, "reference": reference, key: of(*pair) });
                    (name.clone(), value)
                });
                Value::Object(each.collect())
            };
        json!({
            "same_exchange": self.same_exchange,
            "keys": self.keys.iter().map(|(key, [reference, run])| {
                (key.clone(), json!({ "run": run, "reference": reference }))
            }).collect::<serde_json::Map<_, _>>(),
            "signals": distances(&self.signals),
            "profile": distances(&self.profile),
            "results": pairs(&self.results, "rel", difference),
            "cost": pairs(&self.cost, "ratio", ratio),
        })
    }
}

/// |a - b| / |b|; `None` if one is missing or the reference is 0.
pub fn difference([run, reference]: NumberPair) -> Option<f64> {
    let (run, reference) = run.zip(reference)?;
    part((run - reference).abs(), reference.abs())
}

/// a / b; `None` if one is missing or the reference is 0.
pub fn ratio([run, reference]: NumberPair) -> Option<f64> {
    let (run, reference) = run.zip(reference)?;
    part(run, reference)
}

/// Compares the columns of two tables over their own columns `x`.
fn columns(
    run: &Table,
    reference: &Table,
    x: &str,
    compare: impl Fn([&[f64]; 2], [&[f64]; 2]) -> Compared,
) -> Vec<(String, Compared)> {
    let names = |table: &Table| -> Vec<String> {
        let names = table.columns.iter().map(|(name, _)| name.clone());
        names.filter(|name| name != x).collect()
    };
    let own = names(run).into_iter().map(|name| {
        let other = reference.name_of(&name, run).map(String::from);
        (Some(name), other)
    });
    let others = names(reference).into_iter();
    let others = others.filter(|name| run.name_of(name, reference).is_none());
    let found = own
        .chain(others.map(|other| (None, Some(other))))
        .map(|(own, other)| {
            let [own_numbers, other_numbers] = [(run, &own), (reference, &other)]
                .map(|(table, name)| Some([table.get(x)?, table.get(name.as_deref()?)?]));
            let compared = match (own_numbers, other_numbers) {
                (Some([x, y]), Some([other_x, other_y])) => compare([x, other_x], [y, other_y]),
                (None, _) => Err(OF_ONE[0].to_string()),
                (_, None) => Err(OF_ONE[1].to_string()),
            };
            let numbers = [own_numbers, other_numbers].into_iter().flatten();
            let scatter = numbers.map(|[_, y]| scatter(y)).fold(0.0, f64::max);
            let change = change(&compared, scatter);
            (change, (own.or(other).unwrap_or_default(), compared))
        });
    let mut found: Vec<_> = found.collect();
    found.sort_by(|(a, _), (b, _)| b.partial_cmp(a).unwrap_or(Ordering::Equal));
    found.into_iter().map(|(_, row)| row).collect()
}

/// A distance below this many times the scatter is noise: two samples of noise differ by 1.4 times the scatter.
const NOISE: f64 = 3.0;

/// Whether a distance exceeds the scatter, and the relative distance.
fn change(compared: &Compared, scatter: f64) -> (bool, f64) {
    match compared {
        Ok(d) => {
            let share = d.l2_rel.or(d.max_rel).unwrap_or(f64::from(d.max > 0.0));
            (d.rms > NOISE * scatter, share)
        }
        Err(_) => (false, -1.0),
    }
}

/// Standard deviation of the scatter from row to row: third differences remove smooth parts, and their variance is 20
/// times the variance of independent numbers.
fn scatter(y: &[f64]) -> f64 {
    let third = y.windows(4).map(|y| y[3] - y[0] + 3.0 * (y[1] - y[2]));
    let finite = third.filter(|x| x.is_finite());
    let (sum, count) = finite.fold((0.0, 0.0), |(sum, count), x| (sum + x * x, count + 1.0));
    part(sum, count).map_or(0.0, |mean| f64::sqrt(mean / 20.0))
}

/// Numbers of both runs by name, the largest relative change first. Residuals and balances are noise in both runs and
/// come last.
pub fn by_change(all: &BTreeMap<String, NumberPair>) -> Vec<(&String, NumberPair)> {
    let mut all: Vec<_> = all.iter().map(|(name, pair)| (name, *pair)).collect();
    let noise = ["_rel", "residual", "defect"];
    let key = |(name, pair): &(&String, NumberPair)| {
        let is_noise = noise.iter().any(|word| name.contains(word));
        (!is_noise, difference(*pair).unwrap_or(-1.0))
    };
    all.sort_by(|a, b| key(b).partial_cmp(&key(a)).unwrap_or(Ordering::Equal));
    all
}

fn pairs(
    run: BTreeMap<String, f64>,
    reference: BTreeMap<String, f64>,
) -> BTreeMap<String, NumberPair> {
    let names = run.keys().chain(reference.keys());
    let pair = |name: &String| [run.get(name).copied(), reference.get(name).copied()];
    names.map(|name| (name.clone(), pair(name))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn finished(summary: Value, signals: &str, profile: Option<&str>) -> RunFiles {
        RunFiles {
            summary,
            signals: Table::parse(signals).expect("a table"),
            profile: profile.map(|text| Table::parse(text).expect("a table")),
            ..RunFiles::default()
        }
    }

    fn run() -> RunFiles {
        let summary = json!({
            "wall_s": 3.0, "results": { "approach_m": 1.1e-5, "own": 1.0 }, "hashes": { "exchange": "a" },
            "coordinator": { "pid": 7, "cpu_s": 0.5 },
            "participants": { "rail": { "pid": 8, "cpu_s": 2.0, "work": { "element_steps": 100.0 } },
                              "layer": { "pid": 9, "cpu_s": 3.0, "work": { "contact_iterations": 7.0 } } },
        });
        let profile = Some("x_m,pressure_pa,status\n0,2,tied\n1,2,tied\n");
        finished(summary, "t_s,y,z\n0,1,5\n2,3,5\n", profile)
    }

    fn reference() -> RunFiles {
        let summary = json!({
            "wall_s": 1.5, "results": { "approach_m": 1e-5 }, "hashes": { "exchange": "b" },
            "coordinator": { "pid": 7, "cpu_s": 4.5 },
            "participants": { "rail": { "pid": 7, "cpu_s": 4.0, "work": { "element_steps": 50.0 } } },
        });
        let profile = Some("x_m,pressure_pa,status\n0,1,tied\n1,1,tied\n");
        finished(summary, "t_s,y,w\n0,1,5\n2,2,5\n", profile)
    }

    /// d = x/2 on [0, 2] against 1 + x/2.
    #[test]
    fn common_columns_are_compared_and_the_rest_is_listed() {
        let found = Comparison::new(&run(), &reference(), None);
        assert!(!found.same_exchange);
        let names: Vec<&str> = found
            .signals
            .iter()
            .map(|(name, _)| name.as_str())
            .collect();
        assert_eq!(names, ["y", "z", "w"]);
        let y = found.signals[0].1.clone().expect("both have it");
        assert_eq!((y.max, y.max_rel), (1.0, Some(0.5)));
        let why = |k: usize| found.signals[k].1.clone().expect_err("one has it");
        assert_eq!(why(1), "the reference does not have it");
        assert_eq!(why(2), "only the reference has it");
        assert_eq!(found.profile.len(), 1);
        let pressure = found.profile[0].1.clone().expect("both have it");
        assert_eq!(pressure.l2_rel, Some(1.0));
        let approach = difference(found.results["approach_m"]).expect("both have it");
        assert!((approach - 0.1).abs() < 1e-12);
        assert_eq!(found.results["own"], [Some(1.0), None]);
        assert_eq!(found.cost["cpu_s"], [Some(5.5), Some(4.5)]);
        assert_eq!(found.cost["element_steps"], [Some(100.0), Some(50.0)]);
        assert_eq!(found.cost["contact_iterations"], [Some(7.0), None]);
    }

    /// A gap that is pure noise, with other random numbers, and a force that is 2 % larger.
    #[test]
    fn the_largest_change_comes_first_and_noise_last() {
        let signals = |factor: f64, phase: f64| {
            let row = |k: i32| {
                let t = f64::from(k);
                let noise = 1e-16 * (1e4 * (t + phase)).sin().abs();
                format!("{t},{noise:e},{},{}\n", 5.0 + t, factor * (1.0 + t))
            };
            "t_s,gap_rel,a,force\n".to_string() + &(0..50).map(row).collect::<String>()
        };
        let results = |force: f64, residual: f64| json!({"results": {"a_residual": residual, "b": 1.0, "force": force}});
        let own = finished(results(1.02, 1e-15), &signals(1.02, 0.3), None);
        let other = finished(results(1.0, 5e-15), &signals(1.0, 0.0), None);
        let found = Comparison::new(&own, &other, None);
        let names: Vec<&str> = found
            .signals
            .iter()
            .map(|(name, _)| name.as_str())
            .collect();
        assert_eq!(names, ["force", "gap_rel", "a"]);
        let names: Vec<&String> = by_change(&found.results)
            .iter()
            .map(|(name, _)| *name)
            .collect();
        assert_eq!(names, ["force", "b", "a_residual"]);
    }

    #[test]
    fn a_run_equals_itself() {
        let found = Comparison::new(&run(), &run(), Some(0.125));
        assert!(found.same_exchange);
        let all = found.signals.iter().chain(&found.profile);
        for (name, compared) in all {
            assert_eq!(compared.clone().expect("both have it").max, 0.0, "{name}");
        }
        let json = found.json();
        assert_eq!(json["results"]["own"]["rel"], 0.0);
        assert_eq!(json["signals"]["y"]["l2_rel"], 0.0);
        assert_eq!(json["cost"]["wall_s"]["ratio"], 1.0);
    }
}
