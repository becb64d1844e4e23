//! Explicit time integration, and the energies that it moves.
//!
//! The scheme is Newmark's with beta = 0 and gamma = b (the paper's eq 12, regrouped so that a force that begins
//! at t_n acts from t_n on), C_d = c M the mass damping, f the sum of all applied forces:
//!
//! ```text
//! a  = M^-1 (f - F(u) - C_d v)                        at the start of a window
//! u' = u + h v + h^2/2 a                              then m times
//! a' = M^-1 (f' - F(u') - C_d v')
//! v' = v + h [(1-b) a + b a']
//! ```
//!
//! C_d is diagonal like M, so v' in a' costs nothing: with p = M^-1 (f' - F(u')),
//! a' = p - c (v + h [(1-b) a + b p]) / (1 + b h c). The limit h < sqrt(2/b)/omega_max then holds for any c: for one
//! mode 1 + trace + det = (4 - 2 b (omega h)^2 + 2 (2b-1) c h) / (1 + b c h). Taking v instead of v' in a' was tried:
//! the damping lags by a step and feeds the modes above omega h = sqrt(2) when b = 1/2.
//!
//! # Energy of one step
//! Write du = u'-u, da = a'-a, dF = F(u')-F(u). From the scheme h v = du - h^2/2 a, and the kinetic energy
//! K = v M v / 2 changes by
//!
//! ```text
//! dK = (v'-v) M (v + (v'-v)/2)
//!    = [(1-b) a + b a'] M du + (b h^2/2) [(1-b) a + b a'] M da
//! ```
//!
//! In the first term M a = f - F - C_d v, so it is W - [(1-b) F + b F'] du - D with
//!
//! ```text
//! W = [(1-b) f + b f'] du                             work of the applied forces
//! D = [(1-b) v + b v'] C_d du                         mass damping
//! ```
//!
//! and (1-b) F + b F' = (F + F')/2 + (b-1/2) dF, where (F + F') du / 2 is the change of the strain energy.
//! In the second term (1-b) a + b a' = (a + a')/2 + (b-1/2) da. What is left is the numerical loss
//!
//! ```text
//! W - dU - dK - D = (b-1/2) (du dF - b h^2/2 da M da) - (b h^2/4) (a'Ma' - aMa)
//! ```
//!
//! The last bracket telescopes inside a window, not across windows: a is computed anew under the new force.

use std::ops::Range;

use rayon::prelude::*;

use crate::element::{Body, Course, RowForces};
use crate::material::point::PointLaw;
use crate::pack::{LANES, Pack};
use crate::wheel::{Wheel, WheelRun};

/// Below this number of elements for each thread, waking the threads costs more than they save: with 2 820 each,
/// two threads are 1.7 times faster than one, with 705 each not at all.
const ELEMENTS_PER_THREAD: usize = 2_500;

/// The numbers of the scheme.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scheme {
    /// Step h (s).
    pub step: f64,
    /// Damping parameter b.
    pub damping: f64,
    /// Mass damping c (1/s).
    pub mass_damping: f64,
}

impl Scheme {
    /// h (1-b) and h b, in every lane.
    #[inline(always)]
    fn weights(&self) -> (Pack, Pack) {
        let (h, b) = (self.step, self.damping);
        (Pack::splat(h * (1.0 - b)), Pack::splat(h * b))
    }

    #[inline(always)]
    fn predicted(&self, u: f64, v: f64, a: f64) -> f64 {
        u + self.increment(v, a)
    }

    #[inline(always)]
    fn increment(&self, v: f64, a: f64) -> f64 {
        self.step * v + 0.5 * self.step * self.step * a
    }
}

/// Mass damping c at the two ends of a step (1/s); it differs where the damping of a start phase ends, and then
/// D = [(1-b) c_n v + b c_n+1 v'] M du.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Damping {
    pub(crate) start: f64,
    pub(crate) end: f64,
}

impl Damping {
    /// The same at both ends.
    pub(crate) fn constant(rate: f64) -> Damping {
        Damping {
            start: rate,
            end: rate,
        }
    }

    fn acts(self) -> bool {
        self.start > 0.0 || self.end > 0.0
    }
}

/// The state of the body, every field in the order of [`crate::element::Layout`].
#[derive(Clone, Debug, PartialEq)]
pub struct State {
    /// Displacement (m).
    pub u: Vec<f64>,
    /// Velocity (m/s).
    pub v: Vec<f64>,
    /// Internal force F(u) (N).
    pub force: Vec<f64>,
    /// Acceleration (m/s2); computed anew at the start of each window of a body without wheel.
    pub a: Vec<f64>,
    /// What the points of a plastic body remember, empty for any other; see [`Body::plastic_strain`].
    pub history: Vec<f64>,
}

impl State {
    /// At rest, undeformed.
    pub fn at_rest(body: &Body) -> State {
        let zero = vec![0.0; body.layout().len()];
        State {
            u: zero.clone(),
            v: zero.clone(),
            force: zero.clone(),
            a: zero,
            history: Vec::new(),
        }
    }

    /// At rest, undeformed, under a law that may be more than linear.
    pub fn at_rest_under(body: &Body, law: Option<&PointLaw>) -> State {
        let rows = body.layout().node_rows() - 1;
        let remembered = law.map_or(0, |law| rows * body.history_row_len(law));
        State {
            history: vec![0.0; remembered],
            ..State::at_rest(body)
        }
    }

    /// Takes over what a window starts from; the accelerations follow from it.
    pub fn restore(&mut self, start: &State) {
        self.u.copy_from_slice(&start.u);
        self.v.copy_from_slice(&start.v);
        self.force.copy_from_slice(&start.force);
        self.history.copy_from_slice(&start.history);
    }

    /// Takes over what a window starts from, the accelerations included: contact forces do not jump there.
    pub(crate) fn resume(&mut self, start: &State) {
        self.restore(start);
        self.a.copy_from_slice(&start.a);
    }

    /// a = M^-1 (f - F(u)) - c v
    pub(crate) fn accelerate(&mut self, body: &Body, damping: f64, load: &Load) {
        let forces = load.values.iter().zip(&self.force).zip(&body.inverse_mass);
        for ((a, v), ((f, internal), w)) in self.a.iter_mut().zip(&self.v).zip(forces) {
            *a = w * (f - internal) - damping * v;
        }
    }
}

/// Applied nodal forces (N), nearly all of them zero.
#[derive(Clone, Debug)]
pub(crate) struct Load {
    values: Vec<f64>,
    touched: Vec<usize>,
    loaded_rows: Vec<bool>,
    row_len: usize,
    zero_row: Vec<f64>,
}

impl Load {
    pub(crate) fn none(body: &Body) -> Load {
        let layout = body.layout();
        Load {
            values: vec![0.0; layout.len()],
            touched: Vec::new(),
            loaded_rows: vec![false; layout.node_rows()],
            row_len: layout.row_len(),
            zero_row: vec![0.0; layout.row_len()],
        }
    }

    pub(crate) fn clear(&mut self) {
        for index in self.touched.drain(..) {
            self.values[index] = 0.0;
            self.loaded_rows[index / self.row_len] = false;
        }
    }

    pub(crate) fn add(&mut self, index: usize, force: f64) {
        self.values[index] += force;
        self.touched.push(index);
        self.loaded_rows[index / self.row_len] = true;
    }

    /// Forces on the upper row.
    pub(crate) fn upper_row(&self) -> &[f64] {
        self.row(0)
    }

    /// Force on a component (N).
    pub(crate) fn at(&self, index: usize) -> f64 {
        self.values[index]
    }

    /// A row of nodes; the many rows without load share one row of zeros, which stays in the cache.
    fn row(&self, row: usize) -> &[f64] {
        match self.loaded_rows[row] {
            true => &self.values[row * self.row_len..(row + 1) * self.row_len],
            false => &self.zero_row,
        }
    }
}

/// What a row of nodes has moved between energies since the start of the window (J).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct RowSums {
    /// Sum of du dF - b h^2/2 da M da.
    pub(crate) rotation: f64,
    /// Sum of [(1-b) c v + b c' v'] M du.
    pub(crate) damping: f64,
    /// Dissipated by the elements below the row.
    pub(crate) plastic: f64,
}

/// Room for the forces of one block of rows.
#[derive(Clone, Debug)]
struct Scratch {
    elements: RowForces,
    force: Vec<f64>,
    acceleration: Vec<f64>,
    above: Vec<f64>,
    below: Vec<f64>,
    memory: Memory,
}

/// What a block needs besides when the points remember: increments of displacements, and a copy of the histories
/// above it, whose owner changes them at the same time. Empty when they do not.
#[derive(Clone, Debug, Default)]
struct Memory {
    /// Increments of the row at hand and of the one below it.
    here: Vec<f64>,
    next: Vec<f64>,
    above: Vec<f64>,
    below: Vec<f64>,
    history: Vec<f64>,
}

impl Memory {
    fn new(body: &Body, law: &PointLaw) -> Memory {
        let zero = match law.plastic {
            Some(_) => vec![0.0; body.layout().row_len()],
            None => Vec::new(),
        };
        Memory {
            here: zero.clone(),
            next: zero.clone(),
            above: zero.clone(),
            below: zero,
            history: vec![0.0; body.history_row_len(law)],
        }
    }

    /// Goes down by one row.
    fn advance(&mut self) {
        std::mem::swap(&mut self.here, &mut self.next);
    }
}

/// Steps a body, on one thread or several, with the same bits: whoever computes a row computes it alike.
#[derive(Clone, Debug)]
pub(crate) struct Integrator {
    pub(crate) scheme: Scheme,
    /// Mass damping of the step to come.
    pub(crate) damping: Damping,
    law: Option<PointLaw>,
    scratch: Vec<Scratch>,
}

impl Integrator {
    /// An integrator for a body of `elements`, which may use up to `threads` threads.
    pub(crate) fn new(body: &Body, scheme: Scheme, elements: usize, threads: usize) -> Integrator {
        let worthwhile = threads.min(elements / ELEMENTS_PER_THREAD);
        Integrator::with_blocks(body, scheme, worthwhile.max(1))
    }

    fn with_blocks(body: &Body, scheme: Scheme, blocks: usize) -> Integrator {
        let zero = vec![0.0; body.layout().row_len()];
        let scratch = Scratch {
            elements: RowForces::new(body.layout()),
            force: zero.clone(),
            acceleration: zero.clone(),
            above: zero.clone(),
            below: zero,
            memory: Memory::default(),
        };
        Integrator {
            scheme,
            damping: Damping::constant(scheme.mass_damping),
            law: None,
            scratch: vec![scratch; blocks],
        }
    }

    /// Steps under a law that is more than linear.
    pub(crate) fn under(mut self, body: &Body, law: Option<PointLaw>) -> Integrator {
        if let Some(law) = &law {
            for scratch in &mut self.scratch {
                scratch.memory = Memory::new(body, law);
            }
        }
        self.law = law;
        self
    }

    /// Blocks of rows that are stepped at the same time.
    pub(crate) fn blocks(&self) -> usize {
        self.scratch.len()
    }

    /// One step under `load`, the applied forces at its end, and under the forces of the wheel.
    pub(crate) fn step(
        &mut self,
        body: &Body,
        state: &mut State,
        load: &Load,
        sums: &mut [RowSums],
        wheel: Option<(&Wheel, &mut WheelRun)>,
    ) {
        let rows = body.layout().node_rows();
        self.step_blocks(body, state, load, sums, [0, rows], wheel);
    }

    /// One step of the rows `first .. end` only, all others being at rest and staying there.
    pub(crate) fn step_rows(
        &mut self,
        body: &Body,
        state: &mut State,
        load: &Load,
        sums: &mut [RowSums],
        rows: [usize; 2],
    ) {
        self.step_blocks(body, state, load, sums, rows, None);
    }

    fn step_blocks(
        &mut self,
        body: &Body,
        state: &mut State,
        load: &Load,
        sums: &mut [RowSums],
        rows: [usize; 2],
        wheel: Option<(&Wheel, &mut WheelRun)>,
    ) {
        let rule = Rule {
            scheme: self.scheme,
            damping: self.damping,
        };
        let mut blocks = split(body, &rule.scheme, state, sums, &mut self.scratch, rows);
        blocks.iter_mut().for_each(|block| block.law = self.law);
        if let Some(block) = blocks.first_mut() {
            block.wheel = wheel;
        }
        match blocks.as_mut_slice() {
            [one] => one.step(body, &rule, load),
            many => many
                .par_iter_mut()
                .for_each(|block| block.step(body, &rule, load)),
        }
    }
}

/// How a step is done.
#[derive(Clone, Copy)]
struct Rule {
    scheme: Scheme,
    damping: Damping,
}

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
struct Block<'a> {
    first: usize,
    u: &'a mut [f64],
    v: &'a mut [f64],
    a: &'a mut [f64],
    force: &'a mut [f64],
    /// Histories of the elements below each row; empty if the points do not remember.
    history: &'a mut [f64],
    sums: &'a mut [RowSums],
    scratch: &'a mut Scratch,
    /// Of the block with the upper row, if there is a wheel.
    wheel: Option<(&'a Wheel, &'a mut WheelRun)>,
    /// More than linear elasticity in small strain.
    law: Option<PointLaw>,
}

/// Cuts the rows `first .. end` into as many blocks as there is scratch room for. Each block gets copies of the
/// rows next to it as they will be after the prediction, since their owner changes them at the same time.
fn split<'a>(
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
    let mut force = state.force[places].chunks_mut(size);
    let mut sums = sums[first..end].chunks_mut(rows);
    let blocks = starts.zip(scratch).map_while(|(first, scratch)| {
        Some(Block {
            first,
            u: u.next()?,
            v: v.next()?,
            a: a.next()?,
            force: force.next()?,
            history: history.next().unwrap_or_default(),
            sums: sums.next()?,
            scratch,
            wheel: None,
            law: None,
        })
    });
    blocks.collect()
}

fn copy_neighbours(
    body: &Body,
    scheme: &Scheme,
    state: &State,
    [first, end]: [usize; 2],
    room: &mut Scratch,
) {
    let memory = &mut room.memory;
    if first > 0 {
        predict_copy(body, scheme, state, first - 1, &mut room.above);
        increment_copy(body, scheme, state, first - 1, &mut memory.above);
        let size = memory.history.len();
        let above = (first - 1) * size..first * size;
        memory.history.copy_from_slice(&state.history[above]);
    }
    if end < body.layout().node_rows() {
        predict_copy(body, scheme, state, end, &mut room.below);
        increment_copy(body, scheme, state, end, &mut memory.below);
    }
}

fn predict_copy(body: &Body, scheme: &Scheme, state: &State, row: usize, into: &mut [f64]) {
    let row = body.layout().row(row);
    let (u, v, a) = (&state.u[row.clone()], &state.v[row.clone()], &state.a[row]);
    for (copy, ((u, v), a)) in into.iter_mut().zip(u.iter().zip(v).zip(a)) {
        *copy = scheme.predicted(*u, *v, *a);
    }
}

/// The increments that [`predict_copy`] adds; `into` is empty where nobody asks for them.
fn increment_copy(body: &Body, scheme: &Scheme, state: &State, row: usize, into: &mut [f64]) {
    let row = body.layout().row(row);
    let rates = state.v[row.clone()].iter().zip(&state.a[row]);
    for (copy, (v, a)) in into.iter_mut().zip(rates) {
        *copy = scheme.increment(*v, *a);
    }
}

impl Block<'_> {
    /// One sweep from the upper to the lower row: predict the next row, compute the elements above it, then
    /// finish the row whose forces are complete. Every number is touched while it is in the cache.
    fn step(&mut self, body: &Body, rule: &Rule, load: &Load) {
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
                u: [above, &self.u[..above.len()]],
                du: [&memory.above, &memory.next],
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
            u: [here, if inside { &rest[..size] } else { below }],
            du: [
                &memory.here,
                if inside { &memory.next } else { &memory.below },
            ],
            history: &mut self.history[local * remembered..(local + 1) * remembered],
        };
        self.sums[local].plastic += body.element_row_by(law, self.first + local, course, elements);
    }

    fn predict(&mut self, scheme: &Scheme, local: usize) {
        let size = self.scratch.force.len();
        let row = local * size..(local + 1) * size;
        self.remember_increment(scheme, row.clone());
        let rates = self.v[row.clone()].iter().zip(&self.a[row.clone()]);
        for (u, (v, a)) in self.u[row].iter_mut().zip(rates) {
            *u = scheme.predicted(*u, *v, *a);
        }
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
            ..
        } = &mut *self.scratch;
        elements.assemble(force);
        elements.advance();
        let own = local * force.len()..(local + 1) * force.len();
        let all = body.layout().row(self.first + local);
        let load = match &mut self.wheel {
            Some((wheel, run)) if local == 0 => {
                let upper = UpperRow {
                    u: &self.u[own.clone()],
                    v: &self.v[own.clone()],
                    a: &self.a[own.clone()],
                    force,
                    load: load.row(0),
                    inverse_mass: &body.inverse_mass[all.clone()],
                };
                run.close(wheel, (&rule.scheme, rule.damping), &upper);
                run.load()
            }
            _ => load.row(self.first + local),
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
        let (scheme, damping) = (&rule.scheme, rule.damping);
        row.accelerate(scheme, damping.end);
        let sums = &mut self.sums[local];
        if scheme.damping > 0.5 {
            sums.rotation += row.rotation(scheme);
        }
        if damping.acts() {
            sums.damping += row.damping(scheme, damping);
        }
        row.correct(scheme);
    }
}

/// A row of nodes whose displacements are new and whose other fields are still old.
struct Row<'a> {
    v: &'a mut [f64],
    a: &'a mut [f64],
    force: &'a mut [f64],
    new_force: &'a [f64],
    new_a: &'a mut [f64],
    load: &'a [f64],
    mass: &'a [f64],
    inverse_mass: &'a [f64],
}

impl Row<'_> {
    /// a' = p - c (v + h [(1-b) a + b p]) / (1 + b h c), p = M^-1 (f' - F(u'))
    fn accelerate(&mut self, scheme: &Scheme, c: f64) {
        let (h, b) = (scheme.step, scheme.damping);
        let drag = Pack::splat(c / (1.0 + b * h * c));
        let (old, new) = scheme.weights();
        for k in (0..self.new_a.len()).step_by(LANES) {
            let net = Pack::load(self.load, k) - Pack::load(self.new_force, k);
            let p = Pack::load(self.inverse_mass, k) * net;
            let undamped = Pack::load(self.v, k) + (old * Pack::load(self.a, k) + new * p);
            (p - drag * undamped).store(self.new_a, k);
        }
    }

    /// du dF - b h^2/2 da M da
    fn rotation(&self, scheme: &Scheme) -> f64 {
        let h = Pack::splat(scheme.step);
        let half = Pack::splat(0.5 * scheme.step * scheme.step);
        let weight = Pack::splat(0.5 * scheme.damping * scheme.step * scheme.step);
        let mut sum = Pack::splat(0.0);
        for k in (0..self.new_a.len()).step_by(LANES) {
            let a = Pack::load(self.a, k);
            let du = h * Pack::load(self.v, k) + half * a;
            let d_force = Pack::load(self.new_force, k) - Pack::load(self.force, k);
            let da = Pack::load(self.new_a, k) - a;
            sum = sum + (du * d_force - weight * Pack::load(self.mass, k) * da * da);
        }
        sum.sum()
    }

    /// [(1-b) c v + b c' v'] M du
    fn damping(&self, scheme: &Scheme, damping: Damping) -> f64 {
        let h = Pack::splat(scheme.step);
        let half = Pack::splat(0.5 * scheme.step * scheme.step);
        let start = Pack::splat((1.0 - scheme.damping) * damping.start);
        let end = Pack::splat(scheme.damping * damping.end);
        let mut sum = Pack::splat(0.0);
        for k in (0..self.new_a.len()).step_by(LANES) {
            let v = Pack::load(self.v, k);
            let drag = start * v + end * self.new_velocity(scheme, k);
            let du = h * v + half * Pack::load(self.a, k);
            sum = sum + drag * Pack::load(self.mass, k) * du;
        }
        sum.sum()
    }

    /// v' = v + h [(1-b) a + b a']
    #[inline(always)]
    fn new_velocity(&self, scheme: &Scheme, k: usize) -> Pack {
        let (old, new) = scheme.weights();
        Pack::load(self.v, k) + (old * Pack::load(self.a, k) + new * Pack::load(self.new_a, k))
    }

    /// The new fields become the old ones.
    fn correct(&mut self, scheme: &Scheme) {
        for k in (0..self.new_a.len()).step_by(LANES) {
            self.new_velocity(scheme, k).store(self.v, k);
        }
        self.a.copy_from_slice(self.new_a);
        self.force.copy_from_slice(self.new_force);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::{ElementKind, MaterialConfig, Plane};
    use crate::element::Supports;
    use crate::material::Elastic;
    use crate::mesh::Mesh;

    /// A skewed body of 9 x 7 elements with E = density = 1, stepped under two forces.
    fn stepped(blocks: usize, rows: [usize; 2], steps: usize) -> (State, Vec<RowSums>) {
        let mesh = Mesh::structured(9, 7, |i, j| [i as f64 + 0.2 * j as f64, -(j as f64)]);
        let material = MaterialConfig::elastic(1.0, 0.3, 1.0);
        let elastic = Elastic::new(&material, Plane::Strain);
        let supports = Supports::default();
        let body = Body::new(&mesh, ElementKind::Q4OnePoint, &elastic, supports, 1.0);
        let scheme = Scheme {
            step: 0.3,
            damping: 0.75,
            mass_damping: 0.1,
        };
        let mut integrator = Integrator::with_blocks(&body, scheme, blocks);
        let mut load = Load::none(&body);
        load.add(body.layout().index([3, 0], 1), -1.0);
        load.add(body.layout().index([7, 0], 0), 0.5);
        let mut state = State::at_rest(&body);
        state.accelerate(&body, scheme.mass_damping, &load);
        let mut sums = vec![RowSums::default(); body.layout().node_rows()];
        for _ in 0..steps {
            integrator.step_rows(&body, &mut state, &load, &mut sums, rows);
        }
        (state, sums)
    }

    #[test]
    fn blocks_do_not_change_a_bit() {
        let one = stepped(1, [0, 8], 50);
        for blocks in [2, 3, 5, 8, 20] {
            assert_eq!(stepped(blocks, [0, 8], 50), one, "{blocks} blocks");
        }
    }

    #[test]
    fn rows_that_nothing_has_reached_can_be_left_out() {
        let (all, _) = stepped(1, [0, 8], 3);
        let (reached, _) = stepped(2, [0, 4], 3);
        assert_eq!(all.u, reached.u);
    }
}
