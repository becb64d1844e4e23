//! `thirdbody scenes`: the scenes and studies inside this program.

use super::common::{VerbResult, print_rows};
use scenes::listing::{Listed, listing};

/// Arguments of `scenes`.
#[derive(Debug, clap::Args)]
pub struct ScenesArguments {
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

/// Lists them, smallest first, as the manual does.
pub fn scenes(arguments: &ScenesArguments) -> VerbResult {
    print_rows(&listing()[..], arguments.json, table)?;
    Ok(0)
}

fn table(listed: &[Listed]) -> String {
    let mut lines: Vec<String> = listed.iter().map(entry).collect();
    lines.push("thirdbody run NAME runs one (studies: study run NAME); thirdbody new NAME copies it into a folder of your own".into());
    lines.join("\n")
}

fn entry(one: &Listed) -> String {
    let needs = match one.starts.first() {
        None => String::new(),
        Some(program) if program.starts_with("python") => {
            format!("; starts {program}, which needs the Python package thirdbody")
        }
        Some(program) => format!("; starts {program}, built in its folder of the source tree"),
    };
    format!("{} ({}{needs})\n    {}", one.name, one.time, one.shows)
}
