//! All contacts and bodies of a solve, and a pass over them.
//!
//! Contacts inside a subdomain of [`crate::solver::partition`] are treated subdomain beside subdomain; contacts across subdomains, of the wheel, of
//! glued disks and of clusters begin a pass before the subdomains and end it after them. Sums go subdomain by subdomain.

use super::batch::{ContactBatch, Pass};
use super::body_state::{BodyState, Momentum, Products};
use super::constrained::ConstrainedBodies;
use super::group::{Features, PassSums};
use crate::law::lanes::widest;
use crate::solver::partition::{Partition, Subdomain, for_each_subdomain};
use crate::solver::pieces::ByCandidate;
use crate::solver::problem::Problem;

/// Buffers of the solver.
#[derive(Clone, Debug, Default)]
pub struct Workspace {
    subdomains: Vec<Subdomain<Interior>>,
    /// Contacts of bodies of two subdomains, of the wheel, of glued disks and of clusters.
    outside: ContactBatch,
    /// Bodies of subdomains with contacts in `outside`.
    shared: Vec<u32>,
    pub(super) bodies: Vec<BodyState>,
    momenta: Vec<Momentum>,
    constrained: ConstrainedBodies,
}

/// The contacts inside a subdomain.
#[derive(Clone, Debug, Default)]
struct Interior {
    batch: ContactBatch,
    /// Products of its bodies without contacts from outside.
    products: Products<f64>,
}

impl Interior {
    /// A pass over the subdomain; bodies and momenta are its own.
    #[inline(always)]
    fn run<F: Features>(
        &mut self,
        pass: Pass,
        friction: f64,
        bodies: &mut [BodyState],
        momenta: &mut [Momentum],
    ) {
        match pass {
            Pass::Measure => {}
            Pass::RenewThresholds => bodies.iter_mut().for_each(|body| body.h_w = [0.0; 3]),
            Pass::Step { alpha, beta } => {
                for (body, momentum) in bodies.iter_mut().zip(&mut *momenta) {
                    body.follow(momentum, alpha, beta);
                }
            }
        }
        let batch = &mut self.batch;
        batch.advance::<F>(pass, friction, |body, impulse| bodies[body].kick(impulse));
        batch.measure::<F>(friction, bodies);
        self.products = Products::default();
        for (body, momentum) in bodies.iter().zip(&*momenta) {
            self.products.add(body.inner, &body.h_w, momentum);
        }
        self.lose(bodies, momenta);
    }

    /// Subtracts the losses of p from H z, except for bodies with contacts from outside, whose losses stay in the list.
    fn lose(&mut self, bodies: &[BodyState], momenta: &mut [Momentum]) {
        let products = &mut self.products;
        self.batch.losses.retain(|loss| {
            let index = loss.body as usize;
            let body = &bodies[index];
            if body.inner == 0.0 {
                return true;
            }
            products.lose(body.inner, &body.h_w, &mut momenta[index], &loss.impulse);
            false
        });
    }
}

impl Workspace {
    /// Loads a prepared problem.
    pub fn load<F: Features>(&mut self, problem: &Problem, parallel: bool) {
        let partition = Partition::new(problem.contacts.len(), problem.records.len());
        self.load_bodies(problem, &partition);
        self.share_out(problem, |a, b| partition.common(a, b));
        self.outside.load::<F>(problem);
        for_each_subdomain(&mut self.subdomains, (), parallel, &|subdomain, ()| {
            subdomain.work.batch.load::<F>(problem);
        });
    }

    /// Loads a prepared problem whose bodies also have other contacts, with all its contacts as contacts from outside.
    pub fn load_outside<F: Features>(&mut self, problem: &Problem) {
        self.load_bodies(problem, &Partition::new(0, problem.records.len()));
        self.share_out(problem, |_, _| None);
        self.outside.load::<F>(problem);
    }

    /// Loads the softer bonds of these contacts.
    pub fn soften(&mut self, problem: &Problem, softened: &[u32]) {
        for index in softened {
            let inside = self.subdomains.iter_mut();
            let mut batches = inside.map(|subdomain| &mut subdomain.work.batch);
            if !batches.any(|batch| batch.soften(problem, *index)) {
                self.outside.soften(problem, *index);
            }
        }
    }

    /// Forgets p and w: iterations restart at the present impulses and velocities.
    pub fn restart(&mut self, parallel: bool) {
        self.constrained.restart();
        self.outside.restart();
        let forget = |subdomain: &mut Subdomain<Interior>,
                      (bodies, momenta): (&mut [BodyState], &mut [Momentum])| {
            bodies.iter_mut().for_each(|body| body.h_w = [0.0; 3]);
            momenta.fill([0.0; 3]);
            subdomain.work.batch.restart();
        };
        let items = (&mut self.bodies[..], &mut self.momenta[..]);
        for_each_subdomain(&mut self.subdomains, items, parallel, &forget);
    }

    fn load_bodies(&mut self, problem: &Problem, partition: &Partition) {
        self.bodies.clear();
        self.bodies
            .extend(problem.records.iter().map(BodyState::new));
        self.constrained.load(problem, &mut self.bodies);
        self.momenta.clear();
        self.momenta.resize(self.bodies.len(), [0.0; 3]);
        partition.assign(&mut self.subdomains);
    }

    /// Divides the contacts among the subdomains; `common` gives the common subdomain of two bodies.
    fn share_out(&mut self, problem: &Problem, common: impl Fn(u32, u32) -> Option<usize>) {
        for subdomain in &mut self.subdomains {
            subdomain.work.batch.clear(subdomain.bodies.start);
        }
        self.outside.clear(0);
        self.shared.clear();
        for (index, contact) in problem.contacts.iter().enumerate() {
            let pair = [contact.a, contact.b];
            let constrained = &self.constrained;
            let held = pair.iter().any(|body| constrained.holds(*body as usize));
            if let Some(common) = common(contact.a, contact.b).filter(|_| !held) {
                let batch = &mut self.subdomains[common].work.batch;
                batch.members.push(index as u32);
                continue;
            }
            self.outside.members.push(index as u32);
            for body in pair {
                if std::mem::take(&mut self.bodies[body as usize].inner) > 0.0 {
                    self.shared.push(body);
                }
            }
        }
    }

    /// Writes impulses and velocities back.
    pub fn store(&mut self, problem: &mut Problem, parallel: bool) {
        self.outside.store(&mut problem.contacts, 0);
        let all = ByCandidate::all(&mut problem.records, &mut problem.contacts[..]);
        let items = (&self.bodies[..], all);
        for_each_subdomain(
            &mut self.subdomains,
            items,
            parallel,
            &|subdomain, (solved, of)| {
                subdomain.work.batch.store(of.contacts, of.passed);
                for (record, body) in of.bodies.iter_mut().zip(solved) {
                    record.velocity = body.velocity;
                }
            },
        );
        let outside = self.outside.members.iter();
        self.constrained
            .store(problem, outside.map(|member| *member as usize));
    }

    /// One pass over all contacts.
    pub fn run<F: Features>(
        &mut self,
        problem: &Problem,
        pass: Pass,
        parallel: bool,
    ) -> PassSums<f64> {
        self.advance::<F>(problem, pass, parallel);
        self.measure::<F>(problem)
    }

    /// The first half of a pass: bodies and impulses move, and the subdomains are measured.
    pub fn advance<F: Features>(&mut self, problem: &Problem, pass: Pass, parallel: bool) {
        let friction = problem.friction;
        widest!(self.begin::<F>(problem, pass));
        let work = |subdomain: &mut Subdomain<Interior>,
                    (bodies, momenta): (&mut [BodyState], &mut [Momentum])| {
            let interior = &mut subdomain.work;
            widest!(interior.run::<F>(pass, friction, bodies, momenta));
        };
        let items = (&mut self.bodies[..], &mut self.momenta[..]);
        for_each_subdomain(&mut self.subdomains, items, parallel, &work);
    }

    /// The second half: contacts from outside are measured, and sums are computed.
    pub fn measure<F: Features>(&mut self, problem: &Problem) -> PassSums<f64> {
        widest!(self.end::<F>(problem))
    }

    #[inline(always)]
    fn begin<F: Features>(&mut self, problem: &Problem, pass: Pass) {
        if let Pass::Step { alpha, beta } = pass {
            self.constrained.follow(&mut self.bodies, alpha, beta);
        }
        let (bodies, constrained) = (&mut self.bodies, &mut self.constrained);
        let give = |body: usize, impulse: [f64; 3]| {
            bodies[body].kick(impulse);
            constrained.gather(body, impulse);
        };
        let outside = &mut self.outside;
        outside.advance::<F>(pass, problem.friction, give);
        constrained.settle(&problem.boundary, bodies);
    }

    #[inline(always)]
    fn end<F: Features>(&mut self, problem: &Problem) -> PassSums<f64> {
        let outside = &mut self.outside;
        outside.measure::<F>(problem.friction, &mut self.bodies);
        let mut sums = PassSums::<f64>::default();
        for subdomain in &self.subdomains {
            sums.products.join(&subdomain.work.products);
            sums.add(&subdomain.work.batch.sums);
        }
        sums.add(&self.outside.sums);
        let products = &mut sums.products;
        for index in self.shared.iter().map(|body| *body as usize) {
            let body = &self.bodies[index];
            products.add(body.inverse_mass, &body.h_w, &self.momenta[index]);
        }
        self.lose(products);
        self.constrained
            .measure(&problem.boundary, &self.bodies, &self.momenta, products);
        sums
    }

    /// Subtracts the losses of p on bodies with contacts from outside.
    fn lose(&mut self, products: &mut Products<f64>) {
        let inside = self.subdomains.iter_mut();
        let inside = inside.map(|subdomain| &mut subdomain.work.batch);
        for batch in inside.chain([&mut self.outside]) {
            for loss in batch.losses.drain(..) {
                let index = batch.first + loss.body as usize;
                let (body, momentum) = (&self.bodies[index], &mut self.momenta[index]);
                products.lose(body.inverse_mass, &body.h_w, momentum, &loss.impulse);
                self.constrained.gather(index, loss.impulse);
            }
        }
    }
}
