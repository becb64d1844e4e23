//! Problem: a crowned block under its wheel, once generated from a few numbers and once from a mesh file. The file has the nodes
//! and elements in another order, and a third of the elements clockwise.
//! Exact: the same displacements, forces and energies; only the order of sums differs.
//! Source: the numbering of nodes and elements does not change a mesh.
//! Tolerance: 1e-12 of the largest displacement in statics (rounding of a sparse solve of some 200 equations, whose
//! condition of 1e4 multiplies 1e-16); 1e-11 after 600 explicit steps, whose rounding accumulates.

use fem_node::config::mesh::MeshSource;
use fem_node::mesh::graded;
use fem_node::{FemConfig, FemNode, StaticNode};
use kit::read_config;
use protocol::Node;
use serde_json::{Value, json};

use crate::fem_bodies::{block, node, node_on, setting, window, with};
use crate::fem_msh::{Drawing, MshFile};

/// The body of `config` from a file of each version.
fn written(config: &Value) -> [(MshFile, Value); 2] {
    let read: FemConfig = read_config(config).expect("the keys are valid");
    let MeshSource::Graded(numbers) = read.mesh else {
        panic!("it is a block");
    };
    let drawing = Drawing::of_block(&graded::build(&numbers).expect("a valid block"));
    [drawing.msh2(), drawing.msh4()].map(|text| {
        let file = MshFile::new(&text);
        let mut config = config.clone();
        config["mesh"] = json!({"gmsh": file.0});
        (file, config)
    })
}

/// Displacements by place, in the order of the block's nodes.
fn displacements(model: &fem_node::model::Model, u: &[f64], order: &[[f64; 2]]) -> Vec<f64> {
    let mesh = &model.mesh;
    let number = |p: &[f64; 2]| mesh.points.iter().position(|q| q == p);
    let nodes: Vec<[usize; 2]> = mesh.nodes().collect();
    let nodes = order
        .iter()
        .map(|p| nodes[number(p).expect("the node is there")]);
    nodes
        .flat_map(|node| [0, 1].map(|k| u[model.body.layout.index(node, k)]))
        .collect()
}

fn assert_close(ours: &[f64], exact: &[f64], tolerance: f64, what: &str) {
    let scale = exact.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
    assert!(scale > 0.0, "{what}: nothing moved");
    let pairs = ours.iter().zip(exact);
    let error = pairs.fold(0.0, |m: f64, (a, b)| m.max((a - b).abs()));
    assert!(error <= tolerance * scale, "{what}: {:e}", error / scale);
}

/// Displacements and reports after `steps` steps.
fn marched(
    config: &Value,
    steps: u32,
    order: Option<&[[f64; 2]]>,
) -> (Vec<f64>, Vec<f64>, FemNode) {
    let mut node = node(config);
    let report = node.advance_alone(&window(0, steps)).expect("stable");
    let own: Vec<[f64; 2]> = node.model.mesh.points.to_vec();
    let u = displacements(&node.model, &node.state().u, order.unwrap_or(&own));
    (u, report, node)
}

/// Description of a body as a coordinator receives it, with the stability limit, an iteration's result, to six digits. The warnings
/// are left out: only a block has keys to name for sizes that grow fast.
fn described(node: &FemNode) -> String {
    let mut description = node.describe();
    let limit = description.step_limit_s.take().expect("it is explicit");
    description.sets.sort();
    description.warnings.clear();
    format!("{description:?} {limit:.5e}")
}

fn wheel(radius: f64) -> Value {
    json!({
        "wheel": {"load_n": 400.0, "mass_kg": 0.001, "radius_m": radius, "amplitude_m": 1e-5, "frequency_hz": 3e4,
                  "ramp_s": 5e-6, "hold_s": 5e-6, "cycles": 1.0},
        "contact": {"friction": 0.3},
        "time": {"step_s": 2e-8, "damping": 0.75, "mass_damping_per_s": 1e4},
    })
}

#[test]
fn a_body_in_motion_under_its_wheel_is_the_same_from_a_file() {
    for (element, change) in [
        ("q4_1point", wheel(0.0)),
        ("q4_2x2", wheel(0.2)),
        ("q4_bbar", wheel(0.0)),
        (
            "q4_1point",
            with(
                wheel(0.0),
                json!({"material": {"yield_pa": 1e8, "hardening_pa": 2e9}}),
            ),
        ),
        (
            "q4_2x2",
            with(
                wheel(0.0),
                json!({"material": {"yield_pa": 1e8, "hardening_pa": 2e9}}),
            ),
        ),
        (
            "q4_bbar",
            with(
                wheel(0.0),
                json!({"material": {"yield_pa": 1e8, "hardening_pa": 2e9}}),
            ),
        ),
        (
            "q4_1point",
            with(wheel(0.0), json!({"kinematics": "corotational"})),
        ),
        (
            "q4_2x2",
            with(wheel(0.0), json!({"time": {"stiffness_damping_s": 1e-8}})),
        ),
    ] {
        let config = with(with(block(), change), json!({"element": element}));
        let (u, report, block) = marched(&config, 600, None);
        let plastic = block.ledger().plastic;
        assert_eq!(plastic > 0.0, block.model.plastic().is_some(), "{element}");
        let order = block.model.mesh.points.to_vec();
        for (_file, config) in written(&config) {
            let (v, again, other) = marched(&config, 600, Some(&order));
            let what = format!("{element}, plastic work {plastic:e} J");
            assert_close(&v, &u, 1e-11, &what);
            assert_eq!(described(&other), described(&block));
            assert_close(&again, &report, 1e-11, &what);
            let [a, b] = [&block, &other].map(|node| node.ledger().strain);
            assert!((a - b).abs() <= 1e-11 * a, "{what}: {a:e} {b:e}");
        }
    }
}

#[test]
fn the_equilibrium_under_the_wheel_is_the_same_from_a_file() {
    let change =
        json!({"analysis": "static", "statics": {"increment_n": 20.0}, "element": "q4_2x2"});
    let config = with(with(block(), wheel(0.0)), change);
    let held = |config: &Value| {
        let read: FemConfig = read_config(config).expect("valid");
        let mut node = StaticNode::new(&read, &setting(1)).expect("held");
        node.advance_alone(&window(0, 20)).expect("it converges");
        node
    };
    let block = held(&config);
    let order = block.model.mesh.points.to_vec();
    let exact = block.held.as_ref().expect("loaded");
    let u = displacements(&block.model, &exact.state.u, &order);
    let exact = exact.contact.as_ref().expect("a wheel");
    for (_file, config) in written(&config) {
        let node = held(&config);
        let ours = node.held.as_ref().expect("loaded");
        let v = displacements(&node.model, &ours.state.u, &order);
        assert_close(&v, &u, 1e-12, "displacements");
        let ours = ours.contact.as_ref().expect("a wheel");
        assert_close(&ours.normal, &exact.normal, 1e-11, "normal forces");
        assert_close(&ours.tangential, &exact.tangential, 1e-11, "friction");
        assert_eq!(ours.status, exact.status);
    }
}

#[test]
fn threads_do_not_change_a_bit_of_a_body_from_a_file() {
    let mesh = json!({"width_m": 24e-3, "height_m": 12e-3, "size_m": 2e-4});
    let config = with(block(), wheel(0.0));
    let config = with(
        config,
        json!({"material": {"yield_pa": 1e8}, "element": "q4_2x2"}),
    );
    let mut config = with(config, json!({"time": {"step_s": 1e-8}}));
    config["mesh"] = mesh;
    let [(_file, config), _] = written(&config);
    let state = |threads: usize| {
        let mut node = node_on(&config, threads);
        let report = node.advance_alone(&window(0, 60)).expect("stable");
        (report, node.state().clone())
    };
    let one = state(1);
    assert!(one.0.iter().any(|value| *value != 0.0));
    for threads in [2, 3] {
        assert_eq!(state(threads), one, "{threads} threads");
    }
}

#[test]
fn a_repeated_window_gives_the_same_bits() {
    let config = with(block(), wheel(0.0));
    let config = with(config, json!({"material": {"yield_pa": 1e8}}));
    let [(_file, mut config), _] = written(&config);
    for key in ["wheel", "contact"] {
        config.as_object_mut().expect("a table").remove(key);
    }
    let mut node = node(&config);
    let surface = node.couple("top").expect("an open line");
    let force: Vec<f64> = surface
        .x_m
        .iter()
        .flat_map(|x| [50.0 * x.signum(), -400.0])
        .collect();
    let first = node.advance(&window(0, 50), &force).expect("stable");
    let half: Vec<f64> = force.iter().map(|f| 0.5 * f).collect();
    node.advance(&window(0, 50), &half).expect("stable");
    let again = node.advance(&window(0, 50), &force).expect("stable");
    assert_eq!(first, again);
    node.commit(&window(0, 50), &[]).expect("it was advanced");
    assert!(node.ledger().plastic > 0.0);
}
