//! Time per contact and iteration, and time for the contacts and blocks of a step: one cold load step of dense packs of 1 000, 10 000 and
//! 73 000 disks, on one thread and on two.
//!
//! ```sh
//! cargo bench -p tests --bench dem
//! ```
//!
//! The time per contact and iteration (ns) is 1000 over the `Mitem/s` of the fastest sample: other programs on the machine can only add
//! time.

mod pack;

use std::sync::LazyLock;

use dem_kernel::contact::boundary::CompliantBoundary;
use dem_kernel::solver::Solver;
use dem_kernel::solver::criteria::{Algorithm, Criteria};
use dem_kernel::step::Stepper;
use dem_kernel::step::state::GrainState;
use dem_kernel::step::threads;
use divan::Bencher;
use divan::counter::ItemsCount;

use pack::{FRICTION, Pack, SKIN};

/// Iterations of a sample. Sorting the contacts and the last residual take as long as about five of them.
const ITERATIONS: usize = 500;

static PACKS: [(usize, LazyLock<Pack>); 3] = [
    (1_000, LazyLock::new(|| Pack::new(1_000, 1, 1))),
    (10_000, LazyLock::new(|| Pack::new(10_000, 1, 1))),
    (73_000, LazyLock::new(|| Pack::new(9_125, 4, 2))),
];

/// Disks, solver and coefficient of friction.
type Case = (usize, Algorithm, f64);

fn main() {
    divan::main();
}

fn cases() -> impl Iterator<Item = Case> {
    let solvers = [Algorithm::Nsgs, Algorithm::Pcg].into_iter();
    let laws = solvers.flat_map(|solver| [0.0, FRICTION].map(|friction| (solver, friction)));
    let sizes = PACKS.iter().map(|(disks, _)| *disks);
    sizes.flat_map(move |disks| {
        let laws = laws.clone();
        laws.map(move |(solver, friction)| (disks, solver, friction))
    })
}

fn pack(disks: usize) -> &'static Pack {
    let mut packs = PACKS.iter();
    let (_, pack) = packs
        .find(|(size, _)| *size == disks)
        .expect("it is listed");
    pack
}

/// The same cold step, repeated in the buffers of the solve before, as in a run.
#[divan::bench(args = cases(), consts = [1, 2], sample_count = 10, sample_size = 1)]
fn contact_iteration<const THREADS: usize>(bencher: Bencher, (disks, algorithm, friction): Case) {
    let cold = pack(disks).cold(friction);
    let criteria = exactly(ITERATIONS, algorithm, THREADS);
    let pool = threads::pool(THREADS).expect("the threads start");
    let (mut problem, mut solver) = (cold.clone(), Solver::default());
    bencher
        .counter(ItemsCount::new(cold.contacts.len() * ITERATIONS))
        .bench_local(|| {
            problem.contacts.clone_from(&cold.contacts);
            problem.records.clone_from(&cold.records);
            problem.boundary.clone_from(&cold.boundary);
            threads::in_pool(pool.as_ref(), || solver.solve(&mut problem, &criteria))
                .expect("the problem is finite")
        });
}

/// A step with one iteration, with or without a disk that left the Verlet list: contacts from positions, local blocks, the
/// sorting of the solver and one residual.
#[divan::bench(args = cases(), consts = [false, true], sample_count = 50, sample_size = 1)]
fn contacts_and_blocks<const NEW_LIST: bool>(bencher: Bencher, (disks, algorithm, friction): Case) {
    let pack = pack(disks);
    let bodies = pack.bodies(friction);
    let criteria = exactly(1, algorithm, 1);
    let mut state = GrainState::new(&bodies, &pack.disks, &[]);
    let (mut stepper, mut solver) = (Stepper::default(), Solver::default());
    stepper.problem.boundary = CompliantBoundary::fixed(0);
    let mut way = 2.0 * SKIN;
    bencher.bench_local(|| {
        if NEW_LIST {
            state.centres[0][1] += way;
            way = -way;
        }
        stepper.assemble(&mut state, &pack::input(&bodies), false);
        let solved = solver.solve(&mut stepper.problem, &criteria);
        solved.expect("the problem is finite")
    });
}

/// Exactly this many iterations.
fn exactly(iterations: usize, algorithm: Algorithm, threads: usize) -> Criteria {
    Criteria {
        algorithm,
        tolerance: 0.0,
        min_iterations: iterations,
        max_iterations: iterations,
        parallel: threads > 1,
    }
}
