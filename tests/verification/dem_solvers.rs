//! Compares the solvers with each other, and each solver with itself in several threads.
//!
//! ```text
//!   | o o o o |     a heap of unequal disks in a box, under a weight that presses it into the corner
//!   |o o o o o|
//!   +---------+
//! ```
//!
//! The step of a convex problem has a unique velocity, so Gauss-Seidel and the projected conjugate gradient must find the
//! same one. With friction, compliant contacts make it unique here. Tolerance: the true residual of 1e-11 times the
//! condition of a heap of 8 rows, below 1e-8 of the grains' speed.

use dem_node::Dem;
use protocol::{Node, Setting};
use serde_json::{Value, json};

use crate::dem_support::{march, refusal, scene, setting};

const R: f64 = 1e-3;

fn laws() -> [Value; 4] {
    [
        json!({"kind": "signorini"}),
        json!({"kind": "signorini", "contact_stiffness_pa": 1e9}),
        json!({"kind": "coulomb", "friction": 0.3}),
        json!({
            "kind": "coulomb", "friction": 0.3,
            "contact_stiffness_pa": 1e9, "tangential_stiffness_ratio": 0.5,
        }),
    ]
}

/// Disks of three sizes on a grid with small gaps, in a box without a lid.
fn heap(columns: usize, rows: usize) -> Value {
    let radius = |i: usize| R * [0.99, 0.93, 0.85][i % 3];
    let disks: Vec<Value> = (0..columns * rows)
        .map(|i| {
            let (column, row) = (i / rows, i % rows);
            let shift = 0.9 * R * (row % 2) as f64;
            let x = R * (2 * column + 1) as f64 + shift;
            json!({"x_m": x, "y_m": R * (1.0 + 1.9 * row as f64), "radius_m": 0.9 * radius(i)})
        })
        .collect();
    let right = 2.0 * R * columns as f64 + R;
    json!({"kind": "disks", "disks": disks, "walls": [
        {"x_m": 0.0, "y_m": 0.0, "nx": 0.0, "ny": 1.0},
        {"x_m": 0.0, "y_m": 0.0, "nx": 1.0, "ny": 0.0},
        {"x_m": right, "y_m": 0.0, "nx": -1.0, "ny": 0.0},
    ]})
}

fn run(config: &Value, threads: usize, steps: u32) -> (Dem, String) {
    let config = kit::read_config(config).expect("the scene is valid");
    let setting = Setting {
        threads,
        ..setting(1)
    };
    let mut dem = Dem::new(&config, &setting).expect("the scene can be prepared");
    march(&mut dem, 0, steps);
    let hash = dem.finish().expect("it finishes").state_hash;
    (dem, hash)
}

fn top_speed(dem: &Dem) -> f64 {
    let speeds = dem.state().velocities.iter().flatten();
    speeds.fold(0.0f64, |s, v| s.max(v.abs()))
}

fn solver(kind: &str, tolerance: f64) -> Value {
    json!({"kind": kind, "tolerance": tolerance, "max_iterations": 20_000, "min_iterations": 1})
}

#[test]
fn gauss_seidel_and_conjugate_gradient_find_the_same_velocities() {
    for law in laws() {
        let overrides =
            |kind: &str| json!({"gravity_m_per_s2": [2.0, -9.81], "solver": solver(kind, 1e-11)});
        let step = |kind: &str| scene(law.clone(), 2e-4, heap(8, 8), overrides(kind));
        // The steps cover the fall onto the floor and the time after it. The two final states must agree.
        let (nsgs, _) = run(&step("nsgs"), 1, 60);
        let (pcg, _) = run(&step("pcg"), 1, 60);
        let speed = top_speed(&nsgs);
        assert!(speed > 1e-3, "the heap must move");
        for (a, b) in nsgs.state().velocities.iter().zip(&pcg.state().velocities) {
            for (a, b) in a.iter().zip(b) {
                assert!((a - b).abs() < 1e-7 * speed, "{law}: {a} and {b}");
            }
        }
    }
}

/// Every law with every solver that supports it.
fn combinations() -> Vec<(&'static str, Value)> {
    let springs = json!({"contact_stiffness_pa": 1e9, "tangential_stiffness_ratio": 0.5});
    let mut laws = laws().to_vec();
    laws.extend([
        json!({"kind": "signorini", "restitution": 0.6}),
        json!({"kind": "coulomb", "friction": 0.3, "restitution": 0.6}),
        json!({"kind": "coulomb", "friction": 0.3, "penetration": "split"}),
        json!({"kind": "coulomb", "friction": 0.3, "penetration": "projection"}),
        bonds(0.0, 0.5, json!({})),
        bonds(0.3, 0.5, springs),
    ]);
    let mut all: Vec<_> = laws.iter().map(|law| ("nsgs", law.clone())).collect();
    all.extend(laws.into_iter().map(|law| ("pcg", law)));
    all.push(("nsgs", bonds(0.3, 0.5, json!({}))));
    all
}

/// Equal disks on a triangular grid, each touching its six neighbours.
fn grid(columns: usize, rows: usize) -> Value {
    let d = 2.0 * R * (1.0 - 1e-6);
    let disk = |i: usize| {
        let (column, row) = (i / rows, i % rows);
        let x = d * (column as f64 + 0.5 * (row % 2) as f64);
        let speed = 0.01 * (i * i % 17) as f64;
        json!({
            "x_m": x, "y_m": R + 0.75f64.sqrt() * d * row as f64, "radius_m": R,
            "vx_m_per_s": speed, "vy_m_per_s": -speed, "spin_rad_per_s": 10.0 * (i % 5) as f64,
        })
    };
    json!({
        "kind": "disks", "disks": (0..columns * rows).map(disk).collect::<Vec<_>>(),
        "walls": [{"x_m": 0.0, "y_m": 0.0, "nx": 0.0, "ny": 1.0}],
    })
}

#[test]
fn any_number_of_threads_leaves_the_same_bits() {
    for (kind, law) in combinations() {
        let overrides = json!({"gravity_m_per_s2": [2.0, -9.81], "solver": solver(kind, 1e-2)});
        let config = scene(law.clone(), 1e-5, grid(90, 45), overrides);
        let (dem, one) = run(&config, 1, 2);
        let touching = |slot: &&dem_kernel::contact::detect::Slot| slot.force[0] != 0.0;
        let closed = dem.state().list.slots.iter().filter(touching).count();
        assert!(
            closed > 1000,
            "{kind}, {law}: only {closed} contacts carry force"
        );
        let contacts = dem.state().list.slots.len();
        assert!(
            contacts > 2 * 4096,
            "{contacts} contacts make only one block"
        );
        for threads in [2, 4] {
            let bits = run(&config, threads, 2).1;
            assert_eq!(bits, one, "{kind}, {law}, {threads} threads");
        }
    }
}

/// The grid with its lowest row glued, under a wheel that presses down and moves sideways.
fn layer() -> (Value, Value) {
    let mut sample = grid(90, 45);
    let disks = sample["disks"].as_array_mut().expect("they are a list");
    for disk in disks.iter_mut().step_by(45) {
        *disk = json!({"x_m": disk["x_m"], "y_m": disk["y_m"], "radius_m": R, "glued": true});
    }
    let wheel = json!({
        "load_n": 5e4, "mass_kg": 1.0, "amplitude_m": 1e-5, "frequency_hz": 500.0,
        "ramp_s": 0.0, "hold_s": 0.0, "cycles": 1.0,
    });
    (sample, wheel)
}

#[test]
fn a_layer_under_its_wheel_has_the_same_bits_in_any_number_of_threads() {
    for (kind, law) in combinations() {
        let (sample, wheel) = layer();
        let overrides = json!({"wheel": wheel, "solver": solver(kind, 1e-2)});
        let config = scene(law.clone(), 1e-5, sample, overrides);
        let (dem, one) = run(&config, 1, 2);
        let slots = &dem.state().list.slots;
        assert!(slots.len() > 2 * 4096, "there is only one block");
        let wheel = 90 * 45;
        let pressed =
            |slot: &&dem_kernel::contact::detect::Slot| slot.b == wheel && slot.force[0] > 0.0;
        assert!(
            slots.iter().filter(pressed).count() > 10,
            "the wheel is in the air"
        );
        for threads in [2, 4] {
            let bits = run(&config, threads, 2).1;
            assert_eq!(bits, one, "{kind}, {law}, {threads} threads");
        }
    }
}

/// Bonds between grains that nearly touch. The heap below has such pairs.
fn bonds(friction: f64, shear: f64, more: Value) -> Value {
    let mut law = json!({
        "kind": "cohesion", "friction": friction, "cn_pa_per_m": 1e11, "ct_pa_per_m": shear * 1e11,
        "w_j_per_m2": 0.1, "b_pa_m_s": 0.0, "p": 1.0, "h_prime": "one", "alert_m": 4e-4,
    });
    for (key, value) in more.as_object().into_iter().flatten() {
        law[key] = value.clone();
    }
    law
}

#[test]
fn both_solvers_find_the_same_velocities_of_bonded_grains() {
    let springs = json!({"contact_stiffness_pa": 1e9, "tangential_stiffness_ratio": 0.5});
    for law in [
        bonds(0.0, 0.0, json!({})),
        bonds(0.0, 0.5, json!({})),
        bonds(0.0, 0.5, springs.clone()),
        bonds(0.3, 0.5, springs),
    ] {
        // Gravity throws the heap up and against a side wall: some bonds stretch, some are pressed, some fail.
        let overrides = |kind: &str| json!({"gravity_m_per_s2": [-600.0, 300.0], "solver": solver(kind, 1e-11)});
        let step = |kind: &str| scene(law.clone(), 2e-5, heap(8, 8), overrides(kind));
        let (nsgs, _) = run(&step("nsgs"), 1, 120);
        let (pcg, _) = run(&step("pcg"), 1, 120);
        let state = nsgs.state();
        let pulls = state.list.slots.iter().filter(|s| s.force[0] < 0.0).count();
        let pushes = state.list.slots.iter().filter(|s| s.force[0] > 0.0).count();
        assert!(
            pulls > 10 && pushes > 5,
            "{law}: {pulls} pull, {pushes} push"
        );
        let whole = state
            .bonds
            .iter()
            .filter(|bond| bond.adhesion == 1.0)
            .count();
        assert!(whole < state.bonds.len(), "{law}: no bond of {whole} fails");
        let speed = top_speed(&nsgs);
        for (a, b) in state.velocities.iter().zip(&pcg.state().velocities) {
            for (a, b) in a.iter().zip(b) {
                assert!((a - b).abs() < 1e-7 * speed, "{law}: {a} and {b}");
            }
        }
    }
}

#[test]
fn the_conjugate_gradient_refuses_friction_with_a_rigid_bond() {
    let config = |friction: f64| {
        scene(
            bonds(friction, 1.0, json!({})),
            1e-6,
            heap(2, 2),
            json!({"solver": solver("pcg", 1e-6)}),
        )
    };
    let message = refusal(&config(0.3));
    assert!(message.contains("solver.kind"), "{message}");
    run(&config(0.0), 1, 1);
}
