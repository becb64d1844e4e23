//! The body as a participant of a run.
//!
//! - `foreign`: the refusal of a checkpoint of another body;
//! - [`static_node`]: a body in equilibrium, increment by increment;
//! - [`fem_node`]: a body in motion, its committed state and the window at hand;
//! - `windows`: windows and condensed matrices;
//! - `report`: signals, energies, results and snapshots;
//! - `checkpoint`: the committed state of a checkpoint;
//! - `answers`: the answers to a coupler.

mod answers;
mod checkpoint;
pub mod fem_node;
mod foreign;
mod report;
pub mod static_node;
mod windows;
