//! Problem: one element between rollers, a single mass on a spring: omega = sqrt(2) c/H, c = sqrt(M/rho).
//! Exact: damping ratio xi and relative frequency error of the scheme for Omega = omega h.
//! Source: rows of a spectral analysis by an independent code (six digits), copied below. They follow from the
//! amplification matrix's trace = 2 - (b + 1/2) Omega^2 and det = 1 + (1/2 - b) Omega^2.
//! Tolerance: the printed digits, 1e-5 relative, and 1e-9 for the rounding of the measured displacements.

use protocol::Node;
use serde_json::json;

use crate::fem_bodies::{confined_modulus, node, reported, strip, window, with};

const HEIGHT: f64 = 1e-3;

/// (b, Omega, xi, relative frequency error)
const ROWS: [(f64, f64, f64, f64); 15] = [
    (0.5, 0.01, 0.0, 4.16671e-06),
    (0.5, 0.1, 0.0, 0.000417136),
    (0.5, 1.0, 0.0, 0.0471976),
    (0.5, 1.5, 0.0, 0.130749),
    (0.55, 0.1, 0.00249927, 0.000539202),
    (0.55, 1.5, 0.0338015, 0.176266),
    (0.6, 0.5, 0.0248881, 0.0169511),
    (0.75, 0.01, 0.00125, 9.63561e-06),
    (0.75, 0.1, 0.0125026, 0.000965526),
    (0.75, 0.5, 0.0628151, 0.0254081),
    (0.75, 1.0, 0.127052, 0.122964),
    (0.75, 1.5, 0.182079, 0.488106),
    (0.9, 1.0, 0.212741, 0.173097),
    (1.0, 0.1, 0.0250209, 0.00135851),
    (1.0, 1.0, 0.275472, 0.209429),
];

/// Displacements after each step of a free motion.
fn free_motion(damping: f64, omega_h: f64, steps: u64) -> Vec<f64> {
    let speed = (confined_modulus() / 7800.0).sqrt();
    let step = omega_h * HEIGHT / (2f64.sqrt() * speed);
    let time = json!({"time": {"step_s": step, "damping": damping, "unsafe_step": true}});
    let mut node = node(&with(strip(HEIGHT, HEIGHT, HEIGHT), time));
    node.couple("top").expect("a set");
    node.advance(&window(0, 1), &[0.0, -1.0, 0.0, -1.0])
        .expect("one step");
    node.commit(&window(0, 1), &[]).expect("advanced");
    let mut march = |index| {
        let report = node.advance_alone(&window(index, 1)).expect("stable");
        reported(&node, &report, "surface_mean_uy_m")
    };
    (1..=steps).map(&mut march).collect()
}

/// ln|eigenvalue| and its argument, from u(n+2k) = trace u(n+k) - det u(n) over k steps. k is about 1/Omega, which
/// keeps the two equations well conditioned.
fn eigenvalue(damping: f64, omega_h: f64) -> (f64, f64) {
    let k = (1.0 / omega_h).round() as usize;
    let u = free_motion(damping, omega_h, 4 * k as u64);
    let at = |n: usize| u[n * k];
    let determinant = at(1) * at(1) - at(0) * at(2);
    let trace = (at(1) * at(2) - at(0) * at(3)) / determinant;
    let product = (at(2) * at(2) - at(1) * at(3)) / determinant;
    let phase = (trace / (2.0 * product.sqrt())).acos();
    (product.ln() / (2.0 * k as f64), phase / k as f64)
}

#[test]
fn damping_and_frequency_follow_the_spectral_analysis() {
    for (damping, omega_h, xi, frequency) in ROWS {
        let (growth, phase) = eigenvalue(damping, omega_h);
        let measured = (-growth / growth.hypot(phase), phase / omega_h - 1.0);
        let close = |a: f64, b: f64| (a - b).abs() <= 1e-5 * b.abs() + 1e-9;
        assert!(
            close(measured.0, xi) && close(measured.1, frequency),
            "b {damping} Omega {omega_h}: {measured:?} against {xi} {frequency}"
        );
    }
}
