//! Steps in which grains travel too far for detection, or for the scheme of their fall.
//!
//! ```text
//!   O -> 5 R per step    1 mm apart, they never touch; but a long step detects along the normal and stops the first
//!        O
//! ```
//!
//! Exact: no force acts on disks that do not touch (Newton's first law). A fall by implicit Euler reaches g t after t (Hairer, Norsett
//! and Wanner 1993), so its last step of h covers g t h. Tolerance: rounding.

use protocol::{Finding, Node};
use serde_json::{Value, json};

use crate::dem_support::{build, close, march, scene, setting};

const R: f64 = 1e-3;
const G: f64 = 9.81;

/// Findings, warnings and the first disk's speed after some steps of a scene.
fn run(step: f64, steps: u32, sample: Value, overrides: Value) -> (Vec<Finding>, Vec<String>, f64) {
    let law = json!({"kind": "coulomb", "friction": 0.3});
    let mut dem = build(&scene(law, step, sample, overrides));
    march(&mut dem, 0, steps);
    let findings = dem.finish().expect("it ends").findings;
    let [x, y, _] = dem.state().velocities[0];
    (findings, dem.describe().warnings, x.hypot(y))
}

fn found(findings: &[Finding]) -> Vec<(&str, bool)> {
    let found = findings.iter().filter(|f| f.code == "grain_travel");
    found.map(|f| (f.code.as_str(), f.suspect)).collect()
}

fn disk(x: f64, y: f64, vx: f64, vy: f64) -> Value {
    json!({"x_m": x, "y_m": y, "radius_m": R, "vx_m_per_s": vx, "vy_m_per_s": vy})
}

#[test]
fn a_disk_that_passes_another_in_long_steps_is_suspect_and_predicted() {
    let passing = json!({"kind": "disks", "disks": [disk(-20.0 * R, 3.0 * R, 5.0, 0.0), disk(0.0, 0.0, 0.0, 0.0)]});
    let (findings, warnings, speed) = run(1e-3, 20, passing.clone(), json!({}));
    assert!(speed < 4.9, "the other disk stops it: {speed}");
    assert_eq!(found(&findings), [("grain_travel", true)]);
    let finding = findings.iter().find(|f| f.code == "grain_travel");
    close("radii", finding.expect("it is there").value, 5.0, 1e-12);
    assert!(
        warnings
            .iter()
            .any(|w| w.contains("5.000 of the smallest radius")),
        "{warnings:?}"
    );
    let (findings, warnings, speed) = run(1e-5, 2000, passing, json!({}));
    close("speed", speed, 5.0, 0.0);
    assert!(
        found(&findings).is_empty() && warnings.is_empty(),
        "{findings:?} {warnings:?}"
    );
}

#[test]
fn a_fall_in_long_steps_is_suspect_and_predicted() {
    let floor = json!([{"x_m": 0.0, "y_m": 0.0, "nx": 0.0, "ny": 1.0}]);
    let fall = |theta: f64, step: f64, height: f64| {
        let sample =
            json!({"kind": "disks", "disks": [disk(0.0, R + height, 0.0, 0.0)], "walls": floor});
        let time = json!({"step_s": step, "theta": theta, "pressure_pa": 1.0, "end_s": 0.04});
        let overrides = json!({"gravity_m_per_s2": [0.0, -G], "time": time});
        run(step, (0.04 / step).round() as u32, sample, overrides)
    };
    let (findings, warnings, speed) = fall(1.0, 5e-3, 0.01);
    close("speed", speed, G * 0.04, 1e-14);
    let finding = findings.iter().find(|f| f.code == "grain_travel");
    close(
        "radii",
        finding.expect("it is there").value,
        G * 0.04 * 5e-3 / R,
        1e-12,
    );
    assert!(
        warnings
            .iter()
            .any(|w| w.contains("1.962 of the smallest radius")),
        "{warnings:?}"
    );
    // The midpoint rule makes no error before the disk lands.
    assert!(found(&fall(0.5, 5e-3, 0.01).0).is_empty());
    let (findings, warnings, _) = fall(1.0, 1e-4, 0.01);
    assert!(
        found(&findings).is_empty() && warnings.is_empty(),
        "{findings:?} {warnings:?}"
    );
    // At rest on the floor it cannot fall, in a step of any length.
    let (findings, warnings, _) = fall(1.0, 5e-3, 0.0);
    assert!(
        found(&findings).is_empty() && warnings.is_empty(),
        "{findings:?} {warnings:?}"
    );
}

#[test]
fn only_travel_past_grains_and_into_walls_counts() {
    // Neither a row of grains with one velocity nor a slide along a smooth floor changes the geometry.
    let train =
        json!({"kind": "disks", "disks": [disk(0.0, R, 50.0, 0.0), disk(2.0 * R, R, 50.0, 0.0)]});
    let (findings, warnings, _) = run(1e-3, 20, train, json!({}));
    assert!(
        found(&findings).is_empty() && warnings.is_empty(),
        "{findings:?} {warnings:?}"
    );
    let floor = json!([{"x_m": 0.0, "y_m": 0.0, "nx": 0.0, "ny": 1.0}]);
    let slide = json!({"kind": "disks", "disks": [disk(0.0, R, 5.0, 0.0)], "walls": floor});
    let gravity = json!({"gravity_m_per_s2": [0.0, -G], "law": {"kind": "signorini"}});
    let (findings, warnings, _) = run(1e-3, 20, slide, gravity);
    assert!(
        found(&findings).is_empty() && warnings.is_empty(),
        "{findings:?} {warnings:?}"
    );
    // A wall approaches with 2 radii per step.
    let wall = json!([{"x_m": -20.0 * R, "y_m": 0.0, "nx": 1.0, "ny": 0.0, "velocity_m_per_s": [2.0, 0.0]}]);
    let hit = json!({"kind": "disks", "disks": [disk(0.0, R, 0.0, 0.0)], "walls": wall});
    let (findings, warnings, _) = run(1e-3, 20, hit, json!({}));
    assert_eq!(found(&findings), [("grain_travel", true)]);
    assert!(
        warnings
            .iter()
            .any(|w| w.contains("2.000 of the smallest radius")),
        "{warnings:?}"
    );
}

#[test]
fn scaled_masses_raise_a_warning_where_grains_fall() {
    let advice = |scale: f64, gravity: f64| {
        let sample = json!({"kind": "disks", "disks": [disk(0.0, 2.0 * R, 0.0, 0.0)]});
        let overrides = json!({"mass_scale": scale, "gravity_m_per_s2": [0.0, gravity]});
        let config = scene(json!({"kind": "signorini"}), 1e-5, sample, overrides);
        dem_node::check(&config, &setting(1))
            .expect("it is valid")
            .join(" ")
    };
    let warning = advice(1000.0, -G);
    assert!(
        warning.contains("mass_scale") && warning.contains("9.81e-3 m/s2"),
        "{warning}"
    );
    assert_eq!([advice(1.0, -G), advice(1000.0, 0.0)], ["", ""]);
}
