//! Checks of a scenario that need no solver: names and joints.

use kit::ConfigError;
use kit::keys::{config_error, proposal, refuse_if};
use protocol::Cause;
use scheme::keys::connected;

use crate::keys::{Participant, Scenario, TransportKind};
use scheme::keys::{CompliancePrior, Dirichlet, Interface, SchemeWord};

/// Stops at the first failure.
pub(super) fn check(scenario: &Scenario) -> Result<(), ConfigError> {
    let run = &scenario.run;
    plain_name("run.name", &run.name)?;
    run.plausible.check("run.plausible")?;
    refuse_if(
        run.checkpoint_every_windows.is_some_and(|every| every > 0) && !run.output.exchange,
        "run.checkpoint_every_windows",
        "a resumed run continues the log of the first run, but run.output.exchange is false",
        "set run.output.exchange = true, or write no checkpoints",
    )?;
    check_participants(&scenario.participant)?;
    check_launches(scenario)?;
    match (scenario.participant.len(), scenario.interface.as_slice()) {
        (1, []) => Ok(()),
        (count, []) => {
            let problem = format!("{count} participants, and no interface joins them");
            let help = "add [[interface]], or keep one participant, which runs alone";
            refuse("interface", Cause::MissingKey, problem, Some(help))
        }
        (_, interfaces) => check_interfaces(scenario, interfaces),
    }
}

fn check_interfaces(scenario: &Scenario, interfaces: &[Interface]) -> Result<(), ConfigError> {
    for (index, interface) in interfaces.iter().enumerate() {
        check_interface(scenario, interface, index)?;
        for before in &interfaces[..index] {
            check_two_interfaces(before, interface, index)?;
        }
    }
    for (index, participant) in scenario.participant.iter().enumerate() {
        let joined = |interface: &Interface| interface.participants().contains(&&*participant.name);
        if !interfaces.iter().any(joined) {
            let problem = format!("no interface joins `{}`", participant.name);
            let help = "add an [[interface]] with one of its sets, or run it alone";
            let key = format!("participant[{index}].name");
            return refuse(&key, Cause::MissingKey, problem, Some(help));
        }
    }
    for group in connected(&scenario.interface) {
        for index in &group[1..] {
            check_one_solution(&interfaces[group[0]], &interfaces[*index], *index)?;
        }
    }
    Ok(())
}

/// A name belongs to one interface, and a pair of sets too. One set may carry several layers, see `scheme::join`.
fn check_two_interfaces(
    before: &Interface,
    interface: &Interface,
    index: usize,
) -> Result<(), ConfigError> {
    if before.name == interface.name {
        let (key, name) = (format!("interface[{index}].name"), &interface.name);
        let problem = format!("the name `{name}` is taken by another interface");
        let help = "give each interface a name of its own";
        return refuse(&key, Cause::DuplicateName, problem, Some(help));
    }
    let mut sides = interface.between.iter();
    if !sides.all(|side| before.between.contains(side)) {
        return Ok(());
    }
    let (name, [a, b]) = (&before.name, &interface.between);
    let problem = format!("`{a}` and `{b}` are already joined by the interface `{name}`");
    let help = "name another set of one of them, or remove the interface";
    let key = format!("interface[{index}].between");
    refuse(&key, Cause::SetCoupledTwice, problem, Some(help))
}

/// Connected interfaces are solved together, so they need the same value of each key of the solution.
fn check_one_solution(
    first: &Interface,
    interface: &Interface,
    index: usize,
) -> Result<(), ConfigError> {
    let (ours, theirs) = (interface.given(), first.given());
    let policy = interface.on_not_converged;
    let agree = [
        ("scheme", ours.scheme == theirs.scheme),
        ("dirichlet", ours.dirichlet() == theirs.dirichlet()),
        ("repeats_max", ours.repeats_max() == theirs.repeats_max()),
        ("compliance", ours.compliance() == theirs.compliance()),
        ("acceleration", ours.acceleration() == theirs.acceleration()),
        ("relaxation", ours.relaxation() == theirs.relaxation()),
        ("on_not_converged", policy == first.on_not_converged),
    ];
    agree.iter().find(|(_, same)| !same).map_or(Ok(()), |(key, _)| {
        let problem = format!(
            "differs from the value of the interface `{}`, which is connected through participants and solved together with `{}`",
            first.name, interface.name
        );
        let (key, help) = (format!("interface[{index}].{key}"), "give both the same value");
        refuse(&key, Cause::ConflictingKeys, problem, Some(help))
    })
}

fn check_participants(participants: &[Participant]) -> Result<(), ConfigError> {
    if participants.is_empty() {
        let problem = "a run needs at least one participant";
        let help = "add [[participant]] with name, kind and config";
        return refuse("participant", Cause::MissingKey, problem, Some(help));
    }
    for (index, participant) in participants.iter().enumerate() {
        let (key, name) = (format!("participant[{index}].name"), &participant.name);
        plain_name(&key, name)?;
        refuse_taken(&key, name, &participants[..index])?;
    }
    Ok(())
}

/// Refuses a launcher for a participant whose transport does not reach other hosts.
fn check_launches(scenario: &Scenario) -> Result<(), ConfigError> {
    for (index, participant) in scenario.participant.iter().enumerate() {
        let key = format!("participant[{index}].launch");
        refuse_if(
            participant.launch.is_some() && scenario.transport(participant) != TransportKind::Zenoh,
            &key,
            "starts the participant on another host, which shared memory does not reach",
            "set its transport = \"zenoh\"",
        )?;
    }
    Ok(())
}

/// Refuses the name of an earlier participant or of a part of the program.
fn refuse_taken(key: &str, name: &str, before: &[Participant]) -> Result<(), ConfigError> {
    let by = match name {
        _ if before.iter().any(|other| other.name == name) => "another participant",
        "coupler" | "coordinator" => "a part of the program itself",
        _ => return Ok(()),
    };
    let problem = format!("the name `{name}` is taken by {by}");
    let help = "give each participant a name of its own: messages, logs and interfaces go by it";
    refuse(key, Cause::DuplicateName, problem, Some(help))
}

fn check_interface(
    scenario: &Scenario,
    interface: &Interface,
    index: usize,
) -> Result<(), ConfigError> {
    let key = |name: &str| format!("interface[{index}].{name}");
    plain_name(&key("name"), &interface.name)?;
    let given = interface.given();
    if interface.substeps.is_none() && interface.window_s.is_none() {
        return Err(config_error(&key(""), "missing field `substeps`"));
    }
    refuse_if(
        given.scheme == SchemeWord::Velocity && given.compliance == Some(CompliancePrior::Mass),
        &key("compliance"),
        "scheme = \"velocity\" uses the continuum's own impedance, not masses",
        "remove the key, or take scheme = \"dual-schur-secant\"",
    )?;
    refuse_if(
        given.dirichlet == Some(Dirichlet::ForceDriven)
            && interface.scheme().dirichlet() != Dirichlet::ForceDriven,
        &key("dirichlet"),
        "the scheme solves force and motion of both sides at once, so neither side follows the other",
        "remove the key, or take scheme = \"fixed-point-serial\"",
    )?;
    check_between(scenario, interface, &key("between"))
}

/// Both sides are sets of participants, and of different ones.
fn check_between(scenario: &Scenario, interface: &Interface, key: &str) -> Result<(), ConfigError> {
    let participants = scenario.participant.iter();
    let names: Vec<&str> = participants.map(|p| p.name.as_str()).collect();
    for side in &interface.between {
        let Some((participant, _)) = side.split_once('.') else {
            let problem =
                format!("`{side}` must be written participant.set, for instance rail.top");
            return refuse(key, Cause::InvalidValue, problem, None);
        };
        if !names.contains(&participant) {
            let problem = format!("no participant is named `{participant}`");
            let help = proposal(participant, "participants", &names);
            return refuse(key, Cause::UnknownName, problem, Some(&help));
        }
    }
    let [one, other] = interface.participants();
    if one == other {
        let problem = "joins a participant with itself";
        let help = "let the second entry name a set of another participant";
        return refuse(key, Cause::InvalidValue, problem, Some(help));
    }
    Ok(())
}

/// A name that can be a file name on any system: letters, digits, `-` and `_`.
fn plain_name(key: &str, name: &str) -> Result<(), ConfigError> {
    let plain = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
    if name.chars().all(plain) && (1..=64).contains(&name.len()) && !name.starts_with('-') {
        return Ok(());
    }
    let problem = format!(
        "`{}` must be 1 to 64 letters, digits, `-` or `_`, not beginning with `-`: it becomes a file name",
        name.escape_debug()
    );
    refuse(key, Cause::InvalidValue, problem, None)
}

fn refuse(
    key: &str,
    cause: Cause,
    problem: impl Into<String>,
    help: Option<&str>,
) -> Result<(), ConfigError> {
    let mut error = ConfigError::new(key, problem).because(cause);
    error.help = help.map(String::from);
    Err(error)
}
