//! Split bar (case 1 of the coupling page).
//!
//! Problem: a uniform elastic lattice (spacing 1 m, masses 1 kg, springs 1 N/m, wave speed 1 m/s), its left 100
//! elements an explicit bar, the rest a chain of masses and springs with one implicit step per window. A pulse
//! exp(-((x - 50) / 10)^2) m travels right through the joint at x = 100 m.
//!
//! ```text
//!   |~ bar, 100 elements, explicit ~|o-o-o- chain, 100 masses, implicit -o-o
//!             pulse -->          x = 100
//! ```
//!
//! Exact answer: the same lattice in one piece (the node at the joint keeps its half mass, since a glued point has no
//! mass), integrated with 1/200 of the step. An independent program of thirty lines (dense matrices, another language)
//! computed the errors of this case: 2.077e-2 at theta = 0.5, 2.538e-2 at theta = 1; with a tenth of the step
//! 6.04e-4 and 2.55e-3. Energy -0.8 % and -81 %.

use harness::lattice::{Lattice, pulse_m, pulse_m_per_s};
use harness::runs::{Left, run_both_ways, run_in_process};
use harness::scene::{bar, chain, head, interface};

const SUBSTEPS: u32 = 10;
/// The step of the case; the critical one is 1 s.
pub(super) const STEP_S: f64 = 0.9;
/// Eighteen windows; the case's 160 s would end with a short window, which the table does not contain.
const END_S: f64 = 162.0;

pub(super) fn scenario(theta: f64, step_s: f64) -> String {
    let pulse = "pulse = { centre_m = 50.0, width_m = 10.0 }";
    let keys = format!("glued_mass_kg = 0.0\ntheta = {theta:?}\nend_s = {END_S:?}");
    let (ends, tolerance) = (["bar.end", "chain.end"], "tolerance_rel = 1e-9");
    [
        head("split-bar", 1.0, ""),
        bar("bar", 100, step_s, pulse),
        chain("chain", 100.0, 100, &keys),
        interface("joint", ends, "dual-schur", SUBSTEPS, tolerance),
    ]
    .concat()
}

/// Displacement of node 100 of the whole lattice at these times.
fn monolithic(times: &[f64]) -> Vec<f64> {
    let lattice = Lattice {
        nodes: 201,
        halves: &[0, 100],
        at_rest: 201,
        step_s: STEP_S / 200.0,
    };
    lattice.displacements([100], times).concat()
}

pub(super) fn interface_error(left: &Left) -> f64 {
    let times = &left.signals["t_s"];
    let exact = monolithic(times);
    let found = &left.signals["bar.u_m"];
    let square = |values: &mut dyn Iterator<Item = f64>| values.map(|v| v * v).sum::<f64>();
    let difference = square(&mut found.iter().zip(&exact).map(|(a, b)| a - b));
    (difference / square(&mut exact.iter().copied())).sqrt()
}

/// Total energy after each window over the energy at the start.
fn energy(left: &Left) -> Vec<f64> {
    let start = pulse_energy_j();
    let (bar, chain) = (
        &left.signals["bar.energy_j"],
        &left.signals["chain.energy_j"],
    );
    bar.iter()
        .zip(chain)
        .map(|(a, b)| (start + a + b) / start)
        .collect()
}

/// a.M a of the pulse, for masses of 1 kg.
fn inertia() -> f64 {
    (1..100)
        .map(|i| (pulse_m(i + 1) - 2.0 * pulse_m(i) + pulse_m(i - 1)).powi(2))
        .sum()
}

/// Kinetic and strain energy of the pulse (J).
pub(super) fn mechanical_j() -> f64 {
    pulse_energy_j() + 0.125 * STEP_S * STEP_S * inertia()
}

/// Energy of the pulse (J) as the bar's ledger counts it, see `harness::bar`.
fn pulse_energy_j() -> f64 {
    let u = pulse_m;
    let strain: f64 = (0..100).map(|i| 0.5 * (u(i + 1) - u(i)).powi(2)).sum();
    let kinetic: f64 = (0..=100).map(|i| 0.5 * pulse_m_per_s(i).powi(2)).sum();
    strain + kinetic - 0.125 * STEP_S * STEP_S * inertia()
}

#[test]
fn the_trapezoidal_chain_carries_the_pulse_on_and_keeps_its_energy() {
    let left = run_in_process(&scenario(0.5, STEP_S), &[])
        .expect("it is valid")
        .completed();
    let (bar, chain) = (
        &left.signals["bar.mechanical_j"],
        &left.signals["chain.energy_j"],
    );
    let last = (bar[bar.len() - 1] + chain[chain.len() - 1]) / mechanical_j();
    println!(
        "error {:.3e}, energy {last:.4}, gap {:.1e}",
        interface_error(&left),
        left.number("coupling.gap_max_rel")
    );
    assert!((interface_error(&left) / 2.077e-2 - 1.0).abs() < 5e-3);
    assert!((last - 1.0).abs() <= 0.01, "energy {last}");
    assert!(left.number("coupling.gap_max_rel") <= 1e-10);
    assert_eq!(left.number("repeats_mean"), 1.0);
}

#[test]
fn the_implicit_euler_chain_never_gains_energy() {
    let left = run_in_process(&scenario(1.0, STEP_S), &[])
        .expect("it is valid")
        .completed();
    let energy = energy(&left);
    println!(
        "error {:.3e}, energy {:.4}",
        interface_error(&left),
        energy[energy.len() - 1]
    );
    assert!((interface_error(&left) / 2.538e-2 - 1.0).abs() < 5e-3);
    for pair in energy.windows(2) {
        assert!(pair[1] <= pair[0] * (1.0 + 1e-12), "energy rose: {pair:?}");
    }
    assert!(left.number("coupling.gap_max_rel") <= 1e-10);
}

#[test]
fn a_tenth_of_the_step_reduces_the_error() {
    for (theta, expected) in [(0.5, 6.04e-4), (1.0, 2.55e-3)] {
        let left = run_in_process(&scenario(theta, 0.1 * STEP_S), &[])
            .expect("it is valid")
            .completed();
        let error = interface_error(&left);
        assert!(
            (error / expected - 1.0).abs() < 2e-2,
            "theta {theta}: error {error:.3e}"
        );
    }
}

#[test]
fn shared_memory_gives_the_same_bits() {
    run_both_ways(&scenario(1.0, STEP_S), &[]);
}
