//! `thirdbody run --budget`: choose a setting of a stored study for an error or a time.

use std::path::PathBuf;

use super::common::ScenarioArguments;
use super::start::rehearse;
use coordinator::participants::Registry;
use coordinator::run::session::RunBudget;
use runs::identity::build;
use scenario::error::{Error, Refusal};
use scenario::load::Loaded;
use scenario::overrides::{key_of, parse_value};
use study::budget::{Budget, Candidate, SceneSettings, first_choice};
use study::stored::StoredStudy;
use terminal::print_note;

/// Arguments that choose the setting of a run.
#[derive(Debug, clap::Args)]
pub struct BudgetArguments {
    /// Choose the cheapest setting of a stored study that keeps an error (error=2%, or MEASURE=2% for one measure), or the most accurate
    /// one within a time (wall=60s). The setting fixes the keys that the study varies.
    #[arg(long, value_name = "BUDGET")]
    budget: Option<String>,
    /// Study to choose from: study.json, or a folder with it (default: the first stored study that covers the scene).
    #[arg(long, value_name = "DIR", requires = "budget")]
    study: Option<PathBuf>,
}

/// Largest number of dry runs in the search for a setting within a time.
const REHEARSALS: usize = 4;

impl BudgetArguments {
    /// The scenario with the chosen setting, and the budget for the summary; without a budget, the scenario as it is.
    pub(super) fn load(
        &self,
        scenario: &ScenarioArguments,
        registry: &Registry,
    ) -> Result<(Loaded, Option<RunBudget>), Error> {
        let loaded = scenario.load()?;
        let Some(text) = &self.budget else {
            return Ok((loaded, None));
        };
        let budget = Budget::parse(text).map_err(|why| Refusal::argument("--budget", why))?;
        let choose = |study: &StoredStudy, at: &[f64]| {
            let choice = SceneSettings::new(study, at)?;
            let predict = |candidate: &Candidate| {
                let loaded = scenario.with(&candidate.setting.set)?;
                predicted_wall_s(&loaded, scenario.threads(), registry)
            };
            let (chosen, predicted_s, limit_s) = match &budget {
                Budget::Error { measure, error } => {
                    (choice.within_error(measure.as_deref(), *error)?, None, None)
                }
                Budget::Wall(limit_s) => {
                    let (chosen, wall_s) = within_wall(&choice, *limit_s, predict)?;
                    (chosen, Some(wall_s), Some(*limit_s))
                }
            };
            let mut sets = scenario.set.iter();
            if let Some(set) = sets.find(|set| overridden(set, &chosen.setting.set)) {
                let problem = format!(
                    "{set} has no effect: the budget sets this key from the study `{}`; remove --set or --budget",
                    study.study
                );
                return Err(Refusal::argument("--set", problem).into());
            }
            if study.build != build().hash {
                print_note(&format!(
                    "study `{}` is of another build, {}: its errors are assumed to hold for this build",
                    study.study, study.build
                ));
            }
            print_note(&choice.words(chosen));
            let budget = RunBudget {
                told: choice.summary(chosen, text, predicted_s),
                wall_s: limit_s,
            };
            Ok((scenario.with(&chosen.setting.set)?, Some(budget)))
        };
        first_choice(self.study.as_deref(), &loaded.resolved, choose)
    }
}

/// True if these overrides give the key of `set` another value.
fn overridden(set: &str, by: &[String]) -> bool {
    let value = |set: &str| Some(parse_value(set.split_once('=')?.1.trim()));
    let mut same = by.iter().filter(|other| key_of(other) == key_of(set));
    same.any(|other| value(other) != value(set))
}

/// The most accurate setting whose predicted time is within the limit. The study gives the ratios of the times, dry runs give the times
/// on this machine. The search continues after a setting that fits, because this machine may be faster than the study's.
fn within_wall<'a, 'b>(
    choice: &'b SceneSettings<'a>,
    limit_s: f64,
    predict: impl Fn(&Candidate) -> Result<f64, Error>,
) -> Result<(&'b Candidate<'a>, f64), Error> {
    let order = choice.by_accuracy();
    let mut tried = vec![false; order.len()];
    let (mut pace, mut best) = (1.0, None);
    for _ in 0..REHEARSALS {
        let better = best.map_or(order.len(), |(place, _)| place);
        let next = (0..better)
            .find(|place| !tried[*place] && pace * order[*place].setting.wall_s <= limit_s);
        let Some(next) = next else { break };
        tried[next] = true;
        let wall_s = predict(order[next])?;
        pace = wall_s / order[next].setting.wall_s;
        if wall_s <= limit_s {
            best = Some((next, wall_s));
        }
    }
    if let Some((place, wall_s)) = best {
        return Ok((order[place], wall_s));
    }
    let least = order.iter().map(|c| c.setting.wall_s);
    let least = least.fold(f64::INFINITY, f64::min);
    let problem = format!(
        "no setting of the study is predicted to end within {limit_s} s on this machine; its fastest takes about {:.1} s",
        pace * least
    );
    Err(Refusal::argument("--budget", problem).into())
}

/// Wall-clock time of a run, predicted from its first second; a run that ends within that second gives its own time.
pub(super) fn predicted_wall_s(
    loaded: &Loaded,
    threads: usize,
    registry: &Registry,
) -> Result<f64, Error> {
    let ended = rehearse(loaded, threads, registry)?;
    let prediction = ended.summary.spent.as_ref().and_then(|spent| spent.told);
    match (prediction, ended.error) {
        (Some(prediction), _) => Ok(prediction.wall_s),
        (None, Some(error)) => Err(error),
        (None, None) => Ok(ended.summary.value()["wall_s"].as_f64().unwrap_or(0.0)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Settings of 8, 4, 2 and 1 s; a more costly one is more accurate.
    fn study() -> StoredStudy {
        let setting = |wall_s: f64| {
            serde_json::json!({ "words": format!("{wall_s}"), "set": [format!("a.b={wall_s}")], "cpu_rel": 1.0, "wall_s": wall_s,
                "errors": [[0.1 / wall_s, 0.11 / wall_s, 0.1 / wall_s, 0.09 / wall_s, 0.1 / wall_s]] })
        };
        let settings = [8.0, 4.0, 2.0, 1.0].map(setting);
        let study = serde_json::json!({
            "schema": "thirdbody.study/1", "study": "s", "build": "b", "scenario": "", "reference": ["a.b=ref"],
            "scene_keys": [{ "key": "run.seed", "any": true, "values": [1, 2, 3, 4, 5] }],
            "measures": [{ "name": "m", "of": "results.x", "norm": "at" }],
            "floors": [[1e-6, 1e-6, 1e-6, 1e-6, 1e-6]],
            "settings": settings,
        });
        serde_json::from_value(study).expect("a stored study")
    }

    #[test]
    fn an_override_that_the_budget_would_undo_is_detected() {
        let by = [
            "interface.a.substeps=9".to_string(),
            "participant.p.config.mass_scale=1e2".into(),
        ];
        assert!(overridden("interface.a.substeps = 2", &by));
        assert!(!overridden("interface.a.substeps=9", &by));
        assert!(!overridden("participant.p.config.mass_scale=100.0", &by));
        assert!(!overridden("run.seed=2", &by));
    }

    #[test]
    fn the_most_accurate_setting_within_a_time_is_found_on_machines_of_any_speed() {
        let study = study();
        let choice = SceneSettings::new(&study, &[]).expect("five scenes will do");
        let chosen = |pace: f64, limit_s: f64| {
            let found = within_wall(&choice, limit_s, |c| Ok(pace * c.setting.wall_s));
            found.map(|(c, wall_s)| (c.setting.wall_s, wall_s))
        };
        assert_eq!(chosen(1.0, 5.0).expect("4 s do"), (4.0, 4.0));
        assert_eq!(chosen(2.0, 5.0).expect("2 s are 4 here"), (2.0, 4.0));
        assert_eq!(chosen(0.5, 5.0).expect("8 s are 4 here"), (8.0, 4.0));
        let slow = chosen(6.0, 5.0).expect_err("1 s is 6 here").to_string();
        assert!(slow.contains("its fastest takes about 6.0 s"), "{slow}");
    }
}
