//! A step of an unstructured mesh: predict all nodes, compute all elements, sum the forces of each node, finish.
//!
//! Pieces of a fixed size are shared among the threads, and their sums are added in the order of the pieces, so that the
//! bits do not depend on the number of threads.

use std::sync::Arc;

use rayon::prelude::*;

use super::load::Load;
use super::node_row::{NodeRow, RowEnergies};
use super::scheme::{Rule, Scheme};
use super::state::State;
use super::upper_row::UpperRow;
use crate::element::{Body, CORNER_FORCES, GatherBuffers, NodalFields, sum_corners};
use crate::material::nonlinear::NonlinearLaw;
use crate::mesh::Connectivity;
use crate::wheel::{Wheel, WheelRun};

/// Nodes in a piece: large against the cost of handing it out, small enough for some pieces a thread.
const NODES: usize = 1024;

/// Rows of elements in a piece.
const ROWS: usize = 8;

/// Buffers for a step of the whole body.
#[derive(Clone, Debug)]
pub(super) struct Unstructured {
    connectivity: Arc<Connectivity>,
    /// Buffers of each piece of elements; none is shared between threads.
    buffers: Vec<GatherBuffers>,
    /// Dissipation of each piece of elements in this step (J).
    dissipated: Vec<f64>,
    corners: Vec<f64>,
    new: NewFields,
    /// Loads less the stiffness damping; empty until there is any.
    net: Vec<f64>,
    /// Increments of the displacements; empty under a law without history.
    increment: Vec<f64>,
    law: Option<NonlinearLaw>,
    /// History variables of a row of elements.
    row_history: usize,
    parallel: bool,
}

/// Internal forces and accelerations at the end of the step.
#[derive(Clone, Debug)]
struct NewFields {
    force: Vec<f64>,
    acceleration: Vec<f64>,
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
        let row_history = law.map_or(0, |law| body.history_row_len(&law));
        Unstructured {
            connectivity: connectivity.clone(),
            buffers: vec![GatherBuffers::new(layout, row_history > 0); pieces],
            dissipated: vec![0.0; pieces],
            corners: vec![0.0; body.corner_forces_len()],
            increment: if row_history > 0 {
                zero.clone()
            } else {
                Vec::new()
            },
            new: NewFields {
                force: zero.clone(),
                acceleration: zero,
            },
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
        state: &mut State,
        load: &Load,
        energies: &mut RowEnergies,
        wheel: Option<(&Wheel, &mut WheelRun)>,
    ) {
        self.predict(&rule.scheme, state);
        self.elements(body, state);
        energies.plastic += self.dissipated.iter().sum::<f64>();
        self.sum(body);
        let mut load = load.row(0);
        if !state.damping_force.is_empty() {
            self.net.resize(load.len(), 0.0);
            let rows = node_rows(body, state, &mut self.new, load, &mut self.net);
            let damp = |row: &mut NodeRow, energies: &mut RowEnergies| {
                row.damp_stiffness(&rule.scheme, energies);
            };
            over_rows(self.parallel, rows, energies, damp);
            load = &self.net;
        }
        if let Some((wheel, run)) = wheel {
            let upper = UpperRow {
                u: &state.u,
                v: &state.v,
                a: &state.a,
                force: &self.new.force,
                load,
                inverse_mass: &body.inverse_mass,
            };
            run.close(wheel, rule, &upper);
            load = run.load();
        }
        let rows = node_rows(body, state, &mut self.new, load, &mut []);
        let finish = |row: &mut NodeRow, energies: &mut RowEnergies| {
            row.finish(rule, body.layout, energies);
        };
        over_rows(self.parallel, rows, energies, finish);
    }

    fn predict(&mut self, scheme: &Scheme, state: &mut State) {
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

    fn elements(&mut self, body: &Body, state: &mut State) {
        let columns = body.layout.columns;
        let mut histories = state.history.chunks_mut((ROWS * self.row_history).max(1));
        let outs = self.corners.chunks_mut(ROWS * columns * CORNER_FORCES);
        let buffers = self.buffers.iter_mut().zip(&mut self.dissipated).zip(outs);
        let pieces: Vec<_> = buffers
            .map(|((buffers, sum), out)| (buffers, sum, out, histories.next().unwrap_or_default()))
            .enumerate()
            .collect();
        let fields = NodalFields {
            u: &state.u,
            du: &self.increment,
        };
        let (law, row_history) = (self.law.as_ref(), self.row_history);
        each(
            self.parallel,
            pieces,
            |(piece, (buffers, sum, out, history))| {
                let mut histories = history.chunks_mut(row_history.max(1));
                *sum = 0.0;
                for (k, out) in out.chunks_mut(columns * CORNER_FORCES).enumerate() {
                    let history = histories.next().unwrap_or_default();
                    *sum += body.gathered_row(law, piece * ROWS + k, fields, buffers, history, out);
                }
            },
        );
    }

    fn sum(&mut self, body: &Body) {
        let (x, y) = self.new.force.split_at_mut(body.layout.stride);
        let pieces = x.chunks_mut(NODES).zip(y.chunks_mut(NODES)).enumerate();
        let (connectivity, corners) = (&self.connectivity, &self.corners);
        each(self.parallel, pieces.collect(), |(piece, (x, y))| {
            sum_corners(connectivity, corners, piece * NODES, [x, y]);
        });
    }
}

/// Pieces of the nodes; those of the stiffness damping only where `net` is not empty.
fn node_rows<'a>(
    body: &'a Body,
    state: &'a mut State,
    new: &'a mut NewFields,
    load: &'a [f64],
    net: &'a mut [f64],
) -> Vec<NodeRow<'a>> {
    let damped = if net.is_empty() { 0 } else { load.len() };
    let mut damping = state.damping_force[..damped].chunks_mut(NODES);
    let mut nets = net.chunks_mut(NODES);
    let rates = state.v.chunks_mut(NODES).zip(state.a.chunks_mut(NODES));
    let fields = rates.zip(state.force.chunks_mut(NODES));
    let accelerations = new.acceleration.chunks_mut(NODES);
    let fields = fields.zip(new.force.chunks(NODES).zip(accelerations));
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
                damping_force: damping.next().unwrap_or_default(),
                net: nets.next().unwrap_or_default(),
            }
        });
    pieces.collect()
}

/// Does the work of every piece of nodes, and adds up their energies in the order of the pieces.
fn over_rows(
    parallel: bool,
    rows: Vec<NodeRow>,
    energies: &mut RowEnergies,
    work: impl Fn(&mut NodeRow, &mut RowEnergies) + Sync + Send,
) {
    let mut rows: Vec<_> = rows
        .into_iter()
        .map(|row| (row, RowEnergies::default()))
        .collect();
    let pieces = rows.iter_mut().collect();
    each(
        parallel,
        pieces,
        |(row, energies): &mut (NodeRow, RowEnergies)| work(row, energies),
    );
    let mut sum = RowEnergies::default();
    for (_, piece) in &rows {
        energies.numerical += piece.numerical;
        energies.mass_damping += piece.mass_damping;
        sum.stiffness_damping += piece.stiffness_damping;
    }
    energies.stiffness_damping += sum.stiffness_damping;
}

/// Does the work of every piece, on one thread or on all of them.
fn each<T: Send>(parallel: bool, pieces: Vec<T>, work: impl Fn(T) + Sync + Send) {
    if parallel {
        pieces.into_par_iter().for_each(work);
    } else {
        pieces.into_iter().for_each(work);
    }
}
