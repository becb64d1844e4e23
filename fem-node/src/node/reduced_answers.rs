//! Answers of a reduced body to a coupler.

use std::collections::BTreeMap;

use protocol::checkpoint::{pack, unpack};
use protocol::{Capabilities, Description, Node, NodeError, Outcome, Surface, Term, Window};

use super::checkpoint::foreign;
use super::reduced_node::{ReducedCommitted, ReducedNode};
use super::report::phases_of;
use crate::error::FemError;
use crate::interface::{coupling_sets, outward_normals, periods};
use crate::model::limit_name;
use crate::output::ledger::NamedTerm;

impl Node for ReducedNode {
    fn describe(&self) -> Description {
        let model = &self.model;
        let term = |(role, name, _): NamedTerm| Term {
            name: name.into(),
            role,
        };
        Description {
            kind: "fem".into(),
            software: format!("fem-node {}", env!("CARGO_PKG_VERSION")),
            capabilities: Capabilities {
                rollback: true,
                advance: true,
                columns: true,
                alone: true,
                resume: true,
                ..Capabilities::default()
            },
            step_s: Some(model.scheme.step),
            step_limit_s: Some(model.step_limit),
            step_limit_name: limit_name(model.scheme.stiffness_damping).into(),
            end_s: model.end,
            phases: phases_of(model),
            moments: model.moments.clone(),
            sets: coupling_sets(model),
            signals: self.signals().into_iter().map(|(name, _)| name).collect(),
            ledger: self.terms().map(term).collect(),
            warnings: model.warnings.clone(),
            first_period_s: Some(model.first_period()),
            outward: outward_normals(model),
            period_m: periods(model),
            ..Description::default()
        }
    }

    fn couple(&mut self, set: &str) -> Result<Surface, NodeError> {
        self.reselect();
        Ok(self.interface.couple(&self.model, set)?)
    }

    fn select(&mut self, points: &[usize]) -> Result<(), NodeError> {
        self.reselect();
        Ok(self.interface.select(&self.model, points)?)
    }

    fn columns(&mut self, window: &Window) -> Result<Vec<f64>, NodeError> {
        self.prepare(window.substeps)?;
        Ok(self.windows[&window.substeps].field.near.clone())
    }

    fn advance(&mut self, window: &Window, force: &[f64]) -> Result<Vec<f64>, NodeError> {
        Ok(self.try_window(window, force)?)
    }

    fn commit(&mut self, window: &Window, displacement: &[f64]) -> Result<Vec<f64>, NodeError> {
        if !displacement.is_empty() {
            let (window, count) = (window.index, displacement.len());
            return Err(FemError::Dictated { window, count }.into());
        }
        self.try_commit(window)?;
        Ok(self.report())
    }

    fn advance_alone(&mut self, window: &Window) -> Result<Vec<f64>, NodeError> {
        let none = vec![0.0; self.interface.components.len()];
        self.advance(window, &none)?;
        self.commit(window, &[])
    }

    fn checkpoint(&mut self) -> Result<Vec<u8>, NodeError> {
        self.surface();
        pack(&(&self.committed, self.state_hash()))
    }

    fn restore(&mut self, state: &[u8]) -> Result<(), NodeError> {
        let (committed, hash): (ReducedCommitted, String) = unpack(state)?;
        if !self.surface().fits(&committed.state) {
            return foreign("its modes or its exchanged points differ");
        }
        self.committed = committed;
        (self.pending, self.free) = (None, None);
        if self.state_hash() != hash {
            return foreign("the hash of its numbers differs");
        }
        Ok(())
    }

    fn snapshot(&mut self, name: &str) -> Result<(), NodeError> {
        Ok(self.try_snapshot(name)?)
    }

    fn finish(&mut self) -> Result<Outcome, NodeError> {
        let last = self.recovered();
        let windows = self.committed.mode_windows as f64;
        Ok(Outcome {
            steps: self.committed.steps_done,
            work: BTreeMap::from([("mode_windows".into(), windows)]),
            results: self.results(&last),
            state_hash: self.state_hash(),
            findings: self.findings(&last),
            ..Outcome::default()
        })
    }
}
