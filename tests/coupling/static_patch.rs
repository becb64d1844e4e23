//! Static patch (case 5 of the coupling page).
//!
//! Problem: an elastic strip, 4 mm wide and 8 mm high, with its sides clamped in x and its base held. A row of masses
//! under a constant traction is glued to its upper edge through the mapping and presses it. Mass damping brings the strip
//! to rest.
//!
//! ```text
//!      | | | | |  500 MPa
//!      o-o-o-o-o  masses, glued
//!     |~~~~~~~~~|
//!    >| elastic |<  no lateral motion
//!     |_________|
//! ```
//!
//! Exact answer: uniaxial strain, u_y = -p L / M with M = E (1 - nu) / ((1 + nu)(1 - 2 nu)), and the interface carries p
//! everywhere. Tolerance 5e-4, gap 1e-12 node spacings: measured by independent prototypes (1.0001, 1.0002, 3e-17).

use harness::runs::{Left, run_in_process, run_over_shared_memory};
use harness::scene::{POISSON, YOUNG_PA, head, interface, plate, strip};

const HEIGHT_M: f64 = 8e-3;
const PRESSURE_PA: f64 = 500e6;

pub(super) fn scenario(substeps: u32, points: u32) -> String {
    let time = "time = { step_s = 6.0e-8, damping = 0.5, mass_damping_per_s = 6e5 }";
    let sets = ["strip.top", "plate.row"];
    [
        head("static-patch", 1e-3, ""),
        strip("strip", ["clamped", "fixed_x"], HEIGHT_M, time),
        plate(points, -PRESSURE_PA, 1.2e-4),
        interface("glue", sets, "dual-schur", substeps, "tolerance_rel = 1e-9"),
    ]
    .concat()
}

fn holds(left: &Left, substeps: u32) {
    settles(left, substeps);
    assert!(left.number("results.energy_balance_rel") <= 1e-9);
}

pub(super) fn settles(left: &Left, substeps: u32) {
    let last = |name: &str| *left.signals[name].last().expect("there are windows");
    let modulus = YOUNG_PA * (1.0 - POISSON) / ((1.0 + POISSON) * (1.0 - 2.0 * POISSON));
    let displacement = -last("strip.surface_mean_uy_m") / (PRESSURE_PA * HEIGHT_M / modulus);
    let traction = -last("interface_fy_n") / (PRESSURE_PA * 4e-6);
    let gap = left.number("coupling.gap_max_rel");
    println!(
        "m = {substeps}: traction {traction:.6}, displacement {displacement:.6} of exact, gap {gap:.1e}"
    );
    assert!((traction - 1.0).abs() <= 5e-4, "traction {traction}");
    assert!(
        (displacement - 1.0).abs() <= 5e-4,
        "displacement {displacement}"
    );
    assert!(gap <= 1e-12, "gap {gap}");
    assert!(left.number("coupling.force_residual_rel") <= 1e-12);
}

#[test]
fn traction_and_displacement_settle_on_the_static_answer() {
    for (substeps, points) in [(1, 10), (10, 23), (30, 23)] {
        let left = run_in_process(&scenario(substeps, points), &[])
            .expect("it is valid")
            .completed();
        holds(&left, substeps);
    }
}

#[test]
fn the_same_over_shared_memory() {
    let left = run_over_shared_memory(&scenario(10, 23), &[])
        .expect("it is valid")
        .completed();
    holds(&left, 10);
}
