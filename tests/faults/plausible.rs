//! Runs whose results are not plausible: warnings with value and bound, and exit code 8 beyond the second bound.

use std::process::Output;

use harness::runs::{Scratch, parse_json, thirdbody};
use serde_json::{Value, json};

use crate::scene::folder;

/// A shipped scene with these overrides, for ten windows of `quick` unless they say otherwise.
fn run(scene: &str, sets: &[&str], more: &[&str]) -> (Option<i32>, Value, Output) {
    let work = Scratch::new("plausible");
    let mut command = thirdbody(work.path());
    command
        .arg("run")
        .arg(folder(scene))
        .args(["--out", "out", "--json"]);
    for set in sets {
        command.args(["--set", set]);
    }
    let output = command.args(more).output().expect("the program starts");
    let summary = if output.stdout.is_empty() {
        Value::Null
    } else {
        parse_json(&output.stdout)
    };
    (output.status.code(), summary, output)
}

const SHORT: &str = "run.end_s=6e-6";

fn codes(summary: &Value) -> Vec<&str> {
    let warnings = summary["warnings"].as_array().expect("a list");
    let codes = warnings.iter().map(|warning| &warning["code"]);
    codes.filter_map(Value::as_str).collect()
}

#[test]
fn a_layer_of_another_shape_than_its_rail_is_suspect() {
    let crown = |radius: &str, more: &[&str]| {
        let set = format!("participant.third-body.config.sample.crown_radius_m={radius}");
        run("quick", &[SHORT, &set], more)
    };
    let (code, summary, output) = crown("0.1", &[]);
    assert_eq!((code, &summary["status"]), (Some(8), &json!("suspect")));
    assert_eq!(codes(&summary), ["surface_offset"]);
    let warning = &summary["warnings"][0];
    assert_eq!(warning["where"], "layer-base");
    assert!(
        warning["value"].as_f64() > warning["bound"].as_f64(),
        "{warning}"
    );
    let told = String::from_utf8_lossy(&output.stderr);
    assert!(
        told.contains("warning[surface_offset]: layer-base: the shape"),
        "{told}"
    );

    let (code, summary, _) = crown("0.25", &[]);
    assert_eq!((code, codes(&summary)), (Some(0), vec!["surface_offset"]));
    let (code, summary, _) = crown("0.25", &["--strict"]);
    assert_eq!((code, &summary["status"]), (Some(8), &json!("suspect")));
    let bounds = "run.plausible.surface_offset_rel=[5.0, 9.0]";
    let (code, summary, _) = crown("0.1", &["--set", bounds, "--strict"]);
    assert_eq!((code, codes(&summary)), (Some(0), vec![]));
}

#[test]
fn bounds_out_of_order_are_refused_by_their_key() {
    for (set, key) in [
        ("run.plausible.gap_rel=[1.0, 0.5]", "run.plausible.gap_rel"),
        (
            "participant.third-body.config.plausible.overlap_rel=[1.0, 0.5]",
            "participant.third-body.config.plausible.overlap_rel",
        ),
        (
            "participant.third-body.config.plausible.detection_rel=[0.03, 0.003]",
            "participant.third-body.config.plausible.detection_rel",
        ),
        (
            "participant.rail.config.plausible.strain=[-1.0, 0.5]",
            "participant.rail.config.plausible.strain",
        ),
    ] {
        let (code, _, output) = run("quick", &[SHORT, set], &[]);
        let told = String::from_utf8_lossy(&output.stderr);
        assert_eq!(code, Some(2), "{told}");
        assert!(
            told.contains(key) && told.contains("rising order"),
            "{told}"
        );
    }
}

#[test]
fn interfaces_inside_out_are_refused() {
    let (code, _, output) = run(
        "two-rails",
        &[
            "interface.below.between=[\"lower.top\", \"third-body.lid\"]",
            "interface.above.between=[\"upper.bottom\", \"third-body.base\"]",
        ],
        &[],
    );
    let told = String::from_utf8_lossy(&output.stderr);
    assert_eq!(code, Some(2), "{told}");
    for part in ["below", "lower.top", "third-body.lid", "face the same way"] {
        assert!(told.contains(part), "{part}: {told}");
    }
}

#[test]
fn windows_accepted_without_convergence_are_counted_against_the_run() {
    let (code, summary, _) = run(
        "quick",
        &[
            SHORT,
            "interface.layer-base.on_not_converged=\"accept\"",
            "participant.third-body.config.solver.max_iterations=2",
        ],
        &[],
    );
    assert_eq!(code, Some(8));
    assert!(codes(&summary).contains(&"not_converged"), "{summary}");
}

#[test]
fn a_wheel_that_moves_at_once_under_its_load_is_suspect() {
    let key = "participant.third-body.config.wheel";
    let set = |name: &str| format!("{key}.{name}");
    let (code, summary, _) = run(
        "layer-alone",
        &["run.end_s=1e-5", &set("ramp_s=0.0"), &set("hold_s=0.0")],
        &[],
    );
    assert_eq!(code, Some(8), "{summary}");
    assert!(codes(&summary).contains(&"wheel_at_rest"), "{summary}");
    let short_ramp = [&set("ramp_s=2e-5")[..], &set("hold_s=0.0")];
    let (_, summary, _) = run(
        "layer-alone",
        &[&["run.end_s=3e-5"], &short_ramp[..]].concat(),
        &[],
    );
    let rest = |w: &&Value| w["code"] == "wheel_at_rest";
    let warnings = summary["warnings"].as_array().expect("a list");
    let value = warnings.iter().find(rest).map(|w| &w["value"]);
    assert!(
        value.is_some_and(|value| value.as_f64() > Some(0.05)),
        "the last force of a ramp of 0.02 ms is far off: {summary}"
    );
    let (_, summary, _) = run(
        "layer-alone",
        &[&["run.end_s=1e-5"], &short_ramp[..]].concat(),
        &[],
    );
    assert!(
        !codes(&summary).contains(&"wheel_at_rest"),
        "it is still being loaded: {summary}"
    );
}

#[test]
fn a_rail_too_heavy_to_come_to_rest_is_told() {
    let heavy = "participant.rail.config.material.density_kg_per_m3=1e7";
    let alone = "participant.third-body.config.wheel.cycles=0.0";
    let (code, summary, _) = run("quick", &[heavy, alone], &[]);
    // The approach is 2.7 % below that of a rail of steel.
    assert_eq!((code, codes(&summary)), (Some(0), vec!["wheel_drift"]));
}

#[test]
fn a_rough_tolerance_and_a_layer_under_stress_are_told() {
    let rough = "participant.third-body.config.solver.tolerance=0.05";
    let (_, summary, _) = run("quick", &["run.end_s=6e-5", rough], &[]);
    assert_eq!(codes(&summary), ["contact_residual"]);
    let advised = |pressures: &str| {
        let work = Scratch::new("prestress");
        let mut check = thirdbody(work.path());
        let set = format!("participant.third-body.config.sample.press_pa={pressures}");
        check
            .arg("check")
            .arg(folder("quick"))
            .args(["--set", &set]);
        let told = check.output().expect("the program starts");
        let told = [told.stdout, told.stderr].concat();
        let told = String::from_utf8_lossy(&told).into_owned();
        let flat: Vec<&str> = told.split_whitespace().collect();
        flat.join(" ").contains("sample.press_pa: the layer")
    };
    assert!(advised("[1e10]"));
    assert!(!advised("[1e9, 5e7]"), "the last pressure counts");
}

#[test]
fn a_tolerance_below_rounding_is_refused() {
    let set = "participant.third-body.config.solver.tolerance=1e-100";
    let (code, _, output) = run("quick", &[SHORT, set], &[]);
    let told = String::from_utf8_lossy(&output.stderr);
    assert_eq!(code, Some(2), "{told}");
    assert!(
        told.contains("solver.tolerance") && told.contains("1e-100"),
        "{told}"
    );
}

#[test]
fn a_key_without_meaning_is_a_warning_of_the_summary() {
    let set = "interface.layer-base.relaxation=0.5";
    let (code, summary, _) = run("quick", &[SHORT, set], &[]);
    assert_eq!((code, codes(&summary)), (Some(0), vec!["unused_key"]));
    assert_eq!(
        summary["warnings"][0]["where"],
        "interface.layer-base.relaxation"
    );
}

#[test]
fn energies_that_nobody_tells_are_said_to_be_missing() {
    let (code, summary, _) = run("verification/block-under-wheel", &[], &[]);
    assert_eq!(code, Some(0));
    let block = &summary["participants"]["block"];
    assert_eq!(block["ledger"], false);
    assert_eq!(block["energy_balance_rel"], Value::Null);
    assert_eq!(summary["results"]["energy_balance_rel"], Value::Null);
    let (_, summary, _) = run("quick", &[SHORT], &[]);
    assert_eq!(summary["participants"]["rail"].get("ledger"), None);
}
