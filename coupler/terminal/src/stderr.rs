//! Messages on stderr, for a person or a program.
//!
//! A process has one stderr, so the output mode and the block of lines that is redrawn at the end are global. Messages appear above the
//! block.

use std::fmt::Write as _;
use std::io::{IsTerminal, Write};
use std::sync::{Mutex, OnceLock, PoisonError};

use serde_json::{Value, json};
use terminal_size::{Width, terminal_size_of};

/// Output mode of this process.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum StderrMode {
    /// Sentences, and progress.
    #[default]
    Progress,
    /// Sentences without progress.
    Quiet,
    /// One JSON object per line.
    JsonLines,
}

static STDERR_MODE: OnceLock<StderrMode> = OnceLock::new();
static BLOCK: Mutex<Vec<String>> = Mutex::new(Vec::new());

/// Sets the output mode. Only the first call has an effect.
pub fn set_stderr_mode(stderr_mode: StderrMode) {
    let _ = STDERR_MODE.set(stderr_mode);
}

/// Output mode of this process.
pub fn stderr_mode() -> StderrMode {
    STDERR_MODE.get().copied().unwrap_or_default()
}

/// Prints a line, for a program as the `text` of the event `note`. Errors of a closed stderr are ignored.
pub fn print_note(text: &str) {
    print_event("note", json!({ "text": text }), || text.into());
}

/// Prints a note on progress, except in quiet mode.
pub fn tell_progress(text: &str) {
    if stderr_mode() != StderrMode::Quiet {
        print_note(text);
    }
}

/// Prints words for a person, or an object for a program; the object gets its name as `event`.
pub fn print_event(event: &str, object: Value, words: impl FnOnce() -> String) {
    let line = match stderr_mode() {
        StderrMode::JsonLines => named(event, object).to_string(),
        StderrMode::Progress | StderrMode::Quiet => words(),
    };
    let block = BLOCK.lock().unwrap_or_else(PoisonError::into_inner);
    write(&redrawn(&block, &format!("{line}\n"), &block));
}

/// Text that clears a block from a terminal, writes something in its place, and a new block below that.
fn redrawn(old: &[String], between: &str, new: &[String]) -> String {
    let mut text = String::new();
    if !old.is_empty() {
        // Move to the beginning of the first line, then clear everything from there on.
        let _ = write!(text, "\r\x1b[{}A\x1b[J", old.len());
    }
    text.push_str(between);
    for line in new {
        let _ = writeln!(text, "{line}");
    }
    text
}

fn write(text: &str) {
    let mut stderr = std::io::stderr().lock();
    let _ = stderr.write_all(text.as_bytes());
}

/// The object with its name as the first key.
fn named(event: &str, object: Value) -> Value {
    let mut named = json!({ "event": event });
    if let (Some(named), Value::Object(keys)) = (named.as_object_mut(), object) {
        named.extend(keys);
    }
    named
}

/// Columns of the terminal on stderr; `None` if stderr is no terminal, or one that cannot redraw lines.
pub fn columns() -> Option<usize> {
    let stderr = std::io::stderr();
    let dumb = std::env::var_os("TERM").is_none_or(|kind| kind == "dumb");
    (stderr.is_terminal() && !dumb).then(|| {
        // A terminal of unknown size is at least as wide as the narrowest in use.
        terminal_size_of(&stderr).map_or(80, |(Width(columns), _)| columns.into())
    })
}

/// Draws lines at the end of a terminal of `columns` columns, in place of the lines drawn before.
pub fn draw(lines: &[String], columns: usize) {
    let lines = cut(lines, columns);
    let mut block = BLOCK.lock().unwrap_or_else(PoisonError::into_inner);
    write(&redrawn(&block, "", &lines));
    *block = lines;
}

pub(crate) fn cut(lines: &[String], columns: usize) -> Vec<String> {
    let cut = |line: &String| line.chars().take(columns).collect();
    lines.iter().map(cut).collect()
}

/// Leaves the drawn lines standing; the next message comes below them.
pub fn leave() {
    let mut block = BLOCK.lock().unwrap_or_else(PoisonError::into_inner);
    block.clear();
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_message_comes_above_the_block() {
        let block = ["a", "b"].map(String::from);
        assert_eq!(redrawn(&[], "", &block), "a\nb\n");
        assert_eq!(
            redrawn(&block, "note\n", &block),
            "\r\x1b[2A\x1b[Jnote\na\nb\n"
        );
        assert_eq!(redrawn(&[], "note\n", &[]), "note\n");
    }

    #[test]
    fn an_object_begins_with_its_name() {
        let object = named("note", json!({ "text": "a \"b\"\nc" }));
        assert_eq!(
            object.to_string(),
            r#"{"event":"note","text":"a \"b\"\nc"}"#
        );
    }
}
