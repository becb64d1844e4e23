//! Histories by hand: quantities that are linear in time are exact for any steps.

use dem_kernel::step::state::WheelState;

use super::*;

/// A step of a history: height of the wheel (m), force on it (N), work of its drive since the start (J).
#[derive(Default)]
struct Step {
    height: f64,
    force: [f64; 2],
    work: f64,
}

/// Period 10 ms, motion from 2 ms on.
fn program(cycles: f64) -> WheelProgram {
    WheelProgram {
        load_n: 1.0,
        load_table: None,
        ramp_s: 1e-3,
        hold_s: 1e-3,
        amplitude_m: 1e-4,
        frequency_hz: 100.0,
        cycles,
        rolling: None,
    }
}

/// The cycles of a number of steps, each from its number, from 1 on, and the time at its end.
fn cycles(cycles: f64, length: f64, steps: u32, step: impl Fn(u32, f64) -> Step) -> WheelCycles {
    let mut all = WheelCycles::new(step(0, 0.0).height, 1e-3);
    for number in 1..=steps {
        let [start, end] = [number - 1, number].map(|n| f64::from(n) * length);
        let Step {
            height,
            force,
            work,
        } = step(number, end);
        let mut state = GrainState {
            wheel: WheelState {
                position: [0.0, height],
                velocity: [0.0; 2],
                turn: 0.0,
            },
            ..GrainState::default()
        };
        state.ledger.drive = work;
        let summary = StepSummary {
            on_wheel: force,
            ..StepSummary::default()
        };
        let grains = (&Bodies::default(), &state, &summary);
        all.record(&program(cycles), [start, end], grains, &[], None);
    }
    all
}

fn result(cycles: &WheelCycles, name: &str) -> f64 {
    let results = cycles.results(false);
    let found = results.iter().find(|(known, _)| *known == name);
    found.unwrap_or_else(|| panic!("there is no {name}")).1
}

fn close(value: f64, expected: f64) {
    assert!(
        (value - expected).abs() <= 1e-11 * expected.abs(),
        "{value:e} instead of {expected:e}"
    );
}

/// Steps of 0.3 ms end neither at the end of a cycle nor where the wheel passes D = 0. T falls from 5 N at t_s by 0.4 N/ms: 3 N and 1 N in the middle
/// and at the end of the first cycle, -1 N and -3 N in the second. N is 4 |T|, but 0 in each third step.
#[test]
fn a_straight_history_is_exact_between_the_ends_of_steps() {
    let history = |number: u32, t: f64| {
        let tangential = 5.0 - 400.0 * (t - 2e-3);
        let pressed = f64::from(u8::from(!number.is_multiple_of(3)));
        Step {
            height: 1.0 - 0.3 * t,
            force: [tangential, 4.0 * pressed * tangential.abs()],
            work: 7.0 * t,
        }
    };
    let all = cycles(2.5, 3e-4, 90, history);
    for (name, expected) in [
        ("full_cycles", 2.0),
        ("cycle_sink_m", 3e-3),
        ("all_cycles_sink_m", 6e-3),
        ("loop_area_j", 0.07),
        ("all_cycles_work_j", 0.14),
        ("cycle_tangential_at_zero_n", 2.0),
        ("all_cycles_tangential_at_zero_n", 2.0),
        ("cycle_traction_ratio", 0.25),
        ("all_cycles_traction_ratio", 0.25),
    ] {
        close(result(&all, name), expected);
    }
    assert_eq!(all.results(false).len(), 14, "no flows are followed");
}

/// Steps of 0.25 ms: 40 a cycle, and 8 before the first. The wheel sinks by 1 um a step, rises by 2, and sinks by 50.
#[test]
fn each_cycle_has_its_own_numbers_and_a_cut_cycle_has_none() {
    let done = |number: u32| [8, 48, 88].map(|start| number.clamp(start, start + 40) - start);
    let history = |number: u32, _: f64| {
        let [first, second, third] = done(number).map(f64::from);
        let ratio = if number <= 48 { 0.25 } else { -0.5 };
        Step {
            height: 1e-6 * (2.0 * second - first - 50.0 * third),
            force: [8.0 * ratio, 8.0],
            work: 3.0 * first + 5.0 * second + 100.0 * third,
        }
    };
    let all = cycles(3.0, 2.5e-4, 127, history);
    for (name, expected) in [
        ("full_cycles", 2.0),
        ("cycle_sink_m", -80e-6),
        ("all_cycles_sink_m", -40e-6),
        ("loop_area_j", 200.0),
        ("all_cycles_work_j", 320.0),
        ("cycle_tangential_at_zero_n", 4.0),
        ("all_cycles_tangential_at_zero_n", 3.0),
        ("cycle_traction_ratio", 0.5),
        ("all_cycles_traction_ratio", 0.375),
        ("all_cycles_friction_coefficient", 0.375),
    ] {
        close(result(&all, name), expected);
    }
    let text = all.csv(false).expect("there are cycles");
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(
        lines[0],
        "cycle,t0_s,t1_s,sink_m,work_j,tangential_at_zero_n,traction_ratio,slip_amplitude_m,accommodated_by_body_m,p0_1mm_pa"
    );
    let rows: Vec<Vec<f64>> = lines[1..]
        .iter()
        .map(|line| {
            line.split(',')
                .map(|x| x.parse().expect("a number"))
                .collect()
        })
        .collect();
    let expected = [
        [1.0, 2e-3, 12e-3, 40e-6, 120.0, 2.0, 0.25],
        [2.0, 12e-3, 22e-3, -80e-6, 200.0, 4.0, 0.5],
    ];
    assert_eq!(rows.len(), 2);
    // Other tests check the last columns.
    let rows = [0, 1].map(|row| rows[row][..7].to_vec());
    for (value, expected) in rows.concat().into_iter().zip(expected.concat()) {
        close(value, expected);
    }
    // The last step ends the third cycle, up to the rounding of its time.
    let whole = cycles(3.0, 2.5e-4, 128, history);
    assert_eq!(result(&whole, "full_cycles"), 3.0);
    close(result(&whole, "cycle_sink_m"), 2e-3);
}

#[test]
fn without_a_full_cycle_there_are_neither_results_nor_a_table() {
    let resting = |_: u32, _: f64| Step {
        height: 0.0,
        force: [0.0, 1.0],
        ..Step::default()
    };
    for (count, steps) in [(1.0, 47), (0.0, 200)] {
        let all = cycles(count, 2.5e-4, steps, resting);
        assert_eq!(all.results(true), []);
        assert_eq!(all.csv(true), None);
    }
}

/// A wheel without a force has no ratio of forces, and no such result.
#[test]
fn a_wheel_in_the_air_has_no_friction() {
    let falling = |_: u32, t: f64| Step {
        height: -t,
        ..Step::default()
    };
    let all = cycles(1.0, 2.5e-4, 48, falling);
    let results = all.results(false);
    let names: Vec<&str> = results.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(result(&all, "full_cycles"), 1.0);
    assert!(!names.contains(&"cycle_traction_ratio"), "{names:?}");
    assert!(all.csv(false).expect("there is one").contains("NaN"));
}
