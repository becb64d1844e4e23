//! Problem: a confined strip of 200 elements over its height, under a sudden constant traction.
//! Exact: the surface moves down at sigma/(rho c_p) until the reflection returns at 2H/c_p. It has then sunk by
//! 2 sigma H/M, moves back, and repeats after 4H/c_p, as a triangular wave.
//! During a ramp sigma t/T the surface moves by sigma t^2/(2 T rho c_p).
//! Source: d'Alembert, c_p = sqrt(M/rho).
//! Tolerance: period 0.1 %, velocity 0.5 %. The lumped chain is slower by (pi/4/200)^2/6 in its first mode, and its
//! short waves ripple behind the front.

use protocol::Node;
use serde_json::json;

use crate::fem_bodies::{confined_modulus, node, reported, strip, window, with};

const HEIGHT: f64 = 20e-3;
const SIGMA: f64 = 100e6;

/// Surface displacement after each step (m), and the step (s).
fn surface(steps: u64, ramp: f64) -> (Vec<f64>, f64) {
    let load = json!({"boundary": {"top": {"traction_pa": [0.0, -SIGMA], "ramp_s": ramp}}});
    let mut node = node(&with(strip(2e-4, HEIGHT, 1e-4), load));
    let step = node.model.scheme.step;
    let march = |index| {
        let report = node.advance_alone(&window(index, 1)).expect("stable");
        reported(&node, &report, "surface_mean_uy_m")
    };
    ((0..steps).map(march).collect(), step)
}

#[test]
fn waves_travel_at_the_confined_speed() {
    let speed = (confined_modulus() / 7800.0).sqrt();
    let step = surface(1, 0.0).1;
    let period = 4.0 * HEIGHT / speed;
    let (u, _) = surface((3.6 * period / step) as u64, 0.0);
    let middle = -SIGMA * HEIGHT / confined_modulus();
    let crossings: Vec<f64> = u
        .windows(2)
        .enumerate()
        .filter(|(_, pair)| pair[0] > middle && pair[1] <= middle)
        .map(|(n, pair)| step * (n as f64 + 1.0 + (pair[0] - middle) / (pair[0] - pair[1])))
        .collect();
    assert_eq!(crossings.len(), 4);
    let measured = (crossings[3] - crossings[0]) / 3.0;
    assert!(
        (measured / period - 1.0).abs() < 1e-3,
        "{measured:e} against {period:e}"
    );

    let (early, late) = (
        (0.1 * period / step) as usize,
        (0.4 * period / step) as usize,
    );
    let velocity = (u[late] - u[early]) / ((late - early) as f64 * step);
    let exact = -SIGMA / (7800.0 * speed);
    assert!(
        (velocity / exact - 1.0).abs() < 5e-3,
        "{velocity} against {exact}"
    );
    let deepest = u.iter().fold(0.0, |least: f64, u| least.min(*u));
    assert!((deepest / (2.0 * middle) - 1.0).abs() < 5e-3, "{deepest:e}");
}

#[test]
fn a_ramp_moves_the_surface_with_the_square_of_time() {
    let speed = (confined_modulus() / 7800.0).sqrt();
    let back = 2.0 * HEIGHT / speed;
    let step = surface(1, back).1;
    let steps = (0.9 * back / step) as u64;
    let (u, _) = surface(steps, back);
    let t = steps as f64 * step;
    let exact = -SIGMA * t * t / (2.0 * back * 7800.0 * speed);
    let measured = u[u.len() - 1];
    assert!(
        (measured / exact - 1.0).abs() < 5e-3,
        "{measured:e} against {exact:e}"
    );
}
