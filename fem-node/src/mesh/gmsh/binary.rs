//! Binary files, converted to text.
//!
//! Format: Geuzaine and Remacle, Gmsh reference manual. Names of sections and `$PhysicalNames` are text in either form;
//! `$Nodes`, `$Elements` and (4.1) `$Entities` hold 4-byte whole numbers, in 4.1 8-byte counts and numbers of nodes and elements, and 8-byte
//! floating-point numbers. A one after the format shows the byte order. Numbers are written so that they read back to the bit: one reader serves both
//! forms.

use std::fmt::{Display, Write};

use kit::ConfigError;

use super::error::{damaged, other_form, truncated};

/// Bytes of a count or a floating-point number, the only size that is read.
const WIDE: &str = "8";

/// True where the second line announces binary content.
pub(super) fn is_binary(bytes: &[u8]) -> bool {
    let mut lines = bytes.split(|byte| *byte == b'\n').map(<[u8]>::trim_ascii);
    let mut lines = lines.by_ref().filter(|line| !line.is_empty());
    let format = (lines.next() == Some(b"$MeshFormat")).then(|| lines.next());
    let mut words = format.flatten().unwrap_or_default().split(|b| *b == b' ');
    words.nth(1) == Some(b"1")
}

/// The text of a binary file.
pub(super) fn to_text(bytes: &[u8]) -> Result<String, ConfigError> {
    let mut reader = Reader {
        bytes,
        at: 0,
        section: "MeshFormat",
        big_endian: false,
        text: String::new(),
    };
    let four = reader.format()?;
    while reader.next_section()? {
        match reader.section {
            "Nodes" if four => reader.node_blocks()?,
            "Nodes" => reader.nodes()?,
            "Elements" if four => reader.element_blocks()?,
            "Elements" => reader.elements()?,
            "Entities" if four => reader.entities()?,
            "PhysicalNames" => reader.copy()?,
            _ => reader.leave_out()?,
        }
    }
    Ok(reader.text)
}

/// Bytes, the position of the reader, and the text of the bytes before it.
struct Reader<'a> {
    bytes: &'a [u8],
    at: usize,
    /// The current section.
    section: &'a str,
    big_endian: bool,
    text: String,
}

impl<'a> Reader<'a> {
    /// The header; true for version 4.1.
    fn format(&mut self) -> Result<bool, ConfigError> {
        self.line()?;
        let mut words = self.line()?.split_whitespace();
        let version = words.next().unwrap_or_default();
        let size = words.nth(1).unwrap_or_default();
        if size != WIDE {
            return Err(other_form(format!(
                "it is binary with counts or numbers of {size} bytes; only 8 are supported"
            )));
        }
        self.big_endian = match self.take()? {
            [1, 0, 0, 0] => false,
            [0, 0, 0, 1] => true,
            _ => {
                let problem = "its header declares binary data, but no 1 of 4 bytes follows";
                return Err(damaged(problem.into()));
            }
        };
        self.put(format_args!("$MeshFormat\n{version} 0 {WIDE}\n"));
        self.end()?;
        Ok(version == "4.1")
    }

    /// Goes to the next section, if there is one; text between sections is ignored.
    fn next_section(&mut self) -> Result<bool, ConfigError> {
        while self.at < self.bytes.len() {
            if let Some(name) = self.line()?.trim().strip_prefix('$') {
                self.section = name;
                return Ok(true);
            }
        }
        Ok(false)
    }

    fn nodes(&mut self) -> Result<(), ConfigError> {
        for _ in 0..self.begin_counted()? {
            self.integer()?;
            self.doubles(3)?;
            self.put("\n");
        }
        self.end()
    }

    fn node_blocks(&mut self) -> Result<(), ConfigError> {
        for _ in 0..self.begin_blocks()? {
            let dimension = self.integer()?;
            self.integer()?;
            let parameters = match self.integer()? {
                0 => 0,
                _ => dimension.max(0) as u64,
            };
            let count = self.size()?;
            self.sizes(count)?;
            for _ in 0..count {
                self.doubles(3 + parameters)?;
                self.put("\n");
            }
        }
        self.end()
    }

    fn elements(&mut self) -> Result<(), ConfigError> {
        let count = self.begin_counted()?;
        let mut read = 0;
        while read < count {
            let [kind, following, tags] = [self.take_int()?, self.take_int()?, self.take_int()?];
            for _ in 0..following {
                self.integer()?;
                self.put(format_args!("{kind} {tags} "));
                self.integers(tags.max(0) as u64)?;
                let Some(corners) = corners(kind) else {
                    return self.give_up();
                };
                self.integers(corners)?;
                self.put("\n");
            }
            read += following.max(1) as u64;
        }
        self.end()
    }

    fn element_blocks(&mut self) -> Result<(), ConfigError> {
        for _ in 0..self.begin_blocks()? {
            self.integers(2)?;
            let kind = self.integer()?;
            let count = self.size()?;
            self.put("\n");
            for _ in 0..count {
                self.size()?;
                let Some(corners) = corners(kind) else {
                    return self.give_up();
                };
                self.sizes(corners)?;
                self.put("\n");
            }
        }
        self.end()
    }

    fn entities(&mut self) -> Result<(), ConfigError> {
        self.begin();
        let counts = [self.size()?, self.size()?, self.size()?, self.size()?];
        for (dimension, count) in counts.into_iter().enumerate() {
            for _ in 0..count {
                self.integer()?;
                self.doubles(if dimension == 0 { 3 } else { 6 })?;
                let groups = self.size()?;
                self.integers(groups)?;
                if dimension > 0 {
                    let boundary = self.size()?;
                    self.integers(boundary)?;
                }
                self.put("\n");
            }
        }
        self.end()
    }

    /// Copies a section that is text in either form.
    fn copy(&mut self) -> Result<(), ConfigError> {
        self.begin();
        let end = format!("$End{}", self.section);
        loop {
            let line = self.line()?;
            self.put(format_args!("{line}\n"));
            if line.trim() == end {
                return Ok(());
            }
        }
    }

    /// Skips a section that a body does not need.
    fn leave_out(&mut self) -> Result<(), ConfigError> {
        let end = format!("\n$End{}", self.section);
        let rest = &self.bytes[self.at.saturating_sub(1)..];
        let found = rest.windows(end.len()).position(|w| w == end.as_bytes());
        self.at += found.ok_or_else(|| truncated(self.section))? + end.len() - 1;
        Ok(())
    }

    fn begin(&mut self) {
        let section = self.section;
        self.put(format_args!("${section}\n"));
    }

    /// Copies the section's name and the number of its entries, which 2.2 writes as text.
    fn begin_counted(&mut self) -> Result<u64, ConfigError> {
        self.begin();
        let line = self.line()?;
        self.put(format_args!("{line}\n"));
        line.trim().parse().map_err(|_| self.misplaced())
    }

    /// Copies the section's name, the number of its blocks, and three more numbers.
    fn begin_blocks(&mut self) -> Result<u64, ConfigError> {
        self.begin();
        let blocks = self.size()?;
        self.sizes(3)?;
        Ok(blocks)
    }

    /// Copies the end of the section, which must be here.
    fn end(&mut self) -> Result<(), ConfigError> {
        let end = format!("$End{}", self.section);
        let blanks = self.bytes[self.at..].iter();
        self.at += blanks.take_while(|b| b.is_ascii_whitespace()).count();
        if !self.bytes[self.at..].starts_with(end.as_bytes()) {
            let complete = self.at < self.bytes.len();
            return Err(if complete {
                self.misplaced()
            } else {
                truncated(self.section)
            });
        }
        self.line()?;
        self.put(format_args!("\n{end}\n"));
        Ok(())
    }

    /// Ends the text at an element of unknown size; the reader of the text refuses it by its type.
    fn give_up(&mut self) -> Result<(), ConfigError> {
        self.put("\n$EndElements\n");
        self.at = self.bytes.len();
        Ok(())
    }

    fn line(&mut self) -> Result<&'a str, ConfigError> {
        let rest = &self.bytes[self.at..];
        if rest.is_empty() {
            return Err(truncated(self.section));
        }
        let line = rest.split(|b| *b == b'\n').next().unwrap_or_default();
        let text = str::from_utf8(line).map_err(|_| self.misplaced())?;
        self.at = (self.at + line.len() + 1).min(self.bytes.len());
        Ok(text.trim_end_matches('\r'))
    }

    fn integers(&mut self, count: u64) -> Result<(), ConfigError> {
        (0..count).try_for_each(|_| self.integer().map(|_| ()))
    }

    fn sizes(&mut self, count: u64) -> Result<(), ConfigError> {
        (0..count).try_for_each(|_| self.size().map(|_| ()))
    }

    fn doubles(&mut self, count: u64) -> Result<(), ConfigError> {
        for _ in 0..count {
            let value = f64::from_bits(self.take_wide()?);
            self.put(format_args!("{value:e} "));
        }
        Ok(())
    }

    fn integer(&mut self) -> Result<i32, ConfigError> {
        let value = self.take_int()?;
        self.put(format_args!("{value} "));
        Ok(value)
    }

    fn size(&mut self) -> Result<u64, ConfigError> {
        let value = self.take_wide()?;
        self.put(format_args!("{value} "));
        Ok(value)
    }

    fn take_int(&mut self) -> Result<i32, ConfigError> {
        self.take().map(i32::from_le_bytes)
    }

    fn take_wide(&mut self) -> Result<u64, ConfigError> {
        self.take().map(u64::from_le_bytes)
    }

    /// The next bytes, the lowest first.
    fn take<const N: usize>(&mut self) -> Result<[u8; N], ConfigError> {
        let taken = self.bytes[self.at..].first_chunk();
        let mut taken = *taken.ok_or_else(|| truncated(self.section))?;
        if self.big_endian {
            taken.reverse();
        }
        self.at += N;
        Ok(taken)
    }

    fn put(&mut self, what: impl Display) {
        write!(self.text, "{what}").expect("a string takes what it is given");
    }

    fn misplaced(&self) -> ConfigError {
        let (byte, section) = (self.at, self.section);
        damaged(format!(
            "byte {byte}: ${section} should end or continue differently there"
        ))
    }
}

/// Number of nodes of the supported elements.
fn corners(kind: i32) -> Option<u64> {
    match kind {
        1 => Some(2),
        3 => Some(4),
        15 => Some(1),
        _ => None,
    }
}
