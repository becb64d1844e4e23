//! Numbers of signals.csv.

use protocol::larger;
use runs::table::Table;

/// `<column>.<last | max | min | mean | t_max | t_min>`, where `t_` is the time of the extreme (s). The column's name may contain dots, and
/// columns joined by `+` are summed.
pub(super) fn of_signals(signals: &Table, path: &str) -> Option<f64> {
    let (columns, what) = path.rsplit_once('.')?;
    let columns = columns.split('+').map(|column| signals.get(column));
    let columns = columns.collect::<Option<Vec<&[f64]>>>()?;
    let reports = columns.iter().map(|column| column.len()).min()?;
    let sum = |row| columns.iter().map(|column| column[row]).sum();
    let values = &(0..reports).map(sum).collect::<Vec<f64>>();
    match what {
        "last" => values.last().copied(),
        "max" => values.iter().copied().reduce(larger),
        "min" => values.iter().copied().reduce(|a, b| -larger(-a, -b)),
        "t_max" => time_of(signals, values, 1.0),
        "t_min" => time_of(signals, values, -1.0),
        "mean" => Some(values.iter().sum::<f64>() / values.len() as f64),
        _ => None,
    }
}

/// Time of the first largest value (s), or of the smallest if the sign is -1.
fn time_of(signals: &Table, values: &[f64], sign: f64) -> Option<f64> {
    let extreme = values.iter().map(|value| sign * value).reduce(larger)?;
    let at = values.iter().position(|value| sign * value == extreme)?;
    signals.get("t_s")?.get(at).copied()
}
