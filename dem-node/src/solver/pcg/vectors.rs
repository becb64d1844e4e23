//! All contacts and bodies of a solve, and a pass over them.
//!
//! Contacts inside a block of [`crate::solver::blocks`] are treated block beside block; those across, of the wheel and of
//! glued disks begin a pass before the blocks and end it after them. Whatever is summed up is summed up block by block.

use super::batch::Batch;
use super::body::{Body, Momentum, Products};
use super::group::Kind;
use super::group::Lanes;
use super::special::Special;
use super::wave::{Pass, Wave};
use crate::solver::Problem;
use crate::solver::blocks::{self, Block, Cut};
use crate::solver::lanes::widest;

/// Buffers of the solver.
#[derive(Clone, Debug, Default)]
pub struct Vectors {
    blocks: Vec<Block<Wave>>,
    /// Contacts of bodies of two blocks, of the wheel and of glued disks.
    outside: Batch,
    /// Bodies of blocks that they touch.
    shore: Vec<u32>,
    bodies: Vec<Body>,
    momenta: Vec<Momentum>,
    special: Special,
}

/// What a pass over the contacts finds.
#[derive(Clone, Copy, Debug, Default)]
pub struct Sums {
    /// u.w and u.z.
    pub uw: f64,
    /// See `uw`.
    pub uz: f64,
    /// Products with W + C.
    pub products: Products,
    /// Squares of the defect with thresholds held, of the true one, and of D r.
    pub held: f64,
    /// See `held`.
    pub defect: f64,
    /// See `held`.
    pub size: f64,
}

impl Vectors {
    /// Takes over a prepared problem.
    pub fn load<K: Kind>(&mut self, problem: &Problem) {
        self.bodies.clear();
        self.bodies.extend(problem.movers.iter().map(Body::new));
        self.momenta.clear();
        self.momenta.resize(self.bodies.len(), [0.0; 3]);
        self.special.load(problem, &mut self.bodies);
        self.share_out(problem);
        self.outside.load::<K>(problem);
        for block in &mut self.blocks {
            block.work.batch.load::<K>(problem);
            block.work.plan(block.bodies.len(), problem.friction);
        }
    }

    /// Finds for each contact who treats it.
    fn share_out(&mut self, problem: &Problem) {
        let cut = Cut::new(problem);
        cut.lay(&mut self.blocks);
        for block in &mut self.blocks {
            block.work.batch.clear(block.bodies.start);
        }
        self.outside.clear(0);
        self.shore.clear();
        for (index, contact) in problem.contacts.iter().enumerate() {
            let pair = [contact.a, contact.b];
            let special = pair.iter().any(|body| self.special.holds(*body as usize));
            if let Some(block) = cut.common(contact.a, contact.b).filter(|_| !special) {
                self.blocks[block].work.batch.members.push(index as u32);
                continue;
            }
            self.outside.members.push(index as u32);
            for body in pair {
                if std::mem::take(&mut self.bodies[body as usize].inner) > 0.0 {
                    self.shore.push(body);
                }
            }
        }
    }

    /// Writes impulses and velocities back.
    pub fn store(&self, problem: &mut Problem) {
        for block in &self.blocks {
            block.work.batch.store(problem);
        }
        self.outside.store(problem);
        for (mover, body) in problem.movers.iter_mut().zip(&self.bodies) {
            mover.velocity = body.velocity;
        }
        self.special.store(problem);
    }

    /// One pass over all contacts.
    pub fn run<K: Kind>(&mut self, problem: &Problem, pass: Pass, parallel: bool) -> Sums {
        widest(
            #[inline(always)]
            || self.begin::<K>(problem, pass),
        );
        let work = |block: &mut Block<Wave>, (bodies, momenta): (&mut [Body], &mut [Momentum])| {
            widest(
                #[inline(always)]
                || block.work.run::<K>(pass, bodies, momenta),
            );
        };
        let items = (&mut self.bodies[..], &mut self.momenta[..]);
        blocks::each(&mut self.blocks, items, parallel, &work);
        widest(
            #[inline(always)]
            || self.end::<K>(problem),
        )
    }

    #[inline(always)]
    fn begin<K: Kind>(&mut self, problem: &Problem, pass: Pass) {
        if let Pass::Step { alpha, beta } = pass {
            self.special.follow(&mut self.bodies, alpha, beta);
        }
        let (bodies, special) = (&mut self.bodies, &mut self.special);
        let mut give = |body: usize, impulse: [f64; 3]| {
            bodies[body].kick(impulse);
            special.note(body, impulse);
        };
        let outside = &mut self.outside;
        for g in 0..outside.places.len() {
            match pass {
                Pass::Look => {}
                Pass::Renew => outside.renew_limits::<K>(g, problem.friction, &mut give),
                Pass::Step { alpha, beta } => {
                    outside.advance::<K>(g, [alpha, beta], &mut give);
                }
            }
        }
        self.special.settle(&problem.wall, &mut self.bodies);
    }

    #[inline(always)]
    fn end<K: Kind>(&mut self, problem: &Problem) -> Sums {
        let bodies = &mut self.bodies[..];
        self.outside.sums = Default::default();
        for g in 0..self.outside.places.len() {
            self.outside.measure::<K>(g, problem.friction, bodies);
        }
        let mut sums = Sums::default();
        for block in &self.blocks {
            sums.products.join(&block.work.products);
            sums.take(&block.work.batch);
        }
        sums.take(&self.outside);
        let products = &mut sums.products;
        for place in self.shore.iter().map(|body| *body as usize) {
            let body = &self.bodies[place];
            products.add(body.inverse_mass, &body.push, &self.momenta[place]);
        }
        self.lose(products);
        self.special
            .measure(&problem.wall, &self.bodies, &self.momenta, products);
        sums
    }

    /// What p has lost on bodies on which contacts from outside act.
    fn lose(&mut self, products: &mut Products) {
        let inside = self.blocks.iter_mut().map(|block| &mut block.work.batch);
        for batch in inside.chain([&mut self.outside]) {
            for loss in batch.losses.drain(..) {
                let place = batch.first + loss.body as usize;
                let (body, momentum) = (&self.bodies[place], &mut self.momenta[place]);
                products.lose(body.inverse_mass, &body.push, momentum, &loss.impulse);
                self.special.note(place, loss.impulse);
            }
        }
    }
}

impl Sums {
    /// Adds what a batch has summed up.
    fn take(&mut self, batch: &Batch) {
        let sums = &batch.sums;
        let add = |sum: &mut f64, lanes: Lanes| *sum += lanes.sum();
        add(&mut self.uw, sums.uw);
        add(&mut self.uz, sums.uz);
        add(&mut self.products.wp, sums.wp);
        add(&mut self.products.ww, sums.ww);
        add(&mut self.products.wz, sums.wz);
        add(&mut self.products.zz, sums.zz);
        add(&mut self.held, sums.held);
        add(&mut self.defect, sums.defect);
        add(&mut self.size, sums.size);
    }
}
