//! A study of a few milliseconds, and its results.csv as rows by their columns.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use harness::runs::{Scratch, thirdbody};

/// A folder of shipped scenes or studies.
pub fn shipped(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../scenarios")
        .join(name)
}

/// A study file on `quick-bonded`, cut short to 60 us, with these tables behind its head.
pub fn study(work: &Scratch, tables: &str) -> PathBuf {
    let scenario = shipped("quick-bonded");
    let head = format!(
        "[study]\nname = \"short\"\nscenario = \"{}\"\nset = [\"run.end_s=6e-5\"]\nmode = \"one-at-a-time\"\n",
        scenario.display()
    );
    let path = work.path().join("short.toml");
    fs::write(&path, format!("{head}{tables}\n")).expect("it is writable");
    path
}

/// The substeps against a reference with 1 substep.
pub const SUBSTEPS: &str = "[reference]\nset = [\"interface.layer-base.substeps=1\"]\nperturb = 2\n\
    [[vary]]\nkey = \"interface.layer-base.substeps\"\nvalues = [9, 3, 1]\n\
    [[measure]]\nname = \"height\"\nof = \"signals.wheel_y_m\"\nnorm = \"l2\"\n";

/// Values for two frictions, without a reference.
pub const VALUES: &str = "[[vary]]\nkey = \"participant.third-body.config.law.friction\"\nvalues = [0.1, 0.3]\n\
    [[measure]]\nname = \"height\"\nof = \"signals.wheel_y_m\"\nnorm = \"max\"\n\
    [[measure]]\nname = \"grains\"\nof = \"results.disks\"\n";

/// `thirdbody study VERB FILE --out <work>/out` with more arguments.
pub fn command(work: &Scratch, verb: &str, file: &Path, more: &[&str]) -> Command {
    let mut command = thirdbody(work.path());
    command
        .args(["study", verb])
        .arg(file)
        .arg("--out")
        .arg(work.path().join("out"))
        .args(more);
    command
}

/// Its standard output; it must have this exit code.
pub fn printed(command: &mut Command, code: i32) -> String {
    let output = command.output().expect("the program starts");
    assert_eq!(output.status.code(), Some(code), "{}", words(&output));
    String::from_utf8_lossy(&output.stdout).into_owned()
}

/// All output of a command.
pub fn words(output: &Output) -> String {
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    text(&output.stdout) + &text(&output.stderr)
}

/// A row by its columns.
pub type Row = BTreeMap<String, String>;

/// The rows of results.csv.
pub fn rows(work: &Scratch) -> Vec<Row> {
    let text = fs::read_to_string(work.path().join("out/results.csv")).expect("it was written");
    let mut lines = text.lines().map(cells);
    let head = lines.next().expect("a head");
    let row = |cells: Vec<String>| {
        assert_eq!(cells.len(), head.len(), "{cells:?}");
        head.iter().cloned().zip(cells).collect()
    };
    lines.map(row).collect()
}

/// The cells of a line, in which commas may stand within quotes.
fn cells(line: &str) -> Vec<String> {
    let mut cells = vec![String::new()];
    let mut within = false;
    for c in line.chars() {
        match c {
            '"' => within = !within,
            ',' if !within => cells.push(String::new()),
            c => cells.last_mut().expect("one is there").push(c),
        }
    }
    cells
}

/// A number of a row.
pub fn number(row: &Row, column: &str) -> f64 {
    row[column]
        .parse()
        .unwrap_or_else(|_| panic!("{column} is `{}`", row[column]))
}

/// Columns that do not repeat: times, memory, and the number of attempts.
const TIMES: [&str; 6] = [
    "attempts",
    "wall_s",
    "cpu_s",
    "peak_rss_bytes",
    "wall_rel",
    "cpu_rel",
];

/// Rows without the columns that do not repeat.
pub fn lasting(rows: &[Row]) -> Vec<Row> {
    let kept = |row: &Row| {
        let columns = row
            .iter()
            .filter(|(column, _)| !TIMES.contains(&column.as_str()));
        columns
            .map(|(column, cell)| (column.clone(), cell.clone()))
            .collect()
    };
    rows.iter().map(kept).collect()
}
