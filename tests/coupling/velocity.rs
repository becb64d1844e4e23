//! The scheme `velocity`: equal velocities at the end of each window (Gravouil and Combescure 2001).
//!
//! Problem: the split bar of [`super::split_bar`], the three pieces of [`super::several`], the static patch of
//! [`super::static_patch`], and an elastic bar of ten elements, held at one end and with a mass at the other.
//!
//! Exact answer: an independent program of sixty lines (dense matrices, another language) computed the errors of the split bar
//! against the lattice in one piece: 1.0343e-1 at theta = 1, 6.247e-4 with a tenth of the step; 1.1296e-1 and
//! 2.520e-3 at theta = 0.5. Its energy at theta = 1 ends at 5.03 % and rises by 3.73 % of its start in the worst window. For a
//! linear continuum one repeat closes the velocity gap to rounding. At theta = 1 the energy of the differentiated equations,
//! a.(M - h^2/4 K).a / 2 + v.K v / 2 of both sides together, rises only by -h^2/8 times the jump of a.K a between two windows.

use harness::runs::{Left, run_both_ways, run_in_process};
use harness::window_matrix::{Operator, TransmissionCondition};
use lab::bench::stability::bar::UnitBar;
use nalgebra::DVector;
use protocol::BoundaryInertia;
use scenario::error::Error;
use scheme::predict::sprung_mass::{Masses, SprungMass};

use super::split_bar::{STEP_S, interface_error, mechanical_j};
use super::stability::masses_in_motion;
use super::{schemes, several, split_bar, static_patch};

fn by_velocity(text: &str) -> String {
    let found = text.replace("scheme = \"dual-schur\"", "scheme = \"velocity\"");
    assert_ne!(found, text);
    found
}

fn split(theta: f64, step_s: f64) -> Left {
    let text = by_velocity(&split_bar::scenario(theta, step_s));
    run_in_process(&text, &[]).expect("it is valid").completed()
}

#[test]
fn the_split_bar_has_the_errors_of_an_independent_program() {
    let cases = [
        (1.0, STEP_S, 1.0343e-1),
        (1.0, 0.1 * STEP_S, 6.247e-4),
        (0.5, STEP_S, 1.1296e-1),
        (0.5, 0.1 * STEP_S, 2.520e-3),
    ];
    for (theta, step_s, expected) in cases {
        let left = split(theta, step_s);
        let error = interface_error(&left);
        println!("theta {theta}, h = {step_s} s: error {error:.4e}");
        assert!(
            (error / expected - 1.0).abs() < 5e-3,
            "theta {theta}, h = {step_s} s: error {error:.4e}"
        );
        assert_eq!(left.number("repeats_mean"), 1.0);
        assert!(left.number("coupling.gap_max_rel") <= 1e-11);
        assert!(left.number("coupling.force_residual_rel") <= 1e-12);
    }
}

#[test]
fn the_energy_of_the_split_bar_rises_by_less_than_four_per_cent_per_window() {
    let left = split(1.0, STEP_S);
    let sides = ["bar.mechanical_j", "chain.energy_j"].map(|side| &left.signals[side]);
    let energy = |i: usize| (sides[0][i] + sides[1][i]) / mechanical_j();
    let windows = sides[0].len();
    let rise = (1..windows).fold(0.0, |most: f64, i| most.max(energy(i) - energy(i - 1)));
    let first = energy(0) - 1.0;
    println!(
        "rise {:.4}, end {:.4}",
        rise.max(first),
        energy(windows - 1)
    );
    assert!((rise.max(first) - 0.0373).abs() <= 5e-4, "{rise} {first}");
    assert!((energy(windows - 1) - 0.0503).abs() <= 5e-4);
}

/// K x of the bench's bar: unit springs, held at its far end.
fn pulls(bar: &UnitBar, x: impl Fn(usize) -> f64) -> Vec<f64> {
    let n = bar.elements;
    let pull = |i: usize| {
        let left = if i > 0 { x(i - 1) } else { 0.0 };
        match i + 1 < n {
            true => 2.0 * x(i) - left - x(i + 1),
            false => x(i) - left,
        }
    };
    (0..n).map(pull).collect()
}

/// a.(M - h^2/4 K).a / 2 + v.K v / 2 of the bar whose end has this acceleration, and h^2/8 a.K a.
fn differentiated(bar: &UnitBar, state: &DVector<f64>, a_end: f64) -> [f64; 2] {
    let n = bar.elements;
    let inner = pulls(bar, |i| state[i]);
    let a = |i: usize| if i + 1 < n { -inner[i] } else { a_end };
    let v = |i: usize| state[n + i];
    let mass = |i: usize| if i + 1 < n { 1.0 } else { 0.5 };
    let sum = |part: &dyn Fn(usize) -> f64| (0..n).map(part).sum::<f64>();
    let (pull_a, pull_v) = (pulls(bar, a), pulls(bar, v));
    let correction = 0.125 * bar.step_s.powi(2) * sum(&|i| a(i) * pull_a[i]);
    let moving = sum(&|i| 0.5 * mass(i) * a(i) * a(i) + 0.5 * v(i) * pull_v[i]);
    [moving - correction, correction]
}

/// Largest rise of the differentiated energy of both sides in a window, over its largest value, without the jump of the corrected
/// part where the line of velocities bends. Masses in motion meet a bar at rest.
fn rises(cfl: f64, substeps: u32, boundary_inertia: BoundaryInertia) -> f64 {
    let bar = UnitBar {
        elements: 10,
        step_s: cfl,
    };
    let response = bar.response(substeps);
    let window_s = cfl * f64::from(substeps);
    let operator = Operator {
        response: &response,
        wall: SprungMass::new(&boundary_inertia, window_s),
        window_s,
        condition: TransmissionCondition::Velocity,
    };
    let mut joint = masses_in_motion();
    let (mut last, mut a_last, mut rise, mut largest) = (None, 0.0, 0.0f64, 0.0f64);
    for _ in 0..200 {
        let before = joint;
        joint = operator.advance(&before);
        let wall = wall_part(&boundary_inertia, [&before.masses, &joint.masses], window_s);
        let speeds = [&before, &joint].map(|joint| response.speed(&joint.continuum));
        let a_end = (speeds[1] - speeds[0]) / window_s;
        let jump = [a_end, a_last].map(|a| differentiated(&bar, &before.continuum, a)[1]);
        let energy = differentiated(&bar, &joint.continuum, a_end)[0] + wall;
        // From the end of the first window on, both sides have the same velocity.
        if let Some(last) = last {
            rise = rise.max(energy - last + jump[0] - jump[1]);
        }
        largest = largest.max(energy);
        (last, a_last) = (Some(energy), a_end);
    }
    rise / largest
}

/// m a^2 / 2 of the masses and k (v - v_g)^2 / 2 of the spring, a being the mean acceleration of the window.
fn wall_part(
    boundary_inertia: &BoundaryInertia,
    [before, after]: [&Masses; 2],
    window_s: f64,
) -> f64 {
    let a_glued = (after.glued_velocity - before.glued_velocity) / window_s;
    let a_free = (after.velocity - before.velocity) / window_s;
    let glued = 0.5 * boundary_inertia.glued_mass_kg * a_glued * a_glued;
    let free = boundary_inertia.stiffness_n_per_m.map_or(0.0, |k| {
        let apart = after.velocity - after.glued_velocity;
        0.5 * boundary_inertia.mass_kg * a_free * a_free + 0.5 * k * apart * apart
    });
    glued + free
}

#[test]
fn the_differentiated_energy_of_both_sides_does_not_rise() {
    for cfl in [0.1, 0.5, 0.9] {
        for substeps in [1, 3, 10, 100] {
            for ratio in [1e-2, 1.0, 1e2] {
                let springy = BoundaryInertia {
                    glued_mass_kg: 0.0,
                    mass_kg: 10.0 * ratio,
                    stiffness_n_per_m: Some(1.0),
                    theta: 1.0,
                    may_part: false,
                };
                let rigid = BoundaryInertia {
                    glued_mass_kg: 10.0 * ratio,
                    mass_kg: 0.0,
                    stiffness_n_per_m: None,
                    theta: 1.0,
                    may_part: false,
                };
                for boundary_inertia in [springy, rigid] {
                    let rise = rises(cfl, substeps, boundary_inertia);
                    println!("{cfl} {substeps} {ratio}: {rise:.2e}");
                    assert!(
                        rise <= 1e-9,
                        "CFL {cfl}, m {substeps}, {boundary_inertia:?}: {rise:e}"
                    );
                }
            }
        }
    }
}

#[test]
fn shared_memory_gives_the_same_bits() {
    run_both_ways(&by_velocity(&split_bar::scenario(1.0, STEP_S)), &[]);
}

#[test]
fn a_heavy_body_is_stopped_without_growth() {
    let text = schemes::scenario("velocity", 10, 400, false);
    let left = run_in_process(&text, &[]).expect("it is valid").completed();
    let u = &left.signals["bar.u_m"];
    let largest = |part: &[f64]| part.iter().fold(0.0, |most: f64, u| most.max(u.abs()));
    assert!(largest(&u[200..]) < 0.9 * largest(&u[..200]));
}

#[test]
fn two_bars_with_a_chain_between_them_take_one_repeat() {
    let three = |scheme: &str, step_s: f64| {
        let text = several::three(scheme, 1.0, [step_s, step_s / 3.0], [4, 12]);
        let left = several::run(&text);
        for name in ["lower", "upper"] {
            let gap = left.number(&format!("interfaces.{name}.gap_max_rel"));
            assert!(gap <= 1e-12, "{name}: gap {gap}");
        }
        assert_eq!(left.number("repeats_mean"), 1.0);
        several::errors(&left)
    };
    let [coarse, fine] = [0.9, 0.225].map(|step_s| three("velocity", step_s));
    let default = three("dual-schur", 0.225);
    println!(
        "errors {coarse:.3?}, with a quarter of the window {fine:.3?}, dual-schur {default:.3?}"
    );
    for joint in 0..2 {
        assert!(fine[joint] < coarse[joint], "{coarse:?} {fine:?}");
        // The remaining error is the implicit chain's own damping.
        let apart = (fine[joint] / default[joint] - 1.0).abs();
        assert!(apart < 0.1, "{fine:?} {default:?}");
    }
}

/// The short bar between the walls is nearly rigid over a window, so each wall feels the other within it.
#[test]
fn two_walls_on_one_bar_close_both_gaps() {
    let more = ("repeats_max = 60", "repeats_max = 200");
    let text = several::two_walls("velocity").replace(more.0, more.1);
    let left = several::run(&text);
    let repeats = left.number("repeats_mean");
    println!("{repeats:.1} repeats per window");
    assert!(repeats > 1.5, "the walls feel each other: {repeats}");
    for name in ["above", "below"] {
        let gap = left.number(&format!("interfaces.{name}.gap_max_rel"));
        assert!(gap <= 1e-11, "{name}: {gap}");
    }
}

/// Continuum and mapping in full: 11 nodes, 23 points, sides held in x.
#[test]
fn the_static_patch_settles_on_its_answer() {
    for substeps in [1, 10, 30] {
        let text = by_velocity(&static_patch::scenario(substeps, 23));
        let left = run_in_process(&text, &[]).expect("it is valid").completed();
        static_patch::settles(&left, substeps);
    }
}

#[test]
fn windows_are_halved_and_the_last_one_is_short() {
    let sets = [
        "interface.glue.on_not_converged=halve",
        "participant.bar.config.nan_above_substeps=5",
        "participant.body.config.end_s=58.0",
    ];
    let left = run_in_process(&schemes::scenario("velocity", 10, 60, false), &sets)
        .expect("it is valid")
        .completed();
    assert!(left.number("coupling.halved_windows") > 0.0);
    assert!(left.number("coupling.gap_max_rel") <= 1e-11);
    let t = &left.signals["t_s"];
    assert!((t[t.len() - 1] - 65.0 * 0.9).abs() < 1e-9);
}

#[test]
fn participants_that_cannot_follow_are_refused_by_name() {
    let text = schemes::scenario("velocity", 10, 60, false);
    let staggered = ["participant.bar.config.grouping=staggered"];
    let left = run_in_process(&text, &staggered).expect("it is valid");
    let error = left.ended.error.expect("the staggered bar cannot follow");
    assert!(matches!(error, Error::Refused(_)), "{error}");
    for said in ["interface.glue.scheme", "`bar`", "dual-schur"] {
        assert!(error.to_string().contains(said), "no {said} in {error}");
    }
    let strip = by_velocity(&static_patch::scenario(10, 23));
    let plastic = ["participant.strip.config.material.yield_pa=1e8"];
    let left = run_in_process(&strip, &plastic).expect("it is valid");
    let error = left.ended.error.expect("a plastic strip cannot follow");
    for said in ["interface.glue.scheme", "`strip`", "dual-schur-secant"] {
        assert!(error.to_string().contains(said), "no {said} in {error}");
    }
    let masses = run_in_process(&text, &["interface.glue.compliance=mass"]);
    let error = masses.err().expect("it asks for the impedance").to_string();
    for said in ["compliance", "velocity"] {
        assert!(error.contains(said), "no {said} in {error}");
    }
}

/// A plastic bar does not answer with its own impedance.
#[test]
fn a_plastic_bar_ends_as_not_converged() {
    let text = schemes::scenario("velocity", 30, 120, true);
    let once = ["interface.glue.repeats_max=1"];
    let left = run_in_process(&text, &once).expect("it is valid");
    let error = left.ended.error.expect("one repeat is not enough");
    assert!(matches!(error, Error::NotConverged(_)), "{error}");
    assert!(error.to_string().contains("dual-schur-secant"), "{error}");
}

/// In accepted windows the bar carries another force at the end than the body's.
#[test]
fn the_residual_compares_with_the_force_that_the_bar_carried() {
    let text = schemes::scenario("velocity", 30, 120, true);
    let accepted = [
        "interface.glue.repeats_max=1",
        "interface.glue.on_not_converged=accept",
    ];
    let left = run_in_process(&text, &accepted).expect("it is valid");
    let residual = left.completed().number("coupling.force_residual_rel");
    assert!(residual > 1e-6, "{residual:e}");
}
