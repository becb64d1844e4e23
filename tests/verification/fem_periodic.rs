//! Problem: a block whose left and right edges are the same (mesh.periodic_x).
//!
//! ```text
//!     = o---o---o---o =        the last column of nodes is the first one
//!     = |   |   |   | =
//!     = o---o---o---o =
//! ```
//!
//! Exact: a translation stretches nothing. A wave crosses the seam unchanged and comes back after a period. Under a uniform
//! traction (tau, sigma) every column has u = (tau/mu, sigma/M) (y + H). Under a flat rigid wheel the pressure is the load
//! over the area everywhere. The fastest mode is one element's, 2 c_p/d.
//! Source: d'Alembert; the dispersion relation of `fem_dispersion`; M = lambda + 2 mu.
//! Tolerance: rounding, given at each assertion.

use fem_kernel::statics::history::{StaticLoads, equilibrium};
use fem_node::output::profile::ContactProfile;
use protocol::{FaultCode, Node};
use serde_json::{Value, json};

use crate::fem_bodies::{
    block, confined_modulus, node, node_on, reported, set_in_motion, setting, window, with,
};
use crate::fem_dispersion::{SIZE, Wave, exact, number, travelling};

fn periodic(base: Value) -> Value {
    with(base, json!({"mesh": {"periodic_x": true}}))
}

/// 24 x 8 square elements, flat, clamped.
fn flat() -> Value {
    periodic(json!({
        "mesh": {"width_m": 12e-3, "height_m": 4e-3, "size_m": 5e-4},
        "material": {"young_pa": 102.5e9, "poisson": 0.3, "density_kg_per_m3": 7800.0},
        "time": {"step_s": "auto", "damping": 0.75},
    }))
}

/// v M v / 2 (J); the ledger has its change since the start.
fn kinetic(node: &fem_node::FemNode) -> f64 {
    let masses = node.model.body.mass.iter();
    let squares = masses.zip(&node.state().v).map(|(m, v)| m * v * v);
    0.5 * squares.sum::<f64>()
}

#[test]
fn a_translation_stretches_nothing() {
    for element in ["q4_1point", "q4_2x2", "q4_bbar"] {
        let config = with(
            periodic(block()),
            json!({"element": element, "base": "free"}),
        );
        let start = |_| [[1e-6, -2e-6], [3.0, -1.0]];
        let mut free = set_in_motion(&node(&config), start);
        let start = free.state().u.clone();
        let report = free.advance_alone(&window(0, 50)).expect("stable");
        let time = 50.0 * free.model.scheme.step;
        let layout = free.model.body.layout;
        let moved = |n: [usize; 2], k: usize| {
            free.state().u[layout.index(n, k)] - start[layout.index(n, k)]
        };
        for node in [[0, 0], [3, 2], [12, 6], [12, 0]] {
            for (k, speed) in [3.0, -1.0].into_iter().enumerate() {
                let error = moved(node, k) / (speed * time) - 1.0;
                assert!(error.abs() <= 1e-10, "{element} {node:?}: {error:e}");
            }
        }
        let strain = reported(&free, &report, "strain") / kinetic(&free);
        assert!(strain.abs() <= 1e-12, "{element}: {strain:e}");
    }
}

#[test]
fn a_wave_crosses_the_seam_unchanged() {
    const PERIODS: usize = 3;
    for wave in [Wave::P, Wave::S] {
        let mut strip = travelling(wave, PERIODS, 1e-9, wave.strip(0.5));
        let z = exact(wave, PERIODS, strip.model.scheme.step, 0.5);
        // With three periods in the strip, every front crosses the seam more than twice.
        let steps = (8.0 * std::f64::consts::TAU / z.phase).round() as u32;
        strip.advance_alone(&window(0, steps)).expect("stable");
        let (mesh, layout) = (&strip.model.mesh, strip.model.body.layout);
        let component = usize::from(matches!(wave, Wave::S));
        for i in 0..=mesh.columns {
            let place = number(PERIODS) * mesh.point(i, 0)[0] - f64::from(steps) * z.phase;
            for row in [0, 1] {
                let u = strip.state().u[layout.index([i, row], component)];
                let error = u / 1e-9 - place.cos();
                assert!(error.abs() <= 1e-9, "{wave:?}, column {i}: {error:e}");
            }
        }
    }
}

#[test]
fn no_energy_is_lost_at_the_seam() {
    for b in [0.5, 0.75] {
        let mut strip = travelling(Wave::P, 3, 1e-9, Wave::P.strip(b));
        let energy = |node: &fem_node::FemNode| {
            let ledger = node.ledger();
            ledger.kinetic + ledger.strain + ledger.numerical
        };
        strip.advance_alone(&window(0, 1)).expect("stable");
        let start = energy(&strip);
        let kinetic = kinetic(&strip);
        strip.advance_alone(&window(1, 500)).expect("stable");
        let defect = (energy(&strip) - start) / kinetic;
        assert!(defect.abs() <= 1e-10, "b = {b}: {defect:e}");
    }
}

/// One row of square elements has 2 c_p/d, the mode of alternating expansion in the free direction.
#[test]
fn the_fastest_mode_is_the_mode_of_one_element() {
    for wave in [Wave::P, Wave::S] {
        let strip = node(&wave.strip(0.75));
        let fastest = 2.0 * Wave::P.speed() / SIZE;
        let error = strip.model.omega_max / fastest - 1.0;
        assert!(error.abs() <= 2e-6, "{wave:?}: {error:e}");
    }
}

#[test]
fn the_step_limit_belongs_to_the_closed_body() {
    let limit = node(&flat()).model.step_limit;
    let run = |share: f64| {
        let time = json!({"time": {"step_s": share * limit, "unsafe_step": true}});
        let mut body = node(&with(flat(), time));
        let points = body.couple("top").expect("a set").len();
        let mut force = vec![0.0; 2 * points];
        force[1] = -1.0;
        body.advance(&window(0, 1), &force).expect("one step");
        body.commit(&window(0, 1), &[]).expect("one step");
        (1..400).try_for_each(|index| body.advance_alone(&window(index, 1)).map(|_| ()))
    };
    run(0.999).expect("it is stable");
    let fault = run(1.01).expect_err("it is unstable");
    assert_eq!(fault.code, FaultCode::Diverged);
}

#[test]
fn under_a_uniform_traction_every_column_is_the_same() {
    let (tau, sigma) = (2e6, -5e6);
    let load = json!({"boundary": {"top": {"traction_pa": [tau, sigma]}}});
    for element in ["q4_1point", "q4_2x2", "q4_bbar"] {
        let body = node(&with(
            with(flat(), load.clone()),
            json!({"element": element}),
        ));
        let state = equilibrium(&body.model.static_problem(), None)
            .expect("it exists")
            .state;
        let (mesh, layout) = (&body.model.mesh, body.model.body.layout);
        let moduli = [102.5e9 / 2.6, confined_modulus()];
        for (i, j) in (0..=8).flat_map(|j| (0..=24).map(move |i| (i, j))) {
            let depth = mesh.point(i, j)[1] + 4e-3;
            for (k, traction) in [tau, sigma].into_iter().enumerate() {
                let exact = traction / moduli[k] * depth;
                let error = state.u[layout.index([i, j], k)] - exact;
                let scale = (traction / moduli[k] * 4e-3).abs();
                assert!(error.abs() <= 1e-10 * scale, "{element} {i} {j}: {error:e}");
            }
        }
    }
}

#[test]
fn a_flat_wheel_gives_a_uniform_pressure() {
    let wheel = json!({"wheel": {"load_n": 600.0, "mass_kg": 0.01, "ramp_s": 1e-5, "hold_s": 1e-5},
                       "contact": {"friction": 0.3}});
    let body = node(&with(flat(), wheel));
    let loads = StaticLoads {
        start: 0.0,
        load: 600.0,
        radius: 0.0,
        friction: 0.3,
        friction_while_loading: true,
        increments: 3,
    };
    let contact = equilibrium(&body.model.static_problem(), Some(&loads))
        .expect("it exists")
        .contact;
    let profile = ContactProfile::new(&body.model, &contact.expect("there is a wheel"));
    assert_eq!(profile.x.len(), 24);
    for (x, pressure) in profile.x.iter().zip(&profile.pressure) {
        let error = pressure / (600.0 / (12e-3 * 1e-3)) - 1.0;
        assert!(error.abs() <= 1e-9, "x = {x}: {error:e}");
    }
}

/// In motion all columns are equal, too.
#[test]
fn a_falling_wheel_shows_no_seam() {
    let wheel = json!({"wheel": {"load_n": 600.0, "mass_kg": 0.01, "ramp_s": 1e-5, "hold_s": 1e-5},
                       "contact": {"friction": 0.3}});
    let mut body = node(&with(flat(), wheel));
    body.advance_alone(&window(0, 400)).expect("stable");
    let layout = body.model.body.layout;
    for row in 0..8 {
        let uy = |i: usize| body.state().u[layout.index([i, row], 1)];
        for i in 1..=24 {
            let error = uy(i) / uy(0) - 1.0;
            assert!(error.abs() <= 1e-9, "row {row}, column {i}: {error:e}");
        }
    }
}

#[test]
fn threads_do_not_change_a_bit() {
    let config = with(
        periodic(block()),
        json!({"mesh": {"size_m": 5e-5, "side_columns": 45, "depth_rows": 50},
               "boundary": {"top": {"traction_pa": [1e6, -3e6]}}}),
    );
    let run = |threads: usize| {
        let mut body = node_on(&config, threads);
        body.advance_alone(&window(0, 60)).expect("stable");
        (body.state().clone(), *body.ledger())
    };
    let one = run(1);
    for threads in [2, 3] {
        assert_eq!(run(threads), one, "{threads} threads");
    }
}

#[test]
fn each_node_is_exchanged_once() {
    let mut body = node(&flat());
    let top = body.couple("top").expect("a set");
    assert_eq!(top.len(), 24);
    assert!(top.length_m.iter().all(|l| (l / 5e-4 - 1.0).abs() < 1e-9));
    let mass = 7800.0 * 5e-4 * 2.5e-4 * 1e-3;
    assert!(top.mass_kg.iter().all(|m| (m / mass - 1.0).abs() < 1e-9));
    // Every node has the same response to a force, also the node on the seam.
    let columns = body.columns(&window(0, 6)).expect("stable");
    let own = |point: usize| columns[(2 * point + 1) * 48 + 2 * point + 1];
    assert!((own(0) / own(11) - 1.0).abs() < 1e-9);
}

#[test]
fn only_the_edges_of_a_periodic_body_have_a_period() {
    let free = with(flat(), json!({"base": "free"}));
    let periods = node(&free).describe().period_m;
    assert_eq!(periods.len(), 2);
    for set in ["top", "bottom"] {
        assert!((periods[set] / 12e-3 - 1.0).abs() < 1e-12, "{periods:?}");
    }
    let with_ends = with(flat(), json!({"mesh": {"periodic_x": false}}));
    assert!(node(&with_ends).describe().period_m.is_empty());
}

/// Thrown along x, a periodic block goes three times round without strain. Thrown along y, or with ends, it travels three times its width.
#[test]
fn a_block_may_fly_any_distance_with_ends_and_without() {
    let thrown = |repeats: bool, velocity: [f64; 2]| {
        let changes = json!({
            "base": "free", "mesh": {"periodic_x": repeats},
            "initial": {"body": {"velocity_m_per_s": velocity}},
        });
        let mut block = node(&with(flat(), changes));
        let steps = (36e-3 / 100.0 / block.model.scheme.step) as u32;
        let windows = (0..10).map(|index| block.advance_alone(&window(index, steps / 10)));
        let end = windows.collect::<Result<Vec<_>, _>>();
        (block, end.map(|mut reports| reports.pop().expect("ten")))
    };
    for (repeats, velocity) in [
        (true, [100.0, 0.0]),
        (true, [0.0, 100.0]),
        (false, [100.0, 0.0]),
    ] {
        let (block, report) = thrown(repeats, velocity);
        let strain = reported(&block, &report.expect("it flies"), "strain") / kinetic(&block);
        assert!(strain.abs() < 1e-12, "{velocity:?}: {strain:e}");
    }
}

#[test]
fn keys_that_need_ends_are_refused_by_name() {
    let refused = |change: Value| {
        let config = with(flat(), change);
        fem_node::check(&config, &setting(1))
            .expect_err("it has no ends")
            .key
    };
    assert_eq!(refused(json!({"sides": "fixed_x"})), "sides");
    let pulled = json!({"boundary": {"left": {"traction_pa": [1.0, 0.0]}}});
    assert_eq!(refused(pulled), "boundary.left");
    let mut body = node(&flat());
    let error = body.couple("right").expect_err("it has no ends");
    assert_eq!(error.code, FaultCode::Configuration);
    assert!(!body.describe().sets.contains(&"left".into()));
}
