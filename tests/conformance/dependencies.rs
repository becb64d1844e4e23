//! Dependencies run one way: a crate depends only on lower layers, and the solvers and the coupler share only the protocol and `kit`.
//! Only the composition root names the shipped solvers.

use std::path::{Path, PathBuf};
use std::process::Command;

use harness::source::product_crates;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// Members of this workspace below `package` in the tree of normal dependencies.
fn members_below(package: &str) -> Vec<String> {
    let output = Command::new(env!("CARGO"))
        .args([
            "tree",
            "--offline",
            "--edges",
            "normal",
            "--prefix",
            "none",
            "--package",
            package,
        ])
        .current_dir(root())
        .output()
        .expect("cargo starts");
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    let members: Vec<String> = product_crates().into_iter().map(|(name, _)| name).collect();
    let mut found: Vec<String> = text
        .lines()
        .filter_map(|line| line.split(' ').next())
        .map(String::from)
        .filter(|name| members.contains(name) && name != package)
        .collect();
    found.sort();
    found.dedup();
    found
}

fn sources(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).expect("it is there").flatten() {
        let path = entry.path();
        match path.is_dir() {
            true => found.extend(sources(&path)),
            false if path.extension().is_some_and(|ending| ending == "rs") => found.push(path),
            false => {}
        }
    }
    found
}

/// Members below each crate, in the order of the layers: enter new dependencies here.
#[test]
fn each_crate_knows_only_lower_layers() {
    let wire = ["protocol"];
    let shared = ["kit", "protocol"];
    let fem = ["fem-kernel", "kit", "protocol"];
    let dem = ["dem-kernel", "kit", "protocol"];
    let log = ["exchange-log", "kit", "protocol", "scenes", "scheme"];
    let with = |below: &[&'static str], more: &[&'static str]| {
        let mut all = [below, more].concat();
        all.sort_unstable();
        all
    };
    let keys = with(&log, &["scenario"]);
    let files = with(&keys, &["runs"]);
    let drawn = with(&files, &["draw"]);
    let said = with(&files, &["coordinator"]);
    let run = with(&drawn, &["coordinator", "terminal"]);
    let judged = with(&run, &["report", "study"]);
    for (package, below) in [
        ("protocol", &[] as &[&str]),
        ("kit", &wire),
        ("fem-kernel", &shared),
        ("fem-node", &fem),
        ("dem-kernel", &shared),
        ("dem-node", &dem),
        ("scheme", &wire),
        ("exchange-log", &wire),
        ("scenes", &shared),
        ("draw", &[]),
        ("scenario", &log),
        ("runs", &keys),
        ("coordinator", &files),
        ("terminal", &said),
        ("report", &drawn),
        ("study", &run),
        ("lab", &judged),
    ] {
        assert_eq!(members_below(package), below, "{package}");
    }
}

#[test]
fn only_the_composition_root_names_the_solvers() {
    for path in sources(&root().join("coupler")) {
        let text = std::fs::read_to_string(&path).expect("it is text");
        let solvers = ["fem_kernel", "fem_node", "dem_kernel", "dem_node"];
        let names = solvers.iter().any(|solver| text.contains(solver));
        assert_eq!(
            names,
            path.ends_with("coupler/src/main.rs"),
            "{}",
            path.display()
        );
    }
}

#[test]
fn no_solver_names_another_room() {
    for (room, others) in [
        ("protocol", ["fem_", "dem_", "coupler::"]),
        ("fem-node/kernel", ["_node::", "dem_", "coupler::"]),
        ("fem-node", ["dem_", "coupler::", "harness"]),
        ("dem-node/kernel", ["_node::", "fem_", "coupler::"]),
        ("dem-node", ["fem_node", "coupler::", "harness"]),
    ] {
        for path in sources(&root().join(room).join("src")) {
            let text = std::fs::read_to_string(&path).expect("it is text");
            for other in others {
                assert!(!text.contains(other), "{} names {other}", path.display());
            }
        }
    }
}

/// The manifest of a folder of this workspace.
fn manifest(folder: &Path) -> toml::Table {
    let text = std::fs::read_to_string(folder.join("Cargo.toml")).expect("it is there");
    text.parse().expect("it is TOML")
}

/// A crate whose library is not tested in its own package is a target of `tests/unit`.
#[test]
fn every_crate_has_its_unit_tests_run() {
    let unit = root().join("tests/unit");
    let targets = manifest(&unit)["test"].as_array().expect("a list").clone();
    let paths = targets.iter().filter_map(|target| target["path"].as_str());
    let tested: Vec<PathBuf> = paths
        .map(|path| unit.join(path).canonicalize().expect("a library"))
        .collect();
    for (name, folder) in product_crates() {
        let manifest = manifest(&folder);
        let library = manifest.get("lib").and_then(|library| library.get("test"));
        let in_place = library.and_then(toml::Value::as_bool).unwrap_or(true);
        let path = folder.join("src/lib.rs").canonicalize();
        let elsewhere = tested.contains(&path.expect("a library"));
        assert!(in_place != elsewhere, "{name} is tested never or twice");
    }
}

/// Allowed licences: each dependency must offer one of them in each part of its expression.
const LICENCES: [&str; 13] = [
    "0BSD",
    "Apache-2.0",
    "BSD-2-Clause",
    "BSD-3-Clause",
    "BSL-1.0",
    "CC0-1.0",
    "CDLA-Permissive-2.0",
    "ISC",
    "MIT",
    "MPL-2.0",
    "Unicode-3.0",
    "Unlicense",
    "Zlib",
];

/// True if each part of an SPDX expression offers an allowed licence; exceptions only widen one.
fn is_allowed(expression: &str) -> bool {
    let plain = expression.replace(['(', ')'], "").replace('/', " OR ");
    plain.split(" AND ").all(|part| {
        let mut choices = part.split(" OR ").map(str::trim);
        choices.any(|choice| LICENCES.contains(&choice.split(" WITH ").next().unwrap_or(choice)))
    })
}

#[test]
fn every_crate_has_a_licence_that_we_may_ship() {
    // Not offline: crates of a feature that was not built yet are not here.
    let output = Command::new(env!("CARGO"))
        .args(["metadata", "--locked", "--format-version", "1"])
        .args(["--filter-platform", "x86_64-unknown-linux-gnu"])
        .current_dir(root())
        .output()
        .expect("cargo starts");
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{errors}");
    let metadata: serde_json::Value =
        serde_json::from_slice(&output.stdout).expect("cargo writes JSON");
    let packages = metadata["packages"].as_array().expect("a list");
    assert!(packages.len() > 100, "{}", packages.len());
    for package in packages {
        let licence = package["license"].as_str().unwrap_or_default();
        assert!(is_allowed(licence), "{}: `{licence}`", package["name"]);
    }
    assert!(!is_allowed("GPL-3.0-only") && !is_allowed("MIT AND GPL-2.0"));
}
