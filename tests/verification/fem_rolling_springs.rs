//! Problem: a rigid wheel that rolls on a half-plane through a layer of springs, by boundary elements ([`crate::line_contact`]).
//!
//! These elements are the exact answer for a wheel that rolls through a bonded layer (`scenarios/rolling/layer-as-springs`), so they have to be right
//! themselves.
//! Exact: rows of `reference/rolling_rigid.csv`, from boundary elements written separately, with 72 to 160 cells over 2.5 half-widths; Carter's
//! 1 - sqrt(1 - T/(mu N)) at nu = 0.5.
//! Tolerance: 0.006 of zeta R/(mu a), twice the differences stated there; with springs 0.03, as everywhere: 40 and 200 cells differ by 0.02. Carter's
//! curve 0.012, half a cell.

use crate::line_contact::LineContact;

const TABLE: &str = include_str!("reference/rolling_rigid.csv");

const CELLS: usize = 40;

#[test]
fn rows_of_the_reference_come_out() {
    let mut worst = [[0.0_f64; 3]; 2];
    let mut rows = 0;
    for line in TABLE.lines().filter(|line| !line.starts_with('#')).skip(1) {
        let cells = Vec::from_iter(line.split(',').map(|cell| cell.parse::<f64>().ok()));
        let given = |k: usize| cells[k].expect("a number");
        let wheel = LineContact {
            poisson: given(1),
            friction: given(2),
            compliance: [given(0), 0.0],
            traction: given(3),
            cells: CELLS,
        };
        let found = wheel.roll();
        let own = [found.creepage, found.peak, found.stick];
        for (k, (own, exact)) in own.into_iter().zip(&cells[4..7]).enumerate() {
            let worst = &mut worst[usize::from(given(0) > 0.0)][k];
            *worst = worst.max(exact.map_or(0.0, |exact| (own - exact).abs()));
        }
        rows += 1;
    }
    for ([creepage, peak, stick], most) in worst.into_iter().zip([0.006, 0.03]) {
        assert!(creepage < most && peak < 0.006 && stick < 0.04, "{worst:?}");
    }
    assert!(rows > 20, "{rows}");
}

#[test]
fn without_springs_on_an_incompressible_body_it_is_carters() {
    for traction in [0.36, 0.64, 0.96] {
        let wheel = LineContact {
            poisson: 0.5,
            friction: 1.0,
            compliance: [0.0; 2],
            traction,
            cells: CELLS,
        };
        let exact = 1.0 - f64::sqrt(1.0 - traction);
        let found = wheel.roll().creepage;
        assert!((found - exact).abs() < 0.012, "{found}, {exact}");
    }
}

/// Springs between the wheel and the body make the contact wider and softer. With lambda = 1 and springs across it of a third of that compliance, the
/// same elements written separately give 0.281 and 0.574 (nu = 0.4999).
#[test]
fn a_layer_that_yields_across_lowers_the_creepage() {
    for (traction, exact) in [(0.36, 0.281), (0.64, 0.574)] {
        let wheel = LineContact {
            poisson: 0.4999,
            friction: 0.3,
            compliance: [1.0, 0.33],
            traction,
            cells: CELLS,
        };
        let found = wheel.roll().creepage;
        assert!((found - exact).abs() < 0.006, "{found}, {exact}");
    }
}

/// The layer of `scenarios/rolling/layer-as-springs`, from whose creepage its `expected.toml` takes off what base and thickness change.
#[test]
fn the_shipped_layer_has_the_creepage_that_its_scene_expects() {
    let wheel = LineContact {
        poisson: 0.3,
        friction: 0.6,
        compliance: [1.052, 0.387],
        traction: 0.644,
        cells: CELLS,
    };
    let found = wheel.roll().creepage;
    let thickness = 0.3e-3 / (0.6 * 3.225e-3);
    let base = 0.32 * 3.225 / (0.6 * 80.0);
    let scene = 4e-3 * 0.46 / (0.6 * 3.225e-3);
    let expected = scene + base - thickness;
    assert!((found - expected).abs() < 0.006, "{found}, {expected}");
}
