//! The signals of a run for its frames: wheel and forces at their times, and over time for the strip below the picture.

use serde_json::{Value, json};

use runs::files::RunFiles;

/// Number of intervals of the strip; each shows its smallest and its largest value.
const PIECES: usize = 400;

/// Signals of the wheel that are shown: words, name, unit, and factor from SI to the unit.
const OF_WHEEL: [(&str, &str, &str, f64); 4] = [
    ("F_T, friction force on the wheel", "wheel_ft_n", "N", 1.0),
    ("F_N, normal force on the wheel", "wheel_fn_n", "N", 1.0),
    ("x of the wheel", "wheel_x_m", "mm", 1e3),
    ("y of the wheel", "wheel_y_m", "mm", 1e3),
];

/// A signal over time.
#[derive(Clone, Debug)]
struct Signal {
    label: String,
    unit: &'static str,
    values: Vec<f64>,
}

/// Signals over time.
#[derive(Clone, Debug, Default)]
pub struct Track {
    times_s: Vec<f64>,
    signals: Vec<Signal>,
    /// Positions wheel_x_m and wheel_y_m (m), if there is a wheel.
    wheel: Option<[Vec<f64>; 2]>,
}

impl Track {
    /// The signals of the wheel that a participant carries; without a wheel, the forces of the interfaces.
    pub fn of(run: &RunFiles, wheel_of: Option<&String>) -> Track {
        let columns = &run.signals;
        let column = |name: &str| {
            let own = columns.get(&format!("{}.{name}", wheel_of?));
            own.or(columns.get(name))
        };
        let of_wheel = OF_WHEEL.iter().filter_map(|(label, name, unit, factor)| {
            Some(Signal {
                label: label.to_string(),
                unit,
                values: column(name)?.iter().map(|value| factor * value).collect(),
            })
        });
        let mut signals: Vec<Signal> = of_wheel.collect();
        if signals.is_empty() {
            let ends = ["interface_fx_n", "interface_fy_n"];
            let forces = columns.chosen(|name| ends.iter().any(|end| name.ends_with(end)));
            signals.extend(forces.into_iter().map(|(name, values)| {
                let name = name.trim_end_matches("_n");
                Signal {
                    label: name.replace("interface_f", "interface force "),
                    unit: "N",
                    values: values.to_vec(),
                }
            }));
        }
        let [x, y] = ["wheel_x_m", "wheel_y_m"].map(column);
        Track {
            times_s: columns.get("t_s").unwrap_or_default().to_vec(),
            signals,
            wheel: x.zip(y).map(|(x, y)| [x.to_vec(), y.to_vec()]),
        }
    }

    /// The row nearest to a time (s).
    fn row(&self, time_s: f64) -> Option<usize> {
        let next = self.times_s.partition_point(|t| *t < time_s);
        let near = [next.checked_sub(1), Some(next)].into_iter().flatten();
        let rows = near.filter(|row| *row < self.times_s.len());
        let far = |row: &usize| (self.times_s[*row] - time_s).abs();
        rows.min_by(|a, b| far(a).total_cmp(&far(b)))
    }

    /// The numbers for a frame at a time (s), from the nearest row, with the time of that row.
    pub fn at(&self, time_s: f64) -> Value {
        let Some(row) = self.row(time_s) else {
            return Value::Null;
        };
        let value = |signal: &Signal| json!(signal.values.get(row));
        let wheel = self.wheel.as_ref();
        let wheel = wheel.and_then(|[x, y]| Some([1e3 * x.get(row)?, 1e3 * y.get(row)?]));
        json!({
            "t_ms": 1e3 * self.times_s[row],
            "values": self.signals.iter().map(value).collect::<Vec<Value>>(),
            "wheel": wheel,
        })
    }

    /// The signals for the strip.
    pub fn strip(&self) -> Value {
        let json = |signal: &Signal| {
            let point = |row| Some([1e3 * self.times_s.get(row)?, *signal.values.get(row)?]);
            let points = extremes(&signal.values).into_iter().filter_map(point);
            json!({
                "label": signal.label,
                "unit": signal.unit,
                "points": points.collect::<Vec<[f64; 2]>>(),
            })
        };
        self.signals.iter().map(json).collect()
    }
}

/// Rows with the smallest and the largest value of each interval, in order.
fn extremes(values: &[f64]) -> Vec<usize> {
    let length = values.len().div_ceil(PIECES).max(1);
    let mut rows = Vec::new();
    for (piece, part) in values.chunks(length).enumerate() {
        let by = |sign: f64| {
            let numbers = part.iter();
            let numbers = numbers.enumerate().filter(|(_, value)| value.is_finite());
            let found = numbers.max_by(|a, b| (sign * a.1).total_cmp(&(sign * b.1)));
            found.map(|(row, _)| piece * length + row)
        };
        let mut two: Vec<usize> = [by(-1.0), by(1.0)].into_iter().flatten().collect();
        two.sort_unstable();
        two.dedup();
        rows.extend(two);
    }
    rows
}

#[cfg(test)]
mod tests {
    use super::*;
    use runs::table::Table;

    fn track(csv: &str, wheel_of: Option<&str>) -> Track {
        let run = RunFiles {
            signals: Table::parse(csv).expect("a table"),
            ..RunFiles::default()
        };
        Track::of(&run, wheel_of.map(String::from).as_ref())
    }

    #[test]
    fn a_frame_has_the_numbers_of_the_nearest_row() {
        let csv = "t_s,a.wheel_x_m,a.wheel_y_m,a.wheel_fn_n\n0,0,1e-3,1\n1e-3,2e-3,3e-3,5\n";
        let track = track(csv, Some("a"));
        let near = track.at(0.8e-3);
        assert_eq!(near["t_ms"], 1.0);
        assert_eq!(near["values"], json!([5.0, 2.0, 3.0]));
        assert_eq!(near["wheel"], json!([2.0, 3.0]));
        assert_eq!(track.at(-1.0)["t_ms"], 0.0);
    }

    #[test]
    fn a_run_without_a_wheel_shows_its_interfaces() {
        let csv = "t_s,below.interface_fx_n,a.wheel_x_m\n0,7,0\n";
        let strip = track(csv, None).strip();
        assert_eq!(strip[0]["label"], "below.interface force x");
        assert_eq!(strip[0]["points"], json!([[0.0, 7.0]]));
        assert_eq!(strip.as_array().map(Vec::len), Some(1));
    }

    #[test]
    fn a_peak_of_one_row_stays_in_the_strip() {
        let mut values = vec![0.0; 10_000];
        values[4_321] = 9.0;
        values[4_322] = f64::NAN;
        let rows = extremes(&values);
        assert!(rows.contains(&4_321) && rows.len() <= 2 * PIECES);
    }
}
