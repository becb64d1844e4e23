//! Problem: a force on the head of a slender soft column, clamped at its foot, bends it to a large rotation.
//! Exact: work - stored - dissipated = 0. With small strain the rotated column is longer; with corotational kinematics it
//! keeps its length, up to the stretch from the force.
//! Source: the energy in `fem_kernel::material::nonlinear`; inextensibility of a slender column in bending (Euler).
//! Tolerance: the trapezium rule for the internal forces' work is exact for linear forces only. So the balance of a
//! rotating body is of second order in the step: order 2 within 0.3, and 1e-6 of the work at 0.45 of the limit. 1 % for
//! the length.

use protocol::Node;
use serde_json::{Value, json};

use crate::fem_bodies::{node, reported, window};

fn column(element: &str, kinematics: &str, refined: u32) -> Value {
    json!({
        "element": element, "kinematics": kinematics,
        "mesh": {"width_m": 1e-3, "height_m": 10e-3, "size_m": 2.5e-4},
        "material": {"young_pa": 1e8, "poisson": 0.3, "density_kg_per_m3": 1000.0},
        "time": {"step_s": "auto", "damping": 0.5, "safety": 0.9 / f64::from(refined)},
    })
}

/// Length of the centre line over the height, angle of the head (rad), largest |W - E - D| / W.
fn bent(config: &Value, refined: u32) -> [f64; 3] {
    let mut node = node(config);
    node.couple("top").expect("a set");
    let force: Vec<f64> = [0.02, 0.0].repeat(5);
    let mut worst: f64 = 0.0;
    for index in 0..100 {
        node.advance(&window(index, 40 * refined), &force)
            .expect("stable");
        let report = node
            .commit(&window(index, 40 * refined), &[])
            .expect("advanced");
        let term = |name| reported(&node, &report, name);
        let work = term("interface_work");
        let gone = term("strain") + term("kinetic") + term("numerical_loss");
        worst = worst.max((work - gone).abs() / work.abs());
    }
    let (mesh, layout) = (&node.model.mesh, node.model.body.layout);
    let place = |row: usize| {
        [0, 1].map(|k| mesh.point(2, row)[k] + node.state().u[layout.index([2, row], k)])
    };
    let length: f64 = (0..mesh.rows)
        .map(|row| (place(row), place(row + 1)))
        .map(|(a, b)| (a[0] - b[0]).hypot(a[1] - b[1]))
        .sum();
    let (head, below) = (place(0), place(1));
    let angle = (head[0] - below[0]).atan2(head[1] - below[1]);
    [length / 10e-3, angle, worst]
}

#[test]
fn a_column_in_large_rotation_keeps_its_length_and_every_joule() {
    for element in ["q4_1point", "q4_2x2"] {
        let run = |kinematics, refined| bent(&column(element, kinematics, refined), refined);
        let [length, angle, coarse] = run("corotational", 1);
        assert!(angle > 0.5, "{element}: {angle} rad is too little");
        assert!((length - 1.0).abs() < 1e-2, "{element}: {length}");
        let [_, _, fine] = run("corotational", 2);
        assert!(fine < 1e-6, "{element}: {fine:e}");
        let order = (coarse / fine).log2();
        assert!(
            (order - 2.0).abs() < 0.3,
            "{element}: order {order} of {coarse:e} {fine:e}"
        );
        let [longer, ..] = run("small", 1);
        assert!(longer > 1.1, "{element}: {longer} in small strain");
    }
}
