//! The local engine: the content of the rows, no work done twice, and failures as rows.

use std::fs;
use std::os::unix::process::CommandExt;
use std::process::Stdio;
use std::time::{Duration, Instant};

use harness::runs::{Scratch, parse_json, thirdbody};
use nix::sys::signal::{Signal, killpg};
use nix::unistd::Pid;

use crate::rows::{
    SUBSTEPS, VALUES, command, lasting, number, printed, rows, shipped, study, words,
};

#[test]
fn rows_hold_errors_floors_costs_and_hashes() {
    let work = Scratch::new("study-rows");
    let file = study(&work, SUBSTEPS);
    let text = printed(&mut command(&work, "run", &file, &[]), 0);
    assert!(
        text.contains("front of error_height") && text.contains("substeps 1 -> 9"),
        "{text}"
    );
    let rows = rows(&work);
    let roles: Vec<&str> = rows.iter().map(|row| row["role"].as_str()).collect();
    assert_eq!(
        roles,
        [
            "reference",
            "perturbed-1",
            "perturbed-2",
            "point",
            "point",
            "point"
        ]
    );
    for row in &rows {
        assert_eq!(
            (&*row["status"], &*row["exit_code"], &*row["attempts"]),
            ("completed", "0", "1")
        );
        assert!(number(row, "element_steps") > 0.0 && number(row, "contact_iterations") > 0.0);
        assert!(number(row, "messages") > 0.0 && number(row, "cpu_s") > 0.0);
    }
    // The point with the reference's value shares the reference's run; the perturbed runs are others, and their distance is the floor.
    assert_eq!(rows[5]["id"], rows[0]["id"]);
    assert_eq!(number(&rows[5], "error_height"), 0.0);
    let perturbed = [1, 2].map(|k| number(&rows[k], "error_height"));
    assert_ne!(rows[1]["hash_exchange"], rows[0]["hash_exchange"]);
    let floor = perturbed[0].max(perturbed[1]);
    assert!(floor > 0.0 && floor < 1e-9, "{floor:e}");
    assert!(rows.iter().all(|row| number(row, "floor_height") == floor));
    // Longer windows have larger errors and less work.
    let errors = [3, 4].map(|k| number(&rows[k], "error_height"));
    assert!(
        errors[0] > errors[1] && errors[1] > 1e3 * floor,
        "{errors:?}, floor {floor:e}"
    );
    assert!(number(&rows[3], "messages") < 0.2 * number(&rows[0], "messages"));
    // A finished run keeps its measured quantities, and no exchange log.
    let run = work
        .path()
        .join("out/tasks")
        .join(&rows[0]["id"])
        .join("run");
    assert!(run.join("signals.csv").is_file() && !run.join("exchange.mcap").exists());
    for file in [
        "front.csv",
        "front.svg",
        "knobs.svg",
        "digest.txt",
        "study.json",
    ] {
        // One scene is too few for a bound, as `run --budget` reports; the study is kept anyway.
        assert!(work.path().join("out").join(file).is_file(), "{file}");
    }
}

#[test]
fn without_a_reference_there_are_values_and_no_errors() {
    let work = Scratch::new("study-values");
    let file = study(&work, VALUES);
    let text = printed(&mut command(&work, "run", &file, &[]), 0);
    let shown = [
        "values",
        "grains: friction = 0.1: 1.8800e2",
        "height: friction = 0.3: ",
    ];
    for words in shown {
        assert!(text.contains(words), "{words} in {text}");
    }
    for words in ["knee", "front", "budget", "noise"] {
        assert!(!text.contains(words), "{words} in {text}");
    }
    let rows = rows(&work);
    assert_eq!(rows.len(), 2);
    for row in &rows {
        assert_eq!((&*row["role"], &*row["status"]), ("point", "completed"));
        assert!(!row["warnings"].is_empty(), "so short a run has warnings");
        assert!(!row.contains_key("error_height") && !row.contains_key("cpu_rel"));
        // The value equals the run's, bit for bit.
        let run = work.path().join("out/tasks").join(&row["id"]).join("run");
        let summary = parse_json(&fs::read(run.join("summary.json")).expect("it ran"));
        assert_eq!(
            Some(number(row, "value_grains")),
            summary["results"]["disks"].as_f64()
        );
        let signals = fs::read_to_string(run.join("signals.csv")).expect("it ran");
        let head = signals.lines().next().expect("a head").split(',');
        let column = head
            .into_iter()
            .position(|name| name == "third-body.wheel_y_m");
        let column = column.expect("the wheel has a height");
        let heights = signals.lines().skip(1);
        let heights = heights.map(|line| line.split(',').nth(column).and_then(|y| y.parse().ok()));
        let largest = heights
            .map(|y: Option<f64>| y.expect("a number").abs())
            .reduce(f64::max);
        assert_eq!(Some(number(row, "value_height")), largest);
    }
    let out = |file: &str| work.path().join("out").join(file);
    for file in ["settings.toml", "means.svg", "means.csv", "digest.txt"] {
        assert!(out(file).is_file(), "{file}");
    }
    for file in ["front.csv", "front.svg", "knobs.svg", "study.json"] {
        assert!(!out(file).exists(), "{file}");
    }
    let page = |folder: &str| {
        thirdbody(work.path())
            .args(["study", "report", folder])
            .output()
    };
    let output = page("out").expect("the program starts");
    assert!(output.status.success(), "{output:?}");
    let html = fs::read_to_string(out("report.html")).expect("a page");
    for words in [
        "2 runs: 2 completed",
        "2 by thirdbody ",
        "Figure 1: ",
        "[[vary]]",
        "friction",
    ] {
        assert!(html.contains(words), "{words}");
    }
    let nothing = page(".").expect("the program starts");
    assert_eq!(nothing.status.code(), Some(2), "{nothing:?}");
    // A second key makes a map, and a seed means.
    let two = format!(
        "[[vary]]\nkey = \"run.seed\"\nscene = true\nseeds = 2\n{VALUES}[[vary]]\nkey = \"participant.third-body.config.sample.thickness_m\"\nvalues = [0.2e-3, 0.3e-3]\n"
    );
    fs::remove_dir_all(out("")).expect("it was made");
    let file = study(&work, &two);
    let text = fs::read_to_string(&file)
        .expect("written")
        .replace("one-at-a-time", "grid");
    fs::write(&file, text).expect("writable");
    let text = printed(&mut command(&work, "run", &file, &[]), 0);
    assert!(
        text.contains("means over the scenes") && text.contains("(2 runs"),
        "{text}"
    );
    assert!(out("maps.svg").is_file());
}

/// Three cases of the scene make two runs: an interval from three values would be narrower than from two.
#[test]
fn cases_of_the_same_run_count_as_one_realisation() {
    let work = Scratch::new("study-draws");
    let draws = "[[vary]]\nkey = \"draw\"\nscene = true\ncase = [\
        { value = \"a\", set = [\"run.seed=1\"] }, { value = \"b\", set = [\"run.seed=1\"] }, { value = \"c\", set = [\"run.seed=2\"] }]\n";
    let file = study(&work, &format!("{draws}{VALUES}"));
    let text = printed(&mut command(&work, "run", &file, &[]), 0);
    let expected = "(2 runs, scatter";
    assert!(
        text.contains(expected) && text.contains("; 1 more repeat the bits"),
        "{text}"
    );
}

#[test]
fn without_a_noise_floor_there_is_no_study_to_choose_by() {
    let work = Scratch::new("study-floorless");
    let file = study(&work, &SUBSTEPS.replace("perturb = 2", "perturb = 0"));
    let text = printed(&mut command(&work, "run", &file, &[]), 0);
    for words in [
        "no study.json for `run --budget`: its floor of noise is unknown",
        "(floor of noise not measured)",
    ] {
        assert!(text.contains(words), "{words} in {text}");
    }
    assert!(!work.path().join("out/study.json").exists());
    assert!(rows(&work).iter().all(|row| row["floor_height"].is_empty()));
}

#[test]
fn finished_tasks_are_not_repeated_and_work_repeats_exactly() {
    let work = Scratch::new("study-again");
    let file = study(&work, SUBSTEPS);
    printed(&mut command(&work, "run", &file, &[]), 0);
    let first = rows(&work);
    let text = printed(&mut command(&work, "run", &file, &[]), 0);
    assert!(text.contains("done     5"), "{text}");
    assert_eq!(rows(&work), first, "times included");
    let other = Scratch::new("study-again-elsewhere");
    let file = study(&other, SUBSTEPS);
    printed(&mut command(&other, "run", &file, &["--jobs", "1"]), 0);
    assert_eq!(lasting(&rows(&other)), lasting(&first));
}

#[test]
fn a_killed_study_continues_where_it_was() {
    let work = Scratch::new("study-killed");
    // Long enough to be killed during the run.
    let file = study(
        &work,
        &SUBSTEPS.replace("substeps=1\"", "substeps=1\", \"run.end_s=4e-4\""),
    );
    let mut run = command(&work, "run", &file, &["--jobs", "1"]);
    let run = run
        .process_group(0)
        .stdout(Stdio::null())
        .stderr(Stdio::null());
    let mut child = run.spawn().expect("the program starts");
    let tasks = work.path().join("out/tasks");
    let done = || {
        let folders = fs::read_dir(&tasks).into_iter().flatten().flatten();
        folders
            .filter(|folder| folder.path().join("task.json").is_file())
            .count()
    };
    let begun = Instant::now();
    while done() == 0 {
        assert!(
            begun.elapsed() < Duration::from_secs(60),
            "no run has ended"
        );
        std::thread::sleep(Duration::from_millis(2));
    }
    killpg(Pid::from_raw(child.id() as i32), Signal::SIGKILL).expect("it runs");
    child.wait().expect("it was started here");
    let before = done();
    assert!(before < 5, "it was over before it was killed");
    let status = printed(&mut command(&work, "status", &file, &[]), 8);
    assert!(status.contains(&format!("done     {before}\n")), "{status}");
    printed(&mut command(&work, "run", &file, &[]), 0);
    let rows = rows(&work);
    let attempts: f64 = rows[..5].iter().map(|row| number(row, "attempts")).sum();
    assert!(
        rows.iter().all(|row| row["status"] == "completed"),
        "{rows:?}"
    );
    // The run of the one job was under way and starts again, or had not started yet.
    assert!(
        (5.0..=6.0).contains(&attempts),
        "{attempts} attempts for 5 runs"
    );
}

#[test]
fn a_failed_run_is_a_row_with_its_reason_and_a_suspect_run_is_outside_the_front() {
    let work = Scratch::new("study-fails");
    let tables = "[reference]\nset = []\nperturb = 0\n\
        [[vary]]\nkey = \"participant.third-body.config.solver.tolerance\"\nvalues = [-1.0, 1e-3]\n\
        [[vary]]\nkey = \"run.plausible.energy_balance_rel\"\nvalues = [[0.0, 1e-300]]\n\
        [[measure]]\nname = \"height\"\nof = \"signals.wheel_y_m\"\nnorm = \"max\"\n";
    let file = study(&work, tables);
    let text = printed(&mut command(&work, "run", &file, &[]), 0);
    let rows = rows(&work);
    let row = |value: &str| {
        rows.iter()
            .find(|row| row["participant.third-body.config.solver.tolerance"] == value)
    };
    let refused = row("-1").expect("a row");
    assert_eq!(
        (&*refused["status"], &*refused["exit_code"]),
        ("refused", "2")
    );
    assert!(
        refused["message"].contains("tolerance"),
        "{}",
        refused["message"]
    );
    let suspect = rows.last().expect("a row");
    assert_eq!(
        (&*suspect["status"], &*suspect["exit_code"]),
        ("suspect", "8")
    );
    assert!(
        suspect["message"].contains("energy_balance at"),
        "{}",
        suspect["message"]
    );
    let front = fs::read_to_string(work.path().join("out/front.csv")).expect("it was written");
    assert_eq!(
        front.lines().count(),
        2,
        "only 1e-3 stands and is not the reference: {front}"
    );
    assert!(
        text.contains("not on the fronts") && text.contains("failed   1"),
        "{text}"
    );
    // Failed runs are repeated only with `--retry`.
    printed(&mut command(&work, "run", &file, &["--retry"]), 0);
    let again: Vec<String> = crate::rows::rows(&work)
        .iter()
        .map(|row| row["attempts"].clone())
        .collect();
    assert_eq!(again, ["1", "2", "1", "1"]);
}

#[test]
fn several_that_begin_at_once_in_a_new_folder_share_the_work() {
    let work = Scratch::new("study-at-once");
    let file = study(&work, SUBSTEPS);
    let begin = || {
        let mut run = command(&work, "run", &file, &["--jobs", "1"]);
        let run = run.stdout(Stdio::piped()).stderr(Stdio::piped());
        run.spawn().expect("the program starts")
    };
    let all: Vec<_> = (0..4).map(|_| begin()).collect();
    for child in all {
        let output = child.wait_with_output().expect("it was started here");
        assert!(output.status.success(), "{}", words(&output));
    }
    assert!(rows(&work).iter().all(|row| row["attempts"] == "1"));
}

#[test]
fn a_damaged_run_is_a_row_that_says_what_to_do() {
    let work = Scratch::new("study-damaged");
    let file = study(&work, SUBSTEPS);
    printed(&mut command(&work, "run", &file, &[]), 0);
    let point = rows(&work)[3]["id"].clone();
    let run = work.path().join("out/tasks").join(point).join("run");
    for name in ["summary.json", "signals.csv"] {
        let whole = fs::read(run.join(name)).expect("it was written");
        fs::write(run.join(name), &whole[..whole.len() / 2]).expect("it is writable");
        let text = printed(&mut command(&work, "collect", &file, &[]), 8);
        let row = &rows(&work)[3];
        assert_eq!(row["status"], "damaged");
        assert!(row["message"].contains(name) && row["message"].contains("--retry"));
        assert!(text.contains(&row["message"]), "{text}");
        printed(&mut command(&work, "run", &file, &["--retry"]), 0);
        assert_eq!(rows(&work)[3]["status"], "completed");
    }
}

#[test]
fn a_load_that_the_reference_does_not_have_is_reported() {
    let work = Scratch::new("study-load");
    let load = "[[vary]]\nkey = \"participant.third-body.config.wheel.load_n\"\nvalues = [4000.0, 8000.0]\n";
    let file = study(
        &work,
        &SUBSTEPS.replace("[[vary]]", &format!("{load}[[vary]]")),
    );
    let text = printed(&mut command(&work, "run", &file, &[]), 0);
    let expected = "config.wheel.load_n = 4000 is not the load of the reference";
    assert_eq!(text.matches(expected).count(), 1, "{text}");
    // Each scene has its own reference.
    let work = Scratch::new("study-load-scene");
    let scene = load.replace("values", "scene = true\nvalues");
    let file = study(
        &work,
        &SUBSTEPS.replace("[[vary]]", &format!("{scene}[[vary]]")),
    );
    let text = printed(&mut command(&work, "run", &file, &[]), 0);
    assert!(!text.contains("is not the load"), "{text}");
}

#[test]
fn a_task_that_is_not_as_planned_is_refused_and_others_run_by_themselves() {
    let work = Scratch::new("study-exec");
    let file = study(&work, SUBSTEPS);
    let listed = printed(&mut command(&work, "plan", &file, &[]), 0);
    assert_eq!(listed.lines().count(), 7, "{listed}");
    let lists = fs::read_dir(work.path().join("out")).expect("it was made");
    let mut lists = lists.flatten().map(|entry| entry.path());
    let list = lists
        .find(|path| path.extension().is_some_and(|e| e == "csv"))
        .expect("the list");
    let list = list.display().to_string();
    let done = printed(
        &mut command(&work, "exec", &file, &["--planned", &list, "--index", "4"]),
        0,
    );
    assert!(done.starts_with("completed"), "{done}");
    fs::write(
        &file,
        fs::read_to_string(&file)
            .expect("it is there")
            .replace("9, 3, 1", "9, 4, 1"),
    )
    .expect("it is writable");
    let output = command(&work, "exec", &file, &["--planned", &list, "--index", "4"]).output();
    let output = output.expect("the program starts");
    assert_eq!(output.status.code(), Some(2));
    assert!(
        words(&output).contains("has changed since the plan"),
        "{}",
        words(&output)
    );
    let output = command(&work, "exec", &file, &["--index", "6"])
        .output()
        .expect("the program starts");
    assert!(
        words(&output).contains("tasks 0 to 5"),
        "{}",
        words(&output)
    );
}

#[test]
fn a_run_has_only_the_outputs_that_its_scene_needs() {
    let work = Scratch::new("study-alone");
    let run = |scene: &str, out: &str, sets: &[&str]| {
        let mut run = thirdbody(work.path());
        run.arg("run")
            .arg(shipped(scene))
            .args(["--json", "--threads", "1", "--out", out]);
        for set in ["run.end_s=6e-5"].iter().chain(sets) {
            run.args(["--set", set]);
        }
        let output = run.output().expect("the program starts");
        assert!(output.status.success(), "{}", words(&output));
        parse_json(&output.stdout)
    };
    let files = |out: &str| {
        let entries = fs::read_dir(work.path().join(out))
            .expect("it was made")
            .flatten();
        let mut names: Vec<String> = entries
            .map(|e| e.file_name().into_string().expect("a name"))
            .collect();
        names.sort();
        names
    };
    let bare = [
        "run.output.exchange=false",
        "run.checkpoint_every_windows=0",
        "run.output.fields=false",
    ];
    let summary = run("layer-alone", "alone", &bare);
    assert_eq!(
        summary["participants"].as_object().map(|all| all.len()),
        Some(1)
    );
    assert!(
        summary.get("coupling").is_none() && summary.get("log").is_none(),
        "{summary}"
    );
    assert!(summary.get("fields").is_none(), "{summary}");
    assert_eq!(files("alone/fields"), [""; 0]);
    assert_eq!(
        files("alone"),
        [
            "fields",
            "logs",
            "manifest.json",
            "scenario.toml",
            "signals.csv",
            "summary.json"
        ]
    );
    run("quick", "coupled", &bare);
    assert!(
        !files("coupled")
            .iter()
            .any(|name| name == "exchange.mcap" || name == "checkpoints")
    );
    run("quick", "recorded", &["run.checkpoint_every_windows=50"]);
    let all = files("recorded");
    assert!(
        all.contains(&"exchange.mcap".into()) && all.contains(&"checkpoints".into()),
        "{all:?}"
    );
    assert!(all.contains(&"fields.pvd".into()), "{all:?}");
}
