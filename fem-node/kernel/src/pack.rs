//! Packs of four doubles.
//!
//! The compiler turns loops over whole rows into vector code only when it can prove that a dozen slices do
//! not overlap, and gives up. Loading a few numbers of each slice by value, computing, and storing them at
//! the end leaves nothing to prove.
//!
//! - `lanes`: a pack, and the traits of computations over packs;
//! - `avx`: the vector registers of x86-64;
//! - `line`: rows of numbers that begin on a cache line.

#[cfg(target_arch = "x86_64")]
mod avx;
pub(crate) mod lanes;
pub(crate) mod line;

use std::ops::Range;

use protocol::larger;

use lanes::{InRegisters, LANES, Pack, Registers};

/// Runs `work` with the widest vector registers of this machine and build; all functions that it calls must be inlined. Every operation rounds as
/// elsewhere, so the bits are the same. `work` is the body of a closure: a `return` leaves only the closure.
macro_rules! vectorised {
    ($work:expr) => {
        $crate::pack::dispatch(
            #[inline(always)]
            || $work,
        )
    };
}
pub(crate) use vectorised;

/// Calls `work`. The bound shows the compiler that the closure is called once, so it inlines it.
#[inline(always)]
pub(crate) fn dispatch<R>(work: impl FnOnce() -> R) -> R {
    pulp::Arch::new().dispatch(work)
}

/// Runs a computation in the widest registers of this machine and build. In loops over [`Pack`] the compiler has to find the vectors, and where a
/// loop reads many rows it splits the lanes again to compute several packs at once.
pub(crate) fn in_registers(computation: impl InRegisters) {
    match pulp::Arch::new() {
        #[cfg(target_arch = "x86_64")]
        pulp::Arch::V4(machine) => avx::run_wide(machine, computation),
        #[cfg(target_arch = "x86_64")]
        pulp::Arch::V3(machine) => avx::run(machine, computation),
        _ => computation.run(Portable),
    }
}

/// The registers of any machine.
#[derive(Clone, Copy)]
struct Portable;

impl Registers for Portable {
    type Vector = Pack;
    type Single = Portable;
    const PACKS: usize = 1;

    #[inline(always)]
    fn single(self) -> Portable {
        self
    }

    #[inline(always)]
    fn splat(self, value: f64) -> Pack {
        Pack::splat(value)
    }

    #[inline(always)]
    fn vector(self, pack: impl Fn(usize) -> [f64; LANES]) -> Pack {
        Pack(pack(0))
    }
}

/// These packs of the numbers from `first` on. Slices of the same packs have one length, so that a loop over them checks no bounds.
#[inline(always)]
pub(crate) fn packs_of<'a>(
    numbers: &'a [f64],
    first: usize,
    packs: &Range<usize>,
) -> &'a [[f64; LANES]] {
    &numbers[first..].as_chunks().0[packs.clone()]
}

/// The same packs, mutable.
#[inline(always)]
pub(crate) fn packs_of_mut<'a>(
    numbers: &'a mut [f64],
    first: usize,
    packs: &Range<usize>,
) -> &'a mut [[f64; LANES]] {
    &mut numbers[first..].as_chunks_mut().0[packs.clone()]
}

/// The largest of these non-negative numbers; NaN if any is NaN.
pub fn largest(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(0.0, larger)
}

#[cfg(test)]
mod tests {
    use super::lanes::{ByPacks, Lanes};
    use super::*;

    const A: [[f64; LANES]; 3] = [
        [1.5, -2.25, 3e-9, 7e11],
        [0.1, 0.2, -0.3, 1e300],
        [1.0, 2.0, 3.0, 4.0],
    ];
    const B: [[f64; LANES]; 3] = [
        [0.5, 0.0, 9.0, -4.75],
        [3.0, 0.7, 0.3, 1e10],
        [1.1, 2.2, 3.3, 4.4],
    ];

    /// Sums, differences, products, numbers and maxima of three packs: a vector of two packs leaves one over.
    #[derive(Debug, Default, PartialEq)]
    struct Computed([[[f64; LANES]; 3]; 5]);

    impl ByPacks for Computed {
        fn at<R: Registers>(&mut self, registers: R, p: usize) {
            let constants = [0, 1, 2].map(|p| [Pack(A[p]), Pack(B[p])]);
            let [x, y] = registers.load_all(&constants, p);
            let [sums, differences, products, numbers, larger] = &mut self.0;
            (x + y).put(sums, p);
            (registers.load(&A, p) - registers.load(&B, p)).put(differences, p);
            (x * y).put(products, p);
            x.all(0.1).put(numbers, p);
            x.larger(y).put(larger, p);
        }
    }

    impl InRegisters for &mut Computed {
        fn run<R: Registers>(self, registers: R) {
            self.over(registers, 3);
        }
    }

    #[test]
    fn registers_compute_like_arrays() {
        let mut computed = Computed::default();
        in_registers(&mut computed);
        let mut plain = Computed::default();
        plain.over(Portable, 3);
        assert_eq!(computed, plain);
        let [a, b] = [Pack(A[1]), Pack(B[1])];
        let second = plain.0.map(|packs| packs[1]);
        assert_eq!(
            second,
            [a + b, a - b, a * b, Pack::splat(0.1), a.max(b)].map(|pack| pack.0)
        );
    }
}
