//! The rules of the wire, tried on one participant, one by one (`thirdbody conform`).
//!
//! The participant is launched as in a run of its scenario, with its configuration, sets and windows, but all requests come from
//! here: windows under small loads that are the same in each life. One *plain* life is asked for each window once; the others are
//! asked twice, early, under another load first, for fields or for a checkpoint in between, and must answer with the bits of
//! the plain one. What has no such twin is compared with what the wire page says: work, columns, velocities of a boundary.
//!
//! - [`rule`]: the rules by name, and the outcome of each;
//! - [`subject`]: the participant with its part; [`launch`]: one launch of it; [`load`]: its loads; [`plain`]: the plain life;
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
pub mod subject;

use kit::keys::proposal;
use protocol::Cause;

use coordinator::error::{Code, Error, Refusal};
use coordinator::scenario::Participant;
use coordinator::scenario::load::Loaded;
use joined::joins;
use launch::Launch;
use plain::RuleTrial;
use rule::{ConformRow, Finding, Rule, RuleVerdict};
use subject::{ConformOptions, Part, ScenarioLauncher, TestedParticipant};

/// A rule, the parts that it concerns, and how it is tried.
type Test = (
    Rule,
    &'static [Part],
    fn(&RuleTrial) -> Result<Finding, Error>,
);

const ALL: &[Part] = &[Part::Alone, Part::ForceDriven, Part::MotionDriven];
const JOINED: &[Part] = &[Part::ForceDriven, Part::MotionDriven];
const FORCE: &[Part] = &[Part::ForceDriven];
const MOTION: &[Part] = &[Part::MotionDriven];

/// In this order: lives that end before their time come last.
const TESTS: [Test; 23] = [
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

/// Tries a participant of a scenario, or another program in its place. `seen` is told of each rule as it is tried.
pub fn conform(
    loaded: &Loaded,
    name: &str,
    command: Option<&[String]>,
    options: &ConformOptions,
    mut seen: impl FnMut(&ConformRow),
) -> Result<Vec<ConformRow>, Error> {
    let participant = conforming(loaded, name, command)?;
    refuse_unknown_rules(&options.only)?;
    let wanted =
        |rule: Rule| options.only.is_empty() || options.only.iter().any(|word| word == rule.word());
    let mut table = Table {
        rows: Vec::new(),
        seen: &mut seen,
    };
    let stage = ScenarioLauncher::new(loaded, options);
    let greeted = table.tried(Rule::Greeting, stage.launch(&participant, 1))?;
    let Some((peers, greeted)) = greeted else {
        return Ok(table.rows);
    };
    drop(peers);
    let subject = TestedParticipant::new(&stage, &participant, greeted.description)?;
    let software = format!("{} ({})", subject.told.software, subject.told.kind);
    table.add(Rule::Greeting, rule::holds(software));
    let Some(life) = table.tried(Rule::Surface, Launch::new(&subject, 1))? else {
        return Ok(table.rows);
    };
    let points = life.surface.len();
    drop(life);
    table.add(Rule::Surface, rule::holds(format!("{points} points")));
    if wanted(Rule::Joins)
        && let Some(found) = table.tried(Rule::Joins, joins(&subject))?
    {
        table.add(Rule::Joins, found);
    }
    let Some(trial) = table.tried(Rule::Frames, RuleTrial::new(&subject))? else {
        return Ok(table.rows);
    };
    let concern = TESTS.into_iter();
    let concern = concern.filter(|(_, parts, _)| parts.contains(&subject.part));
    for (rule, _, test) in concern.filter(|(rule, ..)| wanted(*rule)) {
        if let Some(found) = table.tried(rule, test(&trial))? {
            table.add(rule, found);
        }
    }
    for rule in [Rule::Frames, Rule::Finite, Rule::Lives] {
        if table.rows.iter().all(|row| row.rule != rule.word()) {
            table.add(rule, rule::holds("in all lives"));
        }
    }
    Ok(table.rows)
}

/// Refuses names that no rule has.
fn refuse_unknown_rules(only: &[String]) -> Result<(), Error> {
    let mut known: Vec<&str> = TESTS.iter().map(|(rule, ..)| rule.word()).collect();
    known.push(Rule::Joins.word());
    known.dedup();
    let Some(word) = only.iter().find(|word| !known.contains(&word.as_str())) else {
        return Ok(());
    };
    let problem = format!("no such rule; {}", proposal(word, "rules", &known));
    Err(Refusal::argument(format!("--only {word}"), problem).into())
}

/// The participant of this name, or another program in its place.
pub fn conforming(
    loaded: &Loaded,
    name: &str,
    command: Option<&[String]>,
) -> Result<Participant, Error> {
    let participants = &loaded.scenario.participant;
    let found = participants.iter().find(|one| one.name == name);
    let mut participant = found.cloned().ok_or_else(|| {
        let known: Vec<&str> = participants.iter().map(|p| p.name.as_str()).collect();
        Refusal::NoParticipant {
            name: name.into(),
            known: known.join(", "),
        }
    })?;
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
    fn add(&mut self, rule: Rule, (verdict, why): Finding) {
        let row = ConformRow {
            rule: rule.word(),
            verdict,
            why,
        };
        (self.seen)(&row);
        self.rows.push(row);
    }

    /// The value of a trial that came to its end. An error that is the participant's is entered under the rule that it breaks; one
    /// that is not is returned.
    fn tried<T>(&mut self, rule: Rule, result: Result<T, Error>) -> Result<Option<T>, Error> {
        let error = match result {
            Ok(value) => return Ok(Some(value)),
            Err(error) => error,
        };
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
            _ => rule,
        };
        if breaks != rule {
            let why = format!("it breaks the rule `{}`", breaks.word());
            self.add(rule, rule::not_tested(why));
        }
        let known =
            |row: &&ConformRow| row.rule == breaks.word() && row.verdict == RuleVerdict::Broken;
        if self.rows.iter().find(known).is_none() {
            self.add(breaks, rule::broken(error.to_string()));
        }
        Ok(None)
    }
}
