//! Columns of a body that one thread steps for a whole window.

use std::ops::Range;
use std::sync::Arc;

use fem_kernel::element::body::Body;
use fem_kernel::integrate::cut::{Cut, CutRegion};
use fem_kernel::integrate::fields::StepFields;
use fem_kernel::integrate::integrator::Integrator;
use fem_kernel::integrate::region::{Region, RingRecord};
use fem_kernel::integrate::state::NodalState;
use fem_kernel::integrate::tally::{Tally, blocks_of};

use super::extent::{BodyWindow, WindowInput};
use super::start::PieceStart;
use crate::model::Model;

/// A piece with copies of neighbouring columns.
#[derive(Clone, Debug)]
pub(super) struct Piece {
    /// Its number among the pieces of the body.
    index: usize,
    pub(super) cut: Cut,
    body: Body,
    integrator: Integrator,
    /// The fields at the end of the window, valid in its own columns.
    pub(super) fields: StepFields,
    /// Sums over the blocks of its own columns.
    pub(super) tally: Tally,
    own_blocks: Vec<usize>,
    /// The part of the body's region that the piece steps in a repeat.
    region: CutRegion,
    record: RingRecord,
}

impl Piece {
    /// The piece of this number with these own columns and copies of `overlap` columns on each side.
    pub(super) fn new(model: &Model, index: usize, own: Range<usize>, overlap: usize) -> Piece {
        let layout = model.body.layout;
        let columns =
            own.start.saturating_sub(overlap)..(own.end + overlap).min(layout.nodes_in_row);
        let body = model.body.piece(&columns);
        let cut = Cut {
            own,
            columns,
            body: layout,
            piece: body.layout,
        };
        let own = (0..2 * layout.node_rows).map(|line| cut.in_line(line, &cut.own));
        let own_blocks = blocks_of(body.layout, own);
        Piece {
            index,
            integrator: Integrator::new(&body, model.scheme, model.law, 1),
            fields: StepFields::at_rest(&body, None, model.dissipates()),
            tally: Tally::sized(body.layout),
            own_blocks,
            region: CutRegion::default(),
            record: RingRecord::default(),
            cut,
            body,
        }
    }

    /// Room for the committed state in its own columns.
    pub(super) fn start(&self) -> PieceStart {
        PieceStart {
            cut: self.cut.clone(),
            state: NodalState::at_rest(&self.body),
        }
    }

    /// Records the rings of this region from now on.
    pub(super) fn follow(&mut self, region: Option<&Arc<Region>>) {
        let region = region.map(|region| CutRegion::new(region, &self.cut));
        self.region = region.unwrap_or_default();
    }

    /// Runs a window.
    pub(super) fn run(&mut self, window: BodyWindow, starts: &[PieceStart]) {
        self.begin(window, starts);
        let substeps = window.input.substeps;
        for k in 1..=substeps {
            self.damp(window, k);
            let good = self.cut.good_in_piece((substeps - k) as usize);
            let fields = &mut self.fields;
            self.integrator.step_columns(&self.body, fields, good);
            if let Some(step) = self.region.steps.get(k as usize - 1) {
                self.record.record_end(&step.ring, fields);
            }
        }
        self.tally.again(&self.body, &self.fields, &self.own_blocks);
    }

    /// Repeats the last window under another force, within the piece's part of the region.
    pub(super) fn repeat(&mut self, window: BodyWindow, starts: &[PieceStart]) {
        self.begin_again(window, starts);
        for k in 1..=window.input.substeps {
            self.damp(window, k);
            let step = &self.region.steps[k as usize - 1];
            let fields = &mut self.fields;
            // No piece has a law with history.
            self.record.read(&step.ring, fields, &mut Vec::new());
            self.integrator.step_cut(&self.body, fields, step);
        }
        self.tally
            .again(&self.body, &self.fields, &self.region.blocks);
    }

    /// Sets the damping of step `k`.
    fn damp(&mut self, window: BodyWindow, k: u32) {
        let step = window.committed.steps + u64::from(k) - 1;
        self.integrator.rule.damping = window.model.damping_over(step);
    }

    /// The committed state under the forces of the window.
    fn begin(&mut self, window: BodyWindow, starts: &[PieceStart]) {
        let own = &starts[self.index];
        let damped = own.state.damping_force.len();
        self.fields.state.damping_force.resize(damped);
        self.set_load(window.input);
        self.fields.dissipated.clear();
        self.record.clear();
        let damping = window.model.damping_at(window.committed.steps);
        // The first step reads one column beyond the spoilt ones.
        let columns = self.cut.good(window.input.substeps as usize + 1);
        for line in 0..2 * self.body.layout.node_rows {
            for start in starts {
                start.give(line, &columns, &self.cut, &mut self.fields.state);
            }
            let part = self.cut.in_line(line, &columns);
            self.fields.accelerate_part(&self.body, damping, part);
        }
        let a = &self.fields.state.a;
        self.tally.begin_blocks(&self.body, &self.own_blocks, a);
    }

    /// The start of the window where it differs from the last run.
    fn begin_again(&mut self, window: BodyWindow, starts: &[PieceStart]) {
        self.set_load(window.input);
        self.record.rewind();
        let damping = window.model.damping_at(window.committed.steps);
        for range in &self.region.begin {
            let (line, columns) = self.cut.in_body(range);
            for start in starts {
                start.give(line, &columns, &self.cut, &mut self.fields.state);
            }
            let fields = &mut self.fields;
            fields.accelerate_part(&self.body, damping, range.clone());
            for field in fields.dissipated.nodal_mut() {
                field.get_mut(range.clone()).unwrap_or_default().fill(0.0);
            }
        }
        let start = &starts[self.index].state;
        let start = (start, &self.fields.load, damping);
        self.tally
            .begin_again(&self.body, &self.region.sources, start);
    }

    fn set_load(&mut self, input: &WindowInput) {
        self.fields.load.clear();
        let body = self.cut.body;
        for (index, force) in &input.interface {
            let (line, column) = (index / body.stride, index % body.stride);
            if self.cut.columns.contains(&column) {
                let at = self.cut.in_line(line, &(column..column + 1)).start;
                self.fields.load.add(at, *force);
            }
        }
    }
}
