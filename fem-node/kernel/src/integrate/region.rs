//! The part of a body that a changed interface force can reach within a window.
//!
//! The internal force on a node depends on the nodes of its elements only, so a step carries a disturbance one ring of elements
//! further: k steps after other forces act on the exchanged nodes, nothing beyond k rings around them differs. A repeat of a
//! window therefore steps the nodes A_k within k rings at its step k. It needs the ring beyond these nodes as in the first run: a [`RingRecord`]
//! keeps the state of each ring just before the change reaches it. The result has the bits of a repeat of the whole.

use std::ops::Range;

use super::fields::StepFields;
use super::front::Front;
use super::rings::Rings;
use super::state::NodalState;
use super::tally::blocks_of;
use crate::element::body::Body;
use crate::scheme::NewmarkScheme;

/// Largest share of all element steps that a region may take: beyond it the record does not pay.
const SHARE_MAX: f64 = 0.8;

/// The ring beyond the front of a step.
#[derive(Clone, Debug, Default)]
pub struct Ring {
    /// Components that the change reaches with the next step, a range in one row each.
    pub(super) enters: Vec<Range<usize>>,
    /// Histories of the rows of elements that the step computes for the first time.
    pub(super) histories: Vec<Range<usize>>,
    /// Energies of these rows.
    pub(super) plastic: Vec<Range<usize>>,
}

/// Reach of a change of the force on some components in a window of `substeps` steps.
#[derive(Clone, Debug)]
pub struct Region {
    pub(super) components: Vec<usize>,
    substeps: u32,
    /// Components of A_1, which begin from the start of the window.
    pub(super) begin: Vec<Range<usize>>,
    /// Stepped nodes, step by step.
    pub fronts: Vec<Front>,
    /// Rings beyond the stepped nodes.
    pub rings: Vec<Ring>,
    /// Element steps of a repeat.
    pub element_steps: u64,
    /// Blocks of [`crate::integrate::tally::Tally`] with components of A_m.
    pub blocks: Vec<usize>,
    /// Blocks with components on which the changed force acts.
    pub sources: Vec<usize>,
}

impl Region {
    /// The region of a body with `row_history` history variables per row of elements; `None` if a repeat of the whole costs little more.
    pub fn new(
        body: &Body,
        row_history: usize,
        components: &[usize],
        substeps: u32,
    ) -> Option<Region> {
        let history = row_history > 0;
        let rings = Rings::new(body, history);
        let mut region = Region {
            components: components.to_vec(),
            substeps,
            begin: Vec::new(),
            fronts: Vec::new(),
            rings: Vec::new(),
            element_steps: 0,
            blocks: Vec::new(),
            sources: blocks_of(body.layout, components.iter().map(|k| *k..*k + 1)),
        };
        let all = f64::from(substeps) * body.elements() as f64;
        let mut front = rings.grown(&rings.around(components));
        region.begin = rings.components(&front, None);
        let mut computed = Vec::new();
        for step in 1..=substeps {
            let beyond = rings.grown(&front);
            region.element_steps += rings.work(&front);
            if region.element_steps as f64 > SHARE_MAX * all {
                return None;
            }
            let rows = history.then(|| rings.rows(&front));
            let rows = rows.unwrap_or_default();
            // The last step needs the displacements of the ring beyond, which are still as at the end, but also their increments.
            let enters = || rings.components(&beyond, Some(&front));
            let enters = (step < substeps || history).then(enters);
            let new = rows.iter().filter(|row| !computed.contains(*row));
            let padded = body.layout.padded_columns();
            let of = |size: usize| new.clone().map(move |row| row * size..(row + 1) * size);
            region.rings.push(Ring {
                enters: enters.unwrap_or_default(),
                histories: of(row_history).collect(),
                plastic: of(padded).collect(),
            });
            region.fronts.push(front);
            computed = rows;
            front = beyond;
        }
        let reached = rings.components(region.fronts.last()?, None);
        region.blocks = blocks_of(body.layout, reached.into_iter());
        Some(region)
    }

    /// True if it is the region of these components and this many steps.
    pub fn is_of(&self, components: impl Iterator<Item = usize>, substeps: u32) -> bool {
        self.substeps == substeps && self.components.iter().copied().eq(components)
    }

    /// First step that steps a component; `None` if no step does.
    pub fn reached_at(&self, component: usize) -> Option<u32> {
        let holds = |ranges: &[Range<usize>]| ranges.iter().any(|range| range.contains(&component));
        if holds(&self.begin) {
            return Some(1);
        }
        let entered = self.rings.iter().position(|ring| holds(&ring.enters));
        entered.map(|ring| ring as u32 + 2)
    }

    /// Resets the nodes that are stepped first to the start of the window, and accelerates them under the current load.
    pub fn begin(
        &self,
        fields: &mut StepFields,
        (body, damping): (&Body, f64),
        start: &NodalState,
    ) {
        for range in &self.begin {
            fields
                .state
                .restore_part(range.clone(), start, range.clone());
            fields.accelerate_part(body, damping, range.clone());
            for field in fields.dissipated.nodal_mut() {
                part(field, range).fill(0.0);
            }
        }
        let (state, dissipated) = (&mut fields.state, &mut fields.dissipated);
        body.layout.repeat_period(&mut state.a);
        for own in &self.rings[0].histories {
            state.history[own.clone()].copy_from_slice(&start.history[own.clone()]);
        }
        for own in &self.rings[0].plastic {
            part(&mut dissipated.plastic, own).fill(0.0);
        }
    }
}

/// States of the rings of a region, each just before a change reaches it.
#[derive(Clone, Debug, Default)]
pub struct RingRecord {
    numbers: Vec<f64>,
    at: usize,
}

impl RingRecord {
    /// Begins to record.
    pub fn clear(&mut self) {
        self.numbers.clear();
        self.at = 0;
    }

    /// Begins to read.
    pub fn rewind(&mut self) {
        self.at = 0;
    }

    /// Records, before a step, the data that its elements need under a law with history.
    pub fn record_start(&mut self, ring: &Ring, scheme: &NewmarkScheme, fields: &StepFields) {
        let state = &fields.state;
        if state.history.is_empty() {
            return;
        }
        for i in ring.enters.iter().cloned().flatten() {
            self.numbers.push(scheme.increment(state.v[i], state.a[i]));
        }
        for own in &ring.histories {
            self.numbers.extend_from_slice(&state.history[own.clone()]);
        }
        for own in &ring.plastic {
            let plastic = &fields.dissipated.plastic[own.clone()];
            self.numbers.extend_from_slice(plastic);
        }
    }

    /// Records, after a step, the ring that a change reaches with the next one.
    pub fn record_end(&mut self, ring: &Ring, fields: &StepFields) {
        let [numerical, mass, stiffness] = fields.dissipated.nodal();
        let [u, v, a, force, damping_force] = fields.state.nodal();
        let fields = [u, v, a, force, damping_force, numerical, mass, stiffness];
        for range in &ring.enters {
            for field in fields {
                let kept = field.get(range.clone()).unwrap_or_default();
                self.numbers.extend_from_slice(kept);
            }
        }
    }

    /// Reads the record for the next step; under a law with history `increments` gets the increments of the ring.
    pub fn read(&mut self, ring: &Ring, fields: &mut StepFields, increments: &mut Vec<f64>) {
        let (state, dissipated) = (&mut fields.state, &mut fields.dissipated);
        if !state.history.is_empty() {
            increments.resize(state.u.len(), 0.0);
            ring.enters
                .iter()
                .for_each(|own| self.take(increments, own));
            let histories = ring.histories.iter();
            histories.for_each(|own| self.take(&mut state.history, own));
            let plastic = ring.plastic.iter();
            plastic.for_each(|own| self.take(&mut dissipated.plastic, own));
        }
        let [numerical, mass, stiffness] = dissipated.nodal_mut();
        let [u, v, a, force, damping_force] = state.nodal_mut();
        let mut fields = [u, v, a, force, damping_force, numerical, mass, stiffness];
        for own in &ring.enters {
            fields.iter_mut().for_each(|field| self.take(field, own));
        }
    }

    /// Reads the next numbers into part of a field that the scene may not have.
    fn take(&mut self, field: &mut [f64], own: &Range<usize>) {
        let field = part(field, own);
        let end = self.at + field.len();
        field.copy_from_slice(&self.numbers[self.at..end]);
        self.at = end;
    }
}

/// Part of a field, empty where the scene does not have the field.
fn part<'a>(field: &'a mut [f64], range: &Range<usize>) -> &'a mut [f64] {
    field.get_mut(range.clone()).unwrap_or_default()
}
