//! One window of each coupling scheme.
//!
//! - [`compliance`]: what the coupler believes of the continua's compliance;
//! - `dual_schur`: one force a window, equal displacements at its end;
//! - `fixed_point`: motion one way, force the other, repeated or not;
//! - `state`: what a checkpoint holds of it;
//! - [`acceleration`]: what a fixed-point iteration makes of its last answers;
//! - `foresee`: what the handshake tells of its stability.

use protocol::serve::unpack_wall_answer;
use protocol::{Kind, WallAnswer, Window};
use serde::{Deserialize, Serialize};

use super::conversation::Conversation;
use super::group::{Group, Patch};
use super::ledger::{InterfaceLedger, WindowEntry, largest_difference, total};
use crate::error::Error;
use crate::scenario::{Interface, Policy, Scheme};
use compliance::{Compliance, tell_walls};

pub mod acceleration;
pub mod compliance;
mod dual_schur;
mod fixed_point;
mod foresee;
mod state;

pub use state::CouplingState;

/// `dual-schur-cheap` never looks back, so its compliance errs to the soft side, which is far safer than too stiff.
pub const CHEAP_FACTOR: f64 = 1.2;

/// The coupler's own state of one group: it changes only when a window stands.
#[derive(Clone, Debug)]
pub struct Coupling {
    /// The keys on which connected interfaces agree.
    rules: Interface,
    group: Group,
    compliance: Compliance,
    /// Window length that walls without compliance were told of (substeps).
    rigid_wall: Option<u32>,
    /// Motion of the glued points in the last window that stands (m), for what runs one window late.
    last_motion: Vec<f64>,
    /// Force on the exchanged nodes (N) in the last window that stands.
    pub lambda: Vec<f64>,
    /// Total displacement of the exchanged nodes (m).
    pub displacement: Vec<f64>,
    /// What each interface of the group has seen.
    pub ledgers: Vec<InterfaceLedger>,
}

/// What came of trying a window.
#[derive(Clone, Debug)]
pub enum Attempt {
    /// It stands, and is everybody's state.
    Standing(Standing),
    /// It did not converge, and the scenario wants it halved. Nothing has changed.
    Halve,
}

/// What a window that stands left behind.
#[derive(Clone, Debug, Default)]
pub struct Standing {
    /// Interfaces of the group, by their index in the scenario, and what the coupler saw of each.
    pub signals: Vec<(usize, InterfaceSignals)>,
    /// Participants of the group and what each reported.
    pub reports: Vec<(usize, Vec<f64>)>,
}

/// What the coupler sees of an interface in a window that stands.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct InterfaceSignals {
    /// Repeats beyond the first run.
    pub repeats: u32,
    /// Gap over the mean node spacing.
    pub gap_rel: f64,
    /// Sum of the forces on the continuum's nodes (N).
    pub force_n: [f64; 2],
    /// The part of it that presses on the continuum's surface (N).
    pub pressing_n: f64,
}

/// The answers of all walls of a group.
struct Answer {
    /// Force of the grains on the wall at each glued point (N).
    force: Vec<f64>,
    /// Velocity of each glued point at the end of the window (m/s).
    velocity: Vec<f64>,
    /// What each wall said of its contact solve.
    solves: Vec<Solve>,
}

/// What a wall says of its contact solve.
struct Solve {
    iterations: u64,
    residual: f64,
    converged: bool,
}

/// A window that all sides may make their state.
struct Solved {
    window: Window,
    increment: Vec<f64>,
    /// Force under which the continua made the increment (N).
    used: Vec<f64>,
    /// Force that the answers give, of the window as far as it is known (N).
    lambda: Vec<f64>,
    answer: Answer,
    /// Why it should not stand, if so.
    faults: Vec<Fault>,
}

/// Why a window should not stand.
struct Fault {
    /// The interface, as a place in the group.
    patch: usize,
    why: String,
}

impl Coupling {
    /// All sides at rest and unloaded; `rules` is any of the group's interfaces.
    pub fn new(rules: &Interface, group: Group) -> Coupling {
        let factor = match rules.scheme {
            Scheme::DualSchurCheap => CHEAP_FACTOR,
            _ => 1.0,
        };
        Coupling {
            rules: rules.clone(),
            compliance: Compliance::new(rules.compliance, factor),
            rigid_wall: None,
            last_motion: vec![0.0; 2 * group.points.len()],
            lambda: vec![0.0; 2 * group.nodes.len()],
            displacement: vec![0.0; 2 * group.nodes.len()],
            ledgers: vec![InterfaceLedger::default(); group.patches.len()],
            group,
        }
    }

    /// What the handshake agreed on.
    pub fn group(&self) -> &Group {
        &self.group
    }

    /// Tries a window until it stands, or the scenario's policy decides otherwise. `following` tells the window after
    /// one that stands.
    pub fn window(
        &mut self,
        conversation: &mut Conversation,
        window: Window,
        following: impl Fn(&Window) -> Option<Window>,
    ) -> Result<Attempt, Error> {
        let mut solved = match self.solved(conversation, window) {
            Err(Error::NotFinite(_)) if self.may_halve(&window) => return Ok(self.halve()),
            solved => solved?,
        };
        solved.faults.extend(self.leaks(&solved));
        match (solved.faults.first(), self.rules.on_not_converged) {
            (None, _) => {}
            (Some(_), Policy::Accept) => {
                for fault in &solved.faults {
                    self.ledgers[fault.patch].not_converged += 1;
                }
            }
            (Some(_), Policy::Halve) if self.may_halve(&window) => return Ok(self.halve()),
            (Some(fault), Policy::Halve) => {
                let end = self.cannot_halve();
                return Err(Error::NotConverged(format!("{}; {end}", fault.why)));
            }
            (Some(fault), Policy::Stop) => return Err(Error::NotConverged(fault.why.clone())),
        }
        let next = following(&solved.window);
        self.stand(conversation, solved, next)
            .map(Attempt::Standing)
    }

    fn solved(&mut self, conversation: &mut Conversation, window: Window) -> Result<Solved, Error> {
        match self.rules.scheme {
            Scheme::DualSchur | Scheme::DualSchurSecant | Scheme::DualSchurCheap => {
                self.dual_schur(conversation, window)
            }
            Scheme::StaggeredSerial => self.staggered_serial(conversation, window),
            Scheme::StaggeredParallel => self.staggered_parallel(conversation, window),
            Scheme::FixedPointSerial | Scheme::FixedPointParallel => {
                self.fixed_point(conversation, window)
            }
        }
    }

    /// Whether the first thing of a window is a run of the continua under the force of the window before.
    fn begins_with_continua(&self) -> bool {
        match self.rules.scheme {
            Scheme::DualSchur | Scheme::DualSchurSecant | Scheme::DualSchurCheap => true,
            Scheme::StaggeredSerial
            | Scheme::StaggeredParallel
            | Scheme::FixedPointSerial
            | Scheme::FixedPointParallel => false,
        }
    }

    fn may_halve(&self, window: &Window) -> bool {
        self.rules.on_not_converged == Policy::Halve && window.substeps > 1
    }

    fn halve(&mut self) -> Attempt {
        for ledger in &mut self.ledgers {
            ledger.halved += 1;
        }
        Attempt::Halve
    }

    fn cannot_halve(&self) -> String {
        match self.group.continua.iter().all(|side| side.steps == 1) {
            true => "the window has one step left and cannot be halved".into(),
            false => "the connected continua have no shorter window that is a whole number of steps of each: give substeps that share more factors".into(),
        }
    }

    /// All continua at once.
    fn advance(
        &self,
        conversation: &mut Conversation,
        window: &Window,
        lambda: &[f64],
    ) -> Result<Vec<f64>, Error> {
        self.tell_continua(conversation, window, lambda)?;
        self.hear_continua(conversation, window)
    }

    fn tell_continua(
        &self,
        conversation: &mut Conversation,
        window: &Window,
        lambda: &[f64],
    ) -> Result<(), Error> {
        self.group.continua.iter().try_for_each(|side| {
            let force = side.of(lambda).to_vec();
            conversation.tell(side.peer, Kind::Advance, &side.window(window), force)
        })
    }

    fn hear_continua(
        &self,
        conversation: &mut Conversation,
        window: &Window,
    ) -> Result<Vec<f64>, Error> {
        let mut increment = Vec::with_capacity(2 * self.group.nodes.len());
        let mut fault = None;
        for side in &self.group.continua {
            let due = 2 * side.places.len();
            let window = side.window(window);
            match conversation.hear_exactly(side.peer, Kind::Motion, &window, due) {
                Ok(motion) => increment.extend(motion),
                // The others have answered too, and the window may be tried again.
                Err(error @ Error::NotFinite(_)) => fault = fault.or(Some(error)),
                Err(error) => return Err(error),
            }
        }
        fault.map_or(Ok(increment), Err)
    }

    /// All walls at once.
    fn solve(
        &mut self,
        conversation: &mut Conversation,
        window: &Window,
        free: Vec<f64>,
    ) -> Result<Answer, Error> {
        for side in &self.group.walls {
            conversation.tell(side.peer, Kind::Solve, window, side.of(&free).to_vec())?;
        }
        let mut all = Answer {
            force: Vec::with_capacity(free.len()),
            velocity: Vec::with_capacity(free.len()),
            solves: Vec::new(),
        };
        let mut fault = None;
        for (wall, side) in self.group.walls.iter().enumerate() {
            let answer = match hear_wall(conversation, side.peer, window, 2 * side.places.len()) {
                Ok(answer) => answer,
                Err(error @ Error::NotFinite(_)) => {
                    fault = fault.or(Some(error));
                    continue;
                }
                Err(error) => return Err(error),
            };
            self.ledgers[self.group.first_of(wall)].contact_iterations += answer.iterations;
            all.force.extend(answer.force);
            all.velocity.extend(answer.velocity);
            all.solves.push(Solve {
                iterations: answer.iterations,
                residual: answer.residual,
                converged: answer.converged,
            });
        }
        fault.map_or(Ok(all), Err)
    }

    /// Walls that move exactly as they are told.
    fn rigid_wall(
        &mut self,
        conversation: &mut Conversation,
        window: &Window,
    ) -> Result<(), Error> {
        if self.rigid_wall != Some(window.substeps) {
            tell_walls(conversation, &self.group, window, None)?;
            self.rigid_wall = Some(window.substeps);
        }
        Ok(())
    }

    /// A contact solve that ran out of iterations gives garbage while the gap still reads zero, so it
    /// is the contact solver's own residual that decides.
    fn starved(&self, window: &Window, answer: &Answer) -> Vec<Fault> {
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
    fn open(
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
    fn leaks(&self, solved: &Solved) -> Vec<Fault> {
        let judged = |patch: &Patch| patch.energy_defect_max_rel.is_some();
        if !self.group.patches.iter().any(judged) {
            return Vec::new();
        }
        let point_motion = self.group.mapping.motion(&solved.increment);
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

    /// H v_g (m).
    fn wall_motion(&self, window: &Window, answer: &Answer) -> Vec<f64> {
        let window_s = self.group.window_s(window);
        answer.velocity.iter().map(|v| v * window_s).collect()
    }

    fn stand(
        &mut self,
        conversation: &mut Conversation,
        solved: Solved,
        next: Option<Window>,
    ) -> Result<Standing, Error> {
        for (total, increment) in self.displacement.iter_mut().zip(&solved.increment) {
            *total += increment;
        }
        self.lambda.clone_from(&solved.lambda);
        self.commit(conversation, &solved.window, next)?;
        // While the others are at work.
        let point_motion = self.group.mapping.motion(&solved.increment);
        let signals = self.enter(&solved, &point_motion);
        self.last_motion = point_motion;
        let reports = self.reports(conversation)?;
        conversation.end_window(solved.window.index)?;
        Ok(Standing { signals, reports })
    }

    /// Enters a window into the ledger of each interface.
    fn enter(&mut self, solved: &Solved, point_motion: &[f64]) -> Vec<(usize, InterfaceSignals)> {
        let wall_motion = self.wall_motion(&solved.window, &solved.answer);
        let given = self.group.mapping.force(&solved.answer.force);
        let mut signals = Vec::new();
        for (patch, ledger) in self.group.patches.iter().zip(&mut self.ledgers) {
            let entry = entry(patch, solved, &given, point_motion, &wall_motion);
            ledger.add(&entry);
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
    fn commit(
        &self,
        conversation: &mut Conversation,
        window: &Window,
        next: Option<Window>,
    ) -> Result<(), Error> {
        let place = self.group.mapping.motion(&self.displacement);
        for side in &self.group.continua {
            conversation.tell(side.peer, Kind::Commit, &side.window(window), Vec::new())?;
        }
        for side in &self.group.walls {
            conversation.tell(side.peer, Kind::Commit, window, side.of(&place).to_vec())?;
        }
        let Some(next) = next.filter(|_| self.begins_with_continua()) else {
            return Ok(());
        };
        self.group.continua.iter().try_for_each(|side| {
            let force = side.of(&self.lambda).to_vec();
            conversation.foretell(side.peer, Kind::Advance, &side.window(&next), force)
        })
    }

    fn reports(&self, conversation: &mut Conversation) -> Result<Vec<(usize, Vec<f64>)>, Error> {
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
fn entry<'a>(
    patch: &Patch,
    solved: &'a Solved,
    given: &[f64],
    point_motion: &'a [f64],
    wall_motion: &'a [f64],
) -> WindowEntry<'a> {
    let (used, given) = (patch.of_nodes(&solved.used), patch.of_nodes(given));
    let late = used
        .iter()
        .zip(given)
        .zip(patch.of_nodes(&solved.increment));
    WindowEntry {
        late_work_j: late.map(|((used, given), du)| (used - given) * du).sum(),
        point_force: patch.of_points(&solved.answer.force),
        nodal_force: patch.of_nodes(&solved.lambda),
        point_motion: patch.of_points(point_motion),
        wall_motion: patch.of_points(wall_motion),
        spacing_m: patch.spacing_m,
    }
}

fn hear_wall(
    conversation: &mut Conversation,
    peer: usize,
    window: &Window,
    components: usize,
) -> Result<WallAnswer, Error> {
    let due = 2 * components + 3;
    let numbers = conversation.hear_exactly(peer, Kind::Force, window, due)?;
    Ok(unpack_wall_answer(&numbers, components).expect("the length was checked"))
}
