//! Answers of the body to a coupler.

use std::collections::BTreeMap;

use protocol::{Capabilities, Description, Node, NodeError, Outcome, Reaction, Surface, Window};

use super::fem_node::FemNode;
use crate::error::FemError;
use crate::interface::{Condensed, coupling_sets};
use crate::model::limit_name;
use crate::probe;
use crate::wheel::SIGNALS;

impl Node for FemNode {
    fn describe(&self) -> Description {
        let alone = self.model.wheel.is_none();
        let forces = ["interface_force_x_n", "interface_force_y_n"];
        Description {
            kind: "fem".into(),
            software: format!("fem-node {}", env!("CARGO_PKG_VERSION")),
            capabilities: Capabilities {
                rollback: true,
                advance: alone,
                columns: alone,
                compliant_boundary: false,
                prescribed_velocity: self.takes_velocity().is_ok(),
                alone: true,
                resume: true,
            },
            step_s: Some(self.model.scheme.step),
            step_limit_s: Some(self.model.step_limit),
            step_limit_name: limit_name(self.model.scheme.stiffness_damping).into(),
            end_s: self.model.end,
            phases: self.phases(),
            sets: coupling_sets(&self.model),
            signals: probe::surface_names(&self.model)
                .iter()
                .chain(&forces)
                .chain(SIGNALS.iter().filter(|_| !alone))
                .map(|name| (*name).into())
                .collect(),
            ledger: self.terms().names(),
            warnings: self.model.warnings.clone(),
            first_period_s: Some(self.model.first_period()),
            ..Description::default()
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

    fn columns(&mut self, substeps: u32) -> Result<Vec<f64>, NodeError> {
        Ok(self.condensed(Condensed::Compliance, substeps)?)
    }

    fn advance(&mut self, window: &Window, force: &[f64]) -> Result<Vec<f64>, NodeError> {
        Ok(self.try_advance(window, force)?)
    }

    fn impedance(&mut self, substeps: u32) -> Result<Vec<f64>, NodeError> {
        self.takes_velocity()?;
        Ok(self.condensed(Condensed::Impedance, substeps)?)
    }

    fn prescribe_velocity(
        &mut self,
        window: &Window,
        velocity: &[f64],
    ) -> Result<Reaction, NodeError> {
        Ok(self.try_velocity(window, velocity)?)
    }

    fn commit(&mut self, window: &Window, displacement: &[f64]) -> Result<Vec<f64>, NodeError> {
        Ok(self.try_commit(window, displacement)?)
    }

    fn advance_alone(&mut self, window: &Window) -> Result<Vec<f64>, NodeError> {
        let none = vec![0.0; self.interface.components.len()];
        self.advance(window, &none)?;
        self.commit(window, &[])
    }

    fn checkpoint(&mut self) -> Result<Vec<u8>, NodeError> {
        self.checkpoint_bytes()
    }

    fn restore(&mut self, state: &[u8]) -> Result<(), NodeError> {
        self.restore_bytes(state)
    }

    fn snapshot(&mut self, name: &str) -> Result<(), NodeError> {
        Ok(self.try_snapshot(name)?)
    }

    fn finish(&mut self) -> Result<Outcome, NodeError> {
        let elements = self.model.mesh.elements() as f64;
        let work = |steps: u64| elements * steps as f64;
        Ok(Outcome {
            steps: self.committed.steps_done,
            work: BTreeMap::from([
                ("element_steps".into(), work(self.committed.steps_done)),
                (
                    "column_element_steps".into(),
                    work(self.committed.column_steps),
                ),
            ]),
            results: self.results(),
            state_hash: self.state_hash(),
            warnings: Vec::new(),
        })
    }
}
