//! The participant beside the other sides of its interfaces.

use super::rule::{Finding, broken, holds, not_tested};
use super::subject::{Part, TestedParticipant};
use coordinator::error::Error;
use coordinator::participants::remote::Remote;
use coordinator::plausible;
use scheme::join::join;

/// Launches all participants of the scenario and joins their sets.
pub fn joins(subject: &TestedParticipant) -> Result<Finding, Error> {
    if subject.part == Part::Alone {
        return Ok(not_tested("it has no interface"));
    }
    let (stage, name) = (subject.stage, &subject.participant.name);
    let mut all = stage.scenario().participant.clone();
    for participant in &mut all {
        if participant.name == *name {
            participant.clone_from(subject.participant);
        } else if let Err(error) = stage.launch(participant, 1) {
            return Ok(not_tested(format!("the other side: {error}")));
        }
    }
    let (mut peers, greeted) = stage.launch_all(&all, 1)?;
    let groups = join(
        &mut Remote::new(&mut peers, &greeted),
        &stage.scenario().interface,
    )?;
    let bounds = &stage.scenario().run.plausible;
    let mut said = Vec::new();
    for patch in groups.iter().flat_map(|group| &group.patches) {
        if let Some(warning) = plausible::surfaces(bounds, patch).first() {
            return Ok(broken(warning.line()));
        }
        said.push(format!(
            "`{}`: {} nodes, {} points",
            patch.name,
            patch.nodes.len(),
            patch.points.len()
        ));
    }
    Ok(holds(said.join(", ")))
}
