use dem_kernel::bodies::Bodies;
use dem_kernel::bodies::faces::{Face, RigidWall};
use dem_kernel::contact::boundary::CompliantBoundary;
use dem_kernel::law::cohesion::{Cohesion, HPrime};
use dem_kernel::solver::criteria::{Algorithm, Criteria};
use dem_kernel::step::state::GrainState;
use dem_kernel::step::{StepInput, Stepper, WheelTurn};

use super::*;
use crate::config::radii::RadiusLaw;
use crate::config::rail::{HeightAt, RailConfig};

const RADII: [f64; 2] = [0.05e-3, 0.1e-3];
const WIDTH: f64 = 65e-3;

fn wheel(face: FaceKind) -> DemWheelConfig {
    DemWheelConfig {
        load_n: 8000.0,
        load_table: None,
        mass_kg: 0.01,
        radius_m: 0.0,
        face,
        bonded: false,
        vy_m_per_s: 0.0,
        amplitude_m: 0.0,
        frequency_hz: 300.0,
        ramp_s: 1e-3,
        hold_s: 1e-3,
        cycles: 0.0,
        rolling: None,
    }
}

fn rail(seed: Option<u64>) -> SampleConfig {
    SampleConfig::Rail(RailConfig {
        width_m: WIDTH,
        height_m: 20e-3,
        height_at: HeightAt::Edge,
        crown_radius_m: 0.3,
        radius_min_m: RADII[0],
        radius_max_m: RADII[1],
        law: RadiusLaw::SurfaceUniform,
        power: None,
        seed,
    })
}

/// The paper's wheel has 450 disks. Of p ~ r^-2 on [a, b] the mean radius is a b ln(b/a)/(b - a) = 69.3 um: 469 fill the width.
#[test]
fn a_row_as_wide_as_the_paper_s_rail_has_some_469_disks_that_touch() {
    for seed in 1..=10 {
        let row = row(&wheel(FaceKind::Disks), &rail(None), seed);
        assert!((450..=488).contains(&row.len()), "{}", row.len());
        for pair in row.windows(2) {
            let apart = pair[1].centre[0] - pair[0].centre[0];
            assert!((apart - pair[0].radius - pair[1].radius).abs() < 1e-15);
            assert_eq!(pair[0].centre[1], pair[1].centre[1]);
        }
        let (first, last) = (row[0], row[row.len() - 1]);
        let ends = [first.centre[0] - first.radius, last.centre[0] + last.radius];
        assert!((ends[0] + ends[1]).abs() < 1e-15, "{ends:?}");
        assert!(ends[1] - ends[0] <= WIDTH && ends[1] - ends[0] > WIDTH - 2.0 * RADII[1]);
        let lowest = row.iter().map(|d| d.centre[1] - d.radius);
        assert_eq!(lowest.fold(f64::INFINITY, f64::min), 0.0);
    }
}

#[test]
fn the_row_follows_the_seed_of_the_sample_and_a_smooth_face_has_none() {
    let disks = wheel(FaceKind::Disks);
    assert_eq!(row(&disks, &rail(Some(7)), 1), row(&disks, &rail(None), 7));
    assert_ne!(row(&disks, &rail(None), 1), row(&disks, &rail(None), 2));
    assert!(row(&wheel(FaceKind::Flat), &rail(None), 1).is_empty());
}

/// A grain of radius r on a floor, in the valley between two disks of radius R of the face.
fn in_a_valley(cohesion: Option<Cohesion>, bonded: bool) -> Bodies {
    let mut bodies = Bodies {
        free: 1,
        radii: vec![1e-3, 2e-3, 2e-3],
        masses: vec![1e-3],
        wheel_mass: Some(2e-3),
        face: vec![[-2e-3, 2e-3], [2e-3, 2e-3]],
        face_bonded: bonded,
        walls: vec![RigidWall {
            face: Face::HalfPlane {
                point: [0.0; 2],
                normal: [0.0, 1.0],
            },
            velocity: [0.0; 2],
        }],
        alert: 2e-5,
        skin: 2e-4,
        ..Bodies::default()
    };
    bodies.law.cohesion = cohesion;
    bodies
}

/// Gauss-Seidel to this tolerance within a number of sweeps.
fn sweeps(tolerance: f64, max_iterations: usize) -> Criteria {
    Criteria {
        algorithm: Algorithm::Nsgs,
        tolerance,
        max_iterations,
        min_iterations: 0,
        parallel: false,
    }
}

fn grain() -> [Disk; 1] {
    [Disk {
        centre: [0.0, 1e-3],
        radius: 1e-3,
        ..Disk::default()
    }]
}

/// Both contacts make the angle t with the vertical, sin t = R/(R + r): each bears F / (2 cos t), the floor F. Without weight this holds from the
/// first step on.
#[test]
fn a_grain_in_a_valley_bears_the_load_on_both_disks() {
    let bodies = in_a_valley(None, false);
    let mut state = GrainState::new(&bodies, &grain(), &[]);
    let cosine = 5f64.sqrt() / 3.0;
    let height = 1e-3 + 3e-3 * cosine - 2e-3;
    assert!((state.wheel.position[1] - height).abs() < 1e-18);
    let mut stepper = Stepper::default();
    stepper.problem.boundary = CompliantBoundary::fixed(0);
    let criteria = sweeps(1e-13, 10_000);
    let input = StepInput {
        bodies: &bodies,
        step: 1e-6,
        theta: 1.0,
        load: 30.0,
        wheel_x: 0.0,
        turn: WheelTurn::Held,
        loaded: 0.0,
        free_velocity: &[],
    };
    for _ in 0..3 {
        let summary = stepper
            .advance(&mut state, &input, &criteria)
            .expect("it is well posed");
        assert!((summary.on_wheel[1] - 30.0).abs() < 1e-6, "{summary:?}");
        assert!(summary.on_wheel[0].abs() < 1e-6);
        let forces: Vec<f64> = state.list.slots.iter().map(|s| s.force[0]).collect();
        let expected = [15.0 / cosine, 15.0 / cosine, 30.0];
        for (force, expected) in forces.iter().zip(expected) {
            assert!((force - expected).abs() < 1e-6, "{forces:?}");
        }
        assert_eq!(forces.len(), 3);
    }
}

/// The disks of the face move with the wheel, in a step of any theta.
#[test]
fn the_disks_of_the_face_move_with_the_wheel() {
    let bodies = in_a_valley(None, false);
    let mut state = GrainState::new(
        &bodies,
        &[Disk {
            centre: [1.0, 1e-3],
            ..grain()[0]
        }],
        &[],
    );
    state.wheel.position = [0.0, 0.5];
    let mut stepper = Stepper::default();
    stepper.problem.boundary = CompliantBoundary::fixed(0);
    let criteria = sweeps(1e-10, 100);
    let mut input = StepInput {
        bodies: &bodies,
        step: 1e-3,
        theta: 0.5,
        load: 2e-3,
        wheel_x: 1e-3,
        turn: WheelTurn::Held,
        loaded: 0.0,
        free_velocity: &[],
    };
    for _ in 0..2 {
        stepper
            .advance(&mut state, &input, &criteria)
            .expect("it is well posed");
        input.wheel_x += 1e-3;
    }
    // Two steps of F/m = 1 m/s2 with theta = 1/2: y falls by h^2 (1/2 + 3/2), exactly t^2/2.
    for (place, centre) in bodies.face.iter().zip(&state.centres[1..]) {
        assert!((centre[0] - place[0] - 2e-3).abs() < 1e-15, "{centre:?}");
        assert!(
            (centre[1] - place[1] - (0.5 - 2e-6)).abs() < 1e-15,
            "{centre:?}"
        );
    }
    assert_eq!(state.velocity_of(&bodies, 1)[0], 1.0);
}

#[test]
fn only_a_bonded_face_is_bonded() {
    let law = Cohesion {
        normal: 1e15,
        tangential: 1e15,
        energy: 1e3,
        viscosity: 0.0,
        power: 1.0,
        h_prime: HPrime::One,
        thickness: 1e-3,
        alert: 1e-5,
        bonds_min: 0,
        damping: 0.0,
    };
    for (bonded, pairs) in [(false, vec![]), (true, vec![(0, 1), (0, 2)])] {
        let bodies = in_a_valley(Some(law), bonded);
        let state = GrainState::new(&bodies, &grain(), &[]);
        let found: Vec<(u32, u32)> = state.bonds.iter().map(|bond| bond.pair()).collect();
        assert_eq!(found, pairs);
    }
}
