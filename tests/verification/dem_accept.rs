//! Steps of an uncoupled run that end above the tolerance: they stop the run, or are accepted and counted.

use protocol::{Node, Window};
use serde_json::{Value, json};

use crate::dem_support::{build, close, scene};

const R: f64 = 1e-3;

/// A column of disks on a wall, which a single sweep cannot solve.
fn hasty(policy: Value) -> Value {
    let disk = |i: u32| json!({"x_m": 0.0, "y_m": R * (1.0 + 2.0 * f64::from(i)), "radius_m": R});
    let sample = json!({
        "kind": "disks",
        "disks": (0..6).map(disk).collect::<Vec<_>>(),
        "walls": [{"x_m": 0.0, "y_m": 0.0, "nx": 0.0, "ny": 1.0}],
    });
    let mut config = scene(
        json!({"kind": "coulomb", "friction": 0.3}),
        1e-5,
        sample,
        json!({"gravity_m_per_s2": [0.0, -9.81]}),
    );
    config["solver"]["max_iterations"] = json!(1);
    config["solver"]["on_not_converged"] = policy;
    config
}

#[test]
fn a_step_above_the_tolerance_stops_the_run_or_is_accepted_and_makes_it_suspect() {
    let window = Window {
        substeps: 4,
        ..Window::default()
    };
    let stopped = build(&hasty(json!("stop"))).advance_alone(&window);
    assert!(stopped.is_err(), "{stopped:?}");
    let mut accepting = build(&hasty(json!("accept")));
    accepting
        .advance_alone(&window)
        .expect("steps that do not converge are accepted");
    let findings = accepting.finish().expect("the run can end").findings;
    let found = findings
        .iter()
        .find(|finding| finding.code == "not_converged");
    let found = found.expect("it is reported");
    close("share", found.value, 1.0, 0.0);
    assert!(
        found.suspect && found.text.starts_with("4 of 4 steps"),
        "{}",
        found.text
    );
}
