//! Where a resumed run goes on: a checkpoint of another run directory, with the log and the outputs up to it.

use std::fs;
use std::path::{Path, PathBuf};

use protocol::{Frame, Header, Kind, Phase};

use super::file::{self, Unusable};
use super::keeper::{about, participants};
use super::{About, Checkpoint, FOLDER};
use crate::couple::conversation::Conversation;
use crate::couple::course::Course;
use crate::couple::handshake::Greeted;
use crate::error::Error;
use crate::log::{Entry, recover};
use crate::rundir::RunDir;
use crate::scenario::load::Loaded;

/// A checkpoint that can be gone on from.
pub struct Origin {
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
) -> Result<(Option<Origin>, Vec<Unusable>), Error> {
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
                    let origin = Origin {
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

impl Origin {
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

    /// Gives the coupler and each participant their states back, and tells the walls what they stood on.
    pub fn restore(
        &self,
        conversation: &mut Conversation,
        courses: &mut [Course],
    ) -> Result<(), Error> {
        self.place(courses)?;
        for course in courses {
            conversation.aside(|conversation| course.coupling.tell_again(conversation))?;
        }
        (0..self.checkpoint.nodes.len())
            .try_for_each(|peer| self.restore_node(conversation, peer, peer))
    }

    /// Gives the participant `index` of the scenario its state back, the only one of the conversation.
    pub fn restore_one(&self, conversation: &mut Conversation, index: usize) -> Result<(), Error> {
        self.restore_node(conversation, 0, index)
    }

    fn restore_node(
        &self,
        conversation: &mut Conversation,
        peer: usize,
        index: usize,
    ) -> Result<(), Error> {
        let frame = Frame::with_bytes(Header::of(Kind::Restore), &self.checkpoint.nodes[index]);
        conversation.repeat(peer, frame.header, frame.payload)?;
        conversation.hear(peer, Kind::Restored).map(|_| ())
    }

    /// Gives the coupler its state back.
    pub fn place(&self, courses: &mut [Course]) -> Result<(), Error> {
        let state = &self.checkpoint;
        let places = &state.position.courses;
        if [places.len(), state.couplings.len()] != [courses.len(); 2] {
            return Err(Error::Refused(format!(
                "checkpoint {}: it is of {} groups of interfaces, here are {}",
                self.path.display(),
                places.len(),
                courses.len()
            )));
        }
        for ((course, place), coupling) in courses.iter_mut().zip(places).zip(&state.couplings) {
            course.go_to(place);
            course.coupling.restore(coupling)?;
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
