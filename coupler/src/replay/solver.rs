//! One solver again, against what the coupler asked of it.

use protocol::{Frame, Header, Kind, Window};

use super::departure::Departure;
use super::tape::{Turn, turns};
use super::{Recording, Replayed};
use crate::couple::conversation::Conversation;
use crate::couple::handshake;
use crate::error::Error;
use crate::launch::{Launcher, Watch};

/// Starts the participant `name` alone, asks it everything that the log holds, and compares its answers.
pub fn replay(
    recording: &Recording,
    launcher: &Launcher,
    name: &str,
    watch: &Watch,
) -> Result<Replayed, Error> {
    let scenario = &recording.loaded.scenario;
    let participant = scenario
        .participant
        .iter()
        .find(|participant| participant.name == name)
        .ok_or_else(|| {
            let names: Vec<&str> = scenario
                .participant
                .iter()
                .map(|participant| participant.name.as_str())
                .collect();
            Error::Refused(format!(
                "no participant `{name}` in this run; participants: {}",
                names.join(", ")
            ))
        })?;
    let memory = launcher.shared_memory();
    let peer = launcher.start(participant, &memory)?;
    let deadlines = &scenario.run.deadlines;
    let mut conversation = Conversation::new(
        vec![peer],
        launcher.run_id,
        vec![scenario.label(name)],
        deadlines,
        watch.clone(),
        None,
    );
    handshake::greet(&mut conversation, &recording.loaded, launcher.run_id)?;
    let mut replayed = Replayed {
        who: name.to_string(),
        equal: 0,
        last_window: 0,
        departure: None,
    };
    for turn in turns(&recording.messages, name) {
        let Some(answer) = &turn.answer else { break };
        let ours = ask_again(&mut conversation, &turn, answer)?;
        replayed.departure = Departure::between(name, answer, &ours);
        if replayed.departure.is_some() {
            return Ok(replayed);
        }
        replayed.equal += 1;
        replayed.last_window = answer.header.window;
    }
    conversation.tell(0, Kind::Finish, &Window::default(), Vec::new())?;
    conversation.hear(0, Kind::Finished)?;
    Ok(replayed)
}

fn ask_again(conversation: &mut Conversation, turn: &Turn, answer: &Frame) -> Result<Frame, Error> {
    let header: Header = turn.request.header;
    conversation.repeat(0, header, turn.request.payload.clone())?;
    let kind = answer
        .kind()
        .map_err(|error| Error::Refused(format!("the log: {error}")))?;
    conversation.hear(0, kind)
}
