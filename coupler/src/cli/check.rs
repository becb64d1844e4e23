//! `thirdbody check`: everything that can be said before a run.

use super::common::{ScenarioArguments, VerbResult, foreign, own_program, print};
use crate::participants::Registry;
use crate::run::forecast::Forecast;
use crate::run::session::check as check_scenario;
use crate::scenario::load::Loaded;

/// Arguments of `check`.
#[derive(Debug, clap::Args)]
pub struct CheckArguments {
    #[command(flatten)]
    scenario: ScenarioArguments,
    /// Start nothing: leave out the prediction of stability, which needs the solvers' own words.
    #[arg(long)]
    no_start: bool,
    /// Start programs that the scenario names, too.
    #[arg(long)]
    allow_commands: bool,
}

/// Checks a scenario; an error has exit code 2.
pub fn check(arguments: &CheckArguments, registry: &Registry) -> VerbResult {
    let loaded = arguments.scenario.load()?;
    let warnings = check_scenario(&loaded, registry, arguments.scenario.threads())?;
    print(&describe(&loaded))?;
    for warning in warnings {
        print(&warning.line())?;
    }
    if loaded.scenario.interface.is_empty() || arguments.no_start {
        return Ok(0);
    }
    if let Some((name, _)) = foreign(&loaded.scenario)
        && !arguments.allow_commands
    {
        print(&format!(
            "stability: not predicted, participant {name} is a program of its own; --allow-commands starts it"
        ))?;
        return Ok(0);
    }
    let forecast = Forecast {
        loaded: &loaded,
        registry,
        program: own_program()?,
        threads: arguments.scenario.threads(),
    };
    for line in forecast.lines()? {
        print(&line)?;
    }
    Ok(0)
}

fn describe(loaded: &Loaded) -> String {
    let scenario = &loaded.scenario;
    let (name, hash) = (&scenario.run.name, &loaded.hash);
    let mut lines = vec![format!("{name}: valid, scenario {hash}")];
    for participant in &scenario.participant {
        let (name, kind) = (&participant.name, &participant.kind);
        let command = match &participant.command {
            None => format!("thirdbody node {kind}"),
            Some(words) => words.join(" "),
        };
        lines.push(format!("participant {name} ({kind}): {command}"));
    }
    for interface in &scenario.interface {
        let ([a, b], scheme) = (&interface.between, interface.scheme.word());
        lines.push(format!(
            "interface {}: {a} <-> {b}, {scheme:?}, {} substeps a window, gap within {:.1e} node spacings",
            interface.name, interface.substeps, interface.tolerance_rel
        ));
    }
    if scenario.interface.is_empty() {
        lines.push("no interface: the solver runs alone".into());
    }
    lines.join("\n")
}
