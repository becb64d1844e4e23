//! The bodies of the cases.

use fem_node::{FemConfig, FemNode};
use kit::read_config;
use protocol::{Node, Setting, Window};
use serde_json::{Value, json};

/// The rail of the paper: 65 mm x 20 mm, crown 300 mm, E = 102.5 GPa, nu = 0.3, 7 800 kg/m3, clamped.
pub fn rail(mesh: Value) -> Value {
    let mut config = json!({
        "mesh": {"width_m": 65e-3, "height_m": 20e-3, "fine_width_m": 21.6e-3, "crown_radius_m": 0.3},
        "material": {"young_pa": 102.5e9, "poisson": 0.3, "density_kg_per_m3": 7800.0},
        "time": {"step_s": "auto", "damping": 0.75},
    });
    merge(&mut config["mesh"], mesh);
    config
}

/// The paper's mesh, d = 0.1 mm.
pub fn paper() -> Value {
    json!({"size_m": 1e-4, "fine_depth_m": 3e-3, "side_columns": 87, "depth_rows": 42})
}

/// The small mesh, d = 0.2 mm.
pub fn small() -> Value {
    json!({"size_m": 2e-4, "fine_depth_m": 2e-3, "side_columns": 40, "depth_rows": 20})
}

/// The quick mesh, d = 0.4 mm.
pub fn quick() -> Value {
    json!({"size_m": 4e-4, "fine_depth_m": 2e-3, "side_columns": 20, "depth_rows": 10})
}

/// A laterally confined strip on rollers, one-dimensional: E = 102.5 GPa, nu = 0.3, 7 800 kg/m3.
pub fn strip(width: f64, height: f64, size: f64) -> Value {
    json!({
        "base": "roller", "sides": "fixed_x",
        "mesh": {"width_m": width, "height_m": height, "size_m": size},
        "material": {"young_pa": 102.5e9, "poisson": 0.3, "density_kg_per_m3": 7800.0},
        "time": {"step_s": "auto", "damping": 0.5},
    })
}

/// Confined modulus M = lambda + 2 mu of the strip (Pa).
pub fn confined_modulus() -> f64 {
    102.5e9 * 0.7 / (1.3 * 0.4)
}

/// A crowned block of 12 x 6 elements, small enough for thousands of steps.
pub fn block() -> Value {
    json!({
        "mesh": {"width_m": 12e-3, "height_m": 7e-3, "size_m": 5e-4, "fine_width_m": 3e-3, "fine_depth_m": 1e-3,
                 "side_columns": 3, "depth_rows": 4, "crown_radius_m": 0.05},
        "material": {"young_pa": 102.5e9, "poisson": 0.3, "density_kg_per_m3": 7800.0},
        "time": {"step_s": "auto", "damping": 0.75},
    })
}

/// Overwrites the keys of `base` that `change` names, table by table.
pub fn merge(base: &mut Value, change: Value) {
    match (base, change) {
        (Value::Object(base), Value::Object(change)) => {
            for (key, value) in change {
                merge(base.entry(key).or_insert(Value::Null), value);
            }
        }
        (base, change) => *base = change,
    }
}

/// `base` with the keys of `change`.
pub fn with(mut base: Value, change: Value) -> Value {
    merge(&mut base, change);
    base
}

/// A setting as a coordinator gives it, with 1 mm of thickness.
pub fn setting(threads: usize) -> Setting {
    Setting {
        participant: "rail".into(),
        seed: 0,
        thickness_m: 1e-3,
        threads,
        fields: None,
        cache: None,
    }
}

/// A node on one thread.
pub fn node(config: &Value) -> FemNode {
    node_on(config, 1)
}

/// A node on several threads.
pub fn node_on(config: &Value, threads: usize) -> FemNode {
    let config: FemConfig = read_config(config).expect("the keys are valid");
    FemNode::new(&config, &setting(threads)).expect("the body is valid")
}

/// The same body with initial displacements (m) and velocities (m/s), given for each position; fixed components stay at rest.
pub fn set_in_motion(node: &FemNode, motion: impl Fn([f64; 2]) -> [[f64; 2]; 2]) -> FemNode {
    let (model, mut state) = (node.model.clone(), node.state().clone());
    let (mesh, body) = (&model.mesh, &model.body);
    for node in mesh.nodes() {
        // The right edge of a periodic body moves with the left one.
        let tied = mesh.tied_to(node);
        let [u, v] = motion(mesh.point(tied[0], tied[1]));
        for k in 0..2 {
            let [own, tied] = [node, tied].map(|node| body.layout.index(node, k));
            if body.inverse_mass[tied] > 0.0 {
                (state.u[own], state.v[own]) = (u[k], v[k]);
            }
        }
    }
    body.internal_force(&state.u, &mut state.force);
    FemNode::starting_from(model, state, &setting(1)).expect("its pool starts")
}

/// The window with this index.
pub fn window(index: u64, substeps: u32) -> Window {
    Window {
        index,
        substeps,
        ..Window::default()
    }
}

/// The value of a signal or ledger term in a report.
pub fn reported(node: &FemNode, report: &[f64], name: &str) -> f64 {
    let description = node.describe();
    let terms = description.ledger.iter().map(|term| &term.name);
    let position = description
        .signals
        .iter()
        .chain(terms)
        .position(|known| known == name);
    report[position.expect("the node describes it")]
}
