//! Answers of the body to a coupler.

use fem_kernel::interface::compliance::{compliance, impedance};
use protocol::checkpoint::{pack, unpack};
use protocol::{Capabilities, Description, Node, NodeError, Outcome, Reaction, Surface, Window};

use super::fem_node::FemNode;
use super::report::{described, reported};
use super::windows::{FORCE, VELOCITY};
use crate::error::FemError;
use crate::interface::window::committed::Committed;
use crate::interface::window::extent::{BodyWindow, WindowInput};
use crate::interface::window::warms_in_steps;

impl Node for FemNode {
    fn describe(&self) -> Description {
        let alone = self.model.wheel.is_none();
        let signals = self.signals(&WindowInput::default());
        Description {
            capabilities: Capabilities {
                rollback: true,
                advance: alone,
                columns: alone,
                prescribed_velocity: self.takes_velocity().is_ok(),
                alone: true,
                resume: true,
                heat: alone && self.model.heat.is_some(),
                ..Capabilities::default()
            },
            ..described(&self.model, signals, self.terms())
        }
    }

    fn couple(&mut self, set: &str) -> Result<Surface, NodeError> {
        if self.model.wheel.is_some() {
            return Err(FemError::CoupledWithWheel { set: set.into() }.into());
        }
        Ok(self.interface.couple(&self.model, set)?)
    }

    fn select(&mut self, points: &[usize]) -> Result<(), NodeError> {
        Ok(self.interface.select(&self.model, points)?)
    }

    fn columns(&mut self, window: &Window) -> Result<Vec<f64>, NodeError> {
        Ok(self.condensed("compliance", compliance, window.substeps)?)
    }

    fn advance(&mut self, window: &Window, force: &[f64]) -> Result<Vec<f64>, NodeError> {
        let input = WindowInput {
            interface: self.paired(window, FORCE, force)?,
            ..WindowInput::default()
        };
        self.try_window(window, input)?;
        Ok(self.increments())
    }

    fn impedance(&mut self, window: &Window) -> Result<Vec<f64>, NodeError> {
        self.takes_velocity()?;
        Ok(self.condensed("impedance", impedance, window.substeps)?)
    }

    fn prescribe_velocity(
        &mut self,
        window: &Window,
        velocity: &[f64],
    ) -> Result<Reaction, NodeError> {
        self.takes_velocity()?;
        let input = WindowInput {
            velocity: self.paired(window, VELOCITY, velocity)?,
            ..WindowInput::default()
        };
        self.try_window(window, input)?;
        let reaction = self.run.velocity.as_ref();
        let reaction = reaction.map(|of| (of.force.clone(), of.work.clone()));
        let (force, work) = reaction.unwrap_or_default();
        let increment = self.increments();
        Ok(Reaction {
            force,
            work,
            increment,
        })
    }

    fn commit(&mut self, window: &Window, displacement: &[f64]) -> Result<Vec<f64>, NodeError> {
        if !displacement.is_empty() {
            let (window, count) = (window.index, displacement.len());
            return Err(FemError::Dictated { window, count }.into());
        }
        let input = FemError::advanced(window, self.pending.take())?;
        let window = BodyWindow {
            model: &self.model,
            committed: &self.committed,
            input: &input,
        };
        let ledger = self.run.close(window);
        let committed = &mut self.committed;
        committed.ledger = ledger;
        committed.reactions = self.run.works.last_reactions(&self.model);
        let in_steps = warms_in_steps(&self.model, &input);
        if in_steps {
            committed.heat.clone_from(&self.run.heat);
        } else if let Some(heat) = &self.model.heat {
            let lost = self.run.fields.dissipated.plastic.iter();
            committed.heat.yields(heat, lost.copied());
            let steps = committed.steps + u64::from(input.substeps);
            heat.pass(&mut committed.heat, (steps, self.model.scheme.step));
        }
        if let (Some(wheel), Some(run)) = (&mut committed.wheel, &self.run.wheel) {
            committed.state.resume(&self.run.fields.state);
            wheel.clone_from(&run.state);
            let record = self.run.hold_record.take();
            committed.hold_record = record.or(committed.hold_record.take());
            self.run.forget();
        } else {
            self.run.accept(&mut committed.state, &self.reported_rows);
        }
        if !in_steps {
            self.model.warm(&mut committed.heat, &mut committed.state);
        }
        self.gathered.take();
        committed.steps += u64::from(input.substeps);
        Ok(reported(self.signals(&input), self.terms()))
    }

    fn advance_alone(&mut self, window: &Window) -> Result<Vec<f64>, NodeError> {
        let none = vec![0.0; self.interface.components.len()];
        self.advance(window, &none)?;
        self.commit(window, &[])
    }

    fn take_heat(&mut self, _window: &Window, heat: &[f64]) -> Result<Vec<f64>, NodeError> {
        let (of, committed) = (self.model.heat.as_ref(), &mut self.committed);
        let time = (committed.steps, self.model.scheme.step);
        let (of, nodes) = (of.ok_or(FemError::NoHeat)?, &*self.interface.exchanged);
        let answer = of.exchange(&mut committed.heat, (nodes, heat), time);
        self.model.warm(&mut committed.heat, &mut committed.state);
        Ok(answer)
    }

    fn checkpoint(&mut self) -> Result<Vec<u8>, NodeError> {
        self.catch_up();
        pack(&(&self.committed, self.state_hash()))
    }

    fn restore(&mut self, state: &[u8]) -> Result<(), NodeError> {
        let (committed, hash): (Committed, String) = unpack(state)?;
        self.take_up(committed, &hash)
    }

    fn snapshot(&mut self, name: &str) -> Result<(), NodeError> {
        self.catch_up();
        Ok(self.try_snapshot(name)?)
    }

    fn finish(&mut self) -> Result<Outcome, NodeError> {
        self.catch_up();
        let state_hash = self.state_hash();
        self.end_heat();
        if let Some((wheel, state)) = self.model.wheel.as_ref().zip(self.committed.wheel.as_ref()) {
            self.snapshots.table("passages", &state.passages(wheel))?;
        }
        let columns = self.model.mesh.elements() as f64 * self.committed.column_steps as f64;
        let work = [
            ("element_steps", self.committed.element_steps as f64),
            ("column_element_steps", columns),
        ];
        Ok(Outcome {
            steps: self.committed.steps_done,
            work: work.map(|(name, value)| (name.into(), value)).into(),
            results: self.results(),
            state_hash,
            findings: self.findings(),
            ..Outcome::default()
        })
    }
}
