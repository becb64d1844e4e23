//! The restart point of a resumed run: a checkpoint of another run directory, with the log and the outputs up to it.

use std::fs;
use std::path::{Path, PathBuf};

use protocol::frame::packed;
use protocol::{Kind, Window};

use super::content::{About, Checkpoint, FOLDER};
use super::file::{self, Unusable};
use super::keeper::{about, participants};
use crate::participants::Communicator;
use crate::participants::handshake::Greeted;
use crate::participants::remote::Remote;
use crate::run::time_loop::GroupRun;
use exchange_log::{Entry, recover};
use runs::collection::SnapshotTime;
use runs::run_dir::{RunDir, write_whole};
use runs::written::names;
use scenario::content::content_hash;
use scenario::error::{Error, Refusal, Result};
use scenario::load::Loaded;

/// A checkpoint from which a run can be resumed.
pub struct RestartPoint {
    /// The run directory that it belongs to.
    pub run: PathBuf,
    /// Its file.
    pub path: PathBuf,
    /// Its author and subject.
    pub about: About,
    /// Its content.
    pub checkpoint: Checkpoint,
}

/// The latest usable checkpoint of a run after at most `from` windows, and the unusable ones after it. A checkpoint is
/// usable if it is complete, the log reaches as far, and signals, fields and profiles until then are unchanged. A
/// checkpoint of another scenario or version is an error, as all others would be. Without a usable checkpoint the run
/// must start again.
pub fn find(
    run: &Path,
    loaded: &Loaded,
    from: Option<u64>,
) -> Result<(Option<RestartPoint>, Vec<Unusable>)> {
    let mut passed_over = Vec::new();
    let mut logged = None;
    let found = file::list(&run.join(FOLDER)).into_iter().rev();
    for found in found.filter(|found| from.is_none_or(|from| found.window <= from)) {
        let path = found.path;
        let unusable = match file::read(&path, &about(loaded)) {
            Ok((about, checkpoint)) => {
                let logged = *logged.get_or_insert_with(|| blocks(&run.join("exchange.mcap")));
                let due = checkpoint.log_blocks;
                let why = match checkpoint.outputs.damaged(run) {
                    _ if logged < due => format!(
                        "exchange.mcap can be read only up to block {logged} of the {due} before it"
                    ),
                    Some(name) => {
                        format!("{name} differs from what the run had written until then")
                    }
                    None => {
                        let point = RestartPoint {
                            run: run.into(),
                            path,
                            about,
                            checkpoint,
                        };
                        return Ok((Some(point), passed_over));
                    }
                };
                Unusable {
                    path,
                    why,
                    foreign: false,
                }
            }
            Err(unusable) => unusable,
        };
        if unusable.foreign {
            let text = format!("{unusable}; resume with the build and the scenario that wrote it");
            return Err(Refusal::checkpoint(text).into());
        }
        passed_over.push(unusable);
    }
    Ok((None, passed_over))
}

/// Number of complete blocks in a log.
fn blocks(log: &Path) -> u64 {
    let Ok(entries) = recover(log) else { return 0 };
    let ends = entries.filter(|entry| matches!(entry, Ok(Entry::WindowEnd(_))));
    ends.count() as u64
}

impl RestartPoint {
    fn refuse(&self, problem: String) -> Error {
        let path = self.path.display();
        Refusal::checkpoint(format!("checkpoint {path}: {problem}")).into()
    }

    /// Refuses participants other than the ones that wrote the checkpoint.
    pub fn check(&self, loaded: &Loaded, greeted: &[Greeted]) -> Result<()> {
        let ours = participants(loaded, greeted);
        for ((name, theirs), (_, ours)) in self.about.participants.iter().zip(&ours) {
            if theirs != ours {
                return Err(self.refuse(format!(
                    "the state of participant `{name}` was written by {theirs}, but this is {ours}; resume with the build that wrote it"
                )));
            }
        }
        for ((name, software), greeted) in ours.iter().zip(greeted) {
            if !greeted.description.capabilities.resume {
                let problem = format!(
                    "({software}) cannot resume from a checkpoint (capability `resume`): run the scenario from its start"
                );
                return Err(Refusal::participant(name, problem).into());
            }
        }
        Ok(())
    }

    /// Restores the coupler, each participant and the boundaries. This is not part of the exchange, whose log contains
    /// it already.
    pub fn restore(
        &self,
        communicator: &mut dyn Communicator,
        greeted: &[Greeted],
        groups: &mut [GroupRun],
    ) -> Result<()> {
        self.restore_coupler(groups)?;
        for group in groups {
            let remote = &mut Remote::new(communicator, greeted);
            group.coupling.repeat_boundaries(remote)?;
        }
        (0..self.checkpoint.nodes.len())
            .try_for_each(|peer| self.restore_node(communicator, peer, peer))
    }

    /// Restores the peer `peer`, which is the participant `index` of the scenario.
    pub fn restore_node(
        &self,
        communicator: &mut dyn Communicator,
        peer: usize,
        index: usize,
    ) -> Result<()> {
        let kinds = (Kind::Restore, Kind::Restored);
        let state = packed(&self.checkpoint.nodes[index]);
        communicator.ask(peer, kinds, &Window::default(), state)?;
        Ok(())
    }

    /// Restores the coupler.
    pub fn restore_coupler(&self, groups: &mut [GroupRun]) -> Result<()> {
        let state = &self.checkpoint;
        let positions = &state.position.groups;
        if [positions.len(), state.couplings.len()] != [groups.len(); 2] {
            let (theirs, ours) = (positions.len(), groups.len());
            let problem =
                format!("it has {theirs} groups of interfaces, but the scenario has {ours}");
            return Err(self.refuse(problem));
        }
        for ((group, at), coupling) in groups.iter_mut().zip(positions).zip(&state.couplings) {
            group.at = *at;
            group.coupling.restore(coupling)?;
        }
        Ok(())
    }

    /// Copies the fields and profiles of past moments.
    pub fn copy_files(&self, rundir: &RunDir) -> Result<()> {
        for name in self.checkpoint.outputs.files.keys() {
            let [from, to] = [&self.run, rundir.path()].map(|run| run.join(name));
            fs::copy(from, &to).map_err(Error::output(to.display()))?;
        }
        Ok(())
    }

    /// Copies the checkpoint into the new run directory, which can be resumed from here on as well.
    pub fn adopt(&self, rundir: &RunDir) -> Result<()> {
        let folder = rundir.path().join(FOLDER);
        fs::create_dir_all(&folder).map_err(Error::output(folder.display()))?;
        let bytes = fs::read(&self.path).map_err(Error::input(self.path.display()))?;
        let window = self.checkpoint.position.windows;
        write_whole(&file::path(&folder, window), &bytes)
    }
}

/// The files that a run wrote at these moments, by their paths in its directory, with the blake3 of their contents.
pub fn files_of(run: &Path, moments: &[SnapshotTime]) -> Vec<(String, String)> {
    let of_moments = |file: &String| {
        moments.iter().any(|moment| {
            let mark = format!("-{}", moment.name);
            file.contains(&format!("{mark}.")) || file.contains(&format!("{mark}-"))
        })
    };
    let sampled = moments.iter().any(|moment| moment.sampled);
    let profile = |file: &String| sampled && file.starts_with("profile") && file.ends_with(".csv");
    let fields = names(run.join("fields")).filter(of_moments);
    let fields = fields.map(|file| format!("fields/{file}"));
    let files = fields.chain(names(run.into()).filter(profile));
    let hashed = files.map(|file| (content_hash(&run.join(&file)), file));
    let hashed = hashed.filter_map(|(hash, file)| Some((file, hash?)));
    hashed.collect()
}
