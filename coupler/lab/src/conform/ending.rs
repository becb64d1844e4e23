//! Rules for farewells, faults and ends.

use std::time::Duration;

use protocol::Frame;
use protocol::frame::packed;

use super::launch::{Launch, LaunchEnd};
use super::plain::{RuleTrial, WINDOWS};
use super::rule::{RuleFinding, broken, exceeds, not_tested};
use super::tested::Part;
use scenario::error::{Error, Refusal};

/// Time in which a participant must end.
const GRACE: Duration = Duration::from_secs(1);

/// Time in which it must notice that the coordinator has gone.
const NOTICE: Duration = Duration::from_secs(3);

/// Allowed difference between its clocks and ours (s).
const CLOCKS_S: f64 = 0.05;

/// Checks steps and state hash of the farewell.
pub fn farewell(trial: &RuleTrial) -> RuleFinding {
    let tested = trial.tested;
    let outcome = &trial.plain.end.farewell.outcome;
    let due = match (tested.part, tested.description.step_s) {
        (Part::MotionDriven, _) | (_, None) => WINDOWS,
        _ => WINDOWS * u64::from(tested.clock.substeps),
    };
    let (steps, hash) = (outcome.steps, &outcome.state_hash);
    if steps < due {
        return broken(format!("it counts {steps} steps, but {due} were committed"));
    }
    if hash.is_empty() && !tested.description.capabilities.resume {
        return Ok("it has no hash of its state, and no checkpoints".into());
    }
    if hash.len() != 64 || !hash.chars().all(|c| c.is_ascii_hexdigit()) {
        let hash = hash.escape_debug();
        let why = format!("its state hash `{hash}` does not have 64 hexadecimal digits");
        return broken(why);
    }
    let other = trial.live(1, &mut |launch, window, _| {
        let load = trial.loads.of_window(window.index, 1);
        Ok((*window, launch.ask(window, &load)?))
    })?;
    let differs = trial.plain.answers != other.answers;
    if differs && other.state_hash() == hash {
        return broken(
            "another load led to other answers and to the same state hash: it must be over every number that can change a later bit",
        );
    }
    Ok(format!("{steps} steps"))
}

/// Compares the times of the farewell with the launch.
pub fn times(trial: &RuleTrial) -> RuleFinding {
    let LaunchEnd { farewell, lived } = &trial.plain.end;
    let times = [
        ("cpu_s", farewell.cpu_s),
        ("solve_wall_s", farewell.solve_wall_s),
        ("setup_wall_s", farewell.setup_wall_s),
        ("wait_s", farewell.wait_s),
    ];
    if let Some((name, value)) = times.iter().find(|(_, value)| exceeds(-value, 0.0)) {
        return broken(format!("its {name} is {value}"));
    }
    let walls: f64 = times[1..].iter().map(|(_, value)| value).sum();
    let lived = lived.as_secs_f64();
    let sum = format!("solve, set-up and wait take {walls:.3} s of {lived:.3} s");
    if walls > lived + CLOCKS_S {
        return broken(sum);
    }
    Ok(sum)
}

/// An invalid request: its name, and the function that sends it.
type Nonsense<'t> = (&'static str, &'t dyn Fn(&mut Launch) -> Result<(), Error>);

/// Sends invalid requests.
pub fn faults(trial: &RuleTrial) -> RuleFinding {
    let load = trial.loads.of_window(0, 0);
    let short = &load[..load.len().saturating_sub(1)];
    let poisoned: Vec<f64> = load.iter().map(|_| f64::NAN).collect();
    let ask = |launch: &mut Launch, load: &[f64]| launch.ask(&launch.window(0), load).map(|_| ());
    let unknown_set = |launch: &mut Launch| launch.couple("no such set").map(|_| ());
    let short_load = |launch: &mut Launch| ask(launch, short);
    let no_numbers = |launch: &mut Launch| ask(launch, &poisoned);
    let damaged = |launch: &mut Launch| {
        let state = launch.checkpoint()?;
        let bytes = state.bytes().map_err(Refusal::from)?;
        let half = Frame::new(state.header, packed(&bytes[..bytes.len() / 2]));
        launch.restore(&half, &launch.displacement.clone())
    };
    let mut all: Vec<Nonsense> = vec![("a set that it does not have", &unknown_set)];
    if trial.tested.part != Part::Alone {
        all.push(("a load that is a component short", &short_load));
        all.push(("a load of NaN", &no_numbers));
    }
    if trial.tested.description.capabilities.resume {
        all.push(("half of a checkpoint", &damaged));
    }
    for (what, request) in &all {
        let mut launch = trial.begin()?;
        let answered = request(&mut launch);
        let Some(_) = launch.fault() else {
            return broken(match answered {
                Ok(()) => format!("{what} got an ordinary answer"),
                Err(error) => format!("{what} got no `Fault`: {error}"),
            });
        };
        if launch.outlives(GRACE) {
            return broken(format!("it did not end after {what} and its `Fault`"));
        }
    }
    let names: Vec<&str> = all.iter().map(|(what, _)| *what).collect();
    Ok(names.join(", "))
}

/// Checks that it ends: after SIGTERM, after a farewell, and when the coordinator has gone.
pub fn shutdown(trial: &RuleTrial) -> RuleFinding {
    let mut launch = trial.begin()?;
    let Some(process) = launch.process() else {
        return not_tested("it is no separate process");
    };
    process.ask_to_end();
    if !process.ends_within(GRACE) {
        return broken("it still lives a second after SIGTERM");
    }
    let mut launch = trial.begin()?;
    launch.finish()?;
    if launch.outlives(GRACE) {
        return broken("it still lives a second after its farewell");
    }
    let mut launch = trial.begin()?;
    launch.hang_up();
    if launch.outlives(NOTICE) {
        let s = NOTICE.as_secs();
        let why = format!("it still lives {s} s after the coordinator has closed the connection");
        return broken(why);
    }
    Ok("after SIGTERM, after its farewell, and when the coordinator has gone".into())
}
