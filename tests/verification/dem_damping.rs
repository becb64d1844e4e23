//! Springs that rebound: with a damper of their own, and by the time step alone.
//!
//! ```text
//!   V ->  (O)(O)  <- V       two disks meet and part
//! ```
//!
//! Exact: a damper for the restitution e leaves e V, the contact ending where its force vanishes (Schwager and Poschel 2007); the
//! implicit step alone leaves exp(-pi h omega / 2) V, omega = sqrt(2 kn/m). Tolerances: of first order in the step.

use protocol::Node;
use serde_json::{Value, json};

use crate::dem_support::{Report, THICKNESS, build, close, march, mass, refusal, scene};

const R: f64 = 1e-3;
const STIFFNESS_PA: f64 = 1e10;
const V: f64 = 0.5;

fn omega() -> f64 {
    (2.0 * STIFFNESS_PA * THICKNESS / mass(R)).sqrt()
}

/// Speed over the one before of two disks that have met, in steps of h omega, and the last report.
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
fn the_step_alone_leaves_what_the_results_say() {
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

/// Two disks whose bond is as stiff in tension as in compression. Exact, of an oscillator with the damping ratio z that begins with the
/// velocity 2 V: 2 V exp(-z w t) (cos w_d t - z w / w_d sin w_d t), w_d = w sqrt(1 - z^2); along the bond w^2 = 2 k/m, across it
/// w_t^2 = 6 k_t/m, as both disks turn, and z_t = z w_t / w. Of first order in the step, so extrapolated from two.
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
fn dampers_need_springs_and_a_restitution_that_they_can_give() {
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
