//! Time per element and step: whole steps of the paper's mesh of 28 080 elements, as in a run, on one thread and on two.
//!
//! ```sh
//! cargo bench -p tests --bench fem
//! ```
//!
//! The time (ns) is 1000 over the `Mitem/s` of the fastest sample: other programs on the machine can only add time.

use divan::Bencher;
use divan::counter::ItemsCount;
use fem_kernel::integrate::state::NodalState;
use fem_node::model::Model;
use fem_node::node::fem_node::FemNode;
use protocol::{Node, Setting, Window};
use serde_json::json;

/// Steps of a sample; two in a build without optimisation, which is slow and whose times are meaningless.
const STEPS: u32 = if cfg!(debug_assertions) { 2 } else { 100 };

const CASES: [(&str, &str); 6] = [
    ("q4_1point", "elastic"),
    ("q4_1point", "j2"),
    ("q4_2x2", "elastic"),
    ("q4_2x2", "j2"),
    ("q4_bbar", "elastic"),
    ("q4_bbar", "j2"),
];

fn main() {
    divan::main();
}

#[divan::bench(args = CASES, consts = [1, 2], sample_count = 20, sample_size = 1)]
fn element_step<const THREADS: usize>(bencher: Bencher, (element, material): (&str, &str)) {
    let setting = Setting {
        participant: "bench".into(),
        seed: 0,
        thickness_m: 1e-3,
        threads: THREADS,
        fields: None,
        cache: None,
    };
    let model = model(element, material, &setting);
    let elements = model.mesh.elements() as u64;
    bencher
        .counter(ItemsCount::new(elements * u64::from(STEPS)))
        .with_inputs(|| {
            let mut body = stretched(&model, &setting);
            // The first window allocates the buffers.
            advance(&mut body, 0);
            let yields = body.state().history.iter().any(|value| *value != 0.0);
            assert_eq!(yields, material == "j2");
            body
        })
        .bench_local_refs(|body| advance(body, 1));
}

/// The paper's rail. A `j2` material yields in every step.
fn model(element: &str, kind: &str, setting: &Setting) -> Model {
    let mut material = json!({"young_pa": 102.5e9, "poisson": 0.3, "density_kg_per_m3": 7800.0});
    if kind == "j2" {
        material["yield_pa"] = json!(1e3);
        material["hardening_pa"] = json!(2e9);
    }
    let config = json!({
        "element": element, "material": material, "base": "free",
        "mesh": {
            "width_m": 65e-3, "height_m": 20e-3, "size_m": 1e-4, "fine_width_m": 21.6e-3, "fine_depth_m": 3e-3,
            "side_columns": 87, "depth_rows": 42, "crown_radius_m": 0.3,
        },
        "time": {"step_s": "auto", "damping": 0.75},
    });
    let config = kit::read_config(config).expect("the keys are valid");
    Model::new(&config, setting).expect("the body can be built")
}

/// A steadily stretched body, which keeps yielding.
fn stretched(model: &Model, setting: &Setting) -> FemNode {
    let mut state = NodalState::at_rest_under(&model.body, model.law.as_ref());
    for (node, point) in model.mesh.nodes().zip(&model.mesh.points) {
        state.v[model.body.layout.index(node, 0)] = 100.0 * point[0];
        state.v[model.body.layout.index(node, 1)] = -50.0 * point[1];
    }
    FemNode::starting_from(model.clone(), state, setting).expect("its threads start")
}

fn advance(body: &mut FemNode, index: u64) {
    let window = Window {
        index,
        substeps: STEPS,
        ..Window::default()
    };
    body.advance_alone(&window).expect("it is stable");
}
