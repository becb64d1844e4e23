//! The one reader of run directories.
//!
//! - [`files`]: summary, tables and moments of a run; [`table`]: tables of numbers; [`fields`]: what the participants wrote as VTK;
//! - [`scenario`]: the parts of its scenario that pages go by;
//! - [`curve`]: numbers over time, and their distance from a reference; [`steps`]: numbers along a line, likewise;
//! - [`compare`]: the distances of everything that two runs hold; [`front`]: a run among the settings that a study measured.

pub mod compare;
pub mod curve;
pub mod fields;
pub mod files;
pub mod front;
pub mod scenario;
pub mod steps;
pub mod table;
