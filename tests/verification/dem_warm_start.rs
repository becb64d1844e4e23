//! The first guess of a step: impulses of the step before.
//!
//! A dense pack of 200 rigid disks with friction is loaded by its upper plate, and goes on being loaded for three steps. Gauss-Seidel
//! needs the same iterations in the first one, with or without a guess, and less than half of them in the third: measured ratios
//! are far below.

use dem_kernel::solver::Solver;
use dem_kernel::solver::criteria::{Algorithm, Criteria};
use dem_kernel::solver::problem::Problem;

use crate::pack::{FRICTION, Pack, STEP};

/// Iterations of three steps in a row, with the impulses of the one before as first guess or without.
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
            go_on(pack, &mut problem, warm);
        }
        let convergence = solver.solve(&mut problem, &criteria).expect("it is finite");
        assert!(convergence.converged, "{convergence:?}");
        convergence.iterations
    })
}

/// Opens or closes the gaps by a step, loads the plate again and keeps or forgets the impulses.
fn go_on(pack: &Pack, problem: &mut Problem, warm: bool) {
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

/// A first guess from the step before must save most of the iterations of a load that goes on.
#[test]
fn warm_starts_save_iterations() {
    let pack = Pack::new(200, 1, 1);
    let [cold, warm] = [false, true].map(|warm| iterations(&pack, warm));
    assert_eq!(cold[0], warm[0], "the first step has no guess");
    assert!(2 * warm[2] < cold[2], "{cold:?} {warm:?}");
}
