//! What tries, measures and repeats: test apparatus that users run.
//!
//! - [`replay`]: solvers and coupler again, against the log;
//! - [`conform`]: the rules of the wire, tried on one participant;
//! - [`validate`]: scenes against what must come out of them;
//! - [`mod@bench`]: what the machine gives;
//! - [`random`]: numbers for trials; [`cores`]: trials side by side; [`quiet`]: runs of trials.

pub mod bench;
pub mod conform;
pub mod cores;
pub mod quiet;
pub mod random;
pub mod replay;
pub mod validate;
