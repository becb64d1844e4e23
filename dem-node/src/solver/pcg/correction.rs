//! Iterations on a large bonded problem without friction, in single precision: they find the change of impulses and velocities since the
//! start of a solve, of which four digits are enough, and a sweep moves half the bytes.
//!
//! Inside the subdomains are bonded contacts alone ([`super::bonded`]). What is left, the contacts across subdomains and without a bond, of
//! the wheel and of glued disks, is a problem of its own in double precision, with the bodies on which these act: the *outer problem*. In
//! an iteration it moves its bodies, gives their velocities to the subdomains, and takes over the H w that these have found for them.
//!
//! At the end the impulses are r0 + dr and the velocities v0 + M^-1 H dr, in double precision; the true residual is that of any solve. Where it
//! is above the tolerance, the solve begins anew from there.

use super::batch::Pass;
use super::bonded::{BondedBatch, holds};
use super::group::{PassSums, With};
use super::workspace::Workspace;
use crate::law::lanes::widest;
use crate::solver::contact::Contact;
use crate::solver::partition::{Partition, Subdomain, for_each_subdomain};
use crate::solver::pieces::ByCandidate;
use crate::solver::problem::Problem;

/// Least share of bonds among the contacts: the outer problem is solved by one thread.
const BONDED: f64 = 0.9;

/// All that the outer problem can contain.
type Outer = With<true, true, true>;

/// Buffers of the correction.
#[derive(Clone, Debug, Default)]
pub struct Correction {
    subdomains: Vec<Subdomain<Interior>>,
    /// The outer problem and its iterations.
    outer: Problem,
    workspace: Workspace,
    /// Its contacts in the whole problem.
    members: Vec<u32>,
    /// Subdomain, and number there, of each of its bodies that are neither glued nor the wheel.
    shared: Vec<[usize; 2]>,
    /// Number of each body in the outer problem, if it is there.
    numbers: Vec<u32>,
}

/// What a subdomain holds.
#[derive(Clone, Debug, Default)]
struct Interior {
    batch: BondedBatch,
    /// Its contacts that belong to the outer problem.
    outside: Vec<u32>,
    sums: PassSums<f64>,
}

/// A body that is not in the outer problem.
const INSIDE: u32 = u32::MAX;

/// True for a problem for which this form is made: bonds without friction, enough of them for several subdomains.
pub fn suits(problem: &Problem) -> bool {
    let (contacts, bonds) = (problem.contacts.len(), problem.bonds.len());
    Partition::new(contacts, problem.records.len()).several()
        && bonds as f64 >= BONDED * contacts as f64
        && !problem.has_friction()
        && problem.levers.is_empty()
}

impl Correction {
    /// Takes over a prepared problem with its first guess, and its boundary until [`Correction::store`].
    pub fn load(&mut self, problem: &mut Problem, parallel: bool) {
        let partition = Partition::new(problem.contacts.len(), problem.records.len());
        partition.assign(&mut self.subdomains);
        let whole = &*problem;
        let mut bodies = vec![(); whole.records.len()];
        let all = ByCandidate {
            bodies: &mut bodies[..],
            contacts: &whole.contacts[..],
            first: 0,
            passed: 0,
        };
        for_each_subdomain(&mut self.subdomains, all, parallel, &|subdomain, piece| {
            let Interior { batch, outside, .. } = &mut subdomain.work;
            batch.start(&whole.records[subdomain.bodies.clone()]);
            outside.clear();
            for (index, contact) in (piece.passed as u32..).zip(piece.contacts) {
                let inside = subdomain.bodies.contains(&(contact.b as usize));
                let held = [contact.a, contact.b]
                    .into_iter()
                    .any(|b| is_held(whole, b));
                let bond = whole.bonds.get(contact.bond as usize);
                match bond.filter(|bond| inside && !held && holds(bond)) {
                    Some(bond) => {
                        let u = whole.relative_velocity(contact);
                        batch.push(index, (contact, bond), u, piece.first);
                    }
                    None => outside.push(index),
                }
            }
        });
        self.load_outer(problem, &partition);
        self.workspace.load_outside::<Outer>(&self.outer);
    }

    /// Makes the outer problem.
    fn load_outer(&mut self, problem: &mut Problem, partition: &Partition) {
        self.numbers.clear();
        self.numbers.resize(problem.records.len(), INSIDE);
        self.members.clear();
        for subdomain in &self.subdomains {
            self.members.extend(&subdomain.work.outside);
        }
        self.shared.clear();
        let outer = &mut self.outer;
        outer.records.clear();
        let contacts = self.members.iter().map(|i| &problem.contacts[*i as usize]);
        for body in contacts.clone().flat_map(|contact| [contact.a, contact.b]) {
            if self.numbers[body as usize] == INSIDE && !is_held(problem, body) {
                self.numbers[body as usize] = outer.records.len() as u32;
                outer.records.push(problem.records[body as usize]);
                let [subdomain, place] = partition.place(body);
                self.subdomains[subdomain].work.batch.leave(place);
                self.shared.push([subdomain, place]);
            }
        }
        outer.first_glued = outer.records.len();
        let glued = problem.first_glued..problem.first_glued + problem.boundary.disks();
        outer.wheel = problem.wheel.map(|_| outer.first_glued + glued.len());
        for body in glued.chain(problem.wheel) {
            self.numbers[body] = outer.records.len() as u32;
            outer.records.push(problem.records[body]);
        }
        outer.bonds.clear();
        outer.contacts.clear();
        for contact in contacts {
            let bond = problem.bonds.get(contact.bond as usize);
            outer.contacts.push(Contact {
                a: self.numbers[contact.a as usize],
                b: self.numbers[contact.b as usize],
                bond: bond.map_or(contact.bond, |_| outer.bonds.len() as u32),
                ..*contact
            });
            outer.bonds.extend(bond);
        }
        outer.boundary = std::mem::take(&mut problem.boundary);
    }

    /// One pass over all contacts.
    pub fn run(&mut self, pass: Pass, parallel: bool) -> PassSums<f64> {
        let (factors, pass) = in_single(pass);
        self.workspace.advance::<Outer>(&self.outer, pass, parallel);
        for (number, [subdomain, place]) in self.shared.iter().enumerate() {
            let (v, start) = (
                self.workspace.velocity(number),
                self.outer.records[number].velocity,
            );
            let change = [0, 1, 2].map(|axis| v[axis] - start[axis]);
            self.subdomains[*subdomain].work.batch.place(*place, change);
        }
        for_each_subdomain(&mut self.subdomains, (), parallel, &|subdomain, ()| {
            let Interior { batch, sums, .. } = &mut subdomain.work;
            *sums = widest!(batch.iterate(factors));
        });
        for (number, [subdomain, place]) in self.shared.iter().enumerate() {
            let h_w = self.subdomains[*subdomain].work.batch.h_w(*place);
            self.workspace.add_h_w(number, h_w);
        }
        let mut sums = self.workspace.measure::<Outer>(&self.outer);
        for subdomain in &self.subdomains {
            sums.join(&subdomain.work.sums);
        }
        sums
    }

    /// Writes impulses and velocities back, in double precision.
    pub fn store(&mut self, problem: &mut Problem, parallel: bool) {
        self.workspace.store(&mut self.outer, parallel);
        problem.boundary = std::mem::take(&mut self.outer.boundary);
        let all = ByCandidate {
            bodies: &mut problem.records[..],
            contacts: &mut problem.contacts[..],
            first: 0,
            passed: 0,
        };
        for_each_subdomain(&mut self.subdomains, all, parallel, &|subdomain, piece| {
            for (index, change) in subdomain.work.batch.changes() {
                let contact = &mut piece.contacts[index as usize - piece.passed];
                contact.impulse = [0, 1].map(|axis| contact.impulse[axis] + change[axis]);
                let (lever, [x, y]) = (contact.lever(), contact.in_xy(change));
                let [a, b] = [contact.a, contact.b].map(|body| body as usize - piece.first);
                piece.bodies[a].push(lever, [x, y], change);
                piece.bodies[b].push(lever, [-x, -y], change);
            }
        });
        for (index, solved) in self.members.iter().zip(&self.outer.contacts) {
            let before = problem.contacts[*index as usize];
            let change = [0, 1].map(|axis| solved.impulse[axis] - before.impulse[axis]);
            let [x, y] = before.in_xy(change);
            for (side, body, force) in [(0, before.a, [x, y]), (1, before.b, [-x, -y])] {
                if problem.glued_index(body as usize).is_none() {
                    problem.apply_to(&before, side, force, change);
                }
            }
            problem.contacts[*index as usize].impulse = solved.impulse;
        }
    }
}

/// True for a glued disk and the wheel.
fn is_held(problem: &Problem, body: u32) -> bool {
    let body = body as usize;
    problem.glued_index(body).is_some() || problem.wheel == Some(body)
}

/// The factors of a step in single precision, and the pass with them.
fn in_single(pass: Pass) -> ([f32; 2], Pass) {
    match pass {
        Pass::Step { alpha, beta } => {
            let factors = [alpha as f32, beta as f32];
            let [alpha, beta] = factors.map(f64::from);
            (factors, Pass::Step { alpha, beta })
        }
        Pass::Measure | Pass::RenewThresholds => ([0.0; 2], Pass::Measure),
    }
}
