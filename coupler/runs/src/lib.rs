//! The one reader of run directories: what a run left, as tables, fields and numbers.
//!
//! [`table`], [`columns`]: the comma-separated files; [`fields`]: meshes and grains; [`setup`]: the parts of the scenario that pictures go by;
//! [`files`], [`finished`]: all of a run; [`curve`], [`steps`], [`compare`]: a run beside another one.

pub mod columns;
pub mod compare;
pub mod curve;
pub mod fields;
pub mod files;
pub mod finished;
pub mod setup;
pub mod steps;
pub mod table;
