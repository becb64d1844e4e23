//! Driven clusters and named walls in a step: the force of the grains on them, and the work of the drives.

use super::{StepInput, Stepper};
use crate::step::state::GrainState;

impl Stepper {
    /// Records the forces on driven clusters and named walls and adds up the work of drives, before the new velocities are stored.
    ///
    /// In a prescribed direction the drive bears contacts and weight and does -(p + m h g) v; in a free direction it does F h v_theta, and its
    /// damping dissipates c h v_theta^2 (J).
    pub(super) fn drive_clusters(&mut self, state: &mut GrainState, input: &StepInput) {
        let bodies = input.bodies;
        self.on_named.clear();
        let index = |body: usize| bodies.clusters.of(body).map(|(index, _)| index);
        let clusters = match bodies.clusters.driven().next() {
            None => 0,
            Some(_) => bodies.clusters.list.len(),
        };
        let impulses = self.impulses(clusters, index);
        let at = input.step_time();
        for (index, cluster, drive) in bodies.clusters.driven() {
            let (push, drag, impulse) = (drive.push(&at), drive.drag(&at), impulses[index]);
            let leader = cluster.leader();
            let old = state.velocities[leader];
            let new = self.problem.records[leader].velocity;
            for k in 0..2 {
                let v = at.theta * new[k] + (1.0 - at.theta) * old[k];
                let borne = impulse[k] + cluster.mass * at.step * bodies.gravity[k];
                let is_free = cluster.free[k] > 0.0;
                let work = if is_free { push[k] } else { -borne };
                state.ledger.walls += work * v;
                let lost = cluster.free[k] * drag * v * v;
                state.ledger.damping += lost;
                if bodies.heat.is_some() {
                    state.heat.drives += lost;
                }
            }
            self.on_named.push(impulse.map(|p| p / input.step));
        }
        let on_walls = self.impulses(bodies.named_walls.len(), |body| bodies.named_wall(body));
        self.on_named
            .extend(on_walls.into_iter().map(|p| p.map(|p| p / input.step)));
    }

    /// Impulse of the contacts on each of `count` bodies (N s), found by `index` from the number of one of their parts.
    fn impulses(&self, count: usize, index: impl Fn(usize) -> Option<usize>) -> Vec<[f64; 2]> {
        let mut impulses = vec![[0.0; 2]; count];
        if count == 0 {
            return impulses;
        }
        for contact in &self.problem.contacts {
            let push = contact.in_xy(contact.impulse);
            for (body, sign) in [(contact.a, 1.0), (contact.b, -1.0)] {
                if let Some(index) = index(body as usize) {
                    impulses[index][0] += sign * push[0];
                    impulses[index][1] += sign * push[1];
                }
            }
        }
        impulses
    }
}
