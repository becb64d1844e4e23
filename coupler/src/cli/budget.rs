//! `thirdbody run --budget`: the fidelity that a stored study has for an error or a time.

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
use terminal::tell;

/// Arguments that choose the fidelity of a run.
#[derive(Debug, clap::Args)]
pub struct BudgetArguments {
    /// Choose the cheapest setting of a stored study that keeps an error (error=2%, or MEASURE=2% for one of its measures), or the
    /// most accurate one within a time (wall=60s). Keys that the study varies are then set by it.
    #[arg(long, value_name = "BUDGET")]
    budget: Option<String>,
    /// The study to choose by: study.json, or a folder with it. By default the first that covers the scene.
    #[arg(long, value_name = "DIR", requires = "budget")]
    study: Option<PathBuf>,
}

/// Rehearsals until a time is kept.
const REHEARSALS: usize = 4;

impl BudgetArguments {
    /// The scenario with the setting that was chosen, and what to tell of it; as it is without a budget.
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
            let foretell = |candidate: &Candidate| {
                let loaded = scenario.with(&candidate.setting.set)?;
                foretold_wall_s(&loaded, scenario.threads(), registry)
            };
            let (chosen, foretold_s, limit_s) = match &budget {
                Budget::Error { measure, error } => {
                    (choice.within_error(measure.as_deref(), *error)?, None, None)
                }
                Budget::Wall(limit_s) => {
                    let (chosen, wall_s) = within_wall(&choice, *limit_s, foretell)?;
                    (chosen, Some(wall_s), Some(*limit_s))
                }
            };
            if let Some(set) = scenario
                .set
                .iter()
                .find(|set| overridden(set, &chosen.setting.set))
            {
                let problem = format!(
                    "{set} has no effect: the study `{}` chooses this key, and the budget sets it; remove --set or --budget",
                    study.study
                );
                return Err(Refusal::argument("--set", problem).into());
            }
            if study.build != build().hash {
                tell(&format!(
                    "study `{}` was made by another build, {}: its errors are taken to hold for this one",
                    study.study, study.build
                ));
            }
            tell(&choice.words(chosen));
            let budget = RunBudget {
                told: choice.told(chosen, text, foretold_s),
                wall_s: limit_s,
            };
            Ok((scenario.with(&chosen.setting.set)?, Some(budget)))
        };
        first_choice(self.study.as_deref(), &loaded.resolved, choose)
    }
}

/// True for an override whose key these give another value.
fn overridden(set: &str, by: &[String]) -> bool {
    let value = |set: &str| {
        set.split_once('=')
            .map(|(_, value)| parse_value(value.trim()))
    };
    let mut same = by.iter().filter(|other| key_of(other) == key_of(set));
    same.any(|other| value(other) != value(set))
}

/// The most accurate setting whose time is foretold to keep within the limit: the study tells how times compare, dry runs what they
/// are on this machine. One that fits is not the last to be tried where this machine is faster than that of the study.
fn within_wall<'a, 'b>(
    choice: &'b SceneSettings<'a>,
    limit_s: f64,
    foretell: impl Fn(&Candidate) -> Result<f64, Error>,
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
        let wall_s = foretell(order[next])?;
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
        "no setting of the study is foretold to end within {limit_s} s here; its fastest takes about {:.1} s",
        pace * least
    );
    Err(Refusal::argument("--budget", problem).into())
}

/// Wall-clock time of a run, as its first second foretells it. A run that is over within that second takes no longer.
pub(super) fn foretold_wall_s(
    loaded: &Loaded,
    threads: usize,
    registry: &Registry,
) -> Result<f64, Error> {
    let ended = rehearse(loaded, threads, registry)?;
    let told = ended.summary.spent.as_ref().and_then(|spent| spent.told);
    match (told, ended.error) {
        (Some(told), _) => Ok(told.wall_s),
        (None, Some(error)) => Err(error),
        (None, None) => Ok(ended.summary.value()["wall_s"].as_f64().unwrap_or(0.0)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Settings of 8, 4, 2 and 1 s, the more costly the more accurate.
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
        serde_json::from_value(study).expect("it is one")
    }

    #[test]
    fn an_override_that_the_budget_would_undo_is_found() {
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
    fn a_time_is_kept_by_the_most_accurate_setting_on_machines_of_any_pace() {
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
