//! What memory and arithmetic of a machine allow, measured by loops that do nothing else.

use std::hint::black_box;
use std::time::Instant;

use rayon::ThreadPool;
use rayon::prelude::*;

use crate::pack::lanes::{LANES, Pack};
use crate::pack::vectorised;

/// Passes of which the quietest counts.
const PASSES: usize = 7;

/// The least time (s) of a unit of work over the passes; `work` returns how many units it did.
pub fn quietest(mut work: impl FnMut() -> f64) -> f64 {
    let pass = |_| {
        let start = Instant::now();
        let units = work();
        start.elapsed().as_secs_f64() / units
    };
    (0..PASSES).map(pass).fold(f64::INFINITY, f64::min)
}

/// Bytes that all threads together read in a second from arrays of this many numbers.
pub fn read_rate(pool: &ThreadPool, threads: usize, numbers: f64) -> f64 {
    let len = (numbers as usize / threads).next_multiple_of(4 * LANES);
    let arrays = vec![vec![1.0; len]; threads];
    let time = quietest(|| {
        pool.install(|| arrays.par_iter().for_each(|array| sum(array)));
        (8 * len * threads) as f64
    });
    1.0 / time
}

/// Four running sums, so that no addition waits for the one before.
fn sum(array: &[f64]) {
    let mut sums = [Pack::splat(0.0); 4];
    for k in (0..array.len()).step_by(4 * LANES) {
        for (lane, sum) in sums.iter_mut().enumerate() {
            *sum = *sum + Pack::load(array, k + lane * LANES);
        }
    }
    black_box(sums.map(|sum| sum.sum()));
}

/// Additions and multiplications that all threads together do in a second.
pub fn operation_rate(pool: &ThreadPool, threads: usize) -> f64 {
    const ROUNDS: usize = 1_000_000;
    // Enough that no operation waits for the one before it.
    const CHAINS: usize = 8;
    let spin = |_: usize| {
        let packs = black_box([Pack::splat(1.0); CHAINS]);
        let packs = vectorised!(spun(packs, ROUNDS));
        black_box(packs.map(|pack| pack.sum()));
    };
    let time = quietest(|| {
        pool.install(|| (0..threads).into_par_iter().for_each(spin));
        (threads * ROUNDS * CHAINS * LANES * 2) as f64
    });
    1.0 / time
}

/// The packs, each multiplied and added to in every round.
#[inline(always)]
fn spun<const N: usize>(mut packs: [Pack; N], rounds: usize) -> [Pack; N] {
    let (factor, shift) = (Pack::splat(0.999), Pack::splat(1e-3));
    for _ in 0..rounds {
        for pack in &mut packs {
            *pack = *pack * factor + shift;
        }
    }
    packs
}
