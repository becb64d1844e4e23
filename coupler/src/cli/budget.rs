//! `thirdbody run --budget`: the fidelity that a stored study has for an error or a time.

use std::path::PathBuf;

use super::common::ScenarioArguments;
use super::start::options;
use crate::error::{Error, Refusal};
use crate::output::tell;
use crate::participants::Registry;
use crate::run::session::{RunBudget, fresh_run_id, run};
use crate::rundir::{BUILD, Scratch};
use crate::scenario::load::Loaded;
use crate::study::budget::{Budget, Candidate, Choice, covering};

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
        let (study, at) = covering(self.study.as_deref(), &loaded.resolved)?;
        if study.build != BUILD {
            tell(&format!(
                "study `{}` was made by another build, {}: its errors are taken to hold for this one",
                study.study, study.build
            ));
        }
        let choice = Choice::new(&study, &at)?;
        let (chosen, wall_s, limit) = match &budget {
            Budget::Error { measure, error } => {
                (choice.within_error(measure.as_deref(), *error)?, None, None)
            }
            Budget::Wall(limit) => {
                let foretell = |candidate: &Candidate| {
                    let loaded = scenario.with(&candidate.setting.set)?;
                    foretold_wall_s(&loaded, scenario.threads(), registry)
                };
                let (chosen, wall_s) = within_wall(&choice, *limit, foretell)?;
                (chosen, Some(wall_s), Some(*limit))
            }
        };
        tell(&choice.words(chosen));
        Ok((
            scenario.with(&chosen.setting.set)?,
            Some(RunBudget {
                told: choice.told(chosen, text, wall_s),
                wall_s: limit,
            }),
        ))
    }
}

/// The most accurate setting whose time is foretold to keep within the limit: the study tells how times compare, rehearsals what they
/// are on this machine.
fn within_wall<'a, 'b>(
    choice: &'b Choice<'a>,
    limit_s: f64,
    foretell: impl Fn(&Candidate) -> Result<f64, Error>,
) -> Result<(&'b Candidate<'a>, f64), Error> {
    let order = choice.by_accuracy();
    let (mut pace, mut rest) = (1.0, &order[..]);
    for _ in 0..REHEARSALS {
        let next = rest.iter().position(|c| pace * c.setting.wall_s <= limit_s);
        let Some(next) = next else { break };
        let candidate = rest[next];
        let wall_s = foretell(candidate)?;
        if wall_s <= limit_s {
            return Ok((candidate, wall_s));
        }
        pace = wall_s / candidate.setting.wall_s;
        rest = &rest[next + 1..];
    }
    let least = order
        .iter()
        .map(|c| c.setting.wall_s)
        .fold(f64::INFINITY, f64::min);
    let problem = format!(
        "no setting of the study is foretold to end within {limit_s} s here; its fastest takes about {:.1} s",
        pace * least
    );
    Err(Refusal::argument("--budget", problem).into())
}

/// Wall-clock time of a run, as its first second foretells it. A run that is over within that second takes no longer.
fn foretold_wall_s(loaded: &Loaded, threads: usize, registry: &Registry) -> Result<f64, Error> {
    let scratch = Scratch::new("budget", fresh_run_id());
    let mut options = options(Some(scratch.path()), threads, registry)?;
    options.progress = false;
    options.rehearsal = true;
    let ended = run(loaded, &options)?;
    let told = ended.summary.spent.as_ref().and_then(|spent| spent.told);
    match (told, ended.error) {
        (Some(told), _) => Ok(told.wall_s),
        (None, Some(error)) => Err(error),
        (None, None) => Ok(ended.summary.value()["wall_s"].as_f64().unwrap_or(0.0)),
    }
}
