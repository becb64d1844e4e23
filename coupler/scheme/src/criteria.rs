//! Criteria by which a window is accepted: contact solves, gap, energy defect.

use protocol::Window;

use super::group::{Group, Patch};
use super::ledger::{InterfaceLedger, WindowEntry, largest_difference};
use super::vectors::motion_of;
use super::window::{Answer, Solve, SolvedWindow, WindowFault};

/// The contact solves that ran out of iterations. The result of such a solve is useless although its gap is zero: the
/// contact solver's own residual decides.
pub fn starved(group: &Group, window: &Window, answer: &Answer) -> Vec<WindowFault> {
    let starving = |(participant, solve): (usize, &Solve)| {
        let patch = group.first_of(participant);
        (!solve.converged).then(|| WindowFault {
            patch,
            why: format!(
                "interface `{}`: the contact solve of window {}, iteration {} (t = {:.6e} s) was starved of iterations: true residual {:.3e} after {} iterations; raise the limit of the participant on the wall (solver.max_iterations of the built-in grains, repeats_max of a layer in Python), or shorten the window",
                group.patches[patch].name, window.index, window.iteration, window.t0_s, solve.residual, solve.iterations
            ),
        })
    };
    let solves = answer.solves.iter().enumerate();
    solves.filter_map(starving).collect()
}

/// The interfaces whose |N du - H v_g| is above their tolerance.
pub fn open(
    group: &Group,
    window: &Window,
    increment: &[f64],
    answer: &Answer,
    advice: &str,
) -> Vec<WindowFault> {
    let dictated = group.mapping.motion(increment);
    let followed = motion_of(&answer.velocity, group.window_s(window));
    let open = |(index, patch): (usize, &Patch)| {
        let gap_m = largest_difference(patch.of_points(&dictated), patch.of_points(&followed));
        let tolerance_m = patch.tolerance_rel * patch.spacing_m;
        (gap_m > tolerance_m || gap_m.is_nan()).then(|| WindowFault {
            patch: index,
            why: format!(
                "interface `{}`: window {} (t = {:.6e} s) has a gap of {gap_m:.3e} m = {:.3e} node spacings after {} repeats, above tolerance_rel = {:.1e}: {advice}",
                patch.name,
                window.index,
                window.t0_s,
                gap_m / patch.spacing_m,
                window.iteration,
                patch.tolerance_rel
            ),
        })
    };
    let patches = group.patches.iter().enumerate();
    patches.filter_map(open).collect()
}

/// The interfaces whose energy defect would be above its bound if the window were accepted.
pub fn leaking(
    group: &Group,
    ledgers: &[InterfaceLedger],
    solved: &SolvedWindow,
) -> Vec<WindowFault> {
    let leaking = |(index, patch): (usize, &Patch)| {
        let bound = patch.energy_defect_max_rel?;
        let mut ledger = ledgers[index].clone();
        ledger.add(&Motions::of(group, solved).entry(patch, solved));
        let defect = ledger.energy_defect_rel();
        (defect > bound || defect.is_nan()).then(|| WindowFault {
            patch: index,
            why: format!(
                "interface `{}`: by the end of window {} (t = {:.6e} s) the interface has lost or created {defect:.3e} of the energy that passed through it, above energy_defect_max_rel = {bound:.1e}: lower substeps, or take a dual-schur scheme",
                patch.name, solved.window.index, solved.window.t0_s
            ),
        })
    };
    let patches = group.patches.iter().enumerate();
    patches.filter_map(leaking).collect()
}

/// Motions and forces of a solved window, mapped to the other side.
pub struct Motions {
    /// N du of the wanted increments (m).
    pub points: Vec<f64>,
    /// H v_g (m).
    pub boundary: Vec<f64>,
    /// N^T F_g (N).
    pub given: Vec<f64>,
}

impl Motions {
    /// Maps a solved window.
    pub fn of(group: &Group, solved: &SolvedWindow) -> Motions {
        Motions {
            points: group.mapping.motion(&solved.wanted),
            boundary: motion_of(&solved.answer.velocity, group.window_s(&solved.window)),
            given: group.mapping.force(&solved.answer.force),
        }
    }

    /// The window as the ledger of one interface sees it.
    pub fn entry<'a>(&'a self, patch: &Patch, solved: &'a SolvedWindow) -> WindowEntry<'a> {
        let given = patch.of_nodes(&self.given).iter();
        let given = given.zip(patch.of_nodes(&solved.wanted));
        let own = patch.of_nodes(&solved.work).iter();
        let late = own.zip(given).map(|(own, (force, du))| own - force * du);
        WindowEntry {
            late_work_j: late.sum(),
            point_force: patch.of_points(&solved.answer.force),
            nodal_force: patch.of_nodes(&solved.borne),
            point_motion: patch.of_points(&self.points),
            boundary_motion: patch.of_points(&self.boundary),
            spacing_m: patch.spacing_m,
        }
    }
}
