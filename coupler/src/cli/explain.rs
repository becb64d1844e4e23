//! `thirdbody explain`: cause and cure of an error or a warning.

use kit::keys::proposal;

use super::common::{VerbResult, print};
use coordinator::error::{Refusal, explanation, explanations};

/// Arguments of `explain`.
#[derive(Debug, clap::Args)]
pub struct ExplainArguments {
    /// Code in front of a message or in summary.json; all codes are listed without it.
    code: Option<String>,
}

/// Prints an entry of the page of causes and cures, or a line for each.
pub fn explain(arguments: &ExplainArguments) -> VerbResult {
    let Some(code) = &arguments.code else {
        for explanation in explanations() {
            print(&format!("{:24}{}", explanation.code, explanation.line()))?;
        }
        return Ok(0);
    };
    // As it stands in a message: error[unknown-key].
    let word = code
        .trim_start_matches("error[")
        .trim_end_matches([']', ':']);
    match explanation(word) {
        Some(explanation) => print(&format!("{}\n\n{}", explanation.code, explanation.text))?,
        None => {
            let codes: Vec<&str> = explanations().map(|explanation| explanation.code).collect();
            let problem = format!(
                "no error or warning has this code; {}",
                proposal(word, "codes", &codes)
            );
            return Err(Refusal::argument(format!("explain {word}"), problem).into());
        }
    }
    Ok(0)
}
