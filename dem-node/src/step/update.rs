//! The contacts at the end of a step: forces, springs and bonds, and the energy that they lost.

use protocol::larger;

use super::{StepInput, StepSummary, Stepper};
use crate::bodies::Bodies;
use crate::bond;
use crate::detect::Slot;
use crate::ledger::{ContactStep, contact_loss};
use crate::solver::{Contact, NO_BOND};
use crate::state::State;

impl Stepper {
    /// Stores forces and springs, books the losses, sums forces and overlaps.
    pub(super) fn update_contacts(&self, state: &mut State, input: &StepInput) -> StepSummary {
        let (bodies, h) = (input.bodies, input.step);
        let mut summary = StepSummary {
            listed: self.problem.contacts.len(),
            ..StepSummary::default()
        };
        for (contact, slot) in self.problem.contacts.iter().zip(&self.slots) {
            let slot = *slot as usize;
            let done = self.contact_step(state, input, contact, &state.list.slots[slot]);
            if contact.bond == NO_BOND {
                let law = bodies.law_at(contact.own);
                state.accounts.lose(&contact_loss(law, &done));
                let slot = &mut state.list.slots[slot];
                slot.force = [done.impulse[0] / h, done.impulse[1] / h];
                slot.spring = done.spring[1];
                slot.left = done.gap + h * done.velocity[0];
            } else {
                self.update_bond(bodies, state, contact.bond as usize, slot, &done);
            }
            if done.impulse[0] > 0.0 {
                let overlap = larger(0.0, -done.gap - h * done.velocity[0]);
                summary.closed += 1;
                summary.overlap[0] += overlap;
                summary.overlap[1] = larger(summary.overlap[1], overlap);
            }
            if Some(contact.b as usize) == bodies.wheel() {
                let force = contact.in_xy(contact.impulse);
                summary.on_wheel[0] -= force[0] / h;
                summary.on_wheel[1] -= force[1] / h;
            }
        }
        state.bonds.retain(|bond| bond.adhesion > 0.0);
        summary.overlap[0] /= summary.closed.max(1) as f64;
        for impulse in self.problem.boundary.impulse.chunks_exact(2) {
            summary.on_boundary[0] += impulse[0] / h;
            summary.on_boundary[1] += impulse[1] / h;
        }
        summary
    }

    /// Moves a bond and its slot to the end of the step and books its loss.
    fn update_bond(
        &self,
        bodies: &Bodies,
        state: &mut State,
        index: usize,
        slot: usize,
        done: &ContactStep,
    ) {
        let contact = &self.problem.bonds[index];
        let [before, solved] = contact.adhesion;
        let adhesion = [before, solved, self.adhesion[index]];
        let bond = &mut state.bonds[contact.index as usize];
        let slot = &mut state.list.slots[slot];
        let law = bodies.law_of(slot.a as usize, slot.b as usize);
        let loss = bond::end_step(law, bond, slot, done, adhesion);
        state.accounts.lose(&loss);
    }

    fn contact_step(
        &self,
        state: &State,
        input: &StepInput,
        contact: &Contact,
        slot: &Slot,
    ) -> ContactStep {
        let velocity = self.problem.relative_velocity(contact);
        // What it is for weighs 1 - theta.
        let before = if input.theta == 1.0 {
            velocity
        } else {
            self.relative_before(input.bodies, state, contact)
        };
        let law = input.bodies.law_at(contact.own);
        let springs = law.springs;
        let stretched = springs.map_or(0.0, |s| -contact.impulse[1] / (input.step * s.tangential));
        // A compliant boundary puts its disks where its own body says, which is not for this ledger to judge.
        let left = if contact.glued && self.problem.boundary.is_compliant() {
            contact.gap
        } else {
            slot.left
        };
        ContactStep {
            step: input.step,
            theta: input.theta,
            gap: contact.gap,
            left,
            spring: [slot.spring, stretched],
            impulse: contact.impulse,
            velocity,
            change: [velocity[0] - before[0], velocity[1] - before[1]],
        }
    }

    /// (u_n, u_t) at the start of the step (m/s).
    pub(super) fn relative_before(
        &self,
        bodies: &Bodies,
        state: &State,
        contact: &Contact,
    ) -> [f64; 2] {
        let a = velocity_before(bodies, state, contact.a as usize);
        let b = velocity_before(bodies, state, contact.b as usize);
        self.problem.project(contact, a, b)
    }
}

fn velocity_before(bodies: &Bodies, state: &State, body: usize) -> [f64; 3] {
    if body < bodies.free {
        return state.velocities[body];
    }
    if let Some(disk) = bodies.glued_index(body) {
        let [x, y] = [0, 1].map(|k| state.glued_velocity[2 * disk + k]);
        return [x, y, 0.0];
    }
    if Some(body) == bodies.wheel() {
        return [state.wheel.velocity[0], state.wheel.velocity[1], 0.0];
    }
    let [x, y] = bodies.wall_of(body).map_or([0.0; 2], |wall| wall.velocity);
    [x, y, 0.0]
}
