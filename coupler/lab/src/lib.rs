//! Test equipment that users run: replay, conformance, validation, benchmarks.
//!
//! - [`replay`]: runs solvers and coupler again against the log;
//! - [`conform`]: tests one participant against the rules of the protocol;
//! - [`validate`]: compares scenes with their expected results;
//! - [`mod@bench`]: benchmarks of the exchange and of the coupling schemes;
//! - [`random`]: random numbers; [`cores`]: trials in parallel; [`quiet`]: runs without output.

pub mod bench;
pub mod conform;
pub mod cores;
pub mod quiet;
pub mod random;
pub mod replay;
pub mod validate;
