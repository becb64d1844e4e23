//! The 256-bit registers of x86-64.

use std::arch::x86_64::__m256d;
use std::ops::{Add, Mul, Sub};

use pulp::Simd;
use pulp::bytemuck::cast;
use pulp::x86::V3;

use super::lanes::{InRegisters, LANES, Lanes, Registers};

/// Runs a computation on a machine that has them, and maybe twice as many as [`V3`] promises.
pub(super) fn run(machine: impl Simd, registers: V3, computation: impl InRegisters) {
    machine.vectorize(
        #[inline(always)]
        || computation.run(Avx(registers)),
    );
}

/// Proof that the machine has the registers.
#[derive(Clone, Copy)]
struct Avx(V3);

/// One of the registers.
#[derive(Clone, Copy)]
struct Register {
    lanes: __m256d,
    machine: V3,
}

impl Registers for Avx {
    type Vector = Register;

    #[inline(always)]
    fn load(self, numbers: &[f64; LANES]) -> Register {
        Register {
            lanes: cast(*numbers),
            machine: self.0,
        }
    }
}

impl Register {
    #[inline(always)]
    fn with(self, lanes: __m256d) -> Register {
        Register { lanes, ..self }
    }
}

impl Lanes for Register {
    #[inline(always)]
    fn all(self, value: f64) -> Register {
        self.with(self.machine.avx._mm256_set1_pd(value))
    }
}

impl From<Register> for [f64; LANES] {
    #[inline(always)]
    fn from(register: Register) -> [f64; LANES] {
        cast(register.lanes)
    }
}

impl Add for Register {
    type Output = Register;

    #[inline(always)]
    fn add(self, other: Register) -> Register {
        self.with(self.machine.avx._mm256_add_pd(self.lanes, other.lanes))
    }
}

impl Sub for Register {
    type Output = Register;

    #[inline(always)]
    fn sub(self, other: Register) -> Register {
        self.with(self.machine.avx._mm256_sub_pd(self.lanes, other.lanes))
    }
}

impl Mul for Register {
    type Output = Register;

    #[inline(always)]
    fn mul(self, other: Register) -> Register {
        self.with(self.machine.avx._mm256_mul_pd(self.lanes, other.lanes))
    }
}
