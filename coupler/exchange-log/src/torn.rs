//! Distinguishes the torn end after a killed writer from damage.

use std::fs::File;
use std::io;
use std::os::unix::fs::FileExt;

use mcap::MAGIC;
use mcap::records::op;

use super::lengths::{Layout, layout};

/// Size of kind and length before the data of each record (bytes).
pub(super) const FRAMING: usize = 9;

/// Longest beginning of a record that is checked (bytes).
const BEGINNING: u64 = 1 << 12;

/// True if a file is the beginning of a log: it ends inside the record at `offset`, or right before it. A file with the end of a log was
/// closed. If the parts of a record do not add up to its length, the length is damaged.
pub(super) fn is_torn(file: &File, offset: u64) -> io::Result<bool> {
    let size = file.metadata()?.len();
    let part = |start: u64, length: u64| {
        let mut bytes = vec![0; length.min(size.saturating_sub(start)) as usize];
        file.read_exact_at(&mut bytes, start).map(|()| bytes)
    };
    let magic = MAGIC.len() as u64;
    let (first, last) = (part(0, magic)?, part(size.saturating_sub(magic), magic)?);
    if size <= magic {
        return Ok(MAGIC.starts_with(&first));
    }
    if first != MAGIC || last == MAGIC {
        return Ok(false);
    }
    let beginning = part(offset, BEGINNING)?;
    let Some((framing, data)) = beginning.split_at_checked(FRAMING) else {
        let record = beginning.first().is_none_or(|kind| *kind <= op::DATA_END);
        return Ok(record || MAGIC.starts_with(&beginning));
    };
    let (opcode, length) = (framing[0], number(&framing[1..]));
    let left = size - offset - FRAMING as u64;
    Ok(length > left && may_have_length(opcode, data, length))
}

/// True unless the beginning of a record implies another length.
fn may_have_length(opcode: u8, data: &[u8], length: u64) -> bool {
    match opcode {
        op::DATA_END => length == 4,
        // These describe the data at the end of the file, which is not read here.
        op::FOOTER | op::SCHEMA | op::CHANNEL | op::STATISTICS | op::SUMMARY_OFFSET => true,
        op::CHUNK_INDEX | op::ATTACHMENT_INDEX | op::METADATA_INDEX => true,
        _ => {
            layout(opcode).is_some_and(|layout| layout.length(data).is_none_or(|due| due == length))
        }
    }
}

impl Layout {
    /// Length of all parts, if the available part of the record determines it.
    fn length(&self, data: &[u8]) -> Option<u64> {
        let mut end = self.front;
        for width in self.counted {
            let start = usize::try_from(end).ok()?;
            let count = data.get(start..start.checked_add(*width as usize)?)?;
            end = end.checked_add(width + number(count))?;
        }
        end.checked_add(self.back)
    }
}

/// A little-endian number of up to eight bytes.
fn number(bytes: &[u8]) -> u64 {
    let digits = bytes.iter().rev();
    digits.fold(0, |number, byte| number << 8 | u64::from(*byte))
}
