//! The first guess of a step: the impulses of the step before.
//!
//! The upper plate loads a dense pack of 200 rigid disks with friction for three steps. Gauss-Seidel needs the same number of
//! iterations in the first step, with or without a guess. In the third step the guess saves more than half of them; the measured
//! ratios are far below 1/2.

use dem_kernel::solver::Solver;
use dem_kernel::solver::criteria::{Algorithm, Criteria};
use dem_kernel::solver::problem::Problem;

use crate::pack::{FRICTION, Pack, STEP};

/// Iterations of three consecutive steps, with or without the previous step's impulses as the first guess.
fn iterations(pack: &Pack, warm: bool) -> [usize; 3] {
    let criteria = Criteria {
        algorithm: Algorithm::Nsgs,
        tolerance: 1e-3,
        min_iterations: 1,
        max_iterations: 20_000,
        parallel: false,
    };
    let (mut problem, mut solver) = (pack.cold(FRICTION), Solver::default());
    [0, 1, 2].map(|step| {
        if step > 0 {
            next_step(pack, &mut problem, warm);
        }
        let convergence = solver.solve(&mut problem, &criteria).expect("it is finite");
        assert!(convergence.converged, "{convergence:?}");
        convergence.iterations
    })
}

/// Opens or closes the gaps by a step, loads the plate again and keeps or forgets the impulses.
fn next_step(pack: &Pack, problem: &mut Problem, warm: bool) {
    let mut contacts = std::mem::take(&mut problem.contacts);
    for contact in &mut contacts {
        contact.gap += STEP * problem.relative_velocity(contact)[0];
        contact.bias[0] = contact.gap.max(0.0) / STEP;
        if !warm {
            contact.impulse = [0.0; 2];
        }
    }
    problem.contacts = contacts;
    pack.load(problem);
}

/// The previous step's impulses as the first guess save most of the iterations under a steady load.
#[test]
fn warm_starts_save_iterations() {
    let pack = Pack::new(200, 1, 1);
    let [cold, warm] = [false, true].map(|warm| iterations(&pack, warm));
    assert_eq!(cold[0], warm[0], "the first step has no guess");
    assert!(2 * warm[2] < cold[2], "{cold:?} {warm:?}");
}
