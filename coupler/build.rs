//! Names the build, a hash of all sources, the locked dependencies and the compiler, and what git says of them; and lists the
//! files of the shipped scenes for `shipped`.

use std::collections::hash_map::DefaultHasher;
use std::env;
use std::fs;
use std::hash::{Hash, Hasher};
use std::path::{Path, PathBuf};
use std::process::Command;

/// Everything that the program is made of, from the folder of this crate.
const SOURCES: [&str; 6] = [
    "../protocol/src",
    "../fem-node/src",
    "../dem-node/src",
    "src",
    "../Cargo.lock",
    "../Cargo.toml",
];

/// Shipped scenes, from the folder of this crate. They are no part of the build's name: the hash of a scenario tells scenes apart, and
/// a changed one leaves checkpoints and studies of others valid.
const SCENES: &str = "../scenarios";

/// Endings of the files that a scene or a study is run from; pictures and tables beside them are results.
const NEEDED: [&str; 7] = ["toml", "msh", "json", "py", "rs", "lock", "md"];

/// Folders that running and building leave there.
const LEFT: [&str; 3] = ["runs", "target", "__pycache__"];

fn main() {
    name_build();
    list_scenes();
}

fn name_build() {
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

/// Writes `shipped.rs`: the names of the files below [`SCENES`], in order, with their contents.
fn list_scenes() {
    println!("cargo::rerun-if-changed={SCENES}");
    let folder = fs::canonicalize(SCENES).expect("the scenes lie beside this crate");
    let needed = |path: &&PathBuf| {
        let inside = path.strip_prefix(&folder).unwrap_or(path);
        let mut above = inside.iter().filter_map(|part| part.to_str());
        let ending = path.extension().and_then(|ending| ending.to_str());
        ending.is_some_and(|ending| NEEDED.contains(&ending))
            && !above.any(|part| LEFT.contains(&part) || part.starts_with('.'))
    };
    let files = paths(&folder);
    let entries = files.iter().filter(needed).map(|path| {
        let name = path.strip_prefix(&folder).unwrap_or(path);
        format!("    ({name:?}, include_bytes!({path:?})),\n")
    });
    let text = format!("&[\n{}]\n", entries.collect::<String>());
    let out = env::var_os("OUT_DIR").expect("cargo sets it");
    fs::write(Path::new(&out).join("shipped.rs"), text).expect("cargo's folder is writable");
}

/// All files of a folder, or the file itself, with their contents, by name.
fn files(path: &Path) -> Vec<(PathBuf, Vec<u8>)> {
    let read = |path: PathBuf| {
        let content = fs::read(&path).unwrap_or_default();
        (path, content)
    };
    paths(path).into_iter().map(read).collect()
}

/// All files of a folder, or the file itself, by name.
fn paths(path: &Path) -> Vec<PathBuf> {
    if !path.is_dir() {
        return vec![path.into()];
    }
    let entries = fs::read_dir(path).into_iter().flatten().flatten();
    let mut below: Vec<PathBuf> = entries.map(|entry| entry.path()).collect();
    below.sort();
    below.iter().flat_map(|path| paths(path)).collect()
}

/// The first words that a command prints, if there is such a command and it succeeds.
fn words(command: &str, arguments: &[&str]) -> Option<String> {
    let output = Command::new(command).args(arguments).output().ok()?;
    let text = String::from_utf8(output.stdout).ok()?;
    let text = text.trim().replace('\n', " ");
    (output.status.success() && !text.is_empty()).then_some(text)
}
