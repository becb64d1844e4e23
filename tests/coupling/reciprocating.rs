//! `two-rails-reciprocating`, sixteen times as fast: a load on its upper edge presses a free crowned strip on a layer of grains, and the
//! edge moves it to and fro.
//!
//! ```text
//!      P(t)
//!    v v v v v  <-> D(t)
//!   (_________)     its lower face is crowned
//!    o o o o o      grains between glued rows
//!   |~~~~~~~~~|     clamped base
//! ```
//!
//! Exact: Newton for the strip along y: without mass damping only the load and the interface act on it. In a window of m
//! steps under the constant force F of the interface its momentum changes by m h F + h sum [(1-b) P + b P'], and the grains' by the
//! forces on them. The edge stands on D at the end of every window. Its work over a cycle is the area of the loop of its
//! force, since (1-b) r + b r' acts between two ends of steps.
//! Tolerance: 1e-10 of the load, from rounding over some thousand windows; 1e-14 of the amplitude for D; 1 % for the loop, whose
//! curve the windows approximate by chords.

use std::f64::consts::TAU;

use harness::runs::{Left, run_both_ways};

const SCENE: &str = include_str!("../../scenarios/two-rails-reciprocating/scenario.toml");
const STEP: f64 = 3e-8;
const SUBSTEPS: f64 = 10.0;
const DAMPING: f64 = 0.75;
const LOAD: f64 = 1000.0;
const RAMP: f64 = 6e-5;
const START: f64 = 9e-5;
const AMPLITUDE: f64 = 1e-5;
const PERIOD: f64 = 1.2e-4;

fn fast() -> Left {
    let top = format!(
        "participant.upper.config.boundary.top={{ load_table = [[0.0, 0.0], [{RAMP:e}, -{LOAD:?}]], motion = {{ amplitude_m = {AMPLITUDE:e}, frequency_hz = {:?}, start_s = {START:e} }} }}",
        1.0 / PERIOD
    );
    let end = format!(
        "participant.upper.config.time.end_s={:e}",
        START + 2.0 * PERIOD
    );
    let sets = [
        &top,
        &end,
        "participant.upper.config.time.mass_damping_per_s=0.0",
        "participant.upper.config.probes=[{ name = \"edge\", x_m = 1e-3, y_m = 2e-3 }]",
    ];
    run_both_ways(SCENE, &sets)
}

#[test]
fn a_reciprocating_strip_keeps_momentum_and_its_edge_its_course() {
    let left = fast();
    let signal = |name: &str| &left.signals[name];
    let (time, force) = (signal("t_s"), signal("upper.interface_force_y_n"));
    let momentum = signal("upper.momentum_y_kg_m_per_s");
    let load = |t: f64| -LOAD * (t / RAMP).min(1.0);
    let (mut exact, mut worst, mut scale) = (0.0, 0.0_f64, 0.0_f64);
    for (k, t) in time.iter().enumerate() {
        let first = k as f64 * SUBSTEPS;
        let steps = (0..SUBSTEPS as u32).map(|step| {
            let at = |step: f64| load((first + step) * STEP);
            (1.0 - DAMPING) * at(f64::from(step)) + DAMPING * at(f64::from(step) + 1.0)
        });
        let change = STEP * (SUBSTEPS * force[k] + steps.sum::<f64>());
        exact += change;
        worst = worst.max((momentum[k] - exact).abs());
        scale = scale.max(LOAD * t);
        let d = AMPLITUDE * (TAU / PERIOD * (t - START).max(0.0)).sin();
        for edge in ["upper.edge_ux_m", "upper.top_displacement_x_m"] {
            let off = (signal(edge)[k] - d).abs();
            assert!(
                off <= 1e-14 * AMPLITUDE,
                "{edge}, t = {t:e}: off by {off:e}"
            );
        }
    }
    assert!(worst <= 1e-10 * scale, "{worst:e} of {scale:e} N s");
    let grains = signal("third-body.momentum_defect_n").iter();
    let grains = grains.fold(0.0, |most: f64, defect| most.max(defect.abs()));
    assert!(grains <= 1e-10 * LOAD, "{grains:e} N");

    // The last cycle: from one window to the next the force is the mean of its ends.
    let (u, r) = (signal("upper.edge_ux_m"), signal("upper.top_reaction_x_n"));
    let begin = time.len() - (PERIOD / (SUBSTEPS * STEP)).round() as usize - 1;
    let chords = (begin..time.len() - 1).map(|k| 0.5 * (r[k] + r[k + 1]) * (u[k + 1] - u[k]));
    let (area, work) = (chords.sum::<f64>(), signal("upper.drive_work_j"));
    let work = work[time.len() - 1] - work[begin];
    println!(
        "loop of {work:.4e} J, friction up to {:.3}",
        r.iter().fold(0.0, |m: f64, r| m.max(r.abs())) / LOAD
    );
    assert!(
        work > 0.0 && (area / work - 1.0).abs() < 1e-2,
        "{area:e} {work:e}"
    );

    assert_eq!(left.number("coupling.not_converged_windows"), 0.0);
    for name in ["below", "above"] {
        let of = |key: &str| left.number(&format!("interfaces.{name}.{key}"));
        assert!(of("energy_defect_rel") <= 1e-12 && of("force_residual_rel") <= 1e-14);
        assert!(of("gap_max_rel") <= 1e-5);
    }
}
