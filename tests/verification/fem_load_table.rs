//! Problem: a confined strip under a flat smooth wheel of mass m, with a load table: a step at the start, then straight
//! lines, one of them unloading, then a constant.
//! Exact: until the reflection returns the strip resists with Z v, Z = rho c_p A: m v' + Z v = F(t). With t0 = m/Z and s the
//! time since the change, a step F of the force moves the top by F/Z (s - t0 (1 - exp(-s/t0))). A change k of the slope
//! moves it by k/Z (s^2/2 - t0 s + t0^2 (1 - exp(-s/t0))). The displacements add up.
//! Source: d'Alembert, c_p = sqrt(M/rho); Newton.
//! Tolerance: 0.5 % of the last displacement, for the short waves of the step, as in `fem_wave`.

use protocol::Node;
use serde_json::json;

use crate::fem_bodies::{confined_modulus, node, reported, strip, window, with};

const WIDTH: f64 = 2e-4;
const HEIGHT: f64 = 20e-3;

/// Times (s) and forces (N).
const TABLE: [[f64; 2]; 4] = [[0.0, 2.0], [2e-6, 8.0], [4e-6, 3.0], [6e-6, 5.0]];
const END: f64 = 7e-6;

/// Downward displacement of the top (m), for the resistance Z and the time t0 = m/Z.
fn sunk(t: f64, resistance: f64, t0: f64) -> f64 {
    let relaxed = |s: f64| t0 * (1.0 - (-s / t0).exp());
    let step = TABLE[0][1] * (t - relaxed(t));
    let slopes = TABLE
        .windows(2)
        .map(|p| (p[1][1] - p[0][1]) / (p[1][0] - p[0][0]));
    let slopes: Vec<f64> = [0.0].into_iter().chain(slopes).chain([0.0]).collect();
    let kinks = TABLE.iter().zip(slopes.windows(2)).map(|([at, _], k)| {
        let s = (t - at).max(0.0);
        (k[1] - k[0]) * (0.5 * s * s - t0 * (s - relaxed(s)))
    });
    (step + kinks.sum::<f64>()) / resistance
}

#[test]
fn a_wheel_follows_the_table_of_its_load() {
    let mass = 1e-5;
    let wheel = json!({
        "wheel": {"load_n": 5.0, "load_table": TABLE, "mass_kg": mass, "ramp_s": 0.0, "hold_s": END},
        "contact": {"friction": 0.0},
    });
    let mut node = node(&with(strip(WIDTH, HEIGHT, 1e-4), wheel));
    let h = node.model.scheme.step;
    let resistance = 7800.0 * (confined_modulus() / 7800.0).sqrt() * WIDTH * 1e-3;
    let exact = |t: f64| sunk(t, resistance, mass / resistance);
    let errors = (0..(END / h) as u64).map(|index| {
        let report = node.advance_alone(&window(index, 1)).expect("stable");
        let measured = -reported(&node, &report, "surface_mean_uy_m");
        (measured - exact((index + 1) as f64 * h)).abs()
    });
    let error = errors.fold(0.0, f64::max) / exact(END);
    assert!(error < 5e-3, "{error:e}");
}
