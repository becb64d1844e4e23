//! A window that stands: it is entered into the ledgers and becomes the state of all sides.

use protocol::{Kind, Window};

use super::Coupling;
use super::outcome::{Answer, InterfaceSignals, Solved, Standing};
use crate::couple::conversation::Conversation;
use crate::couple::group::Patch;
use crate::couple::ledger::{PointMotion, WindowEntry, total};
use crate::error::Error;

impl Coupling {
    /// H v_g (m).
    pub(super) fn wall_motion(&self, window: &Window, answer: &Answer) -> Vec<f64> {
        let window_s = self.group.window_s(window);
        answer.velocity.iter().map(|v| v * window_s).collect()
    }

    pub(super) fn stand(
        &mut self,
        conversation: &mut Conversation,
        solved: Solved,
        next: Option<Window>,
    ) -> Result<Standing, Error> {
        for (total, increment) in self.displacement.iter_mut().zip(&solved.increment) {
            *total += increment;
        }
        self.lambda.clone_from(&solved.lambda);
        if let Some(velocity) = &solved.velocity {
            self.velocity.clone_from(velocity);
        }
        self.commit(conversation, &solved.window, next)?;
        // While the others are at work.
        let wanted = self.group.mapping.motion(&solved.wanted);
        let signals = self.enter(&solved, &wanted);
        self.last_motion = wanted;
        let reports = self.reports(conversation)?;
        conversation.end_window(solved.window.index)?;
        Ok(Standing { signals, reports })
    }

    /// Enters a window into the ledger of each interface.
    pub(super) fn enter(
        &mut self,
        solved: &Solved,
        point_motion: &[f64],
    ) -> Vec<(usize, InterfaceSignals)> {
        let wall_motion = self.wall_motion(&solved.window, &solved.answer);
        let given = self.group.mapping.force(&solved.answer.force);
        let mut signals = Vec::new();
        for (patch, ledger) in self.group.patches.iter().zip(&mut self.ledgers) {
            let entry = entry(patch, solved, &given, point_motion, &wall_motion);
            ledger.add(&entry);
            if !solved.inertia.is_empty() {
                ledger.carry(&PointMotion {
                    mass_kg: &self.group.points.mass_kg[patch.points.clone()],
                    velocity: patch.of_points(&solved.answer.velocity),
                    inertia: patch.of_points(&solved.inertia),
                    window_s: self.group.window_s(&solved.window),
                });
            }
            ledger.repeats += u64::from(solved.window.iteration);
            let residual = solved.answer.solves[patch.wall].residual;
            ledger.contact_residual_max = ledger.contact_residual_max.max(residual);
            let force_n = total(entry.nodal_force);
            let seen = InterfaceSignals {
                repeats: solved.window.iteration,
                gap_rel: entry.gap(),
                force_n,
                pressing_n: -patch.outward_y * force_n[1],
            };
            signals.push((patch.index, seen));
        }
        signals
    }

    /// Tells all sides that the window stands and, where the scheme begins the next one with a run of the continua, has
    /// them begin it.
    pub(super) fn commit(
        &self,
        conversation: &mut Conversation,
        window: &Window,
        next: Option<Window>,
    ) -> Result<(), Error> {
        let next = next.filter(|_| self.begins_with_continua());
        for side in &self.group.continua {
            conversation.tell(side.peer, Kind::Commit, &side.window(window), Vec::new())?;
            if let Some(next) = &next {
                let force = side.of(&self.lambda).to_vec();
                conversation.foretell(side.peer, Kind::Advance, &side.window(next), force)?;
            }
        }
        let place = self.group.mapping.motion(&self.displacement);
        self.group.walls.iter().try_for_each(|side| {
            conversation.tell(side.peer, Kind::Commit, window, side.of(&place).to_vec())
        })
    }

    pub(super) fn reports(
        &self,
        conversation: &mut Conversation,
    ) -> Result<Vec<(usize, Vec<f64>)>, Error> {
        let sides = self.group.continua.iter().chain(&self.group.walls);
        sides
            .map(|side| {
                let report = conversation.hear(side.peer, Kind::Report)?;
                Ok((side.peer, report.payload))
            })
            .collect()
    }
}

/// A window as the ledger of one interface sees it; `given` is N^T F_g (N).
pub(super) fn entry<'a>(
    patch: &Patch,
    solved: &'a Solved,
    given: &[f64],
    point_motion: &'a [f64],
    wall_motion: &'a [f64],
) -> WindowEntry<'a> {
    let own = patch.of_nodes(&solved.work).iter();
    let other = patch
        .of_nodes(given)
        .iter()
        .zip(patch.of_nodes(&solved.wanted));
    let other = other.map(|(force, du)| force * du);
    WindowEntry {
        late_work_j: own.zip(other).map(|(own, other)| own - other).sum(),
        point_force: patch.of_points(&solved.answer.force),
        nodal_force: patch.of_nodes(&solved.lambda),
        point_motion: patch.of_points(point_motion),
        wall_motion: patch.of_points(wall_motion),
        spacing_m: patch.spacing_m,
    }
}
