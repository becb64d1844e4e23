//! The body as a participant of a coupled run.
//!
//! - `fem_node`: the body, its committed state and the window at hand;
//! - `windows`: windows and condensed matrices;
//! - `report`: signals, energies, results and snapshots;
//! - `checkpoint`: the committed state of a checkpoint;
//! - `answers`: the answers to a coupler.

mod answers;
mod checkpoint;
mod fem_node;
mod report;
mod windows;

pub use crate::node::fem_node::FemNode;
