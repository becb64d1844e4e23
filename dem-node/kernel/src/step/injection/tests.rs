//! A grain of radius 1 that is fed in between two walls 1.8 apart: it begins with 0.9 of their distance, and ends pressed by both.

use super::*;
use crate::bodies::disk::Disk;
use crate::bodies::faces::{Face, RigidWall};
use crate::bodies::feed::{Feed, Injection, PointSource};
use crate::contact::boundary::CompliantBoundary;
use crate::law::adhesion::Adhesion;
use crate::law::{Law, Springs};
use crate::solver::criteria::{Algorithm, Criteria};
use crate::step::{StepInput, Stepper, WheelTurn};

/// Stiffness of a contact (N/m), and half the distance of the walls (m).
const K: f64 = 1000.0;
const HALF: f64 = 0.9;
const STEP: f64 = 1e-3;
/// Time at which the grain is due, time in which it grows (s).
const DUE: f64 = 0.1;
const GROWTH: f64 = 0.5;

fn between_walls() -> Bodies {
    let wall = |y: f64| RigidWall {
        face: Face::HalfPlane {
            point: [0.0, y],
            normal: [0.0, -y.signum()],
        },
        velocity: [0.0; 2],
    };
    let injection = Injection {
        grains: 1,
        growth: GROWTH,
        source: Source::Point(PointSource {
            point: [5.0, 0.125],
            rate: 2.0 / DUE,
            start: 0.0,
            end: 10.0,
        }),
    };
    Bodies {
        free: 1,
        radii: vec![1.0],
        masses: vec![2.0],
        walls: vec![wall(-HALF), wall(HALF)],
        injection: Some(injection),
        law: Law {
            springs: Some(Springs {
                normal: K,
                tangential: K,
                damping: 0.0,
            }),
            ..Law::default()
        },
        alert: 0.02,
        skin: 0.2,
        ..Bodies::default()
    }
}

fn march(bodies: &Bodies, end: f64, mut watch: impl FnMut(f64, &GrainState)) -> GrainState {
    let grain = Disk {
        centre: [5.0, 0.125],
        radius: 1.0,
        ..Disk::default()
    };
    let mut state = GrainState::new(bodies, &[grain], &[]);
    let mut stepper = Stepper::default();
    stepper.problem.boundary = CompliantBoundary::fixed(0);
    let criteria = Criteria {
        algorithm: Algorithm::Nsgs,
        tolerance: 1e-12,
        max_iterations: 1000,
        min_iterations: 1,
        parallel: false,
    };
    for step in 1..=(end / STEP).round() as u32 {
        let time = f64::from(step) * STEP;
        let input = StepInput {
            bodies,
            step: STEP,
            theta: 1.0,
            load: 0.0,
            wheel_x: 0.0,
            turn: WheelTurn::Held,
            loaded: time,
            free_velocity: &[],
        };
        stepper
            .advance(&mut state, &input, &criteria)
            .expect("it is well posed");
        watch(time, &state);
    }
    state
}

/// The exact end: both walls press by k 0.1, and the springs store k 0.1^2 / 2 each, the work of growing. The energy of the springs in the step in
/// which they close is less than the work over the way of one step.
#[test]
fn a_grain_that_grows_is_pressed_by_its_overlaps_and_its_work_is_in_the_springs() {
    let bodies = between_walls();
    let state = march(&bodies, DUE + GROWTH + 0.2, |time, state| {
        let there = time > DUE - 0.5 * STEP;
        assert_eq!(state.present(&bodies), usize::from(there), "{time}");
        if !there {
            assert!(state.list.slots.is_empty(), "{time}");
            assert_eq!(state.radius(&bodies, 0), 0.0);
            return;
        }
        let first = FILLED * HALF;
        let grown = first + (1.0 - first) * ((time - DUE) / GROWTH).min(1.0);
        assert!((state.radius(&bodies, 0) - grown).abs() < 1e-12, "{time}");
    });
    assert!((state.centres[0][1]).abs() < 1e-12, "{:?}", state.centres);
    let forces: Vec<f64> = state.list.slots.iter().map(|s| s.force[0]).collect();
    assert_eq!(forces.len(), 2);
    for force in forces {
        assert!((force - 0.1 * K).abs() < 1e-9, "{force}");
    }
    let springs = K * 0.01;
    assert!((state.springs(&bodies)[0] - springs).abs() < 1e-9);
    let a_step = K * (0.11 * STEP / GROWTH).powi(2);
    let work = state.ledger.injection;
    assert!((work - springs).abs() < a_step, "{work} {springs}");
    let booked = work - state.ledger.impact - state.ledger.detection;
    assert!((booked - springs).abs() < 1e-12, "{booked} {springs}");
}

/// Walls that attract the grain press it no more than other walls, and the ledger has the energy of their attraction.
#[test]
fn a_grain_that_grows_between_walls_that_attract_it_balances() {
    let mut bodies = between_walls();
    bodies.law.adhesion = Some(Adhesion {
        force: 20.0,
        by_radius: 0.0,
        range: 0.05,
    });
    let state = march(&bodies, DUE + GROWTH + 0.2, |_, _| {});
    let [normal, _, _, attraction] = state.springs(&bodies);
    assert!((normal - K * 0.01).abs() < 1e-9);
    assert!(
        (attraction + 2.0 * 20.0 * 0.15).abs() < 1e-9,
        "{attraction}"
    );
    let ledger = &state.ledger;
    let lost = ledger.impact + ledger.detection + ledger.numerical;
    let left = ledger.injection - lost - normal - attraction;
    assert!(left.abs() < 1e-9, "{left}");
}

/// The positions half-way between the walls are the furthest from both; the first of them is on the left.
#[test]
fn a_grain_begins_where_the_gap_is_widest() {
    let bodies = between_walls();
    let state = march(&bodies, DUE, |_, _| {});
    let [x, y] = state.centres[0];
    assert!(y.abs() < 1e-12 && (3.0..5.0).contains(&x), "{x} {y}");
    let missed = state.feed.missed(0.0);
    assert_eq!(missed, 0.0);
}

/// There is as much room below a row of disks between the walls as above it, and the lower position comes first; or more room above.
#[test]
fn a_grain_begins_above_the_base_and_below_the_face() {
    let row = |x: i32| [f64::from(x), 0.0];
    let places: Vec<[f64; 2]> = (3..8).map(row).collect();
    let count = places.len();
    let with_row = |change: fn(&mut Bodies, Vec<[f64; 2]>)| {
        let mut bodies = between_walls();
        for wall in &mut bodies.walls {
            if let Face::HalfPlane { point, .. } = &mut wall.face {
                point[1] *= 3.0;
            }
        }
        change(&mut bodies, places.clone());
        bodies.radii.extend(vec![0.5; count]);
        bodies
    };
    let base = with_row(|bodies, places| {
        bodies.base = places.len();
        bodies.reference = places;
    });
    let face = with_row(|bodies, places| {
        bodies.face = places;
        bodies.wheel_mass = Some(1.0);
        // Above there is even more room.
        if let Face::HalfPlane { point, .. } = &mut bodies.walls[1].face {
            point[1] += 1.0;
        }
    });
    for (bodies, side) in [(base, 1.0), (face, -1.0)] {
        let mut state = GrainState {
            centres: std::iter::once([5.0, 0.125])
                .chain(places.clone())
                .collect(),
            feed: Feed::new(bodies.injection.as_ref()),
            velocities: vec![[0.0; 3]],
            ..GrainState::default()
        };
        feed(&mut state, &bodies, DUE);
        assert_eq!(state.present(&bodies), 1);
        let y = state.centres[0][1];
        assert!(side * y > 0.5, "{y} of a row at 0");
    }
}

/// Walls with room for less than a twentieth of its radius keep it in store, which is reported once a whole grain is late.
#[test]
fn a_grain_without_a_gap_stays_in_store_and_is_missed() {
    let mut bodies = between_walls();
    for wall in &mut bodies.walls {
        if let Face::HalfPlane { point, .. } = &mut wall.face {
            point[1] *= 0.5 * LEAST / HALF;
        }
    }
    let state = march(&bodies, 3.0 * DUE, |_, _| {});
    assert_eq!(state.present(&bodies), 0);
    // Three are due, and one of them may be under way.
    let missed = state.feed.missed(2.0);
    assert!((missed - 2.0 / 3.0).abs() < 1e-12, "{missed}");
}
