//! Dense packs and their load steps.
//!
//! Four plates press a bed of soft disks; larger packs are its mirror images side by side, which touch as
//! the bed touches its plates. Then the disks count as rigid and touching (LMGC90's IQS: overlaps are not repaired),
//! and one step of 1 us from rest loads the upper plate with 690 MPa, without a first guess: no step of a
//! run is harder.

use std::f64::consts::PI;

use dem_kernel::bodies::Bodies;
use dem_kernel::bodies::disk::{Disk, in_columns};
use dem_kernel::bodies::faces::{Face, RigidWall};
use dem_kernel::contact::boundary::CompliantBoundary;
use dem_kernel::law::Law;
use dem_kernel::random::RandomNumbers;
use dem_kernel::relax::Packing;
use dem_kernel::solver::problem::Problem;
use dem_kernel::step::state::GrainState;
use dem_kernel::step::{StepInput, Stepper, WheelTurn};

/// Coefficient of friction.
pub const FRICTION: f64 = 0.3;
/// Length of the step (s).
pub const STEP: f64 = 1e-6;
/// Skin of the Verlet list (m), and gap below which contacts are in the problem.
pub const SKIN: f64 = 0.2 * RADII[0];
const ALERT: f64 = 0.02 * RADII[0];
const PRESSURE: f64 = 690e6;
const DENSITY: f64 = 7800.0;
const THICKNESS: f64 = 1e-3;
const RADII: [f64; 2] = [0.05e-3, 0.1e-3];
/// Solid fraction of the beds, just above jamming: 2.2 contacts per disk.
const FRACTION: f64 = 0.852;
/// Largest number of relaxation steps of a bed.
const RELAXATIONS: usize = 4_000;

/// Disks between a floor, two side walls and a plate above, at 0 <= x <= width and y >= 0.
pub struct Pack {
    pub disks: Vec<Disk>,
    width: f64,
}

impl Pack {
    /// A pressed bed of about this many disks and its mirror images, `columns` by `lines`.
    pub fn new(disks: usize, columns: usize, lines: usize) -> Pack {
        let packing = pressed(disks);
        let (width, height) = (2.0 * packing.half_width, packing.ceiling - packing.floor);
        let mut all = Vec::new();
        for column in 0..columns {
            for line in 0..lines {
                for (centre, radius) in packing.centres.iter().zip(&packing.radii) {
                    let x = mirrored(centre[0] + packing.half_width, width, column);
                    let y = mirrored(centre[1] - packing.floor, height, line);
                    all.push(Disk::at_rest([x, y], *radius));
                }
            }
        }
        Pack {
            disks: in_columns(all),
            width: width * columns as f64,
        }
    }

    /// The disks between their walls.
    pub fn bodies(&self, friction: f64) -> Bodies {
        let mass = |disk: &Disk| DENSITY * PI * disk.radius * disk.radius * THICKNESS;
        let wall = |point, normal| RigidWall {
            face: Face::HalfPlane { point, normal },
            velocity: [0.0; 2],
        };
        Bodies {
            free: self.disks.len(),
            radii: self.disks.iter().map(|disk| disk.radius).collect(),
            masses: self.disks.iter().map(mass).collect(),
            wheel_mass: Some(DENSITY * self.width * RADII[1] * THICKNESS),
            walls: vec![
                wall([0.0, 0.0], [0.0, 1.0]),
                wall([0.0, 0.0], [1.0, 0.0]),
                wall([self.width, 0.0], [-1.0, 0.0]),
            ],
            law: Law {
                friction,
                ..Law::default()
            },
            alert: ALERT,
            skin: SKIN,
            ..Bodies::default()
        }
    }

    /// The problem of the cold load step.
    pub fn cold(&self, friction: f64) -> Problem {
        let bodies = self.bodies(friction);
        let mut state = GrainState::new(&bodies, &self.disks, &[]);
        let mut stepper = Stepper::default();
        stepper.problem.boundary = CompliantBoundary::fixed(0);
        stepper.assemble(&mut state, &input(&bodies), false);
        let mut cold = stepper.problem;
        self.load(&mut cold);
        for contact in &mut cold.contacts {
            contact.bias[0] = contact.bias[0].max(0.0);
        }
        cold
    }

    /// Loads the plate for a step. The load comes after detection: a light plate under such a load would fly through the
    /// pack in one step.
    pub fn load(&self, problem: &mut Problem) {
        let plate = &mut problem.records[self.disks.len()];
        plate.velocity[1] -= STEP * PRESSURE * self.width * THICKNESS * plate.inverse_mass;
    }
}

/// A step of these bodies, without any load.
pub fn input(bodies: &Bodies) -> StepInput<'_> {
    StepInput {
        bodies,
        step: STEP,
        theta: 1.0,
        load: 0.0,
        wheel_x: 0.0,
        turn: WheelTurn::Held,
        loaded: 0.0,
        free_velocity: &[],
    }
}

/// Coordinate in the `copy`-th image of [0, length], every other one mirrored.
fn mirrored(x: f64, length: f64, copy: usize) -> f64 {
    let inside = [x, length - x][copy % 2];
    inside + length * copy as f64
}

/// A square bed between four fixed plates, relaxed until its forces are balanced to a percent.
fn pressed(disks: usize) -> Packing {
    let mut random = RandomNumbers::new(1);
    // Equal surface in each class of radius.
    let [a, b] = RADII;
    let mut radius = || 1.0 / (1.0 / a - random.unit() * (1.0 / a - 1.0 / b));
    let radii: Vec<f64> = (0..disks).map(|_| radius()).collect();
    let area: f64 = radii.iter().map(|r| PI * r * r).sum();
    let half_width = 0.5 * (area / FRACTION).sqrt();
    let centres = radii.iter().map(|r| {
        let mut place = || random.between(r - half_width, half_width - r);
        [place(), place()]
    });
    let mut packing = Packing {
        centres: centres.collect(),
        movable: disks,
        radii,
        ceiling: half_width,
        floor: -half_width,
        half_width,
        ..Packing::default()
    };
    packing.relax(RELAXATIONS, |load| load.unbalanced() <= 1e-2 * load.mean());
    packing
}
