//! `run --budget`: its choices, reports and refusals.

use std::fs;
use std::path::Path;
use std::process::Output;

use harness::runs::{Scratch, parse_json, thirdbody};

use crate::rows::{command, printed, shipped, study, words};

/// Six seeds, enough for bounds.
const SEEDS: &str = "[reference]\nset = [\"interface.layer-base.substeps=1\"]\nperturb = 1\n\
    [[vary]]\nkey = \"run.seed\"\nscene = true\nseeds = 6\n\
    [[vary]]\nkey = \"interface.layer-base.substeps\"\nvalues = [9, 3]\n\
    [[measure]]\nname = \"height\"\nof = \"signals.wheel_y_m\"\nnorm = \"l2\"\n";

fn run(work: &Scratch, study: &Path, budget: &str, sets: &[&str]) -> Output {
    let mut run = thirdbody(work.path());
    run.arg("run").arg(shipped("quick-bonded"));
    run.args(["--json", "--budget", budget, "--study"])
        .arg(study);
    let out = work
        .path()
        .join(format!("run-{}", budget.replace(['=', '%'], "-")));
    run.arg("--out").arg(out);
    for set in sets {
        run.args(["--set", set]);
    }
    run.output().expect("the program starts")
}

/// Gives the settings the costs of longer runs: runs of 60 us cost their set-up and differ by chance.
fn with_costs(path: &Path) {
    let text = fs::read_to_string(path).expect("it was written");
    let mut study = parse_json(text.as_bytes());
    for setting in study["settings"].as_array_mut().expect("a list") {
        setting["cpu_rel"] = match setting["words"].as_str().expect("words") {
            "reference" => 1.0.into(),
            "substeps = 3" => 0.4.into(),
            "substeps = 9" => 0.2.into(),
            other => panic!("{other} was not asked for"),
        };
    }
    fs::write(path, study.to_string()).expect("it is writable");
}

#[test]
fn a_budget_chooses_the_cheapest_setting_that_keeps_it() {
    let work = Scratch::new("study-budget");
    let file = study(&work, SEEDS);
    printed(&mut command(&work, "run", &file, &[]), 0);
    let out = work.path().join("out");
    with_costs(&out.join("study.json"));
    let other_seed = ["run.end_s=6e-5", "run.seed=40"];
    let chosen = |budget: &str| {
        let output = run(&work, &out, budget, &other_seed);
        assert!(output.status.success(), "{}", words(&output));
        let summary = parse_json(&output.stdout);
        let bound = summary["budget"]["errors"]["height"]["bound"].as_f64();
        let expected = summary["budget"]["errors"]["height"]["expected"].as_f64();
        let set = summary["budget"]["set"][0]
            .as_str()
            .expect("a setting")
            .to_string();
        (
            set,
            expected.expect("it is in the summary"),
            bound.expect("it is in the summary"),
        )
    };
    let (set, expected, bound) = chosen("error=90%");
    assert_eq!(set, "interface.layer-base.substeps=9");
    assert!(
        expected > 0.0 && expected < bound && bound < 0.9,
        "{expected:e} {bound:e}"
    );
    // Now the expected error of nine substeps is too large.
    let less = format!("height={expected:e}");
    let (set, _, finer) = chosen(&less);
    assert_eq!(set, "interface.layer-base.substeps=3");
    assert!(finer <= expected);

    let refused = |budget: &str, sets: &[&str], why: &str| {
        let output = run(&work, &out, budget, sets);
        assert_eq!(
            output.status.code(),
            Some(2),
            "{budget}: {}",
            words(&output)
        );
        assert!(words(&output).contains(why), "{budget}: {}", words(&output));
    };
    refused("error=1e-13", &other_seed, "below the floor of noise");
    refused("depth=1%", &other_seed, "measures height, and not `depth`");
    refused("error=often", &other_seed, "neither error=2%");
    refused(
        "error=5%",
        &["run.end_s=7e-5"],
        "run.end_s = 6e-5, and this scene 7e-5",
    );
    let law = "participant.third-body.config.law.friction=0.2";
    refused(
        "error=5%",
        &["run.end_s=6e-5", law],
        "law.friction = 0.3, and this scene 0.2",
    );
    let own = ["run.end_s=6e-5", "interface.layer-base.substeps=2"];
    refused("error=90%", &own, "substeps=2 has no effect");
    refused(
        "wall=1e-6s",
        &other_seed,
        "no setting of the study is predicted to end within",
    );
}

/// In a study of one key at a time each setting also holds the keys that other settings vary: otherwise it would cover a scene with any
/// value of these keys.
#[test]
fn a_stored_setting_has_every_varied_key() {
    let work = Scratch::new("study-complete");
    let keys = SEEDS.replace("values = [9, 3]", "values = [3]")
        + "[[vary]]\nkey = \"interface.layer-base.tolerance_rel\"\nvalues = [1e-4]\n";
    let file = study(&work, &keys);
    printed(&mut command(&work, "run", &file, &[]), 0);
    let text = fs::read(work.path().join("out/study.json")).expect("it was written");
    let stored = parse_json(&text);
    let settings = stored["settings"].as_array().expect("a list").iter();
    let sets = settings.map(|setting| setting["set"].to_string());
    let sets: Vec<String> = sets.chain([stored["reference"].to_string()]).collect();
    let has = |set: &str, substeps: &str, tolerance: &str| {
        set.contains(&format!("substeps={substeps}"))
            && set.contains(&format!("tolerance_rel={tolerance}"))
    };
    for (set, [substeps, tolerance]) in
        sets.iter()
            .zip([["1", "1e-5"], ["3", "1e-5"], ["1", "0.0001"], ["1", "1e-5"]])
    {
        let tolerance = if tolerance == "1e-5" {
            "0.00001"
        } else {
            tolerance
        };
        assert!(has(set, substeps, tolerance), "{set}");
    }
    assert_eq!(sets.len(), 4);
}
