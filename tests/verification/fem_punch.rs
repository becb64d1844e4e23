//! Problem: a rough rigid punch is pressed into a perfectly plastic half-space in plane strain; one half of it.
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
//! Tolerance: at the edge of the punch elements carry too much, an error of first order in their size: with four
//! elements on a, 10.3 % with q4_bbar, which are 5.3 % with eight: order 1 within 0.2. A limit load is one that does not rise: between 0.036 and
//! 0.04 a by less than 0.3 %. `q4_2x2` locks: still 1 % there. The hourglass stiffness of `q4_1point` as it
//! is without flow made it as stiff.

use fem_node::FemNode;
use protocol::Node;
use serde_json::json;

use crate::fem_bodies::{node, reported, window};
use crate::fem_msh::{Drawing, MshFile};

/// 5 m x 3 m of squares, so many of them on the half-width of the punch, 1 m.
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

/// Load over k a at sinkings of 0.036 and 0.04 a.
fn loads(element: &str, fine: usize) -> [f64; 2] {
    let file = MshFile::new(&block(fine).msh2());
    let mut block: FemNode = node(&json!({
        "element": element, "sides": "fixed_x", "mesh": {"gmsh": file.0},
        "material": {"young_pa": 210e9, "poisson": 0.3, "density_kg_per_m3": 7800.0,
                     "yield_pa": 2e8 * 3f64.sqrt()},
        // Some 500 passages of a wave through the block: it sinks at 0.1 m/s, a stress of rho c v = 4 MPa = 0.02 k.
        "time": {"step_s": "auto", "damping": 0.5, "mass_damping_per_s": 1000.0},
        "boundary": {"punch": {"displacement_m": [0.0, -0.04], "ramp_s": 0.4}},
    }));
    let step = block.model.scheme.step;
    [[0.0, 0.36], [0.36, 0.399]].map(|[from, until]| {
        let steps = ((until - from) / step) as u32;
        let report = block.advance_alone(&window(0, steps)).expect("stable");
        // 1 mm thick.
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
fn the_limit_load_comes_nearer_to_prandtl_with_the_size() {
    let limit = 2.0 + std::f64::consts::PI;
    let [coarse, fine] = [4, 8].map(|fine| loads("q4_bbar", fine)[1] / limit - 1.0);
    let order = (coarse / fine).log2();
    assert!(
        fine > 0.0 && (0.8..1.1).contains(&order),
        "{coarse} {fine}, order {order}"
    );
}
