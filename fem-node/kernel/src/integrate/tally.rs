//! Sums over a body at the end of a window, block by block.
//!
//! A block is a few neighbours of one row and component. A repeat of the window adds up only the blocks that it has changed. The sums of the blocks
//! are added in order, so the bits equal a sum over all blocks.

use std::ops::Range;

use super::fields::StepFields;
use super::load::Load;
use super::state::NodalState;
use crate::element::body::Body;
use crate::element::layout::Layout;
use crate::pack::lanes::{LANES, Pack};
use crate::pack::vectorised;
use kit::add_fields;
use protocol::larger;

/// Components in a block.
pub const BLOCK: usize = 16;

/// Sums over some components.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sums {
    /// v M v
    pub kinetic: f64,
    /// u F(u)
    pub strain: f64,
    /// a M a
    pub inertia: f64,
    /// Sums of [`Dissipated`](super::dissipation::Dissipated).
    pub numerical: f64,
    /// The same for mass damping (J).
    pub mass_damping: f64,
    /// The same for stiffness damping (J).
    pub stiffness_damping: f64,
    /// The displacement farthest from zero (m); NaN if any is NaN.
    pub farthest: f64,
}

/// Sums by blocks.
#[derive(Clone, Debug, Default)]
pub struct Tally {
    blocks: Vec<Sums>,
    /// a M a at the start of the window.
    pub starts: Vec<f64>,
}

impl Tally {
    /// Without any sums yet.
    pub fn sized(layout: Layout) -> Tally {
        Tally {
            blocks: vec![Sums::default(); count(layout)],
            starts: vec![0.0; count(layout)],
        }
    }

    /// Adds up all blocks.
    pub fn all(&mut self, body: &Body, fields: &StepFields) {
        (0..self.blocks.len()).for_each(|block| self.add_block(body, fields, block));
    }

    /// Adds up these blocks again.
    pub fn again(&mut self, body: &Body, fields: &StepFields, blocks: &[usize]) {
        let blocks = blocks.iter();
        blocks.for_each(|block| self.add_block(body, fields, *block));
    }

    fn add_block(&mut self, body: &Body, fields: &StepFields, block: usize) {
        let own = components(body.layout, block);
        self.blocks[block] = vectorised!(add_up(body, fields, own));
    }

    /// The sums over the body.
    pub fn total(&self) -> Sums {
        let mut total = Sums::default();
        for block in &self.blocks {
            add_fields!(total, block; kinetic, strain, inertia, numerical, mass_damping, stiffness_damping);
            total.farthest = larger(total.farthest, block.farthest);
        }
        total
    }

    /// Begins a window with these accelerations.
    pub fn begin(&mut self, body: &Body, a: &[f64]) {
        (0..self.starts.len()).for_each(|block| self.begin_block(body, a, block));
    }

    /// Begins a window with the accelerations in these blocks.
    pub fn begin_blocks(&mut self, body: &Body, blocks: &[usize], a: &[f64]) {
        blocks
            .iter()
            .for_each(|block| self.begin_block(body, a, *block));
    }

    fn begin_block(&mut self, body: &Body, a: &[f64], block: usize) {
        let own = components(body.layout, block);
        self.starts[block] = vectorised!(inertia(&body.mass[own.clone()], &a[own]));
    }

    /// Begins a window again in these blocks, from this state under another load and with this mass damping (1/s).
    pub fn begin_again(
        &mut self,
        body: &Body,
        blocks: &[usize],
        (start, load, damping): (&NodalState, &Load, f64),
    ) {
        for block in blocks {
            let own = components(body.layout, *block);
            let mut a = [0.0; BLOCK];
            for (a, k) in a.iter_mut().zip(own.clone()) {
                *a = start.acceleration(body, damping, load, k);
            }
            self.starts[*block] = inertia(&body.mass[own.clone()], &a[..own.len()]);
        }
    }

    /// Copies the blocks of the own columns of a piece of the body that begins at column `first`. Cuts are at multiples of [`BLOCK`].
    pub fn take(
        &mut self,
        layout: Layout,
        (piece, its): (&Tally, Layout),
        own: &Range<usize>,
        first: usize,
    ) {
        let (of_row, of_its) = (layout.stride.div_ceil(BLOCK), its.stride.div_ceil(BLOCK));
        let end = if own.end == layout.nodes_in_row {
            of_row
        } else {
            own.end / BLOCK
        };
        for line in 0..2 * layout.node_rows {
            for block in own.start / BLOCK..end {
                let (to, from) = (line * of_row + block, line * of_its + block - first / BLOCK);
                // There is padding beyond the end of the piece.
                self.blocks[to] = piece.blocks.get(from).copied().unwrap_or_default();
                self.starts[to] = piece.starts.get(from).copied().unwrap_or_default();
            }
        }
    }
}

/// Blocks with any of these components, ascending.
pub fn blocks_of(layout: Layout, ranges: impl Iterator<Item = Range<usize>>) -> Vec<usize> {
    let of_row = layout.stride.div_ceil(BLOCK);
    let block = |k: usize| k / layout.stride * of_row + k % layout.stride / BLOCK;
    let mut blocks: Vec<usize> = ranges
        .filter(|range| !range.is_empty())
        .flat_map(|range| block(range.start)..=block(range.end - 1))
        .collect();
    blocks.sort_unstable();
    blocks.dedup();
    blocks
}

fn count(layout: Layout) -> usize {
    layout.len() / layout.stride * layout.stride.div_ceil(BLOCK)
}

/// Components of a block.
fn components(layout: Layout, block: usize) -> Range<usize> {
    let of_row = layout.stride.div_ceil(BLOCK);
    let row = block / of_row * layout.stride;
    let first = row + block % of_row * BLOCK;
    first..(first + BLOCK).min(row + layout.stride)
}

#[inline(always)]
fn add_up(body: &Body, fields: &StepFields, own: Range<usize>) -> Sums {
    let (state, dissipated) = (&fields.state, &fields.dissipated);
    let of = |field: &Vec<f64>| sum(field.get(own.clone()).unwrap_or_default());
    let [mass, v, a] = [&body.mass, &state.v, &state.a].map(|field| &field[own.clone()]);
    let (u, force) = (&state.u[own.clone()], &state.force[own.clone()]);
    Sums {
        kinetic: inertia(mass, v),
        strain: product(u, force),
        inertia: inertia(mass, a),
        numerical: of(&dissipated.numerical),
        mass_damping: of(&dissipated.mass_damping),
        stiffness_damping: of(&dissipated.stiffness_damping),
        farthest: u.iter().fold(0.0, |far, u| larger(far, u.abs())),
    }
}

/// x M x
#[inline(always)]
fn inertia(mass: &[f64], x: &[f64]) -> f64 {
    let terms = |k: usize| Pack::load(mass, k) * Pack::load(x, k) * Pack::load(x, k);
    sum_of(mass.len(), terms)
}

#[inline(always)]
fn product(x: &[f64], y: &[f64]) -> f64 {
    sum_of(x.len(), |k| Pack::load(x, k) * Pack::load(y, k))
}

#[inline(always)]
fn sum(x: &[f64]) -> f64 {
    sum_of(x.len(), |k| Pack::load(x, k))
}

/// The sum of the packs of a block, whose length is a multiple of a pack's.
#[inline(always)]
fn sum_of(len: usize, pack: impl Fn(usize) -> Pack) -> f64 {
    let packs = (0..len).step_by(LANES).map(pack);
    packs.fold(Pack::splat(0.0), |sum, pack| sum + pack).sum()
}

/// v M v / 2 (J)
pub fn kinetic_energy(body: &Body, v: &[f64]) -> f64 {
    vectorised!({
        0.5 * sum_of(v.len(), |k| {
            Pack::load(&body.mass, k) * Pack::load(v, k) * Pack::load(v, k)
        })
    })
}
