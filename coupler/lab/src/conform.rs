//! Tests one participant against the rules of the protocol, one by one (`thirdbody conform`).
//!
//! The participant is launched as in a run of its scenario, with its configuration, sets and windows, but all requests come from here:
//! windows under small loads that are the same in each launch. One *plain* launch gets a request for each window once. Other launches get
//! a window twice, early, under another load first, or with fields or a checkpoint in between, and must answer with the bits of the plain
//! launch. Answers without such a twin are compared with WIRE.md: work, columns, velocities of a boundary.
//!
//! - [`rule`]: the rules by name, and the outcome of each;
//! - [`tested`]: the participant with its part; [`launch`]: one launch; [`load`]: the loads; [`plain`]: the plain launch;
//! - [`joined`], [`all_parts`], [`continuum`], [`layer`], [`ending`]: the trials.

pub mod all_parts;
pub mod continuum;
pub mod ending;
pub mod joined;
pub mod launch;
pub mod layer;
pub mod load;
pub mod plain;
pub mod rule;
pub mod tested;

use kit::keys::proposal;
use protocol::{Cause, Surface};

use crate::quiet::participant_index;
use joined::joins;
use launch::Launch;
use plain::RuleTrial;
use rule::{ConformRow, Rule, RuleFinding, RuleVerdict, Stop, broken};
use scenario::error::{Code, Error, Refusal};
use scenario::keys::Participant;
use scenario::load::Loaded;
use tested::{ConformOptions, Part, ScenarioLauncher, TestedParticipant};

/// A rule, the parts that it concerns, and its test.
type Test = (Rule, &'static [Part], fn(&RuleTrial) -> RuleFinding);

const ALL: &[Part] = &[Part::Alone, Part::ForceDriven, Part::MotionDriven];
const JOINED: &[Part] = &[Part::ForceDriven, Part::MotionDriven];
const FORCE: &[Part] = &[Part::ForceDriven];
const MOTION: &[Part] = &[Part::MotionDriven];

/// The tests in order; launches that end early come last.
const TESTS: [Test; 25] = [
    (Rule::SameBits, ALL, all_parts::same_bits),
    (Rule::Repeats, JOINED, all_parts::repeats),
    (Rule::Rollback, JOINED, all_parts::rollback),
    (Rule::Early, FORCE, continuum::early),
    (Rule::Increments, FORCE, continuum::increments),
    (Rule::Substeps, FORCE, continuum::substeps),
    (Rule::Passive, FORCE, continuum::passive),
    (Rule::Passive, MOTION, layer::passive),
    (Rule::Select, FORCE, continuum::select),
    (Rule::Columns, FORCE, continuum::columns),
    (Rule::Velocity, FORCE, continuum::velocity),
    (Rule::Boundary, MOTION, layer::boundary),
    (Rule::Convergence, MOTION, layer::convergence),
    (Rule::Heat, FORCE, continuum::heat),
    (Rule::Heat, MOTION, layer::heat),
    (Rule::Report, ALL, all_parts::report),
    (Rule::Work, JOINED, all_parts::work),
    (Rule::Balance, ALL, all_parts::balance),
    (Rule::Snapshot, ALL, all_parts::snapshot),
    (Rule::Checkpoint, ALL, all_parts::checkpoint),
    (Rule::Alone, JOINED, all_parts::alone),
    (Rule::Farewell, ALL, ending::farewell),
    (Rule::Times, ALL, ending::times),
    (Rule::Faults, ALL, ending::faults),
    (Rule::Shutdown, ALL, ending::shutdown),
];

/// Tests a participant of a scenario, or another program in its place. `seen` gets each row as soon as it is known.
pub fn conform(
    loaded: &Loaded,
    name: &str,
    command: Option<&[String]>,
    options: &ConformOptions,
    mut seen: impl FnMut(&ConformRow),
) -> Result<Vec<ConformRow>, Error> {
    let participant = conforming(loaded, name, command)?;
    refuse_unknown_rules(&options.only)?;
    let wanted = |rule: Rule| {
        options.only.is_empty() || options.only.iter().any(|word| *word == rule.to_string())
    };
    let mut table = Table {
        rows: Vec::new(),
        seen: &mut seen,
    };
    let launcher = ScenarioLauncher::new(loaded, options);
    let greeted = table.tried(Rule::Greeting, launcher.launch(&participant, 1))?;
    let Some((peers, greeted)) = greeted else {
        return Ok(table.rows);
    };
    drop(peers);
    let tested = TestedParticipant::new(&launcher, &participant, greeted.description)?;
    let description = &tested.description;
    let software = format!("{} ({})", description.software, description.kind);
    table.add(Rule::Greeting, RuleVerdict::Holds, software);
    let Some(launch) = table.tried(Rule::Surface, Launch::new(&tested, 1))? else {
        return Ok(table.rows);
    };
    let surface = weights(&tested, &launch.surface);
    drop(launch);
    table.enter(Rule::Surface, surface)?;
    if wanted(Rule::Joins) {
        table.enter(Rule::Joins, joins(&tested))?;
    }
    let Some(trial) = table.tried(Rule::Frames, RuleTrial::new(&tested))? else {
        return Ok(table.rows);
    };
    for (rule, parts, test) in TESTS {
        if parts.contains(&tested.part) && wanted(rule) {
            table.enter(rule, test(&trial))?;
        }
    }
    for rule in [Rule::Frames, Rule::Finite, Rule::Lives] {
        if table.rows.iter().all(|row| row.rule != rule) {
            table.add(rule, RuleVerdict::Holds, "in all lives".into());
        }
    }
    Ok(table.rows)
}

/// Counts the points of a participant, and checks that a continuum with its own step gives them masses.
fn weights(tested: &TestedParticipant, surface: &Surface) -> RuleFinding {
    let points = surface.len();
    let weightless = surface.mass_kg.iter().filter(|mass| **mass == 0.0).count();
    let moves = tested.part == Part::ForceDriven && tested.description.step_s.is_some();
    if moves && weightless > 0 {
        return broken(format!(
            "{weightless} of its {points} points have no mass, although it has a step of its own: give them their lumped masses, or no step_s if it is always in equilibrium"
        ));
    }
    Ok(format!("{points} points"))
}

/// Refuses names of unknown rules.
fn refuse_unknown_rules(only: &[String]) -> Result<(), Error> {
    let rules = TESTS.iter().map(|(rule, ..)| *rule).chain([Rule::Joins]);
    let mut known: Vec<String> = rules.map(|rule| rule.to_string()).collect();
    known.dedup();
    let Some(word) = only.iter().find(|word| !known.contains(word)) else {
        return Ok(());
    };
    let known: Vec<&str> = known.iter().map(String::as_str).collect();
    let problem = format!("no such rule; {}", proposal(word, "rules", &known));
    Err(Refusal::argument(format!("--only {word}"), problem).into())
}

/// The participant with this name, or another program in its place.
pub fn conforming(
    loaded: &Loaded,
    name: &str,
    command: Option<&[String]>,
) -> Result<Participant, Error> {
    let index = participant_index(&loaded.scenario, name)?;
    let mut participant = loaded.scenario.participant[index].clone();
    if let Some(command) = command {
        participant.command = Some(command.to_vec());
    }
    Ok(participant)
}

/// True if no rule is broken.
pub fn all_hold(rows: &[ConformRow]) -> bool {
    rows.iter().all(|row| row.verdict != RuleVerdict::Broken)
}

struct Table<'s> {
    rows: Vec<ConformRow>,
    seen: &'s mut dyn FnMut(&ConformRow),
}

impl Table<'_> {
    fn add(&mut self, rule: Rule, verdict: RuleVerdict, why: String) {
        let row = ConformRow { rule, verdict, why };
        (self.seen)(&row);
        self.rows.push(row);
    }

    /// Adds the outcome of a test.
    fn enter(&mut self, rule: Rule, finding: RuleFinding) -> Result<(), Error> {
        match finding {
            Ok(why) => self.add(rule, RuleVerdict::Holds, why),
            Err(Stop::Verdict(verdict, why)) => self.add(rule, verdict, why),
            Err(Stop::Failed(error)) => self.failed(rule, error)?,
        }
        Ok(())
    }

    /// The value of a result; adds its error to the table.
    fn tried<T>(&mut self, rule: Rule, result: Result<T, Error>) -> Result<Option<T>, Error> {
        match result {
            Ok(value) => Ok(Some(value)),
            Err(error) => self.failed(rule, error).map(|()| None),
        }
    }

    /// Adds an error of the participant under the rule that it breaks; returns any other error.
    fn failed(&mut self, rule: Rule, error: Error) -> Result<(), Error> {
        let breaks = match &error {
            Error::Interrupted { .. } | Error::Input { .. } | Error::Scenario(_) => {
                return Err(error);
            }
            error if error.code() == Code::Of(Cause::ProtocolViolated) => match rule {
                Rule::Greeting | Rule::Surface => rule,
                _ => Rule::Frames,
            },
            Error::NotFinite(_) => Rule::Finite,
            Error::PeerLost { .. } | Error::Deadline { .. } => Rule::Lives,
            Error::Fault { .. } if rule == Rule::Frames => Rule::Lives,
            _ => rule,
        };
        if breaks != rule {
            let why = format!("it breaks the rule `{breaks}`");
            self.add(rule, RuleVerdict::NotTested, why);
        }
        let known = |row: &ConformRow| row.rule == breaks && row.verdict == RuleVerdict::Broken;
        if !self.rows.iter().any(known) {
            self.add(breaks, RuleVerdict::Broken, error.to_string());
        }
        Ok(())
    }
}
