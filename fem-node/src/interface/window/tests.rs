//! A repeat of a window within the region that a changed force can reach, compared with a repeat of the whole body.

use kit::read_config;
use protocol::{Node, Setting, Window};
use serde_json::{Value, json};

mod flight;

use crate::FemNode;

/// Steps in a window.
const SUBSTEPS: u32 = 6;

/// Windows of a run.
const WINDOWS: u64 = 8;

/// A body 10 mm wide and 4 mm high with these additional keys, coupled at these sets.
fn body(keys: &Value, sets: &[&str]) -> FemNode {
    body_on(1, keys, sets)
}

/// The same body on several threads.
fn body_on(threads: usize, keys: &Value, sets: &[&str]) -> FemNode {
    let mut config = json!({
        "mesh": {"width_m": 1e-2, "height_m": 4e-3, "size_m": 0.2e-3}, "base": "clamped",
        "material": {"young_pa": 102.5e9, "poisson": 0.3, "density_kg_per_m3": 7800.0},
        "time": {"step_s": "auto", "damping": 0.75},
    });
    let keys = keys.as_object().expect("keys");
    for (key, value) in keys {
        config[key] = value.clone();
    }
    let setting = Setting {
        participant: "body".into(),
        seed: 0,
        thickness_m: 1e-3,
        threads,
        fields: None,
        cache: None,
    };
    let config = read_config(&config).expect("the keys are valid");
    let mut node = FemNode::new(&config, &setting).expect("the body is valid");
    let mut points = 0..0;
    for set in sets {
        let count = node.couple(set).expect("the set can be coupled").len();
        // A few points in the middle of each set.
        let first = points.end;
        points = first..first + count;
    }
    let middle = |count: usize| count * 2 / 5..count * 3 / 5;
    let of_set = points.len();
    let chosen: Vec<usize> = (0..sets.len())
        .flat_map(|set| middle(of_set).map(move |point| set * of_set + point))
        .collect();
    node.select(&chosen).expect("the points exist");
    node
}

/// A force on every exchanged component (N), different in each window and repeat.
fn force(node: &FemNode, window: u64, repeat: u64) -> Vec<f64> {
    let wave = |k: usize| ((7 * window + 3 * repeat + 1) as f64 * (0.37 * k as f64 + 1.0)).sin();
    (0..node.interface.components.len())
        .map(|k| 40.0 * wave(k))
        .collect()
}

/// All reports of a run of coupled windows with repeats and a halved window, the hash of its state, and the number of repeats of a part.
fn life(
    mut node: FemNode,
    whole: bool,
    mut resume: Option<FemNode>,
) -> (Vec<Vec<f64>>, String, usize) {
    let (mut reports, mut parts, mut step) = (Vec::new(), 0, 0);
    for index in 0..WINDOWS {
        let substeps = if index == 3 { SUBSTEPS / 2 } else { SUBSTEPS };
        let window = |iteration: u32, substeps: u32| Window {
            index,
            iteration,
            step,
            substeps,
            ..Window::default()
        };
        if index == 3 {
            // The halved window was first tried whole.
            let force = force(&node, index, 9);
            reports.push(
                node.advance(&window(0, SUBSTEPS), &force)
                    .expect("it moves"),
            );
        }
        for repeat in 0..=index % 4 {
            if whole {
                node.run.forget();
            }
            let force = force(&node, index, repeat);
            let again = window(repeat as u32, substeps);
            parts += usize::from(!whole && node.run.repeats_a_part());
            reports.push(node.advance(&again, &force).expect("it moves"));
        }
        reports.push(
            node.commit(&window(0, substeps), &[])
                .expect("it is accepted"),
        );
        step += u64::from(substeps);
        if let Some(mut other) = resume.take_if(|_| index == WINDOWS / 2) {
            let state = node.checkpoint().expect("it is packed");
            other.restore(&state).expect("it is this body's");
            node = other;
        }
    }
    (reports, node.state_hash(), parts)
}

fn bits(reports: &[Vec<f64>]) -> Vec<Vec<u64>> {
    let bits = |numbers: &Vec<f64>| numbers.iter().map(|x| x.to_bits()).collect();
    reports.iter().map(bits).collect()
}

/// Expects the bits of the whole, with at least this many repeats of a part.
fn repeats_like_the_whole(keys: &Value, sets: &[&str], at_least: usize) {
    let (whole, hash, _) = life(body(keys, sets), true, None);
    let (part, part_hash, parts) = life(body(keys, sets), false, None);
    assert!(parts >= at_least, "{parts} repeats of a part: {keys}");
    assert_eq!(bits(&part), bits(&whole), "{keys}");
    assert_eq!(part_hash, hash, "{keys}");
    let (resumed, resumed_hash, _) = life(body(keys, sets), false, Some(body(keys, sets)));
    assert_eq!(bits(&resumed), bits(&whole), "resumed: {keys}");
    assert_eq!(resumed_hash, hash);
}

// The tests are compiled in tests/unit.
const GMSH: &str = concat!(
    env!("CARGO_MANIFEST_DIR"),
    "/../../scenarios/verification/pressurised-cylinder/cylinder.msh"
);

#[test]
fn a_repeat_of_a_part_has_the_bits_of_a_repeat_of_the_whole() {
    let top = &["top"][..];
    let j2 = |element: &str| {
        json!({"element": element, "material": {
            "young_pa": 102.5e9, "poisson": 0.3, "density_kg_per_m3": 7800.0,
            "yield_pa": 1e5, "hardening_pa": 2e9}})
    };
    let mesh = |more: Value| {
        let mut mesh = json!({"width_m": 1e-2, "height_m": 4e-3, "size_m": 0.2e-3});
        for (key, value) in more.as_object().expect("keys") {
            mesh[key] = value.clone();
        }
        json!({"mesh": mesh})
    };
    let time = |more: Value| {
        let mut time = json!({"step_s": "auto", "damping": 0.5});
        for (key, value) in more.as_object().expect("keys") {
            time[key] = value.clone();
        }
        json!({"time": time})
    };
    repeats_like_the_whole(&json!({}), top, 7);
    repeats_like_the_whole(&json!({"element": "q4_2x2"}), top, 7);
    repeats_like_the_whole(&json!({"element": "q4_bbar"}), top, 7);
    repeats_like_the_whole(&json!({"kinematics": "corotational"}), top, 7);
    repeats_like_the_whole(&j2("q4_1point"), top, 7);
    repeats_like_the_whole(&j2("q4_2x2"), top, 7);
    repeats_like_the_whole(&j2("q4_bbar"), top, 7);
    repeats_like_the_whole(&time(json!({"stiffness_damping_s": 1e-8})), top, 7);
    repeats_like_the_whole(&time(json!({"mass_damping_per_s": 1e4})), top, 7);
    repeats_like_the_whole(&mesh(json!({"periodic_x": true})), top, 7);
    repeats_like_the_whole(&json!({"base": "free"}), &["top", "bottom"], 7);
    repeats_like_the_whole(&json!({"base": "free"}), &["left"], 7);
}

/// For the laws and schemes that pieces support.
#[test]
fn pieces_have_the_bits_of_the_whole() {
    let wide = json!({"width_m": 4e-2, "height_m": 6e-3, "size_m": 0.2e-3});
    for more in [
        json!({}),
        json!({"element": "q4_2x2", "base": "free"}),
        json!({"probes": [{"name": "inside", "x_m": 1.3e-3, "y_m": -2.1e-3}]}),
        json!({"kinematics": "corotational"}),
        json!({"time": {"step_s": "auto", "damping": 0.6, "stiffness_damping_s": 1e-8,
            "mass_damping_per_s": 1e4}}),
    ] {
        let mut keys = more.clone();
        keys["mesh"] = wide.clone();
        let (whole, hash, _) = life(body(&keys, &["top"]), true, None);
        for threads in [2, 3] {
            let node = || body_on(threads, &keys, &["top"]);
            let mut pieces = node();
            pieces.run.partition.cut(&pieces.model, SUBSTEPS, threads);
            let (reports, its_hash, parts) = life(pieces, false, Some(node()));
            assert!(parts > 6, "{parts} repeats of a part: {keys}");
            assert_eq!(bits(&reports), bits(&whole), "{threads} threads: {keys}");
            assert_eq!(its_hash, hash, "{threads} threads: {keys}");
        }
    }
}

/// Windows with a prescribed velocity run whole, and so does a window of more steps than the pieces were cut for.
#[test]
fn the_state_leaves_the_pieces_for_a_window_without_pieces() {
    let keys = json!({"mesh": {"width_m": 4e-2, "height_m": 6e-3, "size_m": 0.2e-3}});
    let run = |mut node: FemNode| {
        let (mut reports, mut step) = (Vec::new(), 0);
        for (index, substeps) in (0..).zip([6, 6, 6, 30, 6, 5, 6]) {
            let window = Window {
                index,
                step,
                substeps,
                ..Window::default()
            };
            let given = force(&node, index, 0);
            if index == 1 || index == 4 {
                let velocity: Vec<f64> = given.iter().map(|force| 1e-3 * force).collect();
                let reaction = node.prescribe_velocity(&window, &velocity);
                reports.push(reaction.expect("it moves").force);
            } else {
                reports.push(node.advance(&window, &given).expect("it moves"));
            }
            reports.push(node.commit(&window, &[]).expect("it is accepted"));
            reports.push(node.state().v.to_vec());
            step += u64::from(substeps);
        }
        (bits(&reports), node.state_hash())
    };
    let mut pieces = body_on(2, &keys, &["top"]);
    pieces.run.partition.cut(&pieces.model, SUBSTEPS, 2);
    let held = |node: &FemNode| node.run.partition.held().is_some();
    let window = Window {
        substeps: SUBSTEPS,
        ..Window::default()
    };
    let given = force(&pieces, 0, 1);
    pieces.advance(&window, &given).expect("it moves");
    assert!(held(&pieces));
    assert_eq!(run(pieces), run(body(&keys, &["top"])));
}

#[test]
fn tractions_and_drives_inside_the_region_do_the_same_work() {
    let boundary = json!({"boundary": {
        "top": {"traction_pa": [1e6, -2e6], "ramp_s": 1e-6},
        "left": {"velocity_m_per_s": [0.5, "free"]}}});
    repeats_like_the_whole(&boundary, &["top"], 7);
}

#[test]
fn forces_over_time_inside_the_region_do_the_same_work() {
    let boundary = json!({"boundary": {
        "top": {"load_table": [[0.0, 2.0], [6e-7, 50.0], [1.1e-6, -20.0]], "load_direction": [1.0, -2.0]},
        "left": {"velocity_m_per_s": [0.5, "free"], "load_table": [[0.0, 0.0], [2e-6, 30.0]]}}});
    repeats_like_the_whole(&boundary, &["top"], 7);
}

#[test]
fn a_repeat_of_a_part_has_the_bits_of_the_whole_on_an_unstructured_mesh() {
    let mut keys = json!({"mesh": {"gmsh": GMSH, "length_unit_m": 1e-3}, "base": "free"});
    let node = body(&keys, &[]);
    let sets: Vec<String> = node.describe().sets;
    let set = [sets.first().expect("the mesh has a line").as_str()];
    // Under a law with history a front takes whole rows of elements, and soon all of such a small mesh.
    let plastic = json!({"yield_pa": 1e5, "hardening_pa": 2e9});
    for (law, at_least) in [(json!({}), 7), (plastic, 3)] {
        let mut material =
            json!({"young_pa": 102.5e9, "poisson": 0.3, "density_kg_per_m3": 7800.0});
        for (key, value) in law.as_object().expect("keys") {
            material[key] = value.clone();
        }
        keys["material"] = material;
        repeats_like_the_whole(&keys, &set, at_least);
    }
}

#[test]
fn a_window_that_is_never_repeated_records_nothing_after_a_while() {
    let mut node = body(&json!({}), &["top"]);
    let mut recorded = Vec::new();
    for index in 0..8 {
        let window = Window {
            index,
            substeps: SUBSTEPS,
            ..Window::default()
        };
        let force = force(&node, index, 0);
        node.advance(&window, &force).expect("it moves");
        recorded.push(node.run.repeats_a_part());
        node.commit(&window, &[]).expect("it is accepted");
    }
    assert_eq!(
        recorded,
        [true, true, true, true, false, false, false, false]
    );
}
