//! What a checkpoint holds of the coupler.

use serde::{Deserialize, Serialize};

use super::Coupling;
use super::compliance::{ComplianceState, tell_walls};
use crate::couple::conversation::Conversation;
use crate::couple::ledger::InterfaceLedger;
use crate::error::Error;

/// Everything of a group that windows have changed. The rest follows from scenario and handshake.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CouplingState {
    compliance: ComplianceState,
    rigid_wall: Option<u32>,
    last_motion: Vec<f64>,
    lambda: Vec<f64>,
    velocity: Vec<f64>,
    displacement: Vec<f64>,
    ledgers: Vec<InterfaceLedger>,
}

impl CouplingState {
    fn lengths(&self) -> [usize; 5] {
        [
            self.last_motion.len(),
            self.lambda.len(),
            self.velocity.len(),
            self.displacement.len(),
            self.ledgers.len(),
        ]
    }
}

impl Coupling {
    /// What windows have changed.
    pub fn state(&self) -> CouplingState {
        // Every field is named, so that a new one is decided upon here.
        let Coupling {
            rules: _,
            group: _,
            compliance,
            rigid_wall,
            last_motion,
            lambda,
            velocity,
            displacement,
            ledgers,
        } = self;
        CouplingState {
            compliance: compliance.state(),
            rigid_wall: *rigid_wall,
            last_motion: last_motion.clone(),
            lambda: lambda.clone(),
            velocity: velocity.clone(),
            displacement: displacement.clone(),
            ledgers: ledgers.clone(),
        }
    }

    /// Takes up a state after the same handshake.
    pub fn restore(&mut self, state: &CouplingState) -> Result<(), Error> {
        let ours = self.state().lengths();
        if state.lengths() != ours || !state.compliance.is_of(&self.group) {
            return Err(Error::Refused(format!(
                "interface `{}`: the checkpoint is of other interfaces, with {:?} instead of {ours:?} components",
                self.rules.name,
                state.lengths()
            )));
        }
        let CouplingState {
            compliance,
            rigid_wall,
            last_motion,
            lambda,
            velocity,
            displacement,
            ledgers,
        } = state.clone();
        self.compliance.restore(compliance);
        self.rigid_wall = rigid_wall;
        self.last_motion = last_motion;
        self.lambda = lambda;
        self.velocity = velocity;
        self.displacement = displacement;
        self.ledgers = ledgers;
        Ok(())
    }

    /// Tells the walls once more what they stood on.
    pub fn tell_again(&self, conversation: &mut Conversation) -> Result<(), Error> {
        let (substeps, blocks) = match (self.rigid_wall, self.compliance.told()) {
            (Some(substeps), _) => (substeps, None),
            (None, Some((substeps, blocks))) => (substeps, Some(blocks)),
            (None, None) => return Ok(()),
        };
        let window = self.group.clock.window(0, 0, substeps);
        tell_walls(conversation, &self.group, &window, blocks)
    }
}
