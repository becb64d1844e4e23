//! Problem: a small crowned block under its wheel, in motion and in equilibrium, with every plausibility bound at zero or at a
//! huge number.
//! Exact: the findings at the end of a run, and the largest strain seen, in the hold, at a snapshot or at the end.
//! Source: the table of checks in the book (reference/findings.md).

use protocol::{Finding, Node};
use serde_json::{Value, json};

use crate::fem_bodies::{block, node, window, with};
use crate::fem_static_contact::solved;
use crate::fem_wheel::run;

const CHECKS: [&str; 6] = [
    "wheel_force_rel",
    "contact_reach_rel",
    "contact_resolution",
    "strain",
    "locking_rel",
    "cycle_drift_rel",
];

/// The block under a wheel of 500 N that then moves sideways for `cycles`, with all bounds at `bound`.
fn under_wheel(bound: f64, cycles: f64) -> Value {
    let bounds = CHECKS.map(|check| (check.to_string(), json!([bound, bound])));
    with(
        block(),
        json!({
            "wheel": {"load_n": 500.0, "mass_kg": 1e-3, "amplitude_m": 2e-6, "frequency_hz": 1e4,
                      "ramp_s": 2e-5, "hold_s": 1e-5, "cycles": cycles},
            "contact": {"friction": 0.3},
            "plausible": bounds.into_iter().collect::<serde_json::Map<_, _>>(),
        }),
    )
}

fn in_equilibrium(bound: f64, cycles: f64) -> Value {
    let increments =
        json!({"analysis": "static", "element": "q4_2x2", "statics": {"increment_n": 50.0}});
    let mut config = with(under_wheel(bound, cycles), increments);
    for key in ["ramp_s", "hold_s"] {
        config["wheel"][key] = json!(0.0);
    }
    config
}

fn codes(findings: &[Finding]) -> Vec<&str> {
    findings.iter().map(|f| f.code.as_str()).collect()
}

fn strain(findings: &[Finding]) -> f64 {
    let found = findings.iter().find(|finding| finding.code == "strain");
    found.expect("the bound is zero").value
}

#[test]
fn all_checks_of_a_body_in_motion_are_made() {
    let findings = |bound, cycles| {
        let mut body = node(&under_wheel(bound, cycles));
        run(&mut body, |_, _| {});
        body.finish().expect("it ends").findings
    };
    let all = [
        "strain",
        "locking",
        "wheel_at_rest",
        "contact_resolution",
        "contact_reach",
    ];
    assert_eq!(codes(&findings(0.0, 0.25)), all);
    assert_eq!(codes(&findings(1e300, 1.5)), [""; 0]);
    let cycled = findings(0.0, 1.5);
    assert!(codes(&cycled).contains(&"cycle_drift"), "{cycled:?}");
}

#[test]
fn all_checks_of_a_body_in_equilibrium_are_made() {
    let findings = |bound, cycles| {
        let mut body = solved(&in_equilibrium(bound, cycles));
        body.finish().expect("it ends").findings
    };
    let held = findings(0.0, 0.0);
    assert_eq!(
        codes(&held),
        ["strain", "locking", "contact_reach", "contact_resolution"]
    );
    assert_eq!(codes(&findings(1e300, 0.0)), [""; 0]);
    // The wheel then shears the block.
    let sheared = findings(0.0, 0.25);
    assert!(strain(&sheared) > 1.01 * strain(&held), "{sheared:?}");
}

#[test]
fn a_strain_at_a_snapshot_is_not_forgotten() {
    let config = with(
        block(),
        json!({"plausible": {"strain": [0.0, 0.0]}, "time": {"mass_damping_per_s": 1e6}}),
    );
    let largest = |seen: bool| {
        let mut body = node(&config);
        let points = body.couple("top").expect("a set").len();
        for (index, force) in [-50.0, 0.0].into_iter().enumerate() {
            let at = window(index as u64, 400);
            body.advance(&at, &vec![force; 2 * points]).expect("stable");
            body.commit(&at, &[]).expect("advanced");
            if seen {
                body.snapshot("loaded").expect("nothing is written");
            }
        }
        strain(&body.finish().expect("it ends").findings)
    };
    assert!(largest(true) > 2.0 * largest(false));
}

#[test]
fn a_contact_near_the_end_after_the_hold_is_reported() {
    let reach = |cycles: f64| {
        let mut config = under_wheel(0.0, cycles);
        let mesh = config["mesh"].as_object_mut().expect("a table");
        mesh.remove("crown_radius_m");
        // A round wheel takes its contact along, 1 mm in a quarter of a cycle.
        for (key, value) in [
            ("radius_m", 0.05),
            ("amplitude_m", 1e-3),
            ("frequency_hz", 1e3),
        ] {
            config["wheel"][key] = json!(value);
        }
        let mut body = node(&config);
        run(&mut body, |_, _| {});
        let findings = body.finish().expect("it ends").findings;
        let found = findings.iter().find(|f| f.code == "contact_reach");
        found.expect("the bound is zero").value
    };
    assert!(
        reach(0.25) > 1.2 * reach(0.0),
        "{} {}",
        reach(0.25),
        reach(0.0)
    );
}
