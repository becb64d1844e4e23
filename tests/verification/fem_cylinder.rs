//! Problem: a quarter of a thick cylinder in plane strain under an inner pressure, with its mesh from a file.
//!
//! ```text
//!    left |\      outer     a = 100 mm, b = 200 mm
//!         | \
//!   inner |  |    symmetry: `left` held in x, `bottom` in y
//!    p -> )__|
//!           bottom
//! ```
//!
//! Exact, elastic (Lame 1852; Timoshenko and Goodier, Theory of Elasticity, section 28), A = p a^2/(b^2 - a^2):
//! sigma_rr = A (1 - b^2/r^2), sigma_tt = A (1 + b^2/r^2), u = (1+nu)/E ((1-2 nu) A r + A b^2/r).
//!
//! Exact, perfectly plastic (Hill, The Mathematical Theory of Plasticity, 1950, chapter V.2; de Souza Neto, Peric and Owen,
//! Computational Methods for Plasticity, 2008, section 7.5.1), c the radius of the plastic zone, Y' = 2 Y/sqrt(3):
//! p = Y' (ln(c/a) + (1 - c^2/b^2)/2), u(b) = Y' c^2 (1 - nu^2)/(E b). This is Tresca's solution with 2k = Y'. It is also von
//! Mises' solution where sigma_zz is the mean of the other two; at an elastic point it differs by (1 - 2 nu) A.
//!
//! Tolerance: elastic, errors fall with the square of the size (order within 0.1 of 2). Plastic, nu = 0.49: sigma_zz changes
//! the yield condition by ((1 - 2 nu) A/k)^2/3 < 1e-4. The elements' error equals a relative error e in the pressure, of the
//! order of (size/radius)^2 = (5/150)^2 = 1e-3. From dp/dc, the error in u(b) is then 2 e (ln(c/a) + (1 - c^2/b^2)/2)/(1 - c^2/b^2).
//! The tests require e < 1e-3, and four times the error on elements twice as large (3 to 5).

use std::f64::consts::FRAC_PI_2;

use fem_node::FemConfig;
use fem_node::StaticNode;
use fem_node::output::probe;
use kit::read_config;
use protocol::Node;
use serde_json::{Value, json};

use crate::fem_bodies::{node, setting, window, with};
use crate::fem_msh::{Drawing, MshFile};

pub const INNER: f64 = 0.1;
pub const OUTER: f64 = 0.2;
pub const YOUNG: f64 = 210e9;

/// `along` elements from the inner to the outer radius, and the same number around.
fn quarter(along: usize) -> Drawing {
    let number = |i: usize, j: usize| j * (along + 1) + i;
    let share = |k: usize| k as f64 / along as f64;
    let mut drawing = Drawing::default();
    for j in 0..=along {
        let (sin, cos) = (FRAC_PI_2 * share(j)).sin_cos();
        for i in 0..=along {
            let r = INNER + (OUTER - INNER) * share(i);
            // cos(pi/2) is not quite 0.
            drawing
                .points
                .push([if j == along { 0.0 } else { r * cos }, r * sin]);
        }
    }
    for (i, j) in (0..along).flat_map(|j| (0..along).map(move |i| (i, j))) {
        let corners = [[i, j], [i + 1, j], [i + 1, j + 1], [i, j + 1]];
        drawing.quads.push(corners.map(|[i, j]| number(i, j)));
    }
    let line = |node: &dyn Fn(usize) -> usize| (0..along).map(|k| [node(k), node(k + 1)]).collect();
    drawing.lines = vec![
        ("inner", line(&|k| number(0, k))),
        ("outer", line(&|k| number(along, k))),
        ("bottom", line(&|k| number(k, 0))),
        ("left", line(&|k| number(k, along))),
    ];
    drawing
}

pub fn cylinder(along: usize, poisson: f64, pressure: f64) -> (MshFile, Value) {
    let file = MshFile::new(&quarter(along).msh2());
    let config = json!({
        "element": "q4_2x2", "base": "roller", "sides": "fixed_x", "mesh": {"gmsh": file.0},
        "material": {"young_pa": YOUNG, "poisson": poisson, "density_kg_per_m3": 7850.0},
        "time": {"step_s": "auto", "damping": 0.75},
        "boundary": {"inner": {"pressure_pa": pressure}},
    });
    (file, config)
}

/// Relative errors of u(a) and u(b), and the largest stress error at a centroid over p.
fn lame_errors(along: usize) -> [f64; 3] {
    let (nu, p) = (0.3, 100e6);
    let (_file, config) = cylinder(along, nu, p);
    let config = with(config, json!({"analysis": "static"}));
    let config: FemConfig = read_config(&config).expect("valid");
    let mut node = StaticNode::new(&config, &setting(1)).expect("it is held");
    node.advance_alone(&window(0, 1)).expect("it is linear");
    let a2 = p * INNER * INNER / (OUTER * OUTER - INNER * INNER);
    let b2 = OUTER * OUTER;
    let u = |r: f64| (1.0 + nu) / YOUNG * ((1.0 - 2.0 * nu) * a2 * r + a2 * b2 / r);
    let results = node.finish().expect("it ends").results;
    let state = &node.held.as_ref().expect("one increment").state;
    let mut worst: f64 = 0.0;
    for [i, j] in node.model.mesh.element_indices() {
        let mesh = &node.model.mesh;
        let corners = mesh.corners(i, j).map(|n| mesh.point(n[0], n[1]));
        let [x, y] = [0, 1].map(|k| 0.25 * corners.iter().map(|p| p[k]).sum::<f64>());
        let (r2, [xx, yy, xy]) = (
            x * x + y * y,
            probe::stress(&node.model, state, [i, j], [0.0, 0.0]),
        );
        let rr = (x * x * xx + y * y * yy + 2.0 * x * y * xy) / r2;
        let (exact_rr, exact_tt) = (a2 * (1.0 - b2 / r2), a2 * (1.0 + b2 / r2));
        worst = worst
            .max((rr - exact_rr).abs())
            .max((xx + yy - rr - exact_tt).abs());
    }
    [
        (-results["inner_outward_m"] / u(INNER) - 1.0).abs(),
        (results["outer_outward_m"] / u(OUTER) - 1.0).abs(),
        worst / p,
    ]
}

#[test]
fn an_elastic_cylinder_approaches_lame_with_the_square_of_the_size() {
    let (coarse, fine) = (lame_errors(8), lame_errors(16));
    for (what, (coarse, fine)) in ["u(a)", "u(b)", "stress"]
        .iter()
        .zip(coarse.iter().zip(fine))
    {
        let order = (coarse / fine).log2();
        assert!(
            (order - 2.0).abs() < 0.1,
            "{what}: {coarse:e} {fine:e}, order {order}"
        );
    }
    assert!(fine.iter().all(|error| *error < 5e-3), "{fine:?}");
}

/// The ratio of u(b) to Hill's solution at a plastic zone of this radius, and the share of elements that yield.
fn hill_ratio(along: usize, front: f64) -> (f64, f64) {
    let (nu, yield_pa) = (0.49, 240e6);
    let k2 = 2.0 * yield_pa / 3.0f64.sqrt();
    let pressure = k2 * ((front / INNER).ln() + 0.5 * (1.0 - (front / OUTER).powi(2)));
    let (_file, config) = cylinder(along, nu, pressure);
    let period = 2.0 * std::f64::consts::PI * OUTER / (YOUNG / 7850.0).sqrt();
    let config = with(
        config,
        json!({
            "element": "q4_bbar", "material": {"yield_pa": yield_pa},
            "time": {"mass_damping_per_s": 12.0 / period},
            "boundary": {"inner": {"ramp_s": 10.0 * period}},
        }),
    );
    let mut node = node(&config);
    let steps = (16.0 * period / node.model.scheme.step) as u32;
    node.advance_alone(&window(0, steps)).expect("stable");
    let results = node.finish().expect("it ends").results;
    let exact = k2 * front * front * (1.0 - nu * nu) / (YOUNG * OUTER);
    let (model, state) = (&node.model, node.state());
    let strain = |place| model.body.plastic_strain(&state.history, place, [0.0, 0.0])[3];
    let plastic = model
        .mesh
        .element_indices()
        .filter(|place| strain(*place) > 0.0)
        .count();
    (
        results["outer_outward_m"] / exact,
        plastic as f64 / model.mesh.elements() as f64,
    )
}

/// The relative error in the pressure that would have the same effect on u(b) as the elements.
fn pressure_error(ratio: f64, front: f64) -> f64 {
    let square = (front / OUTER).powi(2);
    let reserve = (1.0 - square) / ((front / INNER).ln() + 0.5 * (1.0 - square));
    0.5 * (ratio - 1.0) * reserve
}

#[test]
fn a_perfectly_plastic_cylinder_follows_hill() {
    for front in [0.12, 0.15, 0.18] {
        let (ratio, plastic) = hill_ratio(20, front);
        let error = pressure_error(ratio, front);
        assert!(error.abs() < 1e-3, "c = {front}: {ratio}, {error:e}");
        // Whole rows of elements yield, so the front is within one row.
        let exact = (front - INNER) / (OUTER - INNER);
        let off = (plastic - exact).abs();
        assert!(off <= 0.05 + 1e-9, "c = {front}: {plastic}");
    }
}

#[test]
fn smaller_elements_approach_hill() {
    let [coarse, fine] = [10, 20].map(|along| hill_ratio(along, 0.15).0 - 1.0);
    let gain = coarse / fine;
    assert!((3.0..5.0).contains(&gain), "{coarse:e} {fine:e}");
}
