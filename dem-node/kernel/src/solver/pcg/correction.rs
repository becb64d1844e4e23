//! Iterations on a large bonded problem without friction, in single precision: they compute the change of impulses and velocities since the start of
//! a solve. Four digits of it are enough, and a sweep loads half the bytes.
//!
//! Bonded contacts ([`super::bonded`]) are treated subdomain beside subdomain, after the contacts across subdomains. The other contacts, without a
//! bond, of the wheel and of glued disks, and their bodies are a problem of their own in double precision: the *outer problem*. In an iteration it
//! moves its bodies, passes their velocities to the other contacts, and receives their H w.
//!
//! At the end the impulses are r0 + dr and the velocities v0 + M^-1 H dr, in double precision; the true residual is computed as in any solve. Where
//! it is above the tolerance, the solve restarts from there.

use super::batch::Pass;
use super::bonded::{BondedBatch, SingleBodies, follow, suits_bond};
use super::group::{PassSums, With};
use super::workspace::Workspace;
use crate::law::lanes::widest;
use crate::solver::contact::Contact;
use crate::solver::partition::{Partition, Subdomain, for_each_subdomain};
use crate::solver::pieces::ByCandidate;
use crate::solver::problem::Problem;

/// Largest share of the contacts in the outer problem, which is solved by one thread.
const OUTER_SHARE: f64 = 0.1;

/// Features of the outer problem.
type Outer = With<true, true, true>;

/// Buffers of the correction.
#[derive(Clone, Debug, Default)]
pub struct Correction {
    subdomains: Vec<Subdomain<Interior>>,
    /// Bonded contacts of bodies of two subdomains.
    across: BondedBatch,
    bodies: SingleBodies,
    /// The outer problem and its iterations.
    outer: Problem,
    workspace: Workspace,
    /// Contacts of the outer problem in the whole problem.
    members: Vec<u32>,
    /// Bodies of the outer problem that are neither glued nor the wheel, with their velocities at the start of the solve (m/s).
    shared: Vec<(u32, [f64; 3])>,
    /// Number of each body in the outer problem, if it is there.
    numbers: Vec<u32>,
}

/// Contacts of a subdomain.
#[derive(Clone, Debug, Default)]
struct Interior {
    batch: BondedBatch,
    /// Contacts of which its bodies are the candidates: bonded contacts with a body of another subdomain, and contacts of the outer problem.
    across: Vec<u32>,
    outside: Vec<u32>,
    sums: PassSums<f64>,
}

/// Number of a body that is not in the outer problem.
const INSIDE: u32 = u32::MAX;

/// True for a problem that suits this form: bonds without friction, and several subdomains.
pub fn suits(problem: &Problem) -> bool {
    Partition::new(problem.contacts.len(), problem.records.len()).several()
        && !problem.bonds.is_empty()
        && !problem.has_friction()
        && problem.levers.is_empty()
        && problem.boundary.feet.is_empty()
}

impl Correction {
    /// Loads a prepared problem with its first guess, and takes its boundary until [`Correction::store`]; false, without taking it, where the outer
    /// problem would be too large a part.
    pub fn load(&mut self, problem: &mut Problem, parallel: bool) -> bool {
        let partition = Partition::new(problem.contacts.len(), problem.records.len());
        partition.assign(&mut self.subdomains);
        let whole = &*problem;
        let mut bodies = vec![(); whole.records.len()];
        let all = ByCandidate::all(&mut bodies, &whole.contacts[..]);
        for_each_subdomain(&mut self.subdomains, all, parallel, &|subdomain, piece| {
            let inside = &mut subdomain.work;
            inside.batch.start();
            inside.across.clear();
            inside.outside.clear();
            for (index, contact) in (piece.passed as u32..).zip(piece.contacts) {
                let mut bodies = [contact.a, contact.b].into_iter();
                let held = bodies.any(|body| whole.is_constrained(body as usize));
                let bond = whole.bonds.get(contact.bond as usize);
                let bond = bond.filter(|bond| !held && suits_bond(contact, bond));
                match bond {
                    Some(bond) if subdomain.bodies.contains(&(contact.b as usize)) => {
                        let u = whole.relative_velocity(contact);
                        inside.batch.push(index, (contact, bond), u, piece.first);
                    }
                    Some(_) => inside.across.push(index),
                    None => inside.outside.push(index),
                }
            }
            inside.batch.end();
        });
        let outside = self.subdomains.iter().map(|s| s.work.outside.len());
        if outside.sum::<usize>() as f64 > OUTER_SHARE * problem.contacts.len() as f64 {
            return false;
        }
        self.bodies.load(&problem.records);
        self.across.start();
        for index in self.subdomains.iter().flat_map(|s| &s.work.across) {
            let contact = &problem.contacts[*index as usize];
            let bond = &problem.bonds[contact.bond as usize];
            let u = problem.relative_velocity(contact);
            self.across.push(*index, (contact, bond), u, 0);
        }
        self.across.end();
        self.load_outer(problem);
        self.workspace.load_outside::<Outer>(&self.outer);
        true
    }

    /// Makes the outer problem.
    fn load_outer(&mut self, problem: &mut Problem) {
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
            if self.numbers[body as usize] == INSIDE && !problem.is_constrained(body as usize) {
                let record = problem.records[body as usize];
                self.numbers[body as usize] = outer.records.len() as u32;
                outer.records.push(record);
                self.bodies.leave(body);
                self.shared.push((body, record.velocity));
            }
        }
        outer.first_glued = outer.records.len();
        let disks = problem.boundary.disks() - problem.surface_points;
        outer.surface_points = problem.surface_points;
        let glued = problem.first_glued..problem.first_glued + disks;
        outer.wheel = problem.wheel.map(|_| outer.first_glued + glued.len());
        outer.wheel_turn = problem.wheel_turn;
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

    /// Loads the bonds of these contacts, which have become softer since [`Correction::store`], and takes the boundary again; false, without taking
    /// it, where a bond has become too soft for this form.
    pub fn soften(&mut self, problem: &mut Problem, softened: &[u32], parallel: bool) -> bool {
        for index in softened {
            let contact = &problem.contacts[*index as usize];
            let bond = &problem.bonds[contact.bond as usize];
            if let Ok(place) = self.members.binary_search(index) {
                let own = self.outer.contacts[place].bond as usize;
                self.outer.bonds[own] = *bond;
                self.workspace.soften(&self.outer, &[place as u32]);
                continue;
            }
            if !suits_bond(contact, bond) {
                return false;
            }
            let u = problem.relative_velocity(contact);
            let mut inside = self.subdomains.iter_mut();
            let taken = inside.any(|Subdomain { bodies, work }| {
                let velocities = self.bodies.velocities(bodies.clone());
                let pair = (contact, bond);
                work.batch.soften(*index, pair, u, velocities)
            });
            if !taken {
                let all = self.bodies.velocities(0..problem.records.len());
                self.across.soften(*index, (contact, bond), u, all);
            }
        }
        self.outer.boundary = std::mem::take(&mut problem.boundary);
        self.workspace.restart(parallel);
        true
    }

    /// One pass over all contacts.
    pub fn run(&mut self, pass: Pass, parallel: bool) -> PassSums<f64> {
        let (factors, pass) = in_single(pass);
        self.workspace.advance::<Outer>(&self.outer, pass, parallel);
        for (number, (body, start)) in self.shared.iter().enumerate() {
            let v = self.workspace.bodies[number].velocity;
            self.bodies
                .place(*body, [0, 1, 2].map(|axis| v[axis] - start[axis]));
        }
        let all = self.bodies.all();
        for_each_subdomain(&mut self.subdomains, all, parallel, &|_, bodies| {
            widest!(follow(bodies, factors));
        });
        let mut all = self.bodies.all();
        let mut sums = widest!(self.across.iterate(factors, &mut all));
        for_each_subdomain(&mut self.subdomains, all, parallel, &|subdomain, bodies| {
            let Interior { batch, sums, .. } = &mut subdomain.work;
            *sums = widest!(batch.iterate_inside(factors, bodies));
        });
        for (number, (body, _)) in self.shared.iter().enumerate() {
            let sum = self.workspace.bodies[number].h_w.iter_mut();
            sum.zip(self.bodies.h_w(*body))
                .for_each(|(sum, more)| *sum += more);
        }
        for subdomain in &self.subdomains {
            sums.join(&subdomain.work.sums);
        }
        sums.join(&self.workspace.measure::<Outer>(&self.outer));
        sums
    }

    /// Writes impulses and velocities back, in double precision.
    pub fn store(&mut self, problem: &mut Problem, parallel: bool) {
        self.workspace.store(&mut self.outer, parallel);
        problem.boundary = std::mem::take(&mut self.outer.boundary);
        let all = ByCandidate::all(&mut problem.records, &mut problem.contacts[..]);
        for_each_subdomain(&mut self.subdomains, all, parallel, &|subdomain, piece| {
            for (index, change) in subdomain.work.batch.changes() {
                let contact = &mut piece.contacts[index as usize - piece.passed];
                contact.impulse = [0, 1].map(|axis| contact.impulse[axis] + change[axis]);
                contact.push(piece.bodies, piece.first, change);
            }
        });
        let solved = self.members.iter().zip(&self.outer.contacts);
        let outer = solved.map(|(index, contact)| {
            let before = problem.contacts[*index as usize].impulse;
            let change = [0, 1].map(|axis| contact.impulse[axis] - before[axis]);
            (*index, change)
        });
        let changes: Vec<(u32, [f64; 2])> = self.across.changes().chain(outer).collect();
        for (index, change) in changes {
            add_impulse(problem, index as usize, change);
        }
    }
}

/// Adds to the impulse of a contact, and to the velocities of its bodies, except glued disks, which follow their boundary.
fn add_impulse(problem: &mut Problem, index: usize, change: [f64; 2]) {
    let contact = problem.contacts[index];
    let [x, y] = contact.in_xy(change);
    for (side, body, force) in [(0, contact.a, [x, y]), (1, contact.b, [-x, -y])] {
        if problem.glued_index(body as usize).is_none() {
            problem.apply_to(&contact, side, force, change);
        }
    }
    problem.contacts[index].impulse = [0, 1].map(|axis| contact.impulse[axis] + change[axis]);
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
