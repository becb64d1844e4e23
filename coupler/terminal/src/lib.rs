//! Messages on stderr, for a person or a program:
//!
//! - [`stderr`]: notes and events, and the lines that are redrawn at the end;
//! - [`run`]: events of a run; [`count`]: finished runs, messages or windows.

pub mod count;
pub mod run;
pub mod stderr;

pub use count::Count;
pub use run::listener;
pub use stderr::{print_note, tell_progress};
