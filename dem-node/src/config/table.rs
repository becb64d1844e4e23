//! Loads over time: `load_table = [[t_s, n], ...]`.

use protocol::ConfigError;

use super::limits::{finite, refuse_if};

/// Times (s) and forces (N), by ascending time.
pub type LoadTable = Vec<[f64; 2]>;

/// Force at a time (N): linear between the entries, constant before the first and after the last; 0 without entries.
pub fn load_at(table: &[[f64; 2]], time: f64) -> f64 {
    let next = table.partition_point(|[t, _]| *t <= time);
    match (next.checked_sub(1).map(|last| table[last]), table.get(next)) {
        (Some([t0, n0]), Some([t1, n1])) => n0 + (n1 - n0) * (time - t0) / (t1 - t0),
        (Some([_, n]), None) => n,
        (None, Some([_, n])) => *n,
        (None, None) => 0.0,
    }
}

pub(super) fn validate_table(key: &str, table: &[[f64; 2]]) -> Result<(), ConfigError> {
    refuse_if(
        table.is_empty(),
        key,
        "has no entries",
        "write [[t_s, n], ...]",
    )?;
    for number in table.iter().flatten() {
        finite(key, *number)?;
    }
    for (i, pair) in table.windows(2).enumerate() {
        refuse_if(
            pair[1][0] <= pair[0][0],
            key,
            format!(
                "entry {} is at {:e} s, not after {:e} s of the one before",
                i + 1,
                pair[1][0],
                pair[0][0]
            ),
            "list the entries by ascending time",
        )?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn loads_are_linear_between_entries_and_constant_beyond() {
        let table = [[1.0, 10.0], [3.0, 30.0], [4.0, 0.0]];
        for (time, load) in [
            (0.0, 10.0),
            (1.0, 10.0),
            (1.5, 15.0),
            (3.0, 30.0),
            (3.75, 7.5),
            (9.0, 0.0),
        ] {
            assert_eq!(load_at(&table, time), load, "{time}");
        }
        assert_eq!(load_at(&[], 1.0), 0.0);
    }

    #[test]
    fn entries_that_go_back_are_refused_by_their_number() {
        let error = validate_table("wheel.load_table", &[[0.0, 1.0], [2.0, 1.0], [2.0, 3.0]]);
        let text = error
            .expect_err("two entries are at the same time")
            .to_string();
        assert!(
            text.contains("wheel.load_table") && text.contains("entry 2"),
            "{text}"
        );
    }
}
