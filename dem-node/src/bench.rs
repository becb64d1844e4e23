//! What a contact costs: the solvers on one cold load step of dense packs.
//!
//! A bed of soft disks is pressed between four plates; larger packs are its mirror images side by side, which touch as
//! the bed touches its plates. Then the disks count as rigid and touching (LMGC90's IQS: overlaps are not repaired),
//! and the upper plate is loaded with 690 MPa in one step of 1 us from rest, without any first guess: no step of a
//! run is harder.

use std::f64::consts::PI;
use std::hint::black_box;
use std::time::Instant;

use serde::Serialize;

use crate::bodies::Bodies;
use crate::cluster::Clusters;
use crate::config::RadiusLaw;
use crate::error::DemError;
use crate::faces::{Face, HalfPlane, RigidWall};
use crate::law::{Friction, Law, Penetration};
use crate::node;
use crate::sample::grading::Dice;
use crate::sample::relax::Pile;
use crate::sample::{Disk, layer};
use crate::setup::{ALERT, SKIN};
use crate::solver::{Algorithm, Criteria, Problem};
use crate::state::State;
use crate::step::{Drive, Stepper};
use crate::wall::Wall;

const STEP: f64 = 1e-6;
const PRESSURE: f64 = 690e6;
const DENSITY: f64 = 7800.0;
const THICKNESS: f64 = 1e-3;
const RADII: [f64; 2] = [0.05e-3, 0.1e-3];
/// Solid fraction of the beds, just above jamming: 2.2 contacts a disk.
const FRACTION: f64 = 0.852;
/// Most relaxation steps of a bed.
const RELAXATIONS: usize = 4_000;
const FRICTION: f64 = 0.3;
/// Passes of each timing; the quietest counts.
const PASSES: usize = 5;
/// Iterations that a timing leaves out, and those that it counts.
const WARM: usize = 20;
const TIMED: usize = 80;
/// Load steps with and without a first guess.
const STEPS: usize = 3;
/// Where a search for a tolerance ends.
const MOST_ITERATIONS: usize = 20_000;

/// One solver on one problem.
#[derive(Clone, Debug, Serialize)]
pub struct BenchRow {
    /// Disks of the pack.
    pub disks: usize,
    /// Contacts of the problem, those with plates included.
    pub contacts: usize,
    /// `nsgs` or `pcg`.
    pub solver: &'static str,
    /// `signorini` or `coulomb`.
    pub law: &'static str,
    /// Threads of the solver.
    pub threads: usize,
    /// Time of a whole iteration over the contacts (ns).
    pub ns_per_contact_iteration: f64,
    /// Iterations from nothing to a true residual of 1e-3; absent where the search was given up.
    #[serde(rename = "iterations_to_1e-3")]
    pub iterations_to_1e3: Option<usize>,
    /// The same to 1e-4.
    #[serde(rename = "iterations_to_1e-4")]
    pub iterations_to_1e4: Option<usize>,
    /// Iterations to 1e-3 of three load steps in a row without first guess, and with the impulses of the step before;
    /// absent with several threads, which change nothing.
    pub iterations_cold: Option<[usize; STEPS]>,
    /// See `iterations_cold`.
    pub iterations_warm: Option<[usize; STEPS]>,
    /// How much faster than one thread the iterations are, and how much faster a loop that only computes is on as many
    /// threads in the same run; absent with one thread.
    pub scaling: Option<f64>,
    /// See `scaling`.
    pub compute_scaling: Option<f64>,
    /// A step whose Verlet list still holds, without its iterations: contacts from positions, local blocks, the sorting
    /// of the solver and one residual (ms).
    pub detect_prepare_ms: f64,
    /// The same of a step that makes a new Verlet list.
    pub detect_rebuild_ms: f64,
    /// Highest memory of the process so far (bytes).
    pub peak_rss_bytes: u64,
    /// What the machine's measured bandwidth and arithmetic allow for the same bytes and operations (ns).
    pub bound_ns: f64,
}

/// All rows: packs of about 1 000, 10 000 and 73 000 disks.
pub fn bench() -> Result<Vec<BenchRow>, DemError> {
    let mut rows = Vec::new();
    for (disks, columns, lines) in [(1_000, 1, 1), (10_000, 1, 1), (9_125, 4, 2)] {
        let pack = Pack::new(disks, columns, lines);
        let coulomb = Friction::Coulomb {
            coefficient: FRICTION,
        };
        for (solver, law) in [
            (Algorithm::Nsgs, Friction::Signorini),
            (Algorithm::Nsgs, coulomb),
            (Algorithm::Pcg, Friction::Signorini),
            (Algorithm::Pcg, coulomb),
        ] {
            let one = pack.row(solver, law, 1)?;
            let mut two = pack.row(solver, law, 2)?;
            two.scaling = Some(one.ns_per_contact_iteration / two.ns_per_contact_iteration);
            two.compute_scaling = Some(compute_scaling(2)?);
            rows.extend([one, two]);
        }
    }
    Ok(rows)
}

/// Disks between a floor, two side walls and a plate above, at 0 <= x <= width and y >= 0.
struct Pack {
    disks: Vec<Disk>,
    width: f64,
}

impl Pack {
    /// A pressed bed of about so many disks and its mirror images, `columns` by `lines`.
    fn new(disks: usize, columns: usize, lines: usize) -> Pack {
        let pile = pressed(disks);
        let (width, height) = (2.0 * pile.half_width, pile.ceiling - pile.floor);
        let mut all = Vec::new();
        for column in 0..columns {
            for line in 0..lines {
                for (centre, radius) in pile.centres.iter().zip(&pile.radii) {
                    let x = mirrored(centre[0] + pile.half_width, width, column);
                    let y = mirrored(centre[1] - pile.floor, height, line);
                    all.push(Disk {
                        centre: [x, y],
                        radius: *radius,
                        ..Disk::default()
                    });
                }
            }
        }
        Pack {
            disks: layer::in_columns(all),
            width: width * columns as f64,
        }
    }

    fn bodies(&self, friction: Friction) -> Bodies {
        let mass = |disk: &Disk| DENSITY * PI * disk.radius * disk.radius * THICKNESS;
        let wall = |point, normal| RigidWall::at_rest(Face::HalfPlane(HalfPlane { point, normal }));
        Bodies {
            free: self.disks.len(),
            radii: self.disks.iter().map(|disk| disk.radius).collect(),
            masses: self.disks.iter().map(mass).collect(),
            gravity: [0.0; 2],
            reference: Vec::new(),
            base: 0,
            wheel_mass: Some(DENSITY * self.width * RADII[1] * THICKNESS),
            clusters: Clusters::default(),
            wheel_radius: 0.0,
            walls: vec![
                wall([0.0, 0.0], [0.0, 1.0]),
                wall([0.0, 0.0], [1.0, 0.0]),
                wall([self.width, 0.0], [-1.0, 0.0]),
            ],
            law: Law {
                friction,
                springs: None,
                cohesion: None,
                restitution: None,
                penetration: Penetration::Gap,
            },
            period: None,
            pulled: None,
            alert: ALERT * RADII[0],
            skin: SKIN * RADII[0],
        }
    }

    /// The cold load step: its problem, and the times of posing it with the Verlet list at hand and with a new one (s).
    fn cold(&self, friction: Friction) -> (Problem, [f64; 2]) {
        let bodies = self.bodies(friction);
        let mut state = State::new(&bodies, &self.disks, &[]);
        let drive = Drive {
            step: STEP,
            theta: 1.0,
            load: 0.0,
            wheel_x: 0.0,
            free_velocity: &[],
        };
        let mut stepper = Stepper::default();
        stepper.problem.wall = Wall::fixed(0);
        stepper.pose(&bodies, &mut state, &drive);
        let posing = quietest(|| stepper.pose(&bodies, &mut state, &drive));
        let listing = quietest(|| {
            state.list.expire();
            stepper.pose(&bodies, &mut state, &drive);
        });
        let mut cold = stepper.problem;
        self.load(&mut cold);
        for contact in &mut cold.contacts {
            contact.bias[0] = contact.bias[0].max(0.0);
        }
        (cold, [posing, listing])
    }

    /// Loads the plate for a step. The load comes after detection: a light plate under such a load would fly through the
    /// pack in one step.
    fn load(&self, problem: &mut Problem) {
        let plate = &mut problem.movers[self.disks.len()];
        plate.velocity[1] -= STEP * PRESSURE * self.width * THICKNESS * plate.inverse_mass;
    }

    /// Iterations of each of the steps, with the impulses of the one before as first guess or without.
    fn iterations(
        &self,
        cold: &Problem,
        criteria: &Criteria,
        warm: bool,
    ) -> Result<Option<[usize; STEPS]>, DemError> {
        let mut problem = cold.clone();
        let mut iterations = [0; STEPS];
        for (step, count) in iterations.iter_mut().enumerate() {
            if step > 0 {
                self.go_on(&mut problem, warm);
            }
            let verdict = problem.solve(criteria)?;
            if !verdict.converged {
                return Ok(None);
            }
            *count = verdict.iterations;
        }
        Ok(Some(iterations))
    }

    /// Opens or closes the gaps by a step, loads the plate again and keeps or forgets the impulses.
    fn go_on(&self, problem: &mut Problem, warm: bool) {
        let mut contacts = std::mem::take(&mut problem.contacts);
        for contact in &mut contacts {
            contact.gap += STEP * problem.relative_velocity(contact)[0];
            contact.bias[0] = contact.gap.max(0.0) / STEP;
            if !warm {
                contact.impulse = [0.0; 2];
            }
        }
        problem.contacts = contacts;
        self.load(problem);
    }

    fn row(
        &self,
        algorithm: Algorithm,
        friction: Friction,
        threads: usize,
    ) -> Result<BenchRow, DemError> {
        let (cold, poses) = self.cold(friction);
        let criteria = |tolerance: f64, iterations: usize| Criteria {
            algorithm,
            tolerance,
            min_iterations: if tolerance == 0.0 { iterations } else { 1 },
            max_iterations: iterations,
            parallel: threads > 1,
        };
        let pool = node::pool(threads)?;
        let solve = |criteria: Criteria| {
            let mut problem = cold.clone();
            node::in_pool(pool.as_ref(), || {
                let start = Instant::now();
                let verdict = problem.solve(&criteria)?;
                Ok::<_, DemError>((verdict, start.elapsed().as_secs_f64()))
            })
        };
        let (mut once, mut short, mut long) = (f64::INFINITY, f64::INFINITY, f64::INFINITY);
        for _ in 0..PASSES {
            once = once.min(solve(criteria(0.0, 1))?.1);
            short = short.min(solve(criteria(0.0, WARM))?.1);
            long = long.min(solve(criteria(0.0, WARM + TIMED))?.1);
        }
        let per_iteration = (long - short) / TIMED as f64;
        let [posing, listing] = poses.map(|pose| pose + (once - per_iteration).max(0.0));
        let reach = |tolerance: f64| -> Result<Option<usize>, DemError> {
            let (verdict, _) = solve(criteria(tolerance, MOST_ITERATIONS))?;
            Ok(verdict.converged.then_some(verdict.iterations))
        };
        let repeated = |warm: bool| match threads {
            1 => self.iterations(&cold, &criteria(1e-3, MOST_ITERATIONS), warm),
            _ => Ok(None),
        };
        Ok(BenchRow {
            iterations_cold: repeated(false)?,
            iterations_warm: repeated(true)?,
            scaling: None,
            compute_scaling: None,
            disks: self.disks.len(),
            contacts: cold.contacts.len(),
            solver: match algorithm {
                Algorithm::Nsgs => "nsgs",
                Algorithm::Pcg => "pcg",
            },
            law: match friction {
                Friction::Signorini => "signorini",
                Friction::Coulomb { .. } => "coulomb",
            },
            threads,
            ns_per_contact_iteration: per_iteration * 1e9 / cold.contacts.len() as f64,
            iterations_to_1e3: reach(1e-3)?,
            iterations_to_1e4: reach(1e-4)?,
            detect_prepare_ms: 1e3 * posing,
            detect_rebuild_ms: 1e3 * listing,
            peak_rss_bytes: peak_rss(),
            bound_ns: bound(&cold, algorithm, friction),
        })
    }
}

/// Coordinate in the `copy`-th image of [0, length], every other one mirrored.
fn mirrored(x: f64, length: f64, copy: usize) -> f64 {
    let inside = if copy.is_multiple_of(2) {
        x
    } else {
        length - x
    };
    inside + length * copy as f64
}

/// A square bed between four fixed plates, relaxed until its forces are balanced to a percent.
fn pressed(disks: usize) -> Pile {
    let mut dice = Dice::new(1);
    let radii: Vec<f64> = (0..disks)
        .map(|_| dice.radius(RadiusLaw::SurfaceUniform, RADII[0], RADII[1]))
        .collect();
    let area: f64 = radii.iter().map(|r| PI * r * r).sum();
    let half_width = 0.5 * (area / FRACTION).sqrt();
    let centres = radii.iter().map(|r| {
        let mut place = || dice.between(r - half_width, half_width - r);
        [place(), place()]
    });
    let mut pile = Pile {
        centres: centres.collect(),
        movable: disks,
        radii,
        period: None,
        ceiling: half_width,
        floor: -half_width,
        half_width,
        thrust: None,
    };
    pile.relax(RELAXATIONS, |load| load.unbalanced() <= 1e-2 * load.mean());
    pile
}

/// The time of the quietest pass (s).
fn quietest(mut work: impl FnMut()) -> f64 {
    let pass = |_| {
        let start = Instant::now();
        work();
        start.elapsed().as_secs_f64()
    };
    (0..PASSES).map(pass).fold(f64::INFINITY, f64::min)
}

/// The longer of two times: moving the bytes of an iteration from where they lie, and doing its operations on
/// data at hand. Both rates are measured here and now, on buffers of the problem's own size.
fn bound(problem: &Problem, algorithm: Algorithm, friction: Friction) -> f64 {
    let frictional = matches!(friction, Friction::Coulomb { .. });
    // Per contact: its stored numbers, read and written, and its share of the records of the bodies, read and written
    // (32 bytes each, with the conjugate gradient 88).
    let contacts = problem.contacts.len() as f64;
    let records = problem.movers.len() as f64 / contacts;
    let (bytes, operations) = match (algorithm, frictional) {
        (Algorithm::Nsgs, false) => (48.0 + 8.0 + 64.0 * records, 30.0),
        (Algorithm::Nsgs, true) => (72.0 + 16.0 + 64.0 * records, 62.0),
        (Algorithm::Pcg, false) => (64.0 + 24.0 + 176.0 * records, 45.0),
        (Algorithm::Pcg, true) => (112.0 + 48.0 + 176.0 * records, 100.0),
    };
    let numbers = (bytes * contacts / 8.0) as usize;
    (bytes * byte_time(numbers)).max(operations * operation_time()) * 1e9
}

/// Time to read and rewrite a byte of a buffer of so many numbers (s).
fn byte_time(numbers: usize) -> f64 {
    let mut buffer = vec![1.0f64; numbers];
    let rounds = (1 << 23) / numbers + 1;
    let time = quietest(|| {
        for _ in 0..rounds {
            black_box(&mut buffer[..])
                .iter_mut()
                .for_each(|x| *x += 1.0);
        }
    });
    time / (rounds * numbers * 8) as f64
}

/// Time of a multiplication or addition in independent lanes (s).
fn operation_time() -> f64 {
    const ROUNDS: usize = 1 << 18;
    let mut lanes = black_box([1.0f64; 16]);
    let time = quietest(|| {
        for _ in 0..ROUNDS {
            for x in &mut lanes {
                *x = *x * 0.999 + 0.001;
            }
        }
        black_box(&lanes);
    });
    time / (ROUNDS * 32) as f64
}

/// How much faster this many threads do work that needs neither memory nor each other.
fn compute_scaling(threads: usize) -> Result<f64, DemError> {
    let share = |rounds: usize| {
        let mut lanes = black_box([1.0f64; 16]);
        for _ in 0..rounds {
            for x in &mut lanes {
                *x = *x * 0.999 + 0.001;
            }
        }
        black_box(&lanes);
    };
    const ROUNDS: usize = 1 << 20;
    let one = quietest(|| share(ROUNDS));
    let pool = node::pool(threads)?;
    let all = node::in_pool(pool.as_ref(), || {
        quietest(|| {
            rayon::scope(|scope| {
                for _ in 0..threads {
                    scope.spawn(|_| share(ROUNDS / threads));
                }
            })
        })
    });
    Ok(one / all)
}

/// Highest resident memory so far (bytes), 0 where the system does not tell.
fn peak_rss() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let kibibytes = line.and_then(|line| {
        line.trim()
            .trim_end_matches("kB")
            .trim()
            .parse::<u64>()
            .ok()
    });
    kibibytes.unwrap_or(0) * 1024
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A first guess from the step before must save most of the iterations of a load that goes on.
    #[test]
    fn warm_starts_save_iterations() {
        let pack = Pack::new(200, 1, 1);
        let friction = Friction::Coulomb {
            coefficient: FRICTION,
        };
        let row = pack
            .row(Algorithm::Nsgs, friction, 1)
            .expect("the pack can be solved");
        let cold = row.iterations_cold.expect("it converges");
        let warm = row.iterations_warm.expect("it converges");
        assert_eq!(cold[0], warm[0], "the first step has no guess");
        assert!(2 * warm[2] < cold[2], "{cold:?} {warm:?}");
    }
}
