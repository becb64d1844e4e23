//! Tables of numbers that a run left.

use std::collections::BTreeMap;
use std::path::Path;

/// Columns of numbers by their names.
pub type Columns = BTreeMap<String, Vec<f64>>;

/// Columns of numbers by name; an absent file has none, cells that are no numbers are left out.
pub fn read_csv(path: &Path) -> Columns {
    let text = std::fs::read_to_string(path).unwrap_or_default();
    let mut lines = text.lines();
    let names: Vec<&str> = lines.next().unwrap_or_default().split(',').collect();
    let mut columns = Columns::new();
    for line in lines {
        for (name, cell) in names.iter().zip(line.split(',')) {
            if let Ok(value) = cell.parse() {
                columns.entry(name.to_string()).or_default().push(value);
            }
        }
    }
    columns
}
