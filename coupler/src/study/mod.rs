//! Comparison of runs: distances of signals, tractions and results, and ratios of costs.
//!
//! - [`table`]: tables of numbers as runs leave them; [`curve`]: numbers over time, [`steps`]: over segments of a line, and the
//!   distances of two of them;
//! - [`finished`]: a run that has ended; [`compare`]: two of them.

pub mod compare;
pub mod curve;
pub mod finished;
pub mod steps;
pub mod table;
