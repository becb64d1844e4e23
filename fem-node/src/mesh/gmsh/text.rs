//! The file as sections of words, each with its line.

use std::str::FromStr;

use kit::ConfigError;

use super::error::{beginning, damaged, truncated};

/// A section `$Name ... $EndName`.
#[derive(Clone, Debug)]
pub(super) struct Section<'a> {
    pub(super) name: &'a str,
    /// Number of its first line.
    pub(super) line: usize,
    lines: &'a [&'a str],
}

/// Sections in their order. Text between them is ignored, as Gmsh does.
pub(super) fn sections<'a>(lines: &'a [&'a str]) -> Result<Vec<Section<'a>>, ConfigError> {
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
        sections.push(Section {
            name,
            line: at + 2,
            lines: &lines[at + 1..at + 1 + length],
        });
        at += length + 2;
    }
    Ok(sections)
}

impl<'a> Section<'a> {
    /// Its words, one after the other.
    pub(super) fn words(&self) -> Words<'a> {
        Words {
            section: self.name,
            line: self.line,
            rest: self.lines.first().copied().unwrap_or_default(),
            later: self.lines.get(1..).unwrap_or_default(),
        }
    }
}

/// The words of a section that have not been read.
pub(super) struct Words<'a> {
    section: &'a str,
    /// Line of the next word, unless it stands further down.
    pub(super) line: usize,
    rest: &'a str,
    later: &'a [&'a str],
}

impl<'a> Words<'a> {
    /// The next word; one in double quotes may hold blanks, and comes without them.
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

    /// The next words as whole numbers. Nothing is reserved for what the file only promises.
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

    /// Leaves out some words.
    pub(super) fn skip(&mut self, count: usize, what: &'static str) -> Result<(), ConfigError> {
        (0..count).try_for_each(|_| self.word(what).map(|_| ()))
    }

    /// Nothing may be left once `announced` entries have been read.
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
