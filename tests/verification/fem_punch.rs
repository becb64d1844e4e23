//! Problem: a rough rigid punch presses on a perfectly plastic half-space in plane strain; one half is modelled.
//!
//! ```text
//!    punch  a    free
//!   |=======|-------------.
//!   |                     |   5 a x 3 a, held in x on both sides, clamped below
//!   |_____________________|
//! ```
//!
//! Exact: (2 + pi) k a of collapse load on a half-width a, k = Y/sqrt(3) (Prandtl 1920; Hill, The Mathematical Theory of
//! Plasticity, 1950, section IX.5).
//! Tolerance: elements at the punch's edge carry too much, an error of first order in their size. With q4_bbar it is 10.3 %
//! for four elements on a and 5.3 % for eight; the order must be between 0.8 and 1.1. A limit load rises by less than 0.3 % between
//! 0.036 and 0.04 a. `q4_2x2` locks and still rises by 1 %. `q4_1point` would be as stiff with its elastic hourglass
//! stiffness.

use fem_node::FemNode;
use protocol::Node;
use serde_json::json;

use crate::fem_bodies::{node, reported, window};
use crate::fem_msh::{Drawing, MshFile};

/// 5 m x 3 m of squares, with `fine` of them on the punch's half-width of 1 m.
fn block(fine: usize) -> Drawing {
    let (columns, rows) = (5 * fine, 3 * fine);
    let number = |i: usize, j: usize| j * (columns + 1) + i;
    let place = |k: usize| k as f64 / fine as f64;
    let mut drawing = Drawing::default();
    for (j, i) in (0..=rows).flat_map(|j| (0..=columns).map(move |i| (j, i))) {
        drawing.points.push([place(i), -place(j)]);
    }
    for (j, i) in (0..rows).flat_map(|j| (0..columns).map(move |i| (j, i))) {
        let corners = [[i, j + 1], [i + 1, j + 1], [i + 1, j], [i, j]];
        drawing.quads.push(corners.map(|[i, j]| number(i, j)));
    }
    let line = |count: usize, node: &dyn Fn(usize) -> usize| {
        (0..count).map(|k| [node(k), node(k + 1)]).collect()
    };
    drawing.lines = vec![
        ("punch", line(fine, &|k| number(k, 0))),
        ("bottom", line(columns, &|k| number(k, rows))),
        ("left", line(rows, &|k| number(0, k))),
        ("right", line(rows, &|k| number(columns, k))),
    ];
    drawing
}

/// Load over k a at punch displacements of 0.036 and 0.04 a.
fn loads(element: &str, fine: usize) -> [f64; 2] {
    let file = MshFile::new(&block(fine).msh2());
    let mut block: FemNode = node(&json!({
        "element": element, "sides": "fixed_x", "mesh": {"gmsh": file.0},
        "material": {"young_pa": 210e9, "poisson": 0.3, "density_kg_per_m3": 7800.0,
                     "yield_pa": 2e8 * 3f64.sqrt()},
        // A wave passes the block some 500 times. The punch sinks at 0.1 m/s, which adds a stress of rho c v = 4 MPa = 0.02 k.
        "time": {"step_s": "auto", "damping": 0.5, "mass_damping_per_s": 1000.0},
        "boundary": {"punch": {"displacement_m": [0.0, -0.04], "ramp_s": 0.4}},
    }));
    let step = block.model.scheme.step;
    [[0.0, 0.36], [0.36, 0.399]].map(|[from, until]| {
        let steps = ((until - from) / step) as u32;
        let report = block.advance_alone(&window(0, steps)).expect("stable");
        // The block is 1 mm thick.
        -reported(&block, &report, "punch_reaction_y_n") / (2e8 * 1e-3)
    })
}

#[test]
fn a_punch_reaches_its_limit_load_and_locks_with_full_integration() {
    let limit = 2.0 + std::f64::consts::PI;
    let [before, load] = loads("q4_bbar", 4);
    assert!(
        (load / limit - 1.103).abs() < 5e-3 && load < before * 1.003,
        "{before} {load}"
    );
    let [before, load] = loads("q4_1point", 4);
    assert!(
        (load / limit - 1.12).abs() < 5e-3 && load < before * 1.003,
        "{before} {load}"
    );
    let [before, load] = loads("q4_2x2", 4);
    assert!(
        load > 1.28 * limit && load > before * 1.008,
        "{before} {load}"
    );
}

#[test]
fn the_limit_load_approaches_prandtl_with_the_size() {
    let limit = 2.0 + std::f64::consts::PI;
    let [coarse, fine] = [4, 8].map(|fine| loads("q4_bbar", fine)[1] / limit - 1.0);
    let order = (coarse / fine).log2();
    assert!(
        fine > 0.0 && (0.8..1.1).contains(&order),
        "{coarse} {fine}, order {order}"
    );
}
