//! The keys of `sample` with kind = "file", and the table of grains that they name.

use std::io;
use std::path::PathBuf;

use kit::ConfigError;
use kit::input_file::content;
use kit::limits::positive;
use protocol::Cause;
use schemars::JsonSchema;
use serde::Deserialize;

use super::disks::{DiskConfig, DisksConfig};

/// The key that names the table.
const KEY: &str = "sample.path";
/// The columns, in any order.
const COLUMNS: [&str; 4] = ["x_m", "y_m", "radius_m", "glued"];
/// A table with more grains is taken for another kind of file.
const GRAINS_MAX: usize = 500_000;
/// Longest table (bytes): room for this many grains, each of three numbers with all their digits.
const LONGEST_FILE: u64 = 64 << 20;

/// A table of disks in a file of comma-separated values.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FileConfig {
    /// Path of the file, absolute or from the folder of the scenario. Its columns are x_m, y_m, radius_m (m) and glued (0 or 1), in any order.
    pub path: PathBuf,
}

impl FileConfig {
    /// The disks of the file, as if they were listed.
    pub(super) fn read(&self) -> Result<DisksConfig, ConfigError> {
        let bytes = content(&self.path, LONGEST_FILE);
        let text = bytes.and_then(|bytes| String::from_utf8(bytes).map_err(io::Error::other));
        let text = text.map_err(|error| {
            let problem = format!("{} cannot be read: {error}", self.path.display());
            ConfigError::new(KEY, problem)
                .because(Cause::FileUnreadable)
                .help("give the path of a .csv file, from the folder of the scenario or from the root")
        })?;
        let disks = parse(&text).map_err(|error| {
            let problem = format!("{}, {}", self.path.display(), error.problem);
            ConfigError { problem, ..error }.because(Cause::FileUnsuitable)
        })?;
        Ok(DisksConfig {
            disks,
            ..DisksConfig::default()
        })
    }
}

/// The disks of a table: a line with the names of its columns, then a line a disk. Empty lines are skipped.
fn parse(text: &str) -> Result<Vec<DiskConfig>, ConfigError> {
    // Some editors write a byte-order mark.
    let lines = text.trim_start_matches('\u{feff}').lines().enumerate();
    let mut lines = lines.filter(|(_, line)| !line.trim().is_empty());
    let header = lines.next().map_or("", |(_, line)| line);
    let columns = columns(header)?;
    let mut disks = Vec::new();
    for (number, line) in lines {
        if disks.len() == GRAINS_MAX {
            let problem = format!("line {}: more than {GRAINS_MAX} grains", number + 1);
            return Err(ConfigError::new(KEY, problem));
        }
        let disk = disk(line, &columns).map_err(|error| {
            let problem = format!("line {}: {} {}", number + 1, error.key, error.problem);
            ConfigError::new(KEY, problem)
        })?;
        disks.push(disk);
    }
    if disks.iter().all(|disk| disk.glued) {
        let problem = "there is no disk that is not glued";
        return Err(ConfigError::new(KEY, problem).help("write 0 in the column glued of one"));
    }
    Ok(disks)
}

/// Index of each of [`COLUMNS`] in a line.
fn columns(header: &str) -> Result<[usize; 4], ConfigError> {
    let names: Vec<&str> = header.split(',').map(str::trim).collect();
    let fault = |problem: String| {
        ConfigError::new(KEY, format!("line 1: {problem}"))
            .help(format!("columns: {}", COLUMNS.join(", ")))
    };
    for (index, name) in names.iter().enumerate() {
        if !COLUMNS.contains(name) {
            return Err(fault(format!("{name:?} is no column of such a table")));
        }
        if names[..index].contains(name) {
            return Err(fault(format!("the column {name} is there twice")));
        }
    }
    let mut indices = [0; 4];
    for (index, column) in indices.iter_mut().zip(COLUMNS) {
        let found = names.iter().position(|name| *name == column);
        *index = found.ok_or_else(|| fault(format!("the column {column} is missing")))?;
    }
    Ok(indices)
}

/// The disk of a line; errors name the column.
fn disk(line: &str, columns: &[usize; 4]) -> Result<DiskConfig, ConfigError> {
    let values: Vec<&str> = line.split(',').map(str::trim).collect();
    if values.len() != columns.len() {
        let problem = format!("has {} values, the header {}", values.len(), columns.len());
        return Err(ConfigError::new("it", problem));
    }
    let number = |column: usize| {
        let text = values[columns[column]];
        let number = text.parse::<f64>().ok().filter(|x| x.is_finite());
        let problem = format!("must be a finite number, got {text:?}");
        number.ok_or_else(|| ConfigError::new(COLUMNS[column], problem))
    };
    let [x_m, y_m, radius_m] = [number(0)?, number(1)?, number(2)?];
    positive(COLUMNS[2], radius_m, "m")?;
    let glued = match values[columns[3]] {
        "1" | "true" => true,
        "0" | "false" => false,
        other => {
            let problem = format!("must be 0, 1, true or false, got {other:?}");
            return Err(ConfigError::new(COLUMNS[3], problem));
        }
    };
    Ok(DiskConfig {
        x_m,
        y_m,
        radius_m,
        glued,
        ..DiskConfig::default()
    })
}
