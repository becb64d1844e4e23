//! Strips of neighbouring rows of nodes, each stepped in one sweep by one thread.

use std::ops::Range;

use super::dissipation::{Dissipated, cut};
use super::fields::StepFields;
use super::front::joined;
use super::load::Load;
use super::node_pass::NodePass;
use super::node_row::NodeRow;
use super::scratch::{Scratch, copy_neighbours};
use super::state::NodalState;
use crate::element::body::Body;
use crate::element::corners::{CornerRows, StrainPath};
use crate::material::nonlinear::NonlinearLaw;
use crate::pack::{in_registers, vectorised};
use crate::scheme::{NewmarkScheme, Rule};
use crate::wheel::rigid::Wheel;
use crate::wheel::run::WheelRun;
use crate::wheel::upper_row::UpperRow;

/// Neighbouring rows of nodes and all data that their step writes.
pub(super) struct Strip<'a> {
    body: &'a Body,
    rule: &'a Rule,
    law: Option<NonlinearLaw>,
    load: &'a Load,
    first: usize,
    u: &'a mut [f64],
    v: &'a mut [f64],
    a: &'a mut [f64],
    force: &'a mut [f64],
    /// Empty without stiffness damping.
    damping_force: &'a mut [f64],
    /// History of the elements below each row; empty under a law without history.
    history: &'a mut [f64],
    dissipated: Dissipated<&'a mut [f64]>,
    scratch: &'a mut Scratch,
    /// The stepped part of its rows; `None` for all of them.
    pub(super) part: Option<Part<'a>>,
    /// The wheel, for the strip with the upper row.
    pub(super) wheel: Option<(&'a Wheel, &'a mut WheelRun)>,
}

/// Part of a body that a step covers; all other nodes that the part needs are already as after the step.
#[derive(Clone, Copy)]
pub(super) struct Part<'a> {
    pub(super) columns: Columns<'a>,
    /// The stepped columns and the columns beside them that are still as the step before left them, and must be predicted.
    pub(super) predicted: Columns<'a>,
    /// Increments of the displacements in the rows beside the part; empty under a law without history.
    pub(super) increments: &'a [f64],
}

/// Columns of nodes of a part.
#[derive(Clone, Copy)]
pub(super) enum Columns<'a> {
    /// The same in each row.
    Alike([usize; 2]),
    /// Columns of each row; a row may have no columns.
    OfRows(&'a [[usize; 2]]),
}

impl Columns<'_> {
    /// Columns of a row; the row below the last one, which belongs to another strip, has no columns.
    fn of(self, row: usize) -> [usize; 2] {
        match self {
            Columns::Alike(columns) => columns,
            Columns::OfRows(rows) => rows.get(row).copied().unwrap_or_default(),
        }
    }
}

/// Cuts the rows `first .. end` into as many strips as there are buffers for. Each strip gets copies of the
/// rows next to it as they will be after the prediction, since their owner changes them at the same time.
pub(super) fn split<'a>(
    body: &'a Body,
    (rule, law): (&'a Rule, Option<NonlinearLaw>),
    fields: &'a mut StepFields,
    scratch: &'a mut [Scratch],
    [first, end]: [usize; 2],
) -> Vec<Strip<'a>> {
    let (load, mut dissipated) = (&fields.load, fields.dissipated.whole());
    let layout = body.layout;
    let rows = (end - first).div_ceil(scratch.len());
    let starts = (first..end).step_by(rows);
    for (start, buffers) in starts.clone().zip(scratch.iter_mut()) {
        let own = [start, (start + rows).min(end)];
        copy_neighbours(body, &rule.scheme, &fields.state, own, buffers);
    }
    let (row_len, padded) = (layout.row_len(), layout.padded_columns());
    let NodalState {
        u,
        v,
        force,
        a,
        damping_force,
        history,
        thermal: _,
    } = &mut fields.state;
    let row_history = history.len() / (layout.node_rows - 1);
    let mut fields = [u, v, a, force, damping_force].map(|field| &mut field[..]);
    let mut history = history.as_mut_slice();
    let before = first * row_len;
    for field in &mut fields {
        cut(field, before);
    }
    cut(&mut history, first * row_history);
    dissipated.cut(before, first * padded);
    let strips = starts.zip(scratch).map(|(start, scratch)| {
        let rows = rows.min(end - start);
        let [u, v, a, force, damping_force] =
            fields.each_mut().map(|field| cut(field, rows * row_len));
        Strip {
            body,
            rule,
            law,
            load,
            first: start,
            u,
            v,
            a,
            force,
            damping_force,
            history: cut(&mut history, rows * row_history),
            dissipated: dissipated.cut(rows * row_len, rows * padded),
            scratch,
            part: None,
            wheel: None,
        }
    });
    strips.collect()
}

impl Strip<'_> {
    /// One sweep from the upper to the lower row: predict the next row, compute the elements above it, then
    /// finish the row whose forces are complete. Every number is touched while it is in the cache.
    pub(super) fn step(&mut self) {
        let layout = self.body.layout;
        let rows = self.u.len() / layout.row_len();
        self.predict(0);
        self.elements_above();
        for local in 0..rows {
            self.scratch.increments.advance();
            if local + 1 < rows {
                self.predict(local + 1);
            }
            if self.first + local + 1 < layout.node_rows {
                self.elements_below(local);
            } else {
                self.scratch.elements.clear_upper();
            }
            self.finish(local);
        }
    }

    /// Elements above the strip, which the strip above also computes for itself.
    fn elements_above(&mut self) {
        let body = self.body;
        let scratch = &mut *self.scratch;
        let (elements, above) = (&mut scratch.elements, &scratch.above);
        elements.clear_carried();
        if self.first == 0 {
            return;
        }
        let all = 0..body.layout.padded_columns();
        let u = CornerRows::between([above, &self.u[..above.len()]]);
        if let Some(law) = &self.law {
            let increments = &scratch.increments;
            let du = CornerRows::between([&increments.above, &increments.next]);
            let history = &mut scratch.history;
            let path = StrainPath {
                u,
                du,
                history,
                // The strip above counts it.
                dissipated: &mut [],
            };
            body.nonlinear_row(law, self.first - 1, path, all, elements);
        } else {
            body.element_row(self.first - 1, u, all, elements);
        }
        elements.advance();
    }

    /// Elements between this row and the next, which may belong to the strip below.
    fn elements_below(&mut self, local: usize) {
        let body = self.body;
        let columns = joined(self.columns(local), self.columns(local + 1));
        if columns[0] == columns[1] {
            return;
        }
        let elements_at = body.layout.elements_at(columns);
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
            return body.element_row(row, u, elements_at, elements);
        };
        let next = if inside {
            &increments.next
        } else {
            &increments.below
        };
        let size = scratch.history.len();
        let padded = body.layout.padded_columns();
        let dissipated = &mut *self.dissipated.plastic;
        let path = StrainPath {
            u,
            du: CornerRows::between([&increments.here, next]),
            history: &mut self.history[local * size..(local + 1) * size],
            dissipated: dissipated
                .get_mut(local * padded..(local + 1) * padded)
                .unwrap_or_default(),
        };
        body.nonlinear_row(law, row, path, elements_at, elements);
    }

    /// Columns of a row that are stepped.
    fn columns(&self, local: usize) -> [usize; 2] {
        match self.part {
            None => [0, self.body.layout.stride],
            Some(part) => part.columns.of(self.first + local),
        }
    }

    fn predict(&mut self, local: usize) {
        let (layout, scheme) = (self.body.layout, &self.rule.scheme);
        let columns = self.columns(local);
        let row = local * layout.row_len()..(local + 1) * layout.row_len();
        if self.part.is_none() && !self.scratch.increments.next.is_empty() {
            return self.predict_and_keep(scheme, row);
        }
        self.keep_increment(scheme, row.clone(), columns);
        let predicted = self
            .part
            .map_or(columns, |part| part.predicted.of(self.first + local));
        let u = &mut self.u[row.clone()];
        let (v, a) = (&self.v[row.clone()], &self.a[row]);
        vectorised!({
            for span in layout.spans(predicted) {
                let rates = v[span.clone()].iter().zip(&a[span.clone()]);
                for (u, (v, a)) in u[span].iter_mut().zip(rates) {
                    *u = scheme.predicted(*u, *v, *a);
                }
            }
        });
    }

    /// Predicts a whole row and keeps the increments, for a law with history.
    fn predict_and_keep(&mut self, scheme: &NewmarkScheme, row: Range<usize>) {
        let next = self.scratch.increments.next.iter_mut();
        let rates = self.v[row.clone()].iter().zip(&self.a[row.clone()]);
        let fields = self.u[row].iter_mut().zip(next).zip(rates);
        vectorised!({
            for ((u, kept), (v, a)) in fields {
                *kept = scheme.increment(*v, *a);
                *u += *kept;
            }
        });
    }

    /// Increments of the next row of a part, for a law with history.
    fn keep_increment(&mut self, scheme: &NewmarkScheme, row: Range<usize>, columns: [usize; 2]) {
        let next = &mut self.scratch.increments.next;
        if let Some(part) = self
            .part
            .filter(|_| columns[0] == columns[1] && !next.is_empty())
        {
            let all = self.first * next.len() + row.start;
            next.copy_from_slice(&part.increments[all..all + row.len()]);
            return;
        }
        let rates = self.v[row.clone()].iter().zip(&self.a[row]);
        for (increment, (v, a)) in next.iter_mut().zip(rates) {
            *increment = scheme.increment(*v, *a);
        }
    }

    fn finish(&mut self, local: usize) {
        let (body, rule, layout) = (self.body, self.rule, self.body.layout);
        let columns = self.columns(local);
        let scratch = &mut *self.scratch;
        if columns[0] == columns[1] {
            return scratch.elements.advance();
        }
        let own = local * layout.row_len()..(local + 1) * layout.row_len();
        let all = layout.row(self.first + local);
        let comes_between = (self.wheel.is_some() && local == 0) || !self.damping_force.is_empty();
        let is_counted = NodePass::counts(&self.dissipated, rule.damping);
        if is_counted && !comes_between && !layout.periodic {
            in_registers(&mut NodePass {
                rule: *rule,
                stride: layout.stride,
                columns,
                forces: &scratch.elements,
                v: &mut self.v[own.clone()],
                a: &mut self.a[own.clone()],
                force: &mut self.force[own.clone()],
                load: self.load.row(self.first + local),
                mass: &body.mass[all.clone()],
                inverse_mass: &body.inverse_mass[all],
                dissipated: self.dissipated.row(own),
            });
            return scratch.elements.advance();
        }
        let spans = layout.spans(columns);
        let force = &mut scratch.force;
        scratch.elements.assemble(force, &spans);
        scratch.elements.advance();
        layout.fold_period(force);
        let mut row = NodeRow {
            v: &mut self.v[own.clone()],
            a: &mut self.a[own.clone()],
            force: &mut self.force[own.clone()],
            new_force: force,
            new_a: &mut scratch.acceleration,
            load: self.load.row(self.first + local),
            mass: &body.mass[all.clone()],
            inverse_mass: &body.inverse_mass[all],
            damping_force: self.damping_force.get_mut(own.clone()).unwrap_or_default(),
            net: &mut scratch.net,
            dissipated: self.dissipated.row(own.clone()),
        };
        row.damp_stiffness(&rule.scheme, &spans);
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
            row.load = &run.load;
        }
        row.finish(rule, layout, &spans);
    }
}
