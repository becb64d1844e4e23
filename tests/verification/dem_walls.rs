//! Rigid walls: half-planes, and polylines with straight joints, convex and concave corners, at rest or moving.
//!
//! ```text
//!   O ->                  a joint of a straight line must have no effect
//!   ____.____.____
//!                \        over a convex corner the normal turns with the disk: its centre moves on a circle of its radius
//! ```
//!
//! Exact by kinematics and statics, derived in each case. Tolerance: rounding of positions over the step, 1e-16 m /
//! 1e-5 s, and the true residual 1e-12.

use dem_node::Dem;
use protocol::Node;
use serde_json::{Value, json};

use crate::dem_support::{build, close, march, mass, refusal, scene};

const R: f64 = 1e-3;
const G: f64 = 9.81;
const STEP: f64 = 1e-5;

fn on_walls(law: Value, walls: Value, disks: Value, overrides: Value) -> Dem {
    let sample = json!({"kind": "disks", "disks": disks, "walls": walls});
    build(&scene(law, STEP, sample, overrides))
}

/// A line through the origin along (cos, sin) with unevenly spaced joints, rounded to the last digit.
fn line(sin: f64, cos: f64) -> Value {
    let places = [-9.0, -3.1, -1.3, -0.2, 0.017, 0.9, 1.7, 2.9, 4.0, 30.0];
    let points: Vec<[f64; 2]> = places.iter().map(|s| [s * R * cos, s * R * sin]).collect();
    json!([{"points_m": points}])
}

#[test]
fn a_disk_slides_over_straight_joints_undisturbed() {
    let (sin, cos) = 0.3f64.sin_cos();
    // A weight normal to the line presses the disk on it.
    let gravity = json!({"gravity_m_per_s2": [1e4 * sin, -1e4 * cos]});
    let disk = json!([{
        "x_m": -2.0 * R * cos - R * sin, "y_m": -2.0 * R * sin + R * cos, "radius_m": R,
        "vx_m_per_s": cos, "vy_m_per_s": sin,
    }]);
    let law = json!({"kind": "signorini"});
    let mut dem = on_walls(law, line(sin, cos), disk, gravity);
    for step in 0..800 {
        let report = march(&mut dem, step, 1);
        let [vx, vy, spin] = dem.state().velocities[0];
        close("along", vx * cos + vy * sin, 1.0, 1e-12);
        close("across", vy * cos - vx * sin, 0.0, 1e-11);
        assert_eq!(spin, 0.0);
        assert_eq!(report.signal("contacts"), 1.0, "step {step}");
    }
}

#[test]
fn a_disk_rolls_over_joints_as_over_a_half_plane() {
    // At friction 0.3 on a slope of 20 degrees the disk rolls. The compliant law would show a lost spring.
    let (sin, cos) = 20f64.to_radians().sin_cos();
    let disk =
        json!([{"x_m": 2.0 * R * cos - sin * R, "y_m": 2.0 * R * sin + cos * R, "radius_m": R}]);
    let plane = json!([{"x_m": 0.0, "y_m": 0.0, "nx": -sin, "ny": cos}]);
    for law in [
        json!({"kind": "coulomb", "friction": 0.3}),
        json!({
            "kind": "coulomb", "friction": 0.3,
            "contact_stiffness_pa": 1e8, "tangential_stiffness_ratio": 0.5,
        }),
    ] {
        let gravity = json!({"gravity_m_per_s2": [0.0, -G]});
        let mut over = on_walls(law.clone(), line(sin, cos), disk.clone(), gravity.clone());
        let mut reference = on_walls(law.clone(), plane.clone(), disk.clone(), gravity);
        // Compare every step: the effect of a lost spring on the velocities disappears within a few.
        for step in 0..6000 {
            march(&mut over, step, 1);
            march(&mut reference, step, 1);
            let [on, off] = [&over, &reference].map(|dem| dem.state().velocities[0]);
            for (on, off) in on.into_iter().zip(off) {
                close(&format!("step {step}, {law}"), on, off, 1e-11);
            }
        }
        let travelled = reference.state().centres[0][0] - (2.0 * R * cos - sin * R);
        assert!(travelled < -2.0 * R, "it must cross joints: {travelled:e}");
    }
}

#[test]
fn over_a_convex_corner_a_disk_falls_as_an_inverted_pendulum() {
    // The disk sticks to the corner and turns about it. With phi the angle from the vertical, the energy balance gives
    // (3/4) (R phi')^2 = (3/4) v^2 + g R (1 - cos phi).
    let roof = json!([{"points_m": [[-0.1, 0.0], [0.0, 0.0], [0.0, -0.1]]}]);
    let v = 0.02;
    let disk = json!([{"x_m": -0.1 * R, "y_m": R, "radius_m": R, "vx_m_per_s": v, "spin_rad_per_s": -v / R}]);
    let law = json!({"kind": "coulomb", "friction": 2.0});
    let mut dem = on_walls(law, roof, disk, json!({"gravity_m_per_s2": [0.0, -G]}));
    let mut checked = 0;
    for step in 0..2000 {
        let report = march(&mut dem, step, 1);
        let [x, y] = dem.state().centres[0];
        if x <= 0.0 {
            close("on the flat", dem.state().velocities[0][0], v, 1e-12);
            continue;
        }
        let cos = y / x.hypot(y);
        if cos < 0.8 {
            break;
        }
        checked += 1;
        assert_eq!(report.signal("contacts"), 1.0);
        close("it stays on the corner", x.hypot(y), R, 3e-4 * R);
        let [vx, vy, _] = dem.state().velocities[0];
        let expected = (v * v + 4.0 / 3.0 * G * R * (1.0 - cos)).sqrt();
        // The scheme is of first order, with steps of 1e-5 s over 20 ms.
        close("speed", vx.hypot(vy), expected, 5e-3 * expected);
    }
    assert!(checked > 500, "{checked} steps on the corner");
}

#[test]
fn a_disk_in_a_concave_corner_rests_on_both_faces() {
    // A V of 60 and 30 degrees: N1 = m g cos(60), N2 = m g cos(30) without friction.
    let (sin, cos) = 30f64.to_radians().sin_cos();
    let wedge =
        json!([{"points_m": [[-0.01 * sin, 0.01 * cos], [0.0, 0.0], [0.01 * cos, 0.01 * sin]]}]);
    // Touching both: R times the sum of the normals (cos, sin) and (-sin, cos).
    let disk = json!([{"x_m": R * (cos - sin), "y_m": R * (sin + cos), "radius_m": R}]);
    let law = json!({"kind": "signorini"});
    let mut dem = on_walls(law, wedge, disk, json!({"gravity_m_per_s2": [0.0, -G]}));
    let report = march(&mut dem, 0, 100);
    assert_eq!(report.signal("contacts"), 2.0);
    let weight = mass(R) * G;
    // A gap's rounding of 1e-19 m, over the step, is 1e-10 of g h.
    let forces: Vec<f64> = dem.state().list.slots.iter().map(|s| s.force[0]).collect();
    close("steep face", forces[0], weight * sin, 1e-8 * weight);
    close("gentle face", forces[1], weight * cos, 1e-8 * weight);
    close("it rests", report.signal("speed_max_m_per_s"), 0.0, 1e-12);
}

#[test]
fn a_disk_stops_in_the_corner_it_rolls_into() {
    let corner = json!([{"points_m": [[-0.1, 0.0], [0.0, 0.0], [0.0, 0.1]]}]);
    let disk = json!([{"x_m": -3.0 * R, "y_m": R, "radius_m": R, "vx_m_per_s": 1.0}]);
    let law = json!({"kind": "signorini"});
    let mut dem = on_walls(law, corner, disk, json!({"gravity_m_per_s2": [0.0, -G]}));
    march(&mut dem, 0, 400);
    close("x", dem.state().centres[0][0], -R, 1e-15);
    close("y", dem.state().centres[0][1], R, 1e-15);
}

#[test]
fn a_moving_wall_takes_its_grains_along_and_does_the_work() {
    let speed = 0.5;
    for wall in [
        json!({"x_m": -2.0 * R, "y_m": 0.0, "nx": 1.0, "ny": 0.0}),
        json!({"points_m": [[-2.0 * R, R], [-2.0 * R, -R]]}),
    ] {
        let mut wall = wall;
        wall["velocity_m_per_s"] = json!([speed, 0.0]);
        let disks = json!([
            {"x_m": 0.0, "y_m": 0.0, "radius_m": R}, {"x_m": 3.0 * R, "y_m": 0.0, "radius_m": R},
        ]);
        let law = json!({"kind": "signorini"});
        let mut dem = on_walls(law, json!([wall]), disks, json!({}));
        let steps = 2000;
        let report = march(&mut dem, 0, steps);
        // Inelastic: both end at the wall's speed, in a row.
        let face = -2.0 * R + speed * STEP * f64::from(steps);
        close("first", dem.state().centres[0][0], face + R, 1e-14);
        close("second", dem.state().centres[1][0], face + 3.0 * R, 1e-14);
        for v in &dem.state().velocities {
            close("speed", v[0], speed, 1e-12);
        }
        // The wall gives both disks their momentum at its own speed. The impacts dissipate half of its work.
        let work = 2.0 * mass(R) * speed * speed;
        close("work", report.energy("walls"), work, 1e-12 * work);
        close("lost", report.energy("impact"), 0.5 * work, 1e-9 * work);
        assert!(report.imbalance(0.0) < 1e-12, "{:e}", report.imbalance(0.0));
    }
}

#[test]
fn impossible_walls_are_refused_by_key() {
    let cases = [
        (
            json!({"x_m": 0.0, "y_m": 0.0, "nx": 1.0}),
            "sample.walls[0].ny: is missing",
        ),
        (
            json!({"x_m": 0.0, "y_m": 0.0, "nx": 0.0, "ny": 0.0}),
            "sample.walls[0].nx",
        ),
        (
            json!({"points_m": [[0.0, 0.0]]}),
            "sample.walls[0].points_m: must have a length of at least 2, got 1",
        ),
        (
            json!({"points_m": [[0.0, 0.0], [1.0, 0.0], [1.0, 0.0]]}),
            "points 1 and 2",
        ),
        (
            json!({"points_m": [[0.0, 0.0], [1.0, 0.0]], "nx": 1.0}),
            "sample.walls[0].nx: belongs to a half-plane",
        ),
    ];
    for (wall, expected) in cases {
        let disks = json!([{"x_m": 0.0, "y_m": R, "radius_m": R}]);
        let sample = json!({"kind": "disks", "disks": disks, "walls": [wall]});
        let message = refusal(&scene(
            json!({"kind": "signorini"}),
            STEP,
            sample,
            json!({}),
        ));
        assert!(message.contains(expected), "{message}");
    }
}

/// A square of 20 R around (0, 10 R) with its corners anticlockwise, so its inside is on the left.
fn square() -> Vec<[f64; 2]> {
    let [a, b] = [-10.0 * R, 10.0 * R];
    vec![[a, 0.0], [b, 0.0], [b, 2.0 * b], [a, 2.0 * b], [a, 0.0]]
}

fn at(y: f64) -> Value {
    json!({"x_m": 0.0, "y_m": y, "radius_m": R})
}

#[test]
fn disks_behind_a_wall_of_points_are_refused() {
    let clockwise: Vec<_> = square().into_iter().rev().collect();
    let floor = vec![[-10.0 * R, 0.0], [10.0 * R, 0.0]];
    let turned: Vec<_> = floor.iter().rev().copied().collect();
    let plate = vec![floor[0], floor[1], floor[0]];
    let (inside, outside, below) = (at(5.0 * R), at(25.0 * R), at(-5.0 * R));
    let cases = [
        ("a closed box", square(), json!([inside]), false),
        (
            "the box clockwise",
            clockwise.clone(),
            json!([inside]),
            true,
        ),
        ("an obstacle", clockwise.clone(), json!([outside]), false),
        (
            "the obstacle anticlockwise",
            square(),
            json!([outside]),
            true,
        ),
        (
            "one inside, one outside",
            square(),
            json!([inside, outside]),
            true,
        ),
        ("a floor", floor.clone(), json!([inside]), false),
        (
            "the floor from right to left",
            turned,
            json!([inside]),
            true,
        ),
        (
            "one that falls away below",
            floor.clone(),
            json!([inside, below]),
            false,
        ),
        (
            "one that lies in the floor",
            floor.clone(),
            json!([inside, at(-0.3 * R)]),
            true,
        ),
        ("a plate with two faces", plate, json!([at(R)]), false),
    ];
    for (what, points, disks, refused) in cases {
        for law in [
            json!({"kind": "signorini"}),
            json!({"kind": "signorini", "contact_stiffness_pa": 1e8}),
        ] {
            let sample = json!({"kind": "disks", "disks": disks, "walls": [{"points_m": points}]});
            let config = scene(law, STEP, sample, json!({}));
            if refused {
                let message = refusal(&config);
                let expected = "sample.walls[0].points_m: the disk at";
                assert!(
                    message.contains(expected) && message.contains("other order"),
                    "{what}: {message}"
                );
            } else {
                build(&config);
            }
        }
    }
}

#[test]
fn an_overlap_at_the_start_is_refused_as_by_a_half_plane() {
    let floor = json!({"points_m": [[-10.0 * R, 0.0], [10.0 * R, 0.0]]});
    let plane = json!({"x_m": 0.0, "y_m": 0.0, "nx": 0.0, "ny": 1.0});
    let overlap = |wall: &Value, y: f64| {
        let sample = json!({"kind": "disks", "disks": [at(y)], "walls": [wall]});
        refusal(&scene(
            json!({"kind": "signorini"}),
            STEP,
            sample,
            json!({}),
        ))
    };
    assert_eq!(overlap(&floor, 0.7 * R), overlap(&plane, 0.7 * R));
    // The plane still pushes a disk back whose centre is beyond it.
    assert!(overlap(&plane, -0.3 * R).contains("overlap"));
    assert!(overlap(&floor, -0.3 * R).contains("behind this wall"));
}

/// A wall approaches a disk from behind, or a disk rises into a floor from below. Neither wall holds the disk.
#[test]
fn a_disk_that_meets_a_wall_from_behind_is_suspect() {
    let points = json!([[-10.0 * R, 0.0], [10.0 * R, 0.0]]);
    for (velocity, gravity, found) in [(-0.5, 0.0, true), (0.0, G, true), (0.0, -G, false)] {
        let wall = json!({"points_m": points, "velocity_m_per_s": [0.0, velocity]});
        let disks = json!([at(5.0 * R), at(-3.0 * R)]);
        let overrides = json!({"gravity_m_per_s2": [0.0, gravity]});
        let mut dem = on_walls(
            json!({"kind": "signorini"}),
            json!([wall]),
            disks,
            overrides,
        );
        march(&mut dem, 0, 3000);
        let findings = dem.finish().expect("it ends").findings;
        let codes: Vec<_> = findings
            .iter()
            .map(|f| (f.code.as_str(), f.value, f.suspect))
            .collect();
        let expected = [("behind_wall", 0.5, true)];
        assert_eq!(
            codes,
            expected[..usize::from(found)],
            "{velocity} {gravity}"
        );
    }
}

/// A wall comes down on a glued disk, and another begins behind it.
#[test]
fn a_glued_disk_that_a_wall_passes_gives_a_finding() {
    let glued = json!({"x_m": 0.0, "y_m": 0.0, "radius_m": R, "glued": true});
    for (velocity, expected) in [(-0.5, Some(0.5)), (-0.1, None)] {
        let wall = json!({"x_m": 0.0, "y_m": 2.0 * R, "nx": 0.0, "ny": -1.0, "velocity_m_per_s": [0.0, velocity]});
        let behind = json!({"x_m": 0.0, "y_m": 0.0, "nx": 1.0, "ny": 0.0});
        let grain = json!({"x_m": R, "y_m": -1.5 * R, "radius_m": 0.1 * R});
        let sample = json!({"kind": "disks", "disks": [glued, grain], "walls": [wall, behind]});
        let law = json!({"kind": "signorini"});
        let mut dem = build(&scene(law, 1e-5, sample, json!({})));
        march(&mut dem, 0, 500);
        let findings = dem.finish().expect("it ends").findings;
        let found = findings.iter().find(|f| f.code == "glued_behind_wall");
        let value = found.map(|f| (1e6 * f.value).round() / 1e6);
        assert_eq!(value, expected, "{velocity}");
    }
}
