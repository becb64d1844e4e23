//! A user's first day: messages answer a slip with the word that was meant, and `explain` explains words.

use harness::runs::{Scratch, thirdbody};

use crate::scene::fails;

#[test]
fn slips_are_refused_with_the_word_that_was_meant() {
    let work = Scratch::new("slips");
    let study = "scenarios/studies/quick-bonded";
    let copied = thirdbody(work.path())
        .args(["new", "studies/quick-bonded", study])
        .output();
    assert!(copied.is_ok_and(|copied| copied.status.success()));
    let study = format!("{study}/study.toml");
    let tower = "participant.third-body.config.sample.thickness_m=0.4";
    let seeds = "run.seed=9223372036854775807";
    let slips: [(&[&str], &[&str]); 19] = [
        (
            &["run", "quick", "--set", "law.friction=0.2"],
            &["did you mean `participant.third-body.config.law.friction`?"],
        ),
        (
            &[
                "check",
                "quick",
                "--set",
                "participant.thirdbody.config.law.friction=0.2",
            ],
            &["did you mean `third-body`?"],
        ),
        (
            &["check", "quick", "--set", tower],
            &["thickness_m", "tower", "0.4 mm are 4e-4"],
        ),
        (&["check", &study], &["is a study", "thirdbody study plan"]),
        (
            &["report", "nowhere"],
            &["nowhere", "there is no such folder"],
        ),
        (
            &["compare", "scenarios", "scenarios"],
            &["is not a run directory"],
        ),
        (
            &["run", "scenarios/foreign/winklr"],
            &["did you mean `foreign/winkler`?"],
        ),
        (
            &["conform", "--scenario", "quick", "--participant", "rial"],
            &["did you mean `rail`?"],
        ),
        (
            &["scenes", "beds"],
            &["no entry has this tag", "did you mean `bonds`?"],
        ),
        (
            &["run", "quick", "--set", "run..seed=3"],
            &["the key has an empty part"],
        ),
        (
            &["run", "quick", "--seeds", "2", "--set", seeds],
            &["--seeds 2", "lower run.seed"],
        ),
        (
            &["run", "quick", "--seeds", "2", "--strict"],
            &["cannot be used with", "--strict"],
        ),
        (
            &["study", "run", "quick-bonded", "--jobs", "0"],
            &["--jobs", "0"],
        ),
        (&["compare", &study, &study], &["is a file"]),
        (
            &["study", "run", "dpe"],
            &["dpe", "no study that `thirdbody scenes` lists"],
        ),
        (&["explain", "aproach_m"], &["did you mean `approach_m`?"]),
        (
            &["explain", "law.contacts"],
            &["no error, warning, key, result or signal"],
        ),
        (&["explain", "friktion"], &["did you mean `friction`?"]),
        (
            &["explain", "xyzzy"],
            &["no error, warning, key, result or signal", "check --schema"],
        ),
    ];
    for (command, words) in slips {
        let said = thirdbody(work.path())
            .args(command)
            .output()
            .expect("it starts");
        fails(&said, 2, words);
        let printed = String::from_utf8_lossy(&said.stderr).into_owned();
        assert!(!printed.contains("os error"), "{command:?}: {printed}");
    }
}

#[test]
fn codes_keys_and_results_are_explained() {
    let work = Scratch::new("words");
    for (word, expected) in [
        (
            "warning[long_window]:",
            "- Do: lower `interface.<name>.substeps`",
        ),
        ("approach_m", "Way of the wheel towards the rail"),
        (
            "mass_scale",
            "participant.NAME.config (dem).mass_scale: Factor on the inertia of the grains",
        ),
        ("law.friction", "Coefficient of friction"),
        (
            "substeps",
            "interface.NAME.substeps: Explicit steps of the continuum in a window",
        ),
        (
            "interface.layer-base.substeps",
            "interface.NAME.substeps: Explicit steps of the continuum in a window",
        ),
        ("participant.rail.command", "participant.NAME.command: "),
        ("seed", "run.seed: Seed of everything random."),
        (
            "participant.grains.config.law.friction",
            "Coefficient of friction",
        ),
        (
            "third-body.wheel_ft_n",
            "(a signal): Force on the wheel along x",
        ),
        ("peer_lost", "A participant ended in the middle of the run."),
    ] {
        let said = thirdbody(work.path())
            .args(["explain", word])
            .output()
            .expect("it starts");
        let text = String::from_utf8_lossy(&said.stdout).into_owned();
        assert!(
            said.status.success() && text.contains(expected),
            "{word}: {text}"
        );
    }
    let listed = thirdbody(work.path())
        .arg("list")
        .output()
        .expect("it starts");
    assert!(String::from_utf8_lossy(&listed.stdout).contains("wheel-rail-coupled"));
}

/// A run prints the results that people ask for first, and all of them on request.
#[test]
fn a_run_ends_in_six_figures_and_what_comes_next() {
    let work = Scratch::new("ends");
    let ended = |more: &[&str]| {
        let mut run = thirdbody(work.path());
        run.args([
            "run",
            "layer-alone",
            "--set",
            "participant.third-body.config.law.friction=0.25",
        ]);
        let said = run.args(more).output().expect("it starts");
        assert!(said.status.success());
        String::from_utf8_lossy(&said.stdout).into_owned()
    };
    let short = ended(&["--out", "one"]);
    for words in [
        "set       participant.third-body.config.law.friction = 0.25 (was 0.3)",
        "approach_m",
        "over its motion. It includes sticking, so it is not a coefficient of friction.",
        "more: --all",
        "next: thirdbody report one",
    ] {
        assert!(short.contains(words), "{words} in {short}");
    }
    let results = short.lines().skip_while(|line| *line != "Results").skip(1);
    assert_eq!(
        results
            .take_while(|line| !line.contains("more: --all"))
            .count(),
        6,
        "{short}"
    );
    let all = ended(&["--all", "--out", "two"]);
    assert!(
        all.contains("spring_restitution") && all.lines().count() > 2 * short.lines().count(),
        "{all}"
    );
}

#[test]
fn a_copied_scene_says_what_its_keys_are() {
    for (scene, shipped, line) in [
        ("quick", "quick", "# law.friction: "),
        ("wheel-rail-fe-small", "wheel-rail-fe-small", "# element: "),
    ] {
        let work = Scratch::new("commented");
        let copied = thirdbody(work.path()).args(["new", scene, "mine"]).output();
        assert!(copied.is_ok_and(|copied| copied.status.success()));
        let read = |path: std::path::PathBuf| std::fs::read_to_string(path).expect("it is there");
        let text = read(work.path().join("mine/scenario.toml"));
        assert!(text.lines().any(|own| own.starts_with(line)), "{text}");
        // The comments stand above the lines, and the keys are the scene's.
        let mut own: toml::Table = text.parse().expect("it is TOML");
        let run = own["run"].as_table_mut().expect("a table");
        assert_eq!(run.remove("derived_from"), Some(shipped.into()));
        let original = read(crate::scene::folder(scene).join("scenario.toml"));
        let original: toml::Table = original.parse().expect("it is TOML");
        own["run"]
            .as_table_mut()
            .expect("a table")
            .insert("name".into(), original["run"]["name"].clone());
        assert_eq!(own, original, "{scene}");
    }
}
