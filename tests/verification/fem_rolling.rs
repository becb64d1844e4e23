//! Problem: a rigid wheel that rolls over an elastic block.
//!
//! ```text
//!           ___
//!         /  o ->\  V        zeta = (V - omega R)/V, T on the block in the direction of rolling
//!        |  omega |
//!     ____\_____/____
//!    |    stick, slip behind
//! ```
//!
//! Exact: Carter's tractions, mu p0 (sqrt(1 - x^2) - c sqrt(1 - ((x - d)/c)^2)) with c = sqrt(1 - T/(mu N)), d = 1 - c, lengths over a, the stick
//! zone at the front (nu near 0.5); the work of the steady state, slip dissipation per metre = T zeta + N e/R; mirror images; a wheel without spin.
//! Creep curves and transients are in `scenarios/rolling`.
//! Source: F. W. Carter, On the action of a locomotive driving wheel, 1926; K. L. Johnson, Contact Mechanics, 1985, section 8.3.
//! Tolerance: elements of a/20.

use fem_node::{FemConfig, FemNode, StaticNode};
use kit::read_config;
use kit::scratch::Scratch;
use protocol::{Node, Setting};
use serde_json::{Value, json};

use crate::fem_bodies::{merge, node, reported, setting, window};
use crate::fem_wheel::run;

const LOAD: f64 = 8000.0;
const RADIUS: f64 = 0.46;
const THICKNESS: f64 = 1e-3;

/// A steel block, 150 half-widths of the contact wide and 75 deep, under a wheel that rolls 16 mm.
fn block(poisson: f64, friction: f64, rolling: Value) -> Value {
    let mut config = json!({
        "analysis": "static", "element": "q4_bbar",
        "mesh": {"width_m": 0.7, "height_m": 0.35, "size_m": 2e-4, "fine_width_m": 32e-3, "fine_depth_m": 4e-3,
                 "side_columns": 35, "depth_rows": 35},
        "material": {"young_pa": 205e9, "poisson": poisson, "density_kg_per_m3": 7800.0},
        "time": {"step_s": "auto", "damping": 0.5},
        "wheel": {"load_n": LOAD, "mass_kg": 1.0, "radius_m": RADIUS, "ramp_s": 0.0, "hold_s": 0.0,
                  "rolling": {"speed_m_per_s": 1.0, "distance_m": 16e-3, "start_m": -8e-3}},
        "contact": {"friction": friction},
    });
    merge(&mut config["wheel"]["rolling"], rolling);
    config
}

/// The wheel at the end of its way.
fn rolled(config: &Value, setting: &Setting) -> StaticNode {
    let config: FemConfig = read_config(config).expect("the keys are valid");
    let mut node = StaticNode::new(&config, setting).expect("the body is valid");
    let increments = node.describe().end_s.expect("it ends") as u32;
    node.advance_alone(&window(0, increments))
        .expect("it converges");
    node
}

fn results(node: &mut dyn Node) -> impl Fn(&str) -> f64 + use<> {
    let results = node.finish().expect("it ends").results;
    move |name| results[name]
}

/// (x/a, traction over p0, pressure over p0) below the wheel, x from its centre in the direction of rolling.
fn tractions(poisson: f64, friction: f64, rolling: Value, along: f64) -> (f64, Vec<[f64; 3]>) {
    let folder = Scratch::new(
        "rolling",
        rolling["speed_m_per_s"].as_f64().unwrap_or(1.0).to_bits(),
    );
    let setting = Setting {
        fields: Some(folder.path().to_path_buf()),
        ..setting(1)
    };
    let mut node = rolled(&block(poisson, friction, rolling), &setting);
    node.snapshot("end").expect("a file");
    let name = format!("{}-end-profile.csv", setting.participant);
    let text = std::fs::read_to_string(folder.path().join(name)).expect("a table");
    let modulus = 205e9 / (1.0 - poisson * poisson);
    let a = (4.0 * LOAD / THICKNESS * RADIUS / (std::f64::consts::PI * modulus)).sqrt();
    let p0 = modulus * a / (2.0 * RADIUS);
    let centre = along * 8e-3;
    let rows = text.lines().skip(1).map(|line| {
        let cell = |k: usize| line.split(',').nth(k).expect("four").parse::<f64>();
        let [x, pressure, shear] = [0, 1, 2].map(|k| cell(k).expect("a number"));
        [along * (x - centre) / a, shear / p0, pressure / p0]
    });
    (a, rows.filter(|[.., pressure]| *pressure > 0.0).collect())
}

#[test]
fn tractions_are_carters_with_the_stick_zone_at_the_front() {
    for (along, speed) in [(1.0, 1.0), (-1.0, -1.0)] {
        let rolling =
            json!({"speed_m_per_s": speed, "start_m": -8e-3 * along, "force_n": 0.64 * LOAD});
        let (_, rows) = tractions(0.4999, 1.0, rolling, along);
        let c: f64 = 0.6;
        let root = |x: f64| (1.0 - x * x).max(0.0).sqrt();
        let exact = |x: f64| root(x) - c * root((x - (1.0 - c)) / c);
        let (mut error, mut size) = (0.0, 0.0);
        for [x, shear, _] in &rows {
            error += (along * shear - exact(*x)).powi(2);
            size += exact(*x).powi(2);
        }
        let error = f64::sqrt(error / size);
        assert!(
            rows.len() > 35 && error < 0.06,
            "{error} over {} nodes",
            rows.len()
        );
    }
}

/// On steel the pressure leads or trails the wheel by e: without N e/R the balance is off by more than the dissipation.
#[test]
fn slip_dissipates_the_work_of_creep_force_and_lead_of_the_pressure() {
    for share in [0.9, -0.64] {
        let rolling = json!({"force_n": share * 0.3 * LOAD});
        let of = results(&mut rolled(&block(0.3, 0.3, rolling), &setting(1)));
        let work = of("creep_force_n") * of("creepage") + of("rolling_resistance");
        let dissipated = of("slip_dissipation_j_per_m");
        let error = (dissipated - work).abs() / dissipated;
        assert!(error < 0.01, "{dissipated} J/m by slip, {work} J/m of work");
        assert!(of("rolling_resistance").abs() > 1.0, "the pressure leads");
        // Given in turn, this creepage brings up some half of the force: the block is sheared first.
        let given = json!({ "creepage": of("creepage") });
        let back = results(&mut rolled(&block(0.3, 0.3, given), &setting(1)));
        let found = back("creep_force_n") / (share * 0.3 * LOAD);
        assert!((0.3..1.0).contains(&found), "{found} of the force");
    }
}

#[test]
fn a_mirrored_wheel_has_mirrored_results() {
    let forward = json!({"creepage": 2e-3, "ramp_m": 4e-3});
    let backward =
        json!({"creepage": 2e-3, "ramp_m": 4e-3, "speed_m_per_s": -1.0, "start_m": 8e-3});
    let [one, other] = [forward, backward]
        .map(|rolling| results(&mut rolled(&block(0.3, 0.3, rolling), &setting(1))));
    for name in [
        "creepage",
        "traction_ratio_mean",
        "rolling_resistance",
        "slip_dissipation_j_per_m",
        "p0_rolling_pa",
    ] {
        let error = (one(name) / other(name) - 1.0).abs();
        assert!(error < 1e-8, "{name}: {} and {}", one(name), other(name));
    }
}

/// Increments go on from a checkpoint in the middle of the way, to the same bits.
#[test]
fn an_interrupted_way_goes_on() {
    let config = block(0.3, 0.3, json!({"creepage": 2e-3}));
    let mut whole = rolled(&config, &setting(1));
    let config: FemConfig = read_config(&config).expect("valid");
    let whole_result = whole.finish().expect("it ends");
    // While the load grows, and on the way.
    for share in [0.1, 0.8] {
        let mut begun = StaticNode::new(&config, &setting(1)).expect("valid");
        let end = begun.describe().end_s.expect("it ends");
        let cut = (share * end) as u32;
        begun.advance_alone(&window(0, cut)).expect("it converges");
        let checkpoint = begun.checkpoint().expect("it can be packed");
        let mut resumed = StaticNode::new(&config, &setting(1)).expect("valid");
        resumed.restore(&checkpoint).expect("it is of this body");
        let rest = window(1, end as u32 - cut);
        resumed.advance_alone(&rest).expect("it converges");
        let other = resumed.finish().expect("it ends");
        assert_eq!(whole_result.state_hash, other.state_hash, "{share}");
        assert_eq!(whole_result.results, other.results);
    }
}

/// A small block in time, under a wheel with this motion.
fn in_time(wheel: Value) -> FemNode {
    let mut config = json!({
        "start": "static",
        "mesh": {"width_m": 24e-3, "height_m": 10e-3, "size_m": 4e-4, "fine_width_m": 12e-3, "fine_depth_m": 1.6e-3,
                 "side_columns": 8, "depth_rows": 8},
        "material": {"young_pa": 205e9, "poisson": 0.3, "density_kg_per_m3": 7800.0},
        "time": {"step_s": "auto", "damping": 0.75},
        "wheel": {"load_n": 2000.0, "mass_kg": 0.01, "radius_m": RADIUS, "ramp_s": 0.0, "hold_s": 1e-5},
        "contact": {"friction": 0.3},
    });
    merge(&mut config["wheel"], wheel);
    node(&config)
}

/// At a creepage of 1 the wheel slides without turning, as one that is moved sideways: over 2.5 mm of a stroke of 10 m its speed falls by 1e-8.
#[test]
fn a_wheel_without_spin_is_one_that_is_moved_sideways() {
    let (speed, stroke) = (25.0, 10.0);
    let frequency = speed / (std::f64::consts::TAU * stroke);
    let rolling =
        json!({"rolling": {"speed_m_per_s": speed, "creepage": 1.0, "distance_m": 2.5e-3}});
    let sideways =
        json!({"amplitude_m": stroke, "frequency_hz": frequency, "cycles": 1e-4 * frequency});
    let forces = [rolling, sideways].map(|wheel| {
        let mut forces = Vec::new();
        run(&mut in_time(wheel), |node, report| {
            forces.push(["wheel_fn_n", "wheel_ft_n"].map(|name| reported(node, report, name)));
        });
        forces
    });
    let [one, other] = &forces;
    assert_eq!(one.len(), other.len());
    for (one, other) in one.iter().zip(other) {
        for k in 0..2 {
            assert!((one[k] - other[k]).abs() < 1e-4, "{one:?} and {other:?}");
        }
    }
    let [_, pulled] = one.last().expect("it slides");
    assert!(*pulled < -500.0, "{pulled}");
}

/// Nodes that enter and leave the contact lose energy to the hard face; on its way along the curved face a node neither loses nor gains any.
#[test]
fn impacts_below_a_wheel_that_rolls_take_energy() {
    let rolling = json!({"rolling": {"speed_m_per_s": 25.0, "creepage": 2e-3, "distance_m": 4e-3}});
    let mut terms = [0.0; 3];
    run(&mut in_time(rolling), |node, report| {
        terms = ["impact", "friction", "wheel_drive"].map(|name| reported(node, report, name));
    });
    let [impact, friction, drive] = terms;
    assert!(friction > 0.0 && drive > 0.0, "{terms:?}");
    assert!(
        impact > -1e-3 * friction && impact < 0.1 * drive,
        "{terms:?}"
    );
}

#[test]
fn what_cannot_roll_on_the_body_is_refused_by_its_key() {
    let refused = |rolling: Value, changes: Value| {
        let mut config = block(0.3, 0.3, rolling);
        merge(&mut config, changes);
        let config: FemConfig = read_config(&config).map_err(|e| e.key).ok()?;
        StaticNode::new(&config, &setting(1))
            .err()
            .map(|error| error.to_string())
    };
    let none = json!({});
    for (rolling, changes, key) in [
        (
            json!({"creepage": 0.0, "distance_m": 1.0}),
            none.clone(),
            "wheel.rolling.distance_m",
        ),
        (
            json!({"creepage": 0.0, "start_m": -1.0}),
            none.clone(),
            "wheel.rolling.start_m",
        ),
        (
            json!({"force_n": 0.3 * LOAD}),
            none.clone(),
            "wheel.rolling.force_n",
        ),
        (
            json!({"torque_nm": -0.3 * LOAD * RADIUS}),
            none.clone(),
            "wheel.rolling.force_n",
        ),
        (
            json!({"creepage": 0.0, "spin_inertia_kg_m2": 1.0}),
            none.clone(),
            "spin_inertia_kg_m2",
        ),
        (
            json!({"creepage": 0.0}),
            json!({"statics": {"rolling_increment_m": 1e-3}}),
            "rolling_increment_m",
        ),
        (
            json!({"creepage": 0.0}),
            json!({"wheel": {"amplitude_m": 1e-5, "cycles": 1.0, "frequency_hz": 1.0}}),
            "wheel.amplitude_m",
        ),
        (
            json!({"force_n": 1.0}),
            json!({"analysis": "dynamic"}),
            "spin_inertia_kg_m2",
        ),
        (
            json!({"creepage": 0.0, "speed_m_per_s": 4000.0}),
            json!({"analysis": "dynamic"}),
            "speed_m_per_s",
        ),
    ] {
        let error = refused(rolling.clone(), changes).unwrap_or_default();
        assert!(error.contains(key), "{rolling}: {error}");
    }
}
