//! Progress, means and balances during a run:
//!
//! - [`sample`]: means over the phase in which results are sampled; [`running_balance`]: energies, judged during the
//!   run;
//! - [`state`]: their memory from window to window;
//! - [`progress`]: the progress of a run, and from its [`pace`] the time for the rest.

pub mod pace;
pub mod progress;
pub mod running_balance;
pub mod sample;
pub mod state;

pub use progress::Progress;
pub use running_balance::RunningBalance;
pub use sample::SampledMeans;
pub use state::OutputState;
