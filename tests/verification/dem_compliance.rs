//! Compliant contacts against the exact solution of implicit Euler, and against statics.
//!
//! Normal: two disks approach head on and meet a spring kn. In the step the gap g becomes g + h u', and the force is
//! -kn (g + h u') while the gap is negative, so with m_eff = m/2: u' = (u - h kn g / m_eff) / (1 + h^2 kn / m_eff).
//! Tangential: a disk on a floor under its weight starts sideways; the spring d and the slip velocity
//! u_t = v - w obey u_t' = (u_t - h kt d (3/m)) / (1 + h^2 kt 3/m), d' = d + h u_t'.
//! Slip: the spring is clipped at mu r_n / kt; a disk that starts without spin ends rolling at 2/3 of its speed, as any
//! sliding disk does (Coriolis 1835).
//! Statics: a column between floor and wheel shortens by (n + 1) F / kn.
//! Tolerances: rounding and the solver's true residual of 1e-12.

use serde_json::json;

use crate::dem_support::{THICKNESS, build, close, march, mass, scene};

const RADIUS: f64 = 1e-3;
const STIFFNESS: f64 = 1e9;
const STEP: f64 = 1e-6;

#[test]
fn two_disks_on_a_spring_follow_implicit_euler() {
    let law = json!({"kind": "signorini", "contact_stiffness_pa": STIFFNESS});
    let apart = 2.0 * RADIUS + 3.3e-6;
    let sample = json!({"kind": "disks", "disks": [
        {"x_m": 0.0, "y_m": 0.0, "radius_m": RADIUS, "vx_m_per_s": 0.7},
        {"x_m": apart, "y_m": 0.0, "radius_m": RADIUS, "vx_m_per_s": -0.3},
    ]});
    let mut dem = build(&scene(law, STEP, sample, json!({})));
    let (kn, m_eff) = (STIFFNESS * THICKNESS, 0.5 * mass(RADIUS));
    let (mut gap, mut u) = (3.3e-6, -1.0);
    let mut touched = false;
    for step in 0..400 {
        let report = march(&mut dem, step, 1);
        if gap + STEP * u < 0.0 {
            u = (u - STEP * kn * gap / m_eff) / (1.0 + STEP * STEP * kn / m_eff);
            touched = true;
        }
        gap += STEP * u;
        let [a, b] = [dem.state().velocities[0][0], dem.state().velocities[1][0]];
        close("relative velocity", b - a, u, 1e-9);
        close(
            "momentum",
            report.signal("momentum_x_kg_m_per_s"),
            0.4 * mass(RADIUS),
            1e-16,
        );
        assert!(
            report.imbalance(0.5 * m_eff) < 1e-9,
            "energy at step {step}"
        );
    }
    assert!(
        touched && gap > 0.0 && u > 0.5,
        "they must have bounced: {gap} {u}"
    );
}

#[test]
fn the_tangential_spring_follows_implicit_euler() {
    let law = json!({
        "kind": "coulomb", "friction": 10.0,
        "contact_stiffness_pa": STIFFNESS, "tangential_stiffness_ratio": 0.5,
    });
    let (m, kn) = (mass(RADIUS), STIFFNESS * THICKNESS);
    let g = 1000.0;
    let sunk = m * g / kn;
    let sample = json!({
        "kind": "disks",
        "disks": [{"x_m": 0.0, "y_m": RADIUS - sunk, "radius_m": RADIUS, "vx_m_per_s": 1e-4}],
        "walls": [{"x_m": 0.0, "y_m": 0.0, "nx": 0.0, "ny": 1.0}],
    });
    let mut dem = build(&scene(
        law,
        STEP,
        sample,
        json!({"gravity_m_per_s2": [0.0, -g]}),
    ));
    let (kt, w_tt) = (0.5 * kn, 3.0 / m);
    // Slip velocity along +x and elongation of the spring along it.
    let (mut u, mut d) = (1e-4, 0.0);
    for step in 0..300 {
        march(&mut dem, step, 1);
        u = (u - STEP * kt * d * w_tt) / (1.0 + STEP * STEP * kt * w_tt);
        d += STEP * u;
        let [vx, vy, w] = dem.state().velocities[0];
        // A disk that rolls to the right turns clockwise: the floor sees vx + w.
        close("slip velocity", vx + w, u, 1e-12);
        close("height is kept", vy, 0.0, 1e-12);
        close(
            "spring",
            dem.state().list.slots[0].spring.abs(),
            d.abs(),
            1e-16,
        );
    }
    assert!(
        d.abs() < 1e-9 && u.abs() < 1e-4,
        "implicit Euler damps the oscillation"
    );
}

/// u_t' = u_t + h (3/m) f, f the spring's force within +-mu m g; along +x.
#[test]
fn a_spring_slips_at_its_threshold_and_sticks_again() {
    let law = json!({
        "kind": "coulomb", "friction": 0.3,
        "contact_stiffness_pa": STIFFNESS, "tangential_stiffness_ratio": 0.5,
    });
    let (m, kn, g) = (mass(RADIUS), STIFFNESS * THICKNESS, 1000.0);
    let (kt, limit) = (0.5 * kn, 0.3 * m * g);
    let sample = json!({
        "kind": "disks",
        "disks": [{"x_m": 0.0, "y_m": RADIUS - m * g / kn, "radius_m": RADIUS, "vx_m_per_s": 1.0}],
        "walls": [{"x_m": 0.0, "y_m": 0.0, "nx": 0.0, "ny": 1.0}],
    });
    let gravity = json!({"gravity_m_per_s2": [0.0, -g]});
    let mut dem = build(&scene(law, STEP, sample, gravity));
    let (mut u, mut d, mut slipped, mut lost) = (1.0, 0.0, 0, 0.0);
    for step in 0..1500 {
        let report = march(&mut dem, step, 1);
        let stick = -(u + d / STEP) / (3.0 / m + 1.0 / (kt * STEP * STEP)) / STEP;
        let force = stick.clamp(-limit, limit);
        u += STEP * 3.0 / m * force;
        slipped += usize::from(force != stick);
        lost -= force * (STEP * u - (-force / kt - d));
        d = -force / kt;
        let [vx, _, w] = dem.state().velocities[0];
        close("slip velocity", vx + w, u, 1e-9);
        close(
            "spring",
            dem.state().list.slots[0].spring.abs(),
            d.abs(),
            1e-15,
        );
        close("friction", report.energy("friction"), lost, 1e-9 * m);
    }
    // From 1 m/s to rest at 3 mu g = 900 m/s2.
    assert!((1100..1112).contains(&slipped), "{slipped} steps of slip");
    close("it rolls", dem.state().velocities[0][0], 2.0 / 3.0, 1e-6);
}

#[test]
fn a_compliant_column_shortens_by_force_over_stiffness() {
    let law = json!({"kind": "signorini", "contact_stiffness_pa": STIFFNESS});
    let disk =
        |i: usize| json!({"x_m": 0.0, "y_m": RADIUS * (2 * i + 1) as f64, "radius_m": RADIUS});
    let sample = json!({
        "kind": "disks",
        "disks": (0..5).map(disk).collect::<Vec<_>>(),
        "walls": [{"x_m": 0.0, "y_m": 0.0, "nx": 0.0, "ny": 1.0}],
    });
    let wheel = json!({"load_n": 4.0, "mass_kg": 0.01, "ramp_s": 1e-3, "hold_s": 1.0});
    let mut dem = build(&scene(law, 1e-4, sample, json!({"wheel": wheel})));
    let report = march(&mut dem, 0, 2000);
    close("force on the wheel", report.signal("wheel_fn_n"), 4.0, 1e-8);
    let approach = 10.0 * RADIUS - report.signal("wheel_y_m");
    close(
        "approach",
        approach,
        6.0 * 4.0 / (STIFFNESS * THICKNESS),
        1e-13,
    );
    assert!(
        report.imbalance(0.0) < 1e-8,
        "energy: {}",
        report.imbalance(0.0)
    );
}
