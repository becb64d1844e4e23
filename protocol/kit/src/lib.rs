//! What every shipped solver needs beside the wire, written once.
//!
//! In reading order:
//! - [`keys`]: a participant's own keys, read with errors that name the key and what to write instead;
//! - [`input_file`]: files that a scenario names;
//! - [`schema`]: the keys of a configuration as a JSON Schema;
//! - [`table`]: loads over time;
//! - [`wheel`]: load and sideways motion of a wheel over time;
//! - [`cycle_drift`]: its drift from cycle to cycle;
//! - [`bounds`]: the two bounds of a check of plausibility;
//! - [`vtk`]: files of fields;
//! - [`scratch`]: folders that go with whoever made them.

pub mod bounds;
pub mod cycle_drift;
pub mod input_file;
pub mod keys;
pub mod schema;
pub mod scratch;
pub mod table;
pub mod vtk;
pub mod wheel;

pub use bounds::Bounds;
pub use keys::{ConfigError, read_config, read_part};
