//! The order in which a block is treated, so that what a contact needs is still at hand.
//!
//! The contacts advance chunk after chunk. A chunk is measured as soon as all contacts of its bodies have advanced, which
//! is some columns of grains later: until then its numbers have not left the near caches. In front of the contacts go the
//! bodies, behind them the products of those that no later contact pushes.

use std::ops::Range;

use super::batch::Batch;
use super::body::{Body, Momentum, Products};
use super::group::Kind;
use super::group::LANES;

/// Groups of a chunk.
const CHUNK: usize = 32;

/// What all blocks do in one pass.
#[derive(Clone, Copy, Debug)]
pub enum Pass {
    /// Measure where the contacts are.
    Look,
    /// Take the thresholds of friction anew, then measure.
    Renew,
    /// A step along p, then measure.
    Step {
        /// Length of the step.
        alpha: f64,
        /// p = w + beta z.
        beta: f64,
    },
}

/// How far bodies are moved, chunks advanced and measured, and products made.
#[derive(Clone, Copy, Debug, Default)]
struct Stage {
    moved: usize,
    advanced: usize,
    measured: usize,
    done: usize,
}

/// A block of bodies with the contacts among them.
#[derive(Clone, Debug, Default)]
pub struct Wave {
    /// The contacts.
    pub batch: Batch,
    /// Products of its bodies, as far as nothing acts on them from outside.
    pub products: Products,
    stages: Vec<Stage>,
    /// Coefficient of friction.
    friction: f64,
}

impl Wave {
    /// Finds the stages of its loaded contacts.
    pub fn plan(&mut self, bodies: usize, friction: f64) {
        self.friction = friction;
        let chunks = self.batch.members.len().div_ceil(CHUNK * LANES);
        let touched = |chunk: usize| touched(&self.batch, chunk);
        let mut last = vec![0; bodies];
        for chunk in 0..chunks {
            touched(chunk).for_each(|body| last[body] = chunk);
        }
        let mut least = vec![bodies; chunks + 1];
        for chunk in (0..chunks).rev() {
            least[chunk] = touched(chunk).fold(least[chunk + 1], usize::min);
        }
        self.stages.clear();
        let mut at = Stage::default();
        for chunk in 0..chunks {
            at.advanced = chunk + 1;
            at.moved = touched(chunk).fold(at.moved, |moved, body| moved.max(body + 1));
            while at.measured < chunks && touched(at.measured).all(|body| last[body] <= chunk) {
                at.measured += 1;
            }
            at.done = least[at.measured].min(at.moved);
            self.stages.push(at);
        }
        self.stages.push(Stage {
            moved: bodies,
            done: bodies,
            ..at
        });
    }

    /// A pass over the block; bodies and momenta are its own.
    #[inline(always)]
    pub fn run<K: Kind>(&mut self, pass: Pass, bodies: &mut [Body], momenta: &mut [Momentum]) {
        self.batch.sums = Default::default();
        self.products = Products::default();
        let mut at = Stage::default();
        for index in 0..self.stages.len() {
            let to = self.stages[index];
            self.advance::<K>(pass, [at, to], bodies, momenta);
            for g in self.groups(at.measured, to.measured) {
                self.batch.measure::<K>(g, self.friction, bodies);
            }
            let done = at.done..to.done;
            for (body, momentum) in bodies[done.clone()].iter().zip(&momenta[done]) {
                self.products.add(body.inner, &body.push, momentum);
            }
            at = to;
        }
        self.lose(bodies, momenta);
    }

    /// What comes before measuring.
    #[inline(always)]
    fn advance<K: Kind>(
        &mut self,
        pass: Pass,
        [at, to]: [Stage; 2],
        bodies: &mut [Body],
        momenta: &mut [Momentum],
    ) {
        let groups = self.groups(at.advanced, to.advanced);
        let kick = |bodies: &mut [Body], body: usize, impulse: [f64; 3]| bodies[body].kick(impulse);
        match pass {
            Pass::Look => {}
            Pass::Renew => {
                for body in &mut bodies[at.moved..to.moved] {
                    body.push = [0.0; 3];
                }
                for g in groups {
                    let give = |body, impulse| kick(bodies, body, impulse);
                    self.batch.renew_limits::<K>(g, self.friction, give);
                }
            }
            Pass::Step { alpha, beta } => {
                let moved = at.moved..to.moved;
                let momenta = &mut momenta[moved.clone()];
                for (body, momentum) in bodies[moved].iter_mut().zip(momenta) {
                    body.follow(momentum, alpha, beta);
                }
                for g in groups {
                    let give = |body, impulse| kick(bodies, body, impulse);
                    self.batch.advance::<K>(g, [alpha, beta], give);
                }
            }
        }
    }

    #[inline(always)]
    fn groups(&self, from: usize, to: usize) -> Range<usize> {
        let count = self.batch.places.len();
        count.min(from * CHUNK)..count.min(to * CHUNK)
    }

    /// Takes what p has lost from H z, but for bodies on which contacts from outside act: those are left.
    fn lose(&mut self, bodies: &[Body], momenta: &mut [Momentum]) {
        let products = &mut self.products;
        self.batch.losses.retain(|loss| {
            let place = loss.body as usize;
            let body = &bodies[place];
            if body.inner == 0.0 {
                return true;
            }
            let momentum = &mut momenta[place];
            products.lose(body.inner, &body.push, momentum, &loss.impulse);
            false
        });
    }
}

/// The bodies of the contacts of a chunk.
fn touched(batch: &Batch, chunk: usize) -> impl Iterator<Item = usize> {
    let start = chunk * CHUNK * LANES;
    let end = batch.members.len().min(start + CHUNK * LANES);
    (start..end).flat_map(|i| {
        let (place, k) = (&batch.places[i / LANES], i % LANES);
        [place.a[k] as usize, place.b[k] as usize]
    })
}
