//! Results of the wheel's motion for each cycle.
//!
//! ```text
//!   =====  -> D(t)      a wheel of friction mu slides on two disks that neither move nor turn, under a growing load:
//!    O O                F_T = mu N(t) against its motion, at each moment
//!   =====
//! ```
//!
//! Exact by statics: with N linear over time, |F_T| at D = 0 is mu N, and the work of a cycle is mu times the path 4 A times N at its
//! middle, since the rest of N is odd about the middle; a step has the load of its end, half a step later. Tolerance: the true residual
//! 1e-12. A sheared layer loses grains in each cycle; there the reference is the difference of the signals at the ends of the cycle,
//! linear between steps.

use protocol::{Node, Setting};
use serde_json::{Value, json};

use crate::dem_flow::{STEP as FLOW_STEP, followed, sheared};
use crate::dem_support::{Report, THICKNESS, build, close, march, scene, setting};

const RADIUS: f64 = 1e-3;
const FRICTION: f64 = 0.3;
const AMPLITUDE: f64 = 1e-4;
/// Steps before the motion, and steps of a cycle: a multiple of 4, so that the wheel reverses between two steps.
const BEFORE: u32 = 20;
const CYCLE: u32 = 1000;
const STEP: f64 = 1e-4;
/// Load at the start of the motion (N) and its growth (N/s).
const LOAD: f64 = 2.0;
const GROWTH: f64 = 10.0;

fn load_at(step: f64) -> f64 {
    LOAD + GROWTH * STEP * (step - f64::from(BEFORE))
}

fn slider(cycles: f64) -> Value {
    let disk = |x: f64| json!({"x_m": x, "y_m": RADIUS, "radius_m": RADIUS, "cluster": "rest"});
    let sample = json!({
        "kind": "disks",
        "disks": [disk(-3.0 * RADIUS), disk(3.0 * RADIUS)],
        "clusters": [{"name": "rest", "locked": ["x", "rotation"]}],
        "walls": [{"x_m": 0.0, "y_m": 0.0, "nx": 0.0, "ny": 1.0}],
    });
    let start = STEP * f64::from(BEFORE);
    let wheel = json!({
        "load_n": LOAD, "mass_kg": 1e-6, "amplitude_m": AMPLITUDE, "frequency_hz": 1.0 / (f64::from(CYCLE) * STEP),
        "ramp_s": 0.5 * start, "hold_s": 0.5 * start, "cycles": cycles,
        "load_table": [[0.0, load_at(0.0)], [start, LOAD], [1.0, load_at(1.0 / STEP)]],
    });
    scene(
        json!({"kind": "coulomb", "friction": FRICTION}),
        STEP,
        sample,
        json!({"wheel": wheel}),
    )
}

/// The row of a cycle: work, |F_T| at D = 0, |F_T|/F_N.
fn expected(cycle: u32) -> [f64; 3] {
    let at = |periods: f64| load_at(f64::from(BEFORE) + periods * f64::from(CYCLE));
    let first = f64::from(cycle);
    let work = FRICTION * 4.0 * AMPLITUDE * (at(first + 0.5) + 0.5 * GROWTH * STEP);
    let at_zero = FRICTION * 0.5 * (at(first + 0.5) + at(first + 1.0));
    [work, at_zero, FRICTION]
}

#[test]
fn a_sliding_wheel_has_the_work_and_the_friction_of_each_cycle() {
    let folder = std::env::temp_dir().join(format!("thirdbody-cycles-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder can be made");
    let setting = Setting {
        fields: Some(folder.clone()),
        ..setting(1)
    };
    let config = kit::read_config(slider(2.5)).expect("it is valid");
    let mut dem = dem_node::Dem::new(&config, &setting).expect("it can be prepared");
    march(&mut dem, 0, BEFORE + 5 * CYCLE / 2);
    let results = dem.finish().expect("it ends").results;
    let text = std::fs::read_to_string(folder.join("third-body-cycles.csv"));
    std::fs::remove_dir_all(&folder).expect("the folder can go");
    let text = text.expect("the table is written");
    let rows: Vec<&str> = text.lines().skip(1).collect();
    assert_eq!(rows.len(), 2);
    for (cycle, row) in (0..).zip(rows) {
        let numbers: Vec<f64> = row
            .split(',')
            .map(|x| x.parse().expect("a number"))
            .collect();
        let start = STEP * f64::from(BEFORE + cycle * CYCLE);
        close("start", numbers[1], start, 1e-12);
        close("end", numbers[2], start + STEP * f64::from(CYCLE), 1e-12);
        close("rigid disks do not yield", numbers[3], 0.0, 1e-15);
        for (value, expected) in numbers[4..].iter().zip(expected(cycle)) {
            close("work, force, ratio", *value, expected, 1e-9 * expected);
        }
    }
    let [first, last] = [0, 1].map(expected);
    let names = [
        "loop_area_j",
        "cycle_tangential_at_zero_n",
        "cycle_traction_ratio",
    ];
    for (name, value) in names.into_iter().zip(last) {
        close(name, results[name], value, 1e-9 * value);
    }
    close(
        "all",
        results["all_cycles_work_j"],
        first[0] + last[0],
        1e-12,
    );
    assert_eq!(results["full_cycles"], 2.0);
    assert!(
        !results.contains_key("cycle_wear_kg"),
        "no flows are followed"
    );
    // It slides all the way, except in the step in which it reverses.
    for name in ["slip_amplitude_m", "slip_by_work_m"] {
        close(name, results[name], AMPLITUDE, 1e-4 * AMPLITUDE);
    }
    close(
        "nothing gives way",
        results["accommodated_by_body_m"],
        0.0,
        0.0,
    );
}

/// The same under a constant load on springs: the contacts deflect by F/k of the amplitude, with F = mu N and k = kt of two contacts
/// together.
#[test]
fn the_deflection_of_the_contact_springs_is_no_slip() {
    let taken = 0.3 * AMPLITUDE;
    let stiffness = FRICTION * LOAD / taken;
    let mut config = slider(3.5);
    config["law"]["contact_stiffness_pa"] = json!(stiffness / THICKNESS);
    config["law"]["tangential_stiffness_ratio"] = json!(0.5);
    config["law"]["damping"] = json!(0.4);
    let wheel = config["wheel"].as_object_mut().expect("it is a table");
    wheel.remove("load_table");
    let mut dem = build(&config);
    march(&mut dem, 0, BEFORE + 7 * CYCLE / 2);
    let results = dem.finish().expect("it ends").results;
    for name in ["cycle_slip_amplitude_m", "slip_by_work_m"] {
        close(name, results[name], AMPLITUDE - taken, 5e-3 * AMPLITUDE);
    }
}

#[test]
fn a_run_that_ends_within_its_first_cycle_has_no_loop() {
    let mut dem = build(&slider(2.0));
    march(&mut dem, 0, BEFORE + CYCLE - 1);
    let results = dem.finish().expect("it ends").results;
    assert!(!results.contains_key("loop_area_j") && !results.contains_key("full_cycles"));
}

/// The value of a signal at a time, linear between the reports at the ends of all steps.
fn at(reports: &[Report], time: f64, value: impl Fn(&Report) -> f64) -> f64 {
    let steps = time / FLOW_STEP;
    let before = steps as usize;
    // The first report belongs to the first step.
    let [a, b] = [before - 1, before].map(|k| value(&reports[k]));
    a + steps.fract() * (b - a)
}

/// Motion from 0.15 ms on at 3 kHz, in steps of 1 us: cycles end at 0.48333 ms and 0.81667 ms, within steps.
#[test]
fn cycles_of_a_sheared_layer_are_the_differences_of_its_signals() {
    let mut config = sheared(followed());
    // Grains leave earlier, and are worn within the run.
    config["flow"]["margin_diameters"] = json!(0.5);
    let mut dem = build(&config);
    let reports: Vec<Report> = (0..830).map(|step| march(&mut dem, step, 1)).collect();
    let results = dem.finish().expect("it ends").results;
    assert_eq!(results["full_cycles"], 2.0);
    let [first, second, end] = [0.0, 1.0, 2.0].map(|cycle| 1.5e-4 + cycle / 3000.0);
    let middle = 0.5 * (second + end);
    let difference = |from: f64, value: &dyn Fn(&Report) -> f64| {
        at(&reports, end, value) - at(&reports, from, value)
    };
    let signal = |name: &'static str| move |report: &Report| report.signal(name);
    type Value = Box<dyn Fn(&Report) -> f64>;
    let sums: [(&str, Value, f64); 5] = [
        ("sink_m", Box::new(signal("wheel_y_m")), -1.0),
        ("source_kg", Box::new(signal("q_source_kg")), 1.0),
        ("ejected_kg", Box::new(signal("q_ejected_kg")), 1.0),
        ("wear_kg", Box::new(signal("q_wear_kg")), 1.0),
        (
            "work_j",
            Box::new(|report| report.energy("wheel_drive")),
            1.0,
        ),
    ];
    for (name, value, sign) in &sums {
        let of_last = match *name {
            "work_j" => results["loop_area_j"],
            _ => results[&format!("cycle_{name}")],
        };
        let of_all = results[&format!("all_cycles_{name}")];
        let all = sign * difference(first, value);
        assert!(all != 0.0, "{name}: nothing happens");
        close(
            name,
            of_last,
            sign * difference(second, value),
            1e-9 * all.abs(),
        );
        close(name, of_all, all, 1e-9 * all.abs());
    }
    let zeros = [middle, end].map(|time| at(&reports, time, signal("wheel_ft_n")).abs());
    let at_zero = results["cycle_tangential_at_zero_n"];
    close(
        "T at D = 0",
        at_zero,
        0.5 * (zeros[0] + zeros[1]),
        1e-6 * at_zero,
    );
    // Means over time: each step counts with its part inside the cycle.
    let mean = |value: &dyn Fn(&Report) -> f64, counts: &dyn Fn(&Report) -> bool| {
        let shared = |step: usize| {
            let [from, to] = [step, step + 1].map(|step| step as f64 * FLOW_STEP);
            (to.min(end) - from.max(second)).max(0.0)
        };
        let steps = reports
            .iter()
            .enumerate()
            .filter(|(_, report)| counts(report));
        let sums = steps.map(|(step, report)| [shared(step) * value(report), shared(step)]);
        let [sum, time] = sums.fold([0.0; 2], |sum, part| [sum[0] + part[0], sum[1] + part[1]]);
        sum / time
    };
    let name = "third_body_per_length_kg_per_m";
    let held = mean(&signal(name), &|_| true);
    close(
        name,
        results["cycle_third_body_kg_per_m"],
        held,
        1e-9 * held,
    );
    let ratio = mean(
        &|report| report.signal("wheel_ft_n").abs() / report.signal("wheel_fn_n"),
        &|report| report.signal("wheel_fn_n") > 0.0,
    );
    let found = results["cycle_traction_ratio"];
    close("traction ratio", found, ratio, 1e-9 * ratio);
    assert!(results["traction_ratio_mean"] < results["traction_ratio_peak"]);
    assert!(held > 0.0 && ratio > 0.0);
}

/// Third body per length, compared with grains counted one by one in the middle half of the zone.
#[test]
fn third_body_per_length_equals_the_counted_grains() {
    let mut dem = build(&sheared(followed()));
    let start = march(&mut dem, 0, 150);
    let [left, right] = crate::dem_flow::zone(&start);
    let quarter = 0.25 * (right - left);
    let ends = [left + quarter, right - quarter];
    for window in 3..16 {
        let report = march(&mut dem, 50 * window, 50);
        let expected = crate::dem_flow::third_body(&dem, ends) / (ends[1] - ends[0]);
        let found = report.signal("third_body_per_length_kg_per_m");
        close("per length", found, expected, 1e-12 * found.max(1e-3));
    }
    let results = dem.finish().expect("it ends").results;
    assert!(results["third_body_per_length_kg_per_m"] > 0.0);
}
