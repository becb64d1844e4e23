//! The scenario of a run: its file, its keys, and the errors that point into it.
//!
//! In reading order:
//! - [`error`]: what can end a run or a verb, with its code and exit code;
//! - [`keys`]: who takes part, who talks to whom, and how; [`plausible`]: the bounds of the coupler's checks; [`schema`]: the keys for editors;
//! - [`source`]: the text and the places of its keys; [`overrides`]: `KEY=VALUE`; [`load`]: a scenario by folder, file or name, read and checked;
//! - [`content`], [`inputs`]: what the files that a scenario names held when a run read them.
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
