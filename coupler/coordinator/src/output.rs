//! Progress, means and balances of a run that goes on:
//!
//! - [`sample`]: means over the phase that results are sampled in; [`running_balance`]: energies that are judged on the way;
//! - [`state`]: what all of it remembers from window to window;
//! - [`progress`]: how far a run has come, and by its [`pace`] how long the rest will take.

pub mod pace;
pub mod progress;
pub mod running_balance;
pub mod sample;
pub mod state;

pub use progress::Progress;
pub use running_balance::RunningBalance;
pub use sample::SampledMeans;
pub use state::OutputState;
