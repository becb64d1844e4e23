//! A run, from the launch to the farewells.
//!
//! - [`position`], [`time_loop`]: the loop over all windows;
//! - [`log_volume`]: the predicted length of the log;
//! - [`checkpoint`]: resuming a run that was cut off; `fields`, `outputs`: the output of each window;
//! - [`check`](mod@check): checks before anything starts; [`session`]: a whole run, or its beginning as a dry run.

pub mod check;
pub mod checkpoint;
mod fields;
pub mod log_volume;
mod outputs;
pub mod position;
pub mod session;
pub mod time_loop;
mod unusual;
