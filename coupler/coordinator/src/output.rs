//! Progress, means and balances of a run that goes on:
//!
//! - [`sample`]: means over the phase that results are sampled in; [`running_balance`]: energies that are judged on the way;
//! - [`state`]: what all of it remembers from window to window;
//! - [`progress`]: how far a run has come, by its [`run_progress`] and its [`pace`]; [`count`]: counters of runs, messages and windows;
//! - [`stderr`]: words on stderr.

pub mod count;
pub mod pace;
pub mod progress;
pub mod run_progress;
pub mod running_balance;
pub mod sample;
pub mod state;
pub mod stderr;

pub use count::Count;
pub use progress::Progress;
pub use running_balance::RunningBalance;
pub use sample::SampledMeans;
pub use state::OutputState;
pub use stderr::{tell, tell_progress};
