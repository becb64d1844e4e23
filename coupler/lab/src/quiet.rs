//! Runs without output, for trials.

use coordinator::run::session::Ended;
use kit::keys::proposal;
use scenario::error::{Code, Error, Refusal};
use scenario::keys::Scenario;

/// A run that reached its end; otherwise its error.
pub fn whole(ended: Result<Ended, Error>) -> Result<Ended, Error> {
    let mut ended = ended?;
    ended.error.take().map_or(Ok(ended), Err)
}

/// Index of the participant with this name.
///
/// # Errors
/// There is no such participant.
pub fn participant_index(scenario: &Scenario, name: &str) -> Result<usize, Error> {
    let names = scenario.participant.iter();
    let names: Vec<&str> = names.map(|p| p.name.as_str()).collect();
    let index = names.iter().position(|known| *known == name);
    index.ok_or_else(|| {
        let meant = proposal(name, "participants", &names);
        let text = format!("no participant `{name}` in this scenario; {meant}");
        Refusal::other(Code::UnknownParticipant, text).into()
    })
}
