//! Runs that are cut off: killed at any instant, interrupted, or with damaged checkpoints. They can always be resumed, and end with the
//! bits of an undisturbed run.

use std::path::{Path, PathBuf};
use std::process::Output;
use std::time::{Duration, Instant};

use coordinator::run::checkpoint::FOLDER;
use coordinator::run::checkpoint::file::{MAGIC, encode, list, read};
use coordinator::run::checkpoint::keeper::about;
use harness::runs::{Scratch, as_programs, parse_json, program, thirdbody};
use harness::scene::{bar, body, glue, head};
use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;
use runs::run_dir::write_whole;
use scenario::load::load;
use serde_json::Value;

use crate::scene::{Running, completed, fails, gone_within, short_quick};

/// A checkpoint every other window, so that many kills hit while one is written.
const OFTEN: [&str; 3] = [
    "run.end_s=2e-4",
    "run.checkpoint_every_windows=2",
    "run.checkpoints_kept=2",
];

/// Kills in an ordinary run of this suite; more with THIRDBODY_KILLS.
const KILLS: u32 = 6;

fn resume(work: &Path, run: &str, out: &str, more: &[&str]) -> Output {
    thirdbody(work)
        .args(["resume", run, "--out", out, "--json"])
        .args(more)
        .output()
        .expect("the program starts")
}

fn hashes(output: &Output) -> Value {
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    parse_json(&output.stdout)["hashes"].clone()
}

fn checkpoints(out: &Path) -> Vec<PathBuf> {
    let found = list(&out.join(FOLDER));
    found.into_iter().map(|found| found.path).collect()
}

#[test]
fn a_run_that_was_killed_at_any_instant_resumes_to_the_same_bits() {
    let kills = std::env::var("THIRDBODY_KILLS").map_or(KILLS, |n| n.parse().expect("a number"));
    let reference = Scratch::new("never-killed");
    let start = Instant::now();
    let whole = completed(&mut short_quick(reference.path(), &OFTEN))["hashes"].clone();
    let took = start.elapsed();
    let mut resumed_from_checkpoint = 0;
    // A linear congruential generator (Knuth 1997, vol. 2, 3.3.4) spreads the instants.
    let mut random = 2026u64;
    for index in 0..kills {
        random = random
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        let instant = took.mul_f64((random >> 11) as f64 / (1u64 << 53) as f64);
        let work = Scratch::new("killed");
        let out = work.path().join("out");
        let mut running = Running::start(&mut short_quick(work.path(), &OFTEN), &out);
        std::thread::sleep(instant);
        let _ = running.child.kill();
        let pids = running.participants();
        let _ = running.end_within(Duration::from_secs(5));
        gone_within(&pids, Duration::from_secs(5));
        if !out.join("scenario.toml").is_file() {
            fails(
                &resume(work.path(), "out", "again", &[]),
                2,
                &["no run directory"],
            );
            continue;
        }
        let output = resume(work.path(), "out", "again", &["--threads", "2"]);
        assert_eq!(hashes(&output), whole, "kill {index} after {instant:?}");
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(
            !said.contains("checkpoint-unusable"),
            "kill {index}: {said}"
        );
        resumed_from_checkpoint += u32::from(said.contains("continues from"));
    }
    eprintln!("{resumed_from_checkpoint} of {kills} resumed from a checkpoint");
}

#[test]
fn an_interrupted_run_resumes_from_its_last_window() {
    let reference = Scratch::new("never-interrupted");
    let rare = ["run.checkpoint_every_windows=1000000", "run.end_s=3e-4"];
    let whole = completed(&mut short_quick(reference.path(), &rare))["hashes"].clone();
    let work = Scratch::new("interrupted");
    let out = work.path().join("out");
    let mut running = Running::start(&mut short_quick(work.path(), &rare), &out);
    running.wait_for("windows of");
    std::thread::sleep(Duration::from_millis(100));
    kill(Pid::from_raw(running.child.id() as i32), Signal::SIGINT).expect("it runs");
    let (output, _) = running.end_within(Duration::from_secs(5));
    fails(&output, 130, &["interrupted"]);
    let windows = parse_json(&output.stdout)["windows"]
        .as_u64()
        .expect("a number");
    let written = list(&out.join(FOLDER));
    assert_eq!(written.len(), 1);
    assert_eq!(written[0].window, windows);
    assert_eq!(hashes(&resume(work.path(), "out", "again", &[])), whole);
}

/// The resumed run becomes the latest as soon as it begins, and must still find the run that it continues.
#[test]
fn the_latest_run_resumes_by_that_name() {
    let work = Scratch::new("resume-latest");
    let whole = completed(&mut short_quick(work.path(), &OFTEN))["hashes"].clone();
    let runs = work.path().join("runs");
    std::fs::create_dir(&runs).expect("writable");
    std::os::unix::fs::symlink("../out", runs.join("latest")).expect("writable");
    let output = thirdbody(work.path())
        .args(["resume", "runs/latest", "--json"])
        .output()
        .expect("the program starts");
    assert_eq!(hashes(&output), whole);
    let latest = runs.join("latest").canonicalize().expect("it exists");
    assert_eq!(latest.parent(), runs.canonicalize().ok().as_deref());
}

#[test]
fn a_damaged_checkpoint_is_named_and_the_one_before_it_is_used() {
    let work = Scratch::new("damaged-checkpoint");
    let out = work.path().join("out");
    let whole = completed(&mut short_quick(work.path(), &OFTEN))["hashes"].clone();
    let files = checkpoints(&out);
    assert_eq!(files.len(), 2);
    let bytes = std::fs::read(&files[1]).expect("it was written");
    std::fs::write(&files[1], &bytes[..bytes.len() - 1]).expect("writable");
    let name = |path: &Path| {
        path.file_name()
            .expect("a file")
            .to_string_lossy()
            .into_owned()
    };
    let output = resume(work.path(), "out", "cut", &[]);
    assert_eq!(hashes(&output), whole);
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(
        said.contains(&name(&files[1])) && said.contains("does not match its hash"),
        "{said}"
    );
    assert!(
        said.contains(&format!(
            "continues from out/checkpoints/{}",
            name(&files[0])
        )),
        "{said}"
    );
    // A log cut before the checkpoints makes both useless; the run begins again.
    let log = std::fs::read(out.join("exchange.mcap")).expect("it was written");
    std::fs::write(out.join("exchange.mcap"), &log[..log.len() / 2]).expect("writable");
    let output = resume(work.path(), "out", "short-log", &[]);
    assert_eq!(hashes(&output), whole);
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(
        said.contains("exchange.mcap can be read only up to block")
            && said.contains("starts again"),
        "{said}"
    );
}

#[test]
fn a_checkpoint_of_another_version_or_scenario_is_refused_by_name() {
    let work = Scratch::new("foreign-checkpoint");
    let out = work.path().join("out");
    completed(&mut short_quick(work.path(), &OFTEN));
    let text = std::fs::read_to_string(out.join("scenario.toml")).expect("it was written");
    std::fs::write(out.join("scenario.toml"), text.replace("8000.0", "8001.0")).expect("writable");
    let output = resume(work.path(), "out", "other", &[]);
    fails(
        &output,
        2,
        &[
            "belongs to scenario",
            "resume with the build and the scenario",
        ],
    );
    std::fs::write(out.join("scenario.toml"), text).expect("writable");
    for path in checkpoints(&out) {
        let mut bytes = std::fs::read(&path).expect("it was written");
        bytes[MAGIC.len() - 2] = b'9';
        std::fs::write(&path, bytes).expect("writable");
    }
    fails(
        &resume(work.path(), "out", "newer", &[]),
        2,
        &["thirdbody.checkpoint/9"],
    );
}

#[test]
fn a_checkpoint_of_another_build_of_this_version_is_refused_by_name() {
    let work = Scratch::new("other-build");
    let out = work.path().join("out");
    completed(&mut short_quick(work.path(), &OFTEN));
    let manifest = std::fs::read(out.join("manifest.json")).expect("it was written");
    let manifest = parse_json(&manifest);
    let build = manifest["build"].as_str().expect("a hash").to_string();
    assert!(
        build.len() == 16 && manifest["git"].is_string(),
        "{manifest}"
    );
    let loaded = load(&out.display().to_string(), &[]).expect("it ran");
    for path in checkpoints(&out) {
        let (mut about, checkpoint) = read(&path, &about(&loaded)).expect("this build wrote it");
        assert!(about.software.ends_with(&format!(" build {build}")));
        about.software = about.software.replace(&build, "0123456789abcdef");
        let bytes = encode(&about, &checkpoint).expect("plain numbers");
        write_whole(&path, &bytes).expect("writable");
    }
    let words = ["build 0123456789abcdef", &build, "resume with the build"];
    fails(&resume(work.path(), "out", "other", &[]), 2, &words);
}

fn foreign() -> String {
    as_programs(
        &[
            // At a Courant number of 0.9 the energy error of the bar is 12 %.
            head(
                "foreign",
                1.0,
                "checkpoint_every_windows = 10\nplausible = { energy_balance_rel = [1.0, 1.0] }",
            ),
            bar("bar", 40, 0.9, ""),
            body(40.0, 40.0, -1.0, "end_s = 90.0"),
            glue("dual-schur", 3, "tolerance_rel = 1e-9"),
        ]
        .concat(),
    )
}

#[test]
fn foreign_programs_resume_only_with_permission() {
    let work = Scratch::new("foreign-resume");
    let node = program("verification-node").display().to_string();
    std::fs::write(work.path().join("scene.toml"), foreign()).expect("writable");
    let mut run = thirdbody(work.path());
    run.args(["run", "scene.toml", "--out", "out", "--json"]);
    let whole = completed(&mut run)["hashes"].clone();
    fails(
        &resume(work.path(), "out", "no", &[]),
        2,
        &["--allow-commands", &node],
    );
    let output = resume(work.path(), "out", "yes", &["--allow-commands"]);
    assert_eq!(hashes(&output), whole);
}

/// Rows of signals.csv: the header, then one row per window.
fn rows(out: &Path) -> Vec<String> {
    let text = std::fs::read_to_string(out.join("signals.csv")).expect("it was written");
    text.lines().map(String::from).collect()
}

fn write_rows(out: &Path, rows: &[String]) {
    let text = rows
        .iter()
        .map(|row| format!("{row}\n"))
        .collect::<String>();
    std::fs::write(out.join("signals.csv"), text).expect("writable");
}

/// Damage: a row without two cells, a changed digit, half of all rows. The run continues from before the damage.
#[test]
fn a_damaged_table_is_not_carried_on() {
    let work = Scratch::new("damaged-table");
    let out = work.path().join("out");
    let whole = completed(&mut short_quick(work.path(), &OFTEN));
    let windows: Vec<u64> = list(&out.join(FOLDER)).iter().map(|c| c.window).collect();
    let sound = rows(&out);
    let shorter = |row: &String| row.rsplitn(3, ',').last().expect("a row").to_string();
    let changed = |row: &String| row.replacen('1', "2", 1);
    let between = windows[0] as usize + 1;
    let begins = "starts again".to_string();
    let before = format!("continues from out/checkpoints/{:012}", windows[0]);
    let mut damaged = vec![sound.clone(); 4];
    damaged[0][7] = shorter(&sound[7]);
    damaged[1][7] = changed(&sound[7]);
    damaged[2].truncate(sound.len() / 2);
    damaged[3][between] = changed(&sound[between]);
    let expected = [&begins, &begins, &begins, &before];
    for (index, (damaged, expected)) in damaged.iter().zip(expected).enumerate() {
        assert!(*damaged != sound);
        write_rows(&out, damaged);
        let output = resume(work.path(), "out", &format!("again-{index}"), &[]);
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(
            said.contains("signals.csv differs from what the run had written until then"),
            "{said}"
        );
        assert!(said.contains(expected), "{index}: {said}");
        let again = parse_json(&output.stdout);
        assert_eq!(
            (&again["hashes"], &again["tables"]),
            (&whole["hashes"], &whole["tables"])
        );
    }
}

/// A rail after its hold: the resumed run takes over its field and its traction as they were written.
#[test]
fn a_damaged_field_or_profile_is_not_carried_on() {
    let work = Scratch::new("damaged-field");
    let mut run = thirdbody(work.path());
    run.args(["run", "wheel-rail-fe-small", "--out", "out", "--json"]);
    for set in ["run.end_s=8.6e-4", "run.checkpoint_every_windows=110"] {
        run.args(["--set", set]);
    }
    let whole = completed(&mut run);
    let out = work.path().join("out");
    let newest = resume(work.path(), "out", "newest", &[]);
    assert!(String::from_utf8_lossy(&newest.stderr).contains("000000000330.checkpoint"));
    assert_eq!(hashes(&newest), whole["hashes"]);
    for name in [
        "profile.csv",
        "fields/rail-hold.vtu",
        "fields/rail-hold-profile.csv",
    ] {
        let sound = std::fs::read(out.join(name)).expect(name);
        let mut damaged = sound.clone();
        damaged[sound.len() / 2] ^= 1;
        std::fs::write(out.join(name), damaged).expect("writable");
        let output = resume(work.path(), "out", &name.replace('/', "-"), &[]);
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        let why = format!("{name} differs from what the run had written until then");
        assert!(
            said.contains(&why) && said.contains("000000000220.checkpoint"),
            "{said}"
        );
        let again = parse_json(&output.stdout);
        assert_eq!(
            (&again["hashes"], &again["tables"]),
            (&whole["hashes"], &whole["tables"])
        );
        std::fs::write(out.join(name), sound).expect("writable");
    }
}

/// A disk of a table falls on another disk of the same table.
const FALLS: &str = r#"
[run]
name = "falls"
thickness_m = 1e-3
checkpoint_every_windows = 100
output = { alone_steps = 1 }
[[participant]]
name = "disks"
kind = "dem"
[participant.config]
density_kg_per_m3 = 7800.0
gravity_m_per_s2 = [0.0, -9.81]
law = { kind = "RST_CLB", friction = 0.3, restitution = 0.8 }
solver = { kind = "nsgs", tolerance = 1e-10, max_iterations = 100, min_iterations = 1 }
time = { step_s = 1e-5, theta = 0.5, pressure_pa = 1.0, end_s = 5e-3 }
sample = { kind = "file", path = "grains.csv" }
"#;

#[test]
fn a_table_of_grains_that_has_changed_is_refused_with_or_without_a_checkpoint() {
    let work = Scratch::new("other-grains");
    let [scene, grains] = ["scene.toml", "grains.csv"].map(|name| work.path().join(name));
    let table = "x_m,y_m,radius_m,glued\n0,0,1e-3,1\n0,2.5e-3,1e-3,0\n";
    std::fs::write(&scene, FALLS).expect("writable");
    std::fs::write(&grains, table).expect("writable");
    let mut run = thirdbody(work.path());
    let whole = completed(run.args(["run", "scene.toml", "--out", "out", "--json"]));
    assert_eq!(
        hashes(&resume(work.path(), "out", "same", &[])),
        whole["hashes"]
    );
    let refused = |out: &str, words: &[&str]| {
        fails(&resume(work.path(), "out", out, &["--recover"]), 2, words)
    };
    let words = [
        "checkpoint-unusable",
        "grains.csv has changed since the run read it",
        "put that file back",
    ];
    std::fs::write(&grains, table.replace("2.5e-3", "2.6e-3")).expect("writable");
    refused("moved", &words);
    std::fs::remove_file(&grains).expect("it was there");
    refused("gone", &words);
    std::fs::remove_dir_all(work.path().join("out/checkpoints")).expect("it was there");
    refused("without-checkpoint", &words);
    std::fs::write(&grains, table).expect("writable");
    assert_eq!(
        hashes(&resume(work.path(), "out", "back", &[])),
        whole["hashes"]
    );
    std::fs::write(work.path().join("out/manifest.json"), "{}").expect("writable");
    refused(
        "unknown",
        &[
            "manifest.json lacks the hashes",
            "run the scenario from its start",
        ],
    );
}

#[test]
fn a_mesh_or_a_program_that_has_changed_is_refused() {
    let work = Scratch::new("other-mesh");
    let mesh = work.path().join("cylinder.msh");
    let shipped = crate::scene::folder("verification/pressurised-cylinder");
    for name in ["scenario.toml", "cylinder.msh"] {
        std::fs::copy(shipped.join(name), work.path().join(name)).expect("it ships");
    }
    let mut run = thirdbody(work.path());
    completed(run.args(["run", "scenario.toml", "--out", "out", "--json"]));
    let text = std::fs::read_to_string(&mesh).expect("it is a text");
    std::fs::write(&mesh, text.replace("106.25 0 0", "106.26 0 0")).expect("writable");
    let words = ["cylinder.msh has changed since the run read it"];
    fails(&resume(work.path(), "out", "other", &[]), 2, &words);

    let (node, copy) = (program("verification-node"), work.path().join("node"));
    std::fs::copy(&node, &copy).expect("it is built");
    let [node, own] = [&node, &copy].map(|path| path.display().to_string());
    std::fs::write(
        work.path().join("scene.toml"),
        foreign().replace(&node, &own),
    )
    .expect("writable");
    let mut run = thirdbody(work.path());
    completed(run.args(["run", "scene.toml", "--out", "own", "--json"]));
    let mut bytes = std::fs::read(&copy).expect("it was copied");
    bytes.push(0);
    std::fs::write(&copy, bytes).expect("writable");
    let output = resume(work.path(), "own", "rebuilt", &["--allow-commands"]);
    fails(&output, 2, &["node has changed since the run read it"]);
}
