//! Newton's restitution with friction can add energy if a body turns as it is hit (Kane and Levinson 1985), and a finding reports it.
//!
//! ```text
//!        (O) c     the lower disk of a dumbbell meets a floor at p; l leads from the centre of mass c to p
//!       /
//!    (O)
//!   ==p====
//! ```
//!
//! Exact: an impulse P at p changes its velocity by P/M + (l x P)/I (-l_y, l_x). With e = 1 and sticking friction this change is
//! (-v_x, -2 v_y), and the work of P is P.(v + v')/2 = P_x v_x/2 (Kelvin; Routh 1905), which is positive for some v. Tolerance: the
//! contact solver's residual of 1e-12.

use protocol::{Finding, Node};
use serde_json::{Value, json};

use crate::dem_support::{Report, build, close, march, mass, scene};

const R: f64 = 1e-3;
const MASS: f64 = 2e-5;
const INERTIA: f64 = 2e-11;
/// From the centre of mass to the contact point (m).
const LEVER: [f64; 2] = [-1.2e-3, -3e-3];

/// The dumbbell after its impact at this velocity (m/s), and the findings.
fn hit(law: Value, step: f64, velocity: [f64; 2]) -> (Report, Vec<Finding>) {
    let centre = [0.0, 1e-5 - LEVER[1]];
    let disk = |side: f64| {
        let [x, y] = [side * LEVER[0], side * (LEVER[1] + R)];
        json!({"x_m": centre[0] + x, "y_m": centre[1] + y, "radius_m": R, "cluster": "rod"})
    };
    let rod = json!({
        "name": "rod", "mass_kg": MASS, "inertia_kg_m2": INERTIA,
        "vx_m_per_s": velocity[0], "vy_m_per_s": velocity[1],
    });
    let sample = json!({
        "kind": "disks", "disks": [disk(1.0), disk(-1.0)], "clusters": [rod],
        "walls": [{"x_m": 0.0, "y_m": 0.0, "nx": 0.0, "ny": 1.0}],
    });
    let time = json!({"step_s": step, "theta": 0.5, "pressure_pa": 1.0});
    let mut dem = build(&scene(law, step, sample, json!({"time": time})));
    let report = march(&mut dem, 0, (1e-4 / step).round() as u32);
    (report, dem.finish().expect("it ends").findings)
}

/// Impulse that sticks and rebounds with e.
fn impulse([x, y]: [f64; 2], e: f64) -> [f64; 2] {
    let [lx, ly] = LEVER;
    let (xx, yy) = (
        1.0 / MASS + ly * ly / INERTIA,
        1.0 / MASS + lx * lx / INERTIA,
    );
    let (xy, [dx, dy]) = (-lx * ly / INERTIA, [-x, -(1.0 + e) * y]);
    let determinant = xx * yy - xy * xy;
    [
        (yy * dx - xy * dy) / determinant,
        (xx * dy - xy * dx) / determinant,
    ]
}

fn found(findings: &[Finding]) -> Option<(f64, bool)> {
    let found = findings.iter().find(|f| f.code == "impact_energy");
    found.map(|f| (f.value, f.suspect))
}

fn law(e: f64, friction: f64) -> Value {
    json!({"kind": "coulomb", "friction": friction, "restitution": e})
}

/// Velocity at which the impulse of friction drives the rod.
const VELOCITY: [f64; 2] = [0.02, -0.3];

#[test]
fn a_rod_that_friction_drives_is_suspect() {
    let [x, _] = impulse(VELOCITY, 1.0);
    let made = 0.5 * x * VELOCITY[0];
    assert!(made > 0.0, "{made:e}");
    let (report, findings) = hit(law(1.0, 0.5), 1e-5, VELOCITY);
    close("friction", report.energy("friction"), -made, 1e-9 * made);
    close("kinetic", report.energy("kinetic"), made, 1e-9 * made);
    // It is half of the stored plus the lost energy.
    let (value, suspect) = found(&findings).expect("it is found");
    close("value", value, 0.5, 1e-9);
    assert!(suspect);
    // The loss of the rebound at e = 0.6 does not hide that energy.
    assert!(found(&hit(law(0.6, 0.5), 1e-5, VELOCITY).1).is_some_and(|(_, suspect)| suspect));
}

#[test]
fn rebounds_that_lose_energy_are_not_suspect() {
    // Without friction, sliding the other way, with springs instead, and without a rebound.
    assert_eq!(found(&hit(law(1.0, 0.0), 1e-5, VELOCITY).1), None);
    assert_eq!(found(&hit(law(1.0, 0.1), 1e-5, [-0.3, -0.3]).1), None);
    let springs = json!({
        "kind": "coulomb", "friction": 0.5, "contact_stiffness_pa": 1e9, "tangential_stiffness_ratio": 0.5,
    });
    let (report, findings) = hit(springs, 1e-8, VELOCITY);
    assert!(report.energy("friction") >= 0.0 && found(&findings).is_none());
    assert_eq!(
        found(&hit(json!({"kind": "coulomb", "friction": 0.5}), 1e-5, VELOCITY).1),
        None
    );
}

#[test]
fn a_disk_hit_by_two_walls_at_once_is_judged_wall_by_wall() {
    // Spinning into a corner: friction at one wall gives the disk the energy that it takes at the other.
    let spinning = json!([{"x_m": 0.0, "y_m": 3.0 * R, "radius_m": R, "vy_m_per_s": -1.0, "spin_rad_per_s": 500.0}]);
    let walls = json!([
        {"x_m": 0.0, "y_m": 0.0, "nx": 1.0, "ny": 1.0}, {"x_m": 0.0, "y_m": 0.0, "nx": -1.0, "ny": 1.0},
    ]);
    let sample = json!({"kind": "disks", "disks": spinning, "walls": walls});
    let time = json!({"step_s": 1e-5, "theta": 0.5, "pressure_pa": 1.0});
    let mut dem = build(&scene(law(1.0, 0.5), 1e-5, sample, json!({"time": time})));
    let report = march(&mut dem, 0, 400);
    close(
        "friction of both",
        report.energy("friction"),
        0.0,
        1e-12 * mass(R),
    );
    let findings = dem.finish().expect("it ends").findings;
    assert!(found(&findings).is_some_and(|(_, suspect)| suspect));
}

#[test]
fn an_overlap_repaired_by_the_gap_law_gains_speed_and_is_reported() {
    let sample = |y: f64| {
        json!({
            "kind": "disks", "disks": [{"x_m": 0.0, "y_m": y, "radius_m": R}],
            "walls": [{"x_m": 0.0, "y_m": 0.0, "nx": 0.0, "ny": 1.0}],
        })
    };
    let judged = |y: f64| {
        let gap = json!({"kind": "signorini", "penetration": "gap"});
        let mut dem = build(&scene(
            gap,
            1e-5,
            sample(y),
            json!({"gravity_m_per_s2": [0.0, -9.81]}),
        ));
        march(&mut dem, 0, 100);
        found(&dem.finish().expect("it ends").findings)
    };
    assert!(judged(0.995 * R).is_some_and(|(_, suspect)| suspect));
    assert_eq!(judged(R), None);
}
