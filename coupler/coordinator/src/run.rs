//! Runs, from the launch to the farewells.
//!
//! - [`position`], [`time_loop`]: the loop over all windows;
//! - [`log_volume`]: the length of the log, foreseen;
//! - [`checkpoint`]: going on after a run was cut off; `fields`, `outputs`: everything that is written while windows pass;
//! - [`check`](mod@check): a scenario before anything is started; [`session`]: a whole run, or its beginning as a dry run.

pub mod check;
pub mod checkpoint;
mod fields;
pub mod log_volume;
mod outputs;
pub mod position;
pub mod session;
pub mod time_loop;
mod unusual;
