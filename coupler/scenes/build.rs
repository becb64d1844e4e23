//! Lists the files of the built-in scenes.

use std::env;
use std::fs;
use std::path::{Path, PathBuf};

use paths::paths;

mod paths;

/// Shipped scenes, from the folder of this crate.
const SCENES: &str = "../../scenarios";

/// Endings of the files that a scene or a study needs; pictures and tables beside them are results.
const NEEDED: [&str; 8] = ["toml", "msh", "json", "py", "rs", "lock", "c", "h"];

/// Folders that runs and builds leave there.
const LEFT: [&str; 3] = ["runs", "target", "__pycache__"];

/// Writes `shipped.rs`: the sorted names of the files below [`SCENES`], with their contents.
fn main() {
    let folder = fs::canonicalize(SCENES).expect("the source tree contains the scenes");
    // Folder by folder: a change of the manual beside them does not rebuild the program. A test finds new folders.
    for inside in fs::read_dir(&folder).into_iter().flatten().flatten() {
        if inside.path().is_dir() {
            println!("cargo::rerun-if-changed={}", inside.path().display());
        }
    }
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
