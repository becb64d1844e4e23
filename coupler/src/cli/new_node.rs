//! `thirdbody new-node`: a participant to start from.

use std::env;
use std::fs;
use std::path::PathBuf;

use clap::ValueEnum;

use super::common::{VerbResult, print};
use scenario::error::{Error, Refusal};

/// Arguments of `new-node`.
#[derive(Debug, clap::Args)]
pub struct NewNodeArguments {
    /// Language of the solver.
    language: Language,
    /// Name of the participant and of its folder: letters, digits, `-` and `_`, a letter first.
    name: String,
    /// Folder in which to create the participant's folder.
    #[arg(long, default_value = ".")]
    into: PathBuf,
    /// Folder of the crate `protocol`, for Rust (default: the one in the source tree around the current folder, or around this program).
    #[arg(long)]
    protocol: Option<PathBuf>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Language {
    /// A crate of its own: a rail, a bed of springs.
    Rust,
    /// A class for the package `thirdbody`: a rail, a bed of springs with dashpots (for grains see the manual, page `grains-in-python`).
    Python,
}

/// Files of the Rust skeleton, which is a shipped scene.
const RUST: [&str; 3] = ["Cargo.toml", "src/main.rs", "scenario.toml"];

/// Files of the Python skeleton, with their names in the new folder.
const PYTHON: [(&str, &str); 2] = [
    (
        "node.py",
        include_str!("../../../protocol/python/skeleton/node.py"),
    ),
    (
        "scenario.toml",
        include_str!("../../../protocol/python/skeleton/scenario.toml"),
    ),
];

/// Writes the files of a participant that runs as it is, and prints the next commands.
pub fn new_node(arguments: &NewNodeArguments) -> VerbResult {
    let name = &arguments.name;
    check(name)?;
    let folder = arguments.into.join(name);
    if folder.exists() {
        let problem = "exists already: give another name, or another folder with --into";
        return Err(Refusal::file(folder, problem).into());
    }
    let shipped = |file| Some((file, scenes::text(&format!("foreign/rust-bed/{file}"))?));
    let rust = RUST.into_iter().filter_map(shipped);
    let (files, old, protocol): (Vec<_>, _, _) = match arguments.language {
        Language::Rust => (rust.collect(), "rust-bed", Some(protocol(arguments)?)),
        Language::Python => (PYTHON.into(), "skeleton", None),
    };
    for (place, text) in files {
        let path = folder.join(place);
        let beside = path.parent().unwrap_or(&folder);
        fs::create_dir_all(beside).map_err(Error::output(beside.display()))?;
        let text = text.replace(old, name);
        let text = text.replace("../../../protocol", protocol.as_deref().unwrap_or_default());
        fs::write(&path, text).map_err(Error::output(path.display()))?;
        print(&path.display().to_string())?;
    }
    let folder = folder.display();
    print("next:")?;
    if protocol.is_some() {
        print(&format!(
            "  cargo build --release --manifest-path {folder}/Cargo.toml"
        ))?;
    }
    print(&format!(
        "  thirdbody conform --scenario {folder} --participant rail\n  thirdbody run {folder}"
    ))
}

/// Refuses a name that a crate or a folder cannot have.
fn check(name: &str) -> Result<(), Error> {
    let plain = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
    if name.starts_with(|c: char| c.is_ascii_alphabetic()) && name.chars().all(plain) {
        return Ok(());
    }
    let problem = "is no name for a participant: use letters, digits, `-` and `_`, a letter first";
    Err(Refusal::argument(name, problem).into())
}

/// The absolute path of the crate `protocol`.
fn protocol(arguments: &NewNodeArguments) -> Result<String, Error> {
    let Some(folder) = arguments.protocol.clone().or_else(nearby) else {
        let problem = "a solver in Rust needs the crate `protocol`, and there is no source tree around this folder or this program: give the folder of that crate";
        return Err(Refusal::argument("--protocol", problem).into());
    };
    let whole = folder.canonicalize().ok();
    let whole = whole.filter(|folder| folder.join("Cargo.toml").is_file());
    let found = whole.and_then(|folder| folder.to_str().map(String::from));
    found.ok_or_else(|| {
        let problem = "is not the crate `protocol`: give its folder with --protocol";
        Refusal::file(folder, problem).into()
    })
}

/// The crate `protocol` of a source tree around this folder, or around this program.
fn nearby() -> Option<PathBuf> {
    let places = [env::current_dir(), env::current_exe()];
    let places: Vec<PathBuf> = places.into_iter().flatten().collect();
    let above = places.iter().flat_map(|place| place.ancestors());
    let mut crates = above.map(|folder| folder.join("protocol"));
    let files = ["Cargo.toml", "WIRE.md"];
    crates.find(|found| files.iter().all(|file| found.join(file).is_file()))
}
