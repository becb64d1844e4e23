//! The continuum follows the wall (`dirichlet = "continuum"`).
//!
//! Problem: the bar and body of [`super::schemes`], the three pieces and the two walls of [`super::several`], the static patch of
//! [`super::static_patch`], and a bar of ten elements with a body of a thousandth or a thousand times its mass.
//!
//! Exact answer: scheme `velocity` for points that have the declared masses in their own equations, or for a bar whose end is
//! heavier by these masses: the same window equations, to the tolerance of the gap. A fixed point with constant
//! relaxation omega converges below omega (1 + 1 / (C S)) = 2 (Causin, Gerbeau and Nobile 2005 with the roles swapped); with
//! the other roles it converges below omega (1 + C S) = 2.

use harness::runs::{Left, run_both_ways, run_in_process};
use harness::scene::{bar, body, glue, head};
use scenario::error::Error;

use super::{schemes, several, static_patch};

const SWAPPED: &str = "interface.glue.dirichlet=continuum";

fn run(text: &str, sets: &[&str]) -> Left {
    run_in_process(text, sets).expect("it is valid")
}

/// Largest difference of a signal from another run's, over its largest value.
fn apart(a: &Left, b: &Left, signal: &str) -> f64 {
    let (a, b) = (&a.signals[signal], &b.signals[signal]);
    assert_eq!(a.len(), b.len());
    let scale = b.iter().fold(0.0, |most: f64, u| most.max(u.abs()));
    let pairs = a.iter().zip(b);
    pairs.fold(0.0, |most: f64, (a, b)| most.max((a - b).abs())) / scale
}

/// A bar of 100 elements and a chain of 20 masses behind a point. The pulse of the bar pushes the chain.
fn with_chain(scheme: &str, own_kg: f64, point_kg: f64, theta: f64, bar_keys: &str) -> String {
    let pulse = "pulse = { centre_m = 50.0, width_m = 10.0 }";
    let masses = format!("glued_mass_kg = {own_kg:?}\npoint_mass_kg = {point_kg:?}");
    let keys = format!("{masses}\ntheta = {theta:?}\nend_s = 120.0");
    [
        head("roles", 1.0, ""),
        bar("bar", 100, 0.9, &format!("{pulse}\n{bar_keys}")),
        harness::scene::chain("body", 100.0, 20, &keys),
        glue(scheme, 5, "tolerance_rel = 1e-12\nrepeats_max = 400"),
    ]
    .concat()
}

/// Ways to the same fixed point; the last one converges only where a repeat contracts.
const WAYS: [(&str, &str); 4] = [
    ("fixed-point-serial", "iqn-ils"),
    ("fixed-point-parallel", "iqn-ils"),
    ("fixed-point-serial", "aitken"),
    ("fixed-point-serial", "constant"),
];

#[test]
fn every_acceleration_gives_the_motion_of_scheme_velocity_with_heavier_points() {
    for theta in [1.0, 0.5] {
        let exact = run(&with_chain("velocity", 3.0, 0.0, theta, ""), &[]).completed();
        let heavier = with_chain("velocity", 0.0, 0.0, theta, "end_mass_kg = 3.0");
        let heavier = run(&heavier, &[]).completed();
        assert!(apart(&heavier, &exact, "bar.u_m") <= 1e-9);
        for own_kg in [0.0, 2.0] {
            for (scheme, acceleration) in WAYS {
                let text = with_chain(scheme, own_kg, 3.0 - own_kg, theta, "");
                let acceleration = format!("interface.glue.acceleration={acceleration}");
                let sets = [SWAPPED, &acceleration, "interface.glue.relaxation=0.6"];
                let left = run(&text, &sets).completed();
                let distances = ["bar.u_m", "bar.v_m_per_s", "body.far_m"]
                    .map(|signal| apart(&left, &exact, signal));
                let repeats = left.number("repeats_mean");
                println!(
                    "theta {theta}, {scheme} {acceleration}: {repeats:.1} repeats, {distances:?} apart"
                );
                assert!(distances.into_iter().all(|distance| distance <= 1e-9));
                assert!(left.number("coupling.gap_max_rel") <= 1e-12);
                assert!(left.number("coupling.force_residual_rel") <= 1e-9);
            }
        }
    }
}

/// The force on the continuum includes the inertia of the points: its momentum and the work at the interface are the
/// same as with `velocity` and heavier points.
#[test]
fn the_ledger_equals_the_ledger_of_velocity_with_heavier_points() {
    let exact = run(&with_chain("velocity", 3.0, 0.0, 1.0, ""), &[]).completed();
    let left = run(
        &with_chain("fixed-point-serial", 0.0, 3.0, 1.0, ""),
        &[SWAPPED],
    )
    .completed();
    assert!(apart(&left, &exact, "interface_fx_n") <= 1e-9);
    let defect = [&left, &exact].map(|left| left.number("coupling.energy_defect_rel"));
    assert!((defect[0] / defect[1] - 1.0).abs() <= 1e-6, "{defect:?}");
}

/// Many nodes, points between them, edges that are held sideways.
#[test]
fn a_row_of_points_moves_as_with_scheme_velocity_and_heavier_points() {
    for substeps in [1, 10] {
        let heavier = static_patch::scenario(substeps, 23)
            .replace("scheme = \"dual-schur\"", "scheme = \"velocity\"")
            .replace("mass_kg = 1e-5", "mass_kg = 3e-5");
        let declared_masses = format!("mass_kg = 1e-5\npoint_mass_kg = {:?}", [2e-5 / 23.0; 23]);
        let swapped = static_patch::scenario(substeps, 23)
            .replace(
                "scheme = \"dual-schur\"",
                "scheme = \"fixed-point-serial\"\ndirichlet = \"continuum\"\nrepeats_max = 60",
            )
            .replace("mass_kg = 1e-5", &declared_masses);
        let exact = run(&heavier, &[]).completed();
        let left = run(&swapped, &["interface.glue.tolerance_rel=1e-11"]).completed();
        for signal in ["interface_fy_n", "strip.surface_mean_uy_m"] {
            let distance = apart(&left, &exact, signal);
            println!(
                "m = {substeps}, {signal}: {distance:.1e} apart, {:.1} repeats",
                left.number("repeats_mean")
            );
            assert!(distance <= 1e-7, "m = {substeps}, {signal}: {distance:e}");
        }
        // The row accounts for its kinetic energy and the loss of implicit Euler; the coupler does so for the declared masses.
        let balance = [&left, &exact].map(|left| left.number("results.energy_balance_rel"));
        println!("m = {substeps}: energy balance {balance:?}");
        assert!((balance[0] / balance[1] - 1.0).abs() <= 1e-5, "{balance:?}");
    }
}

fn ratio(mass_ratio: f64, substeps: u32, keys: &str) -> String {
    let end_s = 0.9 * f64::from(40 * substeps);
    let point_kg = 0.1 * mass_ratio;
    let keys = format!(
        "tolerance_rel = 1e-9\nrepeats_max = 100\nacceleration = \"constant\"\nrelaxation = 0.5\n{keys}"
    );
    [
        head("ratio", 1.0, ""),
        bar("bar", 10, 0.9, "left_fixed = true"),
        body(
            10.0,
            9.9 * mass_ratio,
            1.0,
            &format!("point_mass_kg = {point_kg:?}\nend_s = {end_s:?}"),
        ),
        glue("fixed-point-serial", substeps, &keys),
    ]
    .concat()
}

#[test]
fn the_continuum_follows_a_heavy_wall_and_a_light_wall_follows_the_continuum() {
    let unsafe_window = "interface.glue.unsafe_window=true";
    for (mass_ratio, dirichlet, other) in [(1e3, "continuum", "wall"), (1e-3, "wall", "continuum")]
    {
        let text = ratio(mass_ratio, 10, "");
        let [dirichlet, other] =
            [dirichlet, other].map(|side| format!("interface.glue.dirichlet={side}"));
        let left = run(&text, &[&dirichlet]).completed();
        println!("{mass_ratio}: {} repeats", left.number("repeats_mean"));
        assert!(left.number("coupling.gap_max_rel") <= 1e-9);
        let refused = run(&text, &[&other]).ended.error.expect("it is predicted");
        assert!(matches!(refused, Error::Refused(_)), "{refused}");
        assert!(refused.to_string().contains("added mass"), "{refused}");
        let found = run(&text, &[&other, unsafe_window])
            .ended
            .error
            .expect("it does not contract");
        assert_eq!(found.exit_code(), 3, "{found}");
    }
}

/// One pass per window, one window late: the motion stays bounded with a heavy wall, and grows with a light one.
#[test]
fn staggered_windows_are_bounded_for_a_heavy_wall_and_grow_for_a_light_one() {
    for scheme in ["staggered-serial", "staggered-parallel"] {
        let grown = |mass_ratio: f64| {
            let text =
                ratio(mass_ratio, 10, "unsafe_window = true").replace("fixed-point-serial", scheme);
            let left = run(&text, &[SWAPPED]);
            let u = &left.signals["bar.u_m"];
            let largest = |part: &[f64]| part.iter().fold(0.0, |most: f64, u| most.max(u.abs()));
            largest(&u[20..]) / largest(&u[..20])
        };
        let (heavy, light) = (grown(1e3), grown(1e-2));
        println!("{scheme}: {heavy:.2}, {light:.2e}");
        assert!(heavy < 3.0, "{scheme}: {heavy}");
        assert!(light > 1e3 || light.is_nan(), "{scheme}: {light}");
    }
}

fn swapped(text: String) -> String {
    let found = text.replace(
        "scheme = \"fixed-point-serial\"",
        "scheme = \"fixed-point-serial\"\ndirichlet = \"continuum\"",
    );
    assert_ne!(found, text);
    found
}

#[test]
fn two_bars_with_a_chain_between_them_and_two_chains_on_a_bar() {
    let exact = run(
        &several::three("velocity", 1.0, [0.9, 0.3], [4, 12])
            .replace("glued_mass_kg = 0.0", "glued_mass_kg = 0.7")
            .replace("far_mass_kg = 0.0", "far_mass_kg = 0.7"),
        &[],
    );
    let exact = exact.completed();
    let text = several::three("fixed-point-serial", 1.0, [0.9, 0.3], [4, 12]);
    let text = swapped(text).replace("glued_mass_kg", "point_mass_kg = 0.7\nglued_mass_kg");
    let left = run(&text, &[]).completed();
    for signal in ["left.u_m", "right.start_u_m"] {
        let distance = apart(&left, &exact, signal);
        assert!(distance <= 1e-8, "{signal}: {distance:e}");
    }
    let exact =
        several::two_walls("velocity").replace("glued_mass_kg = 0.0", "glued_mass_kg = 0.7");
    let exact = run(&exact.replace("repeats_max = 60", "repeats_max = 200"), &[]).completed();
    let text = swapped(several::two_walls("fixed-point-serial"))
        .replace("glued_mass_kg", "point_mass_kg = 0.7\nglued_mass_kg");
    let left = run(&text, &[]).completed();
    let distance = apart(&left, &exact, "above.interface_fx_n");
    println!(
        "two walls: {distance:.1e} apart, {:.1} repeats",
        left.number("repeats_mean")
    );
    assert!(distance <= 1e-7, "{distance:e}");
}

#[test]
fn shared_memory_gives_the_same_bits() {
    for scheme in [
        "fixed-point-serial",
        "fixed-point-parallel",
        "staggered-serial",
    ] {
        let text = with_chain(scheme, 0.0, 3.0, 1.0, "");
        let sets = [SWAPPED, "interface.glue.unsafe_window=true"];
        run_both_ways(&text, &sets);
    }
}

#[test]
fn windows_are_halved_and_the_last_one_is_short() {
    let sets = [
        "interface.glue.on_not_converged=halve",
        "participant.bar.config.nan_above_substeps=5",
        "participant.body.config.end_s=58.0",
        "participant.body.config.point_mass_kg=1.0",
        SWAPPED,
    ];
    let text = schemes::scenario("fixed-point-serial", 10, 60, false);
    let left = run(&text, &sets).completed();
    assert!(left.number("coupling.halved_windows") > 0.0);
    assert!(left.number("coupling.gap_max_rel") <= 1e-9);
    let t = &left.signals["t_s"];
    assert!((t[t.len() - 1] - 65.0 * 0.9).abs() < 1e-9);
}

#[test]
fn roles_that_cannot_be_swapped_are_refused_by_name() {
    let text = schemes::scenario("fixed-point-serial", 10, 60, false);
    let weighs = "participant.body.config.point_mass_kg=1.0";
    let refused = |text: &str, sets: &[&str], said: &[&str]| {
        let error = match run_in_process(text, sets) {
            Err(error) => error,
            Ok(left) => left.ended.error.expect("it must be refused"),
        };
        assert_eq!(error.exit_code(), 2, "{error}");
        for said in said {
            assert!(error.to_string().contains(said), "no {said} in {error}");
        }
    };
    for scheme in [
        "dual-schur",
        "dual-schur-secant",
        "dual-schur-cheap",
        "velocity",
    ] {
        let other = schemes::scenario(scheme, 10, 60, false);
        refused(&other, &[SWAPPED, weighs], &["dirichlet", "both sides"]);
    }
    refused(
        &text,
        &[SWAPPED],
        &["interface.glue.dirichlet", "`body`", "`end`", "masses"],
    );
    let zero = "participant.body.config.point_mass_kg=0.0";
    refused(
        &text,
        &[SWAPPED, zero],
        &["interface.glue.dirichlet", "`body`", "0e0 kg"],
    );
    let staggered = "participant.bar.config.grouping=staggered";
    refused(
        &text,
        &[SWAPPED, weighs, staggered],
        &["interface.glue.dirichlet", "`bar`"],
    );
    let few = static_patch::scenario(10, 3)
        .replace("\"dual-schur\"", "\"fixed-point-serial\"")
        .replace(
            "mass_kg = 1e-5",
            "mass_kg = 1e-5\npoint_mass_kg = [1e-5, 1e-5, 1e-5]",
        );
    refused(
        &few,
        &[SWAPPED],
        &["interface.glue.dirichlet", "node at (", "3 points", "nodes"],
    );
    let two = several::three("fixed-point-serial", 1.0, [0.9, 0.9], [4, 4]);
    let one = "interface.lower.dirichlet=continuum";
    refused(&two, &[one], &["dirichlet", "`lower`"]);
}
