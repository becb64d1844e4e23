//! Rates of this machine in the same run, and the memory that the process has taken.

use std::hint::black_box;
use std::time::{Duration, Instant};

use crate::law::lanes::{Lanes, widest};

/// Fewest passes of each timing; the quietest counts.
pub const PASSES: usize = 5;
/// Least time of passes of a few milliseconds.
const A_WHILE: Duration = Duration::from_millis(250);
/// Rounds of the loop that only computes, and its chains.
const ROUNDS: usize = 1 << 20;
const CHAINS: usize = 10;

/// The time of the quietest of several passes (s).
pub fn quietest(mut work: impl FnMut()) -> f64 {
    let mut least = f64::INFINITY;
    let begun = Instant::now();
    let mut passes = 0;
    while passes < PASSES || begun.elapsed() < A_WHILE {
        let start = Instant::now();
        work();
        least = least.min(start.elapsed().as_secs_f64());
        passes += 1;
    }
    least
}

/// Time to read and rewrite a byte of a buffer of so many numbers (s).
pub fn byte_time(numbers: usize) -> f64 {
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

/// Multiplications and additions alone, in the widest registers and in as many independent chains as keep all arithmetic
/// units of a core busy: with fewer, two threads that share a core would seem to have one each.
fn arithmetic(rounds: usize) {
    widest!({
        let (factor, term) = (Lanes::<4>::splat(0.999), Lanes::splat(0.001));
        let mut chains = black_box([Lanes::splat(1.0); CHAINS]);
        for _ in 0..rounds {
            for x in &mut chains {
                *x = *x * factor + term;
            }
        }
        black_box(&chains);
    });
}

/// Time of a multiplication or addition (s).
pub fn operation_time() -> f64 {
    let time = quietest(|| arithmetic(ROUNDS));
    time / (ROUNDS * CHAINS * 4 * 2) as f64
}

/// Time of work that needs neither memory nor anything of another thread, shared out to so many (s).
pub fn compute(threads: usize) -> f64 {
    let share = || arithmetic(ROUNDS / threads);
    let start = Instant::now();
    match threads {
        1 => share(),
        _ => rayon::scope(|scope| (0..threads).for_each(|_| scope.spawn(|_| share()))),
    }
    start.elapsed().as_secs_f64()
}

/// Highest resident memory so far (bytes), 0 where the system does not tell.
pub fn peak_rss() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let kibibytes = line.and_then(|line| line.split_whitespace().next()?.parse::<u64>().ok());
    kibibytes.unwrap_or(0) * 1024
}
