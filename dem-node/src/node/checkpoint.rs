//! What the grains write down of themselves, and how they take that up again.

use protocol::NodeError;
use protocol::checkpoint::{pack, unpack};
use serde::{Deserialize, Serialize};

use super::Dem;
use crate::report::Journal;
use crate::state::State;

/// Everything that windows have changed. The rest follows from configuration and handshake.
#[derive(Serialize, Deserialize)]
struct Written {
    state: State,
    journal: Journal,
    steps: u64,
    contact_iterations: f64,
    /// Of the node that wrote this: whoever reads it into other fields than it came from gets another one.
    hash: String,
}

impl Dem {
    pub(super) fn write_down(&self) -> Result<Vec<u8>, NodeError> {
        // Every field is named, so that a new one is decided upon here.
        let Dem {
            state,
            journal,
            steps,
            contact_iterations,
            // The same after the same start:
            participant: _,
            fields: _,
            thickness: _,
            mass_per_area: _,
            half_width: _,
            theta: _,
            own_step: _,
            end: _,
            bounds: _,
            crew: _,
            bodies: _,
            program: _,
            pull: _,
            born: _,
            bond_step_limit: _,
            solid_fraction: _,
            scaling: _,
            warnings: _,
            exchange: _,
            initial_energy: _,
            // Announced anew by the coupler:
            window: _,
            // Overwritten by the next window:
            trial: _,
            stepper: _,
            pending: _,
        } = self;
        pack(&Written {
            state: state.clone(),
            journal: journal.clone(),
            steps: *steps,
            contact_iterations: *contact_iterations,
            hash: state.hash(),
        })
    }

    pub(super) fn take_up(&mut self, bytes: &[u8]) -> Result<(), NodeError> {
        let written: Written = unpack(bytes)?;
        let counts = |state: &State| {
            [
                state.centres.len(),
                state.velocities.len(),
                state.glued_velocity.len(),
                state.clusters.len(),
            ]
        };
        let refuse = |why: &str| {
            Err(NodeError::configuration(format!(
                "the checkpoint is not of these grains: {why}; resume with the build and the scenario that wrote it"
            )))
        };
        if counts(&written.state) != counts(&self.state) {
            return refuse("their number is another");
        }
        if written.state.hash() != written.hash {
            return refuse("their numbers have another hash");
        }
        self.state = written.state;
        self.journal = written.journal;
        self.steps = written.steps;
        self.contact_iterations = written.contact_iterations;
        self.pending = None;
        Ok(())
    }
}
