//! Dependencies run one way: the solvers and the coupler's library know the protocol, and nobody else knows anybody.
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

/// Members below each, in the order of the layers: whoever names more has to be entered here.
#[test]
fn each_crate_knows_only_lower_layers() {
    let wire = ["protocol"];
    let shared = ["kit", "protocol"];
    let kernel = ["dem-kernel", "kit", "protocol"];
    let log = ["exchange-log", "kit", "protocol", "scenes", "scheme"];
    let run = [
        "coordinator",
        "exchange-log",
        "kit",
        "protocol",
        "scenes",
        "scheme",
    ];
    let drawn = [
        "coordinator",
        "draw",
        "exchange-log",
        "kit",
        "protocol",
        "runs",
        "scenes",
        "scheme",
    ];
    let judged = [
        "coordinator",
        "draw",
        "exchange-log",
        "kit",
        "protocol",
        "report",
        "runs",
        "scenes",
        "scheme",
        "study",
    ];
    for (package, below) in [
        ("protocol", &[] as &[&str]),
        ("kit", &wire),
        ("fem-node", &shared),
        ("dem-kernel", &shared),
        ("dem-node", &kernel),
        ("scheme", &wire),
        ("exchange-log", &wire),
        ("scenes", &shared),
        ("draw", &[]),
        ("coordinator", &log),
        ("runs", &run),
        ("report", &drawn),
        ("study", &drawn),
        ("lab", &judged),
    ] {
        assert_eq!(members_below(package), below, "{package}");
    }
}

#[test]
fn only_the_composition_root_names_the_solvers() {
    for path in sources(&root().join("coupler")) {
        let text = std::fs::read_to_string(&path).expect("it is text");
        let solvers = ["fem_node", "dem_node", "dem_kernel"];
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
        ("protocol", ["fem_node", "dem_", "coupler::"]),
        ("fem-node", ["dem_", "coupler::", "harness"]),
        ("dem-node/kernel", ["_node", "coupler::", "harness"]),
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
