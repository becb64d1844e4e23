//! Time from a request of the coupler to the answer of any participant.

use serde::Serialize;

use super::time_turns;
use crate::conform::conforming;
use crate::conform::launch::Launch;
use crate::conform::tested::{ConformOptions, Part, ScenarioLauncher, TestedParticipant};
use scenario::error::{Error, Refusal};
use scenario::load::{Loaded, parse};
use scenario::source::ScenarioSource;

/// Number of windows before timing starts.
const WARM_UP: usize = 200;
/// Number of timed windows.
const TIMED: usize = 3_000;

/// Name of a participant without a scenario.
pub const NAME: &str = "node";

/// One row of the table.
#[derive(Clone, Debug, Serialize)]
pub struct ParticipantRow {
    /// Doubles in the request.
    pub doubles: usize,
    /// Doubles in the answer.
    pub answered: usize,
    /// Median time from the request to the answer (us).
    pub p50_us: f64,
    /// 99th percentile (us).
    pub p99_us: f64,
    /// Mean time per request in the solver, as the participant reports it (us).
    pub solve_us: f64,
}

/// A scenario for a program that is measured without one.
pub fn scenario_of_a_command() -> Result<Loaded, Error> {
    let text = format!(
        "[run]\nname = \"bench\"\nthickness_m = 1e-3\n[[participant]]\nname = \"{NAME}\"\nkind = \"foreign\"\n"
    );
    parse(ScenarioSource::new("scenario.toml", text, &[]))
}

/// Requests the first window from a participant repeatedly, without a load.
pub fn bench(
    loaded: &Loaded,
    name: &str,
    command: Option<&[String]>,
    options: &ConformOptions,
) -> Result<Vec<ParticipantRow>, Error> {
    let participant = conforming(loaded, name, command)?;
    let launcher = ScenarioLauncher::new(loaded, options);
    let (peers, greeted) = launcher.launch(&participant, 1)?;
    drop(peers);
    let mut description = greeted.description;
    let no_interface = loaded.scenario.interface.is_empty();
    if no_interface {
        description.step_s.get_or_insert(1e-6);
    }
    let mut tested = TestedParticipant::new(&launcher, &participant, description)?;
    if no_interface {
        tested.part = Part::joined(&tested.description);
        tested.sets = tested.description.sets.iter().take(1).cloned().collect();
        tested.clock.substeps = 1;
    }
    if tested.part == Part::Alone || !tested.description.capabilities.rollback {
        let problem =
            "takes part in no interface, or cannot repeat a window: there is no exchange to time";
        return Err(Refusal::participant(name, problem).into());
    }
    let mut launch = Launch::new(&tested, 1)?;
    let load = vec![0.0; launch.size()];
    let window = launch.window(0);
    let mut answered = 0;
    let (p50_us, p99_us) = time_turns(WARM_UP, TIMED, |_| {
        answered = launch.ask(&window, &load)?.len();
        Ok(())
    })?;
    let farewell = launch.finish()?.farewell;
    Ok(vec![ParticipantRow {
        doubles: load.len(),
        answered,
        p50_us,
        p99_us,
        solve_us: 1e6 * farewell.solve_wall_s / (WARM_UP + TIMED) as f64,
    }])
}
