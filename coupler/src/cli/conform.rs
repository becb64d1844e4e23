//! `thirdbody conform`: tests one participant against the rules of the protocol.

use super::common::{VerbResult, own_program, print};
use super::start::listen;
use coordinator::participants::Registry;
use coordinator::run::check::check;
use lab::conform::rule::{ConformRow, RuleVerdict};
use lab::conform::tested::ConformOptions;
use lab::conform::{all_hold, conform as try_rules};
use scenario::error::CHECK_FAILED;
use scenario::load::load;
use terminal::print_note;

/// Arguments of `conform`.
#[derive(Debug, clap::Args)]
pub struct ConformArguments {
    /// Scenario: a folder with scenario.toml, a file, a name under scenarios/, or a name from `thirdbody scenes`.
    #[arg(long)]
    scenario: String,
    /// Name of the participant in the scenario.
    #[arg(long)]
    participant: String,
    /// Override a key of the scenario; repeatable.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// Test only this rule; repeatable.
    #[arg(long, value_name = "RULE")]
    only: Vec<String>,
    /// Print the rows as JSON.
    #[arg(long)]
    json: bool,
    /// Program and arguments that replace the participant, started in the folder of the scenario.
    #[arg(last = true)]
    command: Vec<String>,
}

/// Tests all rules; exit code 8 if one is broken.
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
    // A failed print is ignored here: the print at the end then fails too and returns the error.
    let seen = |row: &ConformRow| {
        let text = line(row);
        if arguments.json {
            print_note(&text);
        } else {
            let _ = print(&text);
        }
    };
    let rows = try_rules(&loaded, &arguments.participant, command, &options, seen)?;
    let broken = rows.iter().filter(|row| row.verdict == RuleVerdict::Broken);
    let broken: Vec<String> = broken.map(|row| row.rule.to_string()).collect();
    print(&match (arguments.json, &broken[..]) {
        (true, _) => serde_json::json!({ "results": rows }).to_string(),
        (false, []) => format!(
            "`{}` breaks none of the tested rules",
            arguments.participant
        ),
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
