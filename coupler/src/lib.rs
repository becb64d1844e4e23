//! The coordinator and coupler of `thirdbody`: it launches solvers, joins them window by window, and records
//! everything that they say to each other.
//!
//! Modules, in reading order:
//! - [`scenario`]: who takes part, who talks to whom, and how;
//! - [`launch`]: starting participants and keeping watch over them;
//! - [`couple`]: handshake, mapping, clock, schemes, ledgers and the loop over windows;
//! - [`log`]: the exchange log and its hash;
//! - [`checkpoint`]: going on after a run was cut off;
//! - [`output`]: signals, interface traction, progress; [`rundir`], [`summary`]: what a run leaves behind;
//! - [`replay`]: solvers and coupler again, against the log;
//! - [`validate`]: scenes against what must come out of them;
//! - [`report`]: pictures of it; [`bench`](mod@bench): what the machine gives;
//! - [`cli`]: the verbs of the command line;
//! - [`error`]: what can end a run, and the exit code it has.
//!
//! The library knows no solver: the binary hands its [`launch::Registry`] in.
//!
//! ```
//! use coupler::couple::mapping::Mapping;
//! let nodes = [[0.0, 0.0], [1.0, 0.0]];
//! let mapping = Mapping::mortar(&nodes, &[[0.25, 0.0]]).expect("the point lies on the line");
//! assert_eq!(mapping.motion(&[0.0, 0.0, 4.0, 8.0]), [1.0, 2.0]);
//! ```

pub mod bench;
pub mod checkpoint;
pub mod cli;
pub mod couple;
pub mod error;
pub mod launch;
pub mod log;
pub mod output;
pub mod replay;
pub mod report;
pub mod rundir;
pub mod scenario;
pub mod summary;
pub mod validate;
