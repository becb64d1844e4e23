//! Files and lines that come about while a run goes on:
//!
//! - [`signals`]: one row a window; [`table`]: size, rows and hash of a table; [`collection`]: the fields over time, [`interface_fields`]: those of an interface;
//! - [`vtk_arrays`]: the fields read again; `vtkhdf`, a feature: gathered in one file a part;
//! - [`profile`]: the traction of an interface; [`sample`]: means over the phase that results are sampled in;
//! - [`running_balance`]: energies that are judged on the way;
//! - [`state`]: what all of it remembers from window to window;
//! - [`progress`]: how far a run has come, by its [`run_progress`] and its [`pace`]; [`count`]: counters of runs, messages and windows;
//! - [`stderr`]: words on stderr.

pub mod collection;
pub mod count;
pub mod interface_fields;
pub mod pace;
pub mod profile;
pub mod progress;
pub mod run_progress;
pub mod running_balance;
pub mod sample;
pub mod signals;
pub mod state;
pub mod stderr;
pub mod table;
pub mod vtk_arrays;
#[cfg(feature = "vtkhdf")]
pub mod vtkhdf;

pub use count::Count;
pub use progress::Progress;
pub use running_balance::RunningBalance;
pub use sample::SampledMeans;
pub use signals::SignalsFile;
pub use state::OutputState;
pub use stderr::{tell, tell_progress};
