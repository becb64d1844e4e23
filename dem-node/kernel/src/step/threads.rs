//! Threads of the contact solver.

use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::error::KernelError;

/// A pool of this many threads, `None` where the calling thread suffices.
pub fn pool(threads: usize) -> Result<Option<ThreadPool>, KernelError> {
    if threads <= 1 {
        return Ok(None);
    }
    let pool = ThreadPoolBuilder::new().num_threads(threads).build();
    pool.map(Some)
        .map_err(|error| KernelError::Threads { threads, error })
}

/// Runs work where a solver may use the threads of the pool.
pub fn in_pool<T: Send>(pool: Option<&ThreadPool>, work: impl FnOnce() -> T + Send) -> T {
    match pool {
        Some(pool) => pool.install(work),
        None => work(),
    }
}
