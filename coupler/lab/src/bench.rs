//! Benchmarks of the exchange and of the coupling schemes.
//!
//! - [`exchange`], [`participant`]: time of a request and its answer, over shared memory and for any participant;
//! - [`stability`]: the set-ups in which schemes are unstable.

pub mod exchange;
pub mod participant;
pub mod stability;

use std::time::Instant;

use scenario::error::Error;

/// Median and 99th percentile (us) of the times of turns, after a warm-up.
fn time_turns(
    warm_up: usize,
    timed: usize,
    mut turn: impl FnMut(usize) -> Result<(), Error>,
) -> Result<(f64, f64), Error> {
    let mut times = Vec::with_capacity(timed);
    for index in 0..warm_up + timed {
        let start = Instant::now();
        turn(index)?;
        if index >= warm_up {
            times.push(1e6 * start.elapsed().as_secs_f64());
        }
    }
    times.sort_by(f64::total_cmp);
    Ok((times[timed / 2], times[timed * 99 / 100]))
}
