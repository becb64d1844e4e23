//! Driven clusters in a step: the force of the grains on them, and the work of their drives.

use super::{StepInput, Stepper};
use crate::bodies::Bodies;
use crate::step::state::GrainState;

impl Stepper {
    /// Keeps the forces on driven clusters and adds up the work of their drives, before their velocities are taken over.
    ///
    /// In a prescribed direction the drive bears contacts and weight and does -(p + m h g) v; in a free one it does F h v_theta, and
    /// its damping takes c h v_theta^2 (J).
    pub(super) fn drive_clusters(&mut self, state: &mut GrainState, input: &StepInput) {
        let bodies = input.bodies;
        self.on_driven.clear();
        if bodies.clusters.driven().next().is_none() {
            return;
        }
        let impulses = self.impulses_on_clusters(bodies);
        let at = input.step_time();
        for (index, cluster, drive) in bodies.clusters.driven() {
            let (push, drag, impulse) = (drive.push(&at), drive.drag(&at), impulses[index]);
            let leader = cluster.leader();
            let (old, new) = (
                state.velocities[leader],
                self.problem.records[leader].velocity,
            );
            for k in 0..2 {
                let v = at.theta * new[k] + (1.0 - at.theta) * old[k];
                let borne = impulse[k] + cluster.mass * at.step * bodies.gravity[k];
                let work = if cluster.free[k] > 0.0 {
                    push[k]
                } else {
                    -borne
                };
                state.ledger.walls += work * v;
                state.ledger.damping += cluster.free[k] * drag * v * v;
            }
            self.on_driven.push(impulse.map(|p| p / input.step));
        }
    }

    /// Impulse of the contacts on each cluster (N s).
    fn impulses_on_clusters(&self, bodies: &Bodies) -> Vec<[f64; 2]> {
        let mut impulses = vec![[0.0; 2]; bodies.clusters.list.len()];
        for contact in &self.problem.contacts {
            let push = contact.in_xy(contact.impulse);
            for (body, sign) in [(contact.a, 1.0), (contact.b, -1.0)] {
                if let Some((index, _)) = bodies.clusters.of(body as usize) {
                    impulses[index][0] += sign * push[0];
                    impulses[index][1] += sign * push[1];
                }
            }
        }
        impulses
    }
}
