//! Cost of a contact: the solvers on one cold load step of dense packs.
//!
//! A bed of soft disks is pressed between four plates; larger packs are its mirror images side by side, which touch as
//! the bed touches its plates. Then the disks count as rigid and touching (LMGC90's IQS: overlaps are not repaired),
//! and the upper plate is loaded with 690 MPa in one step of 1 us from rest, without any first guess: no step of a
//! run is harder.

mod machine;
mod pack;

use std::time::{Duration, Instant};

use serde::Serialize;

use crate::error::KernelError;
use crate::solver::Solver;
use crate::solver::criteria::{Algorithm, Criteria};
use crate::solver::problem::Problem;
use crate::step::threads;
use machine::{PASSES, byte_time, operation_time, peak_rss};
use pack::Pack;

const FRICTION: f64 = 0.3;
/// Least time for which one thread, two threads and the loop that only computes take turns.
const TURNS: Duration = Duration::from_secs(3);
/// Iterations that a timing leaves out, and those that it counts.
const WARM: usize = 20;
const TIMED: usize = 80;
/// Solves of each length before it is another one's turn.
const TURN: usize = 4;
/// Load steps with and without a first guess.
const STEPS: usize = 3;
/// End of a search for a tolerance.
const MOST_ITERATIONS: usize = 20_000;

/// One solver on one problem.
#[derive(Clone, Debug, Serialize)]
pub struct ContactBenchRow {
    /// Disks of the pack.
    pub disks: usize,
    /// Contacts of the problem, those with plates included.
    pub contacts: usize,
    /// The algorithm.
    pub solver: Algorithm,
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
    /// Speed-up of the iterations over one thread, and that of a loop that only computes on as many
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
    /// Least time that the machine's measured bandwidth and arithmetic allow for the same bytes and operations (ns).
    pub bound_ns: f64,
}

/// All rows: packs of about 1 000, 10 000 and 73 000 disks.
pub fn bench() -> Result<Vec<ContactBenchRow>, KernelError> {
    let mut rows = Vec::new();
    for (disks, columns, lines) in [(1_000, 1, 1), (10_000, 1, 1), (9_125, 4, 2)] {
        let pack = Pack::new(disks, columns, lines);
        for solver in [Algorithm::Nsgs, Algorithm::Pcg] {
            rows.extend(pack.rows(solver, 0.0)?);
            rows.extend(pack.rows(solver, FRICTION)?);
        }
    }
    Ok(rows)
}

impl Pack {
    /// Iterations of each of the steps, with the impulses of the one before as first guess or without.
    fn iterations(
        &self,
        cold: &Problem,
        criteria: &Criteria,
        warm: bool,
    ) -> Result<Option<[usize; STEPS]>, KernelError> {
        let (mut problem, mut solver) = (cold.clone(), Solver::default());
        let mut iterations = [0; STEPS];
        for (step, count) in iterations.iter_mut().enumerate() {
            if step > 0 {
                self.go_on(&mut problem, warm);
            }
            let convergence = solver.solve(&mut problem, criteria)?;
            if !convergence.converged {
                return Ok(None);
            }
            *count = convergence.iterations;
        }
        Ok(Some(iterations))
    }

    /// The rows of one thread and of two.
    fn rows(
        &self,
        algorithm: Algorithm,
        friction: f64,
    ) -> Result<[ContactBenchRow; 2], KernelError> {
        let (cold, poses) = self.cold(friction);
        let times = times(&cold, algorithm)?;
        let contacts = cold.contacts.len();
        let row = |threads: usize, time: &Times| -> Result<ContactBenchRow, KernelError> {
            let criteria =
                |tolerance: f64| criteria(algorithm, tolerance, MOST_ITERATIONS, threads);
            let pool = threads::pool(threads)?;
            let reach = |tolerance: f64| -> Result<Option<usize>, KernelError> {
                let mut problem = cold.clone();
                let convergence = threads::in_pool(pool.as_ref(), || {
                    Solver::default().solve(&mut problem, &criteria(tolerance))
                })?;
                Ok(convergence.converged.then_some(convergence.iterations))
            };
            let repeated = |warm: bool| match threads {
                1 => self.iterations(&cold, &criteria(1e-3), warm),
                _ => Ok(None),
            };
            let scaling = |of: fn(&Times) -> f64| (threads > 1).then(|| of(&times[0]) / of(time));
            let rest = (time.once - time.iteration()).max(0.0);
            let [posing, listing] = poses.map(|pose| pose + rest);
            Ok(ContactBenchRow {
                disks: self.disks.len(),
                contacts,
                solver: algorithm,
                law: ["signorini", "coulomb"][usize::from(friction > 0.0)],
                threads,
                ns_per_contact_iteration: time.iteration() * 1e9 / contacts as f64,
                iterations_to_1e3: reach(1e-3)?,
                iterations_to_1e4: reach(1e-4)?,
                iterations_cold: repeated(false)?,
                iterations_warm: repeated(true)?,
                scaling: scaling(Times::iteration),
                compute_scaling: scaling(|time| time.compute),
                detect_prepare_ms: 1e3 * posing,
                detect_rebuild_ms: 1e3 * listing,
                peak_rss_bytes: peak_rss(),
                bound_ns: bound(&cold, algorithm, friction),
            })
        };
        Ok([row(1, &times[0])?, row(2, &times[1])?])
    }
}

/// Least times of a number of threads (s).
#[derive(Clone, Copy, Debug)]
struct Times {
    /// A solve of one iteration, of those left out, and of all.
    once: f64,
    short: f64,
    long: f64,
    /// The loop that only computes.
    compute: f64,
}

impl Times {
    fn iteration(&self) -> f64 {
        (self.long - self.short) / TIMED as f64
    }
}

/// The times of one thread and of two, which take turns: a machine that others use too is not the same a second later.
/// A solve begins from the cold step each time, but in the buffers of the one before, as in a run.
fn times(cold: &Problem, algorithm: Algorithm) -> Result<[Times; 2], KernelError> {
    let pools = [threads::pool(1)?, threads::pool(2)?];
    let never = f64::INFINITY;
    let mut times = [Times {
        once: never,
        short: never,
        long: never,
        compute: never,
    }; 2];
    let mut problems = [cold, cold].map(|cold| (cold.clone(), Solver::default()));
    let start = Instant::now();
    let mut passes = 0;
    while passes < PASSES || start.elapsed() < TURNS {
        for (i, ((pool, least), (problem, solver))) in
            pools.iter().zip(&mut times).zip(&mut problems).enumerate()
        {
            let threads = i + 1;
            let mut solve = |iterations: usize| {
                problem.contacts.clone_from(&cold.contacts);
                problem.records.clone_from(&cold.records);
                problem.boundary.clone_from(&cold.boundary);
                let criteria = criteria(algorithm, 0.0, iterations, threads);
                threads::in_pool(pool.as_ref(), || {
                    let start = Instant::now();
                    solver.solve(problem, &criteria)?;
                    Ok::<_, KernelError>(start.elapsed().as_secs_f64())
                })
            };
            // A system that is asked for a second core finds one within milliseconds: the first solves are for that.
            for _ in 0..TURN {
                least.long = least.long.min(solve(WARM + TIMED)?);
                least.short = least.short.min(solve(WARM)?);
                least.once = least.once.min(solve(1)?);
            }
            let compute = threads::in_pool(pool.as_ref(), || machine::compute(threads));
            least.compute = least.compute.min(compute);
        }
        passes += 1;
    }
    Ok(times)
}

/// A tolerance of 0 asks for exactly so many iterations.
fn criteria(algorithm: Algorithm, tolerance: f64, iterations: usize, threads: usize) -> Criteria {
    Criteria {
        algorithm,
        tolerance,
        min_iterations: if tolerance == 0.0 { iterations } else { 1 },
        max_iterations: iterations,
        parallel: threads > 1,
    }
}

/// The longer of two times: moving the bytes of an iteration from where they lie, and doing its operations on
/// data at hand. Both rates are measured here and now, on buffers of the problem's own size.
fn bound(problem: &Problem, algorithm: Algorithm, friction: f64) -> f64 {
    let frictional = friction > 0.0;
    // Per contact: its stored numbers, read and written, and its share of the records of the bodies, read and written
    // (32 bytes each, with the conjugate gradient 88).
    let contacts = problem.contacts.len() as f64;
    let records = problem.records.len() as f64 / contacts;
    let (bytes, operations) = match (algorithm, frictional) {
        (Algorithm::Nsgs, false) => (48.0 + 8.0 + 64.0 * records, 30.0),
        (Algorithm::Nsgs, true) => (72.0 + 16.0 + 64.0 * records, 62.0),
        (Algorithm::Pcg, false) => (64.0 + 24.0 + 176.0 * records, 45.0),
        (Algorithm::Pcg, true) => (112.0 + 48.0 + 176.0 * records, 100.0),
    };
    let numbers = (bytes * contacts / 8.0) as usize;
    (bytes * byte_time(numbers)).max(operations * operation_time()) * 1e9
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A first guess from the step before must save most of the iterations of a load that goes on.
    #[test]
    fn warm_starts_save_iterations() {
        let pack = Pack::new(200, 1, 1);
        let [row, _] = pack
            .rows(Algorithm::Nsgs, FRICTION)
            .expect("the pack can be solved");
        let cold = row.iterations_cold.expect("it converges");
        let warm = row.iterations_warm.expect("it converges");
        assert_eq!(cold[0], warm[0], "the first step has no guess");
        assert!(2 * warm[2] < cold[2], "{cold:?} {warm:?}");
    }
}
