//! Same scenario, same build: same bits, for any number of threads, any transport and beside other runs.

use std::path::Path;

use harness::runs::{Scratch, parse_json, read_csv, thirdbody};
use serde_json::Value;

use crate::scene::{completed, folder, short_quick};

fn hashes(summary: &Value) -> (String, String) {
    let hash = |name: &str| {
        summary["hashes"][name]
            .as_str()
            .expect("a completed run has it")
            .to_string()
    };
    (hash("exchange"), hash("state"))
}

fn run(sets: &[&str], threads: &str) -> (String, String) {
    let work = Scratch::new("bits");
    hashes(&completed(
        short_quick(work.path(), sets).args(["--threads", threads]),
    ))
}

#[test]
fn threads_and_transport_change_no_bit() {
    let first = run(&[], "1");
    assert_eq!(first, run(&[], "1"), "a second run");
    assert_eq!(first, run(&[], "2"), "two threads");
    assert_eq!(
        first,
        run(&["run.transport=channel"], "1"),
        "in one process"
    );
}

#[test]
fn threads_and_transport_change_no_bit_of_modes() {
    let modes = "participant.rail.config.reduced.modes=20";
    let first = run(&[modes], "1");
    assert_eq!(first, run(&[modes], "2"), "two threads");
    let inside = run(&[modes, "run.transport=channel"], "1");
    assert_eq!(first, inside, "in one process");
}

#[test]
fn rolling_couples_have_the_same_bits_on_any_number_of_threads() {
    let sets = [
        "participant.third-body.config.sample.glued=false",
        "participant.third-body.config.law.rolling.coefficient=0.2",
        "participant.third-body.config.law.adhesion={ pull_off_pa = 1e8, range_m = 1e-5 }",
    ];
    assert_eq!(run(&sets, "1"), run(&sets, "2"));
}

#[test]
fn healing_bonds_have_the_same_bits_on_any_number_of_threads() {
    let sets = [
        "participant.third-body.config.law.kind=cohesion",
        "participant.third-body.config.law.cn_pa_per_m=6.4e15",
        "participant.third-body.config.law.ct_pa_per_m=6.4e15",
        "participant.third-body.config.law.w_j_per_m2=39.0",
        "participant.third-body.config.law.b_pa_m_s=0.0",
        "participant.third-body.config.law.p=1.0",
        "participant.third-body.config.law.h_prime=one",
        "participant.third-body.config.law.alert_m=1e-9",
        "participant.third-body.config.law.healing={ time_s = 2e-4, pressure_pa = 1e7 }",
    ];
    assert_eq!(run(&sets, "1"), run(&sets, "2"));
}

/// 4 050 disks in 12 000 contacts on a strip of 5 040 elements. From 8 192 contacts on, the contact solver divides its problem; from
/// 5 000 elements on, two threads share them.
fn large_scene(folder: &Path) {
    let (radius, columns, rows) = (0.1e-3, 90, 45);
    let d = 2.0 * radius * (1.0 - 1e-6);
    let disks: Vec<String> = (0..columns * rows)
        .map(|i| {
            let (column, row) = (f64::from(i / rows), f64::from(i % rows));
            let x = d * (column + 0.5 * (row % 2.0)) - 0.5 * f64::from(columns) * d;
            let y = radius + 0.75f64.sqrt() * d * row;
            let glued = i % rows == 0;
            format!("{{ x_m = {x:e}, y_m = {y:e}, radius_m = {radius:e}, glued = {glued} }}")
        })
        .collect();
    let text = format!(
        r#"
[run]
name = "large"
thickness_m = 1e-3
end_s = 3e-6
[[participant]]
name = "strip"
kind = "fem"
[participant.config]
base = "clamped"
sides = "free"
mesh = {{ width_m = 24e-3, height_m = 8.4e-3, size_m = 0.2e-3 }}
material = {{ young_pa = 102.5e9, poisson = 0.3, density_kg_per_m3 = 7800.0 }}
time = {{ step_s = 3e-8, damping = 0.75 }}
[[participant]]
name = "grains"
kind = "dem"
[participant.config]
density_kg_per_m3 = 7800.0
mass_scale = 1000.0
law = {{ kind = "coulomb", friction = 0.3, contact_stiffness_pa = 2.255e11, tangential_stiffness_ratio = 0.5 }}
solver = {{ kind = "nsgs", tolerance = 1e-3, max_iterations = 2000, min_iterations = 2 }}
time = {{ pressure_pa = 1e9 }}
plausible = {{ ejected_rel = [1.0, 1.0], added_inertia_rel = [3.0, 3.0] }}
sample = {{ kind = "disks", disks = [{}] }}
wheel = {{ load_n = 8e3, mass_kg = 0.01, radius_m = 0.0, amplitude_m = 0.0, frequency_hz = 300.0, ramp_s = 1e-6, hold_s = 1e-3, cycles = 0.0 }}
[[interface]]
name = "joint"
between = ["strip.top", "grains.base"]
scheme = "dual-schur"
substeps = 10
tolerance_rel = 1e-5
"#,
        disks.join(", ")
    );
    std::fs::write(folder.join("scenario.toml"), text).expect("the folder is ours");
}

#[test]
fn threads_change_no_bit_of_a_scene_large_enough_to_use_them() {
    let work = Scratch::new("large");
    large_scene(work.path());
    let run = |threads: &str, out: &str, transport: &str| {
        let mut command = thirdbody(work.path());
        command
            .args(["run", "scenario.toml", "--json", "--out", out])
            .args(["--threads", threads])
            .args(["--set", &format!("run.transport={transport}")]);
        let summary = completed(&mut command);
        let force = summary["results"]["contacts"].as_f64();
        assert!(force > Some(4000.0), "contacts that carry force: {force:?}");
        hashes(&summary)
    };
    let first = run("1", "one", "shm");
    assert_eq!(first, run("2", "two", "shm"), "two threads");
    let inside = [first.1, run("4", "four", "channel").1];
    assert_eq!(inside[0], inside[1], "four threads in one process");
}

/// Four layers under one rail, as processes with one or two threads or as threads of one process, listed in either order, give the same
/// numbers. `hashes.state` covers the participants in listed order; each participant keeps its own hash.
#[test]
fn places_and_order_of_several_layers_change_no_bit() {
    let run = |scene: &Path, sets: &[&str], threads: &str| {
        let work = Scratch::new("layers");
        let mut command = thirdbody(work.path());
        command.arg("run").arg(scene).arg("--json");
        command.args(["--threads", threads, "--out", "out"]);
        command.args(["--set", "run.end_s=1.2e-4"]);
        for set in sets {
            command.args(["--set", set]);
        }
        let summary = completed(&mut command);
        let signals = read_csv(&work.path().join("out/signals.csv"));
        (summary, signals)
    };
    let shipped = folder("rail-over-layers");
    let (first, signals) = run(&shipped, &[], "1");
    let repeats = first["repeats_mean"].as_f64();
    assert!(
        repeats > Some(1.05),
        "the layers feel each other: {repeats:?}"
    );
    for (sets, threads) in [
        (&[][..], "2"),
        (&["run.transport=channel"], "1"),
        (&["run.transport=channel"], "2"),
    ] {
        let other = run(&shipped, sets, threads);
        assert_eq!(
            hashes(&first),
            hashes(&other.0),
            "{sets:?}, {threads} threads"
        );
        assert_eq!(signals, other.1);
    }
    let text = std::fs::read_to_string(shipped.join("scenario.toml")).expect("it is shipped");
    let mut scene: toml::Table = text.parse().expect("it is TOML");
    let listed = scene["participant"].as_array_mut().expect("five of them");
    listed.reverse();
    let turned = Scratch::new("turned");
    std::fs::write(turned.path().join("scenario.toml"), scene.to_string()).expect("it is ours");
    let (other, of_other) = run(turned.path(), &[], "1");
    assert_eq!(signals, of_other);
    assert_eq!(hashes(&first).0, hashes(&other).0);
    for name in ["rail", "third-body-1", "third-body-4"] {
        let state = |of: &Value| of["participants"][name]["state_hash"].clone();
        assert!(state(&first).is_string());
        assert_eq!(state(&first), state(&other), "{name}");
    }
}

/// The rail is in equilibrium: in the hold its four patches carry the load in compression, each about a quarter.
#[test]
fn patches_under_one_rail_share_its_load() {
    let work = Scratch::new("shares");
    let mut command = thirdbody(work.path());
    command.arg("run").arg(folder("rail-over-layers"));
    command.args(["--json", "--out", "out", "--set", "run.end_s=2e-4"]);
    let summary = completed(&mut command);
    let results = &summary["results"];
    let carried = [1, 2, 3, 4].map(|patch| {
        let of = |name: &str| results[format!("patch-{patch}.{name}")].as_f64();
        assert!(of("p0_1mm_pa") > Some(2e8), "{results}");
        of("interface_force_n").expect("there is a hold")
    });
    let sum: f64 = carried.iter().sum();
    assert!((sum / 5000.0 - 1.0).abs() < 1e-3, "{carried:?}");
    assert!(
        carried
            .iter()
            .all(|force| (force / 1250.0 - 1.0).abs() < 0.1),
        "{carried:?}"
    );
    for layer in 1..=4 {
        let disks = &results[format!("third-body-{layer}.disks")];
        assert!(disks.as_f64() > Some(40.0), "{disks}");
    }
}

#[test]
fn threads_and_transport_change_no_bit_with_the_velocity_scheme() {
    let velocity = "interface.layer-base.scheme=velocity";
    let first = run(&[velocity], "1");
    assert_ne!(first, run(&[], "1"), "another scheme");
    assert_eq!(first, run(&[velocity], "2"), "two threads");
    assert_eq!(first, run(&[velocity, "run.transport=channel"], "1"));
}

#[test]
fn threads_and_transport_change_no_bit_where_the_rail_follows_the_grains() {
    let sets = [
        "interface.layer-base.scheme=fixed-point-serial",
        "interface.layer-base.dirichlet=continuum",
        "interface.layer-base.tolerance_rel=1e-4",
    ];
    let first = run(&sets, "1");
    assert_ne!(first, run(&[], "1"), "another scheme");
    assert_eq!(first, run(&sets, "2"), "two threads");
    let inside = [sets.as_slice(), &["run.transport=channel"]].concat();
    assert_eq!(first, run(&inside, "1"), "in one process");
}

#[test]
fn another_seed_and_one_ulp_of_load_change_both_hashes() {
    let first = run(&[], "1");
    let ulp = f64::from_bits(8000f64.to_bits() + 1);
    let load = format!("participant.third-body.config.wheel.load_n={ulp:?}");
    for set in ["run.seed=2", load.as_str()] {
        let other = run(&[set], "1");
        assert_ne!(first.0, other.0, "{set}");
        assert_ne!(first.1, other.1, "{set}");
    }
}

#[test]
fn two_runs_at_the_same_time_do_not_disturb_each_other() {
    let works = [Scratch::new("one"), Scratch::new("other")];
    let start = |path: &Path| {
        short_quick(path, &[])
            .stdout(std::process::Stdio::piped())
            .stderr(std::process::Stdio::piped())
            .spawn()
            .expect("the program starts")
    };
    let children = works.each_ref().map(|work| start(work.path()));
    let ended = children.map(|child| child.wait_with_output().expect("its output was piped"));
    for output in &ended {
        assert!(
            output.status.success(),
            "{}",
            String::from_utf8_lossy(&output.stderr)
        );
    }
    let [one, other] = ended.map(|output| hashes(&parse_json(&output.stdout)));
    assert_eq!(one, other);
    assert_eq!(one, run(&[], "1"));
}
