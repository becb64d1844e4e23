//! The restart point of a resumed run: a checkpoint of another run directory, with the log and the outputs up to it.

use std::fs;
use std::path::{Path, PathBuf};

use protocol::{Frame, Kind, Phase, Window};

use super::content::{About, Checkpoint, FOLDER};
use super::file::{self, Unusable};
use super::keeper::{about, participants};
use crate::error::Error;
use crate::log::{Entry, recover};
use crate::participants::Communicator;
use crate::participants::handshake::Greeted;
use crate::participants::remote::Remote;
use crate::run::time_loop::GroupRun;
use crate::rundir::RunDir;
use crate::scenario::load::Loaded;

/// A checkpoint that can be gone on from.
pub struct RestartPoint {
    /// The run directory that it belongs to.
    pub run: PathBuf,
    /// Its file.
    pub path: PathBuf,
    /// What it is about.
    pub about: About,
    /// What it holds.
    pub checkpoint: Checkpoint,
}

/// The latest usable checkpoint of a run after at most `from` windows, and those that were passed over. A checkpoint is
/// usable if it is whole and the log reaches as far. One of another scenario or version is an error: all others would be
/// the same. None at all means that the run has to begin again.
pub fn find(
    run: &Path,
    loaded: &Loaded,
    from: Option<u64>,
) -> Result<(Option<RestartPoint>, Vec<Unusable>), Error> {
    let mut passed_over = Vec::new();
    let found = file::list(&run.join(FOLDER));
    let candidates = found
        .into_iter()
        .rev()
        .filter(|found| from.is_none_or(|from| found.window <= from));
    let mut logged = None;
    for found in candidates {
        let unusable = match file::read(&found.path, &about(loaded)) {
            Ok((about, checkpoint)) => {
                let logged = *logged.get_or_insert_with(|| blocks(&run.join("exchange.mcap")));
                if logged >= checkpoint.log_blocks {
                    let origin = RestartPoint {
                        run: run.into(),
                        path: found.path,
                        about,
                        checkpoint,
                    };
                    return Ok((Some(origin), passed_over));
                }
                Unusable {
                    path: found.path,
                    why: format!(
                        "exchange.mcap can be read for {logged} of the {} blocks that came before it",
                        checkpoint.log_blocks
                    ),
                    foreign: false,
                }
            }
            Err(unusable) => unusable,
        };
        if unusable.foreign {
            return Err(Error::Refused(format!(
                "{unusable}; resume with the build and the scenario that wrote it"
            )));
        }
        passed_over.push(unusable);
    }
    Ok((None, passed_over))
}

/// Blocks of a log that can be read whole.
fn blocks(log: &Path) -> u64 {
    let Ok(entries) = recover(log) else { return 0 };
    let ends = entries.filter(|entry| matches!(entry, Ok(Entry::WindowEnd(_))));
    ends.count() as u64
}

impl RestartPoint {
    /// Where the log of the run lies that is gone on with.
    pub fn log(&self) -> PathBuf {
        self.run.join("exchange.mcap")
    }

    /// Refuses participants that are not those that wrote the checkpoint.
    pub fn check(&self, loaded: &Loaded, greeted: &[Greeted]) -> Result<(), Error> {
        let ours = participants(loaded, greeted);
        let pairs = self.about.participants.iter().zip(&ours);
        for ((name, theirs), (_, ours)) in pairs {
            if theirs != ours {
                return Err(Error::Refused(format!(
                    "checkpoint {}: the state of participant `{name}` was written by {theirs}, this is {ours}; resume with the build that wrote it",
                    self.path.display()
                )));
            }
        }
        match greeted
            .iter()
            .zip(&ours)
            .find(|(greeted, _)| !greeted.description.capabilities.resume)
        {
            None => Ok(()),
            Some((_, (name, software))) => Err(Error::Refused(format!(
                "participant `{name}` ({software}) cannot take up a checkpoint (capability `resume`): run the scenario from its start"
            ))),
        }
    }

    /// Gives the coupler and each participant their states back, and tells the boundaries what they were; not a part of
    /// the exchange, which holds this already.
    pub fn restore(
        &self,
        communicator: &mut dyn Communicator,
        greeted: &[Greeted],
        groups: &mut [GroupRun],
    ) -> Result<(), Error> {
        self.place(groups)?;
        for group in groups {
            let remote = &mut Remote::new(communicator, greeted);
            group.coupling.repeat_boundaries(remote)?;
        }
        (0..self.checkpoint.nodes.len())
            .try_for_each(|peer| self.restore_node(communicator, peer, peer))
    }

    /// Gives the peer `peer`, which is the participant `index` of the scenario, its state back.
    pub fn restore_node(
        &self,
        communicator: &mut dyn Communicator,
        peer: usize,
        index: usize,
    ) -> Result<(), Error> {
        let header = communicator
            .peers()
            .header(peer, Kind::Restore, &Window::default());
        let frame = Frame::with_bytes(header, &self.checkpoint.nodes[index]);
        communicator.send(peer, header, frame.payload)?;
        communicator.receive(peer, Kind::Restored).map(|_| ())
    }

    /// Gives the coupler its state back.
    pub fn place(&self, groups: &mut [GroupRun]) -> Result<(), Error> {
        let state = &self.checkpoint;
        let positions = &state.position.groups;
        if [positions.len(), state.couplings.len()] != [groups.len(); 2] {
            return Err(Error::Refused(format!(
                "checkpoint {}: it is of {} groups of interfaces, here are {}",
                self.path.display(),
                positions.len(),
                groups.len()
            )));
        }
        for ((group, at), coupling) in groups.iter_mut().zip(positions).zip(&state.couplings) {
            group.go_to(*at);
            group.coupling.restore(coupling)?;
        }
        Ok(())
    }

    /// Takes over the fields of the phases that had ended.
    pub fn copy_fields(&self, rundir: &RunDir, phases: &[Phase]) -> Result<(), Error> {
        let ended = &phases[..self.checkpoint.outputs.snapshots_taken.min(phases.len())];
        let fields = fs::read_dir(self.run.join("fields"));
        for entry in fields.into_iter().flatten().flatten() {
            let name = entry.file_name().to_string_lossy().into_owned();
            let of = |phase: &Phase| {
                let mark = format!("-{}", phase.name);
                name.contains(&format!("{mark}.")) || name.contains(&format!("{mark}-"))
            };
            if ended.iter().any(of) {
                copy(&entry.path(), &rundir.fields().join(&name))?;
            }
        }
        if !ended.iter().any(|phase| phase.sampled) {
            return Ok(());
        }
        for entry in fs::read_dir(&self.run).into_iter().flatten().flatten() {
            let name = entry.file_name().to_string_lossy().into_owned();
            if name.starts_with("profile") && name.ends_with(".csv") {
                copy(&entry.path(), &rundir.path().join(&name))?;
            }
        }
        Ok(())
    }

    /// Puts the checkpoint itself into the new run directory: from here on that one can be resumed as well.
    pub fn adopt(&self, rundir: &RunDir) -> Result<(), Error> {
        let folder = rundir.path().join(FOLDER);
        fs::create_dir_all(&folder).map_err(Error::output(folder.display()))?;
        let bytes = fs::read(&self.path).map_err(Error::input(self.path.display()))?;
        file::write_whole(
            &file::path(&folder, self.checkpoint.position.windows),
            &bytes,
        )
    }
}

fn copy(from: &Path, to: &Path) -> Result<(), Error> {
    fs::copy(from, to)
        .map(|_| ())
        .map_err(Error::output(to.display()))
}
