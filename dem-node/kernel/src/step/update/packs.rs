//! The end of a step for contacts side by side: springs and bonds of two grains, as [`super::Stepper::update_contact`] ends them one by one.

use protocol::larger;

use super::totals::{Doubles, LANES, PackSums, Totals, UpdatePiece};
use crate::bodies::Bodies;
use crate::contact::bond::BondStep;
use crate::contact::loss::{ContactStep, Loss, compliant_loss, turned};
use crate::law::Law;
use crate::law::lanes::{Real, widest};
use crate::solver::contact::{Contact, NO_BOND, relative_velocity};
use crate::step::state::GrainState;
use crate::step::temperature::PairHeat;
use crate::step::{StepInput, Stepper};

/// Contacts that are ended together, all with a bond or all without.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Pack {
    members: [usize; LANES],
    count: usize,
    radii: [Doubles; 2],
    /// Velocities of both bodies after the step (m/s).
    velocities: [[Doubles; 3]; 2],
    /// Velocity of the first body against the second before the step (m/s).
    passed: [Doubles; 2],
    normal: [Doubles; 2],
    lever: Doubles,
    step: ContactStep<Doubles>,
    /// The bonds; without bonds, the elongations of the tangential springs in place of their slip.
    bonds: BondStep<Doubles>,
}

/// The numbers of a pack at the end of a step.
struct PackEnd {
    force: [Doubles; 2],
    opening: Doubles,
    slip: Doubles,
    adhesion: Doubles,
    losses: Loss<Doubles>,
    load: Doubles,
}

/// The law of contacts that go side by side in a step; `None` where all go one by one.
pub(super) fn common_law<'a>(input: &StepInput<'a>) -> Option<&'a Law> {
    input.bodies.alike().filter(|_| input.theta == 1.0)
}

/// True for a contact of two grains where the law of most contacts has springs: its loss is added in lanes, whether it goes side by side or not.
#[inline(always)]
pub(super) fn is_plain(bodies: &Bodies, contact: &Contact) -> bool {
    (contact.b as usize) < bodies.free && bodies.law.springs.is_some()
}

impl Stepper {
    /// Adds a contact to a pack, which is ended when it is full.
    #[inline(always)]
    pub(super) fn pack(
        &self,
        (state, input, law): (&GrainState, &StepInput, &Law),
        piece: &mut UpdatePiece,
        (pack, index): (&mut Pack, usize),
        totals: &mut Totals,
    ) {
        let (contact, slot) = (&piece.contacts[index], piece.slot(index));
        let k = pack.count % LANES;
        let bodies = [contact.a, contact.b].map(|body| body as usize);
        let [a, b] = bodies.map(|body| state.velocities[body]);
        for (side, body) in bodies.into_iter().enumerate() {
            pack.radii[side].0[k] = input.bodies.radii[body];
            let velocity = self.problem.records[body].velocity;
            for (lanes, velocity) in pack.velocities[side].iter_mut().zip(velocity) {
                lanes.0[k] = velocity;
            }
        }
        (pack.passed[0].0[k], pack.passed[1].0[k]) = (a[0] - b[0], a[1] - b[1]);
        for axis in 0..2 {
            pack.normal[axis].0[k] = contact.normal[axis];
            pack.step.impulse[axis].0[k] = contact.impulse[axis];
        }
        pack.lever.0[k] = contact.lever();
        (pack.step.gap.0[k], pack.step.last_gap.0[k]) = (contact.gap, slot.last_gap);
        if contact.bond == NO_BOND {
            pack.bonds.slip.0[k] = slot.spring;
        } else {
            let solved = &piece.bonded[contact.bond as usize];
            let bond = &piece.bonds[solved.index as usize - piece.first_bond];
            let [before, during] = solved.adhesion;
            let after = self.adhesion[contact.bond as usize];
            pack.bonds.area.0[k] = bond.area;
            pack.bonds.slip.0[k] = bond.slip;
            for (lanes, adhesion) in pack.bonds.adhesion.iter_mut().zip([before, during, after]) {
                lanes.0[k] = adhesion;
            }
            for (lanes, relaxation) in pack.bonds.relaxation.iter_mut().zip(solved.relaxation) {
                lanes.0[k] = relaxation;
            }
        }
        (pack.members[k], pack.count) = (index, k + 1);
        if pack.count == LANES {
            self.end_pack((state, input, law), piece, pack, totals);
        }
    }

    /// Stores forces, springs and bonds of a full pack. One with a bond that breaks goes one by one.
    fn end_pack(
        &self,
        (state, input, law): (&GrainState, &StepInput, &Law),
        piece: &mut UpdatePiece,
        pack: &mut Pack,
        totals: &mut Totals,
    ) {
        (pack.step.step, pack.step.theta) = (input.step, input.theta);
        let bonded = piece.contacts[pack.members[0]].bond != NO_BOND;
        let kind = usize::from(bonded);
        let Some(end) = widest!(pack.end(law, bonded, &mut totals.packs[kind])) else {
            for (k, index) in pack.members().iter().enumerate() {
                let lane = Some((kind, k));
                self.update_contact((state, input), piece, (*index, lane), totals);
            }
            pack.count = 0;
            return;
        };
        pack.count = 0;
        for (k, index) in pack.members.into_iter().enumerate() {
            let bond = piece.contacts[index].bond;
            let slot = piece.slot_mut(index);
            slot.force = [end.force[0].0[k], end.force[1].0[k]];
            slot.last_gap = end.opening.0[k];
            if bond == NO_BOND {
                slot.spring = end.slip.0[k];
            } else {
                let index = piece.bonded[bond as usize].index as usize;
                let bond = &mut piece.bonds[index - piece.first_bond];
                (bond.opening, bond.slip) = (end.opening.0[k], end.slip.0[k]);
                bond.adhesion = end.adhesion.0[k];
            }
            if input.bodies.heat.is_some() {
                let (slot, loss) = (piece.slot(index), end.losses.each(|loss| loss.0[k]));
                let heat = PairHeat::of([slot.a, slot.b], &loss);
                totals.outer.warmed.push(heat);
            }
        }
    }
}

impl Pack {
    /// Its contacts.
    pub fn members(&self) -> &[usize] {
        &self.members[..self.count]
    }

    /// The end of the step; `None` where a bond breaks.
    #[inline(always)]
    fn end(&self, law: &Law, bonded: bool, sums: &mut PackSums) -> Option<PackEnd> {
        let (mut step, passed, radii) = (self.step, self.passed, self.radii);
        let h = Doubles::of(step.step);
        let [a, b] = self.velocities;
        step.velocity = relative_velocity(self.normal, self.lever, a, b);
        let distance = (radii[0] + radii[1]) * self.lever;
        step.turned_gap = step.last_gap + turned(step.step, self.normal, distance, passed);
        let springs = law.springs.as_ref()?;
        let end = if bonded {
            let cohesion = law.cohesion.as_ref()?;
            let end = self.bonds.end(cohesion, Some(springs), false, &step);
            if end.adhesion.any_is(|adhesion| adhesion == 0.0) {
                return None;
            }
            PackEnd {
                force: step.impulse.map(|impulse| impulse / h),
                opening: end.opening,
                slip: end.slip,
                adhesion: end.adhesion,
                losses: end.loss(),
                load: cohesion.drive(end.opening, end.slip) / Doubles::of(cohesion.energy),
            }
        } else {
            let stretched = -step.impulse[1] / (h * Doubles::of(springs.tangential));
            step.spring = [self.bonds.slip, stretched];
            PackEnd {
                force: step.impulse.map(|r| Doubles::of(1.0 / step.step) * r),
                opening: step.gap + h * step.velocity[0],
                slip: stretched,
                adhesion: Doubles::default(),
                losses: compliant_loss(springs, &step),
                load: Doubles::default(),
            }
        };
        let speed = (passed[0] * passed[0] + passed[1] * passed[1]).map(f64::sqrt);
        let travel = h * (speed / radii[0].zip(radii[1], f64::min));
        let pressed = |x| step.impulse[0].choose(|r_n| r_n > 0.0, x, Doubles::default());
        let overlap = pressed(end.opening.map(|gap| larger(0.0, -gap)));
        sums.closed = sums.closed + pressed(Doubles::of(1.0));
        sums.overlap = [
            sums.overlap[0] + overlap,
            sums.overlap[1].zip(overlap, larger),
        ];
        sums.travel = sums.travel.zip(pressed(travel), larger);
        sums.load = sums.load.zip(end.load, larger);
        sums.lose(end.losses);
        Some(end)
    }
}
