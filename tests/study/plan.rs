//! Messages before the first run of a study: plans, refusals, and the requirements of a budget.

use std::fs;

use harness::runs::Scratch;

use crate::rows::{SUBSTEPS, VALUES, command, printed, study, words};

/// The words of a command of a study that is refused with exit code 2.
fn refused(work: &Scratch, verb: &str, tables: &str) -> String {
    let file = study(work, tables);
    let output = command(work, verb, &file, &[]).output();
    let output = output.expect("the program starts");
    assert_eq!(output.status.code(), Some(2), "{}", words(&output));
    words(&output)
}

#[test]
fn a_measure_that_no_run_reports_is_refused_before_the_first_run() {
    let work = Scratch::new("study-mistyped");
    for (of, norm, meant) in [
        ("signals.wheel_ym", "l2", "did you mean `wheel_y_m`?"),
        ("signals.third-body.wheel_z", "l2", "no run reports"),
        ("results.aproach_m", "at", "did you mean `approach_m`?"),
    ] {
        let old = "of = \"signals.wheel_y_m\"\nnorm = \"l2\"";
        let new = format!("of = \"{of}\"\nnorm = \"{norm}\"");
        for verb in ["plan", "run"] {
            let said = refused(&work, verb, &SUBSTEPS.replace(old, &new));
            assert!(said.contains(of) && said.contains(meant), "{said}");
        }
    }
    let old = "of = \"signals.wheel_y_m\"\nnorm = \"l2\"";
    let tables = SUBSTEPS.replace(old, "of = \"results.friction_coefficient\"");
    let output = command(&work, "plan", &study(&work, &tables), &[]).output();
    let said = words(&output.expect("the program starts"));
    assert!(
        said.contains("the old name of `results.traction_ratio_mean`"),
        "{said}"
    );
    // Other scenes have this result, and this one has no such table: its first run shows that.
    for (of, norm) in [("results.p0_pa", "at"), ("profile.p_pa", "l2")] {
        let old = "of = \"signals.wheel_y_m\"\nnorm = \"l2\"";
        let new = format!("of = \"{of}\"\nnorm = \"{norm}\"");
        let said = refused(&work, "run", &SUBSTEPS.replace(old, &new));
        assert!(said.contains("in the reference, which has ended"), "{said}");
        fs::remove_dir_all(work.path().join("out")).expect("it was made");
    }
}

/// The study's value of a varied key comes after the overrides of all runs.
#[test]
fn keys_of_a_study_without_effect_are_refused() {
    let work = Scratch::new("study-idle");
    let reference = "set = [\"interface.layer-base.substeps=1\"]\nperturb = 2";
    for (from, to, word) in [
        (
            "set = [\"run",
            "set = [\"interface.layer-base.substeps=9\", \"run",
            "`interface.layer-base.substeps=9` has no effect",
        ),
        (
            "mode",
            "threads = 0\nmode",
            "study.threads: must be at least 1",
        ),
        (reference, "run = \"nowhere\"", "nowhere"),
    ] {
        let file = study(&work, SUBSTEPS);
        let text = fs::read_to_string(&file).expect("it was written");
        fs::write(&file, text.replacen(from, to, 1)).expect("it is writable");
        let output = command(&work, "plan", &file, &[]).output();
        let said = words(&output.expect("the program starts"));
        assert!(said.contains(word), "{said}");
    }
}

/// The runs end at 60 us, and the layer is 20 mm wide.
#[test]
fn an_instant_beyond_the_run_and_bins_that_hide_the_surface_are_refused_before_the_first_run() {
    let work = Scratch::new("study-beyond");
    let old = "of = \"signals.wheel_y_m\"\nnorm = \"l2\"";
    for (new, said) in [
        (
            "of = \"signals.wheel_y_m\"\nat_s = 1.0",
            "is no instant of the run, which ends at 6",
        ),
        (
            "of = \"profile.pressure_pa\"\nnorm = \"l2\"\nbin_m = 1.0",
            "do not fit a surface",
        ),
        (
            "of = \"profile.traction_pa\"\nnorm = \"l2\"\nbin_m = 1e-12",
            "do not fit a surface",
        ),
    ] {
        for verb in ["plan", "run"] {
            let words = refused(&work, verb, &SUBSTEPS.replace(old, new));
            assert!(words.contains(said), "{new}: {words}");
        }
    }
}

#[test]
fn a_result_of_a_full_cycle_is_refused_where_no_wheel_makes_one() {
    let work = Scratch::new("study-cycle");
    let old = "of = \"signals.wheel_y_m\"\nnorm = \"l2\"";
    let tables = SUBSTEPS.replace(old, "of = \"results.loop_area_j\"");
    let said = refused(&work, "run", &tables);
    let words = ["results.loop_area_j needs a full cycle", "wheel.cycles = 1"];
    assert!(words.iter().all(|word| said.contains(word)), "{said}");
    // The run ends before a cycle is over; with 1.8e-3 s and a faster wheel it does not.
    let wheel = "participant.third-body.config.wheel";
    let cycle = format!("{wheel}.cycles=1.0");
    let whole = [
        "run.end_s=1.8e-3",
        &cycle,
        &format!("{wheel}.frequency_hz=2000.0"),
    ];
    let file = study(&work, &tables);
    for (sets, code) in [(&whole[1..2], 2), (&whole[..], 0)] {
        let sets: Vec<&str> = sets.iter().flat_map(|set| ["--set", set]).collect();
        printed(&mut command(&work, "plan", &file, &sets), code);
    }
}

#[test]
fn a_plan_shows_the_refusals_of_a_check() {
    let work = Scratch::new("study-refused");
    let key = "interface.layer-base.substeps";
    for (new, said) in [
        (
            "participant.third-body.config.law.frictoin",
            "did you mean `friction`?",
        ),
        (
            "participant.third-body.config.law.friction",
            "must be at least 0, got -1",
        ),
    ] {
        let points = format!("key = \"{new}\"\nvalues = [0.1, -1.0]");
        let tables = SUBSTEPS.replace(&format!("key = \"{key}\"\nvalues = [9, 3, 1]"), &points);
        let words = refused(&work, "plan", &tables);
        assert!(words.contains(said) && words.contains("--set"), "{words}");
    }
    // A study continues without such a value, but a refused reference ends it.
    let tables = SUBSTEPS.replace("substeps=1\"", "substeps=0\"");
    let words = refused(&work, "run", &tables);
    assert!(
        words.contains(key) && !words.contains("in the reference, which has ended"),
        "{words}"
    );
}

#[test]
fn a_plan_reports_what_a_budget_needs() {
    let work = Scratch::new("study-plan-budget");
    let planned = |tables: &str| {
        let output = command(&work, "plan", &study(&work, tables), &[]).output();
        let output = output.expect("the program starts");
        assert!(output.status.success(), "{}", words(&output));
        words(&output)
    };
    let few = planned(SUBSTEPS);
    assert!(
        few.contains("not for `run --budget`: 1 combinations"),
        "{few}"
    );
    assert!(
        few.contains("which needs 4; run.seed with scene = true and seeds = 4"),
        "{few}"
    );
    let seeds = "[[vary]]\nkey = \"run.seed\"\nscene = true\nseeds = 3\n";
    let load = "[[vary]]\nkey = \"participant.third-body.config.wheel.load_n\"\nscene = true\nvalues = [4e3, 8e3]\n";
    let enough = planned(&format!("{SUBSTEPS}{seeds}{load}"));
    // Six scenes less a mean and a slope leave four degrees of freedom.
    for word in [
        "6 scenes (5 would be enough)",
        "any run.seed and the range of",
        "lies 2.8 standard",
    ] {
        assert!(enough.contains(word), "{word} in {enough}");
    }
    let no_floor = planned(&SUBSTEPS.replace("perturb = 2", "perturb = 0"));
    assert!(
        no_floor.contains("the floor of noise is unknown"),
        "{no_floor}"
    );
    assert!(!planned(VALUES).contains("run --budget"));
}

#[test]
fn more_runs_than_can_be_listed_are_refused() {
    let work = Scratch::new("study-many");
    let values = "values = [9, 3, 1]";
    let long = "log = { from = 1.0, to = 2.0, count = 4000000000 }";
    for (old, new) in [
        (values, "seeds = 4000000000"),
        (values, long),
        ("perturb = 2", "perturb = 5000000000"),
        (values, "seeds = 100000"),
    ] {
        let said = refused(&work, "plan", &SUBSTEPS.replace(old, new));
        assert!(said.contains("at most 100000"), "{new}: {said}");
    }
    let scenes = |key: usize| format!("[[vary]]\nkey = \"k{key}\"\nscene = true\nseeds = 1000\n");
    let grid: String = (0..6).map(scenes).collect();
    let said = refused(&work, "plan", &(grid + SUBSTEPS));
    assert!(said.contains("plans 6000000000000000000 runs"), "{said}");
}
