//! Work on all cores of the machine.

use rayon::prelude::*;

/// Results of `work` for 0, 1, ... `count` - 1, in this order.
pub fn on_all_cores<T: Send>(count: u64, work: impl Fn(u64) -> T + Send + Sync) -> Vec<T> {
    // One by one: trials last from a millisecond to a minute, and no trial should wait behind a long one.
    let one_by_one = (0..count as usize).into_par_iter().with_max_len(1);
    one_by_one.map(|index| work(index as u64)).collect()
}
