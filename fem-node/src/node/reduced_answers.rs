//! Answers of a reduced body to a coupler.

use std::collections::BTreeMap;

use protocol::checkpoint::{pack, unpack};
use protocol::{Capabilities, Description, Node, NodeError, Outcome, Surface, Window};

use super::checkpoint::foreign;
use super::reduced_node::{ReducedCommitted, ReducedNode};
use super::report::{described, reported};
use crate::error::FemError;

impl Node for ReducedNode {
    fn describe(&self) -> Description {
        Description {
            capabilities: Capabilities {
                rollback: true,
                advance: true,
                columns: true,
                alone: true,
                resume: true,
                heat: self.model.heat.is_some(),
                ..Capabilities::default()
            },
            late_far_field: !(self.near.0).is_some_and(|reach| reach >= self.model.size),
            ..described(&self.model, self.signals(), self.terms())
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
        Ok(reported(self.signals(), self.terms()))
    }

    fn advance_alone(&mut self, window: &Window) -> Result<Vec<f64>, NodeError> {
        let none = vec![0.0; self.interface.components.len()];
        self.advance(window, &none)?;
        self.commit(window, &[])
    }

    fn take_heat(&mut self, _window: &Window, heat: &[f64]) -> Result<Vec<f64>, NodeError> {
        let of = self.model.heat.as_ref().ok_or(FemError::NoHeat)?;
        let time = (self.committed.steps, self.model.scheme.step);
        let nodes = (&*self.interface.exchanged, heat);
        Ok(of.exchange(&mut self.committed.heat, nodes, time))
    }

    fn checkpoint(&mut self) -> Result<Vec<u8>, NodeError> {
        self.surface()?;
        pack(&(&self.committed, self.state_hash()))
    }

    fn restore(&mut self, state: &[u8]) -> Result<(), NodeError> {
        let (committed, hash): (ReducedCommitted, String) = unpack(state)?;
        if !self.surface()?.fits(&committed.state) {
            return foreign("its modes or its exchanged points differ");
        }
        self.committed = committed;
        (self.pending, self.free, self.far) = (None, None, None);
        self.suspected = false;
        if self.state_hash() != hash {
            return foreign("the hash of its numbers differs");
        }
        // Results describe the longest window.
        if self.committed.longest > 0 {
            self.prepare(self.committed.longest)?;
        }
        Ok(())
    }

    fn snapshot(&mut self, name: &str) -> Result<(), NodeError> {
        Ok(self.try_snapshot(name)?)
    }

    fn finish(&mut self) -> Result<Outcome, NodeError> {
        let (last, state_hash) = (self.recovered()?, self.state_hash());
        let time = (self.committed.steps, self.model.scheme.step);
        if let Some(heat) = &self.model.heat {
            heat.end(&mut self.committed.heat, time);
        }
        let windows = self.committed.mode_windows as f64;
        Ok(Outcome {
            steps: self.committed.steps_done,
            work: BTreeMap::from([("mode_windows".into(), windows)]),
            results: self.results(&last),
            state_hash,
            findings: self.findings(&last),
            warnings: self.kept.warnings.clone(),
            ..Outcome::default()
        })
    }
}
