//! The other schemes on the added-mass bar and on a plastic one (cases 2 and 9 of the coupling page).
//!
//! Problem: an elastic, or elastic-plastic, bar of 100 elements of 1 kg and 1 N/m with a held left end; a rigid body of the
//! bar's own mass is glued to its right end and starts with 1 m/s towards it.
//!
//! Exact answer: all schemes that converge must give the motion of the default one, since they solve the same window
//! equations, and a scheme that does not converge must report it. Not every scheme has an answer on paper.

use harness::runs::{Left, run_both_ways, run_in_process};
use harness::scene::{bar, body, glue, head};
use scenario::error::Error;

pub(super) fn scenario(scheme: &str, substeps: u32, windows: u32, plastic: bool) -> String {
    let step_s = 0.9;
    let end_s = f64::from(substeps * windows) * step_s;
    let material = match plastic {
        true => "yield_elongation_m = 0.1\nhardening_ratio = 0.05",
        false => "",
    };
    [
        head("schemes", 1.0, ""),
        bar(
            "bar",
            100,
            step_s,
            &format!("left_fixed = true\n{material}"),
        ),
        body(100.0, 100.0, -1.0, &format!("end_s = {end_s:?}")),
        glue(scheme, substeps, "tolerance_rel = 1e-9\nrepeats_max = 40"),
    ]
    .concat()
}

fn run(text: &str, sets: &[&str]) -> Left {
    run_in_process(text, sets).expect("it is valid")
}

/// Largest difference of the interface displacement from another run's, over its largest value.
fn apart(a: &Left, b: &Left) -> f64 {
    let (a, b) = (&a.signals["bar.u_m"], &b.signals["bar.u_m"]);
    assert_eq!(a.len(), b.len());
    let scale = b.iter().fold(0.0, |most: f64, u| most.max(u.abs()));
    a.iter()
        .zip(b)
        .fold(0.0, |most: f64, (a, b)| most.max((a - b).abs()))
        / scale
}

#[test]
fn every_converging_scheme_gives_the_default_motion() {
    let default = run(&scenario("dual-schur", 10, 60, false), &[]).completed();
    let schemes = [
        ("dual-schur-secant", ""),
        ("dual-schur-secant", "interface.glue.compliance=mass"),
        ("fixed-point-serial", "interface.glue.acceleration=iqn-ils"),
        ("fixed-point-serial", "interface.glue.acceleration=aitken"),
        (
            "fixed-point-parallel",
            "interface.glue.acceleration=iqn-ils",
        ),
    ];
    for (scheme, set) in schemes {
        let sets: Vec<&str> = [set, "interface.glue.relaxation=0.05"]
            .into_iter()
            .filter(|s| !s.is_empty())
            .collect();
        let left = run(&scenario(scheme, 10, 60, false), &sets).completed();
        let distance = apart(&left, &default);
        println!(
            "{scheme} {set}: {:.2} repeats, {distance:.1e} apart",
            left.number("repeats_mean")
        );
        assert!(distance < 1e-6, "{scheme} {set}: {distance:.1e} apart");
        assert_eq!(left.number("coupling.not_converged_windows"), 0.0);
    }
}

#[test]
fn the_cheap_scheme_is_bounded_and_reports_its_gap() {
    let left = run(&scenario("dual-schur-cheap", 10, 400, false), &[]).completed();
    let u = &left.signals["bar.u_m"];
    let largest = |part: &[f64]| part.iter().fold(0.0, |most: f64, u| most.max(u.abs()));
    assert!(largest(&u[200..]) <= largest(&u[..200]));
    assert_eq!(left.number("repeats_mean"), 1.0);
    assert!(left.number("coupling.gap_max_rel") > 0.0);
}

#[test]
fn parallel_staggering_grows_as_well() {
    let asked = ["interface.glue.unsafe_window=true"];
    let left = run(&scenario("staggered-parallel", 10, 30, false), &asked).completed();
    let force = &left.signals["interface_fx_n"];
    assert!(
        force[29].abs() > 1e3 * force[2].abs(),
        "{} {}",
        force[2],
        force[29]
    );
}

/// Without relaxation the fixed point of a body as heavy as the bar is repelling: the run must be stopped, not
/// finished wrong.
#[test]
fn a_fixed_point_that_is_not_reached_ends_the_run() {
    let sets = [
        "interface.glue.acceleration=constant",
        "interface.glue.relaxation=1.0",
        "interface.glue.unsafe_window=true",
    ];
    let left = run(&scenario("fixed-point-serial", 10, 60, false), &sets);
    assert!(
        matches!(left.ended.error, Some(Error::NotConverged(_))),
        "{:?}",
        left.ended.error
    );
}

#[test]
fn a_plastic_bar_needs_the_secant_update_and_at_most_five_runs() {
    for substeps in [3, 10, 30] {
        let text = scenario("dual-schur-secant", substeps, 120, true);
        let left = run(&text, &[]).completed();
        let runs = 1.0 + left.number("repeats_mean");
        println!("m = {substeps}: {runs:.2} continuum runs per window");
        assert!(runs <= 5.0, "m = {substeps}: {runs} runs");
        assert!(left.number("coupling.gap_max_rel") <= 1e-9);
    }
    for substeps in [3, 10, 30] {
        let left = run(
            &scenario("dual-schur", substeps, 120, true),
            &["interface.glue.repeats_max=1"],
        );
        let error = left
            .ended
            .error
            .as_ref()
            .expect("the elastic compliance does not fit");
        assert!(matches!(error, Error::NotConverged(_)), "{error}");
        assert!(error.to_string().contains("dual-schur-secant"), "{error}");
    }
}

#[test]
fn a_plastic_bar_over_shared_memory_gives_the_same_bits() {
    let text = scenario("dual-schur-secant", 30, 120, true);
    let left = run_both_ways(&text, &[]);
    assert!(1.0 + left.number("repeats_mean") <= 5.0);
}

#[test]
fn halved_windows_close_the_gap_and_reach_the_end() {
    let halve = [
        "interface.glue.on_not_converged=halve",
        "interface.glue.repeats_max=2",
    ];
    let left = run(&scenario("dual-schur-secant", 30, 60, true), &halve).completed();
    assert!(left.number("coupling.halved_windows") > 0.0);
    assert!(left.number("coupling.gap_max_rel") <= 1e-9);
    let t = &left.signals["t_s"];
    assert!(t.windows(2).all(|pair| pair[1] > pair[0]));
    assert_eq!(t[t.len() - 1], 1800.0 * 0.9);
}

#[test]
fn the_last_window_is_as_short_as_the_end_requires() {
    let end = ["participant.body.config.end_s=58.0"];
    let left = run(&scenario("dual-schur", 10, 60, false), &end).completed();
    // 58 / 0.9 = 64.4: six windows of ten steps and one of five.
    let t = &left.signals["t_s"];
    assert_eq!(t.len(), 7);
    assert!((t[6] - 65.0 * 0.9).abs() < 1e-9);
    assert!(left.number("coupling.gap_max_rel") <= 1e-12);
}
