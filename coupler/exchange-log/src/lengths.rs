//! Checks of lengths inside records before memory is reserved: four damaged bytes may claim four gigabytes.

use mcap::records::{Record, op};

use super::error::chain;

/// The parts of a record in order (MCAP 0, "Records").
pub(super) struct Layout {
    /// Bytes of the numbers at the beginning.
    pub(super) front: u64,
    /// Number of bytes of the length of each part that follows its length.
    pub(super) counted: &'static [u64],
    /// True if the last of these parts contains texts, each after its length in four bytes.
    map: bool,
    /// Bytes of the numbers at the end.
    pub(super) back: u64,
}

/// The layout of a record that has parts with lengths.
pub(super) fn layout(opcode: u8) -> Option<Layout> {
    let (front, counted, map, back): (_, &[_], _, _) = match opcode {
        op::HEADER => (0, &[4, 4], false, 0),
        op::SCHEMA => (2, &[4, 4, 4], false, 0),
        op::CHANNEL => (2 + 2, &[4, 4, 4], true, 0),
        op::CHUNK => (8 + 8 + 8 + 4, &[4, 8], false, 0),
        op::MESSAGE_INDEX => (2, &[4], false, 0),
        op::ATTACHMENT => (8 + 8, &[4, 4, 8], false, 4),
        op::METADATA => (0, &[4, 4], true, 0),
        _ => return None,
    };
    Some(Layout {
        front,
        counted,
        map,
        back,
    })
}

/// Parses a record whose lengths fit into it.
pub(super) fn parse(opcode: u8, data: &[u8]) -> Result<Record<'_>, String> {
    if fits(opcode, data).is_none() {
        return Err(format!(
            "a record of kind {opcode:#04x} claims more than its {} bytes",
            data.len()
        ));
    }
    mcap::parse_record(opcode, data).map_err(|error| chain(&error))
}

/// `None` if a length passes the end of the record. The reader does not copy parts whose length has eight bytes.
fn fits(opcode: u8, data: &[u8]) -> Option<()> {
    let Some(layout) = layout(opcode) else {
        return Some(());
    };
    let (mut part, mut rest) = (&[][..], data.get(layout.front as usize..)?);
    for _ in layout.counted.iter().filter(|width| **width == 4) {
        (part, rest) = block(rest)?;
    }
    while layout.map && !part.is_empty() {
        (_, part) = block(part)?;
    }
    Some(())
}

/// Bytes after their length, and the rest.
fn block(data: &[u8]) -> Option<(&[u8], &[u8])> {
    let (length, rest) = data.split_first_chunk()?;
    rest.split_at_checked(u32::from_le_bytes(*length) as usize)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_length_beyond_its_record_reserves_no_memory() {
        let text = |length: u32| [&length.to_le_bytes()[..], b"abc"].concat();
        let metadata = |lengths: [u32; 4]| {
            let [name, map, key, value] = lengths;
            [
                text(name),
                map.to_le_bytes().to_vec(),
                text(key),
                text(value),
            ]
            .concat()
        };
        assert!(parse(op::METADATA, &metadata([3, 14, 3, 3])).is_ok());
        for wrong in [
            [u32::MAX, 14, 3, 3],
            [3, u32::MAX, 3, 3],
            [3, 14, u32::MAX, 3],
            [3, 14, 3, u32::MAX],
        ] {
            let error = parse(op::METADATA, &metadata(wrong)).expect_err("it passes the end");
            assert!(error.contains("claims more than its 25 bytes"), "{error}");
        }
        for opcode in [
            op::SCHEMA,
            op::CHANNEL,
            op::MESSAGE_INDEX,
            op::CHUNK,
            op::ATTACHMENT,
        ] {
            assert!(parse(opcode, &[255; 60]).is_err(), "{opcode:#04x}");
        }
    }
}
