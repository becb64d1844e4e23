//! Springs that rebound: with a damper, and with the damping of the time step alone.
//!
//! ```text
//!   V ->  (O)(O)  <- V       two disks meet and part
//! ```
//!
//! Exact: with a damper for the restitution e the disks part with e V, where the contact ends when its force vanishes (Schwager and
//! Poschel 2007); with the implicit step alone they part with exp(-pi h omega / 2) V, omega = sqrt(2 kn/m). Tolerances: of first order
//! in the step.

use protocol::Node;
use serde_json::{Value, json};

use crate::dem_support::{Report, THICKNESS, build, close, march, mass, refusal, scene};

const R: f64 = 1e-3;
const STIFFNESS_PA: f64 = 1e10;
const V: f64 = 0.5;

fn omega() -> f64 {
    (2.0 * STIFFNESS_PA * THICKNESS / mass(R)).sqrt()
}

/// Speed of two disks after their contact over the speed before, in steps of h omega, the last report and the results.
fn meet(
    damping: Option<f64>,
    h_omega: f64,
    phase: f64,
) -> (f64, Report, std::collections::BTreeMap<String, f64>) {
    let mut law = json!({"kind": "signorini", "contact_stiffness_pa": STIFFNESS_PA});
    if let Some(restitution) = damping {
        law["damping"] = json!(restitution);
    }
    let step = h_omega / omega();
    let away = R + (2.0 + phase) * V * step;
    let disk =
        |side: f64| json!({"x_m": side * away, "y_m": 0.0, "radius_m": R, "vx_m_per_s": -side * V});
    let sample = json!({"kind": "disks", "disks": [disk(-1.0), disk(1.0)]});
    let mut dem = build(&scene(law, step, sample, json!({})));
    let report = march(&mut dem, 0, (8.0 / h_omega) as u32 + 20);
    let results = dem.finish().expect("it ends").results;
    (dem.state().velocities[1][0] / V, report, results)
}

#[test]
fn a_damper_leaves_its_restitution_of_the_speed() {
    for e in [0.14, 0.3, 0.6, 0.9] {
        let [coarse, fine] = [2e-3, 1e-3].map(|h| meet(Some(e), h, 0.0).0);
        close(&format!("{e}"), 2.0 * fine - coarse, e, 1e-3);
        assert!((fine - e).abs() < 6e-3, "{e}: {fine}");
        let (speed, report, _) = meet(Some(e), 1e-3, 0.5);
        let before = mass(R) * V * V;
        let lost = report.energy("damping") + report.energy("numerical");
        close("lost", lost, before * (1.0 - speed * speed), 1e-9 * before);
        close("impact", report.energy("impact"), 0.0, 0.0);
        let numerical = report.energy("numerical") / before;
        assert!((0.0..6e-3).contains(&numerical), "{e}: {numerical}");
    }
}

#[test]
fn without_a_damper_the_rebound_is_near_the_reported_restitution() {
    for h_omega in [0.03, 0.1, 0.3, 1.0] {
        let speeds = (0..8).map(|k| meet(None, h_omega, f64::from(k) / 8.0));
        for (speed, report, results) in speeds {
            let least = results["spring_restitution"];
            assert!(
                speed > least - 0.02 && speed < least + 0.2,
                "{h_omega}: {speed} {least}"
            );
            close("share", results["numerical_share"], 1.0, 1e-12);
            assert!(report.imbalance(mass(R) * V * V) < 1e-12);
        }
    }
    let (speed, ..) = meet(None, 0.03, 0.3);
    close(
        "small steps",
        speed,
        (-std::f64::consts::FRAC_PI_2 * 0.03).exp(),
        2e-3,
    );
}

/// Two disks whose bond is as stiff in tension as in compression. Exact, for an oscillator with the damping ratio z that starts with the
/// velocity 2 V: 2 V exp(-z w t) (cos w_d t - z w / w_d sin w_d t), w_d = w sqrt(1 - z^2); along the bond w^2 = 2 k/m, across it
/// w_t^2 = 6 k_t/m, since both disks turn, and z_t = z w_t / w. Of first order in the step, so extrapolated from two steps.
#[test]
fn a_damped_bond_rings_as_an_oscillator() {
    let (zeta, radius_m) = (0.3, R);
    let k = STIFFNESS_PA * THICKNESS;
    let per_area = k / (0.5 * R * THICKNESS);
    let ring = |across: bool, h_omega: f64, spans: u32| {
        let law = json!({
            "kind": "cohesion", "friction": 0.0, "contact_stiffness_pa": STIFFNESS_PA, "tangential_stiffness_ratio": 1.0,
            "cn_pa_per_m": per_area, "ct_pa_per_m": 0.25 * per_area, "w_j_per_m2": 1e9, "b_pa_m_s": 0.0, "p": 1.0, "h_prime": "one",
            "alert_m": 0.1 * R, "bond_damping_ratio": zeta,
        });
        let speed = 1e-4 * V;
        let disk = |side: f64| {
            let (along, over) = if across {
                ("vy_m_per_s", "vx_m_per_s")
            } else {
                ("vx_m_per_s", "vy_m_per_s")
            };
            json!({"x_m": side * R, "y_m": 0.0, "radius_m": radius_m, along: side * speed, over: 0.0})
        };
        let sample = json!({"kind": "disks", "disks": [disk(-1.0), disk(1.0)]});
        let mut dem = build(&scene(law, h_omega / omega(), sample, json!({})));
        let report = march(&mut dem, 0, (f64::from(spans) / h_omega) as u32);
        let before = mass(R) * speed * speed;
        assert!(
            report.imbalance(before) < 1e-9,
            "{}",
            report.imbalance(before)
        );
        let [a, b] = [dem.state().velocities[0], dem.state().velocities[1]];
        let apart = if across {
            b[1] - a[1] - b[2] - a[2]
        } else {
            b[0] - a[0]
        };
        (
            apart.abs() / (2.0 * speed),
            report.energy("damping") / before,
        )
    };
    for spans in [1, 2, 4] {
        for (across, stiffer) in [(false, 1.0), (true, 0.75)] {
            let [(coarse, _), (fine, lost)] = [4e-4, 2e-4].map(|h| ring(across, h, spans));
            let (w, z) = (f64::sqrt(stiffer), zeta * f64::sqrt(stiffer));
            let (t, wd) = (f64::from(spans), w * (1.0 - z * z).sqrt());
            let exact = (-z * w * t).exp() * ((wd * t).cos() - z * w / wd * (wd * t).sin());
            let at = format!("{spans} {across}");
            close(&at, 2.0 * fine - coarse, exact.abs(), 1e-5);
            assert!(lost > 0.1, "{at}: {lost}");
        }
    }
}

#[test]
fn dampers_need_springs_and_a_possible_restitution() {
    let with = |law: Value| {
        let sample = json!({"kind": "disks", "disks": [{"x_m": 0.0, "y_m": 0.0, "radius_m": R}]});
        refusal(&scene(law, 1e-6, sample, json!({})))
    };
    let rigid = with(json!({"kind": "signorini", "damping": 0.5}));
    assert!(
        rigid.contains("law.damping") && rigid.contains("law.restitution"),
        "{rigid}"
    );
    let low = with(json!({"kind": "signorini", "contact_stiffness_pa": 1e10, "damping": 0.1}));
    assert!(low.contains("law.damping") && low.contains("0.14"), "{low}");
    let loose = with(json!({"kind": "signorini", "bond_damping_ratio": 0.1}));
    assert!(
        loose.contains("law.bond_damping_ratio") && loose.contains("belongs to bonds"),
        "{loose}"
    );
}

/// Codes and values of the findings at the end.
fn found(dem: &mut dem_node::Dem) -> Vec<(String, f64)> {
    let findings = dem.finish().expect("it ends").findings.into_iter();
    findings.map(|found| (found.code, found.value)).collect()
}

/// The loss of the scheme is compared with the energy of the flight, not with the rest after the rebound: h omega = 0.002 loses 0.6 % of
/// it. The disk is thrown, dropped and back at its height, or moves with a common speed.
#[test]
fn a_rebound_that_keeps_its_energy_reports_no_loss_of_the_scheme() {
    let omega = (STIFFNESS_PA * THICKNESS / mass(R)).sqrt();
    let drop = 1e-4;
    let gravity = V * V / (2.0 * drop);
    let disk = |x: f64, y: f64, vx: f64, vy: f64| json!({"x_m": x, "y_m": y, "radius_m": R, "vx_m_per_s": vx, "vy_m_per_s": vy});
    let floor = json!([{"x_m": 0.0, "y_m": 0.0, "nx": 0.0, "ny": 1.0}]);
    let touch = std::f64::consts::PI / omega;
    let scenes = [
        (
            json!([disk(0.0, R, 0.0, -V)]),
            floor.clone(),
            0.0,
            1.5 * touch,
        ),
        (
            json!([disk(0.0, R + drop, 0.0, 0.0)]),
            floor,
            gravity,
            4.0 * drop / V + touch,
        ),
        (
            json!([
                disk(0.0, 0.0, 20.0 + V, 0.0),
                disk(2.0 * R, 0.0, 20.0 - V, 0.0)
            ]),
            json!([]),
            0.0,
            1.5 * touch,
        ),
    ];
    for (disks, walls, gravity, time) in scenes {
        for (h_omega, expected) in [(2e-3, false), (0.2, true)] {
            let step = h_omega / omega;
            let sample = json!({"kind": "disks", "disks": disks, "walls": walls});
            let law = json!({"kind": "signorini", "contact_stiffness_pa": STIFFNESS_PA});
            let over = json!({"gravity_m_per_s2": [0.0, -gravity]});
            let mut dem = build(&scene(law, step, sample, over));
            march(&mut dem, 0, (time / step) as u32);
            let numerical = found(&mut dem).into_iter().find(|f| f.0 == "numerical");
            assert_eq!(
                numerical.is_some(),
                expected,
                "{disks} {h_omega}: {numerical:?}"
            );
            if let Some((_, value)) = numerical {
                // 1 - exp(-pi h omega), of two disks with omega sqrt(2).
                assert!((0.3..0.7).contains(&value), "{value}");
            }
        }
    }
}

/// A cluster of these disks falls on the floor: normal speed of its lowest disk after the hit over the speed before, and the findings.
fn landed(damping: f64, disks: &[[f64; 2]]) -> (f64, Vec<(String, f64)>) {
    let step = 2e-3 / omega();
    let members: Vec<Value> = disks
        .iter()
        .map(|[x, y]| json!({"x_m": x * R, "y_m": (y + 1.0) * R, "radius_m": R, "cluster": "body"}))
        .collect();
    let sample = json!({"kind": "disks", "disks": members, "clusters": [{"name": "body", "vy_m_per_s": -V}],
        "walls": [{"x_m": 0.0, "y_m": 0.0, "nx": 0.0, "ny": 1.0}]});
    let law =
        json!({"kind": "signorini", "contact_stiffness_pa": STIFFNESS_PA, "damping": damping});
    let mut dem = build(&scene(law, step, sample, json!({})));
    march(&mut dem, 0, 12_000);
    let [_, speed, _] = dem.state().velocity_of(dem.bodies(), 0);
    (speed / V, found(&mut dem))
}

/// 1/m = 1/M + a^2/I: for any lever and any disk that is hit.
#[test]
fn a_cluster_hit_off_its_centre_rebounds_with_the_restitution_of_its_damper() {
    for e in [0.2, 0.3, 0.6, 0.9] {
        for bar in [
            vec![[0.0, 0.0], [2.0, 2.0]],
            vec![[0.0, 0.0], [0.5, 1.9], [3.0, 2.0]],
            vec![[0.0, 0.0], [0.0, 2.0]],
        ] {
            let (speed, findings) = landed(e, &bar);
            close(&format!("{e}"), speed, e, 0.01);
            assert_eq!(findings, [], "{e} {bar:?}");
        }
    }
}

/// n dampers for m_i beside n springs: zeta' = zeta sum sqrt(m_i) / sqrt(n M). The warning gives the actual restitution and the cure.
#[test]
fn a_landing_on_several_dampers_raises_a_warning_with_the_actual_restitution() {
    let row = |n: u32| (0..n).map(|k| [2.0 * f64::from(k), 0.0]);
    let block: Vec<[f64; 2]> = row(4).chain(row(4).map(|[x, _]| [x, 2.0])).collect();
    for e in [0.2, 0.3, 0.6] {
        let (speed, findings) = landed(e, &block);
        let [(code, value)] = &findings[..] else {
            panic!("{e}: {findings:?}");
        };
        assert_eq!(code, "shared_damping");
        close("difference", *value, e - speed, 0.01);
        assert!(*value > 0.05, "{value}");
    }
    // The dampers of a flat bar are nearly right: 1/m = (1 + 8/9)/M, and 2 m = 1.06 M.
    let (speed, findings) = landed(0.3, &[[0.0, 0.0], [4.0, 0.0]]);
    close("bar", speed, 0.3, 0.02);
    assert_eq!(findings, []);
}
