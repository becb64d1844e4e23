//! Time of whole steps on the paper's mesh, beside the bound that the same machine sets in the same run.
//!
//! The bound is the longer of two times: that of moving the numbers which a step must read and write, at the rate of a
//! plain sum over arrays of the same total size, and that of its additions and multiplications, counted in the sources,
//! at the rate of a loop that does nothing else. The quietest of several passes counts, here as there: what else runs
//! on the machine only ever adds time.

use fem_kernel::integrate::fields::StepFields;
use fem_kernel::integrate::integrator::Integrator;
use fem_kernel::rates::{operation_rate, quietest, read_rate};
use kit::{ConfigError, read_config};
use protocol::Setting;
use serde::Serialize;
use serde_json::json;

use crate::config::keys::FemConfig;
use crate::error::FemError;
use crate::model::Model;

/// Steps in a pass, some 0.02 s of work.
const STEPS: usize = 40;

/// One measurement.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ElementBenchRow {
    /// As in the key `element`.
    pub element: &'static str,
    /// As in the key `material.kind`; every point of `j2` yields in every step.
    pub material: &'static str,
    /// Threads.
    pub threads: usize,
    /// Elements of the mesh.
    pub elements: usize,
    /// Time of a whole step over the number of elements (ns).
    pub ns_per_element_step: f64,
    /// Time that memory and arithmetic alone would take (ns).
    pub bound_ns: f64,
}

/// Element and material of a case, and its work in an element: constants, history variables, operations.
type Case = (&'static str, &'static str, [f64; 3]);

const CASES: [Case; 6] = [
    ("q4_1point", "elastic", [8.0, 0.0, 79.0]),
    ("q4_1point", "j2", [8.0, 8.0, 160.0]),
    ("q4_2x2", "elastic", [10.0, 0.0, 220.0]),
    ("q4_2x2", "j2", [10.0, 16.0, 520.0]),
    ("q4_bbar", "elastic", [11.0, 0.0, 240.0]),
    ("q4_bbar", "j2", [11.0, 16.0, 540.0]),
];

/// Operations of the update of a node: both components of prediction, acceleration, numerical loss and correction.
const NODE_OPERATIONS: f64 = 58.0;

/// Numbers of a node that a step reads or writes: u v a F in and out, m and 1/m in, two components each.
const NODE_NUMBERS: f64 = 20.0;

/// Measures every element and material at 28 080 elements, on one thread and on two.
pub fn bench() -> Result<Vec<ElementBenchRow>, FemError> {
    let paper = json!({
        "width_m": 65e-3, "height_m": 20e-3, "size_m": 1e-4, "fine_width_m": 21.6e-3, "fine_depth_m": 3e-3,
        "side_columns": 87, "depth_rows": 42, "crown_radius_m": 0.3,
    });
    let mut rows = Vec::new();
    for case in &CASES {
        let model = model(case, &paper)?;
        for threads in [1, 2] {
            rows.push(measure(case, &model, threads)?);
        }
    }
    Ok(rows)
}

fn model((element, kind, _): &Case, mesh: &serde_json::Value) -> Result<Model, ConfigError> {
    let mut material = json!({"young_pa": 102.5e9, "poisson": 0.3, "density_kg_per_m3": 7800.0});
    if *kind == "j2" {
        material["yield_pa"] = json!(1e3);
        material["hardening_pa"] = json!(2e9);
    }
    let config: FemConfig = read_config(json!({
        "element": element, "mesh": mesh, "material": material, "base": "free",
        "time": {"step_s": "auto", "damping": 0.75},
    }))?;
    let setting = Setting {
        participant: "bench".into(),
        seed: 0,
        thickness_m: 1e-3,
        threads: 1,
        fields: None,
        cache: None,
    };
    Model::new(&config, &setting)
}

fn measure(case: &Case, model: &Model, threads: usize) -> Result<ElementBenchRow, FemError> {
    let (element, material, [constants, history, operations]) = *case;
    let pool = FemError::pool(threads)?;
    let elements = model.mesh.elements();
    let nodes = model.mesh.points.len() as f64 / elements as f64;
    let numbers = constants + 2.0 * history + NODE_NUMBERS * nodes;
    let operations = operations + NODE_OPERATIONS * nodes;
    let memory = 8.0 * numbers / read_rate(&pool, threads, numbers * elements as f64);
    let arithmetic = operations / operation_rate(&pool, threads);
    Ok(ElementBenchRow {
        element,
        material,
        threads,
        elements,
        ns_per_element_step: 1e9 * pool.install(|| step_time(model, threads)) / elements as f64,
        bound_ns: 1e9 * memory.max(arithmetic),
    })
}

/// Time of a step (s) of a body that is stretched steadily, so that it keeps yielding.
fn step_time(model: &Model, threads: usize) -> f64 {
    let body = &model.body;
    let mut integrator = Integrator::new(body, model.scheme, model.law, threads);
    let mut fields = StepFields::at_rest(body, model.law.as_ref(), model.dissipates());
    let v = &mut fields.state.v;
    for (node, point) in model.mesh.nodes().zip(&model.mesh.points) {
        v[body.layout.index(node, 0)] = 100.0 * point[0];
        v[body.layout.index(node, 1)] = -50.0 * point[1];
    }
    let rows = [0, body.layout.node_rows];
    quietest(|| {
        for _ in 0..STEPS {
            integrator.step(body, &mut fields, rows, None);
        }
        STEPS as f64
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_case_runs_and_every_plastic_one_yields() {
        for case in &CASES {
            let mesh = json!({"width_m": 4e-3, "height_m": 2e-3, "size_m": 1e-3});
            let model = model(case, &mesh).expect("the keys are valid");
            let row = measure(case, &model, 1).expect("a pool of one thread");
            assert!(
                row.ns_per_element_step > 0.0 && row.bound_ns > 0.0,
                "{row:?}"
            );
            assert_eq!(model.plastic().is_some(), case.1 == "j2");
        }
    }
}
