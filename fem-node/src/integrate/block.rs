//! Neighbouring rows of nodes, stepped in one sweep by one thread.

use std::ops::Range;

use super::load::Load;
use super::row::{Resisting, Row, RowSums};
use super::scheme::{Rule, Scheme};
use super::scratch::{Scratch, copy_neighbours};
use super::state::State;
use crate::element::{Body, CornerRows, Course};
use crate::material::point::PointLaw;
use crate::pack::widest;
use crate::wheel::{Wheel, WheelRun};

/// The upper row at the end of a step, before its contact forces are known; every field holds a row of nodes.
pub(crate) struct UpperRow<'a> {
    /// New displacements (m).
    pub(crate) u: &'a [f64],
    /// Velocities at the start of the step (m/s).
    pub(crate) v: &'a [f64],
    /// Accelerations at the start of the step (m/s2).
    pub(crate) a: &'a [f64],
    /// New internal forces (N).
    pub(crate) force: &'a [f64],
    /// Applied forces at the end of the step (N).
    pub(crate) load: &'a [f64],
    /// Inverse masses (1/kg).
    pub(crate) inverse_mass: &'a [f64],
}

/// Neighbouring rows of nodes and everything that stepping them writes.
pub(super) struct Block<'a> {
    first: usize,
    u: &'a mut [f64],
    v: &'a mut [f64],
    a: &'a mut [f64],
    force: &'a mut [f64],
    /// Empty without stiffness damping.
    resistance: &'a mut [f64],
    /// Histories of the elements below each row; empty if the points do not remember.
    history: &'a mut [f64],
    sums: &'a mut [RowSums],
    scratch: &'a mut Scratch,
    /// Of the block with the upper row, if there is a wheel.
    pub(super) wheel: Option<(&'a Wheel, &'a mut WheelRun)>,
    /// More than linear elasticity in small strain.
    pub(super) law: Option<PointLaw>,
}

/// Cuts the rows `first .. end` into as many blocks as there is scratch room for. Each block gets copies of the
/// rows next to it as they will be after the prediction, since their owner changes them at the same time.
pub(super) fn split<'a>(
    body: &Body,
    scheme: &Scheme,
    state: &'a mut State,
    sums: &'a mut [RowSums],
    scratch: &'a mut [Scratch],
    [first, end]: [usize; 2],
) -> Vec<Block<'a>> {
    let rows = (end - first).div_ceil(scratch.len());
    let starts = (first..end).step_by(rows);
    for (start, room) in starts.clone().zip(scratch.iter_mut()) {
        copy_neighbours(body, scheme, state, [start, (start + rows).min(end)], room);
    }
    let row_len = body.layout().row_len();
    let remembered = state.history.len() / (body.layout().node_rows() - 1);
    let mut history = state.history[first * remembered..].chunks_mut((rows * remembered).max(1));
    let (places, size) = (first * row_len..end * row_len, rows * row_len);
    let mut u = state.u[places.clone()].chunks_mut(size);
    let mut v = state.v[places.clone()].chunks_mut(size);
    let mut a = state.a[places.clone()].chunks_mut(size);
    let mut force = state.force[places.clone()].chunks_mut(size);
    let resisting = state.resistance.get_mut(places).unwrap_or_default();
    let mut resistance = resisting.chunks_mut(size);
    let mut sums = sums[first..end].chunks_mut(rows);
    let blocks = starts.zip(scratch).map_while(|(first, scratch)| {
        Some(Block {
            first,
            u: u.next()?,
            v: v.next()?,
            a: a.next()?,
            force: force.next()?,
            resistance: resistance.next().unwrap_or_default(),
            history: history.next().unwrap_or_default(),
            sums: sums.next()?,
            scratch,
            wheel: None,
            law: None,
        })
    });
    blocks.collect()
}

impl Block<'_> {
    /// One sweep from the upper to the lower row: predict the next row, compute the elements above it, then
    /// finish the row whose forces are complete. Every number is touched while it is in the cache.
    pub(super) fn step(&mut self, body: &Body, rule: &Rule, load: &Load) {
        let scheme = &rule.scheme;
        let size = body.layout().row_len();
        let rows = self.u.len() / size;
        self.predict(scheme, 0);
        if let Some(law) = self.law {
            return self.step_by(&law, body, rule, load);
        }
        self.start(body);
        for local in 0..rows {
            let here = &self.u[local * size..(local + 1) * size];
            let elements = &mut self.scratch.elements;
            if local + 1 < rows {
                self.predict(scheme, local + 1);
                let (here, next) = self.u[local * size..(local + 2) * size].split_at(size);
                body.element_row(self.first + local, here, next, &mut self.scratch.elements);
            } else if self.first + rows < body.layout().node_rows() {
                body.element_row(self.first + local, here, &self.scratch.below, elements);
            } else {
                elements.clear_upper();
            }
            self.finish(body, rule, load, local);
        }
    }

    /// The elements above the block, which the block above computes for itself as well.
    fn start(&mut self, body: &Body) {
        let Scratch {
            elements, above, ..
        } = &mut *self.scratch;
        elements.clear_carried();
        if self.first > 0 {
            body.element_row(self.first - 1, above, &self.u[..above.len()], elements);
            elements.advance();
        }
    }

    /// Like the rest of [`Block::step`] under a law that is more than linear.
    fn step_by(&mut self, law: &PointLaw, body: &Body, rule: &Rule, load: &Load) {
        let size = body.layout().row_len();
        let rows = self.u.len() / size;
        self.start_by(law, body);
        for local in 0..rows {
            self.scratch.memory.advance();
            if local + 1 < rows {
                self.predict(&rule.scheme, local + 1);
            }
            match self.first + local + 1 < body.layout().node_rows() {
                true => self.elements_by(law, body, local),
                false => self.scratch.elements.clear_upper(),
            }
            self.finish(body, rule, load, local);
        }
    }

    fn start_by(&mut self, law: &PointLaw, body: &Body) {
        let Scratch {
            elements,
            above,
            memory,
            ..
        } = &mut *self.scratch;
        elements.clear_carried();
        if self.first > 0 {
            let course = Course {
                u: CornerRows::between([above, &self.u[..above.len()]]),
                du: CornerRows::between([&memory.above, &memory.next]),
                history: &mut memory.history,
            };
            // The block above counts what they dissipate.
            body.element_row_by(law, self.first - 1, course, elements);
            elements.advance();
        }
    }

    /// The elements between this row and the next, which may belong to the block below.
    fn elements_by(&mut self, law: &PointLaw, body: &Body, local: usize) {
        let size = body.layout().row_len();
        let Scratch {
            elements,
            below,
            memory,
            ..
        } = &mut *self.scratch;
        let inside = (local + 1) * size < self.u.len();
        let (here, rest) = self.u[local * size..].split_at(size);
        let remembered = memory.history.len();
        let course = Course {
            u: CornerRows::between([here, if inside { &rest[..size] } else { below }]),
            du: CornerRows::between([
                &memory.here,
                if inside { &memory.next } else { &memory.below },
            ]),
            history: &mut self.history[local * remembered..(local + 1) * remembered],
        };
        self.sums[local].plastic += body.element_row_by(law, self.first + local, course, elements);
    }

    fn predict(&mut self, scheme: &Scheme, local: usize) {
        let size = self.scratch.force.len();
        let row = local * size..(local + 1) * size;
        self.remember_increment(scheme, row.clone());
        let rates = self.v[row.clone()].iter().zip(&self.a[row.clone()]);
        let places = self.u[row].iter_mut().zip(rates);
        widest(
            #[inline(always)]
            || {
                for (u, (v, a)) in places {
                    *u = scheme.predicted(*u, *v, *a);
                }
            },
        );
    }

    /// The increments of the next row, where the points remember.
    fn remember_increment(&mut self, scheme: &Scheme, row: Range<usize>) {
        let rates = self.v[row.clone()].iter().zip(&self.a[row]);
        for (increment, (v, a)) in self.scratch.memory.next.iter_mut().zip(rates) {
            *increment = scheme.increment(*v, *a);
        }
    }

    fn finish(&mut self, body: &Body, rule: &Rule, load: &Load, local: usize) {
        let Scratch {
            elements,
            force,
            acceleration,
            net,
            ..
        } = &mut *self.scratch;
        elements.assemble(force);
        elements.advance();
        let layout = body.layout();
        layout.gather(force);
        let own = local * force.len()..(local + 1) * force.len();
        let all = layout.row(self.first + local);
        let mut load = load.row(self.first + local);
        if let Some(resistance) = self.resistance.get_mut(own.clone()) {
            let mut resisting = Resisting {
                v: &self.v[own.clone()],
                a: &self.a[own.clone()],
                force: &self.force[own.clone()],
                new_force: force,
                load,
                resistance,
            };
            self.sums[local].resistance += resisting.resist(&rule.scheme, net);
            load = net;
        }
        let load = match &mut self.wheel {
            Some((wheel, run)) if local == 0 => {
                let upper = UpperRow {
                    u: &self.u[own.clone()],
                    v: &self.v[own.clone()],
                    a: &self.a[own.clone()],
                    force,
                    load,
                    inverse_mass: &body.inverse_mass[all.clone()],
                };
                run.close(wheel, (&rule.scheme, rule.damping), &upper);
                run.load()
            }
            _ => load,
        };
        let mut row = Row {
            v: &mut self.v[own.clone()],
            a: &mut self.a[own.clone()],
            force: &mut self.force[own],
            new_force: force,
            new_a: acceleration,
            load,
            mass: &body.mass[all.clone()],
            inverse_mass: &body.inverse_mass[all],
        };
        row.finish(rule, layout, &mut self.sums[local]);
    }
}
