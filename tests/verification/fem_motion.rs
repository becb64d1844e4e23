//! Problem: the top of a strip moves at a constant velocity v from rest; the top of a block has a displacement with a ramp.
//! Exact: until the wave reaches the base the stress behind the front is rho c v. The drive does the work
//! rho c v^2 t per area, half kinetic and half strain energy. A displacement is reached at the end of its ramp and held.
//! Source: d'Alembert, c = sqrt(M/rho); energies of a progressive wave.
//! Tolerance: 1 % for the stress behind the front, which ripples; 0.5 % for the work; 1e-12 for prescribed displacements;
//! 1e-10 for the balance, as in `fem_energy`.

use fem_node::output::probe;
use protocol::Node;
use serde_json::{Value, json};

use crate::fem_bodies::{block, confined_modulus, node, reported, setting, strip, window, with};

const HEIGHT: f64 = 20e-3;

#[test]
fn a_moving_end_sends_the_wave_of_its_velocity() {
    let drive = json!({"time": {"damping": 0.75},
                       "boundary": {"top": {"velocity_m_per_s": ["free", -1.0]}}});
    let mut node = node(&with(strip(2e-4, HEIGHT, 1e-4), drive));
    let speed = (confined_modulus() / 7800.0).sqrt();
    let steps = (0.8 * HEIGHT / speed / node.model.scheme.step) as u32;
    let time = f64::from(steps) * node.model.scheme.step;
    let report = node.advance_alone(&window(0, steps)).expect("stable");

    let exact = -7800.0 * speed;
    for row in [40, 60, 80] {
        let stress = probe::stress(&node.model, node.state(), [0, row], [0.0, 0.0])[1];
        assert!(
            (stress / exact - 1.0).abs() < 1e-2,
            "row {row}: {stress:e} {exact:e}"
        );
    }
    let area = 2e-4 * 1e-3;
    let work = reported(&node, &report, "drive_work") / (7800.0 * speed * time * area);
    assert!((work - 1.0).abs() < 5e-3, "{work}");
    let sunk = reported(&node, &report, "surface_mean_uy_m");
    assert!((sunk / -time - 1.0).abs() < 1e-12, "{sunk:e} {time:e}");
}

#[test]
fn a_displacement_is_reached_and_held() {
    let drive = json!({"boundary": {"top": {"displacement_m": [1e-6, -2e-6], "ramp_s": 1e-6}}});
    let mut node = node(&with(block(), drive));
    let half = (0.5e-6 / node.model.scheme.step) as u32;
    let places = |node: &fem_node::FemNode| {
        [0, 1].map(|k| node.state().u[node.model.body.layout.index([4, 0], k)])
    };
    node.advance_alone(&window(0, half)).expect("stable");
    let share = f64::from(half) * node.model.scheme.step / 1e-6;
    for (place, end) in places(&node).into_iter().zip([1e-6, -2e-6]) {
        assert!((place / (share * end) - 1.0).abs() < 1e-12, "{place:e}");
    }
    node.advance_alone(&window(1, 3 * half)).expect("stable");
    for (place, end) in places(&node).into_iter().zip([1e-6, -2e-6]) {
        assert!((place / end - 1.0).abs() < 1e-12, "{place:e}");
    }
}

/// The drive acts with a load on another set, a coupled set that shares a corner with the driven one, and mass damping.
#[test]
fn the_work_of_a_drive_is_accounted_for() {
    for damping in [0.5, 0.75] {
        let mut node = node(&with(
            block(),
            json!({
                "time": {"damping": damping, "mass_damping_per_s": 3e5},
                "boundary": {"left": {"velocity_m_per_s": [0.3, "free"], "ramp_s": 1e-6},
                             "right": {"traction_pa": [1e6, 2e6]}},
            }),
        ));
        let points = node.couple("top").expect("a set").len();
        for index in 0..100u64 {
            let force: Vec<f64> = (0..2 * points as u64)
                .map(|k| 50.0 * (((index * 37 + k * 11) % 101) as f64 / 101.0 - 0.5))
                .collect();
            node.advance(&window(index, 10), &force).expect("stable");
            let report = node.commit(&window(index, 10), &[]).expect("advanced");
            let term = |name| reported(&node, &report, name);
            let work = ["interface_work", "applied_work", "drive_work"].map(term);
            let gone = ["strain", "kinetic", "mass_damping", "numerical_loss"].map(term);
            let total: f64 = work.iter().map(|w| w.abs()).sum();
            let defect = work.iter().sum::<f64>() - gone.iter().sum::<f64>();
            assert!(
                defect.abs() <= 1e-10 * total,
                "window {index}: {defect:e} of {total:e}"
            );
        }
    }
}

#[test]
fn a_pressure_pushes_each_edge_inwards() {
    for (set, [x, y]) in [
        ("top", [0.0, -1.0]),
        ("left", [1.0, 0.0]),
        ("right", [-1.0, 0.0]),
    ] {
        let load =
            json!({"mesh": {"crown_radius_m": 0.0}, "boundary": {set: {"pressure_pa": 2e6}}});
        let node = node(&with(block(), load));
        let layout = node.model.body.layout;
        let mut total = [0.0; 2];
        for (index, force) in &node.model.tractions[0].forces {
            let component = (index % layout.row_len()) / layout.stride;
            total[component] += force;
        }
        let length = if set == "top" { 12e-3 } else { 7e-3 };
        let size = 2e6 * length * 1e-3;
        let close = (total[0] - size * x).abs() < 1e-9 && (total[1] - size * y).abs() < 1e-9;
        assert!(close, "{set}: {total:?}");
    }
}

#[test]
fn impossible_motions_materials_and_supports_are_refused_by_their_key() {
    let cases = [
        ("boundary.top", json!({"boundary": {"top": {}}})),
        (
            "boundary.top",
            json!({"boundary": {"top": {"traction_pa": [0.0, 1.0], "velocity_m_per_s": [0.0, 1.0]}}}),
        ),
        (
            "boundary.top.ramp_s",
            json!({"boundary": {"top": {"displacement_m": [0.0, 1e-6]}}}),
        ),
        (
            "boundary.bottom",
            json!({"boundary": {"bottom": {"velocity_m_per_s": [0.0, 1.0]}}}),
        ),
        (
            "boundary.top",
            json!({"boundary": {"top": {"velocity_m_per_s": [0.0, 1.0]},
                                             "left": {"velocity_m_per_s": [1.0, 0.0]}}}),
        ),
        (
            "plane",
            json!({"plane": "stress", "material": {"yield_pa": 1e8}}),
        ),
        ("material.yield_pa", json!({"material": {"kind": "j2"}})),
        ("material.yield_pa", json!({"material": {"yield_pa": 0.0}})),
        (
            "material.hardening_pa",
            json!({"material": {"hardening_pa": 1e9}}),
        ),
        (
            "material.kinematic_hardening_pa",
            json!({"material": {"yield_pa": 1e8, "kinematic_hardening_pa": -1.0}}),
        ),
        (
            "material.yield_pa",
            json!({"analysis": "static", "material": {"yield_pa": 1e8}}),
        ),
        ("base", json!({"analysis": "static", "base": "free"})),
        (
            "boundary.left",
            json!({"analysis": "static", "boundary": {"left": {"displacement_m": [0.0, 0.0]}}}),
        ),
        (
            "kinematics",
            json!({"kinematics": "corotational", "element": "q4_bbar"}),
        ),
        (
            "kinematics",
            json!({"kinematics": "corotational", "material": {"yield_pa": 1e8}}),
        ),
    ];
    for (key, change) in cases {
        let config: Value = with(block(), change);
        let error = fem_node::check(&config, &setting(1)).expect_err("it is impossible");
        assert_eq!(error.key, key, "{error}");
        assert!(error.help.is_some(), "{error}");
    }
}

#[test]
fn a_driven_set_cannot_be_coupled() {
    let drive = json!({"boundary": {"top": {"velocity_m_per_s": [0.0, 1.0]}}});
    let error = node(&with(block(), drive))
        .couple("top")
        .expect_err("the scene prescribes its motion");
    assert!(error.message.contains("boundary.top"), "{error}");
}
