//! The bodies at the end of a step: their momentum against the forces on them, their new velocities, and the work done.

use protocol::larger;

use super::update::OuterImpulses;
use super::{StepInput, StepSummary, Stepper, WheelTurn};
use crate::bodies::Bodies;
use crate::bodies::cluster::Cluster;
use crate::step::state::GrainState;

impl Stepper {
    /// Balance of the free grains: impulses from wheel, boundary and weight against the change of momentum. With theta = 1 a fall is off by half the
    /// way of its last step, so it counts as travel too.
    pub(super) fn balance_momentum(
        &self,
        state: &GrainState,
        input: &StepInput,
        outer: &OuterImpulses,
        summary: &mut StepSummary,
    ) {
        let (bodies, h) = (input.bodies, input.step);
        let (mut defect, mut change) = (outer.on_grains, [0.0; 2]);
        let [gx, gy] = bodies.gravity;
        let mut fall = 0.0;
        for (i, mass) in bodies.masses.iter().enumerate() {
            let (new, old) = (self.problem.records[i].velocity, state.velocities[i]);
            for k in 0..2 {
                defect[k] += mass * (h * bodies.gravity[k] - (new[k] - old[k]));
                change[k] += mass * (new[k] - old[k]);
            }
            let along = new[0] * gx + new[1] * gy;
            fall = larger(fall, along.abs() / bodies.radii[i]);
        }
        if !bodies.clusters.list.is_empty() {
            let held = self.held_impulse(state, input);
            defect = [defect[0] + held[0], defect[1] + held[1]];
        }
        if bodies.prescribed_velocity.is_some() {
            // The drive takes up any force.
            defect = [0.0; 2];
        }
        summary.momentum_defect = larger(defect[0].abs(), defect[1].abs()) / h;
        summary.added_inertia = change[0].hypot(change[1]) / h * bodies.added_mass_rel;
        summary.transmitted = outer.transmitted / h;
        let fall = fall / gx.hypot(gy).max(f64::MIN_POSITIVE);
        summary.travel = larger(summary.travel, (2.0 * input.theta - 1.0) * h * fall);
    }

    /// Impulse on clusters in addition to contacts and weight (N s): the reactions of their locked motions, and their drives.
    fn held_impulse(&self, state: &GrainState, input: &StepInput) -> [f64; 2] {
        let (bodies, h) = (input.bodies, input.step);
        let mut held = [0.0; 2];
        for (_, cluster, _) in bodies.clusters.driven() {
            let leader = cluster.leader();
            let start = state.velocities[leader];
            let end = self.problem.records[leader].velocity;
            let push = cluster.driving_impulse(start, end, &input.step_time());
            held = [held[0] + push[0], held[1] + push[1]];
        }
        let mut hold = |cluster: &Cluster, impulse: [f64; 2]| {
            for ((sum, free), p) in held.iter_mut().zip(&cluster.free).zip(impulse) {
                *sum -= (1.0 - free) * p;
            }
        };
        for cluster in &bodies.clusters.list {
            hold(cluster, bodies.gravity.map(|g| cluster.mass * h * g));
        }
        for contact in &self.problem.contacts {
            let push = contact.in_xy(contact.impulse);
            for (body, sign) in [(contact.a, 1.0), (contact.b, -1.0)] {
                if let Some((_, cluster)) = bodies.clusters.of(body as usize) {
                    hold(cluster, push.map(|p| sign * p));
                }
            }
        }
        held
    }

    /// Stores the new velocities and adds up the work of loads, drive, weight and boundary, and the loss of the scheme.
    pub(super) fn update_bodies(
        &self,
        state: &mut GrainState,
        input: &StepInput,
        outer: &OuterImpulses,
    ) {
        let (bodies, h, theta) = (input.bodies, input.step, input.theta);
        let at_theta = |new: f64, old: f64| theta * new + (1.0 - theta) * old;
        let mut squared_change = 0.0;
        for (i, mass) in bodies.masses.iter().enumerate() {
            let (new, old) = (self.problem.records[i].velocity, state.velocities[i]);
            let change = [new[0] - old[0], new[1] - old[1], new[2] - old[2]];
            let squared = mass
                * (change[0] * change[0] + change[1] * change[1] + 0.5 * change[2] * change[2]);
            squared_change += squared;
            let alone = std::iter::empty();
            state.heat.jolt(bodies, i, alone, (theta - 0.5) * squared);
            for k in 0..2 {
                state.ledger.weight += mass * bodies.gravity[k] * h * at_theta(new[k], old[k]);
            }
            state.velocities[i] = new;
        }
        let of_grains = squared_change;
        if let (Some(index), Some(mass)) = (bodies.wheel(), bodies.wheel_mass) {
            let new = self.problem.records[index].velocity;
            let old = state.wheel.velocity;
            squared_change += mass * (new[1] - old[1]).powi(2);
            let (turn, turned) = (new[2], at_theta(new[2], state.wheel.turn));
            match input.turn {
                WheelTurn::Held => {}
                WheelTurn::Given(_) => state.ledger.drive += outer.turning_wheel * turned,
                WheelTurn::Free {
                    inverse_mass,
                    brake,
                } => {
                    squared_change += (turn - state.wheel.turn).powi(2) / inverse_mass;
                    state.ledger.drive += brake * h * turned;
                }
            }
            state.wheel.turn = turn;
            state.ledger.load -= input.load * h * at_theta(new[1], old[1]);
            state.ledger.drive -= outer.on_wheel * at_theta(new[0], old[0]);
            state.wheel.velocity = [new[0], new[1]];
            state.wheel.position[0] = input.wheel_x;
            let contacts = self.problem.contacts.iter();
            let touching = contacts.filter(|contact| contact.b as usize == index);
            let grains = touching.map(|contact| contact.a as usize);
            let joules = (theta - 0.5) * (squared_change - of_grains);
            state.heat.jolt(bodies, index, grains, joules);
        }
        if bodies.wall_speed() > 0.0 {
            state.ledger.walls += self.work_of_walls(bodies);
        }
        if let Some(velocity) = bodies.prescribed_velocity {
            let pushes = self.problem.contacts.iter().map(|c| c.in_xy(c.impulse));
            let works = pushes.map(|push| push[0] * velocity[0] + push[1] * velocity[1]);
            state.ledger.drive -= works.sum::<f64>();
        }
        let boundary = &self.problem.boundary;
        let speeds = boundary.velocity.iter().zip(&state.glued_velocity);
        for (p, (new, old)) in boundary.impulse.iter().zip(speeds) {
            state.ledger.interface -= p * at_theta(*new, *old);
        }
        state.glued_velocity.copy_from_slice(&boundary.velocity);
        let ledger = &mut state.ledger;
        let account = match bodies.is_elastic() {
            true => &mut ledger.numerical,
            false => &mut ledger.impact,
        };
        *account += (theta - 0.5) * squared_change;
    }

    /// Work of moving walls on the grains in a step (J).
    fn work_of_walls(&self, bodies: &Bodies) -> f64 {
        let contacts = self.problem.contacts.iter();
        let works = contacts.filter_map(|contact| {
            let velocity = bodies.wall_of(contact.b as usize)?.velocity;
            let push = contact.in_xy(contact.impulse);
            Some(push[0] * velocity[0] + push[1] * velocity[1])
        });
        works.sum()
    }
}
