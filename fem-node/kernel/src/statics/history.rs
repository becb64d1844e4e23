//! Equilibrium under a history of loads, increment by increment.

use kit::rolling::Rolling;
use serde::{Deserialize, Serialize};

use super::active_set::{ActiveSet, Target, Turn};
use super::contact::WheelContact;
use super::edge::{EdgeCompliance, KnownColumns};
use super::face::Face;
use super::factor::Factor;
use super::problem::StaticProblem;
use crate::error::KernelError;
use crate::integrate::state::NodalState;
use crate::wheel::node_contact::ContactStatus;

/// Largest contact half-width over the radius of a round wheel for the use of undeformed normals.
const LEAN_MAX: f64 = 0.5;

/// Largest number of increments of the load of a wheel without friction.
const SMOOTH_INCREMENTS: usize = 20;

/// A wheel that is pressed on the upper edge, its load growing from zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StaticLoads {
    /// Vertical force on the wheel (N).
    pub load: f64,
    /// Radius of its face (m); 0 = flat.
    pub radius: f64,
    /// Coefficient of friction.
    pub friction: f64,
    /// True where friction acts while the load grows.
    pub friction_while_loading: bool,
    /// Equal increments of the load.
    pub increments: usize,
    /// Abscissa of its centre while the load grows (m).
    pub start: f64,
}

/// The data that increments change; the rest of a history of loads follows from the configuration.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct IncrementState {
    edge: KnownColumns,
    contact: ActiveSet,
    increments_done: usize,
}

/// A body in equilibrium.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StaticState {
    /// Displacements and internal forces; velocities and accelerations are zero.
    pub state: NodalState,
    /// Contact forces and the position of the wheel; absent without a wheel.
    pub contact: Option<WheelContact>,
}

/// The equilibrium of a body under its full tractions and its wheel, if it has one.
pub fn equilibrium(
    problem: &StaticProblem,
    loads: Option<&StaticLoads>,
) -> Result<StaticState, KernelError> {
    let mut statics = Statics::new(problem, loads.copied())?;
    for _ in 0..statics.loading_increments() {
        statics.load_increment(problem)?;
    }
    Ok(statics.state(problem))
}

/// A body under a history of loads.
pub struct Statics {
    loads: Option<StaticLoads>,
    factor: Factor,
    edge: EdgeCompliance,
    face: Face,
    contact: ActiveSet,
    /// Increments so far.
    pub increments_done: usize,
}

impl Statics {
    /// Factorises the stiffness; nothing is loaded yet.
    pub fn new(
        problem: &StaticProblem,
        loads: Option<StaticLoads>,
    ) -> Result<Statics, KernelError> {
        let factor = Factor::new(problem)?;
        let [radius, start] = loads.map_or([0.0; 2], |loads| [loads.radius, loads.start]);
        let face = Face::new(radius, start, problem);
        let edge = EdgeCompliance::new(problem, &factor);
        let contact = ActiveSet::open(&edge, face.centre());
        Ok(Statics {
            loads,
            factor,
            edge,
            face,
            contact,
            increments_done: 0,
        })
    }

    /// Number of increments up to the full load. Without friction there is no history, but small increments try fewer wrong nodes and can be reported
    /// one by one.
    pub fn loading_increments(&self) -> usize {
        match self.loads {
            Some(loads) if loads.friction_while_loading && loads.friction > 0.0 => loads.increments,
            Some(loads) => loads.increments.min(SMOOTH_INCREMENTS),
            None => 1,
        }
    }

    /// The data that the increments so far have changed.
    pub fn progress(&self) -> IncrementState {
        IncrementState {
            edge: self.edge.known.clone(),
            contact: self.contact.clone(),
            increments_done: self.increments_done,
        }
    }

    /// Continues from this progress; false if it belongs to another body.
    pub fn take_up(&mut self, progress: IncrementState) -> bool {
        let fits = self.contact.is_like(&progress.contact) && self.edge.take_up(progress.edge);
        if fits {
            let rolled = progress.contact.centre() != self.face.centre();
            self.contact = progress.contact;
            // Until it rolls, the wheel has the normals of the undeformed edge. The nodes passed matter within an increment only.
            if rolled {
                let (u, approach) = self.contact.displaced();
                self.face = self.face.rolled_to(self.contact.centre(), u, approach);
            }
            self.increments_done = progress.increments_done;
        }
        fits
    }

    /// The next increment of load; beyond the full load nothing changes.
    pub fn load_increment(&mut self, problem: &StaticProblem) -> Result<(), KernelError> {
        if self.increments_done >= self.loading_increments() {
            return Ok(());
        }
        self.increments_done += 1;
        self.load_by_one(problem)?;
        if self.increments_done == self.loading_increments() {
            self.check_size(problem)?;
        }
        Ok(())
    }

    /// Refuses a displacement beyond the size of the body: a linear body has an equilibrium under any load, and a load that moves it by more than its
    /// size has a wrong unit.
    fn check_size(&self, problem: &StaticProblem) -> Result<(), KernelError> {
        let (state, size_m) = (self.state(problem).state, problem.mesh.size());
        let moved = state.u.iter().map(|u| u.abs());
        let approach = self.contact().map_or(0.0, |contact| contact.approach);
        let beyond = |u: &f64| u.is_nan() || *u > size_m;
        match moved.chain([approach]).find(beyond) {
            None => Ok(()),
            Some(displacement_m) => Err(KernelError::StaticSize {
                displacement_m,
                size_m,
            }),
        }
    }

    fn load_by_one(&mut self, problem: &StaticProblem) -> Result<(), KernelError> {
        let share = self.increments_done as f64 / self.loading_increments() as f64;
        let Some(loads) = self.loads else {
            self.edge.known.share = share;
            return Ok(());
        };
        let friction = if loads.friction_while_loading {
            loads.friction
        } else {
            0.0
        };
        let target = Target {
            load: share * loads.load,
            lateral: 0.0,
            friction,
            turn: None,
        };
        self.go_to(problem, share, target)
    }

    /// Moves the wheel sideways under the full load, with friction, to this position (m).
    pub fn move_to(&mut self, problem: &StaticProblem, lateral: f64) -> Result<(), KernelError> {
        let Some(loads) = self.loads else {
            return Ok(());
        };
        self.increments_done += 1;
        let target = Target {
            load: loads.load,
            lateral,
            friction: loads.friction,
            turn: None,
        };
        self.go_to(problem, 1.0, target)
    }

    /// Rolls the wheel under the full load, with friction, until this distance (m). A force that is given grows to `share` of its value.
    pub fn roll_to(
        &mut self,
        problem: &StaticProblem,
        rolling: &Rolling,
        rolled: f64,
        share: f64,
    ) -> Result<(), KernelError> {
        let Some(loads) = self.loads else {
            return Ok(());
        };
        self.increments_done += 1;
        let along = rolling.direction();
        let (turned, force) = (rolling.turned(rolled), rolling.force(rolled));
        let to = turned.map(|arc| Turn::To(along * arc));
        let until = force.map(|force| Turn::Until(along * (share * force)));
        let target = Target {
            load: loads.load,
            lateral: rolling.centre(rolled),
            friction: loads.friction,
            turn: to.or(until),
        };
        self.go_to(problem, 1.0, target)
    }

    fn go_to(
        &mut self,
        problem: &StaticProblem,
        share: f64,
        target: Target,
    ) -> Result<(), KernelError> {
        self.edge.known.share = share;
        let (edge, factor) = (&mut self.edge, &self.factor);
        let solved = self
            .contact
            .advance(&mut self.face, edge, target, |edge, nodes| {
                edge.extend(problem, factor, nodes)
            });
        solved.map_err(|failure| KernelError::ContactNotConverged {
            increment: self.increments_done,
            load_n: target.load,
            lateral_m: target.lateral,
            friction: target.friction,
            violation_n: failure.violation,
            iterations: failure.iterations,
        })?;
        self.check_face()
    }

    /// Refuses a wheel that has sunk in to half of its width: the normals belong to the undeformed edge.
    fn check_face(&self) -> Result<(), KernelError> {
        let Some(loads) = self.loads.filter(|loads| loads.radius > 0.0) else {
            return Ok(());
        };
        let contact = self.contact.describe(&self.face);
        let touching =
            (0..contact.normals.len()).filter(|k| contact.status[*k] != ContactStatus::Open);
        let lean = |node: usize| contact.normals[node][0].abs();
        match touching.map(lean).find(|lean| *lean > LEAN_MAX) {
            None => Ok(()),
            Some(lean) => Err(KernelError::NarrowWheel {
                radius_m: loads.radius,
                half_width_m: lean * loads.radius,
                load_n: loads.load,
            }),
        }
    }

    /// The wheel and its contact.
    pub fn contact(&self) -> Option<WheelContact> {
        self.loads.map(|_| self.contact.describe(&self.face))
    }

    /// The whole body in equilibrium with the current loads.
    pub fn state(&self, problem: &StaticProblem) -> StaticState {
        let layout = problem.body.layout;
        let mut load = self.edge.applied(problem);
        let contact = self.contact();
        if let Some(contact) = &contact {
            for node in 0..contact.normals.len() {
                let force = contact.force(node);
                (0..2).for_each(|k| load[layout.index([node, 0], k)] += force[k]);
            }
        }
        let mut state = NodalState::at_rest(problem.body);
        state.u.copy_from_slice(&self.factor.solve(&load));
        problem.body.internal_force(&state.u, &mut state.force);
        StaticState { state, contact }
    }
}
