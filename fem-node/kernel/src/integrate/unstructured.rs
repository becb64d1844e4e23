//! A step of an unstructured mesh: predict all nodes, compute all elements, sum the forces of each node, finish.
//!
//! Pieces of a fixed size are shared among the threads, and their sums are added in the order of the pieces, so that the
//! bits do not depend on the number of threads.

use std::ops::Range;
use std::sync::Arc;

use rayon::prelude::*;

use super::dissipation::{Dissipated, cut};
use super::fields::StepFields;
use super::front::PartOfNodes;
use super::node_row::NodeRow;
use super::state::NodalState;
use crate::element::body::{Body, ElementRow};
use crate::element::gather::{CORNER_FORCES, GatherBuffers, NodalFields, sum_corners};
use crate::material::nonlinear::NonlinearLaw;
use crate::mesh::connectivity::Connectivity;
use crate::scheme::{NewmarkScheme, Rule};
use crate::wheel::rigid::Wheel;
use crate::wheel::run::WheelRun;
use crate::wheel::upper_row::UpperRow;

/// Nodes in a piece: large compared with the cost of handing it out, small enough for several pieces per thread.
const NODES: usize = 1024;

/// Rows of elements in a piece.
const ROWS: usize = 8;

/// Buffers for a step of the whole body.
#[derive(Clone, Debug)]
pub(super) struct Unstructured {
    connectivity: Arc<Connectivity>,
    /// Buffers of each piece of elements; none is shared between threads.
    buffers: Vec<GatherBuffers>,
    corners: Vec<f64>,
    /// Internal forces at the end of the step.
    new_force: Vec<f64>,
    /// Accelerations at its end.
    new_a: Vec<f64>,
    /// Loads less the stiffness damping; empty until there is any.
    net: Vec<f64>,
    /// Increments of the displacements; empty under a law without history.
    increment: Vec<f64>,
    law: Option<NonlinearLaw>,
    /// History variables of a row of elements.
    row_history: usize,
    parallel: bool,
}

impl Unstructured {
    pub(super) fn new(
        body: &Body,
        connectivity: &Arc<Connectivity>,
        law: Option<NonlinearLaw>,
        strips: usize,
    ) -> Unstructured {
        let layout = body.layout;
        let pieces = layout.rows.div_ceil(ROWS);
        let zero = vec![0.0; layout.len()];
        let row_history = body.history_row_len(law.as_ref());
        Unstructured {
            connectivity: connectivity.clone(),
            buffers: vec![GatherBuffers::new(layout, row_history > 0); pieces],
            corners: vec![0.0; CORNER_FORCES * body.elements()],
            increment: vec![0.0; if row_history > 0 { zero.len() } else { 0 }],
            new_force: zero.clone(),
            new_a: zero,
            net: Vec::new(),
            law,
            row_history,
            parallel: strips > 1,
        }
    }

    pub(super) fn step(
        &mut self,
        body: &Body,
        rule: &Rule,
        fields: &mut StepFields,
        wheel: Option<(&Wheel, &mut WheelRun)>,
    ) {
        let (state, dissipated) = (&mut fields.state, &mut fields.dissipated);
        self.predict(&rule.scheme, state);
        self.elements(body, state, &mut dissipated.plastic);
        self.sum(body);
        let mut load = fields.load.row(0);
        if !state.damping_force.is_empty() {
            self.net.resize(load.len(), 0.0);
            let net = &mut self.net;
            let new = (&self.new_force[..], &mut self.new_a[..]);
            let rows = node_rows(body, state, new, load, net, dissipated.whole());
            each(self.parallel, rows, |mut row| {
                let all = 0..row.new_force.len();
                row.damp_stiffness(&rule.scheme, &[all]);
            });
            load = &self.net;
        }
        if let Some((wheel, run)) = wheel {
            let upper = UpperRow {
                u: &state.u,
                v: &state.v,
                a: &state.a,
                force: &self.new_force,
                load,
                inverse_mass: &body.inverse_mass,
            };
            run.close(wheel, rule, &upper);
            load = &run.load;
        }
        let new = (&self.new_force[..], &mut self.new_a[..]);
        let rows = node_rows(body, state, new, load, &mut [], dissipated.whole());
        each(self.parallel, rows, |mut row| {
            let all = 0..row.new_force.len();
            row.finish(rule, body.layout, &[all]);
        });
    }

    /// One step of a part of the body.
    pub(super) fn step_part(
        &mut self,
        body: &Body,
        rule: &Rule,
        fields: &mut StepFields,
        (part, increments): (&PartOfNodes, &[f64]),
    ) {
        let (state, dissipated) = (&mut fields.state, &mut fields.dissipated);
        let load = fields.load.row(0);
        let layout = body.layout;
        self.increment.copy_from_slice(increments);
        for k in part.components(layout.stride) {
            let increment = rule.scheme.increment(state.v[k], state.a[k]);
            if let Some(kept) = self.increment.get_mut(k) {
                *kept = increment;
            }
            state.u[k] += increment;
        }
        let (law, size) = (self.law.as_ref(), self.row_history);
        let (columns, padded) = (layout.columns, layout.padded_columns());
        let fields = NodalFields {
            u: &state.u,
            du: &self.increment,
        };
        for row in &part.rows {
            let history = state.history.get_mut(row * size..(row + 1) * size);
            let plastic = dissipated.plastic.get_mut(row * padded..(row + 1) * padded);
            let own = ElementRow {
                history: history.unwrap_or_default(),
                dissipated: plastic.unwrap_or_default(),
            };
            let first = row * columns * CORNER_FORCES;
            let end = (first + columns * CORNER_FORCES).min(self.corners.len());
            let out = &mut self.corners[first..end];
            body.gathered_row(law, *row, fields, &mut self.buffers[0], own, out);
        }
        let (x, y) = self.new_force.split_at_mut(layout.stride);
        for nodes in &part.nodes {
            let own = [&mut x[nodes.clone()], &mut y[nodes.clone()]];
            sum_corners(&self.connectivity, &self.corners, nodes.start, own);
        }
        let spans: Vec<Range<usize>> = part.spans(layout.stride).collect();
        self.net.resize(load.len(), 0.0);
        let mut row = NodeRow {
            v: &mut state.v,
            a: &mut state.a,
            force: &mut state.force,
            new_force: &self.new_force,
            new_a: &mut self.new_a,
            load,
            mass: &body.mass,
            inverse_mass: &body.inverse_mass,
            damping_force: &mut state.damping_force,
            net: &mut self.net,
            dissipated: dissipated.whole(),
        };
        row.damp_stiffness(&rule.scheme, &spans);
        row.finish(rule, layout, &spans);
    }

    fn predict(&mut self, scheme: &NewmarkScheme, state: &mut NodalState) {
        for (increment, (v, a)) in self.increment.iter_mut().zip(state.v.iter().zip(&state.a)) {
            *increment = scheme.increment(*v, *a);
        }
        let pieces = state.v.chunks(NODES).zip(state.a.chunks(NODES));
        let pieces: Vec<_> = pieces.zip(state.u.chunks_mut(NODES)).collect();
        each(self.parallel, pieces, |((v, a), u)| {
            for (u, (v, a)) in u.iter_mut().zip(v.iter().zip(a)) {
                *u = scheme.predicted(*u, *v, *a);
            }
        });
    }

    fn elements(&mut self, body: &Body, state: &mut NodalState, mut dissipated: &mut [f64]) {
        let layout = body.layout;
        let columns = layout.columns;
        let size = (self.row_history, layout.padded_columns());
        let mut histories = state.history.as_mut_slice();
        let outs = self.corners.chunks_mut(ROWS * columns * CORNER_FORCES);
        let pieces = self.buffers.iter_mut().zip(outs).map(|(buffers, out)| {
            let own = ElementRow {
                history: cut(&mut histories, ROWS * size.0),
                dissipated: cut(&mut dissipated, ROWS * size.1),
            };
            (buffers, out, own)
        });
        let pieces: Vec<_> = pieces.enumerate().collect();
        let fields = NodalFields {
            u: &state.u,
            du: &self.increment,
        };
        let law = self.law.as_ref();
        each(self.parallel, pieces, |(piece, (buffers, out, mut own))| {
            for (k, out) in out.chunks_mut(columns * CORNER_FORCES).enumerate() {
                let row = ElementRow {
                    history: cut(&mut own.history, size.0),
                    dissipated: cut(&mut own.dissipated, size.1),
                };
                body.gathered_row(law, piece * ROWS + k, fields, buffers, row, out);
            }
        });
    }

    fn sum(&mut self, body: &Body) {
        let (x, y) = self.new_force.split_at_mut(body.layout.stride);
        let pieces = x.chunks_mut(NODES).zip(y.chunks_mut(NODES)).enumerate();
        let (connectivity, corners) = (&self.connectivity, &self.corners);
        each(self.parallel, pieces.collect(), |(piece, (x, y))| {
            sum_corners(connectivity, corners, piece * NODES, [x, y]);
        });
    }
}

/// Pieces of the nodes, with the stiffness damping only where `net` is not empty.
fn node_rows<'a>(
    body: &'a Body,
    state: &'a mut NodalState,
    (new_force, new_a): (&'a [f64], &'a mut [f64]),
    load: &'a [f64],
    mut net: &'a mut [f64],
    mut dissipated: Dissipated<&'a mut [f64]>,
) -> Vec<NodeRow<'a>> {
    let damped = if net.is_empty() { 0 } else { load.len() };
    let mut damping = &mut state.damping_force[..damped];
    let rates = state.v.chunks_mut(NODES).zip(state.a.chunks_mut(NODES));
    let fields = rates.zip(state.force.chunks_mut(NODES));
    let fields = fields.zip(new_force.chunks(NODES).zip(new_a.chunks_mut(NODES)));
    let pieces = fields
        .enumerate()
        .map(|(k, (((v, a), force), (new_force, new_a)))| {
            let range = k * NODES..k * NODES + v.len();
            NodeRow {
                v,
                a,
                force,
                new_force,
                new_a,
                load: &load[range.clone()],
                mass: &body.mass[range.clone()],
                inverse_mass: &body.inverse_mass[range],
                damping_force: cut(&mut damping, NODES),
                net: cut(&mut net, NODES),
                dissipated: dissipated.cut(NODES, 0),
            }
        });
    pieces.collect()
}

/// Does the work of every piece, on one thread or on all of them.
fn each<T: Send>(parallel: bool, pieces: Vec<T>, work: impl Fn(T) + Sync + Send) {
    if parallel {
        pieces.into_par_iter().for_each(work);
    } else {
        pieces.into_iter().for_each(work);
    }
}
