//! Pieces of columns that threads step side by side for a whole window.
//!
//! Each piece has copies of as many columns beside its own as the window has steps. What it computes there is spoilt from the
//! cut on, one column with each step, and its own columns never are: no thread waits for another before the end of the window.
//! The numbers are those of the whole body, to the bit.

use std::ops::Range;
use std::sync::Arc;

use super::extent::WindowInput;
use super::team::Team;
use crate::committed::Committed;
use crate::element::{Body, Layout};
use crate::integrate::{BLOCK, Dissipated, Integrator, Load, Region, Ring, State, Tally, Tape};
use crate::model::Model;

/// Steps of elements in a window for each thread, below which waking it costs more than it saves.
const WORTH_WAKING: u64 = 25_000;

/// Largest share of its own columns that a piece may have besides, on average over the window.
const OVERLAP_MAX: f64 = 0.4;

/// Pieces of a body.
#[derive(Clone, Debug)]
pub(super) struct Pieces {
    pieces: Vec<Piece>,
    /// Region whose rings the pieces record.
    region: Option<Arc<Region>>,
}

#[derive(Clone, Debug)]
struct Piece {
    body: Body,
    integrator: Integrator,
    /// Columns of nodes of the body that only this piece has.
    own: Range<usize>,
    /// The same with the overlap.
    columns: Range<usize>,
    state: State,
    load: Load,
    dissipated: Dissipated<Vec<f64>>,
    tally: Tally,
    /// Rings in its own columns, as the piece counts components, and as the body does.
    rings: Vec<[Ring; 2]>,
    tape: Tape,
}

impl Pieces {
    /// One piece for each thread, where that pays; none for a body that needs more than neighbours in a step.
    pub(super) fn new(model: &Model, substeps: u32, threads: usize) -> Option<Pieces> {
        let layout = model.body.layout;
        let structured = model.body.connectivity.is_none() && !layout.is_periodic();
        let followed = !model.tractions.is_empty() || !model.motions.is_empty();
        if !structured || followed || model.wheel.is_some() || model.plastic().is_some() {
            return None;
        }
        let work = u64::from(substeps) * model.mesh.elements() as u64;
        let threads = threads.min((work / WORTH_WAKING) as usize);
        Pieces::in_parts(model, substeps, threads)
    }

    /// So many pieces for windows of up to so many steps, unless they would overlap too much.
    pub(super) fn in_parts(model: &Model, substeps: u32, count: usize) -> Option<Pieces> {
        let nodes = model.body.layout.nodes_in_row;
        let size = nodes.div_ceil(count.max(1)).next_multiple_of(BLOCK);
        if count < 2 || f64::from(substeps) > OVERLAP_MAX * size as f64 {
            return None;
        }
        let cut = |first: usize| Piece::new(model, first..(first + size).min(nodes), substeps);
        Some(Pieces {
            pieces: (0..nodes).step_by(size).map(cut).collect(),
            region: None,
        })
    }

    /// Runs a window, recording the rings of the region.
    pub(super) fn run(
        &mut self,
        team: &Team,
        model: &Model,
        committed: &Committed,
        input: &WindowInput,
        region: Option<&Arc<Region>>,
    ) {
        let same = match (&self.region, region) {
            (Some(known), Some(region)) => Arc::ptr_eq(known, region),
            (known, region) => known.is_none() && region.is_none(),
        };
        if !same {
            self.region = region.cloned();
            for piece in &mut self.pieces {
                piece.follow(model.body.layout, region);
            }
        }
        team.side_by_side(&mut self.pieces, |piece| piece.run(model, committed, input));
    }

    /// Takes the ends of all pieces over.
    pub(super) fn fill(
        &self,
        layout: Layout,
        state: &mut State,
        dissipated: &mut Dissipated<Vec<f64>>,
        tally: &mut Tally,
    ) {
        for piece in &self.pieces {
            state.damping_force.resize(piece.damping_len(layout), 0.0);
            let [numerical, mass, stiffness] = dissipated.nodal_mut();
            let [its_numerical, its_mass, its_stiffness] = piece.dissipated.nodal();
            let [u, v, a, force, damping_force] = state.nodal_mut();
            let fields = [
                (u, &piece.state.u),
                (v, &piece.state.v),
                (a, &piece.state.a),
                (force, &piece.state.force),
                (damping_force, &piece.state.damping_force),
                (numerical, its_numerical),
                (mass, its_mass),
                (stiffness, its_stiffness),
            ];
            for (field, its) in fields {
                piece.put(layout, field, its);
            }
            let (first, its) = (piece.columns.start, piece.body.layout);
            tally.take(layout, (&piece.tally, its), &piece.own, first);
        }
    }

    /// Reads the ring beyond the front of step `k` of a repeat.
    pub(super) fn read(
        &mut self,
        k: u32,
        state: &mut State,
        dissipated: &mut Dissipated<Vec<f64>>,
    ) {
        for Piece { rings, tape, .. } in &mut self.pieces {
            let [_, ring] = &rings[k as usize - 1];
            // No piece is of a law with history.
            tape.read(ring, state, dissipated, &mut Vec::new());
        }
    }

    /// Begins to read.
    pub(super) fn rewind(&mut self) {
        self.pieces.iter_mut().for_each(|piece| piece.tape.rewind());
    }
}

impl Piece {
    fn new(model: &Model, own: Range<usize>, substeps: u32) -> Piece {
        let layout = model.body.layout;
        // A column beside those that are spoilt is read at the first step.
        let overlap = (substeps as usize + 1).next_multiple_of(BLOCK);
        let columns =
            own.start.saturating_sub(overlap)..(own.end + overlap).min(layout.nodes_in_row);
        let body = model.body.piece(&columns);
        let elements = body.layout.columns * body.layout.rows;
        Piece {
            integrator: Integrator::new(&body, model.scheme, model.law, elements, 1),
            state: State::at_rest(&body),
            load: Load::none(&body),
            dissipated: Dissipated::new(body.layout, model.dissipates()),
            tally: Tally::default(),
            rings: Vec::new(),
            tape: Tape::default(),
            own,
            columns,
            body,
        }
    }

    /// Records the rings of this region from now on.
    fn follow(&mut self, layout: Layout, region: Option<&Arc<Region>>) {
        let rings = region.into_iter().flat_map(|region| &region.rings);
        let (its, first) = (self.body.layout, self.columns.start);
        let own = rings.map(|ring| ring.within(layout, &self.own));
        let both = own.map(|ring| [ring.in_piece(layout, its, first), ring]);
        self.rings = both.collect();
    }

    fn run(&mut self, model: &Model, committed: &Committed, input: &WindowInput) {
        self.begin(model, committed, input);
        for k in 1..=input.substeps {
            let step = committed.steps + u64::from(k) - 1;
            self.integrator.damping = model.damping_over(step);
            let good = self.good_until(model.body.layout, input.substeps - k);
            let (state, dissipated) = (&mut self.state, &mut self.dissipated);
            let integrator = &mut self.integrator;
            integrator.step_columns(&self.body, state, &self.load, dissipated, good);
            if let Some([ring, _]) = self.rings.get(k as usize - 1) {
                self.tape.record_end(ring, &self.state, &self.dissipated);
            }
        }
        self.tally.all(&self.body, &self.state, &self.dissipated);
    }

    /// Columns of the piece that must still be right when so many steps are left.
    fn good_until(&self, layout: Layout, left: u32) -> [usize; 2] {
        let first = self.own.start.saturating_sub(left as usize);
        let end = (self.own.end + left as usize).min(layout.nodes_in_row);
        let start = self.columns.start;
        [first.max(start) - start, end.min(self.columns.end) - start]
    }

    /// The committed state under the forces of the window.
    fn begin(&mut self, model: &Model, committed: &Committed, input: &WindowInput) {
        let (layout, start) = (model.body.layout, &committed.state);
        self.state
            .damping_force
            .resize(start.damping_force.len().min(self.body.layout.len()), 0.0);
        let fields = [
            (&mut self.state.u, &start.u),
            (&mut self.state.v, &start.v),
            (&mut self.state.force, &start.force),
            (&mut self.state.damping_force, &start.damping_force),
        ];
        let stride = self.body.layout.stride;
        for (field, start) in fields {
            for (row, start) in field.chunks_mut(stride).zip(start.chunks(layout.stride)) {
                row[..self.columns.len()].copy_from_slice(&start[self.columns.clone()]);
            }
        }
        self.load.clear();
        for (index, force) in &input.interface {
            let column = index % layout.stride;
            if self.columns.contains(&column) {
                let line = index / layout.stride * stride;
                self.load.add(line + column - self.columns.start, *force);
            }
        }
        self.dissipated.clear();
        self.tape.clear();
        let damping = model.damping_at(committed.steps);
        self.state.accelerate(&self.body, damping, &self.load);
        self.tally.begin(&self.body, &self.state.a);
    }

    /// Writes its own columns of a field.
    fn put(&self, layout: Layout, field: &mut [f64], its: &[f64]) {
        let first = self.own.start - self.columns.start;
        let its = its.chunks(self.body.layout.stride);
        for (row, its) in field.chunks_mut(layout.stride).zip(its) {
            row[self.own.clone()].copy_from_slice(&its[first..first + self.own.len()]);
        }
    }

    /// Length of the damping force of the body, empty where the piece has none.
    fn damping_len(&self, layout: Layout) -> usize {
        if self.state.damping_force.is_empty() {
            0
        } else {
            layout.len()
        }
    }
}
