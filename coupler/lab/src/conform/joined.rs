//! The participant together with the other sides of its interfaces.

use super::rule::{RuleFinding, broken, not_tested};
use super::tested::{Part, TestedParticipant};
use coordinator::participants::remote::Remote;
use runs::plausible;
use scenario::error::Error;
use scheme::join::join;

/// Launches all participants of the scenario and joins their sets.
pub fn joins(tested: &TestedParticipant) -> RuleFinding {
    if tested.part == Part::Alone {
        return not_tested("it has no interface");
    }
    let (launcher, name) = (tested.launcher, &tested.participant.name);
    let mut all = launcher.scenario().participant.clone();
    for participant in &mut all {
        if participant.name == *name {
            participant.clone_from(tested.participant);
        } else if let Err(error) = launcher.launch(participant, 1) {
            return not_tested(format!("the other side: {error}"));
        }
    }
    let (mut peers, greeted) = launcher.launch_all(&all, 1)?;
    let remote = &mut Remote::new(&mut peers, &greeted);
    let groups = join(remote, &launcher.scenario().interface).map_err(Error::from)?;
    let bounds = &launcher.scenario().run.plausible;
    let mut joined = Vec::new();
    for patch in groups.iter().flat_map(|group| &group.patches) {
        if let Some(warning) = plausible::surfaces(bounds, patch).first() {
            return broken(warning.line());
        }
        let (nodes, points) = (patch.nodes.len(), patch.points.len());
        joined.push(format!("`{}`: {nodes} nodes, {points} points", patch.name));
    }
    Ok(joined.join(", "))
}
