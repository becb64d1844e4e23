//! A curved wheel on grains. It does not turn, its sideways motion is prescribed, and it is free to sink.
//!
//! ```text
//!        \    R     /        sin(phi) = s / (R + r)
//!     |   \__ | __/   |      statics without friction: (N1 + N2) cos(phi) = F, side walls N sin(phi), floor N cos(phi)
//!     | O  s     s  O |      (the wheel cannot turn, so statics leaves N1/N2 open)
//!     +---------------+
//! ```
//!
//! Reference: plane statics and impulse balance, derived in each case. Tolerance: the true residual 1e-12 over the
//! condition of four contacts, and rounding of R.

use serde_json::{Value, json};

use crate::dem_support::{build, close, march, mass, refusal, scene};

const R: f64 = 0.46;
const RADIUS: f64 = 1e-3;
const LOAD: f64 = 5.0;

fn wheel(radius: f64, changes: Value) -> Value {
    let mut wheel = json!({
        "load_n": LOAD, "mass_kg": 1e-4, "radius_m": radius, "ramp_s": 0.0, "hold_s": 1.0,
    });
    for (key, value) in changes.as_object().into_iter().flatten() {
        wheel[key] = value.clone();
    }
    wheel
}

fn disk(x: f64, y: f64) -> Value {
    json!({"x_m": x, "y_m": y, "radius_m": RADIUS})
}

/// Two disks at x = +-s on a floor, each touching its side wall.
fn pair(s: f64) -> Value {
    json!({"kind": "disks", "disks": [disk(-s, RADIUS), disk(s, RADIUS)], "walls": [
        {"x_m": 0.0, "y_m": 0.0, "nx": 0.0, "ny": 1.0},
        {"x_m": -s - RADIUS, "y_m": 0.0, "nx": 1.0, "ny": 0.0},
        {"x_m": s + RADIUS, "y_m": 0.0, "nx": -1.0, "ny": 0.0},
    ]})
}

#[test]
fn a_wheel_on_two_grains_satisfies_statics() {
    for radius in [R, 5.0 * RADIUS] {
        for solver in ["nsgs", "pcg"] {
            let s = 3.0 * RADIUS;
            let mut config = scene(
                json!({"kind": "signorini"}),
                1e-5,
                pair(s),
                json!({"wheel": wheel(radius, json!({}))}),
            );
            config["solver"]["kind"] = json!(solver);
            let mut dem = build(&config);
            let report = march(&mut dem, 0, 50);
            let sin = s / (radius + RADIUS);
            let cos = (1.0 - sin * sin).sqrt();
            let force = |a: u32, b: u32| {
                let mut slots = dem.state().list.slots.iter();
                let slot = slots.find(|slot| (slot.a, slot.b) == (a, b));
                slot.expect("they touch").force[0]
            };
            // The wheel cannot turn, so statics leaves open how the two disks share the load.
            let normal = [force(0, 2), force(1, 2)];
            let tolerance = 1e-9 * LOAD;
            assert!(normal.iter().all(|n| *n > 0.1 * LOAD), "{normal:?}");
            close("load", (normal[0] + normal[1]) * cos, LOAD, tolerance);
            close("left on the floor", force(0, 3), normal[0] * cos, tolerance);
            close(
                "right on the floor",
                force(1, 3),
                normal[1] * cos,
                tolerance,
            );
            close("left side wall", force(0, 4), normal[0] * sin, tolerance);
            close("right side wall", force(1, 5), normal[1] * sin, tolerance);
            close(
                "force on the wheel",
                report.signal("wheel_fn_n"),
                LOAD,
                1e-9 * LOAD,
            );
            let sideways = (normal[0] - normal[1]) * sin;
            close("sideways", report.signal("wheel_ft_n"), sideways, tolerance);
        }
    }
}

#[test]
fn the_wheel_starts_on_the_first_grain_that_it_meets() {
    // The highest disk is at the side, where the face is higher by x^2 / 2R. The disk's extra height is less than that.
    let (side, top) = (30.0 * RADIUS, 1.2 * RADIUS);
    let disks = [disk(0.0, RADIUS), disk(side, top)];
    let sample = json!({"kind": "disks", "disks": disks});
    let law = json!({"kind": "signorini"});
    let start = |radius: f64| {
        let overrides = json!({"wheel": wheel(radius, json!({}))});
        let dem = build(&scene(law.clone(), 1e-5, sample.clone(), overrides));
        dem.state().wheel.position[1]
    };
    assert_eq!(start(0.0), top + RADIUS);
    assert_eq!(start(R), 2.0 * RADIUS);
    // With a radius of 3 m the face is only 0.15 mm higher there, so the wheel starts on the disk at the side.
    let reach: f64 = 3.0 + RADIUS;
    let expected = top + (reach * reach - side * side).sqrt() - 3.0;
    close("on the side", start(3.0), expected, 1e-15);
}

#[test]
fn an_impulse_moves_the_wheel_along_y_only() {
    // The loaded wheel hits a disk off its middle in one step: v_b = -hF/M, n = (sin, -cos), and
    // W_nn = 1/m + cos^2/M, as the wheel has no inverse mass along x.
    let (radius, s, h, heavy) = (5.0 * RADIUS, 3.0 * RADIUS, 1e-5, 1e-4);
    let overrides = json!({"wheel": wheel(radius, json!({"mass_kg": heavy}))});
    let sample = json!({"kind": "disks", "disks": [disk(s, RADIUS)]});
    let mut dem = build(&scene(json!({"kind": "signorini"}), h, sample, overrides));
    march(&mut dem, 0, 1);
    let (sin, light) = (0.5, mass(RADIUS));
    let cos = (1.0f64 - sin * sin).sqrt();
    let kick = h * LOAD / heavy;
    let impulse = cos * kick / (1.0 / light + cos * cos / heavy);
    let [vx, vy, spin] = dem.state().velocities[0];
    close("disk, x", vx, impulse * sin / light, 1e-12 * kick);
    close("disk, y", vy, -impulse * cos / light, 1e-12 * kick);
    close("disk, spin", spin, 0.0, 0.0);
    let wheel = dem.state().wheel;
    assert_eq!(wheel.velocity[0], 0.0);
    assert_eq!(wheel.position[0], 0.0);
    let expected = -kick + impulse * cos / heavy;
    close("wheel, y", wheel.velocity[1], expected, 1e-12 * kick);
}

#[test]
fn a_driven_wheel_follows_its_path_over_grains_and_the_ledger_closes() {
    for theta in [0.5, 1.0] {
        let (frequency, start) = (20.0, 1e-3);
        let drive = json!({
            "amplitude_m": 2e-4, "frequency_hz": frequency, "cycles": 1.0, "ramp_s": 5e-4, "hold_s": 5e-4,
        });
        let row = (0..9).map(|i| disk(2.0 * RADIUS * f64::from(i - 4), RADIUS));
        let sample = json!({
            "kind": "disks", "disks": row.collect::<Vec<_>>(),
            "walls": [
                {"x_m": 0.0, "y_m": 0.0, "nx": 0.0, "ny": 1.0},
                {"x_m": -9.5 * RADIUS, "y_m": 0.0, "nx": 1.0, "ny": 0.0},
                {"x_m": 9.5 * RADIUS, "y_m": 0.0, "nx": -1.0, "ny": 0.0},
            ],
        });
        let mut config = scene(
            json!({"kind": "coulomb", "friction": 0.3}),
            1e-5,
            sample,
            json!({"wheel": wheel(20.0 * RADIUS, drive), "mass_scale": 10.0}),
        );
        config["time"]["theta"] = json!(theta);
        let mut dem = build(&config);
        let mut top_defect = 0.0f64;
        let mut moved = 0.0f64;
        let mut report = march(&mut dem, 0, 1);
        for step in 1..2000 {
            report = march(&mut dem, step, 1);
            let time = (step + 1) as f64 * 1e-5 - start;
            let turn = std::f64::consts::TAU * frequency * time.max(0.0);
            close("D", report.signal("wheel_x_m"), 2e-4 * turn.sin(), 1e-17);
            top_defect = top_defect.max(report.signal("momentum_defect_n"));
            moved = moved.max(report.signal("wheel_ft_n").abs());
        }
        assert!(top_defect < 1e-9 * LOAD, "theta {theta}: {top_defect:e} N");
        assert!(moved > 0.01 * LOAD, "the wheel must drag: {moved:e} N");
        let imbalance = report.imbalance(0.0);
        assert!(imbalance < 1e-9, "theta {theta}: {imbalance:e}");
    }
}

#[test]
fn a_wheel_that_no_disk_can_reach_is_refused() {
    let sample = json!({"kind": "disks", "disks": [disk(10.0 * RADIUS, RADIUS)]});
    let overrides = json!({"wheel": wheel(5.0 * RADIUS, json!({}))});
    let message = refusal(&scene(
        json!({"kind": "signorini"}),
        1e-5,
        sample,
        overrides,
    ));
    assert!(
        message.contains("wheel.radius_m") && message.contains("no disk"),
        "{message}"
    );
}
