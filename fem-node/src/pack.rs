//! Packs of four doubles.
//!
//! The compiler turns loops over whole rows into vector code only when it can prove that a dozen slices do
//! not overlap, and gives up. Loading a few numbers of each slice by value, computing, and storing them at
//! the end leaves nothing to prove.

use std::ops::Range;

use protocol::larger;

#[cfg(target_arch = "x86_64")]
mod avx;
mod lanes;

pub(crate) use lanes::{InRegisters, LANES, Lanes, Pack, Registers};

/// Calls `work` where the compiler may use the widest vector registers that this machine and the build have; `work` must be
/// inlined. Every operation rounds as it does elsewhere, so the bits are the same.
#[inline(always)]
pub(crate) fn vectorised<R>(work: impl FnOnce() -> R) -> R {
    pulp::Arch::new().dispatch(work)
}

/// Runs a computation in the widest registers that this machine and the build have. In loops over [`Pack`] the compiler has to find
/// the vectors, and where a loop reads many rows it takes the lanes apart again to compute several packs at once.
pub(crate) fn in_registers(computation: impl InRegisters) {
    match pulp::Arch::new() {
        #[cfg(target_arch = "x86_64")]
        pulp::Arch::V4(machine) => avx::run(machine, *machine, computation),
        #[cfg(target_arch = "x86_64")]
        pulp::Arch::V3(machine) => avx::run(machine, machine, computation),
        _ => computation.run(Portable),
    }
}

/// The registers of any machine.
#[derive(Clone, Copy)]
struct Portable;

impl Registers for Portable {
    type Vector = Pack;

    #[inline(always)]
    fn load(self, numbers: &[f64; LANES]) -> Pack {
        Pack(*numbers)
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

/// The same, to be written.
#[inline(always)]
pub(crate) fn packs_of_mut<'a>(
    numbers: &'a mut [f64],
    first: usize,
    packs: &Range<usize>,
) -> &'a mut [[f64; LANES]] {
    &mut numbers[first..].as_chunks_mut().0[packs.clone()]
}

/// The largest of these, none being negative; not a number if any is not.
pub(crate) fn largest(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(0.0, larger)
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Compare;

    impl InRegisters for Compare {
        fn run<R: Registers>(self, registers: R) {
            let (a, b) = ([1.5, -2.25, 3e-9, 7e11], [0.5, 0.0, 9.0, -4.75]);
            let [x, y] = [registers.load(&a), registers.load(&b)];
            let computed: [[f64; LANES]; 4] = [
                (x + y).into(),
                (x - y).into(),
                (x * y).into(),
                x.all(0.1).into(),
            ];
            let (a, b) = (Pack(a), Pack(b));
            let plain = [a + b, a - b, a * b, Pack::splat(0.1)];
            assert_eq!(computed, plain.map(|pack| pack.0));
        }
    }

    #[test]
    fn registers_compute_like_arrays() {
        in_registers(Compare);
    }
}
