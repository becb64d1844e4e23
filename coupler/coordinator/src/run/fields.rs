//! The fields over time: the moments at which they are written, their files, and their part of `summary.json`.

use std::path::{Path, PathBuf};
use std::time::Instant;

use protocol::frame::packed;
use protocol::{Description, Kind};

use super::time_loop::GroupRun;
use crate::output::sample::load_history;
use crate::participants::Communicator;
use runs::collection::{self, Collection, FieldsSummary, SnapshotTime};
use runs::fields::ranges;
use runs::interface_fields;
use runs::run_dir::{RunDir, free_bytes};
use runs::warning::Warning;
use scenario::error::Result;
use scenario::keys::{RunKeys, Scenario};

kit::findings! {
    /// The fields will not fit on the disk at the requested interval.
    ///
    /// - Why: a small disk, many moments, a fine mesh, or many grains.
    /// - Do: make room, write fewer moments (a longer `run.output.fields_every_s`), or write no fields:
    ///   `run.output.fields = false`.
    FIELDS_SPACE = "fields_space";
}

/// Name of the last snapshot.
pub const AT_THE_END: &str = "end";

/// The fields of a run.
pub struct Fields<'a> {
    rundir: &'a RunDir,
    run: &'a RunKeys,
    /// All moments, in their order.
    pub snapshot_times: Vec<SnapshotTime>,
    parts: Vec<Part>,
    /// `fields.pvd`, which lists all parts.
    whole: Collection,
    summary: FieldsSummary,
    /// A warning that is not yet passed on.
    pub advice: Option<Warning>,
}

/// A part whose files belong together over time: a mesh, grains, their contacts, an interface.
struct Part {
    name: String,
    /// The start of its file names.
    stem: String,
    /// Possible ends of its file names.
    endings: &'static [&'static str],
    collection: Collection,
    /// The listed files, with their times (s).
    moments: Vec<(f64, PathBuf)>,
}

impl<'a> Fields<'a> {
    /// Fields before the first moment; `end_s` is the end of the run (s).
    pub fn new(
        rundir: &'a RunDir,
        scenario: &'a Scenario,
        descriptions: &[&Description],
        end_s: f64,
    ) -> Result<Fields<'a>> {
        let phases = load_history(descriptions.iter().copied());
        let output = &scenario.run.output;
        let every_s = output.fields_every_s.filter(|_| output.fields);
        let part = |stem: &str, more: &str, endings| Part {
            name: format!("{stem}{more}"),
            stem: stem.into(),
            endings,
            collection: Collection::new(rundir.fields().join(format!("{stem}{more}.pvd"))),
            moments: Vec::new(),
        };
        let participants = scenario.participant.iter().flat_map(|participant| {
            let name = &participant.name;
            let contacts = part(name, "-contacts", &["-contacts.vtp"]);
            let surface = part(name, "-surface", &["-surface.vtp"]);
            [part(name, "", &[".vtu", ".vtp"]), contacts, surface]
        });
        let interfaces = scenario.interface.iter();
        let interfaces = interfaces.map(|i| part(&i.name, "-interface", &["-interface.vtp"]));
        Ok(Fields {
            run: &scenario.run,
            snapshot_times: collection::snapshot_times(&phases, every_s, end_s)?,
            parts: participants.chain(interfaces).collect(),
            whole: Collection::new(rundir.path().join("fields.pvd")),
            summary: FieldsSummary::default(),
            advice: None,
            rundir,
        })
    }

    /// Lists the fields copied from another run, which wrote them at these times (s).
    pub fn carry_over(&mut self, times_s: &[f64]) -> Result<()> {
        let taken = self.snapshot_times.iter().zip(times_s);
        let taken: Vec<_> = taken.map(|(m, time_s)| (m.name.clone(), *time_s)).collect();
        let mut taken = taken.iter();
        taken.try_for_each(|(name, time_s)| self.list(name, *time_s))
    }

    /// Has fields written at each moment that has come, and appends the time (s) to `times_s`; returns the sampled
    /// moment if it is among them.
    pub fn take(
        &mut self,
        communicator: &mut dyn Communicator,
        groups: &[GroupRun],
        times_s: &mut Vec<f64>,
        time_s: f64,
    ) -> Result<Option<SnapshotTime>> {
        let come = |snapshot: &&SnapshotTime| time_s >= snapshot.time_s * (1.0 - 1e-9);
        let mut sampled = None;
        while let Some(snapshot) = self.snapshot_times.get(times_s.len()).filter(come).cloned() {
            times_s.push(time_s);
            self.write(communicator, groups, &snapshot.name, time_s)?;
            sampled = sampled.or(Some(snapshot).filter(|snapshot| snapshot.sampled));
        }
        Ok(sampled)
    }

    /// Has the fields of a moment written, at this time (s). Participants get the request even without fields, as some
    /// results belong to the state at a snapshot.
    pub fn write(
        &mut self,
        communicator: &mut dyn Communicator,
        groups: &[GroupRun],
        name: &str,
        time_s: f64,
    ) -> Result<()> {
        let start = Instant::now();
        let kinds = (Kind::Snapshot, Kind::Saved);
        communicator.ask_all(kinds, &packed(name), |_| Ok(()))?;
        if self.run.output.fields {
            self.write_interfaces(groups, name)?;
            self.list(name, time_s)?;
            self.look_ahead();
        }
        self.summary.wall_s += start.elapsed().as_secs_f64();
        Ok(())
    }

    fn write_interfaces(&self, groups: &[GroupRun], name: &str) -> Result<()> {
        let folder = self.rundir.fields();
        for coupling in groups.iter().map(|group| &group.coupling) {
            for patch in &coupling.group().patches {
                let path = folder.join(format!("{}-{name}-interface.vtp", patch.name));
                interface_fields::write(&path, coupling, patch, self.run.thickness_m)?;
            }
        }
        Ok(())
    }

    /// Lists the files of a moment, unless files of the same time are listed.
    fn list(&mut self, name: &str, time_s: f64) -> Result<()> {
        let before = self.summary.times_s.last();
        if before.is_some_and(|before| time_s <= before * (1.0 + 1e-9)) {
            return Ok(());
        }
        let folder = self.rundir.fields();
        let mut sets = String::new();
        for (index, part) in self.parts.iter_mut().enumerate() {
            let Some((file, bytes)) = part.file(&folder, name) else {
                continue;
            };
            let set = |index, file: &str| collection::data_set(time_s, (index, &part.name), file);
            sets += &set(index, &format!("fields/{file}"));
            part.collection.add(&set(0, &file))?;
            part.moments.push((time_s, folder.join(file)));
            self.summary.files += 1;
            self.summary.bytes += bytes;
        }
        if !sets.is_empty() {
            self.whole.add(&sets)?;
            self.summary.times_s.push(time_s);
        }
        Ok(())
    }

    /// Size of the fields of the whole run, if each moment is as large as the end, with a warning if the disk of
    /// `folder` has less space left.
    pub fn foretold(&self, folder: &Path) -> Option<String> {
        let parts = self.parts.iter();
        let files = parts.filter_map(|part| part.file(&self.rundir.fields(), AT_THE_END));
        let (files, bytes) =
            files.fold((0, 0), |(files, sum), (_, bytes)| (files + 1, sum + bytes));
        let snapshot_times = self.snapshot_times.len() as u64 + 1;
        let line = format!(
            "fields: about {:.3e} bytes, {snapshot_times} moments of {files} files",
            (snapshot_times * bytes) as f64
        );
        let warning =
            lack(snapshot_times * bytes, free_bytes(folder)).map(|w| format!("\n{}", w.line()));
        (files > 0).then(|| line + &warning.unwrap_or_default())
    }

    /// After the first moment, makes a warning if the others will not fit on the disk.
    fn look_ahead(&mut self) {
        if self.summary.times_s.len() == 1 {
            let left = self.snapshot_times.len() as u64 * self.summary.bytes;
            self.advice = lack(left, free_bytes(self.rundir.path()));
        }
    }

    /// The summary of the fields so far; `None` if they are switched off.
    pub fn summary(&self) -> Result<Option<FieldsSummary>> {
        if !self.run.output.fields {
            return Ok(None);
        }
        let mut summary = self.summary.clone();
        for part in &self.parts {
            if let Some((_, path)) = part.moments.last() {
                summary.last.insert(part.name.clone(), ranges(path)?);
            }
        }
        Ok(Some(summary))
    }

    /// After the run, gathers the files of each part in one VTKHDF file, if the scenario asks for it.
    ///
    /// # Errors
    /// A file cannot be read, written or gathered; the participants' files stay.
    #[cfg(feature = "vtkhdf")]
    pub fn gather(&self, summary: &mut Option<FieldsSummary>) -> Result<()> {
        let asked = self.run.output.fields_format == scenario::keys::FieldsFormat::Vtkhdf;
        let Some(summary) = summary.as_mut().filter(|_| asked) else {
            return Ok(());
        };
        let (start, folder) = (Instant::now(), self.rundir.fields());
        let parts = self.parts.iter().filter(|part| !part.moments.is_empty());
        let mut gone = vec![self.rundir.path().join("fields.pvd")];
        (summary.files, summary.bytes) = (0, 0);
        for part in parts {
            let path = folder.join(format!("{}.vtkhdf", part.name));
            runs::vtkhdf::write(&path, &part.moments)?;
            summary.files += 1;
            summary.bytes += path.metadata().map_or(0, |file| file.len());
            let names = self.snapshot_times.iter().map(|moment| &*moment.name);
            let names = names.chain([AT_THE_END]);
            let files = names.filter_map(|name| part.file(&folder, name));
            gone.extend(files.map(|(file, _)| folder.join(file)));
            gone.push(path.with_extension("pvd"));
        }
        for path in gone {
            std::fs::remove_file(&path).map_err(scenario::error::Error::output(path.display()))?;
        }
        summary.wall_s += start.elapsed().as_secs_f64();
        Ok(())
    }
}

impl Part {
    /// Name and size (bytes) of its file of a moment, if it exists.
    fn file(&self, folder: &Path, snapshot: &str) -> Option<(String, u64)> {
        self.endings.iter().find_map(|ending| {
            let file = format!("{}-{snapshot}{ending}", self.stem);
            let bytes = std::fs::metadata(folder.join(&file)).ok()?.len();
            Some((file, bytes))
        })
    }
}

/// A warning about fields of this size (bytes), if the disk has less space left.
fn lack(bytes: u64, free: Option<u64>) -> Option<Warning> {
    let free = free.filter(|free| *free < bytes)?;
    let text = format!(
        "the fields take about {:.3e} bytes, but the disk has {:.3e} left: make run.output.fields_every_s longer, choose another --out, or set run.output.fields = false",
        bytes as f64, free as f64
    );
    Some(Warning::advice(&FIELDS_SPACE, "run.output.fields", text))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_that_just_fit_give_no_warning() {
        assert_eq!(lack(1000, Some(1000)), None);
        assert_eq!(lack(1000, None), None, "the free space is unknown");
        let warning = lack(1000, Some(999)).expect("a byte is missing");
        assert!(warning.text.contains("fields_every_s"), "{}", warning.text);
    }
}
