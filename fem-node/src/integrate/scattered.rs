//! A step of a mesh that is no block: predict all nodes, compute all elements, sum the forces of each node, finish.
//!
//! Pieces of a fixed size are shared among the threads, and what they add up is added in the order of the pieces, so
//! that the bits do not depend on who computed what.

use rayon::prelude::*;

use super::block::UpperRow;
use super::load::Load;
use super::row::{Resisting, Row, RowSums};
use super::scheme::{Rule, Scheme};
use super::state::State;
use crate::element::{Body, CORNER_FORCES, Gathered, Nodal};
use crate::material::point::PointLaw;
use crate::wheel::{Wheel, WheelRun};

/// Nodes in a piece: large against the cost of handing it out, small enough for some pieces a thread.
const NODES: usize = 1024;

/// Rows of elements in a piece.
const ROWS: usize = 8;

/// Room for a step of the whole body.
#[derive(Clone, Debug)]
pub(super) struct Scattered {
    /// One for each piece of elements; none is shared between threads.
    rooms: Vec<Gathered>,
    /// Dissipated by each piece of elements in this step (J).
    dissipated: Vec<f64>,
    corners: Vec<f64>,
    force: Vec<f64>,
    acceleration: Vec<f64>,
    /// Loads less the stiffness damping; empty until there is any.
    net: Vec<f64>,
    /// Increments of the displacements; empty where the points do not remember.
    increment: Vec<f64>,
    law: Option<PointLaw>,
    /// Numbers that a row of elements remembers.
    remembered: usize,
    parallel: bool,
}

impl Scattered {
    pub(super) fn new(body: &Body, blocks: usize) -> Scattered {
        let pieces = body.layout().element_rows().div_ceil(ROWS);
        let zero = vec![0.0; body.layout().len()];
        Scattered {
            rooms: vec![Gathered::new(body.layout()); pieces],
            dissipated: vec![0.0; pieces],
            corners: vec![0.0; body.corner_forces_len()],
            force: zero.clone(),
            acceleration: zero,
            net: Vec::new(),
            increment: Vec::new(),
            law: None,
            remembered: 0,
            parallel: blocks > 1,
        }
    }

    pub(super) fn under(mut self, body: &Body, law: &PointLaw) -> Scattered {
        let layout = body.layout();
        let rooms = self.rooms.into_iter();
        self.rooms = rooms.map(|room| room.remembering(layout, law)).collect();
        if law.plastic.is_some() {
            self.increment = vec![0.0; layout.len()];
        }
        self.remembered = body.history_row_len(law);
        self.law = Some(*law);
        self
    }

    pub(super) fn step(
        &mut self,
        body: &Body,
        rule: &Rule,
        (state, load, sums): (&mut State, &Load, &mut RowSums),
        wheel: Option<(&Wheel, &mut WheelRun)>,
    ) {
        self.predict(&rule.scheme, state);
        self.elements(body, state);
        sums.plastic += self.dissipated.iter().sum::<f64>();
        self.sum(body);
        let mut net = std::mem::take(&mut self.net);
        let mut load = load.row(0);
        if !state.resistance.is_empty() {
            net.resize(load.len(), 0.0);
            self.resist(&rule.scheme, (state, load, sums), &mut net);
            load = &net;
        }
        match wheel {
            None => self.finish(body, rule, (state, load, sums)),
            Some((wheel, run)) => {
                let upper = UpperRow {
                    u: &state.u,
                    v: &state.v,
                    a: &state.a,
                    force: &self.force,
                    load,
                    inverse_mass: &body.inverse_mass,
                };
                run.close(wheel, (&rule.scheme, rule.damping), &upper);
                self.finish(body, rule, (state, run.load(), sums));
            }
        }
        self.net = net;
    }

    /// Stiffness damping, as in the rows of a block; `net` gets the load less its force.
    fn resist(
        &self,
        scheme: &Scheme,
        (state, load, sums): (&mut State, &[f64], &mut RowSums),
        net: &mut [f64],
    ) {
        let rates = state.v.chunks(NODES).zip(state.a.chunks(NODES));
        let forces = state.force.chunks(NODES).zip(self.force.chunks(NODES));
        let loads = load.chunks(NODES).zip(state.resistance.chunks_mut(NODES));
        let rows = rates.zip(forces).zip(loads).zip(net.chunks_mut(NODES));
        let mut works: Vec<f64> = vec![0.0; load.len().div_ceil(NODES)];
        let pieces = rows.zip(&mut works);
        let pieces = pieces.map(
            |(((((v, a), (force, new_force)), (load, resistance)), net), work)| {
                let row = Resisting {
                    v,
                    a,
                    force,
                    new_force,
                    load,
                    resistance,
                };
                (row, net, work)
            },
        );
        each(self.parallel, pieces.collect(), |(mut row, net, work)| {
            *work = row.resist(scheme, net);
        });
        sums.resistance += works.iter().sum::<f64>();
    }

    fn predict(&mut self, scheme: &Scheme, state: &mut State) {
        let rates = |v: &[f64], a: &[f64], u: &mut [f64]| {
            for (u, (v, a)) in u.iter_mut().zip(v.iter().zip(a)) {
                *u = scheme.predicted(*u, *v, *a);
            }
        };
        for (increment, (v, a)) in self.increment.iter_mut().zip(state.v.iter().zip(&state.a)) {
            *increment = scheme.increment(*v, *a);
        }
        let pieces = state.v.chunks(NODES).zip(state.a.chunks(NODES));
        let pieces: Vec<_> = pieces.zip(state.u.chunks_mut(NODES)).collect();
        each(self.parallel, pieces, |((v, a), u)| rates(v, a, u));
    }

    fn elements(&mut self, body: &Body, state: &mut State) {
        let columns = body.layout().element_columns();
        let mut histories = state.history.chunks_mut((ROWS * self.remembered).max(1));
        let outs = self.corners.chunks_mut(ROWS * columns * CORNER_FORCES);
        let rooms = self.rooms.iter_mut().zip(&mut self.dissipated).zip(outs);
        let pieces: Vec<_> = rooms
            .map(|((room, heat), out)| (room, heat, out, histories.next().unwrap_or_default()))
            .enumerate()
            .collect();
        let nodal = Nodal {
            u: &state.u,
            du: &self.increment,
        };
        let (law, remembered) = (self.law.as_ref(), self.remembered);
        each(
            self.parallel,
            pieces,
            |(piece, (room, heat, out, history))| {
                let mut histories = history.chunks_mut(remembered.max(1));
                *heat = 0.0;
                for (k, out) in out.chunks_mut(columns * CORNER_FORCES).enumerate() {
                    let history = histories.next().unwrap_or_default();
                    *heat += body.gathered_row(law, piece * ROWS + k, nodal, (room, history), out);
                }
            },
        );
    }

    fn sum(&mut self, body: &Body) {
        let (x, y) = self.force.split_at_mut(body.layout().stride());
        let pieces = x.chunks_mut(NODES).zip(y.chunks_mut(NODES)).enumerate();
        let corners = &self.corners;
        each(self.parallel, pieces.collect(), |(piece, (x, y))| {
            body.sum_corners(corners, piece * NODES, [x, y]);
        });
    }

    /// Accelerations, energies and velocities, as in the rows of a block.
    fn finish(
        &mut self,
        body: &Body,
        rule: &Rule,
        (state, load, sums): (&mut State, &[f64], &mut RowSums),
    ) {
        let rates = state.v.chunks_mut(NODES).zip(state.a.chunks_mut(NODES));
        let news = self
            .force
            .chunks(NODES)
            .zip(self.acceleration.chunks_mut(NODES));
        let masses = body.mass.chunks(NODES).zip(body.inverse_mass.chunks(NODES));
        let fields = rates.zip(state.force.chunks_mut(NODES)).zip(news);
        let rows = fields.zip(load.chunks(NODES)).zip(masses);
        let mut rows: Vec<(Row, RowSums)> = rows
            .map(
                |(((((v, a), force), (new_force, new_a)), load), (mass, inverse_mass))| {
                    let row = Row {
                        v,
                        a,
                        force,
                        new_force,
                        new_a,
                        load,
                        mass,
                        inverse_mass,
                    };
                    (row, RowSums::default())
                },
            )
            .collect();
        each(self.parallel, rows.iter_mut().collect(), |(row, sums)| {
            row.finish(rule, body.layout(), sums);
        });
        for (_, piece) in rows {
            sums.rotation += piece.rotation;
            sums.damping += piece.damping;
        }
    }
}

/// Does the work of every piece, on one thread or on all of them.
fn each<T: Send>(parallel: bool, pieces: Vec<T>, work: impl Fn(T) + Sync + Send) {
    match parallel {
        true => pieces.into_par_iter().for_each(work),
        false => pieces.into_iter().for_each(work),
    }
}
