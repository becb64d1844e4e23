//! Forces of grains on named walls.
//!
//! ```text
//!     |  o o o   |      floor: the weight of all grains
//!     | o o o o  |      sides: +-H, as the upper row wedges the lower one apart,
//!     |__________|      H = w / (2 tan a), a the slope of the line of centres
//! ```
//!
//! References: statics, Coulomb's law, and another description of the same floor. Tolerance: the true residual 1e-12, or rounding.

use protocol::Node;
use serde_json::{Value, json};

use crate::dem_support::{build, close, march, mass, scene};

const R: f64 = 1e-3;
const STEP: f64 = 1e-5;
const G: f64 = 9.81;

fn plane(name: &str, x: f64, y: f64, nx: f64, ny: f64) -> Value {
    json!({"name": name, "x_m": x, "y_m": y, "nx": nx, "ny": ny})
}

fn falling(law: Value, disks: Value, walls: Value, overrides: Value) -> Value {
    let sample = json!({"kind": "disks", "disks": disks, "walls": walls});
    let mut config = scene(law, STEP, sample, json!({"gravity_m_per_s2": [0.0, -G]}));
    for (key, value) in overrides.as_object().into_iter().flatten() {
        config[key] = value.clone();
    }
    config
}

#[test]
fn the_floor_of_a_box_carries_the_weight_and_its_sides_the_wedging() {
    // Four grains 2.2 R apart, three in the hollows between them.
    let disk = |x: f64, y: f64| json!({"x_m": x, "y_m": y, "radius_m": R});
    let rise = (4.0 - 1.21f64).sqrt() * R;
    let lower = (0..4).map(|i| disk(R + 2.2 * R * f64::from(i), R));
    let upper = (0..3).map(|i| disk(2.1 * R + 2.2 * R * f64::from(i), R + rise));
    let disks: Vec<Value> = lower.chain(upper).collect();
    let right = 2.0 * R + 3.0 * 2.2 * R;
    let walls = json!([
        plane("left", 0.0, 0.0, 1.0, 0.0),
        plane("floor", 0.0, 0.0, 0.0, 1.0),
        plane("right", right, 0.0, -1.0, 0.0),
    ]);
    let law = json!({"kind": "signorini"});
    let mut dem = build(&falling(law, json!(disks), walls, json!({})));
    let report = march(&mut dem, 0, 50);
    let weight = mass(R) * G;
    let near = 1e-8 * weight;
    close(
        "floor",
        report.signal("floor_force_y_n"),
        -7.0 * weight,
        near,
    );
    close(
        "along the floor",
        report.signal("floor_force_x_n"),
        0.0,
        near,
    );
    let wedge = 0.5 * weight * 1.1 * R / rise;
    close("left", report.signal("left_force_x_n"), -wedge, near);
    close("right", report.signal("right_force_x_n"), wedge, near);
    close("up the left", report.signal("left_force_y_n"), 0.0, near);
    // Without a known end the means are over the later steps. All steps are at rest.
    let results = dem.finish().expect("it ends").results;
    close("mean", results["floor_force_y_n"], -7.0 * weight, near);
    close("mean of a side", results["right_force_x_n"], wedge, near);
}

/// Grains fall, roll and slide on a floor of one piece and on a floor of five.
#[test]
fn a_polyline_has_the_forces_of_a_half_plane() {
    let disk = |i: i32| {
        let (column, row) = (f64::from(i % 6), f64::from(i / 6));
        json!({
            "x_m": R * (2.3 * column + 0.4 * row), "y_m": R * (1.3 + 2.1 * row), "radius_m": R,
            "vx_m_per_s": 0.1 * (column - 2.0), "vy_m_per_s": -0.2, "spin_rad_per_s": 20.0 * column,
        })
    };
    let disks: Vec<Value> = (0..18).map(disk).collect();
    for law in [
        json!({"kind": "coulomb", "friction": 0.3}),
        json!({"kind": "coulomb", "friction": 0.3, "contact_stiffness_pa": 1e8, "tangential_stiffness_ratio": 0.5}),
    ] {
        let points = json!([
            [-1.0, 0.0],
            [1.1 * R, 0.0],
            [3.0 * R, 0.0],
            [6.5 * R, 0.0],
            [9.0 * R, 0.0],
            [1.0, 0.0]
        ]);
        let floors = [
            plane("floor", 0.0, 0.0, 0.0, 1.0),
            json!({"name": "floor", "points_m": points}),
        ];
        let mut both = floors.map(|floor| {
            build(&falling(
                law.clone(),
                json!(disks),
                json!([floor]),
                json!({}),
            ))
        });
        let scale = 18.0 * mass(R) * G;
        let mut most: f64 = 0.0;
        for step in 0..300 {
            let [plane, pieces] = both.each_mut().map(|dem| march(dem, step, 1));
            for name in ["floor_force_x_n", "floor_force_y_n"] {
                let force = plane.signal(name);
                close(
                    &format!("{name} in step {step}"),
                    pieces.signal(name),
                    force,
                    1e-12 * scale.max(force.abs()),
                );
                most = most.max(force.abs());
            }
        }
        assert!(most > scale, "they must hit the floor: {most:e}");
    }
}

/// A floor moves along below a disk that can neither turn nor move sideways. Its friction force is mu m g, its work that force times
/// its path.
#[test]
fn a_moving_floor_has_friction_and_does_work() {
    let (friction, speed) = (0.3, 0.2);
    let disks = json!([{"x_m": 0.0, "y_m": R, "radius_m": R, "cluster": "stone"}]);
    let walls = json!([{"name": "belt", "points_m": [[-0.1, 0.0], [0.0, 0.0], [0.1, 0.0]], "velocity_m_per_s": [speed, 0.0]}]);
    let mut config = falling(
        json!({"kind": "coulomb", "friction": friction}),
        disks,
        walls,
        json!({}),
    );
    config["sample"]["clusters"] = json!([{"name": "stone", "locked": ["x", "rotation"]}]);
    let mut dem = build(&config);
    let report = march(&mut dem, 0, 100);
    let weight = mass(R) * G;
    close(
        "along",
        report.signal("belt_force_x_n"),
        -friction * weight,
        1e-9 * weight,
    );
    close(
        "down",
        report.signal("belt_force_y_n"),
        -weight,
        1e-9 * weight,
    );
    let work = friction * weight * speed * 100.0 * STEP;
    close("work", report.energy("walls"), work, 1e-9 * work);
}

/// The results are means over the second half of the run, also of a resumed run.
#[test]
fn the_results_are_means_over_the_second_half_of_the_run() {
    let time = json!({"time": {"step_s": STEP, "pressure_pa": 1.0, "end_s": 200.0 * STEP}});
    let disks = json!([{"x_m": 0.0, "y_m": 1.005 * R, "radius_m": R}]);
    let law = json!({"kind": "signorini", "contact_stiffness_pa": 1e7});
    let floor = plane("floor", 0.0, 0.0, 0.0, 1.0);
    let config = falling(law, disks, json!([floor]), time);
    let mut whole = build(&config);
    let mut resumed = build(&config);
    let mut sum = 0.0;
    for step in 0..200 {
        let force = march(&mut whole, step, 1).signal("floor_force_y_n");
        sum += if step < 100 { 0.0 } else { force };
        if step == 130 {
            let checkpoint = whole.checkpoint().expect("it can be packed");
            resumed.restore(&checkpoint).expect("it is of these grains");
        }
    }
    march(&mut resumed, 131, 69);
    assert!(sum < 0.0);
    let [whole, resumed] = [whole, resumed].map(|mut dem| dem.finish().expect("it ends").results);
    close(
        "mean",
        whole["floor_force_y_n"],
        sum / 100.0,
        1e-14 * sum.abs(),
    );
    assert_eq!(whole, resumed);
}
