//! Rules about farewells, faults and ends.

use std::time::Duration;

use protocol::Frame;

use super::launch::Launch;
use super::plain::{RuleTrial, WINDOWS};
use super::rule::{Finding, broken, exceeds, holds, not_tested};
use super::subject::Part;
use coordinator::error::{Error, Refusal};

/// Time in which a participant ends.
const GRACE: Duration = Duration::from_secs(1);

/// Time in which it notices that nobody is there any more.
const NOTICE: Duration = Duration::from_secs(3);

/// Time that its clocks may be apart from ours.
const CLOCKS_S: f64 = 0.05;

/// Steps and state hash of the farewell.
pub fn farewell(trial: &RuleTrial) -> Result<Finding, Error> {
    let subject = trial.subject;
    let outcome = &trial.plain.death.farewell.outcome;
    let due = match (subject.part, subject.told.step_s) {
        (Part::MotionDriven, _) | (_, None) => WINDOWS,
        _ => WINDOWS * u64::from(subject.clock.substeps),
    };
    if outcome.steps < due {
        return Ok(broken(format!(
            "it counts {} steps, {due} were committed",
            outcome.steps
        )));
    }
    let hash = &outcome.state_hash;
    if hash.is_empty() && !subject.told.capabilities.resume {
        return Ok(holds("it has no hash of its state, and no checkpoints"));
    }
    if hash.len() != 64 || !hash.chars().all(|c| c.is_ascii_hexdigit()) {
        return Ok(broken(format!(
            "its state hash `{}` is not of 64 hexadecimal digits",
            hash.escape_debug()
        )));
    }
    let other = trial.live(1, &mut |life, window, _| {
        let load = trial.loads.of_window(window.index, 1);
        Ok((*window, life.ask(window, &load)?))
    })?;
    let differs = trial.plain.answers != other.answers;
    if differs && other.death.farewell.outcome.state_hash == *hash {
        return Ok(broken(
            "another load led to other answers and to the same state hash: it must be over every number that can change a later bit",
        ));
    }
    Ok(holds(format!("{} steps", outcome.steps)))
}

/// Times of the farewell against the life.
pub fn times(trial: &RuleTrial) -> Result<Finding, Error> {
    let death = &trial.plain.death;
    let told = &death.farewell;
    let times = [
        ("cpu_s", told.cpu_s),
        ("solve_wall_s", told.solve_wall_s),
        ("setup_wall_s", told.setup_wall_s),
        ("wait_s", told.wait_s),
    ];
    if let Some((name, value)) = times.iter().find(|(_, value)| exceeds(-value, 0.0)) {
        return Ok(broken(format!("its {name} is {value}")));
    }
    let walls: f64 = times[1..].iter().map(|(_, value)| value).sum();
    let lived = death.lived.as_secs_f64();
    let said = format!("solve, set-up and wait take {walls:.3} s of {lived:.3} s");
    Ok(if walls <= lived + CLOCKS_S {
        holds(said)
    } else {
        broken(said)
    })
}

/// A request that cannot be followed: its name, and how it is made.
type Nonsense<'t> = (&'static str, &'t dyn Fn(&mut Launch) -> Result<(), Error>);

/// Requests that cannot be followed.
pub fn faults(trial: &RuleTrial) -> Result<Finding, Error> {
    let load = trial.loads.of_window(0, 0);
    let short = &load[..load.len().saturating_sub(1)];
    let poisoned: Vec<f64> = load.iter().map(|_| f64::NAN).collect();
    let ask = |life: &mut Launch, load: &[f64]| life.ask(&life.window(0), load).map(|_| ());
    let unknown_set = |life: &mut Launch| life.couple("no such set").map(|_| ());
    let short_load = |life: &mut Launch| ask(life, short);
    let no_numbers = |life: &mut Launch| ask(life, &poisoned);
    let damaged = |life: &mut Launch| {
        let state = life.checkpoint()?;
        let bytes = state.bytes().map_err(Refusal::from)?;
        let place = life.place();
        life.restore(
            &Frame::with_bytes(state.header, &bytes[..bytes.len() / 2]),
            &place,
        )
    };
    let mut all: Vec<Nonsense> = vec![("a set that it does not have", &unknown_set)];
    if trial.subject.part != Part::Alone {
        all.push(("a load that is a component short", &short_load));
        all.push(("a load of NaN", &no_numbers));
    }
    if trial.subject.told.capabilities.resume {
        all.push(("half of a checkpoint", &damaged));
    }
    for (what, request) in &all {
        let mut life = trial.begin()?;
        let answered = request(&mut life);
        let Some(_) = life.fault() else {
            return Ok(broken(match answered {
                Ok(()) => format!("{what} was answered as if nothing were"),
                Err(error) => format!("{what} was not answered with a `Fault`: {error}"),
            }));
        };
        if life.process().is_some_and(|it| !it.ends_within(GRACE)) {
            return Ok(broken(format!(
                "after {what} and its `Fault` it did not end"
            )));
        }
    }
    let names: Vec<&str> = all.iter().map(|(what, _)| *what).collect();
    Ok(holds(names.join(", ")))
}

/// Ends: asked to, after a farewell, and when the coordinator has gone.
pub fn shutdown(trial: &RuleTrial) -> Result<Finding, Error> {
    let mut life = trial.begin()?;
    let Some(process) = life.process() else {
        return Ok(not_tested("it is no process of its own"));
    };
    process.ask_to_end();
    if !process.ends_within(GRACE) {
        return Ok(broken("it lives on a second after SIGTERM"));
    }
    let mut life = trial.begin()?;
    life.finish()?;
    if life.process().is_some_and(|it| !it.ends_within(GRACE)) {
        return Ok(broken("it lives on a second after its farewell"));
    }
    let mut life = trial.begin()?;
    life.hang_up();
    if life.process().is_some_and(|it| !it.ends_within(NOTICE)) {
        return Ok(broken(format!(
            "it lives on {} s after the coordinator has closed the connection",
            NOTICE.as_secs()
        )));
    }
    Ok(holds(
        "after SIGTERM, after its farewell, and when the coordinator has gone",
    ))
}
