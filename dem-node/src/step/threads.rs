//! Threads of the contact solver.

use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::config::solver::Criteria;
use crate::error::DemError;
use crate::step::state::GrainState;
use crate::step::{StepInput, StepSummary, Stepper};

/// The threads of the contact solver, with its stopping criteria.
pub struct SolverThreads {
    /// Stopping criteria for the calling thread alone.
    pub criteria: Criteria,
    pool: Option<ThreadPool>,
}

impl SolverThreads {
    /// Starts so many threads, if more than one.
    pub fn new(criteria: Criteria, threads: usize) -> Result<SolverThreads, DemError> {
        Ok(SolverThreads {
            criteria,
            pool: pool(threads)?,
        })
    }

    /// A step, by all threads where the contacts of the step before are enough for them: to wake them costs as much as some
    /// thousand contacts.
    pub fn advance(
        &self,
        stepper: &mut Stepper,
        state: &mut GrainState,
        input: &StepInput,
    ) -> Result<StepSummary, DemError> {
        let pool = self.pool.as_ref().filter(|_| stepper.is_partitioned());
        let criteria = Criteria {
            parallel: pool.is_some(),
            ..self.criteria
        };
        in_pool(pool, || stepper.advance(state, input, &criteria))
    }
}

/// A pool of so many threads, `None` where the calling one suffices.
pub fn pool(threads: usize) -> Result<Option<ThreadPool>, DemError> {
    if threads <= 1 {
        return Ok(None);
    }
    let pool = ThreadPoolBuilder::new().num_threads(threads).build();
    pool.map(Some)
        .map_err(|error| DemError::Threads { threads, error })
}

/// Runs work where a solver may use the threads of the pool.
pub fn in_pool<T: Send>(pool: Option<&ThreadPool>, work: impl FnOnce() -> T + Send) -> T {
    match pool {
        Some(pool) => pool.install(work),
        None => work(),
    }
}
