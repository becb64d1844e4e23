//! The 256-bit and the 512-bit registers of x86-64.

use std::ops::{Add, Mul, Sub};
use std::slice::from_ref;

use pulp::bytemuck::{cast, cast_slice};
use pulp::x86::{V3, V4};
use pulp::{Simd, f64x4, f64x8};

use super::lanes::{InRegisters, LANES, Lanes, Registers};

/// Runs a computation in the registers of 256 bits.
pub(super) fn run(machine: V3, computation: impl InRegisters) {
    machine.vectorize(
        #[inline(always)]
        || computation.run(Avx(machine)),
    );
}

/// Runs a computation in the registers of 512 bits.
pub(super) fn run_wide(machine: V4, computation: impl InRegisters) {
    machine.vectorize(
        #[inline(always)]
        || computation.run(Avx512(machine)),
    );
}

/// Proof that the machine has registers of 256 bits.
#[derive(Clone, Copy)]
struct Avx(V3);

/// Proof that the machine has registers of 512 bits. A processor that halves them does not compute faster, but has twice as many elements in flight:
/// a pack of elements is one chain of dependent operations, and a processor can hold only a limited number of operations.
#[derive(Clone, Copy)]
struct Avx512(V4);

/// One of the registers.
#[derive(Clone, Copy)]
struct Register<S: Simd> {
    lanes: S::f64s,
    machine: S,
}

impl Registers for Avx {
    type Vector = Register<V3>;
    type Single = Avx;
    const PACKS: usize = 1;

    #[inline(always)]
    fn single(self) -> Avx {
        self
    }

    #[inline(always)]
    fn splat(self, value: f64) -> Register<V3> {
        Register::new(self.0, self.0.splat_f64s(value))
    }

    #[inline(always)]
    fn vector(self, pack: impl Fn(usize) -> [f64; LANES]) -> Register<V3> {
        Register::new(self.0, cast::<_, f64x4>(pack(0)))
    }
}

impl Registers for Avx512 {
    type Vector = Register<V4>;
    type Single = Avx;
    const PACKS: usize = 2;

    #[inline(always)]
    fn single(self) -> Avx {
        Avx(*self.0)
    }

    #[inline(always)]
    fn splat(self, value: f64) -> Register<V4> {
        Register::new(self.0, self.0.splat_f64s(value))
    }

    #[inline(always)]
    fn vector(self, pack: impl Fn(usize) -> [f64; LANES]) -> Register<V4> {
        Register::new(self.0, cast::<_, f64x8>([pack(0), pack(1)]))
    }
}

impl<S: Simd> Lanes for Register<S> {
    #[inline(always)]
    fn all(self, value: f64) -> Register<S> {
        self.with(self.machine.splat_f64s(value))
    }

    #[inline(always)]
    fn larger(self, other: Register<S>) -> Register<S> {
        self.with(self.machine.max_f64s(self.lanes, other.lanes))
    }

    #[inline(always)]
    fn put(self, packs: &mut [[f64; LANES]], p: usize) {
        let own: &[[f64; LANES]] = cast_slice(from_ref(&self.lanes));
        packs[p..p + own.len()].copy_from_slice(own);
    }
}

impl<S: Simd> Register<S> {
    #[inline(always)]
    fn new(machine: S, lanes: S::f64s) -> Register<S> {
        Register { lanes, machine }
    }

    #[inline(always)]
    fn with(self, lanes: S::f64s) -> Register<S> {
        Register::new(self.machine, lanes)
    }
}

/// Operators on whole registers: the trait, its method, the operation of the machine.
macro_rules! register_by_register {
    ($($operator:ident, $method:ident, $operation:ident;)*) => {$(
        impl<S: Simd> $operator for Register<S> {
            type Output = Register<S>;

            #[inline(always)]
            fn $method(self, other: Register<S>) -> Register<S> {
                self.with(self.machine.$operation(self.lanes, other.lanes))
            }
        }
    )*};
}

register_by_register! { Add, add, add_f64s; Sub, sub, sub_f64s; Mul, mul, mul_f64s; }
