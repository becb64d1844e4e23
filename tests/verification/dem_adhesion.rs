//! Adhesion: an attraction N_c within a range d, which shifts contact and friction: r_n + N_c >= 0, |r_t| <= mu (r_n + N_c).
//!
//! ```text
//!   -------         N_c (1 - 1e-6) hangs, N_c (1 + 1e-6) falls with 1e-6 of N_c / m
//!      O
//!      O  v^        rises by v^2 / (2 (g + N_c/m)) if that is below d, by (v^2/2 - N_c d/m)/g else
//!   -------
//! ```
//!
//! Closed forms of a mass point under constant forces, for which theta = 1/2 is exact, and the shifted law of Radjai, Preechawuttipong and
//! Peyroux (2001). Tolerances are rounding unless stated otherwise.

use dem_node::Dem;
use protocol::Node;
use serde_json::{Value, json};

use crate::dem_support::{build, close, march, mass, on_floor, refusal, scene, with};

const R: f64 = 1e-3;
const G: f64 = 9.81;
const H: f64 = 1e-6;
const RANGE: f64 = 2e-4;

fn law(pull_off: f64, more: Value) -> Value {
    let law = json!({"kind": "coulomb", "friction": 0.4, "adhesion": {"pull_off_n": pull_off, "range_m": RANGE}});
    with(law, &more)
}

fn disks(law: Value, gravity: f64, disks: Value, over: Value) -> Dem {
    on_floor(law, H, gravity, disks, &over)
}

fn midpoint() -> Value {
    json!({"time": {"step_s": H, "pressure_pa": 1.0, "theta": 0.5}})
}

fn thrown(speed: f64) -> Value {
    json!([{"x_m": 0.0, "y_m": R, "radius_m": R, "vy_m_per_s": speed}])
}

/// Gravity upwards: the floor is a ceiling.
#[test]
fn a_disk_hangs_by_its_pull_off_force_and_falls_by_a_millionth_more() {
    let weight = mass(R) * G;
    for (springs, allowed) in [
        (json!({}), 1e-12),
        (
            json!({"contact_stiffness_pa": 1e6 * weight / R / 1e-3, "tangential_stiffness_ratio": 1.0}),
            1e-6,
        ),
    ] {
        for (pull_off, falls) in [(weight * (1.0 + 1e-6), 0.0), (weight * (1.0 - 1e-6), 1e-6)] {
            let mut dem = disks(law(pull_off, springs.clone()), -G, thrown(0.0), json!({}));
            march(&mut dem, 0, 2000);
            let [_, speed, _] = dem.state().velocities[0];
            let time = 2000.0 * H;
            close(
                "speed",
                speed,
                falls * G * time,
                1e-3 * 1e-6 * G * time + allowed * 1e-3 * G * time,
            );
        }
    }
}

#[test]
fn a_thrown_disk_rises_against_attraction_and_weight_to_the_exact_height() {
    let pull_off = 5.0 * mass(R) * G;
    let escape = (2.0 * (pull_off / mass(R) + G) * RANGE).sqrt();
    for share in [0.5, 0.999, 1.001, 2.0] {
        let speed = share * escape;
        let mut dem = disks(law(pull_off, json!({})), G, thrown(speed), midpoint());
        let (mut highest, mut from) = (0.0f64, 0);
        for _ in 0..8000 {
            let report = march(&mut dem, from, 5);
            from += 5;
            highest = highest.max(dem.state().centres[0][1] - R);
            assert!(report.imbalance(mass(R) * speed * speed) < 1e-12);
            assert!(report.energy("numerical") >= -1e-12 * mass(R) * speed * speed);
        }
        let expected = if share < 1.0 {
            0.5 * speed * speed / (G + pull_off / mass(R))
        } else {
            (0.5 * speed * speed - pull_off * RANGE / mass(R)) / G
        };
        // Half way between two samples the disk is a (5 h)^2 / 8 below its apex; the step that leaves the range ends a h v beyond it.
        let edge = (speed * speed - escape * escape).max(0.0).sqrt() * H * pull_off / mass(R) / G;
        let slowing = if share < 1.0 {
            G + pull_off / mass(R)
        } else {
            G
        };
        let seen = slowing * (5.0 * H).powi(2) / 8.0;
        close("height", highest, expected, 1e-9 * R + seen + edge);
    }
}

/// m v' = -mu (m g + N_c), m r^2/2 w' = mu (m g + N_c) r until it rolls.
#[test]
fn friction_and_couple_hold_for_the_weight_and_the_attraction() {
    let pull_off = 3.0 * mass(R) * G;
    let disk = json!([{"x_m": 0.0, "y_m": R, "radius_m": R, "vx_m_per_s": 1.0}]);
    let mut dem = disks(law(pull_off, json!({})), G, disk, json!({}));
    march(&mut dem, 0, 1000);
    let (slowed, time) = (0.4 * 4.0 * G, 1000.0 * H);
    let [x, _, spin] = dem.state().velocity_of(dem.bodies(), 0);
    close("speed", x, 1.0 - slowed * time, 1e-12);
    close("spin", spin * R, -2.0 * slowed * time, 1e-11);
    let rolling = json!({"friction": 0.9, "rolling": {"coefficient": 0.1}});
    let turning = json!([{"x_m": 0.0, "y_m": R, "radius_m": R, "vx_m_per_s": 0.5, "spin_rad_per_s": -0.5 / R}]);
    let mut dem = disks(law(pull_off, rolling), G, turning, json!({}));
    march(&mut dem, 0, 1000);
    let [x, ..] = dem.state().velocities[0];
    close(
        "rolling speed",
        x,
        0.5 - 2.0 / 3.0 * 0.1 * 4.0 * G * time,
        1e-11,
    );
}

#[test]
fn at_rest_the_spring_carries_weight_and_attraction() {
    let (weight, k) = (mass(R) * G, 1e4 * mass(R) * G / R);
    let springs = json!({"contact_stiffness_pa": k / 1e-3, "tangential_stiffness_ratio": 1.0, "damping": 0.3});
    let mut dem = disks(
        law(2.0 * weight, springs),
        G,
        thrown(0.0),
        json!({"time": {"step_s": 2e-5, "pressure_pa": 1.0}}),
    );
    let report = march(&mut dem, 0, 20_000);
    let [_, y] = dem.state().centres[0];
    close("overlap", R - y, 3.0 * weight / k, 1e-9 * R);
    assert!(report.imbalance(weight * R) < 1e-9);
    let force = dem.state().list.slots[0].force[0];
    close("force", force, weight, 1e-6 * weight);
    let on_floor = report.signal("floor_force_y_n");
    close("force on the floor", on_floor, -weight, 1e-6 * weight);
}

/// Two disks that meet and part, at many phases of the step: their energy never grows, and the ledger accounts for every joule.
#[test]
fn a_pair_that_meets_and_parts_gains_nothing() {
    let weight = mass(R) * G;
    let k = 1e3 * weight / R;
    let springs = json!({"contact_stiffness_pa": k / 1e-3, "tangential_stiffness_ratio": 1.0});
    for phase in 0..20 {
        for theta in [0.5, 0.7, 1.0] {
            let gap = 3.0 * RANGE + 1.3e-6 * f64::from(phase);
            let pair = json!([
                {"x_m": 0.0, "y_m": 10.0 * R, "radius_m": R, "vx_m_per_s": 0.05},
                {"x_m": 2.0 * R + gap, "y_m": 10.1 * R, "radius_m": R, "vx_m_per_s": -0.05}]);
            let over = json!({"time": {"step_s": 2e-5, "pressure_pa": 1.0, "theta": theta}});
            let mut dem = disks(law(0.2 * weight, springs.clone()), 0.0, pair, over);
            let energy = mass(R) * 0.05 * 0.05;
            let report = march(&mut dem, 0, 4000);
            let kinetic = dem.state().kinetic(dem.bodies());
            assert!(dem.state().centres[1][0] - dem.state().centres[0][0] > 3.0 * R);
            assert!(
                kinetic <= energy * (1.0 + 1e-12),
                "{theta} {phase}: {kinetic:e} of {energy:e}"
            );
            assert!(
                report.imbalance(energy) < 1e-9,
                "{}",
                report.imbalance(energy)
            );
            assert!(report.energy("adhesion").abs() < 1e-18);
        }
    }
}

/// Dropped side by side, the grains settle together in the same way with either solver.
#[test]
fn a_cluster_of_grains_is_the_same_by_sweeps_and_by_conjugate_gradients() {
    let weight = mass(R) * G;
    let springs = json!({"contact_stiffness_pa": 1e4 * weight / R / 1e-3, "tangential_stiffness_ratio": 0.5, "damping": 0.5});
    let disk = |k: u32| {
        let (column, row) = (f64::from(k % 5), f64::from(k / 5));
        json!({"x_m": 2.05 * R * column + 0.9 * R * (row % 2.0), "y_m": R + 1.9 * R * row, "radius_m": R * (1.0 - 0.05 * f64::from(k % 4))})
    };
    let grains: Vec<Value> = (0..20).map(disk).collect();
    let run = |kind: &str| {
        let over = json!({"time": {"step_s": 2e-5, "pressure_pa": 1.0},
            "solver": {"kind": kind, "tolerance": 1e-11, "max_iterations": 50_000, "min_iterations": 1}});
        let mut dem = disks(law(10.0 * weight, springs.clone()), G, json!(grains), over);
        let report = march(&mut dem, 0, 1000);
        assert!(
            report.imbalance(20.0 * weight * R) < 1e-9,
            "{kind}: {}",
            report.imbalance(20.0 * weight * R)
        );
        assert!(report.energy("friction") >= 0.0);
        dem.state().centres.clone()
    };
    let [sweeps, gradients] = ["nsgs", "pcg"].map(run);
    for (one, other) in sweeps.iter().flatten().zip(gradients.iter().flatten()) {
        close("centre", *one, *other, 1e-6 * R);
    }
}

/// At corners of +-0.02 rad a disk lies on two segments, but only one attracts it: N_c at any place.
#[test]
fn a_polyline_attracts_a_disk_where_it_is_nearest() {
    let weight = mass(R) * G;
    for bend in [0.02, -0.02] {
        for springs in [
            json!({}),
            json!({"contact_stiffness_pa": 1e5 * weight / R / 1e-3, "tangential_stiffness_ratio": 1.0}),
        ] {
            let points = [
                [-6.0 * R, 6.0 * R * bend],
                [0.0, 0.0],
                [6.0 * R, 6.0 * R * bend],
            ];
            let speed = 0.1;
            // Half a degree down the first slope, rolling.
            let (sin, cos) = f64::atan(bend).sin_cos();
            let disk = json!([{"x_m": -R * cos + R * sin, "y_m": R * sin + R * cos, "radius_m": R,
                "vx_m_per_s": speed * cos, "vy_m_per_s": -speed * sin, "spin_rad_per_s": -speed / R}]);
            let sample = json!({"kind": "disks", "disks": disk, "walls": [{"name": "floor", "points_m": points}]});
            let over = json!({"gravity_m_per_s2": [0.0, -G], "time": {"step_s": 1e-5, "pressure_pa": 1.0}});
            let mut dem = build(&scene(law(4.0 * weight, springs), 1e-5, sample, over));
            let energy = 0.75 * mass(R) * speed * speed;
            for step in 0..2000 {
                let report = march(&mut dem, step, 1);
                let attractions = dem.state().list.slots.iter().map(|slot| slot.attraction);
                close(
                    "attraction",
                    attractions.sum(),
                    4.0 * weight,
                    1e-12 * weight,
                );
                assert!(
                    report.imbalance(energy) < 1e-6,
                    "{bend} {step}: {:e}",
                    report.imbalance(energy)
                );
            }
            let [x, _] = dem.state().centres[0];
            assert!(x > 0.5 * R, "it has passed the corner: {x}");
        }
    }
}

#[test]
fn keys_that_exclude_adhesion_are_refused_by_name() {
    let refused = |more: Value| {
        let sample = json!({"kind": "disks", "disks": thrown(0.0)});
        refusal(&scene(law(1.0, more), H, sample, json!({})))
    };
    assert!(refused(json!({"restitution": 0.5})).contains("law.restitution"));
    assert!(refused(json!({"penetration": "split"})).contains("law.penetration"));
    let both = json!({"adhesion": {"pull_off_n": 1.0, "pull_off_pa": 1.0, "range_m": 1e-4}});
    assert!(refused(both).contains("pull_off_n and pull_off_pa"));
    assert!(
        refused(json!({"adhesion": {"pull_off_n": 1.0, "range_m": 0.0}}))
            .contains("law.adhesion.range_m")
    );
}

/// No force at all: a disk at rest on a floor, two in flight side by side, and a disk that moves with the floor. Each pair keeps its
/// potential -N_c d.
#[test]
fn a_pair_that_touches_without_a_force_keeps_its_potential() {
    let disk = |x: f64, vx: f64, vy: f64| json!({"x_m": x, "y_m": R, "radius_m": R, "vx_m_per_s": vx, "vy_m_per_s": vy});
    let floor = |speed: f64| json!([{"x_m": 0.0, "y_m": 0.0, "nx": 0.0, "ny": 1.0, "velocity_m_per_s": [0.0, speed]}]);
    let scenes = [
        (json!([disk(0.0, 0.0, 0.0)]), floor(0.0)),
        (
            json!([disk(0.0, 0.1, 0.0), disk(2.0 * R, 0.1, 0.0)]),
            json!([]),
        ),
        (json!([disk(0.0, 0.0, -0.1)]), floor(-0.1)),
        (json!([disk(0.0, 0.0, 0.0)]), floor(-0.1)),
        (json!([disk(0.0, 0.0, -0.1)]), floor(0.0)),
    ];
    for (disks, walls) in scenes {
        let sample = json!({"kind": "disks", "disks": disks, "walls": walls});
        let mut dem = build(&scene(law(0.01, json!({})), H, sample, json!({})));
        let report = march(&mut dem, 0, 2000);
        let potential = 0.01 * RANGE;
        close("adhesion", report.energy("adhesion"), 0.0, 1e-9 * potential);
        assert!(report.imbalance(potential) < 1e-9);
        let stored = dem.state().energies(dem.bodies())[4];
        close("potential", stored, -potential, 1e-9 * potential);
        let found = dem.finish().expect("it ends").findings;
        assert!(found.is_empty(), "{walls}: {found:?}");
    }
}
