//! Terms of the energy ledger between two steps: changes of gaps that detection finds after a step, and repairs of overlaps.
//!
//! ```text
//!   (O) -> v        the disks of a pressed pair pass each other: the normal turns, the gap opens by (h v)^2 / (2 (r_1 + r_2))
//!   (O)
//!   ---- W ----     a disk that overlaps its floor is lifted against its weight and the load of a wheel
//!     (O)
//!   ===========
//! ```
//!
//! Exact: if a step leaves a spring k at the gap g and detection finds g', the spring has lost k (g^2 - g'^2) / 2, without any work. A
//! repair lifts by the overlap less a millionth of the radius, against m g and F. Tolerances: rounding of positions, 1e-16 m
//! of 1e-5 m.

use dem_node::Dem;
use protocol::{Finding, Node, Window};
use serde_json::{Value, json};

use crate::dem_support::{Report, build, close, march, mass, scene};

const R: f64 = 1e-3;
/// k of the springs (N/m).
const STIFFNESS: f64 = 1e7;
const H: f64 = 1e-7;

/// Two disks, one above the other, that overlap by 1 % of a radius and pass each other at this speed (m/s).
fn passing(speed: f64) -> Value {
    let law = json!({"kind": "signorini", "contact_stiffness_pa": 1e10});
    let disks = json!([
        {"x_m": 0.0, "y_m": 0.0, "radius_m": R},
        {"x_m": 0.0, "y_m": 1.99 * R, "radius_m": R, "vx_m_per_s": speed},
    ]);
    let mut config = scene(law, H, json!({"kind": "disks", "disks": disks}), json!({}));
    // Detection then takes place at the start of a step.
    config["time"]["theta"] = json!(1.0);
    config
}

/// Gap of the pair at its present place, and at the end of its step (m).
fn gaps(dem: &Dem) -> [f64; 2] {
    let [a, b] = [dem.state().centres[0], dem.state().centres[1]];
    let distance = (b[0] - a[0]).hypot(b[1] - a[1]);
    [distance - 2.0 * R, dem.state().list.slots[0].last_gap]
}

/// Losses at detection in nine steps, in which the pair stays in contact: their sum, and the sum of their absolute deviations from the
/// opening s^2/(2 d) of a pair that passes by s at the distance d (J).
fn jumps(dem: &mut Dem) -> ([f64; 2], Report) {
    let mut sums = [0.0; 2];
    let mut report = None;
    for step in 0..9 {
        let [found, left] = gaps(dem);
        let ([a, b], distance) = ([0, 1].map(|i| dem.state().centres[i]), 2.0 * R + found);
        let [u, v] = [0, 1].map(|i| dem.state().velocities[i]);
        let past = ((b[0] - a[0]) * (v[1] - u[1]) - (b[1] - a[1]) * (v[0] - u[0])) / distance;
        let turned = left + (H * past).powi(2) / (2.0 * distance);
        let lost = |gap: f64| 0.5 * STIFFNESS * (gap * gap - found * found);
        sums = [sums[0] + lost(left), sums[1] + lost(turned).abs()];
        report = Some(march(dem, step, 1));
    }
    (sums, report.expect("nine steps"))
}

fn finding(dem: &mut Dem, code: &str) -> Option<Finding> {
    let outcome = dem.finish().expect("it finishes");
    outcome
        .findings
        .into_iter()
        .find(|found| found.code == code)
}

#[test]
fn a_turning_contact_loses_the_energy_of_the_opening_at_detection() {
    let mut dem = build(&passing(200.0));
    march(&mut dem, 0, 1);
    // 20 um past each other: 0.1 um of 10 um overlap.
    let [found, left] = gaps(&dem);
    close(
        "opened",
        found - left,
        (200.0 * H).powi(2) / (2.0 * 1.99 * R),
        1e-3 * 1e-7,
    );

    let mut dem = build(&passing(200.0));
    let energy = 0.5 * STIFFNESS * (0.01 * R).powi(2);
    let before = dem.state().kinetic(dem.bodies());
    let ([sum, size], report) = jumps(&mut dem);
    assert!(sum > 0.05 * energy, "{sum:e} of {energy:e}");
    close("detection", report.energy("detection"), sum, 1e-10 * energy);
    assert!(report.imbalance(before) < 1e-12);
    let kept = ["kinetic", "springs_normal", "numerical"].map(|term| report.energy(term).abs());
    let value = size / kept.iter().sum::<f64>();
    let found = finding(&mut dem, "detection").expect("it is far beyond its bounds");
    close("value", found.value, value, 1e-9 * value);
    assert!(!found.suspect && found.bound == 5e-3, "{found:?}");
}

#[test]
fn detection_does_not_change_a_contact_that_does_not_turn() {
    let mut config = passing(0.0);
    config["sample"]["disks"][1]["vy_m_per_s"] = json!(-1.0);
    let mut dem = build(&config);
    let ([_, size], report) = jumps(&mut dem);
    let energy = 0.5 * STIFFNESS * (0.01 * R).powi(2);
    assert!(size < 1e-10 * energy, "{size:e}");
    assert!(report.energy("detection").abs() < 1e-10 * energy);
    assert_eq!(finding(&mut dem, "detection"), None);
}

/// The bounds lie above or below the value of nine steps at this speed.
#[test]
fn the_bounds_of_detection_are_keys() {
    let with = |bounds: [f64; 2]| {
        let mut config = passing(200.0);
        config["plausible"] = json!({"detection_rel": bounds});
        let mut dem = build(&config);
        jumps(&mut dem);
        finding(&mut dem, "detection").map(|found| found.suspect)
    };
    assert_eq!(with([1e6, 1e7]), None);
    assert_eq!(with([1e-6, 1e7]), Some(false));
    assert_eq!(with([1e-6, 1e-5]), Some(true));
}

const OVERLAP: f64 = 4e-3 * R;
const GRAVITY: f64 = 10.0;

/// A disk that overlaps its floor.
fn sunk(penetration: &str, overrides: Value) -> Value {
    let law = json!({"kind": "signorini", "penetration": penetration});
    let sample = json!({
        "kind": "disks", "disks": [{"x_m": 0.0, "y_m": R - OVERLAP, "radius_m": R}],
        "walls": [{"x_m": 0.0, "y_m": 0.0, "nx": 0.0, "ny": 1.0}],
    });
    let mut config = scene(law, 1e-5, sample, overrides);
    config["gravity_m_per_s2"] = json!([0.0, -GRAVITY]);
    config
}

#[test]
fn a_repair_is_work_against_the_weight_and_is_listed_as_such() {
    for penetration in ["split", "projection"] {
        let report = march(&mut build(&sunk(penetration, json!({}))), 0, 1);
        let lift = OVERLAP - 1e-6 * R;
        let work = -mass(R) * GRAVITY * lift;
        close("weight", report.energy("weight"), work, 1e-9 * work.abs());
        close("repair", report.energy("repair"), work, 1e-9 * work.abs());
        assert!(report.imbalance(0.0) < 1e-9, "{penetration}");
    }
    let kept = build(&sunk("iqs", json!({}))).describe();
    assert!(kept.ledger.iter().all(|term| term.name != "repair"));
}

#[test]
fn a_repair_is_work_against_the_load_of_a_wheel() {
    let wheel = json!({"load_n": 50.0, "mass_kg": 0.01, "ramp_s": 1e-5, "hold_s": 1e-3});
    for penetration in ["split", "projection"] {
        let config = sunk(penetration, json!({ "wheel": wheel }));
        let mut dem = build(&config);
        let start = dem.state().wheel.position[1];
        let report = march(&mut dem, 0, 1);
        let lift = report.signal("wheel_y_m") - start;
        // A wheel 400 times as heavy as the disk is not lifted completely at once: the next step repairs the rest.
        assert!(lift > 0.5 * OVERLAP, "{lift:e}");
        // Only the repair moves anything, so the disk carries the load.
        let work = -report.signal("wheel_fn_n") * lift;
        assert!(work < -40.0 * lift, "{work:e}");
        close("load", report.energy("wheel_load"), work, 1e-6 * work.abs());
        let both = report.energy("wheel_load") + report.energy("weight");
        close("repair", report.energy("repair"), both, 1e-9 * work.abs());
        assert!(report.imbalance(0.0) < 1e-9, "{penetration}");
    }
}

/// A row of overlapping disks: one sweep does not repair it, although the step itself has nothing to solve.
#[test]
fn a_repair_that_does_not_converge_ends_the_run_by_its_name() {
    let disks: Vec<Value> = (0..20)
        .map(|i| json!({"x_m": (2.0 * R - OVERLAP) * f64::from(i), "y_m": 0.0, "radius_m": R}))
        .collect();
    for penetration in ["split", "projection"] {
        let law = json!({"kind": "signorini", "penetration": penetration});
        let solver =
            json!({"kind": "nsgs", "tolerance": 1e-6, "max_iterations": 1, "min_iterations": 1});
        let overrides = json!({ "solver": solver });
        let mut dem = build(&scene(
            law,
            1e-5,
            json!({"kind": "disks", "disks": disks}),
            overrides,
        ));
        let window = Window {
            substeps: 1,
            ..Window::default()
        };
        let error = dem
            .advance_alone(&window)
            .expect_err("one sweep")
            .to_string();
        for part in [
            "repair of overlaps",
            "law.penetration",
            "solver.max_iterations",
        ] {
            assert!(error.contains(part), "{part}: {error}");
        }
    }
}
