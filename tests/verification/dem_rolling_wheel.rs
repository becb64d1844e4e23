//! A smooth wheel that rolls over grains.
//!
//! ```text
//!   :   ( o -> )   :     the wheel comes round where the strip repeats; the seam (:) has no effect
//!   :O O OOO O O O :
//! ```
//!
//! Reference: invariance under translation and mirroring; the balance of energy; a disk in `scenarios/rolling/disk-under-wheel`. Tolerance: rounding of
//! positions, times the condition of a heap.

use dem_node::Dem;
use protocol::Node;
use serde_json::{Value, json};

use crate::dem_support::{build, close, march, refusal, scene};

const R: f64 = 1e-4;
const LENGTH: f64 = 25.0 * R;

/// Two rows of disks on a floor under a wheel that rolls along the strip, shifted by `shift` and folded back, or mirrored.
fn layer(shift: f64, mirror: f64, rolling: Value) -> Value {
    let disk = |i: i32| {
        let (column, row) = (i % 12, i / 12);
        let x = mirror * R * (2.05 * f64::from(column) + 0.9 * f64::from(row % 2)) + shift;
        let radius = R * [0.95, 0.9, 0.8, 0.85, 0.9][i as usize % 5];
        json!({"x_m": x.rem_euclid(LENGTH), "y_m": R * (1.0 + 1.7 * f64::from(row)), "radius_m": radius})
    };
    let disks: Vec<Value> = (0..24).map(disk).collect();
    let mut wheel = json!({
        "load_n": 20.0, "mass_kg": 1e-3, "radius_m": 0.02, "ramp_s": 1e-4, "hold_s": 1e-4,
        "rolling": {"speed_m_per_s": 4.0 * mirror, "distance_m": 1.5 * LENGTH, "start_m": shift + mirror * 8.0 * R},
    });
    for (key, value) in rolling.as_object().into_iter().flatten() {
        wheel["rolling"][key] = value.clone();
    }
    let law = json!({"kind": "coulomb", "friction": 0.3, "contact_stiffness_pa": 1e10, "tangential_stiffness_ratio": 0.5, "damping": 0.3});
    let walls = json!([{"x_m": 0.0, "y_m": 0.0, "nx": 0.0, "ny": 1.0}]);
    let strip =
        json!({"kind": "disks", "disks": disks, "periodic_x_m": [0.0, LENGTH], "walls": walls});
    scene(law, 2e-7, strip, json!({"wheel": wheel}))
}

/// The layer after the load and the whole way.
fn rolled(config: &Value) -> Dem {
    let mut dem = build(config);
    let end = dem.describe().end_s.expect("its wheel has a way");
    march(&mut dem, 0, (end / 2e-7).round() as u32);
    dem
}

/// A way across the seam, short enough that rounding does not grow to another heap.
fn creepage(value: f64) -> Value {
    json!({"creepage": value, "distance_m": 0.15 * LENGTH})
}

/// Rounding grows in a heap, and not in a row whose disks do not touch each other.
#[test]
fn the_seam_has_no_effect_on_a_wheel_that_comes_round() {
    let heap = |shift: f64| layer(shift, 1.0, creepage(0.3));
    let cases: [(&dyn Fn(f64) -> Value, f64); 2] = [(&heap, 1e-7), (&row, 1e-12)];
    for (scene, tolerance) in cases {
        let [one, other] = [0.0, 0.6 * LENGTH].map(|shift| rolled(&scene(shift)));
        let speeds = |dem: &Dem| dem.state().velocities.concat();
        let largest = speeds(&one)
            .iter()
            .fold(0.0, |most: f64, v| most.max(v.abs()));
        assert!(largest > 0.1, "{largest}");
        for (a, b) in speeds(&one).into_iter().zip(speeds(&other)) {
            close("velocity", b, a, tolerance * largest);
        }
    }
}

#[test]
fn a_mirrored_wheel_has_mirrored_grains_and_the_same_results() {
    let [mut one, mut other] = [1.0, -1.0].map(|mirror| rolled(&layer(0.0, mirror, creepage(0.3))));
    let pairs = one.state().velocities.iter().zip(&other.state().velocities);
    for (a, b) in pairs {
        for (k, sign) in [-1.0, 1.0, -1.0].into_iter().enumerate() {
            close("velocity", sign * b[k], a[k], 1e-5);
        }
    }
    let [one, other] = [&mut one, &mut other].map(|dem| dem.finish().expect("it ends").results);
    for name in [
        "creepage",
        "traction_ratio_mean",
        "slip_dissipation_j_per_m",
    ] {
        close(name, other[name], one[name], 1e-6 * one[name].abs());
    }
    assert!(
        one["creep_force_n"] > 0.5,
        "it brakes: {}",
        one["creep_force_n"]
    );
}

/// A braking torque of 1 N at the face: it is the mean creep force, and all energies are accounted for.
#[test]
fn a_wheel_that_spins_freely_takes_the_force_of_its_brake() {
    let free = json!({"force_n": 1.0, "spin_inertia_kg_m2": 4e-8, "ramp_m": 0.5 * LENGTH});
    for solver in ["nsgs", "pcg"] {
        let mut config = layer(0.0, 1.0, free.clone());
        config["solver"]["kind"] = json!(solver);
        let mut dem = build(&config);
        let description = dem.describe();
        let steps = (description.end_s.expect("it ends") / 2e-7).round() as u32;
        let report = march(&mut dem, 0, steps);
        let defect = report.imbalance(0.0);
        assert!(defect < 1e-9, "{solver}: {defect:e} of the energy");
        let results = dem.finish().expect("it ends").results;
        let force = results["creep_force_n"];
        assert!((force - 1.0).abs() < 0.3, "{solver}: {force} N");
        assert!(
            results["creepage"].abs() < 0.05,
            "{solver}: {}",
            results["creepage"]
        );
    }
}

/// A row of disks that do not touch each other, below a face that slides without turning, shifted by `shift` and folded back.
fn row(shift: f64) -> Value {
    let disk = |i: i32| {
        let x = R * (2.5 * f64::from(i) + 1.25) + shift;
        json!({"x_m": x.rem_euclid(LENGTH), "y_m": R, "radius_m": R})
    };
    let disks: Vec<Value> = (0..10).map(disk).collect();
    let mut config = layer(shift, 1.0, json!({"creepage": 1.0, "distance_m": LENGTH}));
    config["sample"]["disks"] = json!(disks);
    config["law"]["friction"] = json!(0.9);
    config["wheel"]["radius_m"] = json!(10.0);
    config
}

/// Disks between a floor and a face that slides without turning roll: their velocity grows linearly from the floor to the face, so that each fifth of
/// their height takes up a fifth of the creepage, and nothing slips. All of them are loose, and those under the wheel count.
#[test]
fn disks_that_roll_take_up_the_creepage_in_equal_parts() {
    let results = rolled(&row(0.0)).finish().expect("it ends").results;
    let sites = kit::rolled::LAYER[..kit::rolled::SITES].iter();
    let sites = Vec::from_iter(sites.map(|name| results[*name]));
    let exact = [0.0, 0.2, 0.2, 0.2, 0.2, 0.2, 0.0, 0.0];
    for (site, exact) in sites.iter().zip(exact) {
        close("share of the creepage", *site, exact, 1e-3);
    }
    close("creepage", sites.iter().sum(), results["creepage"], 1e-6);
    let mass = 7800.0 * std::f64::consts::PI * R * R * 1e-3;
    for name in ["nip_kg", "loose_nip_kg"] {
        close(name, results[name], 10.0 * mass, 1.5 * mass);
    }
}

#[test]
fn what_cannot_roll_on_the_grains_is_refused_by_its_key() {
    for (rolling, key) in [
        (
            json!({"force_n": 6.0, "spin_inertia_kg_m2": 1.0}),
            "wheel.rolling.force_n",
        ),
        (json!({"force_n": 1.0}), "wheel.rolling.spin_inertia_kg_m2"),
        (
            json!({"creepage": 0.1, "torque_nm": 1.0}),
            "wheel.rolling.torque_nm",
        ),
        (
            json!({"creepage": 0.1, "passes": 2.0}),
            "wheel.rolling.distance_m",
        ),
    ] {
        let message = refusal(&layer(0.0, 1.0, rolling));
        assert!(message.contains(key), "{message}");
    }
    let mut config = layer(0.0, 1.0, creepage(0.1));
    config["wheel"]["radius_m"] = json!(0.0);
    assert!(refusal(&config).contains("wheel.radius_m"));
}
