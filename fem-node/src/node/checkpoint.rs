//! What a body in motion writes down of itself, and how it takes that up again.

use protocol::NodeError;
use protocol::checkpoint::{pack, unpack};
use serde::{Deserialize, Serialize};

use super::FemNode;
use crate::integrate::State;
use crate::ledger::Ledger;
use crate::probe::{Held, PressureMaxima};
use crate::wheel::WheelState;

/// Everything that windows have changed. The rest follows from configuration and handshake.
#[derive(Serialize, Deserialize)]
struct Written {
    committed: State,
    wheel: Option<WheelState>,
    ledger: Ledger,
    steps: u64,
    steps_done: u64,
    column_steps: u64,
    hold: Option<PressureMaxima>,
    held: Option<Held>,
    /// Of the node that wrote this: whoever reads it into other fields than it came from gets another one.
    hash: String,
}

impl FemNode {
    pub(super) fn write_down(&self) -> Result<Vec<u8>, NodeError> {
        // Every field is named, so that a new one is decided upon here.
        let FemNode {
            committed,
            wheel,
            ledger,
            steps,
            steps_done,
            column_steps,
            hold,
            held,
            // The same after the same start:
            model: _,
            participant: _,
            fields: _,
            pool: _,
            interface: _,
            // Overwritten by the next window:
            integrator: _,
            run: _,
            pending: _,
        } = self;
        pack(&Written {
            committed: committed.clone(),
            wheel: wheel.clone(),
            ledger: *ledger,
            steps: *steps,
            steps_done: *steps_done,
            column_steps: *column_steps,
            hold: *hold,
            held: held.clone(),
            hash: self.state_hash(),
        })
    }

    pub(super) fn take_up(&mut self, bytes: &[u8]) -> Result<(), NodeError> {
        let written: Written = unpack(bytes)?;
        let refuse = |why: &str| {
            Err(NodeError::configuration(format!(
                "the checkpoint is not of this body: {why}; resume with the build and the scenario that wrote it"
            )))
        };
        let lengths = |state: &State| {
            let State {
                u,
                v,
                force,
                a,
                resistance,
                history,
            } = state;
            // Empty until something has been damped.
            let resistance = if resistance.is_empty() { u } else { resistance };
            [u, v, force, a, resistance, history].map(Vec::len)
        };
        if lengths(&written.committed) != lengths(&self.committed) {
            return refuse("its fields have other lengths");
        }
        let touches = |wheel: &Option<WheelState>| wheel.as_ref().map(|wheel| wheel.touches.len());
        if touches(&written.wheel) != touches(&self.wheel) {
            return refuse("its wheel touches other nodes");
        }
        self.committed = written.committed;
        self.wheel = written.wheel;
        self.ledger = written.ledger;
        self.steps = written.steps;
        self.steps_done = written.steps_done;
        self.column_steps = written.column_steps;
        self.hold = written.hold;
        self.held = written.held;
        self.pending = None;
        match self.state_hash() == written.hash {
            true => Ok(()),
            false => refuse("its numbers have another hash"),
        }
    }
}
