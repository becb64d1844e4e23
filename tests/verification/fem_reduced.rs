//! Problem: a crowned, graded, clamped block of 12 x 6 elements (156 unknowns) as its lowest modes, under interface forces that change from window to
//! window, and under loads of its sets.
//! Exact: with all modes and no far field it moves like its elements; under a constant force it comes to K^-1 lambda for any number of modes and any
//! near field; work - stored - dissipated = 0, with each term from its own formula; du = du_free + C lambda with its columns C.
//! Source: the derivation in `fem_kernel::reduced`, for the scheme of the body.
//! Tolerance: 1e-9 for all modes and 1e-10 for the equilibrium (rounding of the modes), 1e-12 of the summed works for the energies.

use std::fs;
use std::path::{Path, PathBuf};

use fem_kernel::statics::history::equilibrium;
use fem_node::{FemConfig, ReducedNode};
use kit::read_config;
use kit::scratch::Scratch;
use nalgebra::{DMatrix, DVector};
use protocol::{Node, Role, Setting, Window};
use serde_json::{Value, json};

use crate::fem_bodies::{block, node, setting, window, with};

fn reduced(config: &Value) -> ReducedNode {
    let config: FemConfig = read_config(config).expect("the keys are valid");
    let keys = config.reduced.expect("it is reduced");
    ReducedNode::new(&config, keys, &setting(1)).expect("the body is valid")
}

/// A force that changes at every window.
fn force(components: usize, index: u64) -> Vec<f64> {
    let rough = |k: u64| ((index * 37 + k * 11) % 101) as f64 / 101.0 - 0.5;
    (0..components as u64).map(|k| 50.0 * rough(k)).collect()
}

/// Loads that are constant, grow, and follow a table.
fn loads() -> Value {
    json!({"top": {"traction_pa": [1e6, -2e6], "ramp_s": 5e-6},
           "right": {"traction_pa": [5e5, 0.0]},
           "left": {"load_table": [[1e-6, 5.0], [9e-6, 40.0], [2e-5, -10.0]], "load_direction": [1.0, -2.0]}})
}

fn go(node: &mut dyn Node, window: &Window, force: &[f64]) -> (Vec<f64>, Vec<f64>) {
    let du = node.advance(window, force).expect("stable");
    (du, node.commit(window, &[]).expect("advanced"))
}

fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |most, value| most.max(value.abs()))
}

#[test]
fn all_modes_move_like_the_elements() {
    for (damping, mass_damping) in [(0.5, 0.0), (0.75, 0.0), (1.0, 3e5)] {
        let config = with(
            block(),
            json!({"time": {"damping": damping, "mass_damping_per_s": mass_damping}, "boundary": loads(),
                   "probes": [{"name": "inside", "x_m": 1.1e-3, "y_m": -2.3e-3}]}),
        );
        let keys = json!({"reduced": {"modes": 1000, "near_m": 1.0}});
        let (mut elements, mut modes) = (node(&config), reduced(&with(config, keys)));
        let count = 2 * elements.couple("top").expect("a set").len();
        modes.couple("top").expect("a set");
        let [ours, theirs] = [modes.describe(), elements.describe()].map(|d| d.signals);
        assert_eq!(ours, theirs);
        let (mut scale, mut worst) = (vec![0.0f64; ours.len()], vec![0.0f64; ours.len()]);
        for index in 0..100 {
            let of_window = window(index, [10, 10, 3][index as usize % 3]);
            let load = force(count, index);
            let (du, theirs) = go(&mut elements, &of_window, &load);
            let (moved, ours) = go(&mut modes, &of_window, &load);
            let apart: Vec<f64> = du.iter().zip(&moved).map(|(a, b)| a - b).collect();
            assert!(
                largest(&apart) <= 1e-9 * largest(&du),
                "b {damping}, window {index}"
            );
            for k in 0..scale.len() {
                scale[k] = scale[k].max(theirs[k].abs());
                worst[k] = worst[k].max((theirs[k] - ours[k]).abs());
            }
        }
        for ((name, scale), worst) in ours.iter().zip(scale).zip(worst) {
            assert!(
                worst <= 1e-9 * scale,
                "b {damping}: {name} {worst:e} of {scale:e}"
            );
        }
    }
}

/// A periodic body has its modes in pairs of one frequency.
#[test]
fn all_modes_of_a_periodic_body_move_like_its_elements() {
    let flat = json!({"mesh": {"periodic_x": true, "crown_radius_m": 0.0}});
    let config = with(block(), flat);
    let keys = json!({"reduced": {"modes": 1000, "near_m": 1.0}});
    let (mut elements, mut modes) = (node(&config), reduced(&with(config, keys)));
    let count = 2 * elements.couple("top").expect("a set").len();
    modes.couple("top").expect("a set");
    for index in 0..100 {
        let (of_window, load) = (window(index, 10), force(count, index));
        let (theirs, _) = go(&mut elements, &of_window, &load);
        let (ours, _) = go(&mut modes, &of_window, &load);
        let apart: Vec<f64> = theirs.iter().zip(&ours).map(|(a, b)| a - b).collect();
        assert!(largest(&apart) <= 1e-9 * largest(&theirs), "window {index}");
    }
}

#[test]
fn a_constant_force_brings_the_body_to_its_equilibrium() {
    for (modes, near) in [
        (5, json!("auto")),
        (30, json!("auto")),
        (30, json!(1.0)),
        (1, json!(1.0)),
    ] {
        let config = with(
            block(),
            json!({"time": {"mass_damping_per_s": 3e5}, "reduced": {"modes": modes, "near_m": near},
                   "boundary": {"right": {"traction_pa": [5e5, -3e5]}}}),
        );
        let mut node = reduced(&config);
        let count = 2 * node.couple("top").expect("a set").len();
        let load = force(count, 5);
        let mut moved = vec![0.0; count];
        for index in 0..300 {
            let (du, _) = go(&mut node, &window(index, 40), &load);
            moved.iter_mut().zip(du).for_each(|(sum, du)| *sum += du);
        }
        let mut problem = node.model.static_problem();
        let layout = node.model.body.layout;
        let component = |k: usize| layout.index([k / 2, 0], k % 2);
        load.iter()
            .enumerate()
            .for_each(|(k, f)| problem.tractions[component(k)] += f);
        let still = equilibrium(&problem, None).expect("it is held").state;
        let expected: Vec<f64> = (0..count).map(|k| still.u[component(k)]).collect();
        let apart: Vec<f64> = moved.iter().zip(&expected).map(|(a, b)| a - b).collect();
        let error = largest(&apart) / largest(&expected);
        assert!(error <= 1e-10, "{modes} modes: {error:e}");
    }
}

#[test]
fn every_joule_is_accounted_for() {
    let mut far = 0.0f64;
    for (damping, mass_damping, modes) in [
        (0.5, 0.0, 20),
        (0.75, 3e5, 20),
        (1.0, 0.0, 4),
        (0.75, 0.0, 156),
    ] {
        let config = with(
            block(),
            json!({"time": {"damping": damping, "mass_damping_per_s": mass_damping}, "boundary": loads(),
                   "reduced": {"modes": modes}}),
        );
        let mut node = reduced(&config);
        let count = 2 * node.couple("top").expect("a set").len();
        let description = node.describe();
        for index in 0..200 {
            let of_window = window(index, [10, 4][index as usize % 2]);
            let (_, report) = go(&mut node, &of_window, &force(count, index));
            let values = &report[description.signals.len()..];
            let sum = |roles: &[Role], part: fn(f64) -> f64| -> f64 {
                let terms = description.ledger.iter().zip(values);
                let terms = terms.filter(|(term, _)| roles.contains(&term.role));
                terms.map(|(_, value)| part(*value)).sum()
            };
            let work = [Role::Work, Role::InterfaceWork];
            let defect =
                sum(&work, |w| w) - sum(&[Role::Stored], |e| e) - sum(&[Role::Dissipated], |d| d);
            let defect = defect.abs() / sum(&work, f64::abs);
            assert!(
                defect <= 1e-12,
                "b {damping}, {modes} modes, window {index}: {defect:e}"
            );
            far = far.max(values[values.len() - 1].abs() / sum(&work, f64::abs));
        }
    }
    assert!(far > 1e-3, "the far field is tested: {far:e}");
}

#[test]
fn a_window_is_affine_in_the_force_with_the_columns_as_slope() {
    let config = with(block(), json!({"reduced": {"modes": 20}}));
    let mut node = reduced(&config);
    node.couple("top").expect("a set");
    node.select(&[2, 5, 6, 11]).expect("points of the set");
    for (index, substeps) in [7, 25, 7].into_iter().enumerate() {
        let of_window = window(index as u64, substeps);
        let load = force(8, index as u64 + 9);
        let still = node.advance(&of_window, &[0.0; 8]).expect("stable");
        let moved = node.advance(&of_window, &load).expect("stable");
        let c = DMatrix::from_column_slice(8, 8, &node.columns(&of_window).expect("stable"));
        assert!(c == c.transpose() && c.clone().cholesky().is_some());
        let expected = DVector::from_vec(still) + c * DVector::from_vec(load);
        let error = (DVector::from_vec(moved) - &expected).amax();
        assert!(error <= 1e-14 * expected.amax(), "{error:e}");
        node.commit(&of_window, &[]).expect("advanced");
    }
}

/// A set that carries two layers is coupled twice, each time with points of its own.
#[test]
fn two_layers_may_lie_on_one_edge() {
    let keys = json!({"reduced": {"modes": 1000, "near_m": 1.0}});
    let (mut elements, mut modes) = (node(&block()), reduced(&with(block(), keys)));
    for node in [&mut elements as &mut dyn Node, &mut modes] {
        let count = [0, 1].map(|_| node.couple("top").expect("a set").len())[0];
        node.select(&[1, 2, 3, count + 8, count + 9])
            .expect("points of the set");
    }
    for index in 0..20 {
        let load = force(10, index);
        let (theirs, _) = go(&mut elements, &window(index, 10), &load);
        let (ours, _) = go(&mut modes, &window(index, 10), &load);
        let apart: Vec<f64> = theirs.iter().zip(&ours).map(|(a, b)| a - b).collect();
        assert!(largest(&apart) <= 1e-9 * largest(&theirs), "window {index}");
    }
}

#[test]
fn a_checkpoint_keeps_every_bit() {
    let config = with(
        block(),
        json!({"reduced": {"modes": 20}, "boundary": loads()}),
    );
    let begin = || {
        let mut node = reduced(&config);
        let count = 2 * node.couple("top").expect("a set").len();
        (node, count)
    };
    let (mut first, count) = begin();
    for index in 0..20 {
        go(&mut first, &window(index, 10), &force(count, index));
    }
    let bytes = first.checkpoint().expect("it is offered");
    let (mut second, _) = begin();
    second.restore(&bytes).expect("its own");
    for index in 20..30 {
        let [a, b] = [&mut first, &mut second]
            .map(|node| go(node, &window(index, 10), &force(count, index)));
        assert_eq!(a, b, "window {index}");
    }
    let hashes = [&mut first, &mut second].map(|node| node.finish().expect("it ends").state_hash);
    assert_eq!(hashes[0], hashes[1]);
    let (mut other, _) = begin();
    other.select(&[3, 4]).expect("points of the set");
    let refused = other.restore(&bytes).expect_err("other points");
    assert!(refused.message.contains("another body"), "{refused}");
}

/// The modes take longer than what is not worth keeping.
#[test]
fn kept_modes_and_surfaces_give_the_same_bits_and_a_flipped_byte_is_noticed() {
    let folder = Scratch::new("kept-modes", 0);
    let finer = json!({"mesh": {"size_m": 2e-4, "side_columns": 8, "depth_rows": 12},
                       "reduced": {"modes": 150}, "boundary": loads()});
    let config = with(block(), finer);
    let run = |config: &Value, cache: Option<&Path>| {
        let setting = Setting {
            cache: cache.map(Path::to_path_buf),
            ..setting(1)
        };
        let config: FemConfig = read_config(config).expect("the keys are valid");
        let keys = config.reduced.expect("it is reduced");
        let mut node = ReducedNode::new(&config, keys, &setting).expect("the body is valid");
        let count = 2 * node.couple("top").expect("a set").len();
        for index in 0..3 {
            go(&mut node, &window(index, 10), &force(count, index));
        }
        node.finish().expect("it ends")
    };
    let hash = |config: &Value| {
        let outcome = run(config, Some(folder.path()));
        (outcome.state_hash, outcome.warnings)
    };
    let files = || {
        let entries = fs::read_dir(folder.path()).expect("it was made");
        let mut paths: Vec<PathBuf> = entries.map(|e| e.expect("it is read").path()).collect();
        paths.sort();
        paths
    };
    let clean = (run(&config, None).state_hash, Vec::new());
    assert_eq!(hash(&config), clean);
    let kept = files();
    assert_eq!(kept.len(), 3, "{kept:?}");
    let written = kept.iter().map(|path| fs::read(path).expect("it is read"));
    let written: Vec<Vec<u8>> = written.collect();
    assert_eq!(hash(&config), clean);
    for (path, whole) in kept.iter().zip(&written) {
        let mut flipped = whole.clone();
        flipped[whole.len() / 2] ^= 1;
        fs::write(path, flipped).expect("it is ours");
        let (state, warnings) = hash(&config);
        assert_eq!(state, clean.0);
        let [warning] = &warnings[..] else {
            panic!("{warnings:?}");
        };
        assert!(warning.contains("is damaged") && warning.contains(&*path.to_string_lossy()));
        assert!(fs::read(path).expect("it is read") == *whole, "replaced");
    }
    let load = json!({"right": {"traction_pa": [4e5, 0.0]}});
    for (more, change) in [
        (
            0,
            json!({"probes": [], "plausible": {"far_field_rel": [0.1, 1.0]}}),
        ),
        (1, json!({"time": {"damping": 1.0}})),
        (1, json!({"reduced": {"near_m": 1.0}})),
        (1, json!({"boundary": load})),
        (3, json!({"reduced": {"modes": 151}})),
        (3, json!({"material": {"poisson": 0.29}})),
        (3, json!({"base": "roller"})),
    ] {
        let before = files().len();
        hash(&with(config.clone(), change.clone()));
        assert_eq!(files().len(), before + more, "{change}");
    }
}

#[test]
fn a_near_field_that_is_too_short_is_refused_with_a_length_that_is_not() {
    let keys = |near: f64| json!({"reduced": {"modes": 3, "near_m": near}});
    let answer = |near: f64| {
        let mut node = reduced(&with(block(), keys(near)));
        node.couple("top").expect("a set");
        node.columns(&window(0, 40))
    };
    let refused = answer(1e-4).expect_err("it is too short").message;
    let (_, rest) = refused.split_once("with these modes ").expect("a length");
    let (length, _) = rest.split_once(" m would do").expect("a length");
    let length: f64 = length.parse().expect("a number");
    assert!(answer(1.01 * length).is_ok(), "{refused}");
}

#[test]
fn what_has_no_modes_is_refused_by_name() {
    let wheel = json!({"load_n": 1.0, "mass_kg": 0.01, "ramp_s": 1e-4, "hold_s": 1e-4});
    let cases = [
        ("analysis", json!({"analysis": "static"})),
        (
            "wheel",
            json!({"wheel": wheel, "contact": {"friction": 0.3}}),
        ),
        ("material.yield_pa", json!({"material": {"yield_pa": 1e9}})),
        ("kinematics", json!({"kinematics": "corotational"})),
        ("base", json!({"base": "free"})),
        (
            "time.stiffness_damping_s",
            json!({"time": {"stiffness_damping_s": 1e-9}}),
        ),
        (
            "initial.top",
            json!({"initial": {"top": {"velocity_m_per_s": [0.0, 1.0]}}}),
        ),
        (
            "boundary.top",
            json!({"boundary": {"top": {"velocity_m_per_s": [0.0, 1.0]}}}),
        ),
        ("reduced", json!({"reduced": {"omega_max_per_s": 1e6}})),
        ("reduced.modes", json!({"reduced": {"modes": 0}})),
        ("reduced.near_m", json!({"reduced": {"near_m": "far"}})),
        ("reduced.mode", json!({"reduced": {"mode": 3}})),
    ];
    for (key, change) in cases {
        let config = with(with(block(), json!({"reduced": {"modes": 10}})), change);
        let error = fem_node::check(&config, &setting(1)).expect_err("it is impossible");
        assert_eq!(error.key, key, "{error}");
    }
    let config = with(block(), json!({"reduced": {}}));
    let error = fem_node::check(&config, &setting(1)).expect_err("no number of modes");
    assert_eq!(error.key, "reduced", "{error}");
}

#[test]
fn a_largest_frequency_gives_the_modes_below() {
    let built = |keys: Value| {
        let config: FemConfig =
            read_config(with(block(), json!({"reduced": keys}))).expect("valid");
        let reduced = config.reduced.expect("it is reduced");
        let node = ReducedNode::new(&config, reduced, &setting(1));
        node.map(|mut node| node.finish().expect("it ends").results)
    };
    let twenty = built(json!({"modes": 20})).expect("it is held");
    let omega = twenty["reduced_omega_max_per_s"];
    for (factor, modes) in [(1.0001, 20.0), (0.9999, 19.0)] {
        let found = built(json!({"omega_max_per_s": factor * omega})).expect("it is held");
        assert_eq!(found["reduced_modes"], modes, "{omega}");
    }
    let error = built(json!({"omega_max_per_s": 1e3})).expect_err("no mode is so slow");
    assert!(
        error.to_string().contains("reduced.omega_max_per_s"),
        "{error}"
    );
}

#[test]
fn forces_that_change_from_window_to_window_are_reported() {
    let found = |modes: u32, near: Value| {
        let keys = json!({"reduced": {"modes": modes, "near_m": near}});
        let mut node = reduced(&with(block(), keys));
        let count = 2 * node.couple("top").expect("a set").len();
        for index in 0..100 {
            go(&mut node, &window(index, 10), &force(count, index));
        }
        let findings = node.finish().expect("it ends").findings;
        let mut findings = findings.into_iter();
        let far = findings.find(|finding| finding.code == "far_field");
        far.map(|finding| finding.value)
    };
    let value = found(5, json!("auto")).expect("forces change in each window");
    println!("the far field gave {value:.3} of the work");
    assert!(value > 0.02, "{value}");
    assert_eq!(found(5, json!(1.0)), None, "there is no far field");
}
