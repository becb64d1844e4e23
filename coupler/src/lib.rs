//! The coordinator and coupler of `thirdbody`: it launches solvers, joins them window by window, and records
//! everything that they say to each other.
//!
//! Modules, in reading order:
//! - [`scenario`]: who takes part, who talks to whom, and how;
//! - [`log`]: the exchange log and its hash;
//! - [`scheme`]: coupling schemes as algorithms, mapping, ledgers, and the prediction of stability;
//! - [`participants`]: starting participants, keeping watch over them, speaking to them;
//! - [`output`]: signals, interface traction, progress; [`rundir`], [`summary`]: the files of a run;
//! - [`run`]: the loop over windows, checkpoints, a whole run;
//! - [`replay`]: solvers and coupler again, against the log;
//! - [`validate`]: scenes against what must come out of them;
//! - [`report`]: pictures of it; [`bench`](mod@bench): what the machine gives;
//! - [`cli`]: the verbs of the command line;
//! - [`error`]: what can end a run, and the exit code it has.
//!
//! The library knows no solver: the binary hands its [`participants::Registry`] in.
//!
//! ```
//! use coupler::scheme::mapping::Mapping;
//! let nodes = [[0.0, 0.0], [1.0, 0.0]];
//! let mapping = Mapping::mortar(&nodes, &[[0.25, 0.0]]).expect("the point lies on the line");
//! assert_eq!(mapping.motion(&[0.0, 0.0, 4.0, 8.0]), [1.0, 2.0]);
//! ```

pub mod bench;
pub mod cli;
pub mod error;
pub mod log;
pub mod output;
pub mod participants;
pub mod replay;
pub mod report;
pub mod run;
pub mod rundir;
pub mod scenario;
pub mod scheme;
pub mod summary;
pub mod validate;
