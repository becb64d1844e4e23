//! Whether a window may stand.

use protocol::Window;

use super::Coupling;
use super::outcome::{Answer, Fault, Solve, Solved};
use super::stand::entry;
use crate::couple::group::Patch;
use crate::couple::ledger::largest_difference;

impl Coupling {
    /// A contact solve that ran out of iterations gives garbage while the gap still reads zero, so it
    /// is the contact solver's own residual that decides.
    pub(super) fn starved(&self, window: &Window, answer: &Answer) -> Vec<Fault> {
        let starving = |(wall, solve): (usize, &Solve)| {
            let patch = self.group.first_of(wall);
            (!solve.converged).then(|| Fault {
                patch,
                why: format!(
                    "interface `{}`: the contact solve of window {}, iteration {} (t = {:.6e} s) was starved: true residual {:.3e} after {} iterations; raise solver.max_iterations of the participant on the wall, or lower the window",
                    self.group.patches[patch].name, window.index, window.iteration, window.t0_s, solve.residual, solve.iterations
                ),
            })
        };
        answer
            .solves
            .iter()
            .enumerate()
            .filter_map(starving)
            .collect()
    }

    /// The interfaces whose |N du - H v_g| is above their tolerance.
    pub(super) fn open(
        &self,
        window: &Window,
        increment: &[f64],
        answer: &Answer,
        advice: &str,
    ) -> Vec<Fault> {
        let motion = self.group.mapping.motion(increment);
        let wall = self.wall_motion(window, answer);
        let open = |(patch, of): (usize, &Patch)| {
            let gap_m = largest_difference(of.of_points(&motion), of.of_points(&wall));
            let tolerance_m = of.tolerance_rel * of.spacing_m;
            (gap_m > tolerance_m || gap_m.is_nan()).then(|| Fault {
                patch,
                why: format!(
                    "interface `{}`: window {} (t = {:.6e} s) has a gap of {gap_m:.3e} m = {:.3e} node spacings after {} repeats, tolerance_rel is {:.1e}: {advice}",
                    of.name,
                    window.index,
                    window.t0_s,
                    gap_m / of.spacing_m,
                    window.iteration,
                    of.tolerance_rel
                ),
            })
        };
        self.group
            .patches
            .iter()
            .enumerate()
            .filter_map(open)
            .collect()
    }

    /// The interfaces whose energy defect would be above its bound if the window stood.
    pub(super) fn leaks(&self, solved: &Solved) -> Vec<Fault> {
        let judged = |patch: &Patch| patch.energy_defect_max_rel.is_some();
        if !self.group.patches.iter().any(judged) {
            return Vec::new();
        }
        let point_motion = self.group.mapping.motion(&solved.wanted);
        let wall_motion = self.wall_motion(&solved.window, &solved.answer);
        let given = self.group.mapping.force(&solved.answer.force);
        let mut faults = Vec::new();
        for (place, (patch, ledger)) in self.group.patches.iter().zip(&self.ledgers).enumerate() {
            let Some(bound) = patch.energy_defect_max_rel else {
                continue;
            };
            let mut ledger = ledger.clone();
            ledger.add(&entry(patch, solved, &given, &point_motion, &wall_motion));
            let defect = ledger.energy_defect_rel();
            // Not `defect > bound`: what is not a number is above every bound.
            if defect <= bound {
                continue;
            }
            faults.push(Fault {
                patch: place,
                why: format!(
                    "interface `{}`: with window {} (t = {:.6e} s) the interface has lost or made {defect:.3e} of the energy that went through it, energy_defect_max_rel is {bound:.1e}: lower substeps, or take a dual-schur scheme",
                    patch.name, solved.window.index, solved.window.t0_s
                ),
            });
        }
        faults
    }
}
