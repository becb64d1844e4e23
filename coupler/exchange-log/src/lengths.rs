//! Lengths inside of records, before anybody reserves memory for them: four damaged bytes may claim four gigabytes.

use mcap::records::{Record, op};

use super::error::chain;

/// The parts of a record that carry their lengths (MCAP 0, "Records").
struct Layout {
    /// Bytes before the first text.
    fixed: usize,
    /// Texts, each behind its length in four bytes.
    texts: usize,
    /// The rest of the record, behind its texts.
    tail: Tail,
}

enum Tail {
    /// Bytes that the reader does not copy.
    Rest,
    /// Bytes behind their length in four bytes.
    Block,
    /// Texts in such a block.
    Map,
}

fn layout(opcode: u8) -> Layout {
    let (fixed, texts, tail) = match opcode {
        op::SCHEMA => (2, 2, Tail::Block),
        op::CHANNEL => (4, 2, Tail::Map),
        op::MESSAGE_INDEX => (2, 0, Tail::Block),
        op::CHUNK => (28, 1, Tail::Rest),
        op::ATTACHMENT => (16, 2, Tail::Rest),
        op::METADATA => (0, 1, Tail::Map),
        _ => (0, 0, Tail::Rest),
    };
    Layout { fixed, texts, tail }
}

/// A record whose lengths fit into it.
pub(super) fn parse(opcode: u8, data: &[u8]) -> Result<Record<'_>, String> {
    if fits(opcode, data).is_none() {
        return Err(format!(
            "a record of kind {opcode:#04x} claims more than its {} bytes",
            data.len()
        ));
    }
    mcap::parse_record(opcode, data).map_err(|error| chain(&error))
}

/// Nothing if a length passes the end of the record.
fn fits(opcode: u8, data: &[u8]) -> Option<()> {
    let Layout { fixed, texts, tail } = layout(opcode);
    let mut rest = data.get(fixed..)?;
    for _ in 0..texts {
        (_, rest) = block(rest)?;
    }
    match tail {
        Tail::Rest => {}
        Tail::Block => drop(block(rest)?),
        Tail::Map => {
            let (mut texts, _) = block(rest)?;
            while !texts.is_empty() {
                (_, texts) = block(texts)?;
            }
        }
    }
    Some(())
}

/// Bytes behind their length, and what follows them.
fn block(data: &[u8]) -> Option<(&[u8], &[u8])> {
    let (length, rest) = data.split_first_chunk()?;
    rest.split_at_checked(u32::from_le_bytes(*length) as usize)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_length_beyond_its_record_is_no_reason_to_reserve_memory() {
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
