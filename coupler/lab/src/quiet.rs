//! Runs without words, for trials.

use std::path::Path;

use coordinator::error::{Error, Refusal};
use coordinator::participants::{Registry, Watch};
use coordinator::run::session::{Ended, RunOptions};
use coordinator::scenario::Scenario;

/// A run into a folder, one thread a participant, that shows no progress and that no signal ends.
pub fn quiet_run<'a>(out: &'a Path, registry: &'a Registry, program: &Path) -> RunOptions<'a> {
    RunOptions {
        out: Some(out),
        threads: 1,
        registry,
        program: program.to_path_buf(),
        watch: Watch::default(),
        progress: false,
        strict: false,
        dry_run: false,
        budget: None,
    }
}

/// A run that came to its end; one that did not is its error.
pub fn whole(ended: Result<Ended, Error>) -> Result<Ended, Error> {
    let mut ended = ended?;
    ended.error.take().map_or(Ok(ended), Err)
}

/// Index of the participant of this name.
///
/// # Errors
/// There is none.
pub fn participant_index(scenario: &Scenario, name: &str) -> Result<usize, Error> {
    let names = scenario.participant.iter();
    let names: Vec<&str> = names.map(|p| p.name.as_str()).collect();
    let index = names.iter().position(|known| *known == name);
    index.ok_or_else(|| {
        Error::from(Refusal::NoParticipant {
            name: name.into(),
            known: names.join(", "),
        })
    })
}
