//! Run directories: the code that names, writes or reads their files.
//!
//! - [`run_dir`]: the folder of a run and its manifest; [`identity`]: its build; [`plausible`]: the judgement at its
//!   end; [`written`]: size, rows and hash of its tables; [`warning`]: one of its warnings;
//! - [`signals`]: one row for each window; [`profile`]: the traction of an interface; [`interface_fields`]: its fields;
//!   [`collection`]: the fields over time;
//! - [`fields`]: the numbers in VTK files; `vtkhdf`, a feature: the fields of each part in one file;
//! - [`files`]: summary, tables and moments of a run; [`table`]: tables of numbers; [`scene`]: the parts of its
//!   scenario that pages use;
//! - [`curve`]: numbers over time, and their distance from a reference; [`steps`]: numbers along a line, likewise;
//! - [`compare`]: the distances between two runs; [`front`]: a run among the settings that a study measured.

pub mod collection;
pub mod compare;
pub mod curve;
pub mod fields;
pub mod files;
pub mod front;
pub mod identity;
pub mod interface_fields;
pub mod plausible;
pub mod profile;
pub mod run_dir;
pub mod scene;
pub mod signals;
pub mod steps;
pub mod table;
#[cfg(feature = "vtkhdf")]
pub mod vtkhdf;
pub mod warning;
pub mod written;
