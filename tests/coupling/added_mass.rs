//! Added mass (case 2 of the coupling page).
//!
//! Problem: an elastic bar with a held left end (100 elements of 1 kg and 1 N/m) is glued to a rigid body at its
//! right end; the body starts with 1 m/s. The mass ratio is the body's mass over the bar's.
//!
//! Exact answer: the initial energy bounds the motion: with a stable scheme the energy at the end is not above the initial one
//! (growth <= 1 + 1e-9 per window). With a staggered scheme the body follows a node that the last window's inertia force pushes.
//! With 10 substeps per window the force comes back larger than it went (growth > 2 per window; independent prototypes measured 13).

use harness::runs::{Left, run_in_process, run_over_shared_memory};
use harness::scene::{bar, body, glue, head};

fn scenario(scheme: &str, mass_ratio: f64, substeps: u32, windows: u32) -> String {
    let step_s = 0.9;
    let end_s = f64::from(substeps * windows) * step_s;
    // A scheme that is predicted to grow is refused unless allowed.
    let naive = scheme.starts_with("staggered");
    let keys = format!("tolerance_rel = 1e-9\nunsafe_window = {naive}");
    [
        head("added-mass", 1.0, ""),
        bar("bar", 100, step_s, "left_fixed = true"),
        body(
            100.0,
            100.0 * mass_ratio,
            1.0,
            &format!("end_s = {end_s:?}"),
        ),
        glue(scheme, substeps, &keys),
    ]
    .concat()
}

/// Mean growth of the interface force per window, from the first window to the last.
fn growth(left: &Left) -> f64 {
    let force = &left.signals["interface_fx_n"];
    let first = force[0].abs();
    let last = force[force.len() - 1].abs();
    (last / first).powf(1.0 / (force.len() - 1) as f64)
}

/// Growth of the amplitude per window, from the largest energies in the first and in the last quarter of the run.
fn late_growth(left: &Left, mass_ratio: f64) -> f64 {
    let (bar, body) = (
        &left.signals["bar.energy_j"],
        &left.signals["body.energy_j"],
    );
    // Ledgers count from the start: the body came with m v^2 / 2.
    let start = 0.5 * 100.0 * mass_ratio;
    let energy: Vec<f64> = bar.iter().zip(body).map(|(a, b)| start + a + b).collect();
    let largest = |part: &[f64]| part.iter().fold(0.0, |most: f64, e| most.max(*e));
    let quarter = energy.len() / 4;
    let ratio = largest(&energy[3 * quarter..]) / largest(&energy[..quarter]);
    ratio.sqrt().powf(1.0 / (3 * quarter) as f64)
}

fn staggered_blows_up(left: &Left) {
    println!("staggered: growth {:.2} a window", growth(left));
    assert!(growth(left) > 2.0, "growth {}", growth(left));
}

fn default_is_bounded(left: &Left, mass_ratio: f64) {
    println!(
        "default: growth {:.12} a window",
        late_growth(left, mass_ratio)
    );
    assert!(
        late_growth(left, mass_ratio) <= 1.0 + 1e-9,
        "growth {}",
        late_growth(left, mass_ratio)
    );
    assert_eq!(left.number("coupling.not_converged_windows"), 0.0);
}

#[test]
fn staggered_coupling_grows_more_than_twofold_a_window() {
    staggered_blows_up(
        &run_in_process(&scenario("staggered-serial", 1.0, 10, 20), &[])
            .expect("it is valid")
            .completed(),
    );
}

#[test]
fn staggered_coupling_grows_over_shared_memory_too() {
    staggered_blows_up(
        &run_over_shared_memory(&scenario("staggered-serial", 1.0, 10, 20), &[])
            .expect("it is valid")
            .completed(),
    );
}

#[test]
fn the_default_stays_bounded_over_mass_ratios_and_substeps() {
    for mass_ratio in [1e-3, 1.0, 1e3] {
        for substeps in [1, 10, 100] {
            default_is_bounded(
                &run_in_process(&scenario("dual-schur", mass_ratio, substeps, 400), &[])
                    .expect("it is valid")
                    .completed(),
                mass_ratio,
            );
        }
    }
}

#[test]
fn the_default_stays_bounded_over_shared_memory_too() {
    default_is_bounded(
        &run_over_shared_memory(&scenario("dual-schur", 1.0, 10, 400), &[])
            .expect("it is valid")
            .completed(),
        1.0,
    );
}

/// In the staggered grouping of the step a new force acts half a step early, and the compliance can be negative. Coupled, this grouping
/// grows where the synchronised one stays bounded.
#[test]
fn the_staggered_grouping_of_the_continuum_step_is_unstable() {
    let wrong = ["participant.bar.config.grouping=staggered"];
    for substeps in [1, 2] {
        let end = run_in_process(&scenario("dual-schur", 1.0, substeps, 400), &wrong);
        let grown = late_growth(&end.expect("it is valid").completed(), 1.0);
        println!("{substeps} substeps: growth {grown:.9} a window");
        assert!(grown > 1.0 + 1e-5, "{substeps} substeps: growth {grown}");
    }
}
