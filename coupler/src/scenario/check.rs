//! Checks of a scenario that need no solver: ranges, names, and who is joined to whom.

use protocol::ConfigError;
use protocol::setting::proposal;

use super::{CompliancePrior, Dirichlet, Interface, Scenario, SchemeWord};

/// Stops at the first that fails.
pub(super) fn check(scenario: &Scenario) -> Result<(), ConfigError> {
    let run = &scenario.run;
    plain_name("run.name", &run.name)?;
    positive("run.thickness_m", run.thickness_m)?;
    if let Some(end) = run.end_s {
        positive("run.end_s", end)?;
    }
    let (deadlines, output) = (&run.deadlines, &run.output);
    positive("run.deadlines.setup_s", deadlines.setup_s)?;
    positive("run.deadlines.answer_s", deadlines.answer_s)?;
    positive("run.deadlines.idle_s", deadlines.idle_s)?;
    let every = output.signals_every_windows;
    at_least_one("run.output.signals_every_windows", every)?;
    let every = output.flush_every_windows;
    at_least_one("run.output.flush_every_windows", every)?;
    at_least_one("run.output.alone_steps", output.alone_steps.into())?;
    at_least_one("run.checkpoints_kept", run.checkpoints_kept)?;
    if run.checkpoint_every_windows.is_some_and(|every| every > 0) && !run.output.exchange {
        return Err(ConfigError::new(
            "run.checkpoint_every_windows",
            "a resumed run goes on with the log of the first, and run.output.exchange is false",
        )
        .help("let run.output.exchange be true, or write no checkpoints"));
    }
    check_participants(scenario)?;
    match (scenario.participant.len(), scenario.interface.as_slice()) {
        (1, []) => Ok(()),
        (count, []) => Err(ConfigError::new(
            "interface",
            format!("{count} participants and nothing that joins them"),
        )
        .help("add [[interface]], or keep one participant, which then runs alone")),
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
            return Err(ConfigError::new(
                &format!("participant[{index}].name"),
                format!("no interface joins `{}`", participant.name),
            )
            .help("add an [[interface]] with one of its sets, or run it alone"));
        }
    }
    for group in scenario.groups() {
        for index in &group[1..] {
            check_one_solution(&interfaces[group[0]], &interfaces[*index], *index)?;
        }
    }
    Ok(())
}

/// Names and sets belong to one interface.
fn check_two_interfaces(
    before: &Interface,
    interface: &Interface,
    index: usize,
) -> Result<(), ConfigError> {
    if before.name == interface.name {
        return Err(ConfigError::new(
            &format!("interface[{index}].name"),
            format!("the name `{}` is taken", interface.name),
        ));
    }
    match interface
        .between
        .iter()
        .find(|side| before.between.contains(side))
    {
        None => Ok(()),
        Some(set) => Err(ConfigError::new(
            &format!("interface[{index}].between"),
            format!(
                "`{set}` is joined by the interface `{}` already",
                before.name
            ),
        )
        .help("one interface carries a set: name another set of the participant")),
    }
}

/// Connected interfaces are solved together, so that they have one value of each key that says how.
fn check_one_solution(
    first: &Interface,
    interface: &Interface,
    index: usize,
) -> Result<(), ConfigError> {
    let (ours, theirs) = (interface.given, first.given);
    let agree = [
        ("scheme", ours.scheme == theirs.scheme),
        ("dirichlet", ours.dirichlet() == theirs.dirichlet()),
        ("repeats_max", ours.repeats_max() == theirs.repeats_max()),
        ("compliance", ours.compliance() == theirs.compliance()),
        ("acceleration", ours.acceleration() == theirs.acceleration()),
        ("relaxation", ours.relaxation() == theirs.relaxation()),
        (
            "on_not_converged",
            first.on_not_converged == interface.on_not_converged,
        ),
    ];
    match agree.iter().find(|(_, same)| !same) {
        None => Ok(()),
        Some((key, _)) => Err(ConfigError::new(
            &format!("interface[{index}].{key}"),
            format!(
                "differs from that of the interface `{}`, which is connected through participants and solved together with `{}`",
                first.name, interface.name
            ),
        )
        .help("give both the same value")),
    }
}

fn check_participants(scenario: &Scenario) -> Result<(), ConfigError> {
    if scenario.participant.is_empty() {
        return Err(ConfigError::new(
            "participant",
            "a run needs at least one participant",
        ));
    }
    for (index, participant) in scenario.participant.iter().enumerate() {
        let key = format!("participant[{index}].name");
        plain_name(&key, &participant.name)?;
        let twice = scenario.participant[..index]
            .iter()
            .any(|p| p.name == participant.name);
        if twice || participant.name == "coupler" || participant.name == "coordinator" {
            return Err(ConfigError::new(
                &key,
                format!("the name `{}` is taken", participant.name),
            ));
        }
        if participant
            .command
            .as_ref()
            .is_some_and(|command| command.is_empty())
        {
            return Err(ConfigError::new(
                &format!("participant[{index}].command"),
                "is empty: give the program and its arguments, or leave the key out",
            ));
        }
    }
    Ok(())
}

fn check_interface(
    scenario: &Scenario,
    interface: &Interface,
    index: usize,
) -> Result<(), ConfigError> {
    let key = |name: &str| format!("interface[{index}].{name}");
    plain_name(&key("name"), &interface.name)?;
    at_least_one(&key("substeps"), interface.substeps.into())?;
    let given = interface.given;
    if let Some(repeats) = given.repeats_max {
        at_least_one(&key("repeats_max"), repeats.into())?;
    }
    positive(&key("tolerance_rel"), interface.tolerance_rel)?;
    if let Some(relaxation) = given.relaxation {
        positive(&key("relaxation"), relaxation)?;
    }
    if let Some(bound) = interface.energy_defect_max_rel {
        positive(&key("energy_defect_max_rel"), bound)?;
    }
    if let Some(relaxation) = given.relaxation.filter(|relaxation| *relaxation > 1.0) {
        return Err(ConfigError::new(
            &key("relaxation"),
            format!("must be at most 1, got {relaxation}"),
        ));
    }
    if given.scheme == SchemeWord::Velocity && given.compliance == Some(CompliancePrior::Mass) {
        return Err(ConfigError::new(
            &key("compliance"),
            "scheme = \"velocity\" goes by the impedance that the continuum tells, not by masses",
        )
        .help("remove the key, or take scheme = \"dual-schur-secant\""));
    }
    if given.dirichlet == Some(Dirichlet::Continuum)
        && interface.scheme.dirichlet() != Dirichlet::Continuum
    {
        return Err(ConfigError::new(
            &key("dirichlet"),
            "the scheme gives both sides force and motion at once, so that neither follows the other",
        )
        .help("remove the key, or take scheme = \"fixed-point-serial\""));
    }
    let mut joined = Vec::new();
    for side in &interface.between {
        let names: Vec<&str> = scenario
            .participant
            .iter()
            .map(|p| p.name.as_str())
            .collect();
        let Some((participant, _)) = side.split_once('.') else {
            return Err(ConfigError::new(
                &key("between"),
                format!("`{side}` must be written participant.set, for instance rail.top"),
            ));
        };
        if !names.contains(&participant) {
            let error = ConfigError::new(
                &key("between"),
                format!("no participant is named `{participant}`"),
            );
            return Err(error.help(proposal(participant, "participants", &names)));
        }
        joined.push(participant);
    }
    if joined[0] == joined[1] {
        return Err(ConfigError::new(
            &key("between"),
            "joins a participant with itself",
        ));
    }
    Ok(())
}

fn positive(key: &str, value: f64) -> Result<(), ConfigError> {
    if value > 0.0 && value.is_finite() {
        return Ok(());
    }
    let problem = format!("must be a positive number, got {value}");
    Err(ConfigError::new(key, problem))
}

fn at_least_one(key: &str, value: u64) -> Result<(), ConfigError> {
    match value {
        0 => Err(ConfigError::new(key, "must be at least 1, got 0")),
        _ => Ok(()),
    }
}

/// A name that can be a file name on any system: letters, digits, `-` and `_`.
fn plain_name(key: &str, name: &str) -> Result<(), ConfigError> {
    let plain = name
        .chars()
        .all(|c| c.is_ascii_alphanumeric() || c == '-' || c == '_');
    if plain && !name.is_empty() && name.len() <= 64 {
        return Ok(());
    }
    let problem =
        format!("`{name}` must be 1 to 64 letters, digits, `-` or `_`: it becomes a file name");
    Err(ConfigError::new(key, problem))
}
