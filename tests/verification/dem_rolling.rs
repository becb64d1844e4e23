//! Rolling resistance: a couple of at most mu_r r r_n against relative spin.
//!
//! ```text
//!        O  M = mu_r r N      rolls without slip: a = 2/3 g (sin(theta) - mu_r cos(theta)), 0 if tan(theta) < mu_r
//!      /                      turns on the spot:  r w' = -2 mu_r g until it is at rest
//!    /                        two disks, one on the other: I_1 w_1' = -M, I_2 w_2' = M with r = r_1 r_2/(r_1 + r_2)
//!  / theta
//! ```
//!
//! Closed forms of rigid-body mechanics with a disk's inertia m r^2/2. Implicit Euler is exact under constant couples, except in the step in
//! which a spin ends; tolerance 1e-9 of the scale.

use dem_node::Dem;
use serde_json::{Value, json};

use crate::dem_support::{build, close, march, mass, refusal, scene};

const R: f64 = 1e-3;
const G: f64 = 9.81;
const H: f64 = 1e-5;

fn floor(angle: f64) -> Value {
    let (sin, cos) = angle.sin_cos();
    json!([{"name": "floor", "x_m": 0.0, "y_m": 0.0, "nx": -sin, "ny": cos}])
}

fn on_floor(angle: f64, rolling: f64, disk: Value) -> Dem {
    let law = json!({"kind": "coulomb", "friction": 0.9, "rolling": {"coefficient": rolling}});
    let sample = json!({"kind": "disks", "disks": [disk], "walls": floor(angle)});
    build(&scene(
        law,
        H,
        sample,
        json!({"gravity_m_per_s2": [0.0, -G]}),
    ))
}

#[test]
fn a_disk_rolls_down_a_slope_that_is_steeper_than_its_resistance() {
    for (degrees, rolling) in [(20.0f64, 0.1), (20.0, 0.3), (20.0, 0.5), (40.0, 0.5)] {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let disk = json!({"x_m": -R * sin, "y_m": R * cos, "radius_m": R});
        let mut dem = on_floor(degrees.to_radians(), rolling, disk);
        let acceleration = (2.0 / 3.0 * G * (sin - rolling * cos)).max(0.0);
        let steps = 1000;
        let report = march(&mut dem, 0, steps);
        let time = f64::from(steps) * H;
        let [vx, vy, spin] = dem.state().velocity_of(dem.bodies(), 0);
        let scale = G * time;
        close(
            "speed",
            -vx * cos - vy * sin,
            acceleration * time,
            1e-9 * scale,
        );
        close("spin", spin * R, acceleration * time, 1e-9 * scale);
        assert!(report.energy("friction") >= -1e-12 * mass(R) * scale * scale);
    }
}

/// v^2/2 = a s with a = 2/3 mu_r g.
#[test]
fn a_rolling_disk_stops_after_its_stopping_distance() {
    let (speed, rolling) = (0.05, 0.02);
    let disk = json!({"x_m": 0.0, "y_m": R, "radius_m": R, "vx_m_per_s": speed, "spin_rad_per_s": -speed / R});
    let mut dem = on_floor(0.0, rolling, disk);
    let time = 1.5 * speed / (rolling * G);
    let steps = (1.1 * time / H) as u32;
    let report = march(&mut dem, 0, steps);
    let way = 0.75 * speed * speed / (rolling * G);
    let [x, _] = dem.state().centres[0];
    // The sum of end velocities misses half a step at the initial speed.
    close("way", x, way - 0.5 * speed * H, 1e-6 * way);
    assert!(
        dem.state()
            .velocity_of(dem.bodies(), 0)
            .iter()
            .all(|v| v.abs() < 1e-12)
    );
    let energy = 0.75 * mass(R) * speed * speed;
    let lost = report.energy("friction") + report.energy("numerical") + report.energy("impact");
    close("energy", lost, energy, 1e-9 * energy);
}

#[test]
fn two_disks_pressed_together_reach_a_common_spin() {
    let (small, spin, rolling) = (0.6 * R, 40.0, 0.2);
    let law = json!({"kind": "coulomb", "friction": 0.0, "rolling": {"coefficient": rolling},
        "pairs": [{"between": ["grains", "floor"], "rolling": {"coefficient": 0.0}}]});
    let disks = json!([
        {"x_m": 0.0, "y_m": R, "radius_m": R},
        {"x_m": 0.0, "y_m": 2.0 * R + small, "radius_m": small, "spin_rad_per_s": spin}]);
    let sample = json!({"kind": "disks", "disks": disks, "walls": floor(0.0)});
    let mut dem = build(&scene(
        law,
        H,
        sample,
        json!({"gravity_m_per_s2": [0.0, -G]}),
    ));
    let inertia = [R, small].map(|r| 0.5 * mass(r) * r * r);
    let couple = rolling * R * small / (R + small) * mass(small) * G;
    let spins = |dem: &Dem| [0, 1].map(|disk| dem.state().velocity_of(dem.bodies(), disk)[2]);
    let steps = 200;
    march(&mut dem, 0, steps);
    let time = f64::from(steps) * H;
    let [lower, upper] = [0, 1].map(|disk| dem.state().velocity_of(dem.bodies(), disk)[2]);
    close(
        "upper",
        upper,
        spin - couple * time / inertia[1],
        1e-9 * spin,
    );
    close("lower", lower, couple * time / inertia[0], 1e-9 * spin);
    march(&mut dem, u64::from(steps), 2000);
    let [lower, upper] = spins(&dem);
    let common = inertia[1] * spin / (inertia[0] + inertia[1]);
    close("upper at last", upper, common, 1e-9 * spin);
    close("lower at last", lower, common, 1e-9 * spin);
}

/// Slip and roll of unequal disks interact: the residual covers both, and the dissipation of friction and couples is never negative.
#[test]
fn a_pile_of_unequal_disks_comes_to_rest_and_loses_energy_at_every_step() {
    let disk = |k: u32| {
        let (column, row) = (f64::from(k % 4), f64::from(k / 4));
        json!({"x_m": 2.1 * R * column + 0.7 * R * (row % 2.0), "y_m": R + 2.05 * R * row, "radius_m": R * (1.0 - 0.1 * f64::from(k % 5)),
            "spin_rad_per_s": 30.0 * f64::from(k % 3)})
    };
    let disks: Vec<Value> = (0..12).map(disk).collect();
    let wall = |name: &str, x: f64, n: f64| json!({"name": name, "x_m": x, "y_m": 0.0, "nx": n, "ny": 0.0});
    let mut walls = floor(0.0);
    let sides = [wall("left", -1.5 * R, 1.0), wall("right", 9.0 * R, -1.0)];
    walls.as_array_mut().expect("a list").extend(sides);
    let stiffness = 1e3 * mass(R) * G / R / 1e-3;
    let law = json!({"kind": "coulomb", "friction": 0.4, "rolling": {"coefficient": 0.3},
        "contact_stiffness_pa": stiffness, "tangential_stiffness_ratio": 0.5});
    let sample = json!({"kind": "disks", "disks": disks, "walls": walls});
    let over = json!({"gravity_m_per_s2": [0.0, -G],
        "solver": {"kind": "nsgs", "tolerance": 1e-9, "max_iterations": 20_000, "min_iterations": 1}});
    let mut dem = build(&scene(law, 10.0 * H, sample, over));
    let mut lost = 0.0;
    let scale = 12.0 * mass(R) * G * R;
    for step in 0..3000 {
        let report = march(&mut dem, step, 1);
        let friction = report.energy("friction");
        assert!(
            friction >= lost - 1e-9 * scale,
            "step {step}: {friction:e} after {lost:e}"
        );
        lost = friction;
        assert!(report.signal("true_residual") <= 1e-9);
        assert!(report.imbalance(scale) < 1e-9);
    }
    let fastest = dem
        .state()
        .velocities
        .iter()
        .flatten()
        .fold(0.0f64, |most, v| most.max(v.abs()));
    assert!(fastest < 1e-6, "at rest, {fastest:e} m/s");
}

#[test]
fn rolling_couples_are_refused_where_they_have_no_effect() {
    let refused = |solver: &str, coefficient: f64| {
        let law =
            json!({"kind": "coulomb", "friction": 0.4, "rolling": {"coefficient": coefficient}});
        let sample = json!({"kind": "disks", "disks": [{"x_m": 0.0, "y_m": R, "radius_m": R}]});
        let over = json!({"solver": {"kind": solver, "tolerance": 1e-9, "max_iterations": 20_000, "min_iterations": 1}});
        refusal(&scene(law, H, sample, over))
    };
    assert!(refused("pcg", 0.1).contains("law.rolling"));
    assert!(refused("nsgs", -0.1).contains("law.rolling.coefficient"));
}
