//! The cost of a run: where its time went, and predictions from its first windows.
//!
//! - [`account`]: the time of the windows, by the process at work;
//! - [`prediction`]: time and memory of a whole run, predicted from its first windows;
//! - [`memory`]: memory of the processes of a run.

pub mod account;
pub mod memory;
pub mod prediction;
