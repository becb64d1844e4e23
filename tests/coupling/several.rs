//! Several interfaces and participants ("Two FE bodies and a sheared layer" of the coupling page).
//!
//! Problem: a uniform elastic lattice (spacing 1 m, masses 1 kg, springs 1 N/m, wave speed 1 m/s) in three pieces: an
//! explicit bar, a chain that takes one implicit step per window and is glued at both ends, and a second explicit bar. A
//! pulse exp(-((x - 50) / 10)^2) m travels right through both joints.
//!
//! ```text
//!   |~ left bar, 100 elements ~|o-o- chain, 60 springs -o-o|~ right bar, 100 elements ~|
//!             pulse -->       x = 100                    x = 160
//! ```
//!
//! Exact answer: the lattice in one piece (the nodes at the joints keep the half mass of their one element, since a glued
//! point has no mass), integrated with 1/90 of the coarsest step. At theta = 0.5 the far joint, which the pulse reaches
//! through the chain, converges with the chain's second order; the near one with the order 1.5 of the split bar. Exact for
//! any window are the momentum (to rounding), the closed gap (1e-12), and one repeat per window, since C is block-diagonal
//! and known.

use harness::lattice::Lattice;
use harness::runs::{Left, run_both_ways, run_in_process};
use harness::scene::{bar, chain, head, interface};
use scenario::error::Error;

const END_S: f64 = 180.0;

const PULSE: &str = "pulse = { centre_m = 50.0, width_m = 10.0 }";

/// A bar of 100 elements with its left end at `x_m`.
fn long_bar(name: &str, x_m: f64, step_s: f64, keys: &str) -> String {
    bar(name, 100, step_s, &format!("x_m = {x_m:?}\n{keys}"))
}

/// Sixty masses between glued points without mass; the far end has the mass of the others unless it is glued.
fn middle(name: &str, x_m: f64, theta: f64, keys: &str) -> String {
    let keys = format!("glued_mass_kg = 0.0\ntheta = {theta:?}\nend_s = {END_S:?}\n{keys}");
    chain(name, x_m, 60, &keys)
}

const FAR: &str = "far_mass_kg = 0.0";
const TOLERANCE: &str = "tolerance_rel = 1e-11\nrepeats_max = 60";

/// Bar, chain, bar; the steps of both bars and the substeps of both interfaces.
pub(super) fn three(scheme: &str, theta: f64, steps_s: [f64; 2], substeps: [u32; 2]) -> String {
    let lower = ["left.end", "middle.end"];
    let upper = ["middle.far", "right.start"];
    [
        head("three", 1.0, ""),
        long_bar("left", 0.0, steps_s[0], PULSE),
        middle("middle", 100.0, theta, FAR),
        long_bar("right", 160.0, steps_s[1], ""),
        interface("lower", lower, scheme, substeps[0], TOLERANCE),
        interface("upper", upper, scheme, substeps[1], TOLERANCE),
    ]
    .concat()
}

pub(super) fn run(text: &str) -> Left {
    run_in_process(text, &[]).expect("it is valid").completed()
}

/// Displacements of both joints of the whole lattice at these times.
fn monolithic(times: &[f64]) -> Vec<[f64; 2]> {
    let lattice = Lattice {
        nodes: 261,
        halves: &[0, 100, 160, 260],
        at_rest: 101,
        step_s: 0.01,
    };
    lattice.displacements([100, 160], times)
}

/// Relative L2 errors over time of the displacements of both joints.
pub(super) fn errors(left: &Left) -> [f64; 2] {
    let exact = monolithic(&left.signals["t_s"]);
    let found = [&left.signals["left.u_m"], &left.signals["right.start_u_m"]];
    [0, 1].map(|joint| {
        let square = |values: &mut dyn Iterator<Item = f64>| values.map(|v| v * v).sum::<f64>();
        let pairs = found[joint].iter().zip(&exact);
        let difference = square(&mut pairs.map(|(a, b)| a - b[joint]));
        (difference / square(&mut exact.iter().map(|b| b[joint]))).sqrt()
    })
}

fn gap_and_balance_are_exact(left: &Left) {
    for name in ["lower", "upper"] {
        let gap = left.number(&format!("interfaces.{name}.gap_max_rel"));
        let defect = left.number(&format!("interfaces.{name}.energy_defect_rel"));
        let residual = left.number(&format!("interfaces.{name}.force_residual_rel"));
        assert!(gap <= 1e-12, "{name}: gap {gap}");
        assert!(defect <= 1e-11, "{name}: defect {defect}");
        assert!(residual <= 1e-12, "{name}: residual {residual}");
    }
    let momentum = ["left", "middle", "right"]
        .map(|name| left.signals[&format!("{name}.momentum_kg_m_per_s")].clone());
    let total = |i: usize| momentum.iter().map(|m| m[i]).sum::<f64>();
    for i in 0..momentum[0].len() {
        assert!(
            (total(i) - total(0)).abs() <= 1e-12,
            "momentum {}",
            total(i)
        );
    }
    assert_eq!(left.number("repeats_mean"), 1.0);
}

#[test]
fn two_bars_with_a_chain_between_them_are_the_lattice_in_one_piece() {
    let mut last: Option<[f64; 2]> = None;
    for (substeps, step_s) in [(4, 0.9), (4, 0.45), (4, 0.225)] {
        let left = run(&three("dual-schur", 0.5, [step_s; 2], [substeps; 2]));
        gap_and_balance_are_exact(&left);
        let errors = errors(&left);
        println!("H = {:.2} s: errors {errors:.3?}", 4.0 * step_s);
        if let Some(last) = last {
            let orders = [0, 1].map(|joint: usize| (last[joint] / errors[joint]).log2());
            println!("orders {orders:.2?}");
            assert!(orders[0] > 1.4 && orders[1] > 1.8, "orders {orders:?}");
        }
        last = Some(errors);
    }
}

#[test]
fn implicit_euler_between_two_bars_never_adds_energy() {
    for (steps_s, substeps) in [([0.9, 0.9], [10, 10]), ([0.9, 0.3], [10, 30])] {
        let left = run(&three("dual-schur", 1.0, steps_s, substeps));
        gap_and_balance_are_exact(&left);
        let sides = ["left.energy_j", "middle.energy_j", "right.energy_j"];
        let energy = |i: usize| sides.iter().map(|side| left.signals[*side][i]).sum::<f64>();
        for i in 1..left.signals["t_s"].len() {
            assert!(energy(i) <= energy(i - 1) + 1e-12, "energy rose at row {i}");
        }
        assert!(
            left.number("results.energy_balance_rel") > 0.1,
            "theta = 1 dissipates"
        );
    }
}

/// The right bar takes three steps to each of the left one's; both meet at every window.
#[test]
fn connected_bars_may_have_steps_of_their_own() {
    let equal = run(&three("dual-schur", 0.5, [0.9, 0.9], [4, 4]));
    let other = run(&three("dual-schur", 0.5, [0.9, 0.3], [4, 12]));
    gap_and_balance_are_exact(&other);
    assert_eq!(equal.signals["t_s"], other.signals["t_s"]);
    assert_eq!(
        other.number("participants.right.steps"),
        3.0 * equal.number("participants.right.steps")
    );
    let (equal, other) = (errors(&equal), errors(&other));
    println!("errors {equal:.3?} with equal steps, {other:.3?} with a third of the step");
    // The error comes from the chain's own step.
    assert!(other[1] < 1.2 * equal[1]);
}

#[test]
fn shared_memory_gives_the_same_bits() {
    run_both_ways(&three("dual-schur", 1.0, [0.9, 0.9], [10, 10]), &[]);
}

#[test]
fn fixed_points_of_a_group_give_the_default_motion() {
    let default = run(&three("dual-schur", 1.0, [0.9, 0.9], [4, 4]));
    for scheme in [
        "fixed-point-serial",
        "fixed-point-parallel",
        "dual-schur-secant",
    ] {
        let left = run(&three(scheme, 1.0, [0.9, 0.9], [4, 4]));
        for signal in ["left.u_m", "right.start_u_m"] {
            let (a, b) = (&left.signals[signal], &default.signals[signal]);
            assert_eq!(a.len(), b.len());
            for (a, b) in a.iter().zip(b) {
                assert!((a - b).abs() <= 1e-9, "{scheme}, {signal}: {a} and {b}");
            }
        }
    }
}

/// Two pairs that share no participant, each with its own window, move exactly as without the other pair.
#[test]
fn separate_pairs_do_not_affect_each_other() {
    let pair = |bar_name: &str, chain_name: &str, joint: &str, substeps: u32| {
        let ends = [format!("{bar_name}.end"), format!("{chain_name}.end")];
        let participants = [
            long_bar(bar_name, 0.0, 0.9, PULSE),
            middle(chain_name, 100.0, 1.0, ""),
        ];
        let between = [ends[0].as_str(), ends[1].as_str()];
        let joined = interface(joint, between, "dual-schur", substeps, TOLERANCE);
        (participants.concat(), joined)
    };
    let head: &str = &head("pairs", 1.0, "");
    let (first, second) = (pair("a", "b", "one", 10), pair("c", "d", "two", 4));
    let alone = run(&[head, &first.0, &first.1].concat());
    let both = run(&[head, &first.0, &second.0, &first.1, &second.1].concat());
    let other = run(&[head, &second.0, &second.1].concat());
    assert_eq!(
        both.number("windows"),
        alone.number("windows") + other.number("windows")
    );
    let at = |left: &Left, time: f64, signal: &str| {
        let row = left.signals["t_s"]
            .iter()
            .position(|t| (t - time).abs() < 1e-9);
        left.signals[signal][row.expect("both have a window that ends there")]
    };
    for time in [36.0, 72.0, 180.0] {
        assert_eq!(at(&both, time, "a.u_m"), at(&alone, time, "a.u_m"));
        assert_eq!(at(&both, time, "d.q_m"), at(&other, time, "d.q_m"));
    }
    assert!(both.signals["t_s"].windows(2).all(|pair| pair[1] > pair[0]));
}

/// A short bar with a chain glued to each end.
pub(super) fn two_walls(scheme: &str) -> String {
    let above = ["bar.end", "up.end"];
    let below = ["bar.start", "down.end"];
    [
        head("walls", 1.0, ""),
        bar("bar", 4, 0.9, "velocity_m_per_s = 1.0"),
        middle("up", 4.0, 1.0, ""),
        middle("down", 0.0, 1.0, ""),
        interface("above", above, scheme, 10, TOLERANCE),
        interface("below", below, scheme, 10, TOLERANCE),
    ]
    .concat()
}

/// One bar with a chain glued to each end: two walls on one continuum. A wave crosses the bar within a window, so each wall
/// feels the other, and repeats are needed.
#[test]
fn two_walls_on_one_bar_close_both_gaps() {
    let text = two_walls("dual-schur");
    let left = run(&text);
    let repeats = left.number("repeats_mean");
    println!("{repeats:.1} repeats per window");
    assert!(repeats > 1.5, "the walls feel each other: {repeats}");
    for name in ["above", "below"] {
        let gap = left.number(&format!("interfaces.{name}.gap_max_rel"));
        assert!(gap <= 1e-11, "{name}: {gap}");
    }
    // The problem is symmetric.
    let (above, below) = (
        &left.signals["above.interface_fx_n"],
        &left.signals["below.interface_fx_n"],
    );
    for (a, b) in above.iter().zip(below) {
        assert!((a - b).abs() <= 1e-10, "{a} and {b}");
    }
}

#[test]
fn a_group_is_halved_as_one() {
    let soft = format!("{PULSE}\nyield_elongation_m = 0.02\nhardening_ratio = 0.05");
    let text = three("dual-schur-secant", 1.0, [0.9, 0.3], [20, 60])
        .replace(PULSE, &soft)
        .replace(
            "repeats_max = 60",
            "repeats_max = 2\non_not_converged = \"halve\"",
        );
    let left = run(&text);
    let halved = left.number("coupling.halved_windows");
    assert!(halved > 0.0);
    for name in ["lower", "upper"] {
        assert_eq!(
            left.number(&format!("interfaces.{name}.halved_windows")),
            halved
        );
        assert!(left.number(&format!("interfaces.{name}.gap_max_rel")) <= 1e-11);
    }
    let t = &left.signals["t_s"];
    assert!((t[t.len() - 1] - END_S).abs() < 1e-9);
}

fn refusal(text: &str) -> String {
    match run_in_process(text, &[]) {
        Err(error) => error.to_string(),
        Ok(left) => {
            let error = left.ended.error.expect("it must be refused");
            assert!(matches!(error, Error::Refused(_)), "{error}");
            error.to_string()
        }
    }
}

#[test]
fn connected_windows_that_differ_are_refused_by_name() {
    let text = refusal(&three("dual-schur", 1.0, [0.9, 0.9], [10, 9]));
    for word in ["`lower`", "`upper`", "10 x", "9 x", "substeps"] {
        assert!(text.contains(word), "no {word} in {text}");
    }
}

#[test]
fn interfaces_that_contradict_each_other_are_refused_by_key() {
    let sound = three("dual-schur", 1.0, [0.9, 0.9], [10, 10]);
    let cases = [
        (
            sound.replacen("\"dual-schur\"", "\"staggered-serial\"", 1),
            "scheme",
        ),
        (
            sound.replacen("repeats_max = 60", "repeats_max = 6", 1),
            "repeats_max",
        ),
        (sound.replace("\"upper\"", "\"lower\""), "is taken"),
        (sound.replace("middle.far", "middle.end"), "already"),
        (sound.replace("right.start", "middle.far"), "itself"),
    ];
    for (text, word) in cases {
        assert_ne!(text, sound);
        let error = refusal(&text);
        assert!(error.contains(word), "no {word} in {error}");
    }
    let lonely = [sound, long_bar("fourth", 0.0, 0.9, "")].concat();
    assert!(refusal(&lonely).contains("no interface joins `fourth`"));
}

/// The left bar answers first and cannot answer windows of ten steps. The right bar's answer meanwhile belongs to the abandoned
/// window, not to its halves.
#[test]
fn one_bar_that_is_not_finite_halves_the_windows_of_all() {
    let steps_s = [0.9, 0.9];
    let halves = [
        "participant.left.config.nan_above_substeps=5",
        "interface.lower.on_not_converged=halve",
        "interface.upper.on_not_converged=halve",
    ];
    let whole = three("dual-schur", 1.0, steps_s, [10, 10]);
    let halved = run_in_process(&whole, &halves).expect("it is valid");
    let halved = halved.completed();
    let short = run(&three("dual-schur", 1.0, steps_s, [5, 5]));
    assert_eq!(halved.number("coupling.halved_windows"), 20.0);
    for name in ["left.u_m", "right.start_u_m"] {
        let (a, b) = (&halved.signals[name], &short.signals[name]);
        assert_eq!(a.len(), b.len());
        let apart = a.iter().zip(b).map(|(a, b)| (a - b).abs());
        assert!(apart.fold(0.0, f64::max) <= 1e-12, "{name}");
    }
}
