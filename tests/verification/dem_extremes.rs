//! Extremes, each with its outcome: right, refused by name, or detected.
//!
//! Answers are statics and momentum: a column carries its weight, an inelastic blow keeps m v, a free disk flies straight.
//! A column of two disks with masses m below M has W_12^2/(W_11 W_22) = M/(M + m): at M/m = 1e6 Gauss-Seidel gains 1e-6 per
//! sweep, which is no convergence, and conjugate gradients need two iterations. t_i = d sqrt(rho/P) (see `dem_bounds`).

use dem_node::Dem;
use protocol::{FaultCode, Node, Window};
use serde_json::{Value, json};

use crate::dem_support::{Report, build, close, march, mass, refusal, scene};

const R: f64 = 1e-3;
const G: f64 = 9.81;

fn floor() -> Value {
    json!([{"x_m": 0.0, "y_m": 0.0, "nx": 0.0, "ny": 1.0}])
}

fn weight() -> Value {
    json!({"gravity_m_per_s2": [0.0, -G]})
}

fn one_disk(y: f64) -> Value {
    json!({"kind": "disks", "disks": [{"x_m": 0.0, "y_m": y, "radius_m": R}], "walls": floor()})
}

fn rigid() -> Value {
    json!({"kind": "signorini"})
}

/// A heavy disk on a light one on the floor; the forces of their contacts.
fn top_heavy(kind: &str, ratio: f64, iterations: usize) -> Result<[f64; 2], protocol::NodeError> {
    let small = R / ratio.sqrt();
    let sample = json!({"kind": "disks", "walls": floor(), "disks": [
        {"x_m": 0.0, "y_m": small, "radius_m": small},
        {"x_m": 0.0, "y_m": 2.0 * small + R, "radius_m": R},
    ]});
    let mut config = scene(rigid(), 1e-5, sample, weight());
    config["solver"] =
        json!({"kind": kind, "tolerance": 1e-9, "max_iterations": iterations, "min_iterations": 1});
    let mut dem = build(&config);
    dem.advance_alone(&Window {
        substeps: 3,
        ..Window::default()
    })?;
    let slots = &dem.state().list.slots;
    let force = |b: u32| {
        slots
            .iter()
            .find(|s| s.a == 0 && s.b == b)
            .map_or(0.0, |s| s.force[0])
    };
    Ok([force(1), force(2)])
}

#[test]
fn a_mass_ratio_of_1e6_is_detected_by_sweeps_and_right_by_conjugate_gradients() {
    let (heavy, light) = (mass(R) * G, mass(R) * 1e-6 * G);
    let [between, below] = top_heavy("pcg", 1e6, 100).expect("two contacts, two iterations");
    close("between", between, heavy, 1e-6 * heavy);
    close("below", below, heavy + light, 1e-6 * heavy);
    let error = top_heavy("nsgs", 1e6, 2000).expect_err("a sweep gains 1e-6");
    assert_eq!(error.code, FaultCode::Diverged);
    assert!(error.message.contains("true residual"), "{error}");
    let [between, _] = top_heavy("nsgs", 100.0, 20_000).expect("a hundred is possible");
    close("between", between, heavy, 1e-6 * heavy);
}

#[test]
fn a_radius_ratio_of_100_settles_without_overlap() {
    let small = 0.01 * R;
    let mut disks = vec![json!({"x_m": 0.0, "y_m": 2.2 * small + R, "radius_m": R})];
    for i in 0..41 {
        let x = 2.1 * small * (f64::from(i) - 20.0);
        disks.push(json!({"x_m": x, "y_m": small, "radius_m": small}));
    }
    let sample = json!({"kind": "disks", "disks": disks, "walls": floor()});
    let law = json!({"kind": "coulomb", "friction": 0.5});
    let mut config = scene(law, 1e-5, sample, weight());
    config["solver"] =
        json!({"kind": "pcg", "tolerance": 1e-6, "max_iterations": 20_000, "min_iterations": 1});
    let mut dem = build(&config);
    let report = march(&mut dem, 0, 100);
    let lowest = dem.state().centres[0][1];
    close(
        "the large disk lies on the small ones",
        lowest,
        2.0 * small + R,
        0.02 * small,
    );
    let overlap = report.signal("overlap_max_rel");
    assert!(
        overlap * dem.bodies().mean_radius() < 1e-4 * small,
        "{overlap:e}"
    );
}

#[test]
fn steps_from_a_hundredth_to_a_hundred_inertial_times_pass_warn_or_are_refused() {
    // d = 2 mm, rho = 7800 kg/m3, P = 1 Pa.
    let inertial = 2.0 * R * 7800f64.sqrt();
    let of = |part: f64| scene(rigid(), part * inertial, one_disk(R), json!({}));
    assert!(build(&of(0.01)).describe().warnings.is_empty());
    for part in [0.06, 0.9] {
        let warnings = build(&of(part)).describe().warnings;
        assert!(warnings[0].contains("inertial time"), "{warnings:?}");
    }
    for part in [1.01, 10.0, 100.0] {
        let message = refusal(&of(part));
        assert!(message.contains("inertial time"), "{message}");
    }
    let mut forced = of(100.0);
    forced["time"]["unsafe_step"] = json!(true);
    forced["gravity_m_per_s2"] = json!([0.0, -G]);
    let mut dem = build(&forced);
    march(&mut dem, 0, 10);
    close("it still rests", dem.state().centres[0][1], R, 1e-9 * R);
}

#[test]
fn friction_of_0_slides_and_of_10_rolls() {
    let (sin, cos) = 60f64.to_radians().sin_cos();
    for (friction, expected) in [(0.0, sin), (10.0, 2.0 / 3.0 * sin)] {
        let law = json!({"kind": "coulomb", "friction": friction});
        let gravity = json!({"gravity_m_per_s2": [G * sin, -G * cos]});
        let mut dem = build(&scene(law, 1e-4, one_disk(R), gravity));
        march(&mut dem, 0, 100);
        let speed = dem.state().velocities[0][0];
        close("speed", speed, expected * G * 1e-2, 1e-12);
    }
}

/// A layer of elastic grains on a rigid base under its wheel, as in `scenarios/extremes/grains`; `changes` apply to the wheel.
fn layer_under_wheel(friction: f64, changes: Value) -> Dem {
    let law = json!({
        "kind": "coulomb", "friction": friction, "contact_stiffness_pa": 2.255e11, "tangential_stiffness_ratio": 0.5,
    });
    layer_of(law, changes)
}

fn layer_of(law: Value, changes: Value) -> Dem {
    build(&layer_scene(law, changes, None))
}

fn layer_scene(law: Value, changes: Value, seed: Option<u64>) -> Value {
    let mut sample = json!({
        "kind": "layer", "thickness_m": 0.3e-3, "half_width_m": 1.5e-3, "crown_radius_m": 0.3,
        "radius_min_m": 0.05e-3, "radius_max_m": 0.1e-3, "law": "surface_uniform",
    });
    let mut wheel = json!({
        "load_n": 1500.0, "mass_kg": 0.01, "amplitude_m": 0.05e-3, "frequency_hz": 300.0,
        "ramp_s": 0.1e-3, "hold_s": 0.1e-3, "cycles": 0.1,
    });
    for (key, value) in changes.as_object().into_iter().flatten() {
        wheel[key] = value.clone();
    }
    if let Some(seed) = seed {
        sample["seed"] = seed.into();
    }
    let overrides = json!({
        "mass_scale": 1000.0,
        "solver": {"kind": "nsgs", "tolerance": 1e-4, "max_iterations": 5000, "min_iterations": 2},
        "time": {"step_s": 6.12e-7, "pressure_pa": 1e9},
        "wheel": wheel,
    });
    scene(law, 6.12e-7, sample, overrides)
}

/// Plain sweeps circle around the solution of some steps, at a true residual of 1e-4 to 2e-3; under-relaxed sweeps show that the
/// solution exists.
#[test]
fn friction_of_5_and_10_among_grains_carries_the_wheel() {
    for friction in [5.0, 10.0] {
        let mut dem = layer_under_wheel(friction, json!({}));
        let report = march(&mut dem, 0, 800);
        assert!(report.signal("true_residual") <= 1e-4);
        assert!(report.imbalance(0.0) < 1e-2, "{}", report.imbalance(0.0));
        // The mean over the last half of the hold: the wheel still swings on the grains.
        let outcome = dem.finish().expect("it finishes");
        close(
            "wheel force",
            outcome.results["wheel_force_n"],
            1500.0,
            30.0,
        );
    }
}

/// Sweeps of all kinds stall at a true residual of 4e-4 after 20 000 in a step of the third layer, and of 9e-3 after 5 000 in a step of
/// the sixth: only pivoting solves these steps.
#[test]
fn rigid_grains_on_which_sweeps_stall_carry_the_wheel() {
    for (seed, friction) in [(3, 0.3), (6, 0.6)] {
        let law = json!({"kind": "coulomb", "friction": friction});
        let mut dem = build(&layer_scene(law, json!({}), Some(seed)));
        let report = march(&mut dem, 0, 800);
        assert!(report.signal("true_residual") <= 1e-4);
    }
}

/// Plain sweeps and their averages stall at a true residual of 1.2e-4 to 9e-4 in some steps of rigid grains: modes with
/// eigenvalues of 0.9998 and of 1.0001.
#[test]
fn rigid_grains_with_friction_up_to_1_carry_the_wheel() {
    for friction in [0.3, 1.0] {
        let law = json!({"kind": "coulomb", "friction": friction});
        let mut dem = layer_of(law, json!({}));
        let report = march(&mut dem, 0, 800);
        assert!(report.signal("true_residual") <= 1e-4);
        let outcome = dem.finish().expect("it finishes");
        close(
            "wheel force",
            outcome.results["wheel_force_n"],
            1500.0,
            30.0,
        );
    }
}

/// Two bonded disks that separate at 20 m/s.
fn parted(w: f64) -> Value {
    let law = json!({
        "kind": "cohesion", "friction": 0.3, "cn_pa_per_m": 4e14, "ct_pa_per_m": 4e14, "w_j_per_m2": w,
        "b_pa_m_s": 0.0, "p": 1.0, "h_prime": "adhesion", "alert_m": 1e-6,
    });
    let sample = json!({"kind": "disks", "disks": [
        {"x_m": 0.0, "y_m": 0.0, "radius_m": R, "vx_m_per_s": -10.0},
        {"x_m": 2.0 * R, "y_m": 0.0, "radius_m": R, "vx_m_per_s": 10.0},
    ]});
    scene(law, 1e-8, sample, json!({}))
}

#[test]
fn a_strength_of_0_is_refused_1_pa_is_negligible_and_1e12_pa_holds() {
    let message = refusal(&parted(0.0));
    assert!(message.contains("law.w_j_per_m2"), "{message}");
    let strength = |pascal: f64| pascal * pascal / 4e14;
    let mut weak = build(&parted(strength(1.0)));
    march(&mut weak, 0, 100);
    assert!(weak.state().bonds.is_empty());
    close("speed", weak.state().velocities[1][0], 10.0, 1e-9);
    let mut strong = build(&parted(strength(1e12)));
    for step in 0..20 {
        march(&mut strong, 100 * step, 100);
        let [a, b] = [strong.state().centres[0][0], strong.state().centres[1][0]];
        assert!(
            (b - a - 2.0 * R).abs() < 1e-5,
            "they must not part: {:e}",
            b - a
        );
    }
    assert_eq!(strong.state().bonds[0].adhesion, 1.0);
}

#[test]
fn a_lone_disk_without_gravity_flies_straight() {
    let sample = json!({"kind": "disks", "disks": [
        {"x_m": 0.0, "y_m": 0.0, "radius_m": R, "vx_m_per_s": 3.0, "vy_m_per_s": -4.0, "spin_rad_per_s": 7.0},
    ]});
    let mut dem = build(&scene(rigid(), 1e-3, sample, json!({})));
    let report = march(&mut dem, 0, 1000);
    let [x, y] = dem.state().centres[0];
    close("x", x, 3.0, 1e-12);
    close("y", y, -4.0, 1e-12);
    assert_eq!(dem.state().velocities[0], [3.0, -4.0, 7.0 * R]);
    assert_eq!(
        (report.signal("contacts"), report.signal("iterations")),
        (0.0, 1.0)
    );
}

#[test]
fn a_sample_without_free_disks_is_refused_by_name() {
    for disks in [
        json!([]),
        json!([{"x_m": 0.0, "y_m": 0.0, "radius_m": R, "glued": true}]),
    ] {
        let sample = json!({"kind": "disks", "disks": disks});
        let message = refusal(&scene(rigid(), 1e-5, sample, json!({})));
        assert!(message.contains("sample.disks"), "{message}");
    }
}

#[test]
fn coincident_disks_are_refused_when_rigid_and_part_when_elastic() {
    let sample = json!({"kind": "disks", "disks": [
        {"x_m": 0.0, "y_m": 0.0, "radius_m": R},
        {"x_m": 0.0, "y_m": 0.0, "radius_m": R},
    ]});
    let message = refusal(&scene(rigid(), 1e-6, sample.clone(), json!({})));
    assert!(message.contains("disks 0 and 1 overlap"), "{message}");
    let law = json!({"kind": "signorini", "contact_stiffness_pa": 1e6});
    let mut dem = build(&scene(law, 1e-6, sample, json!({})));
    march(&mut dem, 0, 20_000);
    let [a, b] = [dem.state().centres[0], dem.state().centres[1]];
    let apart = (a[0] - b[0]).hypot(a[1] - b[1]);
    assert!(apart > 2.0 * R, "{apart:e}");
    close("centre", a[1] + b[1], 0.0, 1e-12);
}

#[test]
fn a_wheel_met_at_10_m_per_s_takes_its_share_of_the_momentum() {
    let sample = json!({"kind": "disks", "disks": [
        {"x_m": 0.0, "y_m": R, "radius_m": R, "vy_m_per_s": 10.0},
        {"x_m": 3.0 * R, "y_m": R, "radius_m": R, "vy_m_per_s": 10.0},
    ]});
    let wheel = json!({"load_n": 0.0, "mass_kg": 0.01, "ramp_s": 1e-3, "hold_s": 1e-3});
    let mut dem = build(&scene(rigid(), 1e-5, sample, json!({"wheel": wheel})));
    let before = dem.state().kinetic(dem.bodies());
    let report = march(&mut dem, 0, 50);
    let expected = 2.0 * mass(R) * 10.0 / (2.0 * mass(R) + 0.01);
    close("wheel", dem.state().wheel.velocity[1], expected, 1e-9);
    close("disk", dem.state().velocities[0][1], expected, 1e-9);
    assert!(report.imbalance(before) < 1e-10);
}

/// Without rebound the disk under the wheel has the wheel's velocity after the first step, and M V = (M + m) v.
#[test]
fn a_wheel_dropped_at_10_m_per_s_shares_its_momentum() {
    let sample = json!({"kind": "disks", "disks": [{"x_m": 0.0, "y_m": R, "radius_m": R}]});
    let wheel = |vy: f64| json!({"load_n": 0.0, "mass_kg": 0.01, "ramp_s": 1e-3, "hold_s": 1e-3, "vy_m_per_s": vy});
    let mut dem = build(&scene(
        rigid(),
        1e-5,
        sample.clone(),
        json!({"wheel": wheel(-10.0)}),
    ));
    let before = dem.state().kinetic(dem.bodies());
    close("energy at the start", before, 0.5, 1e-15);
    let report = march(&mut dem, 0, 50);
    let expected = -10.0 * 0.01 / (mass(R) + 0.01);
    close("wheel", dem.state().wheel.velocity[1], expected, 1e-9);
    close("disk", dem.state().velocities[0][1], expected, 1e-9);
    let lost = 0.5 - 0.5 * (mass(R) + 0.01) * expected.powi(2);
    close("impact", report.energy("impact"), lost, 1e-9 * lost);
    assert!(report.imbalance(before) < 1e-10);
    // A wheel that moves away leaves the disk where it is.
    let mut dem = build(&scene(rigid(), 1e-5, sample, json!({"wheel": wheel(10.0)})));
    march(&mut dem, 0, 50);
    close("wheel", dem.state().wheel.velocity[1], 10.0, 0.0);
    close("disk", dem.state().velocities[0][1], 0.0, 0.0);
}

/// The last report and the warnings after a run up to the end of a hold.
fn held(changes: Value) -> (Report, Vec<String>) {
    let mut dem = layer_under_wheel(0.3, changes);
    let end = dem.describe().end_s.expect("the wheel has an end");
    let report = march(&mut dem, 0, (end / 6.12e-7).ceil() as u32);
    let findings = dem.finish().expect("it finishes").findings;
    let texts = findings.into_iter().map(|finding| finding.text);
    (report, texts.collect())
}

/// The ledger is exact to the solver's residual: it includes the loss of springs as their contacts turn, 4 % here.
#[test]
fn a_wheel_dropped_on_a_layer_keeps_its_ledger_and_is_reported_as_not_at_rest() {
    let of_the_wheel = |warnings: &[String]| {
        let about = |w: &&String| w.starts_with("the wheel is not at rest");
        warnings.iter().find(about).cloned()
    };
    let (report, warnings) = held(json!({"vy_m_per_s": -10.0, "cycles": 0.0}));
    let imbalance = report.imbalance(0.5);
    assert!(imbalance < 1e-5, "{imbalance:e}");
    let text = of_the_wheel(&warnings).expect("it bounces");
    for part in [" m/s", "of its 1500 N", "wheel.hold_s", "wheel.vy_m_per_s"] {
        assert!(text.contains(part), "{part}: {text}");
    }
    let (_, warnings) = held(json!({"ramp_s": 4e-4, "hold_s": 2e-4, "cycles": 0.0}));
    assert_eq!(of_the_wheel(&warnings), None);
}

#[test]
fn a_wheel_that_presses_near_the_ends_of_its_layer_raises_a_warning() {
    let warns = |load: f64| {
        let (_, warnings) = held(json!({"load_n": load, "cycles": 0.0}));
        warnings
            .iter()
            .any(|w| w.contains("sample.half_width_m at least"))
    };
    assert!(warns(1500.0));
    assert!(!warns(100.0));
}

#[test]
fn not_a_number_in_a_message_is_an_error_value() {
    let sample = json!({"kind": "disks", "disks": [
        {"x_m": 0.0, "y_m": R, "radius_m": R},
        {"x_m": 0.0, "y_m": -R, "radius_m": R, "glued": true},
    ]});
    let mut config = scene(rigid(), 1e-5, sample, weight());
    config["time"] = json!({"pressure_pa": 1.0});
    let mut dem = build(&config);
    dem.couple("base").expect("there is a glued disk");
    let error = dem
        .set_boundary(1e-5, &[f64::NAN; 4])
        .expect_err("no compliance");
    assert!(error.message.contains("compliance"), "{error}");
    dem.set_boundary(1e-5, &[1.0, 0.0, 0.0, 1.0])
        .expect("a wall");
    let window = Window {
        t1_s: 1e-5,
        substeps: 1,
        ..Window::default()
    };
    let error = dem
        .solve(&window, &[f64::NAN, 0.0])
        .expect_err("no velocity");
    assert!(error.message.contains("velocit"), "{error}");
    // The state is untouched: the window can be solved with numbers.
    dem.solve(&window, &[0.0; 2]).expect("it can be solved");
    let error = dem
        .commit(&window, &[0.0, f64::INFINITY])
        .expect_err("no place");
    assert!(error.message.contains("displacement"), "{error}");
}
