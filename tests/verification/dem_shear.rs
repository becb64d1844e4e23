//! One bond sheared, or opened and sheared, at a prescribed velocity.
//!
//! ```text
//!   (O)  (O)  -> V cos    both turn with the same spin: opening V cos t, slip V sin t
//! ```
//!
//! Exact (b = 0, h' = 1): D = Cn delta_n^2 + Ct delta_t^2 only grows, so a = min(1, w/D) and the force is
//! l a^2 (Cn delta_n, Ct delta_t). The work is l D/2 up to D = w, and l (w - w^2/(2 D)) after that. In pure shear the force
//! rises to l sqrt(w Ct) at s_0 = sqrt(w/Ct), then falls as l w^2/(Ct delta_t^3). Reference: closed forms of Raous, Cangémi
//! and Cocou (1999). The contact is in the middle of the gap, R + delta_n/2 from the centres, so the slip of a path
//! (s cos, s sin) is s sin (1 + s cos/(4R)).
//! The disks are flywheels with 1e7 l w of energy, so the bond slows them by less than 1e-7. The forces of an implicit
//! step are exact at its end. The work sums the forces at the ends, so at first order it is too large by (step/2) (force at the end).
//! Tolerances: 1e-6 for forces in shear; 1e-4 in an oblique pull, whose arm lags by a step (1e-5 of the slip); 1e-4 of l w
//! for the work, whose second-order error is (step/s_0)^2 = 2.5e-5.

use std::f64::consts::PI;

use dem_node::Dem;
use serde_json::{Value, json};

use crate::dem_support::{THICKNESS, build, close, march, scene};

pub const R: f64 = 0.07e-3;
pub const W: f64 = 60.0;
pub const CN: f64 = 4e14;
pub const CT: f64 = 1.5e14;
/// l of two disks of radius R (m2).
pub const AREA: f64 = 0.5 * R * THICKNESS;
/// A bond without viscosity does not depend on the speed (m/s).
const SPEED: f64 = 1.0;

/// The direction of a displacement: cosine along the normal and sine along the contact.
pub type Direction = [f64; 2];
pub const SHEAR: Direction = [0.0, 1.0];

fn stiffness([cos, sin]: Direction) -> f64 {
    CN * cos * cos + CT * sin * sin
}

/// The path at which D = w, without the rotation in an oblique pull (m).
pub fn critical(direction: Direction) -> f64 {
    (W / stiffness(direction)).sqrt()
}

/// Two heavy disks, m V^2/12 = 1e7 l w, with the relative velocity `speed` along a direction; a step moves them by `step` (m).
pub fn flywheels([cos, sin]: Direction, speed: f64, step: f64, changes: Value) -> Dem {
    let disk = |x: f64, side: f64| -> Value {
        json!({
            "x_m": x, "y_m": 0.0, "radius_m": R,
            "vx_m_per_s": 0.5 * side * speed * cos, "spin_rad_per_s": 0.5 * speed * sin / R,
        })
    };
    let mut law = json!({
        "kind": "cohesion", "friction": 0.3, "cn_pa_per_m": CN, "ct_pa_per_m": CT, "w_j_per_m2": W,
        "b_pa_m_s": 0.0, "p": 1.0, "h_prime": "one", "alert_m": 2e-6,
    });
    for (key, value) in changes.as_object().into_iter().flatten() {
        law[key] = value.clone();
    }
    let sample = json!({"kind": "disks", "disks": [disk(0.0, -1.0), disk(2.0 * R, 1.0)]});
    let density = 12e7 * W * AREA / (speed * speed * PI * R * R * THICKNESS);
    let heavy = json!({"density_kg_per_m3": density});
    build(&scene(law, step / speed, sample, heavy))
}

/// Opening and slip after a path s, with the contact in the middle of the gap.
pub fn opened([cos, sin]: Direction, path: f64) -> [f64; 2] {
    [path * cos, path * sin * (1.0 + path * cos / (4.0 * R))]
}

/// Compares the bond with the closed forms over 30 s_0, with 200 steps per s_0, and returns the largest force (N).
#[track_caller]
fn follows(direction: Direction, tolerance: f64) -> f64 {
    let (per_critical, s_0) = (200, critical(direction));
    let mut dem = flywheels(direction, SPEED, s_0 / f64::from(per_critical), json!({}));
    let (every, mut largest) = (50, 0.0f64);
    for k in 1..=30 * per_critical / every {
        let report = march(&mut dem, u64::from((k - 1) * every), every);
        let path = s_0 * f64::from(k * every) / f64::from(per_critical);
        let [opening, slip] = opened(direction, path);
        let bond = dem.state().bonds[0];
        close("opening", bond.opening, opening, 1e-7 * path);
        close("slip", bond.slip.abs(), slip, 0.1 * tolerance * path);
        let ratio = ((CN * opening * opening + CT * slip * slip) / W).sqrt();
        let adhesion = ratio.powi(-2).min(1.0);
        close("adhesion", bond.adhesion, adhesion, tolerance * adhesion);

        let force = dem.state().list.slots[0].force;
        let [tension, shear] = [CN * opening, CT * slip].map(|c| AREA * adhesion.powi(2) * c);
        let slack = tolerance * (tension + shear);
        close("tension", -force[0], tension, slack);
        // The shear force opposes the slip, for either sign of the slip.
        close("shear", -force[1] * bond.slip.signum(), shear, slack);
        largest = largest.max(force[0].hypot(force[1]));

        // The force at the end of a step counts for the whole step. As the first force is 0, half of the last one is in excess.
        let excess = 0.5 * adhesion.powi(2) * ratio / f64::from(per_critical);
        let work = -report.energy("kinetic") / (W * AREA) - excess;
        close("work", work, exact_work(ratio), 1e-4);
    }
    largest
}

/// Work over l w where D = `ratio`^2 w.
fn exact_work(ratio: f64) -> f64 {
    if ratio < 1.0 {
        0.5 * ratio * ratio
    } else {
        1.0 - 0.5 / (ratio * ratio)
    }
}

#[test]
fn a_sheared_bond_follows_the_closed_form_and_takes_w() {
    let strength = AREA * (W * CT).sqrt();
    close("strength", follows(SHEAR, 1e-6), strength, 1e-6 * strength);
}

#[test]
fn an_oblique_pull_weighs_opening_and_slip_by_their_stiffnesses() {
    for direction in [[0.8, 0.6], [0.6, 0.8]] {
        follows(direction, 1e-4);
    }
}

#[test]
fn the_work_of_shear_converges_at_first_order() {
    let error = [600, 1200, 2400, 4800].map(|steps: u32| {
        let step = 3.0 * critical(SHEAR) / f64::from(steps);
        let mut dem = flywheels(SHEAR, SPEED, step, json!({}));
        let report = march(&mut dem, 0, steps);
        let dissipated = report.energy("cohesion") + report.energy("numerical");
        let taken = dissipated + report.energy("bonds_elastic");
        // Each step rounds the flywheels' energy loss by 1e-16 of their energy, 5e-6 l w in all.
        close("kinetic", -report.energy("kinetic"), taken, 1e-5 * W * AREA);
        (taken / (W * AREA) - exact_work(3.0)).abs()
    });
    for pair in error.windows(2) {
        close("order", (pair[0] / pair[1]).log2(), 1.0, 0.06);
    }
}
