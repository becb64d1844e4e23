//! `thirdbody scenes`: the scenes and studies built into this program.

use std::collections::BTreeSet;

use kit::keys::proposal;

use super::common::{VerbResult, print_rows};
use scenario::error::Refusal;
use scenes::listing::{Listed, listing};

/// Arguments of `scenes`.
#[derive(Debug, clap::Args)]
pub struct ScenesArguments {
    /// List only entries with this tag: fem, dem, coupled, foreign, bonds, wear, wheel, rolling, plasticity, periodic, static, study.
    tag: Option<String>,
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

/// Lists scenes and studies by folder and name.
pub fn scenes(arguments: &ScenesArguments) -> VerbResult {
    let mut listed = listing();
    if let Some(tag) = &arguments.tag {
        let tags = listed.iter().flat_map(|one| &one.about.tags);
        let known: BTreeSet<&str> = tags.map(String::as_str).collect();
        if !known.contains(tag.as_str()) {
            let known = Vec::from_iter(known);
            let problem = format!("no entry has this tag; {}", proposal(tag, "tags", &known));
            return Err(Refusal::argument(format!("scenes {tag}"), problem).into());
        }
        listed.retain(|one| one.about.tags.contains(tag));
    }
    print_rows(&listed[..], arguments.json, table)
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
    format!(
        "{} ({}{needs})\n    {}",
        one.name, one.about.time, one.about.shows
    )
}
