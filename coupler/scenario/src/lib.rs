//! The scenario of a run: its file, its keys, and errors that point into the file.
//!
//! In reading order:
//! - [`error`]: errors that end a run or a verb, with code and exit code;
//! - [`keys`]: the participants, the interfaces and the run; [`plausible`]: the bounds of the coupler's checks;
//!   [`schema`]: the keys for editors;
//! - [`source`]: the text and the positions of its keys; [`overrides`]: `KEY=VALUE`; [`load`]: a scenario by folder,
//!   file or name, read and checked;
//! - [`content`], [`inputs`]: hashes of the files that a scenario names, from when a run read them.
//!
//! ```
//! let loaded = scenario::load::load("quick", &["run.seed=2".to_string()]).expect("it ships");
//! assert_eq!(loaded.scenario.run.seed, 2);
//! assert_eq!(loaded.scenario.interface[0].name, "layer-base");
//! let mistyped = scenario::load::load("quick", &["run.sead=2".to_string()]);
//! assert_eq!(mistyped.expect_err("no such key").exit_code(), 2);
//! ```

mod check;
pub mod content;
pub mod error;
pub mod inputs;
pub mod keys;
pub mod load;
pub mod overrides;
mod paths;
pub mod plausible;
pub mod schema;
pub mod source;
