//! `thirdbody conform`: the rules of the wire, tried on one participant.

use super::common::{VerbResult, own_program, print};
use super::start::listen;
use coordinator::participants::Registry;
use coordinator::run::check::check;
use lab::conform::rule::{ConformRow, RuleVerdict};
use lab::conform::tested::ConformOptions;
use lab::conform::{all_hold, conform as try_rules};
use scenario::error::CHECK_FAILED;
use scenario::load::load;
use terminal::tell;

/// Arguments of `conform`.
#[derive(Debug, clap::Args)]
pub struct ConformArguments {
    /// A folder with scenario.toml, a file, a name under scenarios/, or one that `thirdbody scenes` lists.
    #[arg(long)]
    scenario: String,
    /// Name of the participant in the scenario.
    #[arg(long)]
    participant: String,
    /// Override a key of the scenario.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// Try this rule only; may be given more than once.
    #[arg(long, value_name = "RULE")]
    only: Vec<String>,
    /// Print the rows as JSON.
    #[arg(long)]
    json: bool,
    /// Program and arguments that take the place of the participant; they start in the folder of the scenario.
    #[arg(last = true)]
    command: Vec<String>,
}

/// Tries all rules; exit code 8 if one is broken.
pub fn conform(arguments: &ConformArguments, registry: &Registry) -> VerbResult {
    let loaded = load(&arguments.scenario, &arguments.set)?;
    if arguments.command.is_empty() {
        check(&loaded, registry, 1)?;
    }
    let options = ConformOptions {
        registry,
        program: own_program()?,
        watch: listen()?,
        only: arguments.only.clone(),
    };
    let command = Some(&arguments.command[..]).filter(|words| !words.is_empty());
    // A row that cannot be printed now cannot be printed at the end either, where that is an error.
    let seen = |row: &ConformRow| {
        let text = line(row);
        if arguments.json {
            tell(&text);
        } else {
            let _ = print(&text);
        }
    };
    let rows = try_rules(&loaded, &arguments.participant, command, &options, seen)?;
    let broken = rows.iter().filter(|row| row.verdict == RuleVerdict::Broken);
    let broken: Vec<String> = broken.map(|row| row.rule.to_string()).collect();
    print(&match (arguments.json, &broken[..]) {
        (true, _) => serde_json::json!({ "results": rows }).to_string(),
        (false, []) => format!("`{}` breaks no rule that was tried", arguments.participant),
        (false, _) => format!("`{}` breaks: {}", arguments.participant, broken.join(", ")),
    })?;
    Ok(if all_hold(&rows) { 0 } else { CHECK_FAILED })
}

fn line(row: &ConformRow) -> String {
    let verdict = match row.verdict {
        RuleVerdict::Holds => "holds",
        RuleVerdict::Broken => "BROKEN",
        RuleVerdict::NotOffered => "not offered",
        RuleVerdict::NotTested => "not tested",
    };
    format!("{:<12} {verdict:<12} {}", row.rule, row.why)
}
