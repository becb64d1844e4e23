//! The coupling of one group of interfaces: its scheme, its state, and the policy for windows that do not converge.

use nalgebra::DMatrix;
use protocol::{Window, larger};
use serde::{Deserialize, Serialize};

use super::acceleration::Accelerator;
use super::compliance::{Compliance, ComplianceState};
use super::criteria::{Motions, leaking};
use super::fixed_point::FixedPoint;
use super::group::Group;
use super::heat::HeatState;
use super::ledger::{InterfaceLedger, PointMotion, total};
use super::participants::Participants;
use super::problem::WindowProblem;
use super::source::ComplianceSource;
use super::window::{AcceptedWindow, Attempt, InterfaceSignals, InterfaceState, SolvedWindow};
use super::{dual_schur, fixed_point, neumann_dirichlet, staggered, velocity};
use crate::error::{Result, SchemeError, Unfit};
use crate::keys::{CouplingScheme, Dirichlet, Policy, Update};

/// The coupler's own state of one group. It changes only when a window is accepted.
#[derive(Clone, Debug)]
pub struct Coupling {
    name: String,
    scheme: CouplingScheme,
    policy: Policy,
    group: Group,
    compliance: Compliance,
    /// State of the interfaces after the last accepted window.
    pub state: InterfaceState,
    /// Ledger of each interface of the group.
    pub ledgers: Vec<InterfaceLedger>,
    /// Heat through the interfaces.
    pub heat: HeatState,
}

/// The part of a coupling that windows change. The rest follows from the scenario and the handshake.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CouplingState {
    compliance: ComplianceState,
    state: InterfaceState,
    ledgers: Vec<InterfaceLedger>,
    heat: HeatState,
}

impl Coupling {
    /// All sides at rest and unloaded; messages speak of the interface `name`.
    pub fn new(name: &str, scheme: CouplingScheme, policy: Policy, group: Group) -> Coupling {
        let factor = match scheme {
            CouplingScheme::DualSchur {
                update: Update::Cheap,
                ..
            } => dual_schur::CHEAP_FACTOR,
            _ => 1.0,
        };
        Coupling {
            name: name.to_string(),
            scheme,
            policy,
            compliance: Compliance::new(ComplianceSource::of(&scheme), factor),
            state: InterfaceState::at_rest(group.nodes.len(), group.points.len()),
            ledgers: vec![InterfaceLedger::default(); group.patches.len()],
            heat: HeatState::default(),
            group,
        }
    }

    /// The interfaces as agreed at the handshake.
    pub fn group(&self) -> &Group {
        &self.group
    }

    /// The scheme with its data.
    pub fn scheme(&self) -> &CouplingScheme {
        &self.scheme
    }

    /// Tries a window until it is accepted or the scenario's policy decides otherwise. `following` returns the window
    /// after an accepted one.
    pub fn window(
        &mut self,
        participants: &mut dyn Participants,
        window: Window,
        following: impl Fn(&Window) -> Option<Window>,
    ) -> Result<Attempt> {
        if self.group.heat_every.is_some() {
            self.heat.begin(&self.group, participants, &window)?;
        }
        let mut solved = match self.solve(participants, window) {
            Err(SchemeError::NotFinite(_)) if self.may_halve(&window) => return Ok(self.halve()),
            solved => solved?,
        };
        let leaks = leaking(&self.group, &self.ledgers, &solved);
        solved.faults.extend(leaks);
        match (solved.faults.first(), self.policy) {
            (None, _) => {}
            (Some(_), Policy::Accept) => {
                for fault in &solved.faults {
                    self.ledgers[fault.patch].not_converged += 1;
                }
            }
            (Some(_), Policy::Halve) if self.may_halve(&window) => return Ok(self.halve()),
            (Some(fault), Policy::Halve) => {
                let end = self.cannot_halve();
                return Err(SchemeError::NotConverged(format!("{}; {end}", fault.why)));
            }
            (Some(fault), Policy::Stop) => {
                return Err(SchemeError::NotConverged(fault.why.clone()));
            }
        }
        let next = following(&solved.window);
        self.accept(participants, solved, next)
            .map(Attempt::Accepted)
    }

    /// Solves one window by the scheme, without accepting it.
    fn solve(
        &mut self,
        participants: &mut dyn Participants,
        window: Window,
    ) -> Result<SolvedWindow> {
        let problem = &mut WindowProblem {
            group: &self.group,
            start: &self.state,
            compliance: &mut self.compliance,
            ledgers: &mut self.ledgers,
            participants,
        };
        match self.scheme {
            CouplingScheme::DualSchur {
                update,
                repeats_max,
                ..
            } => dual_schur::solve(problem, update, repeats_max, window),
            CouplingScheme::Velocity { repeats_max } => {
                velocity::solve(problem, repeats_max, window)
            }
            CouplingScheme::Staggered { order, dirichlet } => match dirichlet {
                Dirichlet::MotionDriven => staggered::solve(problem, order, window),
                Dirichlet::ForceDriven => {
                    neumann_dirichlet::solve_staggered(problem, order, window)
                }
            },
            CouplingScheme::FixedPoint {
                order,
                dirichlet,
                acceleration,
                relaxation,
                repeats_max,
            } => {
                let rules = FixedPoint {
                    order,
                    accelerator: Accelerator::new(acceleration, relaxation),
                    repeats_max,
                };
                match dirichlet {
                    Dirichlet::MotionDriven => fixed_point::solve(problem, rules, window),
                    Dirichlet::ForceDriven => {
                        neumann_dirichlet::solve_fixed_point(problem, rules, relaxation, window)
                    }
                }
            }
        }
    }

    fn may_halve(&self, window: &Window) -> bool {
        self.policy == Policy::Halve && window.substeps > 1
    }

    fn halve(&mut self) -> Attempt {
        for ledger in &mut self.ledgers {
            ledger.halved += 1;
        }
        Attempt::Halve
    }

    fn cannot_halve(&self) -> String {
        if self.group.force_driven.iter().all(|side| side.steps == 1) {
            "the window has one step left and cannot be halved".into()
        } else {
            "the connected continua have no shorter window that is a whole number of steps of each: choose substeps with more common factors".into()
        }
    }

    /// Makes a solved window the state of all sides, and enters it into the ledgers while they work.
    fn accept(
        &mut self,
        participants: &mut dyn Participants,
        solved: SolvedWindow,
        next: Option<Window>,
    ) -> Result<AcceptedWindow> {
        for (total, increment) in self.state.displacement.iter_mut().zip(&solved.increment) {
            *total += increment;
        }
        self.state.lambda.clone_from(&solved.lambda);
        if let Some(velocity) = &solved.velocity {
            self.state.velocity.clone_from(velocity);
        }
        let exchanges = self.exchanges_heat(&solved.window, next.is_none());
        let early = next.filter(|_| !exchanges);
        self.accept_window(participants, &solved.window, early)?;
        let motions = Motions::of(&self.group, &solved);
        let signals = self.enter(&solved, &motions);
        self.state.last_motion = motions.points;
        let sides = self.group.force_driven.iter();
        let sides = sides.chain(&self.group.motion_driven);
        let reports = sides.map(|side| Ok((side.peer, participants.report(side.peer)?)));
        let reports: Result<_> = reports.collect();
        let reports = reports?;
        if exchanges {
            self.heat
                .exchange(&self.group, participants, &solved.window)?;
        }
        Ok(AcceptedWindow { signals, reports })
    }

    /// True for a window after which heat is exchanged, the last one included.
    fn exchanges_heat(&self, window: &Window, last: bool) -> bool {
        let every = self.group.heat_every.map(u64::from);
        every.is_some_and(|every| last || (window.index + 1).is_multiple_of(every))
    }

    /// Has all sides accept the window. Where the scheme begins the next window with a run of the force-driven sides
    /// under this window's force, they begin it now.
    fn accept_window(
        &self,
        participants: &mut dyn Participants,
        window: &Window,
        next: Option<Window>,
    ) -> Result<()> {
        let next = next.filter(|_| matches!(self.scheme, CouplingScheme::DualSchur { .. }));
        for side in &self.group.force_driven {
            participants.accept(side.peer, &side.window(window), &[])?;
            if let Some(next) = &next {
                let force = side.of(&self.state.lambda);
                participants.begin_early(side.peer, &side.window(next), force)?;
            }
        }
        let position = self.group.mapping.motion(&self.state.displacement);
        let mut sides = self.group.motion_driven.iter();
        sides.try_for_each(|side| participants.accept(side.peer, window, side.of(&position)))
    }

    /// Enters a window into the ledger of each interface.
    fn enter(
        &mut self,
        solved: &SolvedWindow,
        motions: &Motions,
    ) -> Vec<(usize, InterfaceSignals)> {
        let mut signals = Vec::new();
        for (patch, ledger) in self.group.patches.iter().zip(&mut self.ledgers) {
            let entry = motions.entry(patch, solved);
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
            let residual = solved.answer.solves[patch.motion_driven].residual;
            ledger.contact_residual_max = larger(ledger.contact_residual_max, residual);
            let force_n = total(patch.of_nodes(&solved.lambda));
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

    /// C (m/N) of each force-driven participant in a full window, where the scheme uses their own columns.
    pub fn columns(
        &mut self,
        participants: &mut dyn Participants,
    ) -> Result<Option<Vec<DMatrix<f64>>>> {
        self.compliance.columns(participants, &self.group)
    }

    /// The part that windows have changed.
    pub fn state(&self) -> CouplingState {
        CouplingState {
            compliance: self.compliance.state.clone(),
            state: self.state.clone(),
            ledgers: self.ledgers.clone(),
            heat: self.heat.clone(),
        }
    }

    /// Restores a state that was saved after the same handshake.
    pub fn restore(&mut self, state: &CouplingState) -> Result<()> {
        let lengths = |state: &InterfaceState, ledgers: &[InterfaceLedger]| {
            [state.lengths().as_slice(), &[ledgers.len()]].concat()
        };
        let ours = lengths(&self.state, &self.ledgers);
        let theirs = lengths(&state.state, &state.ledgers);
        if theirs != ours || !state.compliance.is_of(&self.group) {
            let problem = format!(
                "the checkpoint belongs to other interfaces, with {theirs:?} instead of {ours:?} components"
            );
            return Err(Unfit::interface(&self.name, problem).into());
        }
        self.compliance.state = state.compliance.clone();
        (self.state, self.ledgers) = (state.state.clone(), state.ledgers.clone());
        self.heat = state.heat.clone();
        Ok(())
    }

    /// Sends the boundaries again, after a restart.
    pub fn repeat_boundaries(&self, participants: &mut dyn Participants) -> Result<()> {
        self.compliance.repeat_boundaries(participants, &self.group)
    }
}
