//! The file as sections of words, each with its line.

use std::str::FromStr;

use kit::ConfigError;

use super::error::{beginning, damaged, truncated};

/// The unread words of a section `$Name ... $EndName`.
#[derive(Clone)]
pub(super) struct Words<'a> {
    pub(super) section: &'a str,
    /// Line of the next word, unless that is further down.
    pub(super) line: usize,
    rest: &'a str,
    later: &'a [&'a str],
}

/// Sections in order. Text between them is ignored, as in Gmsh.
pub(super) fn sections<'a>(lines: &'a [&'a str]) -> Result<Vec<Words<'a>>, ConfigError> {
    let mut sections = Vec::new();
    let mut at = 0;
    while at < lines.len() {
        let Some(name) = lines[at].trim().strip_prefix('$') else {
            at += 1;
            continue;
        };
        let end = format!("$End{name}");
        let length = lines[at + 1..].iter().position(|line| line.trim() == end);
        let length = length.ok_or_else(|| truncated(name))?;
        let own = &lines[at + 1..at + 1 + length];
        sections.push(Words {
            section: name,
            line: at + 2,
            rest: own.first().copied().unwrap_or_default(),
            later: own.get(1..).unwrap_or_default(),
        });
        at += length + 2;
    }
    Ok(sections)
}

impl<'a> Words<'a> {
    /// The next word; a word in double quotes may hold blanks, and is returned without the quotes.
    pub(super) fn word(&mut self, what: &'static str) -> Result<&'a str, ConfigError> {
        self.find().ok_or_else(|| {
            let (line, section) = (self.line, self.section);
            damaged(format!(
                "line {line}: {what} is expected, but ${section} ends there"
            ))
        })
    }

    fn find(&mut self) -> Option<&'a str> {
        loop {
            self.rest = self.rest.trim_start();
            if !self.rest.is_empty() {
                break;
            }
            let (next, later) = self.later.split_first()?;
            (self.rest, self.later) = (next, later);
            self.line += 1;
        }
        let (word, rest) = match self.rest.strip_prefix('"') {
            Some(quoted) => quoted.split_once('"').unwrap_or((quoted, "")),
            None => {
                let end = self.rest.find(char::is_whitespace);
                self.rest.split_at(end.unwrap_or(self.rest.len()))
            }
        };
        self.rest = rest;
        Some(word)
    }

    /// The next word as a whole number.
    pub(super) fn integer<T: FromStr>(&mut self, what: &'static str) -> Result<T, ConfigError> {
        let word = self.word(what)?;
        word.parse().map_err(|_| self.unlike(what, word))
    }

    /// The next words as whole numbers. No memory is reserved for a count that the file only announces.
    pub(super) fn integers<T: FromStr>(
        &mut self,
        count: usize,
        what: &'static str,
    ) -> Result<Vec<T>, ConfigError> {
        (0..count).map(|_| self.integer(what)).collect()
    }

    /// The next word as a finite number.
    pub(super) fn number(&mut self) -> Result<f64, ConfigError> {
        let what = "a finite number";
        let word = self.word(what)?;
        let number: Option<f64> = word.parse().ok();
        number
            .filter(|number| number.is_finite())
            .ok_or_else(|| self.unlike(what, word))
    }

    /// Skips words.
    pub(super) fn skip(&mut self, count: usize, what: &'static str) -> Result<(), ConfigError> {
        (0..count).try_for_each(|_| self.word(what).map(|_| ()))
    }

    /// Refuses words after `announced` entries.
    pub(super) fn end(&mut self, announced: usize) -> Result<(), ConfigError> {
        let section = self.section;
        match self.find() {
            None => Ok(()),
            Some(_) => Err(damaged(format!(
                "line {}: ${section} goes on where {announced} entries have been read",
                self.line
            ))),
        }
    }

    fn unlike(&self, what: &'static str, word: &str) -> ConfigError {
        let (line, found) = (self.line, beginning(word));
        damaged(format!(
            "line {line}: {what} is expected, {found:?} stands there"
        ))
    }
}
