//! `thirdbody completions`: completions for a shell.

use clap_complete::Shell;

use super::common::{VerbResult, print};

/// Arguments of `completions`.
#[derive(Debug, clap::Args)]
pub struct CompletionsArguments {
    /// Shell that the completions are for; its manual says where it reads them.
    shell: Shell,
}

/// Prints the completions of a command.
pub fn completions(arguments: &CompletionsArguments, mut command: clap::Command) -> VerbResult {
    let name = command.get_name().to_string();
    let mut text = Vec::new();
    clap_complete::generate(arguments.shell, &mut command, name, &mut text);
    print(String::from_utf8_lossy(&text).trim_end())
}
