//! Loads and other numbers over time: `load_table = [[t_s, n], ...]`.

use crate::keys::ConfigError;

/// Times (s) and forces (N), by ascending time.
pub type LoadTable = Vec<[f64; 2]>;

/// Force at a time (N): linear between the entries, constant before the first and after the last; 0 without entries.
///
/// N = N0 + (N1 - N0) (t - t0)/(t1 - t0). The fraction is computed first: from [0, 0] to [T, N] the force has the same bits as
/// a linear ramp, N times t/T.
pub fn load_at(table: &[[f64; 2]], time: f64) -> f64 {
    let next = table.partition_point(|[t, _]| *t <= time);
    match (next.checked_sub(1).map(|last| table[last]), table.get(next)) {
        (Some([t0, n0]), Some([t1, n1])) => n0 + (n1 - n0) * ((time - t0) / (t1 - t0)),
        (Some([_, n]), None) => n,
        (None, first) => first.map_or(0.0, |[_, n]| *n),
    }
}

/// Slope just after a time (N/s): 0 before the first entry and from the last one on.
pub fn slope_at(table: &[[f64; 2]], time: f64) -> f64 {
    let next = table.partition_point(|[t, _]| *t <= time);
    let stretch = next.checked_sub(1).and_then(|last| table.get(last..=next));
    stretch.map_or(0.0, |ends| {
        (ends[1][1] - ends[0][1]) / (ends[1][0] - ends[0][0])
    })
}

/// The integral of [`load_at`] from 0 to a time that is not negative (N s).
pub fn integral_to(table: &[[f64; 2]], time: f64) -> f64 {
    let ends = table.iter().map(|[t, _]| t.clamp(0.0, time));
    let (mut sum, mut from) = (0.0, 0.0);
    for end in ends.chain([time]) {
        sum += (end - from) * (0.5 * (load_at(table, from) + load_at(table, end)));
        from = end;
    }
    sum
}

/// Time from which the force stays constant (s); `None` without a table, and for a constant force.
pub fn last_change(table: Option<&LoadTable>) -> Option<f64> {
    let mut changes = table?.windows(2).filter(|pair| pair[0][1] != pair[1][1]);
    changes.next_back().map(|pair| pair[1][0])
}

/// Refuses a table without entries, numbers that are not finite, and times that do not ascend.
///
/// # Errors
/// Names the `key`, the number of the entry from 0 on, the fault, and what to write instead.
pub fn check_table(key: &str, table: &[[f64; 2]]) -> Result<(), ConfigError> {
    let refused = |problem: String, help: &str| Err(ConfigError::new(key, problem).help(help));
    if table.is_empty() {
        return refused(
            "has no entries".into(),
            "write pairs of numbers, [[x, y], ...]",
        );
    }
    if let Some(i) = table.iter().position(|e| e.iter().any(|x| !x.is_finite())) {
        let problem = format!("entry {i} is {:?}, and must hold finite numbers", table[i]);
        return refused(problem, "write pairs of numbers, [[x, y], ...]");
    }
    let Some(i) = table.windows(2).position(|pair| pair[1][0] <= pair[0][0]) else {
        return Ok(());
    };
    let problem = format!(
        "entry {} is at {:e}, not after the previous one at {:e}",
        i + 1,
        table[i + 1][0],
        table[i][0]
    );
    refused(
        problem,
        "list the entries in ascending order of their first number",
    )
}

/// Refuses a wheel's load table, `wheel.load_table`, with an upward load, or whose load at `held_at` (s), the end of the hold,
/// differs from the load of the results, `wheel.load_n` (N).
///
/// # Errors
/// As [`check_table`].
pub fn check_wheel_table(table: &[[f64; 2]], held_at: f64, load: f64) -> Result<(), ConfigError> {
    let key = "wheel.load_table";
    check_table(key, table)?;
    let refused = |problem: String, help: &str| Err(ConfigError::new(key, problem).help(help));
    if let Some([_, upwards]) = table.iter().find(|[_, load]| *load < 0.0) {
        let problem = format!("must be at least 0 N, got {upwards:?}");
        return refused(problem, "loads press downwards");
    }
    let held = load_at(table, held_at);
    if (held - load).abs() <= 1e-9 * load {
        return Ok(());
    }
    let problem = format!("is {held:e} N at the end of the hold, and wheel.load_n is {load:e} N");
    refused(
        problem,
        "write the load at which results are taken in wheel.load_n",
    )
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
        for (time, slope) in [
            (0.0, 0.0),
            (1.0, 10.0),
            (2.9, 10.0),
            (3.0, -30.0),
            (4.0, 0.0),
        ] {
            assert_eq!(slope_at(&table, time), slope, "{time}");
        }
    }

    #[test]
    fn a_rise_from_zero_has_the_bits_of_a_ramp() {
        let (end, load) = (0.3, 7.1);
        for k in 0..100 {
            let time = 0.003 * f64::from(k);
            let ramp = load * (time / end);
            assert_eq!(load_at(&[[0.0, 0.0], [end, load]], time), ramp, "{time}");
        }
    }

    #[test]
    fn a_wrong_table_is_refused_by_its_key_and_entry() {
        for (table, named) in [
            (vec![], "no entries"),
            (vec![[0.0, 1.0], [2.0, 1.0], [2.0, 3.0]], "entry 2"),
            (vec![[0.0, 1.0], [2.0, f64::NAN]], "entry 1"),
        ] {
            let error = check_table("wheel.load_table", &table).expect_err("the table is wrong");
            let text = error.to_string();
            assert!(
                text.contains("wheel.load_table") && text.contains(named),
                "{text}"
            );
            assert!(error.help.is_some(), "{text}");
        }
    }

    #[test]
    fn a_table_of_a_wheel_has_no_upward_load_and_holds_the_load_of_the_results() {
        let message = |table: &[[f64; 2]]| {
            let error = check_wheel_table(table, 1.0, 8.0).expect_err("the table is wrong");
            error.to_string()
        };
        assert!(check_wheel_table(&[[0.0, 0.0], [1.0, 8.0]], 1.0, 8.0).is_ok());
        let upwards = message(&[[0.0, 8.0], [2.0, 8.0], [3.0, -1.0]]);
        assert!(upwards.contains("at least 0 N, got -1.0"), "{upwards}");
        let other = message(&[[0.0, 0.0], [2.0, 8.0]]);
        assert!(other.contains("4e0 N at the end of the hold"), "{other}");
    }
}
