//! `signals.csv`: one row a window.

use std::fmt::Write as _;
use std::fs::File;
use std::io::{BufWriter, Write};

use protocol::{Description, Window};

use crate::couple::ledger::total;
use crate::couple::scheme::{Coupling, Standing};
use crate::error::Error;
use crate::rundir::RunDir;

/// The open file.
pub struct SignalsFile {
    file: BufWriter<File>,
    name: String,
    line: String,
}

impl SignalsFile {
    /// Starts the file with its header: time, what the coupler sees, then each participant's signals and ledger
    /// terms. A participant that runs alone needs no prefix.
    pub fn create<'a>(
        rundir: &RunDir,
        names: impl Iterator<Item = &'a str>,
        descriptions: &[&Description],
        coupled: bool,
    ) -> Result<SignalsFile, Error> {
        let path = rundir.path().join("signals.csv");
        let name = path.display().to_string();
        let file = File::create(&path).map_err(Error::io(&name))?;
        let mut header = vec!["t_s".to_string()];
        if coupled {
            header.extend(
                ["repeats", "gap_rel", "interface_fx_n", "interface_fy_n"].map(String::from),
            );
        }
        for (participant, description) in names.zip(descriptions) {
            let prefix = if coupled {
                format!("{participant}.")
            } else {
                String::new()
            };
            header.extend(
                description
                    .signals
                    .iter()
                    .map(|signal| format!("{prefix}{signal}")),
            );
            header.extend(
                description
                    .ledger
                    .iter()
                    .map(|term| format!("{prefix}{}_j", term.name)),
            );
        }
        let mut signals = SignalsFile {
            file: BufWriter::new(file),
            name,
            line: header.join(","),
        };
        signals.end_line()?;
        Ok(signals)
    }

    /// Adds the row of a window.
    pub fn row(
        &mut self,
        window: &Window,
        reports: &[Vec<f64>],
        coupled: Option<(&Coupling, &Standing)>,
    ) -> Result<(), Error> {
        let _ = write!(self.line, "{:e}", window.t1_s);
        if let Some((coupling, standing)) = coupled {
            let [fx, fy] = total(&coupling.lambda);
            let _ = write!(
                self.line,
                ",{},{:e},{fx:e},{fy:e}",
                standing.repeats, standing.gap_rel
            );
        }
        for value in reports.iter().flatten() {
            let _ = write!(self.line, ",{value:e}");
        }
        self.end_line()
    }

    /// Writes out what is buffered.
    pub fn finish(&mut self) -> Result<(), Error> {
        self.file.flush().map_err(Error::io(&self.name))
    }

    fn end_line(&mut self) -> Result<(), Error> {
        self.line.push('\n');
        let written = self.file.write_all(self.line.as_bytes());
        self.line.clear();
        written.map_err(Error::io(&self.name))
    }
}
