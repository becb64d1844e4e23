//! The flat wheel: its sideways motion is prescribed, its height follows the load.
//!
//! ```text
//!   =====  -> D(t)      wheel
//!     O                 a disk between wheel and floor that does not slip rolls with half the wheel's speed
//!   =====               floor
//! ```
//!
//! Exact by kinematics (v = V/2, spin = -V/2R) and statics (F_N = load). If the wheel's inverse mass in x were not
//! zero, friction would carry a wheel of a milligram along. Tolerance: the true residual 1e-12.

use protocol::{Finding, Node};
use serde_json::{Value, json};

use crate::dem_support::{THICKNESS, build, close, march, mass, scene};

const RADIUS: f64 = 1e-3;
const LOAD: f64 = 2.0;
const AMPLITUDE: f64 = 1e-4;
const FREQUENCY: f64 = 10.0;
const START: f64 = 2e-3;

fn roller(friction: f64, wheel_mass: f64) -> Value {
    let sample = json!({
        "kind": "disks",
        "disks": [{"x_m": 0.0, "y_m": RADIUS, "radius_m": RADIUS}],
        "walls": [{"x_m": 0.0, "y_m": 0.0, "nx": 0.0, "ny": 1.0}],
    });
    let wheel = json!({
        "load_n": LOAD, "mass_kg": wheel_mass, "amplitude_m": AMPLITUDE, "frequency_hz": FREQUENCY,
        "ramp_s": 1e-3, "hold_s": START - 1e-3, "cycles": 2.0,
    });
    scene(
        json!({"kind": "coulomb", "friction": friction}),
        1e-4,
        sample,
        json!({"wheel": wheel}),
    )
}

#[test]
fn a_disk_under_the_wheel_rolls_with_half_its_speed() {
    let mut dem = build(&roller(0.3, 1e-6));
    let turn = std::f64::consts::TAU * FREQUENCY;
    for step in 0..1000 {
        let report = march(&mut dem, step, 1);
        let drive = |t: f64| AMPLITUDE * (turn * (t - START).max(0.0)).sin();
        let (start, end) = (step as f64 * 1e-4, (step + 1) as f64 * 1e-4);
        let speed = (drive(end) - drive(start)) / 1e-4;
        close("D", report.signal("wheel_x_m"), drive(end), 1e-18);
        let [vx, _, spin] = dem.state().velocities[0];
        close("speed of the disk", vx, 0.5 * speed, 1e-9);
        close("spin of the disk", spin, -0.5 * speed, 1e-9);
        // A rigid disk passes the load on at once, so F_N is the load at the end of the step, also in the ramp.
        let load = LOAD * (end / 1e-3).min(1.0);
        close("normal force", report.signal("wheel_fn_n"), load, 1e-9);
    }
}

/// Exact bits, without a tolerance: any inverse mass in x would let the smallest force move the wheel.
#[test]
fn no_lateral_force_moves_the_wheel_sideways() {
    for (kind, load, curvature) in [
        ("nsgs", LOAD, 0.0),
        ("nsgs", 1e9, 0.0),
        ("nsgs", LOAD, 5e-3),
        ("pcg", LOAD, 0.0),
        ("pcg", 1e9, 0.0),
        ("pcg", LOAD, 5e-3),
    ] {
        let mut config = roller(0.3, 1e-6);
        config["solver"] =
            json!({"kind": kind, "tolerance": 1e-8, "max_iterations": 20_000, "min_iterations": 1});
        config["time"]["step_s"] = json!(1e-7);
        config["sample"]["disks"][0]["vx_m_per_s"] = json!(50.0);
        config["wheel"]["load_n"] = json!(load);
        config["wheel"]["radius_m"] = json!(curvature);
        config["wheel"]["cycles"] = json!(0.0);
        let mut dem = build(&config);
        let mut pull = 0.0f64;
        for step in 0..10 {
            let report = march(&mut dem, step, 1);
            pull = pull.max(report.signal("wheel_ft_n").abs());
            assert_eq!(report.signal("wheel_x_m"), 0.0, "{kind}");
            assert_eq!(dem.state().wheel.velocity[0], 0.0, "{kind}");
        }
        assert!(pull > 1e-6 * load, "{kind} {load:e}: {pull:e}");
    }
}

#[test]
fn a_slipping_wheel_pulls_with_friction_times_load() {
    // Friction 1e-4 is too weak to take the disk along: the wheel slips, and F_T = mu F_N opposes its motion. The
    // disk rolls on the floor: m a = mu N + f and m a / 2 = mu N - f give a = 4 mu N / 3 m with f = mu N / 3 < mu N.
    let mut config = roller(1e-4, 1e-6);
    config["mass_scale"] = json!(1e4);
    config["wheel"]["cycles"] = json!(0.1);
    let mut dem = build(&config);
    let report = march(&mut dem, 0, 30);
    close(
        "tangential force",
        report.signal("wheel_ft_n"),
        -1e-4 * LOAD,
        1e-12,
    );
    let [vx, _, spin] = dem.state().velocities[0];
    let gained = 4.0 * 1e-4 * LOAD / (3.0 * mass(RADIUS) * 1e4) * 10.0 * 1e-4;
    close("speed of the disk", vx, gained, 1e-9);
    close("it turns clockwise", spin, -gained, 1e-9);
    let slipped = report.energy("friction");
    let drive = report.energy("wheel_drive");
    assert!(
        slipped > 0.0 && drive > slipped,
        "the drive does the work of the slip: {drive:e} {slipped:e}"
    );
}

#[test]
fn the_results_give_load_force_and_loop() {
    let mut dem = build(&roller(0.3, 1e-3));
    march(&mut dem, 0, 2020);
    let outcome = dem.finish().expect("it finishes");
    let result = |name: &str| outcome.results[name];
    close("load", result("load_n"), LOAD, 0.0);
    close("force in the hold", result("wheel_force_n"), LOAD, 1e-9);
    close(
        "a rigid disk does not yield",
        result("approach_m"),
        0.0,
        1e-12,
    );
    close(
        "wheel height while cycling",
        result("wheel_y_range_over_r"),
        0.0,
        1e-9,
    );
    for name in [
        "wheel_contacts",
        "wheel_contacts_90",
        "wheel_contacts_90_motion",
    ] {
        assert_eq!(result(name), 1.0, "{name}");
    }
    let reported: Vec<&Finding> = outcome.findings.iter().collect();
    assert!(
        matches!(reported[..], [one] if one.code == "wheel_contacts" && !one.suspect && one.value == 1.0),
        "{reported:?}"
    );
    // Rolling only takes the disk's kinetic energy, which the disk returns.
    assert!(result("loop_area_j").abs() < 1e-6 * LOAD * AMPLITUDE);
    assert_eq!(outcome.steps, 2020);
    assert!(outcome.work["contact_iterations"] > 2020.0);
    let phases: Vec<String> = dem.describe().phases.into_iter().map(|p| p.name).collect();
    assert_eq!(phases, ["ramp", "hold", "cycling"]);
}

/// Disks lie side by side between wheel and floor, with a spring k to each. A disk of the radius r + F / k carries F more than one of
/// the radius r. With shares of 0.32, 0.6 and 0.08 of the load, two disks carry 0.92. With 0.5, 0.3 and 0.2, three are needed.
#[test]
fn contacts_are_counted_from_the_strongest_until_nine_tenths_are_carried() {
    const STIFFNESS: f64 = 1e5;
    for (shares, needed) in [([0.32, 0.6, 0.08], 2.0), ([0.5, 0.3, 0.2], 3.0)] {
        let disks = shares.iter().zip(-1..).map(|(share, place)| {
            let radius = RADIUS + share * LOAD / STIFFNESS;
            json!({"x_m": 3.0 * RADIUS * f64::from(place), "y_m": radius, "radius_m": radius})
        });
        let mut config = roller(0.0, 1e-3);
        config["law"] = json!({"kind": "signorini", "contact_stiffness_pa": STIFFNESS / THICKNESS});
        config["sample"]["disks"] = disks.collect();
        config["wheel"]["hold_s"] = json!(0.1);
        config["wheel"]["cycles"] = json!(0.0);
        let mut dem = build(&config);
        march(&mut dem, 0, 1010);
        let results = dem.finish().expect("it finishes").results;
        assert_eq!(results["wheel_contacts"], 3.0);
        assert_eq!(results["wheel_contacts_90"], needed, "{shares:?}");
        assert!(!results.contains_key("wheel_contacts_90_motion"));
    }
}
