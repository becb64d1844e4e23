//! Bad input: each message says what is wrong, where, and what to do; no process and no shared memory is left.

use std::process::Command;

use harness::runs::{Scratch, program, thirdbody};

use crate::scene::{fails, folder, shared_memory_of, short_quick};

/// Runs `quick` with overrides and expects a refusal.
fn refused(sets: &[&str], code: i32, words: &[&str]) {
    let work = Scratch::new("refused");
    let child = short_quick(work.path(), sets)
        .stdout(std::process::Stdio::piped())
        .stderr(std::process::Stdio::piped())
        .spawn()
        .expect("the program starts");
    let coordinator = child.id();
    let output = child.wait_with_output().expect("its output was piped");
    fails(&output, code, words);
    assert_eq!(shared_memory_of(coordinator), Vec::<String>::new());
}

/// Runs `quick` with its text changed and expects a refusal.
fn text_refused(from: &str, to: &str, words: &[&str]) {
    let work = Scratch::new("text");
    let text = std::fs::read_to_string(folder("quick").join("scenario.toml")).expect("it ships");
    assert!(text.contains(from), "the scene changed: no `{from}`");
    let path = work.path().join("changed.toml");
    std::fs::write(&path, text.replace(from, to)).expect("the folder is writable");
    let output = run(thirdbody(work.path()).arg("run").arg(&path));
    fails(&output, 2, words);
    let output = run(thirdbody(work.path()).arg("check").arg(&path));
    fails(&output, 2, words);
}

fn run(command: &mut Command) -> std::process::Output {
    command.output().expect("the program starts")
}

#[test]
fn an_unknown_key_names_its_line_and_its_neighbour() {
    text_refused(
        "crown_radius_m = 0.3 }\nmaterial",
        "crown_radus_m = 0.3 }\nmaterial",
        &[
            "participant.rail.config.mesh.crown_radus_m",
            "did you mean `crown_radius_m`?",
            "changed.toml:17",
        ],
    );
    text_refused(
        "thickness_m = 1e-3",
        "thikness_m = 1e-3",
        &["run.thikness_m", "did you mean `thickness_m`?"],
    );
}

/// The suites run a program built without the feature `vtkhdf`.
#[test]
fn a_field_format_that_is_not_built_in_is_refused_with_the_build_command() {
    let with = |word: &str| format!("output.fields_format = \"{word}\"\nthickness_m = 1e-3");
    text_refused(
        "thickness_m = 1e-3",
        &with("vtkhdf"),
        &[
            "run.output.fields_format",
            "cargo install --locked --path coupler --features vtkhdf",
            "changed.toml",
        ],
    );
    text_refused(
        "thickness_m = 1e-3",
        &with("vtkhfd"),
        &[
            "`vtkhfd` is not one of the choices",
            "choices: vtk-xml, vtkhdf",
        ],
    );
}

#[test]
fn a_missing_key_is_named() {
    text_refused(
        "pressure_pa = 1e9",
        "",
        &["participant.third-body.config.time.pressure_pa", "missing"],
    );
    text_refused(
        "substeps = 9\n",
        "",
        &["interface.layer-base.substeps", "missing"],
    );
}

#[test]
fn a_wrong_type_is_named() {
    refused(
        &["participant.rail.config.mesh.size_m=big"],
        2,
        &["participant.rail.config.mesh.size_m", "invalid type"],
    );
    refused(
        &["interface.layer-base.substeps=2.5"],
        2,
        &["interface.layer-base.substeps", "invalid type"],
    );
}

#[test]
fn a_negative_radius_is_named() {
    refused(
        &["participant.third-body.config.sample.radius_min_m=-5e-5"],
        2,
        &["participant.third-body.config.sample.radius_min_m", "-5e-5"],
    );
}

#[test]
fn a_step_above_its_bound_is_refused_with_the_bound() {
    refused(
        &["participant.rail.config.time.step_s=1e-6"],
        2,
        &["participant.rail.config.time.step_s", "stability limit"],
    );
}

#[test]
fn a_window_above_the_inertial_time_is_refused_with_the_bound() {
    refused(
        &["interface.layer-base.substeps=300"],
        2,
        &["layer-base", "substeps", "inertial"],
    );
}

#[test]
fn a_run_that_would_never_end_is_refused_with_the_keys_that_make_it_long() {
    let keys = ["steps", "run.end_s", "wheel.cycles"];
    refused(&["run.end_s=1e30"], 2, &keys);
}

#[test]
fn a_static_body_on_an_interface_is_refused_by_its_key() {
    refused(
        &["participant.rail.config.analysis=static"],
        2,
        &["participant `rail`", "analysis = \"dynamic\""],
    );
}

#[test]
fn an_unknown_set_or_participant_is_named() {
    refused(
        &[r#"interface.layer-base.between=["rail.topp", "third-body.base"]"#],
        2,
        &["no set `topp`", "top"],
    );
    refused(
        &[r#"interface.layer-base.between=["rial.top", "third-body.base"]"#],
        2,
        &["no participant is named `rial`", "did you mean `rail`?"],
    );
}

#[test]
fn an_unknown_kind_or_command_is_named() {
    refused(
        &["participant.rail.kind=fen"],
        2,
        &["participant `rail`", "`fen`", "did you mean `fem`?"],
    );
    refused(
        &[r#"participant.rail.command=["no-such-program"]"#],
        2,
        &["participant `rail`", "`no-such-program`"],
    );
}

#[test]
fn a_node_of_another_protocol_version_is_refused() {
    let node = program("verification-node").display().to_string();
    refused(
        &[&format!(
            r#"participant.rail.command=["{node}", "other-version"]"#
        )],
        2,
        &["participant `rail`", "protocol version 77", "speaks 2"],
    );
}

#[test]
fn a_participant_that_never_answers_meets_its_deadline() {
    refused(
        &[
            r#"participant.rail.command=["sleep", "1000"]"#,
            "run.deadlines.setup_s=1",
        ],
        5,
        &[
            "participant `rail`",
            "1.0 s",
            "alive but silent",
            "run.deadlines.setup_s",
        ],
    );
}

#[test]
fn a_program_that_is_no_participant_is_a_lost_peer() {
    refused(
        &[r#"participant.rail.command=["true"]"#],
        4,
        &["participant `rail`", "ended"],
    );
}

#[test]
fn three_sweeps_a_window_starve_the_contact_solver_and_end_the_run() {
    refused(
        &["participant.third-body.config.solver.max_iterations=3"],
        3,
        &["starved", "window", "true residual", "max_iterations"],
    );
}

#[test]
fn a_folder_with_something_in_it_is_never_written_to() {
    let work = Scratch::new("occupied");
    let out = work.path().join("out");
    std::fs::create_dir_all(&out).expect("the folder is writable");
    std::fs::write(out.join("mine.txt"), "mine").expect("the folder is writable");
    let output = run(&mut short_quick(work.path(), &[]));
    fails(&output, 2, &["--out", "not empty"]);
    assert_eq!(std::fs::read_dir(&out).expect("it is there").count(), 1);
}

#[test]
fn a_missing_scenario_is_refused_with_the_folder_that_was_searched() {
    let work = Scratch::new("nowhere");
    let output = run(thirdbody(work.path()).args(["run", "nowhere"]));
    fails(&output, 2, &["nowhere", "scenarios/"]);
}

#[test]
fn control_characters_and_names_that_look_like_options_are_refused() {
    refused(
        &["run.seed=2\nrun.thickness_m=1.0"],
        2,
        &["--set run.seed=2\\nrun.thickness_m=1.0", "line break"],
    );
    text_refused(
        "name = \"rail\"",
        "name = \"-rail\"",
        &[
            "participant.-rail.name",
            "`-rail`",
            "not beginning with `-`",
        ],
    );
    text_refused(
        "name = \"rail\"",
        "name = \"ra\\u001b[31mil\"",
        &["participant.ra?[31mil.name", "`ra\\u{1b}[31mil`"],
    );
}

/// The program must not replace a user's file that has the name of the link.
#[test]
fn a_file_of_the_user_called_latest_stays() {
    let work = Scratch::new("latest");
    std::fs::create_dir(work.path().join("runs")).expect("writable");
    let latest = work.path().join("runs/latest");
    std::fs::write(&latest, "mine").expect("writable");
    let mut command = thirdbody(work.path());
    command.arg("run").arg(folder("quick"));
    let output = run(command.args(["--set", "run.end_s=6e-6"]));
    assert!(output.status.success());
    assert_eq!(std::fs::read_to_string(&latest).expect("it stays"), "mine");
}
