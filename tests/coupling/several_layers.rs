//! Several layers under one edge of a body, each on its own nodes ("Several layers under one body" of the scenes).
//!
//! Problem: a pressure presses a strip on seven columns of disks, which alone hold it, until all is at rest. Each column is a disk on
//! a rigid floor, a grain and a disk that is glued to the strip; they stand below elements 0, 1, 3, 4, 6, 7 and 9 of ten. In one case they
//! are one layer and one interface, in the other four layers on four interfaces that join the same set of the strip.
//!
//! ```text
//!     | | | | | | | | | |  p
//!    |~~~~~~~~~~~~~~~~~~~|  strip, free base
//!     o o   o o   o o   o   lid, glued to its bottom
//!     O O   O O   O O   O   grains
//!     o o   o o   o o   o   base, rigid
//!      1     2     3    4
//! ```
//!
//! Exact: the columns carry p times the area, and their division into participants does not affect the mechanics. Each point
//! is interpolated between the two nodes of its element, so both cases have the same equations; four layers solve
//! them by block Jacobi to the tolerance of their gaps. Tolerance 1e-7: a gap of 1e-10 of the spacing, 4e-14 m, is 4e-6 N in a contact of
//! 1e8 N/m that carries 57 N.

use harness::runs::{Left, run_both_ways, run_in_process};
use harness::scene::{columns_between, head, interface, layers_between, strip};

const PRESSURE_PA: f64 = 100e6;
const WIDTH_M: f64 = 4e-3;
const THICKNESS_M: f64 = 1e-3;

/// Elements of the strip over the columns of each of four layers.
const FOUR: [&[usize]; 4] = [&[0, 1], &[3, 4], &[6, 7], &[9]];

/// The strip over these layers, joined in windows of this many substeps.
fn scenario(layers: &[&[usize]], substeps: u32) -> String {
    let time = format!(
        "time = {{ step_s = 5e-8, damping = 0.5, mass_damping_per_s = 6e5 }}\nboundary = {{ top = {{ pressure_pa = {PRESSURE_PA:e} }} }}"
    );
    let mut text = head("layers", THICKNESS_M, "end_s = 6e-5");
    text += &strip("rail", ["free", "fixed_x"], 2e-3, &time);
    let keys = "tolerance_rel = 1e-10\nrepeats_max = 60\nmapping = \"linear\"";
    for (index, elements) in layers.iter().enumerate() {
        let (name, set) = (format!("layer-{index}"), format!("layer-{index}.lid"));
        text += &columns_between(&name, elements);
        let between = ["rail.bottom", set.as_str()];
        text += &interface(
            &format!("on-{index}"),
            between,
            "dual-schur",
            substeps,
            keys,
        );
    }
    text
}

fn one() -> Vec<usize> {
    FOUR.concat()
}

fn run(text: &str) -> Left {
    run_in_process(text, &[]).expect("it is valid").completed()
}

#[test]
fn four_layers_carry_the_load_of_one_layer() {
    let whole = run(&scenario(&[&one()], 4));
    let parts = run_both_ways(&scenario(&FOUR, 4), &[]);
    let load = PRESSURE_PA * WIDTH_M * THICKNESS_M;
    for left in [&whole, &parts] {
        let last = left.signals["rail.interface_force_y_n"].last();
        let carried = last.expect("there are windows") / load;
        assert!((carried - 1.0).abs() < 1e-4, "{carried} of the load");
    }
    for name in [
        "rail.interface_force_y_n",
        "rail.surface_mean_uy_m",
        "rail.strain_j",
    ] {
        let (a, b) = (&whole.signals[name], &parts.signals[name]);
        let scale = a.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
        let apart = a.iter().zip(b).map(|(a, b)| (a - b).abs() / scale);
        let apart = apart.fold(0.0, f64::max);
        println!("{name}: {apart:.1e} apart");
        assert!(apart < 1e-7, "{name}: {apart}");
    }
    let repeats = [&whole, &parts].map(|left| left.number("repeats_mean"));
    println!("{repeats:.2?} repeats per window");
    assert_eq!(repeats[0], 1.0, "one layer has all of C in its boundary");
    assert!(repeats[1] > 1.5, "layers feel each other one repeat late");
}

/// A force advances one element per step: layers farther apart than the steps of a window do not interact within it.
#[test]
fn layers_out_of_reach_in_a_window_need_no_repeat() {
    let apart = run(&scenario(&[&[0, 1], &[8, 9]], 4));
    assert_eq!(apart.number("repeats_mean"), 1.0);
    let longer = run(&scenario(&[&[0, 1], &[8, 9]], 8));
    assert!(longer.number("repeats_mean") > 1.0);
}

/// In windows of five times a quarter of its first period the strip follows its layers as a whole: block Jacobi converges for two layers,
/// but not for four.
#[test]
fn two_layers_close_any_window_and_four_do_not() {
    let repeats = run(&scenario(&FOUR[..2], 48)).number("repeats_mean");
    println!("{repeats:.1} repeats per window of two layers");
    let four = run_in_process(&scenario(&FOUR, 48), &[]).expect("it is valid");
    let error = four.ended.error.expect("it diverges").to_string();
    assert!(error.contains("more than two layers"), "{error}");
}

/// Two layers on one clamped strip, as elements, as all modes and as few modes. With few modes the same equilibrium is reached.
#[test]
fn two_layers_may_lie_on_the_modes_of_one_body() {
    let keys = "tolerance_rel = 1e-10\nrepeats_max = 60\nmapping = \"linear\"";
    let scene = |lower: &str| layers_between(lower, keys, 6e-5);
    let elements = run(&scene(""));
    let all = run_both_ways(&scene("reduced = { modes = 1000, near_m = 1.0 }"), &[]);
    let few = run_both_ways(&scene("reduced = { modes = 12 }"), &[]);
    for name in [
        "lower.interface_force_y_n",
        "lower.surface_mean_uy_m",
        "upper.surface_mean_uy_m",
        "lower.strain_j",
    ] {
        let signals = [&elements, &all, &few].map(|left| &left.signals[name]);
        let scale = signals[0]
            .iter()
            .fold(0.0, |most: f64, x| most.max(x.abs()));
        let apart = |k: usize| {
            signals[0]
                .iter()
                .zip(signals[k])
                .map(|(a, b)| (a - b).abs() / scale)
        };
        let (largest, last) = (apart(1).fold(0.0, f64::max), apart(2).next_back());
        let last = last.expect("there are windows");
        println!("{name}: {largest:.1e} apart with all modes, {last:.1e} in the end with few");
        assert!(
            largest < 1e-7 && last < 1e-3,
            "{name}: {largest:e}, {last:e}"
        );
    }
    for left in [&elements, &all, &few] {
        println!("{:.2} repeats", left.number("repeats_mean"));
        // The grains alone miss 0.9e-6.
        assert!(left.number("results.energy_balance_rel") <= 2e-6);
    }
}

#[test]
fn layers_that_share_nodes_and_rows_on_two_bodies_are_refused() {
    let refusal = |text: &str| match run_in_process(text, &[]) {
        Err(error) => error.to_string(),
        Ok(left) => left.ended.error.expect("it must be refused").to_string(),
    };
    let sound = scenario(&[&[0, 1], &[3, 4]], 4);
    let cases = [
        (
            scenario(&[&[0, 1], &[2, 3]], 4),
            "`rail.bottom` is already joined by the interface `on-0`, with the node at (-1.200000e-3, -2.000000e-3) m",
        ),
        (
            sound.replace("layer-1.lid", "layer-0.lid"),
            "`rail.bottom` and `layer-0.lid` are already joined by the interface `on-0`",
        ),
    ];
    for (text, said) in cases {
        let error = refusal(&text);
        assert!(
            error.contains(said) && error.contains("on-"),
            "no {said} in {error}"
        );
    }
}
