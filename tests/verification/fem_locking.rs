//! Problem: bodies whose elements lock. One is a nearly incompressible thick cylinder under an inner pressure. The others are slender
//! blocks, clamped below, that a shear traction on the upper edge bends.
//!
//! Exact: the cylinder's u(a) (Lame 1852), as in `fem_cylinder`. The beam's end moves by F L^3/(3 E' I) + 1.2 F L/(G A), E' = E/(1 - nu^2)
//! in plane strain (Timoshenko and Goodier, Theory of Elasticity, section 21).
//!
//! Tolerance: the error of 16 x 16 elements of the cylinder is 0.3 % (limit 1 %). The finding `locking` gives the error of a result. Its
//! value must be within a fifth of the true error in the cylinder, and within a quarter in bending, as the beam has no clamped end (2 %).

use fem_node::FemConfig;
use fem_node::StaticNode;
use kit::read_config;
use protocol::{Finding, Node};
use serde_json::{Value, json};

use crate::fem_bodies::{node, setting, window, with};
use crate::fem_cylinder::{INNER, OUTER, YOUNG, cylinder};

/// Equilibrium of a body: the displacement of its end or inner edge (m), and its finding `locking`.
fn equilibrium(config: Value) -> (f64, Option<Finding>) {
    let config = with(config, json!({"analysis": "static"}));
    let config: FemConfig = read_config(&config).expect("valid");
    let mut node = StaticNode::new(&config, &setting(1)).expect("it is held");
    let report = node.advance_alone(&window(0, 1)).expect("it is linear");
    let end = node.describe().signals.iter().position(|s| s == "end_ux_m");
    let outcome = node.finish().expect("it ends");
    let found = outcome.findings.into_iter().find(|f| f.code == "locking");
    let moved = end.map_or_else(|| -outcome.results["inner_outward_m"], |end| report[end]);
    (moved, found)
}

/// The ratio of the cylinder's u(a) to Lame's solution, and the finding `locking`.
fn widening(element: Option<&str>, nu: f64) -> (f64, Option<Finding>) {
    let pressure = 100e6;
    let (_file, mut config) = cylinder(16, nu, pressure);
    let keys = config.as_object_mut().expect("a table");
    keys.remove("element");
    if let Some(element) = element {
        keys.insert("element".into(), json!(element));
    }
    let (a2, b2) = (INNER * INNER, OUTER * OUTER);
    let lame = pressure * a2 / (b2 - a2);
    let exact = (1.0 + nu) / YOUNG * ((1.0 - 2.0 * nu) * lame * INNER + lame * b2 / INNER);
    let (moved, found) = equilibrium(config);
    (moved / exact, found)
}

#[test]
fn the_default_one_point_and_mean_dilatation_elements_do_not_lock() {
    for nu in [0.3, 0.4, 0.45, 0.499, 0.4999] {
        for element in [None, Some("q4_1point"), Some("q4_bbar")] {
            let (ratio, found) = widening(element, nu);
            assert!((ratio - 1.0).abs() < 0.01, "{element:?}, {nu}: {ratio}");
            assert_eq!(found, None, "{element:?}, {nu}");
        }
    }
}

#[test]
fn a_locking_element_is_reported_with_its_error() {
    for nu in [0.3, 0.45] {
        let (ratio, found) = widening(Some("q4_2x2"), nu);
        assert!((ratio - 1.0).abs() < 0.01 && found.is_none(), "{ratio}");
    }
    for (nu, suspect) in [(0.499, false), (0.4999, true)] {
        let (ratio, found) = widening(Some("q4_2x2"), nu);
        let found = found.expect("it locks");
        let off = 1.0 - ratio;
        assert!(off > 0.09, "{off}");
        assert!((found.value / off - 1.0).abs() < 0.2, "{off}: {found:?}");
        assert_eq!(found.suspect, suspect);
        assert!(found.text.contains("too stiff") && found.text.contains("q4_bbar"));
    }
}

/// The ratio of the end displacement to the beam's, for a block 1 mm wide with `across` square elements, and the finding `locking`.
fn bent(element: &str, across: usize, nu: f64) -> (f64, Option<Finding>) {
    let (width, length, young, thickness) = (1e-3_f64, 20e-3_f64, 100e9, 1e-3);
    let traction = 1e6;
    let (moved, found) = equilibrium(json!({
        "element": element, "base": "clamped",
        "mesh": {"width_m": width, "height_m": length, "size_m": width / across as f64},
        "material": {"young_pa": young, "poisson": nu, "density_kg_per_m3": 7800.0},
        "time": {"step_s": "auto", "damping": 0.75},
        "boundary": {"top": {"traction_pa": [traction, 0.0]}},
        "probes": [{"name": "end", "x_m": 0.0, "y_m": 0.0}],
    }));
    let force: f64 = traction * width * thickness;
    let stiffness = young / (1.0 - nu * nu) * thickness * width.powi(3) / 12.0;
    let shear = young / (2.0 * (1.0 + nu)) * width * thickness;
    let exact = force * length.powi(3) / (3.0 * stiffness) + 1.2 * force * length / shear;
    (moved / exact, found)
}

#[test]
fn the_error_of_a_slender_block_in_bending_is_reported() {
    for (element, nu, across) in [
        ("q4_1point", 0.3, 1),
        ("q4_1point", 0.3, 2),
        ("q4_1point", 0.49, 1),
        ("q4_2x2", 0.3, 1),
        ("q4_2x2", 0.3, 2),
        ("q4_2x2", 0.49, 8),
        ("q4_bbar", 0.3, 1),
        ("q4_bbar", 0.49, 2),
    ] {
        let (ratio, found) = bent(element, across, nu);
        let found = found.expect("a warning");
        let off = ratio - 1.0;
        assert!(off.abs() > 0.06, "{element}, {nu}, {across}: {ratio}");
        let share = found.value / off.abs();
        assert!(
            (share - 1.0).abs() < 0.25,
            "{element}, {nu}, {across}: {off}, {found:?}"
        );
        let word = if off < 0.0 { "too stiff" } else { "too soft" };
        assert!(found.text.contains(word), "{}", found.text);
    }
    for element in ["q4_1point", "q4_2x2", "q4_bbar"] {
        let (ratio, found) = bent(element, 8, 0.3);
        assert!(
            (ratio - 1.0).abs() < 0.02 && found.is_none(),
            "{element}: {ratio}"
        );
    }
}

/// A block in motion, with large rotations: the bending of a rotated element is measured along its own sides.
#[test]
fn bending_is_measured_in_motion_and_in_a_rotated_body() {
    let locking = |change: Value| {
        let base = json!({
            "element": "q4_2x2", "base": "clamped",
            "mesh": {"width_m": 1e-3, "height_m": 10e-3, "size_m": 0.5e-3},
            "material": {"young_pa": 1e9, "poisson": 0.3, "density_kg_per_m3": 7800.0},
            "time": {"step_s": "auto", "damping": 0.75, "mass_damping_per_s": 2e3},
            "boundary": {"top": {"traction_pa": [1e4, 0.0], "ramp_s": 1e-3}},
        });
        let mut body = node(&with(base, change));
        let steps = (5e-3 / body.model.scheme.step) as u32;
        body.advance_alone(&window(0, steps)).expect("stable");
        let findings = body.finish().expect("it ends").findings;
        findings.into_iter().find(|f| f.code == "locking")
    };
    let small = locking(json!({})).expect("two elements across");
    let far =
        json!({"kinematics": "corotational", "boundary": {"top": {"traction_pa": [5e5, 0.0]}}});
    let turned = locking(far).expect("two elements across");
    for found in [small, turned] {
        assert!((0.11..0.14).contains(&found.value), "{found:?}");
    }
    // A free body without a load shows no locking.
    assert_eq!(
        locking(json!({"base": "free", "boundary": {"top": {"traction_pa": [0.0, 0.0]}}})),
        None
    );
}
