//! The shipped bonded layer between wheel and rail against the rail alone under the same wheel.
//!
//! A layer of 0.3 mm that is as stiff as the rail must hardly change the contact of the wheel. Expected, from the project's own
//! quasi-static model (condensed rail, damped disks): over means of 1 mm, |x| <= 9 mm, L2 distance of the pressure at
//! most 8 %, peak within 10 %, approach larger by 0 to 2.5 %; in the cycle, lateral force at D = 0 within 6 % of 591.6 N, the
//! force with the rail alone.

use std::path::Path;

use harness::runs::read_csv;
use harness::runs::{Scratch, parse_json, thirdbody};
use serde_json::Value;

/// Runs a shipped scene into the scratch folder and returns its summary.
fn run(work: &Path, scene: &str, sets: &[&str]) -> Value {
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenarios");
    let mut command = thirdbody(work);
    command
        .arg("run")
        .arg(scenes.join(scene))
        .args(["--out", scene, "--json"]);
    for set in sets {
        command.args(["--set", set]);
    }
    let output = command.output().expect("the program starts");
    let printed = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{printed}");
    let summary = parse_json(&output.stdout);
    assert_eq!(summary["warnings"], serde_json::json!([]), "{scene}");
    summary
}

/// Mean pressures over 1 mm at x = -9, -8, .., 9 mm (Pa), of surface nodes 0.2 mm apart.
fn means(profile: &Path) -> Vec<f64> {
    let columns = read_csv(profile);
    let mut sums = vec![0.0; 19];
    for (x, p) in columns["x_m"].iter().zip(&columns["pressure_pa"]) {
        let bin = (x / 1e-3).round() + 9.0;
        if (0.0..19.0).contains(&bin) {
            sums[bin as usize] += 0.2 * p;
        }
    }
    sums
}

#[test]
fn a_matched_layer_carries_the_wheel_like_the_rail_alone() {
    let work = Scratch::new("wheel-rail");
    let hold = "participant.rail.config.wheel.cycles=0.0";
    let alone = run(work.path(), "wheel-rail-fe-small", &[hold]);
    let cycle = "participant.third-body.config.wheel.cycles=1.0";
    let coupled = run(work.path(), "wheel-rail-coupled", &[cycle]);
    let profile = |scene: &str| means(&work.path().join(scene).join("profile.csv"));
    let (rail, layer) = (
        profile("wheel-rail-fe-small"),
        profile("wheel-rail-coupled"),
    );
    let square = |values: &mut dyn Iterator<Item = f64>| values.map(|v| v * v).sum::<f64>();
    let off = square(&mut rail.iter().zip(&layer).map(|(a, b)| a - b));
    let distance = (off / square(&mut rail.iter().copied())).sqrt();
    let peak = |means: &[f64]| means.iter().copied().fold(0.0, f64::max);
    let peaks = peak(&layer) / peak(&rail);
    let approach = |summary: &Value| summary["results"]["approach_m"].as_f64();
    let approach = approach(&coupled).zip(approach(&alone)).expect("both hold");
    let lateral = at_zero(&work.path().join("wheel-rail-coupled/signals.csv"));
    println!(
        "L2 {distance:.4}, peaks {:.4e} / {:.4e} Pa, approach {approach:?} m, at D = 0 {lateral:?} N",
        peak(&layer),
        peak(&rail)
    );
    assert!((peak(&rail) / 1.048e9 - 1.0).abs() < 0.01, "the rail alone");
    assert!(distance < 0.08, "L2 {distance}");
    assert!((peaks - 1.0).abs() < 0.1, "peaks {peaks}");
    let more = approach.0 / approach.1 - 1.0;
    assert!((0.0..0.025).contains(&more), "approach {more}");
    // The last crossing ends the cycle.
    let last = lateral.last().expect("it crosses").abs();
    assert!((last / 591.6 - 1.0).abs() < 0.06, "{lateral:?}");
}

/// Lateral force on the wheel where it passes D = 0 (N), without the start of its motion.
fn at_zero(signals: &Path) -> Vec<f64> {
    let columns = read_csv(signals);
    let (x, force) = (
        &columns["third-body.wheel_x_m"],
        &columns["third-body.wheel_ft_n"],
    );
    let steps = (1..x.len()).filter(|i| x[i - 1] != 0.0 && x[i - 1] * x[*i] <= 0.0);
    steps.map(|i| force[i]).collect()
}
