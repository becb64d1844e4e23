//! Elastic bar on a rigid wall, and on a rigid mass as heavy as itself (cases 3 and 4 of the coupling page).
//!
//! Problem: a free elastic bar (100 elements of 1 kg and 1 N/m, wave speed c = 1 m/s, L = 100 m) flies at v0 against a disk at
//! rest: the bar's end carries a glued disk that touches the other one without being tied to it. The contact is
//! unilateral and rigid; the grains' own solver solves it, one window at a time.
//!
//! ```text
//!   |~ bar, 100 elements, explicit ~|o O  a disk of 1e12 kg (the wall), or of the bar's own 100 kg
//!             v0 -->
//! ```
//!
//! Exact answers (Saint-Venant, Love 1927, articles 282 to 284): on the wall the contact carries rho c v0 = v0 sqrt(k m) for
//! the time 2 L/c, and the bar leaves with -v0; a mass M of the bar's own mass leaves with v0 (1 - exp(-2)) = 0.8647 v0.
//! Independent prototypes measured the error with windows of 0.9 L/100 c and of four times that length: contact time +1 %,
//! plateau -1 %, rebound -0.987 v0 at H = 0.036 L/c; 0.859 v0 with one step per window, 0.855 v0 with four. Ours loses less
//! on the wall than the prototypes: -0.991 v0, contact time -1 % (counted in windows of 1.8 %), plateau -0.03 %.

use harness::runs::{Left, run_in_process, run_over_shared_memory};
use harness::scene::{bar, head, interface, participant};

/// Velocity of the bar (m/s).
const V0: f64 = 1e-3;
/// Wave time of the bar, L/c (s).
const WAVE_S: f64 = 100.0;

fn scenario(mass_kg: f64, substeps: u32) -> String {
    let density = mass_kg / std::f64::consts::PI;
    let obstacle = format!(
        r#"
density_kg_per_m3 = {density}
law = {{ kind = "signorini" }}
solver = {{ kind = "nsgs", tolerance = 1e-12, max_iterations = 1000, min_iterations = 1 }}
time = {{ pressure_pa = 1e-12 }}
sample = {{ kind = "disks", disks = [
  {{ x_m = 100.0, y_m = 0.0, radius_m = 1.0, glued = true }},
  {{ x_m = 102.0, y_m = 0.0, radius_m = 1.0 }},
] }}
"#
    );
    let ends = ["bar.end", "obstacle.base"];
    [
        head("impact", 1.0, "end_s = 288.0"),
        bar("bar", 100, 0.9, &format!("velocity_m_per_s = {V0:?}")),
        participant("obstacle", "dem", &obstacle),
        interface("end", ends, "dual-schur", substeps, "tolerance_rel = 1e-12"),
    ]
    .concat()
}

fn inside(mass_kg: f64, substeps: u32) -> Left {
    run_in_process(&scenario(mass_kg, substeps), &[])
        .expect("it is valid")
        .completed()
}

fn outside(mass_kg: f64, substeps: u32) -> Left {
    run_over_shared_memory(&scenario(mass_kg, substeps), &[])
        .expect("it is valid")
        .completed()
}

/// Mean velocity of the bar at the end over v0.
fn rebound(left: &Left) -> f64 {
    let momentum = left.signals["bar.momentum_kg_m_per_s"].last();
    momentum.expect("there are windows") / (100.0 * V0)
}

fn wall_holds(left: &Left) {
    // Compression pushes the bar back: negative forces. The plateau is the mean over the middle of the contact.
    let force = &left.signals["interface_fx_n"];
    let t = &left.signals["t_s"];
    let window_s = t[1] - t[0];
    let pressed = force.iter().filter(|f| **f < -0.5 * V0).count();
    let contact_s = pressed as f64 * window_s;
    let middle: Vec<f64> = t
        .iter()
        .zip(force)
        .filter(|(t, _)| (0.2 * WAVE_S..1.8 * WAVE_S).contains(*t))
        .map(|(_, f)| -f / V0)
        .collect();
    let plateau = middle.iter().sum::<f64>() / middle.len() as f64;
    let (contact, rebound) = (contact_s / (2.0 * WAVE_S), rebound(left));
    println!(
        "contact {contact:.4} of 2 L/c, plateau {plateau:.4} of rho c v0, rebound {rebound:.4}"
    );
    assert!((0.99..=1.02).contains(&contact), "contact {contact}");
    assert!((plateau - 0.99).abs() <= 0.01, "plateau {plateau}");
    assert!((-1.0..=-0.987).contains(&rebound), "rebound {rebound}");
    assert!(force.iter().all(|f| *f <= 1e-15), "it never pulls");
    assert!(left.number("coupling.gap_max_rel") <= 1e-12);
}

#[test]
fn a_bar_on_a_rigid_wall_rebounds_after_two_wave_times() {
    wall_holds(&inside(1e12, 4));
}

#[test]
fn a_bar_on_a_rigid_wall_rebounds_over_shared_memory_too() {
    wall_holds(&outside(1e12, 4));
}

fn mass_holds(left: &Left, expected: f64) {
    let velocity = 1.0 - rebound(left);
    println!("the mass leaves with {velocity:.4} v0");
    assert!((velocity - expected).abs() <= 1e-3, "{velocity} v0");
    assert!(velocity < 1.0 - (-2.0f64).exp());
    assert!(left.number("coupling.gap_max_rel") <= 1e-12);
    assert!(left.number("coupling.force_residual_rel") <= 1e-12);
}

#[test]
fn an_equal_mass_leaves_with_the_velocity_of_saint_venant() {
    mass_holds(&inside(100.0, 1), 0.859);
    mass_holds(&inside(100.0, 4), 0.855);
}

#[test]
fn an_equal_mass_leaves_with_the_same_velocity_over_shared_memory() {
    mass_holds(&outside(100.0, 4), 0.855);
}
