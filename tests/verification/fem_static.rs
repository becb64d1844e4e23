//! Problem: a confined strip, 5 mm high, under a constant traction; mass damping brings it to rest.
//! Exact: it sinks by sigma H / M, with the confined modulus M = lambda + 2 mu. sxx = szz = nu/(1-nu) sigma, so
//! p = sigma (1 + nu)/(3 (1 - nu)) at every point.
//! Source: Hooke's law in uniaxial strain.
//! Tolerance: 1e-6; at critical damping of the first mode, c = 2 omega_1 = pi c_p/H, exp(-omega t)(1 + omega t)
//! is 4e-9 after omega t = 22.

use std::f64::consts::PI;

use protocol::Node;
use serde_json::json;

use crate::fem_bodies::{confined_modulus, node, reported, strip, window, with};

const HEIGHT: f64 = 5e-3;
const SIGMA: f64 = 500e6;

#[test]
fn a_damped_strip_settles_to_hookes_law() {
    let omega = 0.5 * PI * (confined_modulus() / 7800.0).sqrt() / HEIGHT;
    let config = with(
        strip(1e-3, HEIGHT, 2.5e-4),
        json!({
            "time": {"damping": 0.75, "mass_damping_per_s": 2.0 * omega},
            "boundary": {"top": {"traction_pa": [0.0, -SIGMA], "ramp_s": 1e-6}},
        }),
    );
    let mut node = node(&config);
    let steps = (22.0 / omega / node.model.scheme.step) as u32;
    let report = node.advance_alone(&window(0, steps)).expect("stable");
    let sunk = -reported(&node, &report, "surface_mean_uy_m");
    let exact = SIGMA * HEIGHT / confined_modulus();
    assert!(
        (sunk / exact - 1.0).abs() < 1e-6,
        "{sunk:e} against {exact:e}"
    );

    let results = node.finish().expect("it ends").results;
    let pressure = SIGMA * 1.3 / (3.0 * 0.7);
    for name in ["p_max_centroid_pa", "p_max_gauss_pa"] {
        assert!(
            (results[name] / pressure - 1.0).abs() < 1e-6,
            "{name} {}",
            results[name]
        );
    }
}

#[test]
fn plane_stress_between_free_sides_settles_to_youngs_modulus() {
    let config = json!({
        "plane": "stress", "base": "roller", "sides": "free",
        "mesh": {"width_m": 1e-3, "height_m": 2e-3, "size_m": 2.5e-4},
        "material": {"young_pa": 102.5e9, "poisson": 0.3, "density_kg_per_m3": 7800.0},
        "time": {"step_s": "auto", "damping": 0.75, "mass_damping_per_s": 4e6},
        "boundary": {"top": {"traction_pa": [0.0, -SIGMA]}},
    });
    let mut node = node(&config);
    let report = node.advance_alone(&window(0, 2000)).expect("stable");
    let sunk = -reported(&node, &report, "surface_mean_uy_m");
    let exact = SIGMA * 2e-3 / 102.5e9;
    assert!(
        (sunk / exact - 1.0).abs() < 1e-6,
        "{sunk:e} against {exact:e}"
    );
}
