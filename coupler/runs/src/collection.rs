//! The moments at which participants write their fields, and `.pvd` files, which list snapshots over time for ParaView.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io;
use std::os::unix::fs::FileExt;
use std::path::PathBuf;

use protocol::Phase;
use serde::Serialize;

use crate::fields::ArrayRanges;
use scenario::error::{Error, Refusal, Result};
use scheme::error::Unfit;

/// Most snapshots within a phase: more files in a folder are not useful.
const MOST: f64 = 10_000.0;

/// A moment at which the participants write their fields.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SnapshotTime {
    /// Name of the snapshot.
    pub name: String,
    /// Simulated time (s).
    pub time_s: f64,
    /// The end of the phase in which results are sampled.
    pub sampled: bool,
}

/// The ends of all phases and, with `run.output.fields_every_s`, moments at this interval within each phase, counted
/// from its start: the k-th within `cycling` is called `cycling-k`. Moments between the last phase (or the start,
/// without phases) and the end of the run (s) are called `run-k`. The end itself is always written.
///
/// # Errors
/// More than 10 000 moments in a phase.
pub fn snapshot_times(
    phases: &[Phase],
    every_s: Option<f64>,
    end_s: f64,
) -> Result<Vec<SnapshotTime>, Refusal> {
    let mut snapshot_times = Vec::new();
    for phase in phases {
        let span = [phase.t0_s, phase.t1_s];
        snapshot_times.extend(within(&phase.name, span, every_s)?);
        snapshot_times.push(SnapshotTime {
            name: phase.name.clone(),
            time_s: phase.t1_s,
            sampled: phase.sampled,
        });
    }
    let rest = [phases.last().map_or(0.0, |phase| phase.t1_s), end_s];
    snapshot_times.extend(within("run", rest, every_s)?);
    Ok(snapshot_times)
}

/// Moments within a span of time (s), without its ends.
fn within(
    name: &str,
    [start, end]: [f64; 2],
    every_s: Option<f64>,
) -> Result<impl Iterator<Item = SnapshotTime>, Refusal> {
    let every = every_s.unwrap_or(f64::INFINITY);
    let parts = (end - start) * (1.0 - 1e-9) / every;
    if parts > MOST {
        let problem = format!(
            "= {every:e} gives {parts:.0} snapshots of `{name}`: at most {MOST} are allowed"
        );
        return Err(Unfit::key("run.output.fields_every_s", problem).into());
    }
    Ok((1..=parts as u64).map(move |k| SnapshotTime {
        name: format!("{name}-{k}"),
        time_s: start + k as f64 * every,
        sampled: false,
    }))
}

/// A `.pvd` file that grows set by set. It is complete after each set: earlier sets stay, and the end of the file
/// moves.
#[derive(Debug)]
pub struct Collection {
    path: PathBuf,
    /// Length of the file without its end; `None` before the first set.
    sets_end: Option<u64>,
}

const BEGIN: &str = "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\" byte_order=\"LittleEndian\">\n<Collection>\n";
const END: &str = "</Collection>\n</VTKFile>\n";

impl Collection {
    /// A file that begins with its first set.
    pub fn new(path: PathBuf) -> Collection {
        let sets_end = None;
        Collection { path, sets_end }
    }

    /// Adds sets made by [`data_set`].
    pub fn add(&mut self, sets: &str) -> Result<()> {
        let written = self.write(sets).map_err(Error::output(self.path.display()));
        self.sets_end = Some(written?);
        Ok(())
    }

    fn write(&self, sets: &str) -> io::Result<u64> {
        let Some(start) = self.sets_end else {
            fs::write(&self.path, format!("{BEGIN}{sets}{END}"))?;
            return Ok((BEGIN.len() + sets.len()) as u64);
        };
        let file = File::options().write(true).open(&self.path)?;
        let written = file.write_all_at(format!("{sets}{END}").as_bytes(), start);
        if written.is_err() {
            // On a full disk the file keeps its old end.
            file.set_len(start + END.len() as u64)?;
            file.write_all_at(END.as_bytes(), start)?;
        }
        written.map(|()| start + sets.len() as u64)
    }
}

/// `fields` of `summary.json`.
#[derive(Clone, Debug, Default, Serialize)]
pub struct FieldsSummary {
    /// Simulated times of the steps of `fields.pvd` (s).
    pub times_s: Vec<f64>,
    /// Number of files listed in `fields.pvd`.
    pub files: u64,
    /// Size of these files.
    pub bytes: u64,
    /// Wall-clock time for writing fields (s); for a resumed run, since it was resumed.
    pub wall_s: f64,
    /// Range of each array at its last time, by part: of numbers, or of the lengths of vectors.
    pub last: BTreeMap<String, ArrayRanges>,
    /// blake3 of each file of fields, by its path in the run directory.
    pub blake3: BTreeMap<String, String>,
}

/// The line of a collection for a file, given by its path relative to the collection. It shows the part with this
/// number and name at this simulated time (s).
pub fn data_set(time_s: f64, (index, name): (usize, &str), file: &str) -> String {
    format!("<DataSet timestep=\"{time_s:e}\" part=\"{index}\" name=\"{name}\" file=\"{file}\"/>\n")
}

#[cfg(test)]
mod tests {
    use super::*;
    use kit::scratch::Scratch;

    #[test]
    fn a_phase_ends_with_a_moment_and_contains_the_requested_ones() {
        let phase = |name: &str, [t0_s, t1_s]: [f64; 2]| Phase {
            name: name.into(),
            t0_s,
            t1_s,
            sampled: name == "hold",
            picture: true,
        };
        let phases = [phase("hold", [0.5, 2.0]), phase("cycling", [2.0, 6.0])];
        let moments = |every| {
            let all = snapshot_times(&phases, every, 6.0).expect("they are few");
            Vec::from_iter(all.into_iter().map(|m| (m.name, m.time_s, m.sampled)))
        };
        let ends = [("hold", 2.0, true), ("cycling", 6.0, false)];
        let inner = [("hold-1", 1.5, false), ("cycling-1", 3.0, false)];
        let last = [("cycling-2", 4.0, false), ("cycling-3", 5.0, false)];
        let own = |all: &[(&str, f64, bool)]| {
            Vec::from_iter(all.iter().map(|(name, t, s)| (name.to_string(), *t, *s)))
        };
        assert_eq!(moments(None), own(&ends));
        let all = [inner[0], ends[0], inner[1], last[0], last[1], ends[1]];
        assert_eq!(moments(Some(1.0)), own(&all));
        let error = snapshot_times(&phases, Some(1e-4), 6.0).expect_err("they are many");
        assert!(error.to_string().contains("fields_every_s"), "{error}");
    }

    #[test]
    fn a_run_without_phases_or_beyond_them_has_the_requested_moments() {
        let moments = |phases: &[Phase], every| {
            let all = snapshot_times(phases, every, 3.0).expect("they are few");
            Vec::from_iter(all.into_iter().map(|m| (m.name, m.time_s)))
        };
        let two = [("run-1".to_string(), 1.0), ("run-2".to_string(), 2.0)];
        assert_eq!(moments(&[], Some(1.0)), two);
        assert_eq!(moments(&[], None), []);
        let phase = Phase {
            name: "ramp".into(),
            t0_s: 0.0,
            t1_s: 1.5,
            sampled: false,
            picture: true,
        };
        let beyond = [
            ("ramp-1".to_string(), 1.0),
            ("ramp".to_string(), 1.5),
            ("run-1".to_string(), 2.5),
        ];
        assert_eq!(moments(&[phase], Some(1.0)), beyond);
    }

    #[test]
    fn a_collection_is_complete_after_each_set() {
        let scratch = Scratch::new("pvd", 1);
        std::fs::create_dir_all(scratch.path()).expect("a folder");
        let path = scratch.path().join("rail.pvd");
        let set = |time_s| data_set(time_s, (0, "rail"), "rail-hold.vtu");
        let mut collection = Collection::new(path.clone());
        let mut sets = String::new();
        for time_s in [0.5, 1e-4, 2.0] {
            collection.add(&set(time_s)).expect("it can be written");
            sets += &set(time_s);
            let text = std::fs::read_to_string(&path).expect("it is there");
            assert_eq!(text, format!("{BEGIN}{sets}{END}"));
        }
        assert!(sets.contains("timestep=\"5e-1\" part=\"0\" name=\"rail\" file=\"rail-hold.vtu\""));
    }
}
