//! Energy and momentum balances of free motion with impacts, friction and spin.
//!
//! The ledger's terms add up to an identity of the scheme for every theta, so the tolerance is the rounding of the steps:
//! 400 with rigid contacts, up to 20 000 with compliant ones. The loss of springs while their contacts turn is of first order
//! in the step: over 1e-3 of the energy in steps of 2e-6 s; a fall on a layer at 10 m/s lost 4.4 %.
//! An isolated group keeps its momentum and the angular momentum of spin and orbit together, since both disks of a contact
//! turn about the same point: to rounding, 1e-12.

use protocol::Node;
use serde_json::{Value, json};

use crate::dem_support::{build, close, march, scene};

const R: f64 = 1e-3;

/// Five disks that collide off centre, one of them spinning.
fn group() -> Value {
    json!({"kind": "disks", "disks": [
        {"x_m": 0.0, "y_m": 0.0, "radius_m": R, "vx_m_per_s": 1.0, "spin_rad_per_s": 500.0},
        {"x_m": 3.0 * R, "y_m": 0.6 * R, "radius_m": 0.7 * R, "vx_m_per_s": -1.0},
        {"x_m": 2.9 * R, "y_m": -1.5 * R, "radius_m": 1.2 * R, "vx_m_per_s": -1.2, "vy_m_per_s": 0.1},
        {"x_m": -2.3 * R, "y_m": -0.3 * R, "radius_m": R, "vx_m_per_s": 2.0},
        {"x_m": 5.5 * R, "y_m": -0.7 * R, "radius_m": R, "vx_m_per_s": -2.0},
    ]})
}

fn compliant() -> Value {
    json!({
        "kind": "coulomb", "friction": 0.4,
        "contact_stiffness_pa": 1e10, "tangential_stiffness_ratio": 0.5,
    })
}

#[test]
fn the_ledger_of_rigid_impacts_closes_for_every_theta() {
    for theta in [0.5, 0.7, 1.0] {
        let law = json!({"kind": "coulomb", "friction": 0.4});
        let mut config = scene(law, 5e-6, group(), json!({}));
        config["time"]["theta"] = json!(theta);
        let mut dem = build(&config);
        let before = dem.state().kinetic(dem.bodies());
        let momentum = dem.state().momentum(dem.bodies());
        let report = march(&mut dem, 0, 400);
        assert!(
            report.energy("friction") > 0.01 * before,
            "there must be slip"
        );
        assert!(
            report.energy("impact") > 0.01 * before,
            "there must be impacts"
        );
        assert!(report.energy("friction") + report.energy("impact") < before);
        assert!(
            report.imbalance(before) < 1e-10,
            "theta {theta}: {:e}",
            report.imbalance(before)
        );
        let scale = momentum[0].hypot(momentum[1]);
        close(
            "momentum x",
            report.signal("momentum_x_kg_m_per_s"),
            momentum[0],
            1e-11 * scale,
        );
        close(
            "momentum y",
            report.signal("momentum_y_kg_m_per_s"),
            momentum[1],
            1e-11 * scale,
        );
    }
}

/// Angular momentum about the origin, and the sum of the sizes of its parts (kg m2/s).
fn angular_momentum(dem: &dem_node::Dem) -> [f64; 2] {
    let (state, bodies) = (dem.state(), dem.bodies());
    let mut sums = [0.0; 2];
    for (i, ([x, y], [vx, vy, w])) in state.centres.iter().zip(&state.velocities).enumerate() {
        for part in [x * vy, -y * vx, 0.5 * bodies.radii[i] * w] {
            sums[0] += bodies.masses[i] * part;
            sums[1] += (bodies.masses[i] * part).abs();
        }
    }
    sums
}

#[test]
fn a_free_group_keeps_momentum_and_angular_momentum() {
    let bonded = json!({
        "kind": "cohesion", "friction": 0.4, "cn_pa_per_m": 1e13, "ct_pa_per_m": 1e13, "w_j_per_m2": 1.0,
        "b_pa_m_s": 0.0, "p": 1.0, "h_prime": "one", "alert_m": 4e-4,
    });
    let rebound = json!({"kind": "coulomb", "friction": 0.4, "restitution": 0.5});
    for (law, h, kind) in [
        (json!({"kind": "coulomb", "friction": 0.4}), 5e-6, "nsgs"),
        (json!({"kind": "coulomb", "friction": 0.4}), 5e-6, "pcg"),
        (compliant(), 5e-7, "nsgs"),
        (compliant(), 5e-7, "pcg"),
        (rebound, 5e-6, "nsgs"),
        (bonded, 5e-7, "nsgs"),
    ] {
        let mut config = scene(law.clone(), h, group(), json!({}));
        config["solver"]["kind"] = json!(kind);
        let mut dem = build(&config);
        let momentum = dem.state().momentum(dem.bodies());
        let [before, scale] = angular_momentum(&dem);
        let report = march(&mut dem, 0, (2e-3 / h) as u32);
        assert!(
            report.energy("friction") + report.energy("cohesion") > 0.0,
            "{law}"
        );
        let [after, _] = angular_momentum(&dem);
        close("angular momentum", after, before, 1e-12 * scale);
        let size: f64 = dem.bodies().masses.iter().sum::<f64>() * 2.0;
        for (now, then) in dem.state().momentum(dem.bodies()).iter().zip(momentum) {
            close("momentum", *now, then, 1e-12 * size);
        }
    }
}

#[test]
fn the_ledger_of_compliant_impacts_closes() {
    for (theta, h) in [(0.5, 1e-7), (1.0, 1e-7), (0.5, 2e-6), (1.0, 2e-6)] {
        let mut config = scene(compliant(), h, group(), json!({}));
        config["time"]["theta"] = json!(theta);
        let mut dem = build(&config);
        let before = dem.state().kinetic(dem.bodies());
        let report = march(&mut dem, 0, (2e-3 / h) as u32);
        assert!(
            report.energy("friction") > 0.01 * before,
            "there must be slip"
        );
        let imbalance = report.imbalance(before);
        assert!(imbalance < 1e-9, "theta {theta}, h {h}: {imbalance:e}");
    }
}

#[test]
fn falling_disks_close_the_ledger_with_the_work_of_their_weight() {
    let mut sample = group();
    sample["walls"] = json!([{"x_m": 0.0, "y_m": -4.0 * R, "nx": 0.1, "ny": 1.0}]);
    let law = json!({"kind": "coulomb", "friction": 0.4});
    let overrides = json!({"gravity_m_per_s2": [3.0, -40_000.0], "mass_scale": 50.0});
    let mut dem = build(&scene(law, 5e-6, sample, overrides));
    let before = dem.state().kinetic(dem.bodies());
    let mut worst = 0.0f64;
    let mut report = march(&mut dem, 0, 1);
    for step in 1..600 {
        report = march(&mut dem, step, 1);
        worst = worst.max(report.signal("momentum_defect_n"));
    }
    assert!(report.energy("weight") > 0.0);
    assert!(
        report.imbalance(before) < 1e-10,
        "{:e}",
        report.imbalance(before)
    );
    let weight: f64 = dem.bodies().masses.iter().sum::<f64>() / 50.0 * 40_000.0;
    assert!(
        worst < 1e-9 * weight,
        "momentum defect {worst:e} N at a weight of {weight:e} N"
    );
}

#[test]
fn weight_comes_from_the_real_mass_at_any_mass_scale() {
    let sample = json!({"kind": "disks", "disks": [{"x_m": 0.0, "y_m": 0.0, "radius_m": R}]});
    let overrides = json!({"gravity_m_per_s2": [0.0, -9.81], "mass_scale": 50.0});
    let mut dem = build(&scene(
        json!({"kind": "signorini"}),
        1e-4,
        sample,
        overrides,
    ));
    march(&mut dem, 0, 100);
    close(
        "speed after 10 ms",
        dem.state().velocities[0][1],
        -9.81e-2 / 50.0,
        1e-15,
    );
}

/// Rest and a constant motion change no energies, except by the tolerance of the solver: 1e-19 J of 1e-7 J here, for which balances and
/// shares are meaningless.
#[test]
fn disks_that_only_carry_their_weight_have_no_energies() {
    let slope = json!([{"x_m": 0.6 * R, "y_m": -0.8 * R, "nx": -0.6, "ny": 0.8}]);
    let rolls = json!([{"x_m": 0.0, "y_m": 0.0, "radius_m": R, "vx_m_per_s": 0.08, "vy_m_per_s": 0.06, "spin_rad_per_s": -100.0}]);
    let floor = json!([{"x_m": 0.0, "y_m": 0.0, "nx": 0.0, "ny": 1.0}]);
    let sunk = R - crate::dem_support::mass(R) * 9.81 / 1e3;
    let rests = json!([{"x_m": 0.0, "y_m": sunk, "radius_m": R}]);
    let springs = json!({"kind": "coulomb", "friction": 0.3, "contact_stiffness_pa": 1e6, "tangential_stiffness_ratio": 0.5});
    let rigid = json!({"kind": "coulomb", "friction": 0.3});
    let scenes = [
        (rigid.clone(), rolls, slope, [0.6 * 9.81, -0.8 * 9.81]),
        (springs, rests, floor.clone(), [0.0, -9.81]),
        (
            rigid,
            json!([{"x_m": 0.0, "y_m": R, "radius_m": R}]),
            floor,
            [0.0, -9.81],
        ),
    ];
    for (law, disks, walls, gravity) in scenes {
        let sample = json!({"kind": "disks", "disks": disks, "walls": walls});
        let mut config = scene(law, 1e-4, sample, json!({"gravity_m_per_s2": gravity}));
        config["solver"]["tolerance"] = json!(1e-10);
        let mut dem = build(&config);
        let report = march(&mut dem, 0, 2000);
        for term in [
            "weight",
            "kinetic",
            "impact",
            "friction",
            "detection",
            "springs_normal",
        ] {
            close(term, report.energy(term), 0.0, report.energy("rounding"));
        }
        assert_eq!(dem.finish().expect("it ends").findings, []);
    }
    // Falls have energies, also one by a hundred-millionth of the radius, whose balance is not judged.
    for (fall, accuracy) in [(1e-3, 1e-9), (1e-8, 1e-6)] {
        let disks = json!([{"x_m": 0.0, "y_m": (1.0 + fall) * R, "radius_m": R}]);
        let sample = json!({"kind": "disks", "disks": disks, "walls": [{"x_m": 0.0, "y_m": 0.0, "nx": 0.0, "ny": 1.0}]});
        let law = json!({"kind": "signorini"});
        let mut dem = build(&scene(
            law,
            1e-5,
            sample,
            json!({"gravity_m_per_s2": [0.0, -9.81]}),
        ));
        let report = march(&mut dem, 0, 2000);
        let work = crate::dem_support::mass(R) * 9.81 * fall * R;
        for term in ["weight", "impact"] {
            close(term, report.energy(term), work, accuracy * work);
        }
        assert_eq!(work < report.energy("rounding"), fall < 1e-6);
    }
}

/// Touching disks at rest, and a pressed row that repeats and moves as a whole or in a wave: the energies of rounding, and
/// the first drift of theta = 1/2, are no loss.
#[test]
fn springs_at_rest_or_under_pressure_raise_no_alarm() {
    let touching: Vec<Value> = (0..5)
        .map(|i| json!({"x_m": 3e-4 * f64::from(i), "y_m": 1.5e-4, "radius_m": 1.5e-4}))
        .collect();
    let floor = json!([{"x_m": 0.0, "y_m": 0.0, "nx": 0.0, "ny": 1.0}]);
    let at_rest = json!({"kind": "disks", "disks": touching, "walls": floor});
    let row = |speed: fn(f64) -> f64| {
        let disk = |i: u32| {
            let velocity = speed(std::f64::consts::TAU * f64::from(i) / 8.0);
            json!({"x_m": 0.999e-3 * (f64::from(i) - 3.5), "y_m": 0.0, "radius_m": 0.5e-3, "vx_m_per_s": velocity})
        };
        let disks: Vec<Value> = (0..8).map(disk).collect();
        json!({"kind": "disks", "disks": disks, "periodic_x_m": [-3.996e-3, 3.996e-3]})
    };
    let cases = [
        ("at rest", at_rest, 1.0, 1e-7),
        ("in a wave", row(|phase| 1e-3 * phase.cos()), 0.5, 2e-9),
        ("moving", row(|_| 1e-3), 0.5, 2.5e-8),
        ("moving", row(|_| 1e-3), 1.0, 2.5e-8),
    ];
    for (what, sample, theta, h) in cases {
        let law = json!({"kind": "signorini", "contact_stiffness_pa": 1e10});
        let mut config = scene(law, h, sample, json!({}));
        config["time"]["theta"] = json!(theta);
        let mut dem = build(&config);
        march(&mut dem, 0, 4000);
        let findings = dem.finish().expect("it ends").findings;
        assert!(findings.is_empty(), "{what}, theta {theta}: {findings:?}");
    }
}
