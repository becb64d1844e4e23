//! Tables of numbers that a run left.

use std::collections::BTreeMap;
use std::path::Path;

/// Columns of numbers by their names.
pub type Columns = BTreeMap<String, Vec<f64>>;

/// Columns of numbers by name; an absent file has none, cells that are no numbers are left out.
pub fn read_csv(path: &Path) -> Columns {
    let text = std::fs::read_to_string(path).unwrap_or_default();
    let mut lines = text.lines();
    let names = lines.next().unwrap_or_default().split(',');
    let mut columns: Vec<(&str, Vec<f64>)> = names.map(|name| (name, Vec::new())).collect();
    for line in lines {
        for ((_, values), cell) in columns.iter_mut().zip(line.split(',')) {
            values.extend(cell.parse::<f64>().ok());
        }
    }
    let some = columns.into_iter().filter(|(_, values)| !values.is_empty());
    some.map(|(name, values)| (name.to_string(), values))
        .collect()
}
