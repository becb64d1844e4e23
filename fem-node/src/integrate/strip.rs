//! Strips of neighbouring rows of nodes, each stepped in one sweep by one thread.

use std::ops::Range;

use super::load::Load;
use super::node_row::{NodeRow, RowEnergies};
use super::scheme::{Rule, Scheme};
use super::scratch::{Scratch, copy_neighbours};
use super::state::State;
use super::upper_row::UpperRow;
use crate::element::{Body, CornerRows, StrainPath};
use crate::material::nonlinear::NonlinearLaw;
use crate::pack::vectorised;
use crate::wheel::{Wheel, WheelRun};

/// Neighbouring rows of nodes and everything that stepping them writes.
pub(super) struct Strip<'a> {
    first: usize,
    u: &'a mut [f64],
    v: &'a mut [f64],
    a: &'a mut [f64],
    force: &'a mut [f64],
    /// Empty without stiffness damping.
    damping_force: &'a mut [f64],
    /// History of the elements below each row; empty under a law without.
    history: &'a mut [f64],
    energies: &'a mut [RowEnergies],
    scratch: &'a mut Scratch,
    /// The wheel, for the strip with the upper row.
    pub(super) wheel: Option<(&'a Wheel, &'a mut WheelRun)>,
    pub(super) law: Option<NonlinearLaw>,
}

/// Cuts the rows `first .. end` into as many strips as there are buffers for. Each strip gets copies of the
/// rows next to it as they will be after the prediction, since their owner changes them at the same time.
pub(super) fn split<'a>(
    body: &Body,
    scheme: &Scheme,
    state: &'a mut State,
    energies: &'a mut [RowEnergies],
    scratch: &'a mut [Scratch],
    [first, end]: [usize; 2],
) -> Vec<Strip<'a>> {
    let rows = (end - first).div_ceil(scratch.len());
    let starts = (first..end).step_by(rows);
    for (start, buffers) in starts.clone().zip(scratch.iter_mut()) {
        copy_neighbours(
            body,
            scheme,
            state,
            [start, (start + rows).min(end)],
            buffers,
        );
    }
    let row_len = body.layout.row_len();
    let row_history = state.history.len() / (body.layout.node_rows - 1);
    let mut history = state.history[first * row_history..].chunks_mut((rows * row_history).max(1));
    let (range, size) = (first * row_len..end * row_len, rows * row_len);
    let mut u = state.u[range.clone()].chunks_mut(size);
    let mut v = state.v[range.clone()].chunks_mut(size);
    let mut a = state.a[range.clone()].chunks_mut(size);
    let mut force = state.force[range.clone()].chunks_mut(size);
    let damping = state.damping_force.get_mut(range).unwrap_or_default();
    let mut damping_force = damping.chunks_mut(size);
    let mut energies = energies[first..end].chunks_mut(rows);
    let strips = starts.zip(scratch).map_while(|(first, scratch)| {
        Some(Strip {
            first,
            u: u.next()?,
            v: v.next()?,
            a: a.next()?,
            force: force.next()?,
            damping_force: damping_force.next().unwrap_or_default(),
            history: history.next().unwrap_or_default(),
            energies: energies.next()?,
            scratch,
            wheel: None,
            law: None,
        })
    });
    strips.collect()
}

impl Strip<'_> {
    /// One sweep from the upper to the lower row: predict the next row, compute the elements above it, then
    /// finish the row whose forces are complete. Every number is touched while it is in the cache.
    pub(super) fn step(&mut self, body: &Body, rule: &Rule, load: &Load) {
        let rows = self.u.len() / body.layout.row_len();
        self.predict(&rule.scheme, 0);
        self.elements_above(body);
        for local in 0..rows {
            self.scratch.increments.advance();
            if local + 1 < rows {
                self.predict(&rule.scheme, local + 1);
            }
            if self.first + local + 1 < body.layout.node_rows {
                self.elements_below(body, local);
            } else {
                self.scratch.elements.clear_upper();
            }
            self.finish(body, rule, load, local);
        }
    }

    /// Elements above the strip, which the strip above computes for itself as well.
    fn elements_above(&mut self, body: &Body) {
        let scratch = &mut *self.scratch;
        let (elements, above) = (&mut scratch.elements, &scratch.above);
        elements.clear_carried();
        if self.first == 0 {
            return;
        }
        let u = CornerRows::between([above, &self.u[..above.len()]]);
        if let Some(law) = &self.law {
            let increments = &scratch.increments;
            let du = CornerRows::between([&increments.above, &increments.next]);
            let history = &mut scratch.history;
            // The strip above counts their dissipation.
            body.nonlinear_row(law, self.first - 1, StrainPath { u, du, history }, elements);
        } else {
            body.element_row(self.first - 1, u, elements);
        }
        elements.advance();
    }

    /// Elements between this row and the next, which may belong to the strip below.
    fn elements_below(&mut self, body: &Body, local: usize) {
        let size = body.layout.row_len();
        let scratch = &mut *self.scratch;
        let (elements, increments) = (&mut scratch.elements, &scratch.increments);
        let inside = (local + 1) * size < self.u.len();
        let (here, rest) = self.u[local * size..].split_at(size);
        let u = CornerRows::between([
            here,
            if inside {
                &rest[..size]
            } else {
                &scratch.below
            },
        ]);
        let row = self.first + local;
        let Some(law) = &self.law else {
            return body.element_row(row, u, elements);
        };
        let next = if inside {
            &increments.next
        } else {
            &increments.below
        };
        let size = scratch.history.len();
        let path = StrainPath {
            u,
            du: CornerRows::between([&increments.here, next]),
            history: &mut self.history[local * size..(local + 1) * size],
        };
        self.energies[local].plastic += body.nonlinear_row(law, row, path, elements);
    }

    fn predict(&mut self, scheme: &Scheme, local: usize) {
        let size = self.scratch.force.len();
        let row = local * size..(local + 1) * size;
        self.keep_increment(scheme, row.clone());
        let rates = self.v[row.clone()].iter().zip(&self.a[row.clone()]);
        let nodes = self.u[row].iter_mut().zip(rates);
        vectorised(
            #[inline(always)]
            || {
                for (u, (v, a)) in nodes {
                    *u = scheme.predicted(*u, *v, *a);
                }
            },
        );
    }

    /// Increments of the next row, for a law with history.
    fn keep_increment(&mut self, scheme: &Scheme, row: Range<usize>) {
        let rates = self.v[row.clone()].iter().zip(&self.a[row]);
        for (increment, (v, a)) in self.scratch.increments.next.iter_mut().zip(rates) {
            *increment = scheme.increment(*v, *a);
        }
    }

    fn finish(&mut self, body: &Body, rule: &Rule, load: &Load, local: usize) {
        let scratch = &mut *self.scratch;
        let force = &mut scratch.force;
        scratch.elements.assemble(force);
        scratch.elements.advance();
        let layout = body.layout;
        layout.fold_period(force);
        let own = local * force.len()..(local + 1) * force.len();
        let all = layout.row(self.first + local);
        let mut row = NodeRow {
            v: &mut self.v[own.clone()],
            a: &mut self.a[own.clone()],
            force: &mut self.force[own.clone()],
            new_force: force,
            new_a: &mut scratch.acceleration,
            load: load.row(self.first + local),
            mass: &body.mass[all.clone()],
            inverse_mass: &body.inverse_mass[all],
            damping_force: self.damping_force.get_mut(own.clone()).unwrap_or_default(),
            net: &mut scratch.net,
        };
        let energies = &mut self.energies[local];
        row.damp_stiffness(&rule.scheme, energies);
        if let Some((wheel, run)) = self.wheel.as_mut().filter(|_| local == 0) {
            let upper = UpperRow {
                u: &self.u[own],
                v: row.v,
                a: row.a,
                force: row.new_force,
                load: row.load,
                inverse_mass: row.inverse_mass,
            };
            run.close(wheel, rule, &upper);
            row.load = run.load();
        }
        row.finish(rule, layout, energies);
    }
}
