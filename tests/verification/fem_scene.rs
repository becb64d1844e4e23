//! Problem: the shipped scene `wheel-rail-fe-small`, unchanged: the paper's rail on 5 640 elements (d = 0.2 mm) under a
//! flat wheel of 8 000 N, with a ramp, a hold and two cycles of 0.05 mm at 300 Hz.
//!
//! Reference: independent dynamics of the same mesh: 37.8 % of sliding nodes at the highest speed. Independent quasi-static
//! finite elements: 664.7 MPa of hydrostatic pressure at centroids for d = 0.2 mm (784 MPa without friction while loading),
//! 678.1 MPa at Gauss points, approach 0.09224 mm, loop of the steady cycle 89.63 N mm.
//! Tolerance: 1 % of pressures and approach and 2 % of the loop, for the wheel's remaining bounce; 2 points of Sn, one of the 52
//! nodes in contact.

use fem_node::{FemConfig, FemNode};
use kit::read_config;
use protocol::Node;
use serde_json::Value;

use crate::fem_bodies::setting;
use crate::fem_wheel::{balance, run};

/// The keys of the only participant of a shipped scene.
fn shipped(scene: &str) -> Value {
    let path = format!(
        "{}/../scenarios/{scene}/scenario.toml",
        env!("CARGO_MANIFEST_DIR")
    );
    let text = std::fs::read_to_string(&path).expect("it ships");
    let table: Value = toml::from_str(&text).expect("it is TOML");
    table["participant"][0]["config"].clone()
}

#[test]
fn the_small_scene_has_the_references_pressure_sliding_and_loop() {
    let config: FemConfig = read_config(shipped("wheel-rail-fe-small")).expect("valid");
    let mut rail = FemNode::new(&config, &setting(1)).expect("valid");
    let mut worst = 0.0_f64;
    run(&mut rail, |node, report| {
        worst = worst.max(balance(node, report))
    });
    assert!(worst <= 1e-6, "energy balance {worst:e}");
    let outcome = rail.finish().expect("it ends");
    assert_eq!(outcome.work["element_steps"] / outcome.steps as f64, 5640.0);
    for (name, expected, tolerance) in [
        ("p_max_centroid_pa", 665e6, 0.01 * 665e6),
        ("p_max_gauss_pa", 678.1e6, 0.01 * 678.1e6),
        ("approach_m", 9.224e-5, 0.01 * 9.224e-5),
        ("loop_area_j", 89.63e-3, 0.02 * 89.63e-3),
        ("sn_max_velocity_pct", 37.8, 2.0),
        ("wheel_force_n", 8000.0, 8.0),
    ] {
        let value = outcome.results[name];
        let error = (value - expected).abs();
        assert!(error <= tolerance, "{name}: {value:e} against {expected:e}");
    }
    let sliding = outcome.results["sn_sliding_mean_pct"];
    assert!(
        (75.0..=97.0).contains(&sliding),
        "{sliding} % of sliding nodes"
    );
}
