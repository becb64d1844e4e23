//! `signals.csv`: one row for each window.

use std::fmt::Write as _;
use std::fs::File;
use std::io::{BufWriter, Seek, Write};

use protocol::Description;

use super::written::{Growing, Written};
use crate::run_dir::RunDir;
use scenario::error::{Error, Result};
use scheme::keys::Interface;
use scheme::window::InterfaceSignals;

kit::results! {
    /// # Signals
    /// - `t_s`: Time at the end of the window.
    /// - `repeats`: Number of repeats of the window.
    /// - `gap_rel`: Largest distance between the joined surfaces, over the mean spacing of the
    ///   nodes.
    /// - `interface_fx_n`: Force along x through the interface, acting on the continuum.
    /// - `interface_fy_n`: Force along y on the continuum, negative if it is pressed down.
}

/// Name of the file.
pub const SIGNALS: &str = "signals.csv";

/// The open file.
pub struct SignalsFile {
    file: BufWriter<File>,
    name: String,
    line: String,
    table: Growing,
}

impl SignalsFile {
    /// Starts the file with its header: time, the coupler's signals, then each participant's signals and ledger terms.
    /// A participant that runs alone has no prefix, and neither has the only interface.
    pub fn create(
        rundir: &RunDir,
        names: &[&str],
        descriptions: &[&Description],
        interfaces: &[Interface],
    ) -> Result<SignalsFile> {
        let path = rundir.path().join(SIGNALS);
        let name = path.display().to_string();
        let file = File::create(&path).map_err(Error::output(&name))?;
        let mut header = vec!["t_s".to_string()];
        for interface in interfaces {
            let prefix = interface.prefix_among(interfaces.len());
            let seen = ["repeats", "gap_rel", "interface_fx_n", "interface_fy_n"];
            header.extend(seen.map(|signal| format!("{prefix}{signal}")));
        }
        let coupled = !interfaces.is_empty();
        for (participant, description) in names.iter().zip(descriptions) {
            let dotted = format!("{participant}.");
            let prefix = if coupled { &dotted } else { "" };
            let signals = description.signals.iter();
            header.extend(signals.map(|signal| format!("{prefix}{signal}")));
            let terms = description.ledger.iter();
            header.extend(terms.map(|term| format!("{prefix}{}_j", term.name)));
        }
        let mut signals = SignalsFile {
            file: BufWriter::new(file),
            name,
            line: header.join(","),
            table: Growing::default(),
        };
        signals.end_line()?;
        Ok(signals)
    }

    /// Replaces the content by these rows of another run.
    pub fn carry_over(&mut self, rows: &[u8]) -> Result<()> {
        self.table = Growing::default();
        self.table.add(rows);
        let copied = self.file.flush().and_then(|()| {
            self.file.rewind()?;
            self.file.get_ref().set_len(0)?;
            self.file.write_all(rows)
        });
        copied.map_err(Error::output(&self.name))
    }

    /// Writes all rows to the disk; returns size, rows and hash for later checks.
    pub fn sync(&mut self) -> Result<Written> {
        let synced = self.file.flush();
        let synced = synced.and_then(|()| self.file.get_ref().sync_data());
        synced.map_err(Error::output(&self.name))?;
        Ok(self.table.written())
    }

    /// Adds a row: the coupler's signals of each interface, and the report of each participant.
    pub fn row(
        &mut self,
        time_s: f64,
        reports: &[Vec<f64>],
        interfaces: &[InterfaceSignals],
    ) -> Result<()> {
        let _ = write!(self.line, "{time_s:e}");
        for seen in interfaces {
            let [fx, fy] = seen.force_n;
            let (repeats, gap_rel) = (seen.repeats, seen.gap_rel);
            let _ = write!(self.line, ",{repeats},{gap_rel:e},{fx:e},{fy:e}");
        }
        for value in reports.iter().flatten() {
            let _ = write!(self.line, ",{value:e}");
        }
        self.end_line()
    }

    /// Writes the buffer to the file; returns size, rows and hash for later checks.
    pub fn finish(&mut self) -> Result<Written> {
        let flushed = self.file.flush().map_err(Error::output(&self.name));
        flushed.map(|()| self.table.written())
    }

    fn end_line(&mut self) -> Result<()> {
        self.line.push('\n');
        let written = self.file.write_all(self.line.as_bytes());
        self.table.add(self.line.as_bytes());
        self.line.clear();
        written.map_err(Error::output(&self.name))
    }
}
