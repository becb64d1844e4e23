//! Newton's restitution, LMGC90's RST.
//!
//! ```text
//!   O  falls from H, rebounds to e^2 H, e^4 H, ...         O ->  O O O O
//!  ===
//! ```
//!
//! Exact: a rebound has e times the speed of the impact, so heights shrink by e^2 (Newton). In a chain of equal disks that do not
//! touch, the n-th gets ((1 + e)/2)^(n-1) of the first one's speed (Huygens 1703 for e = 1: the cradle). A touching chain
//! is hit in all contacts at once: v = P + e (P - v_0), P = V/n the inelastic answer (Moreau 1988), (1 + e)/n - e for the
//! first and (1 + e)/n for the others. Energy: without friction v is a contraction of v_0 for 0 <= e <= 1, for any contacts.
//! Tolerances: speeds, the solver's true residual of 1e-12; heights, one step of gravity in the impact speed, 2e-4.

use dem_kernel::random::RandomNumbers;
use protocol::Node;
use serde_json::{Value, json};

use crate::dem_support::{build, close, march, refusal, scene};

const R: f64 = 1e-3;

fn law(restitution: f64) -> Value {
    json!({"kind": "signorini", "restitution": restitution})
}

#[test]
fn a_disk_rebounds_to_e_squared_of_its_height() {
    for restitution in [0.0, 0.5, 0.8, 1.0] {
        let sample = json!({
            "kind": "disks",
            "disks": [{"x_m": 0.0, "y_m": R + 0.01, "radius_m": R}],
            "walls": [{"x_m": 0.0, "y_m": 0.0, "nx": 0.0, "ny": 1.0}],
        });
        let overrides = json!({
            "gravity_m_per_s2": [0.0, -9.81],
            "time": {"step_s": 1e-5, "theta": 0.5, "pressure_pa": 1.0},
        });
        let mut dem = build(&scene(law(restitution), 1e-5, sample, overrides));
        let (mut before, mut peak, mut expected, mut bounces) = (0.0, 0.0f64, 0.01, 0);
        for step in 0..25_000 {
            march(&mut dem, step, 1);
            let after = dem.state().velocities[0][1];
            if after >= 0.0 && before < -0.02 {
                let speed = restitution * -before;
                close("speed of the rebound", after, speed, 1e-10);
                if bounces > 0 {
                    let name = format!("height {bounces} at e = {restitution}");
                    close(&name, peak, expected, 1e-3 * f64::from(bounces) * 0.01);
                }
                (peak, bounces) = (0.0, bounces + 1);
                expected *= restitution * restitution;
            }
            peak = peak.max(dem.state().centres[0][1] - R);
            before = after;
        }
        assert!(
            bounces >= if restitution == 0.0 { 1 } else { 2 },
            "{bounces}"
        );
        if restitution == 0.0 {
            close("it rests", dem.state().velocities[0][1], 0.0, 1e-12);
        }
    }
}

/// A row of disks: the first one moves from 0.1 R away, the others are `apart` from each other.
fn row(n: usize, apart: f64) -> Value {
    let disk = |i: usize| {
        let away = if i == 0 { 0.1 * R } else { 0.0 };
        let speed = if i == 0 { 1.0 } else { 0.0 };
        let x = (2.0 * R + apart) * i as f64 - away;
        json!({"x_m": x, "y_m": 0.0, "radius_m": R, "vx_m_per_s": speed})
    };
    json!({"kind": "disks", "disks": (0..n).map(disk).collect::<Vec<_>>()})
}

#[test]
fn a_row_of_separate_disks_passes_the_blow_on() {
    for restitution in [1.0, 0.8, 0.3] {
        let n = 5;
        let mut dem = build(&scene(law(restitution), 1e-6, row(n, 0.1 * R), json!({})));
        let mut step = 0;
        while dem.state().velocities[n - 1][0] == 0.0 && step < 10_000 {
            march(&mut dem, step, 1);
            step += 1;
        }
        let expected = (0.5 * (1.0 + restitution)).powi(n as i32 - 1);
        close("last", dem.state().velocities[n - 1][0], expected, 1e-10);
        if restitution == 1.0 {
            for velocity in &dem.state().velocities[..n - 1] {
                close("the others", velocity[0], 0.0, 1e-10);
            }
        }
    }
}

#[test]
fn a_row_that_touches_is_hit_in_all_contacts_at_once() {
    for (n, restitution) in [(3, 1.0), (5, 1.0), (5, 0.6), (4, 0.0)] {
        let mut dem = build(&scene(law(restitution), 1e-6, row(n, -1e-8 * R), json!({})));
        let mut step = 0;
        while dem.state().velocities[n - 1][0] == 0.0 && step < 1_000 {
            march(&mut dem, step, 1);
            step += 1;
        }
        let others = (1.0 + restitution) / n as f64;
        for (i, velocity) in dem.state().velocities.iter().enumerate() {
            let expected = if i == 0 { others - restitution } else { others };
            close(&format!("disk {i} of {n}"), velocity[0], expected, 1e-9);
        }
    }
}

/// Disks of random sizes and velocities between four walls.
fn gas(seed: u64) -> Value {
    let mut dice = RandomNumbers::new(seed);
    let disks: Vec<Value> = (0..36)
        .map(|i| {
            let mut place = |cell: usize| R * (2.0 * cell as f64 + 1.0 + dice.between(-0.1, 0.1));
            let (x, y) = (place(i % 6), place(i / 6));
            let mut speed = || dice.between(-1.0, 1.0);
            let (vx, vy) = (speed(), speed());
            json!({
                "x_m": x, "y_m": y, "radius_m": R * dice.between(0.3, 0.88),
                "vx_m_per_s": vx, "vy_m_per_s": vy, "spin_rad_per_s": dice.between(-500.0, 500.0),
            })
        })
        .collect();
    let wall = |x: f64, y: f64, nx: f64, ny: f64| json!({"x_m": x, "y_m": y, "nx": nx, "ny": ny});
    json!({"kind": "disks", "disks": disks, "walls": [
        wall(0.0, 0.0, 1.0, 0.0), wall(0.0, 0.0, 0.0, 1.0),
        wall(12.0 * R, 0.0, -1.0, 0.0), wall(0.0, 12.0 * R, 0.0, -1.0),
    ]})
}

#[test]
fn restitution_never_adds_energy() {
    let mut rebounds = 0;
    for seed in 0..4 {
        for restitution in [0.0, 0.4, 0.9, 1.0] {
            for friction in [0.0, 0.3] {
                let law =
                    json!({"kind": "RST_CLB", "friction": friction, "restitution": restitution});
                let mut config = scene(law, 5e-6, gas(seed), json!({}));
                config["solver"]["tolerance"] = json!(1e-10);
                let mut dem = build(&config);
                let before = dem.state().kinetic(dem.bodies());
                let mut kinetic = before;
                for step in 0..400 {
                    let report = march(&mut dem, step, 1);
                    let now = dem.state().kinetic(dem.bodies());
                    assert!(
                        now <= kinetic * (1.0 + 1e-12),
                        "seed {seed}, e {restitution}, friction {friction}, step {step}: {kinetic:e} to {now:e}"
                    );
                    rebounds += u64::from(report.signal("contacts") > 0.0);
                    kinetic = now;
                    assert!(report.imbalance(before) < 1e-10);
                }
                if restitution == 1.0 && friction == 0.0 {
                    close("elastic", kinetic, before, 1e-9 * before);
                }
            }
        }
    }
    assert!(rebounds > 1000, "{rebounds} steps with contacts");
}

#[test]
fn names_of_lmgc90_stand_for_a_kind_and_an_option() {
    let sample = || row(2, 0.0);
    let run = |law: Value| {
        let mut dem = build(&scene(law, 1e-5, sample(), json!({})));
        march(&mut dem, 0, 30);
        dem.state().hash()
    };
    let coulomb = |more: Value| {
        let mut law = json!({"kind": "coulomb", "friction": 0.3});
        for (key, value) in more.as_object().into_iter().flatten() {
            law[key] = value.clone();
        }
        law
    };
    assert_eq!(
        run(json!({"kind": "IQS_CLB", "friction": 0.3})),
        run(coulomb(json!({"penetration": "iqs"})))
    );
    assert_eq!(
        run(json!({"kind": "RST_CLB", "friction": 0.3, "restitution": 0.5})),
        run(coulomb(json!({"restitution": 0.5})))
    );
    assert_ne!(
        run(json!({"kind": "IQS_CLB", "friction": 0.3})),
        run(coulomb(json!({"restitution": 0.5})))
    );
    let bonds = |kind: &str, more: Value| {
        let mut law = json!({
            "kind": kind, "friction": 0.3, "cn_pa_per_m": 1e12, "ct_pa_per_m": 1e12, "w_j_per_m2": 1.0,
            "b_pa_m_s": 0.0, "p": 1.0, "h_prime": "one", "alert_m": 1e-6,
        });
        for (key, value) in more.as_object().into_iter().flatten() {
            law[key] = value.clone();
        }
        law
    };
    assert_eq!(
        run(bonds("IQS_MAC_CZM", json!({}))),
        run(bonds("cohesion", json!({"penetration": "iqs"})))
    );
    for (law, words) in [
        (
            json!({"kind": "RST_CLB", "friction": 0.3}),
            ["law.restitution", "RST_CLB"],
        ),
        (
            json!({"kind": "IQS_CLB", "friction": 0.3, "restitution": 0.5}),
            ["law.restitution", "IQS_CLB"],
        ),
        (
            json!({"kind": "IQS_CLB", "friction": 0.3, "penetration": "gap"}),
            ["law.penetration", "IQS_CLB"],
        ),
        (
            bonds("IQS_MAC_CZM", json!({"penetration": "gap"})),
            ["law.penetration", "IQS_MAC_CZM"],
        ),
        (
            bonds("cohesion", json!({"penetration": "split"})),
            ["law.penetration", "bonds"],
        ),
        (
            coulomb(json!({"restitution": 0.5, "penetration": "gap"})),
            ["law.penetration", "rebound"],
        ),
        (
            coulomb(json!({"restitution": 1.5})),
            ["law.restitution", "at least 0 and at most 1"],
        ),
        (
            json!({"kind": "signorini", "restitution": 0.5, "contact_stiffness_pa": 1e9}),
            ["law.restitution", "elastic"],
        ),
        (
            json!({"kind": "signorini", "penetration": "iqs", "contact_stiffness_pa": 1e9}),
            ["law.penetration", "elastic"],
        ),
        (
            json!({"kind": "IQS", "friction": 0.3}),
            ["law.kind", "IQS_CLB"],
        ),
    ] {
        let message = refusal(&scene(law, 1e-5, sample(), json!({})));
        assert!(words.iter().all(|word| message.contains(word)), "{message}");
    }
}

/// Two disks that meet at an angle, and a disk that hits a slope, keep their energy but for rounding. Rounding over rounding is no balance, and
/// 1e-16 J that friction seems to make is no finding.
#[test]
fn a_rebound_that_keeps_its_energy_has_no_balance_of_rounding() {
    let disk = |x: f64, y: f64, v: [f64; 2]| json!({"x_m": x, "y_m": y, "radius_m": R, "vx_m_per_s": v[0], "vy_m_per_s": v[1]});
    let slope = json!([{"x_m": 0.0, "y_m": 0.0, "nx": 0.37, "ny": 1.0}]);
    let pair = json!([
        disk(-2.3 * R, 0.7 * R, [1.0, 0.0]),
        disk(0.0, 0.0, [0.0; 2])
    ]);
    let dropped = json!([disk(0.0, 2.0 * R, [0.7, -1.0])]);
    for (disks, walls) in [(pair, json!([])), (dropped, slope)] {
        let sample = json!({"kind": "disks", "disks": disks, "walls": walls});
        let law = json!({"kind": "signorini", "restitution": 1.0});
        let mut dem = build(&scene(law, 1e-6, sample, json!({})));
        let report = march(&mut dem, 0, 5000);
        for term in ["kinetic", "impact", "weight"] {
            close(term, report.energy(term), 0.0, report.energy("rounding"));
        }
        let findings = dem.finish().expect("it ends").findings;
        assert!(findings.is_empty(), "{:?}", findings[0]);
    }
}
