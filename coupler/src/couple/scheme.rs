//! One window of each coupling scheme.

use nalgebra::DVector;
use protocol::serve::unpack_wall_answer;
use protocol::{Kind, WallAnswer, Window};

use super::conversation::Conversation;
use super::handshake::Joined;
use super::ledger::{InterfaceLedger, WindowEntry, largest_difference};
use crate::error::Error;
use crate::scenario::{Interface, Policy, Scheme};

/// The coupler's own state: it changes only when a window stands.
#[derive(Clone, Debug)]
pub struct Coupling {
    interface: Interface,
    joined: Joined,
    /// Force on the exchanged nodes (N) in the last window that stands.
    pub lambda: Vec<f64>,
    /// Total displacement of the exchanged nodes (m).
    pub displacement: Vec<f64>,
    /// What the interface has seen.
    pub ledger: InterfaceLedger,
}

/// A window that both sides may make their state.
struct Solved {
    window: Window,
    increment: Vec<f64>,
    lambda: Vec<f64>,
    answer: WallAnswer,
    converged: bool,
}

/// What a window that stands left behind.
#[derive(Clone, Debug, Default)]
pub struct Standing {
    /// Repeats beyond the first run.
    pub repeats: u32,
    /// Gap over the mean node spacing.
    pub gap_rel: f64,
    /// What the continuum reported.
    pub continuum_report: Vec<f64>,
    /// What the other side reported.
    pub wall_report: Vec<f64>,
}

impl Coupling {
    /// Both sides at rest and unloaded.
    pub fn new(interface: &Interface, joined: Joined) -> Coupling {
        let size = 2 * joined.nodes.len();
        Coupling {
            interface: interface.clone(),
            joined,
            lambda: vec![0.0; size],
            displacement: vec![0.0; size],
            ledger: InterfaceLedger::default(),
        }
    }

    /// What the handshake agreed on.
    pub fn joined(&self) -> &Joined {
        &self.joined
    }

    /// Runs window `index` until it stands, and makes it the state of everybody.
    pub fn window(
        &mut self,
        conversation: &mut Conversation,
        index: u64,
    ) -> Result<Standing, Error> {
        let solved = match self.interface.scheme {
            Scheme::DualSchur => self.dual_schur(conversation, index)?,
            Scheme::StaggeredSerial => self.staggered_serial(conversation, index)?,
        };
        if !solved.converged {
            self.ledger.not_converged += 1;
        }
        self.stand(conversation, solved)
    }

    /// Dual Schur complement on displacement with a force that is constant in the window.
    ///
    /// The continuum's increment is du = du_free + C lambda, exactly so if it is linear and C holds its own columns. The
    /// other side solves its contacts on the wall v_g = a_g + W_g p with a_g = N (du_k - C lambda_k) / H and
    /// W_g = N C N^T / H^2; its forces F_g are given back as lambda = N^T F_g, and the run of the continuum under this very
    /// lambda decides: |N du - H v_g| must be within the tolerance, whatever C was.
    fn dual_schur(&mut self, conversation: &mut Conversation, index: u64) -> Result<Solved, Error> {
        let window_s = self.joined.clock.window_s();
        let tolerance_m = self.interface.tolerance_rel * self.joined.spacing_m;
        let mut window = self.joined.clock.window(index, 0);
        let mut lambda = self.lambda.clone();
        let mut increment = self.advance(conversation, &window, &lambda)?;
        loop {
            let free = self.free_velocity(&increment, &lambda, window_s);
            let answer = self.solve(conversation, &window, free)?;
            self.refuse_starved(&window, &answer)?;
            lambda = self.joined.mapping.force(&answer.force);
            window.iteration += 1;
            increment = self.advance(conversation, &window, &lambda)?;
            let gap_m = self.gap(&increment, &answer, window_s);
            let converged = gap_m <= tolerance_m;
            if !converged && window.iteration < self.interface.repeats_max {
                continue;
            }
            if !converged && self.interface.on_not_converged == Policy::Stop {
                return Err(Error::NotConverged(format!(
                    "interface `{}`: window {index} (t = {:.6e} s) has a gap of {gap_m:.3e} m = {:.3e} node spacings after {} repeats, tolerance_rel is {:.1e}: the compliance does not fit the continuum any more; lower substeps, raise repeats_max, or accept with on_not_converged = \"accept\"",
                    self.interface.name,
                    window.t0_s,
                    gap_m / self.joined.spacing_m,
                    window.iteration,
                    self.interface.tolerance_rel
                )));
            }
            return Ok(Solved {
                window,
                increment,
                lambda,
                converged: converged && answer.converged,
                answer,
            });
        }
    }

    /// The naive scheme: the continuum runs under the force of the window before, the other side follows its motion
    /// exactly, and its force is used one window later. Nothing is repeated and nothing is checked.
    fn staggered_serial(
        &mut self,
        conversation: &mut Conversation,
        index: u64,
    ) -> Result<Solved, Error> {
        let window_s = self.joined.clock.window_s();
        let window = self.joined.clock.window(index, 0);
        let increment = self.advance(conversation, &window, &self.lambda.clone())?;
        let motion = self.joined.mapping.motion(&increment);
        let velocity = motion.iter().map(|du| du / window_s).collect();
        let answer = self.solve(conversation, &window, velocity)?;
        self.refuse_starved(&window, &answer)?;
        Ok(Solved {
            window,
            increment,
            lambda: self.joined.mapping.force(&answer.force),
            converged: answer.converged,
            answer,
        })
    }

    fn advance(
        &self,
        conversation: &mut Conversation,
        window: &Window,
        lambda: &[f64],
    ) -> Result<Vec<f64>, Error> {
        conversation.ask_exactly(
            self.joined.continuum,
            (Kind::Advance, Kind::Motion),
            window,
            lambda.to_vec(),
            lambda.len(),
        )
    }

    fn solve(
        &mut self,
        conversation: &mut Conversation,
        window: &Window,
        free: Vec<f64>,
    ) -> Result<WallAnswer, Error> {
        let components = free.len();
        let numbers = conversation.ask_exactly(
            self.joined.wall,
            (Kind::Solve, Kind::Force),
            window,
            free,
            2 * components + 3,
        )?;
        let answer = unpack_wall_answer(&numbers, components).expect("the length was checked");
        self.ledger.contact_iterations += answer.iterations;
        Ok(answer)
    }

    /// N (du - C lambda) / H: how the glued points would move without contact forces.
    fn free_velocity(&self, increment: &[f64], lambda: &[f64], window_s: f64) -> Vec<f64> {
        let carried = &self.joined.compliance * DVector::from_column_slice(lambda);
        let free: Vec<f64> = increment
            .iter()
            .zip(carried.iter())
            .map(|(du, c)| du - c)
            .collect();
        let mut velocity = self.joined.mapping.motion(&free);
        velocity.iter_mut().for_each(|v| *v /= window_s);
        velocity
    }

    fn gap(&self, increment: &[f64], answer: &WallAnswer, window_s: f64) -> f64 {
        let motion = self.joined.mapping.motion(increment);
        let wall: Vec<f64> = answer.velocity.iter().map(|v| v * window_s).collect();
        largest_difference(&motion, &wall)
    }

    /// A contact solve that ran out of iterations gives garbage while the gap still reads zero, so it
    /// is the contact solver's own residual that decides.
    fn refuse_starved(&self, window: &Window, answer: &WallAnswer) -> Result<(), Error> {
        if answer.converged || self.interface.on_not_converged == Policy::Accept {
            return Ok(());
        }
        Err(Error::NotConverged(format!(
            "interface `{}`: the contact solve of window {}, iteration {} (t = {:.6e} s) was starved: true residual {:.3e} after {} iterations; raise solver.max_iterations of the participant on the wall, or lower the window",
            self.interface.name,
            window.index,
            window.iteration,
            window.t0_s,
            answer.residual,
            answer.iterations
        )))
    }

    fn stand(
        &mut self,
        conversation: &mut Conversation,
        solved: Solved,
    ) -> Result<Standing, Error> {
        let window_s = self.joined.clock.window_s();
        let point_motion = self.joined.mapping.motion(&solved.increment);
        let wall_motion: Vec<f64> = solved
            .answer
            .velocity
            .iter()
            .map(|v| v * window_s)
            .collect();
        let gap_m = largest_difference(&point_motion, &wall_motion);
        self.ledger.add(&WindowEntry {
            point_force: &solved.answer.force,
            nodal_force: &solved.lambda,
            point_motion: &point_motion,
            wall_motion: &wall_motion,
            spacing_m: self.joined.spacing_m,
        });
        self.ledger.repeats += u64::from(solved.window.iteration);
        self.ledger.contact_residual_max =
            self.ledger.contact_residual_max.max(solved.answer.residual);
        for (total, increment) in self.displacement.iter_mut().zip(&solved.increment) {
            *total += increment;
        }
        self.lambda = solved.lambda;
        let place = self.joined.mapping.motion(&self.displacement);
        conversation.tell(
            self.joined.continuum,
            Kind::Commit,
            &solved.window,
            Vec::new(),
        )?;
        conversation.tell(self.joined.wall, Kind::Commit, &solved.window, place)?;
        let continuum_report = conversation
            .hear(self.joined.continuum, Kind::Report)?
            .payload;
        let wall_report = conversation.hear(self.joined.wall, Kind::Report)?.payload;
        conversation.end_window(solved.window.index)?;
        Ok(Standing {
            repeats: solved.window.iteration,
            gap_rel: gap_m / self.joined.spacing_m,
            continuum_report,
            wall_report,
        })
    }
}
