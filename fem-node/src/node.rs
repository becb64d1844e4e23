//! The body as a participant of a run.
//!
//! - [`static_node`]: a body in equilibrium, increment by increment;
//! - [`reduced_node`]: a linear body in motion as its lowest modes;
//! - `reduced_kept`, `reduced_report`, `reduced_answers`: its kept parts, its reports, and its answers to a coupler;
//! - [`fem_node`]: a body in motion, its committed state and the current window;
//! - `windows`: windows and condensed matrices;
//! - `report`: signals, energies, results and snapshots;
//! - `checkpoint`: the committed state of a checkpoint, and the refusal of another body's checkpoint;
//! - `answers`: the answers to a coupler.

mod answers;
mod checkpoint;
pub mod fem_node;
mod reduced_answers;
mod reduced_kept;
pub mod reduced_node;
mod reduced_report;
mod report;
pub mod static_node;
mod windows;
