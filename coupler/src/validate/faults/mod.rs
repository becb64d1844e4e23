//! Runs under faults.
//!
//! - `random`: numbers of a seed; [`simulated`]: runs behind a simulated network.

mod random;
pub mod simulated;
