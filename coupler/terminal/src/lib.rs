//! Words on stderr, to a person or a program:
//!
//! - [`stderr`]: what is told, and the lines that are redrawn at its end;
//! - [`run`]: what happens in a run; [`count`]: finished runs, messages or windows.

pub mod count;
pub mod run;
pub mod stderr;

pub use count::Count;
pub use run::listener;
pub use stderr::{tell, tell_progress};
