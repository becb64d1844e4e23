//! The farewell of a participant, read leniently: one number that is not finite must not spoil a whole run.

use protocol::Frame;
use protocol::serve::Farewell;
use serde_json::Value;

use super::admission::fault_of_names;

/// Reads a farewell. `NaN` and `Infinity` are not JSON, but some programs write them; they count as missing. A result
/// or a work without a value is left out with a warning; a time or a memory becomes zero.
pub fn read_farewell(frame: &Frame) -> Result<Farewell, String> {
    let text = frame.text().map_err(|error| error.to_string());
    let read = text.and_then(|text| {
        // Parsing to a tree of values takes ten times as long as reading a valid farewell.
        let read = serde_json::from_str(&text).or_else(|_| parse(&text));
        read.map_err(|error| error.to_string())
    });
    let mut farewell = read.map_err(|why| format!("sent an outcome that cannot be read: {why}"))?;
    leave_out_wrong_names(&mut farewell);
    Ok(farewell)
}

/// Results that the coordinator adds to summary.json itself.
const TAKEN: [&str; 6] = [
    "energy_balance_rel",
    "interface_nodes",
    "interface_points",
    "interface_force_n",
    "p0_1mm_pa",
    "half_width_98_m",
];

/// Leaves out results that would take the place of the coordinator's own, and names that a table cannot hold: the end of a long run is too late to
/// refuse them.
fn leave_out_wrong_names(farewell: &mut Farewell) {
    let outcome = &mut farewell.outcome;
    outcome.results.retain(|name, _| {
        let taken = || format!("names a result `{name}`, which the coordinator reports itself");
        let is_taken = TAKEN.contains(&name.as_str());
        let why = is_taken
            .then(taken)
            .or_else(|| fault_of_names("result", [name].into_iter()));
        let left_out = why.map(|why| format!("{why}: it is left out, give it another name"));
        let kept = left_out.is_none();
        outcome.warnings.extend(left_out);
        kept
    });
}

fn parse(text: &str) -> serde_json::Result<Farewell> {
    let mut value: Value = serde_json::from_str(&without_bare_words(text))?;
    let mut left_out = Vec::new();
    for part in ["results", "work"] {
        let Some(numbers) = value["outcome"][part].as_object_mut() else {
            continue;
        };
        numbers.retain(|name, number| {
            if number.is_null() {
                left_out.push(format!("{name} is NaN or infinite and is left out"));
            }
            !number.is_null()
        });
    }
    let mut busy = None;
    if let Some(fields) = value.as_object_mut() {
        for (_, number) in fields.iter_mut().filter(|(_, value)| value.is_null()) {
            *number = 0.into();
        }
        // Unreadable times are left out.
        busy = fields.remove("busy");
    }
    let mut farewell: Farewell = serde_json::from_value(value)?;
    let busy = busy.and_then(|busy| serde_json::from_value(busy).ok());
    farewell.busy = busy.unwrap_or_default();
    farewell.outcome.warnings.extend(left_out);
    Ok(farewell)
}

/// The text with `null` in place of `NaN` and `Infinity`.
fn without_bare_words(text: &str) -> String {
    let mut plain = String::with_capacity(text.len());
    let (mut rest, mut quoted) = (text, false);
    while let Some(next) = rest.chars().next() {
        let mut words = ["-Infinity", "Infinity", "NaN"].into_iter();
        let word = words.find(|word| !quoted && rest.starts_with(word));
        let taken = match (word, next) {
            (Some(word), _) => {
                plain.push_str("null");
                rest = &rest[word.len()..];
                continue;
            }
            // A backslash and the character that it escapes.
            (None, '\\') if quoted => 1 + rest[1..].chars().next().map_or(0, char::len_utf8),
            (None, '"') => {
                quoted = !quoted;
                1
            }
            _ => next.len_utf8(),
        };
        plain.push_str(&rest[..taken]);
        rest = &rest[taken..];
    }
    plain
}

#[cfg(test)]
mod tests {
    use protocol::busy::BusyTimes;

    use super::*;

    #[test]
    fn nan_and_infinity_are_left_out_alone() {
        let text = r#"{"outcome": {"steps": 3, "work": {"steps": 3.0, "odd": NaN},
            "results": {"a_m": 1.5, "b \"NaN\" \\": -Infinity, "c_pa": Infinity}, "state_hash": "NaN"},
            "cpu_s": NaN, "solve_wall_s": 1.0, "setup_wall_s": 0.0, "wait_s": 0.0, "peak_rss_bytes": 7,
            "busy": {"every": 1, "spans_ns": [[1, NaN]]}}"#;
        let farewell = parse(text).expect("it can be read");
        let outcome = &farewell.outcome;
        assert_eq!(outcome.results, [("a_m".to_string(), 1.5)].into());
        assert_eq!(outcome.work, [("steps".to_string(), 3.0)].into());
        assert_eq!(outcome.state_hash, "NaN");
        assert_eq!(outcome.warnings.len(), 3, "{:?}", outcome.warnings);
        assert_eq!((farewell.cpu_s, farewell.solve_wall_s), (0.0, 1.0));
        assert_eq!(farewell.busy, BusyTimes::default());
    }

    #[test]
    fn results_with_a_taken_or_wrong_name_are_left_out() {
        let text = r#"{"outcome": {"steps": 3, "work": {}, "state_hash": "",
            "results": {"a_m": 1.5, "energy_balance_rel": 1.0, "": 2.0, "b,c": 3.0, "d\ne": 4.0}},
            "cpu_s": 1.0, "solve_wall_s": 1.0, "setup_wall_s": 0.0, "wait_s": 0.0, "peak_rss_bytes": 7}"#;
        let mut farewell = parse(text).expect("it can be read");
        leave_out_wrong_names(&mut farewell);
        let outcome = &farewell.outcome;
        assert_eq!(outcome.results, [("a_m".to_string(), 1.5)].into());
        assert_eq!(outcome.warnings.len(), 4, "{:?}", outcome.warnings);
        let of_balance = outcome
            .warnings
            .iter()
            .filter(|w| w.contains("`energy_balance_rel`"));
        assert_eq!(of_balance.count(), 1);
    }

    #[test]
    fn texts_that_are_not_farewells_are_refused() {
        for text in [
            "",
            "NaN",
            "{}",
            r#"{"outcome": {"steps": NaN}}"#,
            r#"{"a": "\"#,
        ] {
            assert!(parse(text).is_err(), "{text}");
        }
    }
}
