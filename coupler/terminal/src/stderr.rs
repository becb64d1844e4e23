//! Words on stderr, to a person or a program.
//!
//! There is one stderr, so its manner and the block of lines that is redrawn at its end are those of the process: whatever is told
//! comes above the block.

use std::fmt::Write as _;
use std::io::{IsTerminal, Write};
use std::sync::{Mutex, OnceLock, PoisonError};

use serde_json::{Value, json};
use terminal_size::{Width, terminal_size_of};

/// The manner in which this process speaks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum StderrMode {
    /// Sentences, and progress.
    #[default]
    Progress,
    /// Sentences without progress.
    Quiet,
    /// One JSON object a line.
    JsonLines,
}

static STDERR_MODE: OnceLock<StderrMode> = OnceLock::new();
static BLOCK: Mutex<Vec<String>> = Mutex::new(Vec::new());

/// Has this process speak in a manner. The first word counts.
pub fn set_stderr_mode(stderr_mode: StderrMode) {
    let _ = STDERR_MODE.set(stderr_mode);
}

/// The manner in which this process speaks.
pub fn stderr_mode() -> StderrMode {
    STDERR_MODE.get().copied().unwrap_or_default()
}

/// Tells a person something, a program the same as the `text` of a `note`. Errors of a closed stderr are ignored.
pub fn tell(text: &str) {
    tell_of("note", json!({ "text": text }), || text.into());
}

/// The same about how far something has come, which is not told to who wants it quiet.
pub fn tell_progress(text: &str) {
    if stderr_mode() != StderrMode::Quiet {
        tell(text);
    }
}

/// Tells a person in words what a program is told as an object, which gets its name as `event`.
pub fn tell_of(event: &str, object: Value, words: impl FnOnce() -> String) {
    let line = match stderr_mode() {
        StderrMode::JsonLines => named(event, object).to_string(),
        StderrMode::Progress | StderrMode::Quiet => words(),
    };
    let block = BLOCK.lock().unwrap_or_else(PoisonError::into_inner);
    write(&redrawn(&block, &format!("{line}\n"), &block));
}

/// Text that takes a block off a terminal, writes something in its place, and a block below that.
fn redrawn(old: &[String], between: &str, new: &[String]) -> String {
    let mut text = String::new();
    if !old.is_empty() {
        // To the beginning of its first line; then everything from there on is cleared.
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

/// The object with its name in front.
fn named(event: &str, object: Value) -> Value {
    let mut named = json!({ "event": event });
    if let (Some(named), Value::Object(keys)) = (named.as_object_mut(), object) {
        named.extend(keys);
    }
    named
}

/// Columns of the terminal that stderr is; none where it is no terminal on which lines can be redrawn.
pub fn columns() -> Option<usize> {
    let stderr = std::io::stderr();
    let dumb = std::env::var_os("TERM").is_none_or(|kind| kind == "dumb");
    (stderr.is_terminal() && !dumb).then(|| {
        // One that does not tell its size is no narrower than the narrowest in use.
        terminal_size_of(&stderr).map_or(80, |(Width(columns), _)| columns.into())
    })
}

/// Draws lines at the end of a terminal that has so many columns, in place of those that were drawn before.
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

/// Leaves the drawn lines standing; what is told next comes below them.
pub fn leave() {
    let mut block = BLOCK.lock().unwrap_or_else(PoisonError::into_inner);
    block.clear();
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_told_comes_above_the_block() {
        let block = ["a", "b"].map(String::from);
        assert_eq!(redrawn(&[], "", &block), "a\nb\n");
        assert_eq!(
            redrawn(&block, "told\n", &block),
            "\r\x1b[2A\x1b[Jtold\na\nb\n"
        );
        assert_eq!(redrawn(&[], "told\n", &[]), "told\n");
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
