//! Export of a log as CSV tables.
//!
//! In long form, one file has one number per row: `window,iteration,step,substeps,t0_s,t1_s,sender,receiver,kind,entry,value`. In wide
//! form, a folder has one file per stream with one message per row: `window,iteration,step,substeps,t0_s,t1_s` and then the numbers.
//! Numbers have the fewest digits that restore every bit. A text (`Couple`, the name of a set) takes the place of the numbers.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use protocol::Kind;

use super::entry::{Entry, Exchange, kind_name};
use super::read::recover;
use crate::error::{ExportError, LogError};

/// The messages to export.
#[derive(Clone, Debug, Default)]
pub struct Selection {
    /// Only what this participant sends or receives.
    pub node: Option<String>,
    /// Only messages of this kind.
    pub kind: Option<Kind>,
    /// Only one window in this many, from the first on; at least 1.
    pub every: Option<u64>,
}

impl Selection {
    fn takes(&self, message: &Exchange) -> bool {
        let header = &message.frame.header;
        let of_node = |name: &String| *name == message.sender || *name == message.receiver;
        self.node.as_ref().is_none_or(of_node)
            && self.kind.is_none_or(|kind| header.kind == kind as u32)
            && header.window.is_multiple_of(self.every.unwrap_or(1))
    }
}

/// Characters per number including the other cells of its row, measured on a coupled layer, in long and in wide form.
const LONG_BYTES: u64 = 82;
const WIDE_BYTES: u64 = 21;

/// Approximate size of the tables of the chosen messages (bytes), in long or in wide form.
pub fn bytes(log: &Path, selection: &Selection, long: bool) -> Result<u64, ExportError> {
    let mut numbers = 0;
    each(log, selection, |message| {
        numbers += message.frame.payload.len() as u64;
        Ok(())
    })?;
    Ok(numbers * if long { LONG_BYTES } else { WIDE_BYTES })
}

/// Exported files and messages.
#[derive(Debug, Default)]
pub struct Exported {
    /// Written files.
    pub files: Vec<PathBuf>,
    /// Number of messages.
    pub messages: u64,
    /// Damage at which the log ended early.
    pub damage: Option<LogError>,
}

const TIMES: &str = "window,iteration,step,substeps,t0_s,t1_s";

/// Writes the chosen messages of a log to one long file.
pub fn long(log: &Path, selection: &Selection, out: &Path) -> Result<Exported, ExportError> {
    let mut file = Table::create(out, &format!("{TIMES},sender,receiver,kind,entry,value"))?;
    let exported = each(log, selection, |message| {
        let kind = kind_name(message.frame.header.kind);
        let (times, sender, receiver) = (times(message), &message.sender, &message.receiver);
        let lead = format!("{times},{sender},{receiver},{kind}");
        cells(message).try_for_each(|(entry, cell)| file.line(&format!("{lead},{entry},{cell}")))
    })?;
    Ok(Exported {
        files: vec![file.close()?],
        ..exported
    })
}

/// Writes the chosen messages of a log to a folder, one wide file per stream.
pub fn wide(log: &Path, selection: &Selection, folder: &Path) -> Result<Exported, ExportError> {
    let mut widths: BTreeMap<String, usize> = BTreeMap::new();
    each(log, selection, |message| {
        let width = widths.entry(file_name(message)).or_default();
        *width = (*width).max(cells(message).count());
        Ok(())
    })?;
    std::fs::create_dir_all(folder).map_err(ExportError::write(folder))?;
    let mut tables = BTreeMap::new();
    for (name, width) in widths {
        let header = (0..width).fold(TIMES.to_string(), |line, entry| format!("{line},{entry}"));
        let table = Table::create(&folder.join(&name), &header)?;
        tables.insert(name, table);
    }
    let exported = each(log, selection, |message| {
        let line = cells(message).fold(times(message), |line, (_, cell)| line + "," + &cell);
        let table = tables.get_mut(&file_name(message));
        table.expect("the log was read once before").line(&line)
    })?;
    let files: Result<_, _> = tables.into_values().map(Table::close).collect();
    Ok(Exported {
        files: files?,
        ..exported
    })
}

/// Visits the chosen messages of the readable part of a log.
fn each(
    log: &Path,
    selection: &Selection,
    mut visit: impl FnMut(&Exchange) -> Result<(), ExportError>,
) -> Result<Exported, ExportError> {
    let mut log = recover(log)?;
    let mut exported = Exported::default();
    for entry in &mut log {
        let Entry::Exchange(message) = entry? else {
            continue;
        };
        if selection.takes(&message) {
            exported.messages += 1;
            visit(&message)?;
        }
    }
    exported.damage = log.damage;
    Ok(exported)
}

fn times(message: &Exchange) -> String {
    let header = &message.frame.header;
    format!(
        "{},{},{},{},{:e},{:e}",
        header.window, header.iteration, header.step, header.substeps, header.t0_s, header.t1_s
    )
}

/// The numbers of a message, or its text.
fn cells(message: &Exchange) -> impl Iterator<Item = (usize, String)> + '_ {
    let frame = &message.frame;
    let is_text = matches!(frame.kind(), Ok(Kind::Couple));
    let text = is_text.then(|| frame.text().ok()).flatten();
    let numbers: &[f64] = match text {
        Some(_) => &[],
        None => &frame.payload,
    };
    let numbers = numbers.iter().map(|value| format!("{value:e}"));
    text.into_iter().chain(numbers).enumerate()
}

fn file_name(message: &Exchange) -> String {
    let kind = kind_name(message.frame.header.kind);
    let (interface, sender, receiver) = (&message.interface, &message.sender, &message.receiver);
    format!("{interface}.{sender}.{receiver}.{kind}.csv")
}

/// A file that is filled line by line.
struct Table {
    path: PathBuf,
    file: BufWriter<File>,
}

impl Table {
    fn create(path: &Path, header: &str) -> Result<Table, ExportError> {
        let file = File::create(path).map_err(ExportError::write(path))?;
        let (path, file) = (path.into(), BufWriter::new(file));
        let mut table = Table { path, file };
        table.line(header)?;
        Ok(table)
    }

    fn line(&mut self, line: &str) -> Result<(), ExportError> {
        writeln!(self.file, "{line}").map_err(ExportError::write(&self.path))
    }

    fn close(mut self) -> Result<PathBuf, ExportError> {
        let flushed = self.file.flush();
        flushed.map_err(ExportError::write(&self.path))?;
        Ok(self.path)
    }
}
