//! The contact problem of one step: its contacts and bodies, the Delassus blocks, and the effect of impulses on velocities.

use super::contact::{BodyRecord, Contact};
use super::partition::{Partition, Subdomain, for_each_subdomain, in_pieces};
use super::pieces::{ByCandidate, WithBonds};
use super::rolling::{self, Couple};
use crate::bodies::levers::Levers;
use crate::contact::bond::BondContact;
use crate::contact::boundary::CompliantBoundary;
use crate::error::KernelError;
use crate::law::cohesion::Cohesion;
use crate::law::local::{DelassusBlock, LocalLaw};

/// The attraction of the bodies of a contact by adhesion, a load on both.
#[derive(Clone, Copy, Debug, Default)]
pub struct Attraction {
    /// The contact.
    pub contact: u32,
    /// Attraction in the last step, and in this step (N).
    pub force: [f64; 2],
    /// Impulse of this step (N s).
    pub impulse: f64,
    /// Gap at the end of the last step (m).
    pub last_gap: f64,
}

/// All contacts and bodies of a step.
#[derive(Clone, Debug, Default)]
pub struct Problem {
    /// Contacts, sorted by (a, b).
    pub contacts: Vec<Contact>,
    /// The bonds among them.
    pub bonds: Vec<BondContact>,
    /// The couples of contacts that resist rolling.
    pub couples: Vec<Couple>,
    /// The attractions of contacts within the range of their adhesion.
    pub attractions: Vec<Attraction>,
    /// The levers of contacts with a body in a cluster.
    pub levers: Vec<Levers>,
    /// Bodies; the entries of glued disks are not used.
    pub records: Vec<BodyRecord>,
    /// First glued disk.
    pub first_glued: usize,
    /// Number of points of surfaces, which follow the glued disks in the boundary, and are no bodies.
    pub surface_points: usize,
    /// First foot on a surface; feet are the last bodies.
    pub first_foot: usize,
    /// The wheel: impulses move it along y only, its sideways velocity is prescribed.
    pub wheel: Option<usize>,
    /// R^2/I of a wheel that spins freely (1/kg); 0 where its spin is prescribed.
    pub wheel_turn: f64,
    /// The boundary that the glued disks belong to.
    pub boundary: CompliantBoundary,
    /// Coefficient of friction of contacts without one of their own.
    pub friction: f64,
    /// Coefficients of friction of the laws by pair.
    pub frictions: Vec<f64>,
    /// Factor on the coefficient of friction of each contact; empty where temperature changes none.
    pub softening: Vec<f64>,
    /// Law of all bonds, and the step (s) in which they may fall; `None` where they have several laws.
    pub cohesion: Option<(Cohesion, f64)>,
    /// Rounding error of a gap over the step (m/s): no residual can be smaller.
    pub rounding: f64,
    /// Least reference of residuals (m/s).
    pub(super) least_size: f64,
}

impl Problem {
    /// Local blocks, local laws, and the effect of the first guess on the velocities.
    ///
    /// Residuals are relative to ||D r||, but to no less than the value with which a defect of pure rounding passes: a group of grains in free motion
    /// has impulses near zero, and would never converge relative to them.
    pub(super) fn prepare(&mut self, tolerance: f64, parallel: bool) -> Result<(), KernelError> {
        let count = self.contacts.len();
        self.least_size = self.rounding * (count.max(1) as f64).sqrt() / tolerance;
        let mut contacts = std::mem::take(&mut self.contacts);
        let mut bonds = std::mem::take(&mut self.bonds);
        let prepared = if Partition::new(count, self.records.len()).several() {
            let all = WithBonds {
                contacts: &mut contacts,
                bonds: &mut bonds,
                first_bond: 0,
            };
            let prepared = in_pieces(count, all, parallel, |range, piece| {
                for (number, contact) in range.zip(piece.contacts) {
                    let bond = (contact.bond as usize).wrapping_sub(piece.first_bond);
                    self.prepare_law(number, contact, piece.bonds.get_mut(bond))?;
                }
                Ok::<(), KernelError>(())
            });
            self.apply_first_guesses(&contacts, parallel);
            prepared.into_iter().collect()
        } else {
            contacts
                .iter_mut()
                .enumerate()
                .try_for_each(|(number, contact)| {
                    self.prepare_law(number, contact, bonds.get_mut(contact.bond as usize))?;
                    self.apply_first_guess(contact);
                    Ok(())
                })
        };
        (self.contacts, self.bonds) = (contacts, bonds);
        rolling::apply(&self.couples, &self.contacts, &mut self.records);
        for attraction in 0..self.attractions.len() {
            self.apply_first_guess(&self.attracting(attraction));
        }
        self.boundary.evaluate();
        prepared
    }

    #[inline(always)]
    fn prepare_law(
        &self,
        number: usize,
        contact: &mut Contact,
        bond: Option<&mut BondContact>,
    ) -> Result<(), KernelError> {
        if contact.prepared {
            return Ok(());
        }
        contact.block = self.block(contact);
        let [nn, tt] = contact.diagonal();
        let nt = contact.block.nt;
        let softened = DelassusBlock { nn, nt, tt };
        let pair = (contact.a, contact.b);
        let softening = self.softening.get(number).copied().unwrap_or(1.0);
        contact.law = match bond {
            None => LocalLaw::new(softened, self.friction_of(contact) * softening, pair)?,
            Some(bond) => (bond.law).prepare(contact.block, contact.compliance[0], pair)?,
        };
        Ok(())
    }

    /// Prepares the local laws of the bonds of these contacts again.
    pub(super) fn prepare_bonds(&mut self, softened: &[u32]) -> Result<(), KernelError> {
        for index in softened {
            let contact = &mut self.contacts[*index as usize];
            let pair = (contact.a, contact.b);
            if let Some(bond) = self.bonds.get_mut(contact.bond as usize) {
                contact.law = bond
                    .law
                    .prepare(contact.block, contact.compliance[0], pair)?;
            }
        }
        Ok(())
    }

    /// Applies the first guesses, side by side within subdomains, and then the others.
    fn apply_first_guesses(&mut self, contacts: &[Contact], parallel: bool) {
        let partition = Partition::new(contacts.len(), self.records.len());
        if !self.levers.is_empty() {
            contacts.iter().for_each(|c| self.apply_first_guess(c));
            return;
        }
        let mut subdomains: Vec<Subdomain<Vec<u32>>> = Vec::new();
        partition.assign(&mut subdomains);
        let mut records = std::mem::take(&mut self.records);
        let all = ByCandidate::all(&mut records, contacts);
        for_each_subdomain(&mut subdomains, all, parallel, &|subdomain, piece| {
            for (index, contact) in piece.contacts.iter().enumerate() {
                let inside = subdomain.bodies.contains(&(contact.b as usize));
                if contact.glued || !inside || self.wheel == Some(contact.b as usize) {
                    subdomain.work.push((piece.passed + index) as u32);
                    continue;
                }
                contact.push(piece.bodies, piece.first, contact.impulse);
            }
        });
        self.records = records;
        for index in subdomains.iter().flat_map(|subdomain| &subdomain.work) {
            self.apply_first_guess(&contacts[*index as usize]);
        }
    }

    /// A contact with its attraction in place of its impulse.
    pub(crate) fn attracting(&self, attraction: usize) -> Contact {
        let attraction = &self.attractions[attraction];
        Contact {
            impulse: [-attraction.impulse, 0.0],
            ..self.contacts[attraction.contact as usize]
        }
    }

    /// Applies the first guess of a contact. Glued disks only gather it: the boundary yields to all at once.
    #[inline(always)]
    fn apply_first_guess(&mut self, contact: &Contact) {
        if contact.impulse == [0.0; 2] {
            return;
        }
        if contact.prepared {
            return contact.push(&mut self.records, 0, contact.impulse);
        }
        let force = contact.in_xy(contact.impulse);
        let bodies = [(contact.a, force), (contact.b, [-force[0], -force[1]])];
        for (side, (body, force)) in bodies.into_iter().enumerate() {
            match self.glued_side(contact, body as usize) {
                Some(disk) => self.boundary.gather(disk, force),
                None => self.apply_to(contact, side, force, contact.impulse),
            }
        }
    }

    /// The block of the Delassus operator W = H^T M^-1 H (equation 8 of Renouf, Saulot and Berthier 2006) at a contact:
    /// W_nn = n.M^-1 n and so on, summed over both bodies; the spin of a disk adds its inverse inertia to W_tt, the spin of a cluster adds to all
    /// components, and a glued disk has the block of W_g.
    #[inline(always)]
    pub fn block(&self, contact: &Contact) -> DelassusBlock {
        let [nx, ny] = contact.normal;
        let mut block = DelassusBlock::default();
        let levers = self.levers.get(contact.levers as usize);
        for (side, body) in [contact.a as usize, contact.b as usize]
            .into_iter()
            .enumerate()
        {
            let mut spin = 0.0;
            let [xx, xy, yy] = match (self.glued_side(contact, body), levers) {
                (Some(disk), _) => {
                    let [[xx, xy], [yx, yy]] = self.boundary.block(disk);
                    [xx, 0.5 * (xy + yx), yy]
                }
                (None, None) => {
                    let [x, y, turn] = self.inverse_mass(body);
                    spin = turn * contact.lever().powi(2);
                    [x, 0.0, y]
                }
                (None, Some(levers)) => {
                    let turning = levers.turning(side);
                    block.nn += turning.nn;
                    block.nt += turning.nt;
                    spin = turning.tt;
                    let [x, y, _] = levers.inverse[side];
                    [x, 0.0, y]
                }
            };
            block.nn += nx * nx * xx + 2.0 * nx * ny * xy + ny * ny * yy;
            block.nt += nx * ny * (yy - xx) + (nx * nx - ny * ny) * xy;
            block.tt += ny * ny * xx - 2.0 * nx * ny * xy + nx * nx * yy + spin;
        }
        block
    }

    /// Change of (v_x, v_y, spin times radius) by a unit impulse, for a body that is neither glued nor in a cluster (1/kg).
    #[inline(always)]
    pub(crate) fn inverse_mass(&self, body: usize) -> [f64; 3] {
        let inverse = self.records[body].inverse_mass;
        if Some(body) == self.wheel {
            [0.0, inverse, self.wheel_turn]
        } else {
            [inverse, inverse, 2.0 * inverse]
        }
    }

    /// Coefficient of friction of a contact, at the temperature of the start.
    #[inline(always)]
    fn friction_of(&self, contact: &Contact) -> f64 {
        match contact.pair_law {
            0 => self.friction,
            own => self.frictions[own as usize - 1],
        }
    }

    /// True if any contact has friction.
    pub(super) fn has_friction(&self) -> bool {
        let rubs = |friction: &f64| *friction > 0.0;
        rubs(&self.friction) || self.frictions.iter().any(rubs) || !self.couples.is_empty()
    }

    /// Index of a glued disk or a foot in the boundary; `None` for other bodies.
    #[inline(always)]
    pub(super) fn glued_index(&self, body: usize) -> Option<usize> {
        let index = body.checked_sub(self.first_glued)?;
        if index < self.boundary.disks() - self.surface_points {
            return Some(index);
        }
        let foot = body.checked_sub(self.first_foot)?;
        (foot < self.boundary.feet.len()).then(|| self.boundary.disks() + foot)
    }

    /// True for the wheel, glued disks and feet, whose W is not a mass's.
    #[inline(always)]
    pub(super) fn is_constrained(&self, body: usize) -> bool {
        self.glued_index(body).is_some() || self.wheel == Some(body)
    }

    /// Index in the boundary of a body of this contact, if it is a glued disk.
    #[inline(always)]
    fn glued_side(&self, contact: &Contact, body: usize) -> Option<usize> {
        contact.glued.then(|| self.glued_index(body))?
    }

    /// Relative velocity u = H^T v of the contact points, (u_n, u_t) of a against b (m/s).
    #[inline(always)]
    pub fn relative_velocity(&self, contact: &Contact) -> [f64; 2] {
        let a = self.velocity(contact, contact.a as usize);
        let b = self.velocity(contact, contact.b as usize);
        self.project(contact, a, b)
    }

    /// Relative velocity (u_n, u_t) of the contact points if the bodies had these velocities (m/s).
    #[inline(always)]
    pub fn project(&self, contact: &Contact, a: [f64; 3], b: [f64; 3]) -> [f64; 2] {
        match self.levers.get(contact.levers as usize) {
            None => contact.relative_velocity(a, b),
            Some(levers) => levers.project(contact.normal, a, b),
        }
    }

    /// Velocity (v_x, v_y, spin times radius) of a body of this contact (m/s).
    #[inline(always)]
    fn velocity(&self, contact: &Contact, body: usize) -> [f64; 3] {
        if let Some(disk) = self.glued_side(contact, body) {
            let [x, y] = self.boundary.velocity_of(disk);
            return [x, y, 0.0];
        }
        self.records[body].velocity
    }

    /// Adds an impulse (r_n, r_t) at a contact to the velocities of both bodies: v += M^-1 H r.
    #[inline(always)]
    pub fn apply(&mut self, contact: &Contact, impulse: [f64; 2]) {
        let force = contact.in_xy(impulse);
        self.apply_to(contact, 0, force, impulse);
        self.apply_to(contact, 1, [-force[0], -force[1]], impulse);
    }

    /// Adds an impulse at a contact to one of its bodies, 0 for a and 1 for b; `force` is that impulse in x and y on it.
    #[inline(always)]
    pub(super) fn apply_to(
        &mut self,
        contact: &Contact,
        side: usize,
        force: [f64; 2],
        impulse: [f64; 2],
    ) {
        let body = if side == 0 { contact.a } else { contact.b } as usize;
        if contact.glued
            && let Some(disk) = self.glued_index(body)
        {
            self.boundary.apply(disk, force);
            return;
        }
        if let Some(levers) = self.levers.get(contact.levers as usize) {
            levers.apply(side, &mut self.records[body].velocity, force, impulse);
            return;
        }
        let inverse = self.inverse_mass(body);
        let velocity = &mut self.records[body].velocity;
        velocity[0] += inverse[0] * force[0];
        velocity[1] += inverse[1] * force[1];
        // The lever is -r n on a and +r n on b, and the impulses are opposite: both disks turn the same way.
        velocity[2] -= inverse[2] * contact.lever() * impulse[1];
    }

    /// Solution (r_n, r_t) of the local problem of a contact (N s), all other contacts held: U = b + W r under its law, with
    /// b = u + bias - W r at the present velocities u and impulse r (Jean 1999; one row of equation 8 of Renouf, Saulot and Berthier 2006).
    #[inline(always)]
    pub fn local_solution(&self, contact: &Contact, velocity: [f64; 2]) -> [f64; 2] {
        let b = contact.without_impulse(velocity);
        match self.bonds.get(contact.bond as usize) {
            None => contact.law.impulse(b),
            Some(bond) => bond.law.impulse(&contact.block, &contact.law, b),
        }
    }

    /// A defect over the size of the problem; 0 for no defect, also in a problem without contacts.
    pub(crate) fn relative(&self, defect: f64, size: f64) -> f64 {
        if defect == 0.0 {
            return 0.0;
        }
        defect / size.max(self.least_size)
    }
}
