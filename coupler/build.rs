//! Names the build: a hash of all sources that can change a bit of a run, of the locked dependencies and the compiler, and what git
//! says of them.

use std::collections::hash_map::DefaultHasher;
use std::env;
use std::fs;
use std::hash::{Hash, Hasher};
use std::path::{Path, PathBuf};
use std::process::Command;

use paths::paths;

#[path = "scenes/paths.rs"]
mod paths;

/// What a run is made of, from the folder of this crate. Scenes are no part of it, for the hash of a scenario tells them apart; nor is
/// what reads runs that have ended.
const SOURCES: [&str; 13] = [
    "../protocol/src",
    "../protocol/kit/src",
    "../fem-node/kernel/src",
    "../fem-node/src",
    "../dem-node/kernel/src",
    "../dem-node/src",
    "scheme/src",
    "exchange-log/src",
    "coordinator/src",
    "scenario/src",
    "runs/src",
    "../Cargo.lock",
    "../Cargo.toml",
];

fn main() {
    let mut hasher = DefaultHasher::new();
    for source in SOURCES {
        println!("cargo::rerun-if-changed={source}");
        files(Path::new(source)).hash(&mut hasher);
    }
    println!("cargo::rerun-if-env-changed=THIRDBODY_GIT");
    let compiler = env::var("RUSTC").unwrap_or_else(|_| "rustc".into());
    words(&compiler, &["--version", "--verbose"]).hash(&mut hasher);
    for variable in ["PROFILE", "OPT_LEVEL", "TARGET", "CARGO_ENCODED_RUSTFLAGS"] {
        env::var(variable).ok().hash(&mut hasher);
    }
    println!("cargo::rustc-env=THIRDBODY_BUILD={:016x}", hasher.finish());
    let git = env::var("THIRDBODY_GIT").ok();
    let git = git.or_else(|| words("git", &["describe", "--always", "--dirty", "--abbrev=12"]));
    let git = git.unwrap_or_else(|| "unknown".into());
    println!("cargo::rustc-env=THIRDBODY_GIT={git}");
}

/// All files of a folder, or the file itself, with their contents, by name.
fn files(path: &Path) -> Vec<(PathBuf, Vec<u8>)> {
    let read = |path: PathBuf| {
        let content = fs::read(&path).unwrap_or_default();
        (path, content)
    };
    paths(path).into_iter().map(read).collect()
}

/// The first words that a command prints, if there is such a command and it succeeds.
fn words(command: &str, arguments: &[&str]) -> Option<String> {
    let output = Command::new(command).args(arguments).output().ok()?;
    let text = String::from_utf8(output.stdout).ok()?;
    let text = text.trim().replace('\n', " ");
    (output.status.success() && !text.is_empty()).then_some(text)
}
