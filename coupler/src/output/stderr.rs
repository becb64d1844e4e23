//! Words to a person on stderr.

use std::io::Write;

/// Tells a person something on stderr. Whoever closed it does not want to know.
pub fn tell(text: &str) {
    let _ = writeln!(std::io::stderr().lock(), "{text}");
}
