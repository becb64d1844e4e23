//! Code that every shipped solver needs in addition to the protocol, written once.
//!
//! In reading order:
//! - [`keys`]: a participant's own keys, read with errors that name the key and what to write instead;
//! - [`limits`]: limits that depend on other keys;
//! - [`number`]: a number, or a word in its place;
//! - [`input_file`]: files that a scenario names;
//! - [`schema`]: the keys of a configuration as a JSON Schema;
//! - [`ranges`]: the configuration of a participant, read and checked against the ranges of its schema;
//! - [`table`]: loads over time;
//! - [`heat`]: capacities over temperature, and half-spaces;
//! - [`wheel`]: load and sideways motion of a wheel over time;
//! - [`rolling`]: its rolling along the rail in place of the sideways motion;
//! - [`rolled`]: the results of the way that it has rolled;
//! - [`cycle_drift`]: the wheel's drift from cycle to cycle;
//! - [`traction`]: the wheel's traction over its motion, and friction during gross sliding;
//! - [`student`]: Student's t;
//! - [`boxes`]: means of a traction over boxes;
//! - [`bounds`]: the two bounds of a plausibility check;
//! - [`finding`]: the kinds of findings, their documentation for users, and the table of their bounds;
//! - [`mod@results`]: the results and signals of a program;
//! - [`vtk`]: files of fields;
//! - [`kept`]: values that are kept for later runs;
//! - [`scratch`]: folders that are removed with their owner.

pub mod bounds;
pub mod boxes;
pub mod cycle_drift;
pub mod finding;
pub mod heat;
pub mod input_file;
pub mod kept;
pub mod keys;
pub mod limits;
pub mod number;
pub mod ranges;
pub mod results;
pub mod rolled;
pub mod rolling;
pub mod schema;
pub mod scratch;
pub mod student;
pub mod table;
pub mod traction;
pub mod vtk;
pub mod wheel;

/// The fields of a value with their names: `named!(key; a, b)` is `[("a", key.a), ("b", key.b)]`. `named!("table.", key; a, b)` puts
/// the names below a table; `named!(key, is_some; a, b)` gives the value of a method of each field.
#[macro_export]
macro_rules! named {
    ($table:literal, $of:expr; $($field:ident),+) => {
        [$((concat!($table, stringify!($field)), $of.$field)),+]
    };
    ($of:expr; $($field:ident),+) => {
        [$((stringify!($field), $of.$field)),+]
    };
    ($of:expr, $method:ident; $($field:ident),+) => {
        [$((stringify!($field), $of.$field.$method())),+]
    };
}

/// Adds fields of one value to the same fields of another: `add_fields!(sum, other; a, b)`.
#[macro_export]
macro_rules! add_fields {
    ($sum:expr, $other:expr; $($field:ident),+) => {
        $($sum.$field += $other.$field;)+
    };
}

#[doc(hidden)]
pub use inventory;

pub use bounds::{Bounds, Plausible};
pub use finding::FindingKind;
pub use keys::{ConfigError, read_part, read_table};
pub use ranges::read_config;
