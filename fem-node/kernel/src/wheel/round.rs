//! A round face: normals differ from node to node, so that normal and tangential parts couple.

use kit::rolling::nearest_image;
use protocol::larger;

use super::coulomb::admissible;
use super::node_contact::{ContactStatus, NodeContact};
use super::problem::{NodeMotion, WheelStep};
use super::rigid::round_gap;
use crate::pack::largest;

/// Residual of the natural map over the largest force at which the sweeps end: forces that are right to ten digits
/// keep the energy balance below 1e-6 over any number of steps.
const TOLERANCE: f64 = 1e-10;

/// Largest number of sweeps: a wheel as heavy as its nodes in contact needs some 10, a wheel of a hundredth of their mass some 500.
pub(super) const SWEEPS_MAX: usize = 2_000;

/// Local problems of the nodes below a round face.
#[derive(Clone, Debug, Default)]
pub(super) struct RoundFace {
    nodes: Vec<LocalProblem>,
}

/// Local problem of one node: gap = g + n.(w r) and slip = s - t.(w r) plus the effect of the wheel's motion on both. A wheel that rolls by dX and
/// turns by R dphi slips by t.dX - R dphi past a node that rests.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LocalProblem {
    /// Unit vector from the centre of the wheel to the node.
    n: [f64; 2],
    t: [f64; 2],
    gap: f64,
    slip: f64,
    w_nn: f64,
    w_nt: f64,
    w_tt: f64,
    r_n: f64,
    r_t: f64,
}

impl RoundFace {
    /// Block Gauss-Seidel: each node in turn obeys Signorini and Coulomb exactly under the current force of all others on the wheel (Jourdan, Alart,
    /// Jean 1998). Fails with the residual after [`SWEEPS_MAX`].
    pub(super) fn solve(
        &mut self,
        nodes: &[NodeMotion],
        radius: f64,
        wheel: &WheelStep,
        contacts: &mut [NodeContact],
    ) -> Result<(), f64> {
        let pairs = nodes.iter().zip(contacts.iter());
        self.nodes.clear();
        self.nodes
            .extend(pairs.map(|(node, contact)| LocalProblem::new(node, radius, wheel, contact)));
        let solved = self.sweep(wheel);
        for (node, contact) in self.nodes.iter().zip(contacts) {
            *contact = node.contact(wheel.friction);
        }
        solved
    }

    /// Vertical force on the wheel and tangential force on the nodes (N).
    fn totals(&self) -> [f64; 2] {
        let lift = self.nodes.iter().map(LocalProblem::lift).sum::<f64>();
        [lift, self.nodes.iter().map(|node| node.r_t).sum()]
    }

    fn sweep(&mut self, wheel: &WheelStep) -> Result<(), f64> {
        let mut residual = f64::INFINITY;
        for _ in 0..SWEEPS_MAX {
            let [mut lift, mut drag] = self.totals();
            for node in &mut self.nodes {
                lift -= node.lift();
                drag -= node.r_t;
                node.solve(wheel, [lift, drag]);
                lift += node.lift();
                drag += node.r_t;
            }
            residual = self.residual(wheel);
            if residual <= TOLERANCE {
                return Ok(());
            }
        }
        Err(residual)
    }

    /// Largest |r - r*| over the largest force, r* the projection of r - W^-1 (gap, -slip) onto the admissible
    /// forces, with the diagonal of each block for W. NaN if any force is NaN.
    fn residual(&self, wheel: &WheelStep) -> f64 {
        let totals = self.totals();
        let force = largest(self.nodes.iter().map(|b| b.r_n));
        let error = largest(self.nodes.iter().map(|b| b.error(wheel, totals)));
        if error == 0.0 { 0.0 } else { error / force }
    }
}

impl LocalProblem {
    fn new(node: &NodeMotion, radius: f64, wheel: &WheelStep, guess: &NodeContact) -> LocalProblem {
        // Measured from the lowest point of the face.
        let aside = node.point[0] + node.free[0] - wheel.lateral[1];
        let x = nearest_image(aside, wheel.period);
        let y = node.point[1] + node.free[1] - wheel.free_height;
        let (gap, distance) = round_gap(radius, [x, y]);
        let n = [x / distance, (y - radius) / distance];
        let t = [-n[1], n[0]];
        let ahead = [
            wheel.lateral[1] - wheel.lateral[0],
            wheel.free_height - wheel.height,
        ];
        let slip = [0, 1].map(|k| ahead[k] - (node.free[k] - node.now[k]));
        let [w_x, w_y] = [node.weight[0], node.weight[1] + wheel.weight];
        let dot = |a: [f64; 2], b: [f64; 2]| a[0] * b[0] + a[1] * b[1];
        LocalProblem {
            gap,
            slip: dot(t, slip) - wheel.turn,
            w_nn: w_x * n[0] * n[0] + w_y * n[1] * n[1],
            w_nt: w_x * n[0] * t[0] + w_y * n[1] * t[1],
            w_tt: w_x * t[0] * t[0] + w_y * t[1] * t[1] + wheel.turn_weight,
            r_n: dot(n, guess.normal).max(0.0),
            r_t: dot(t, guess.friction),
            n,
            t,
        }
    }

    /// Vertical force of the node on the wheel.
    fn lift(&self) -> f64 {
        -(self.n[1] * self.r_n + self.t[1] * self.r_t)
    }

    /// Gap and slip without the node's own force, `lift` and `drag` being the forces of the others.
    fn without(&self, wheel: &WheelStep, [lift, drag]: [f64; 2]) -> (f64, f64) {
        let rise = wheel.weight * lift;
        let slip = self.slip + self.t[1] * rise - wheel.turn_weight * drag;
        (self.gap - self.n[1] * rise, slip)
    }

    fn solve(&mut self, wheel: &WheelStep, others: [f64; 2]) {
        let (gap, slip) = self.without(wheel, others);
        [self.r_n, self.r_t] = if gap >= 0.0 {
            [0.0, 0.0]
        } else {
            self.closed(gap, slip, wheel.friction)
        };
    }

    /// W (r_n, r_t) = (-gap, slip) while |r_t| <= mu r_n, else r_t = +-mu r_n.
    pub(crate) fn closed(&self, gap: f64, slip: f64, friction: f64) -> [f64; 2] {
        let determinant = self.w_nn * self.w_tt - self.w_nt * self.w_nt;
        // A node that is held in x cannot follow the wheel: it resists with full friction.
        let held = determinant <= 1e-12 * self.w_nn * self.w_nn;
        let [r_n, r_t] = if held {
            [-gap / self.w_nn, f64::INFINITY.copysign(slip)]
        } else {
            [
                (-gap * self.w_tt - slip * self.w_nt) / determinant,
                (slip * self.w_nn + gap * self.w_nt) / determinant,
            ]
        };
        if r_t.abs() <= friction * r_n {
            return [r_n, r_t];
        }
        let share = friction.copysign(r_t);
        let r_n = -gap / (self.w_nn + share * self.w_nt);
        [r_n, share * r_n]
    }

    /// Distance of r from the [`admissible`] part of (r_n - gap/W_nn, r_t + slip/W_tt) (N), `lift` and `drag` being the forces of all nodes.
    fn error(&self, wheel: &WheelStep, [lift, drag]: [f64; 2]) -> f64 {
        let (gap, slip) = self.without(wheel, [lift - self.lift(), drag - self.r_t]);
        let gap = gap + self.w_nn * self.r_n + self.w_nt * self.r_t;
        let slip = slip - self.w_nt * self.r_n - self.w_tt * self.r_t;
        let trial = [self.r_n - gap / self.w_nn, self.r_t + slip / self.w_tt];
        let [r_n, r_t] = admissible(trial, wheel.friction);
        let free = slip == 0.0 || wheel.friction * r_n == 0.0;
        let r_t = if free { self.r_t } else { r_t };
        larger((self.r_n - r_n).abs(), (self.r_t - r_t).abs())
    }

    fn contact(&self, friction: f64) -> NodeContact {
        // Sliding forces are on the limit by construction, sticking forces below.
        let sticks = self.r_t.abs() < friction * self.r_n;
        let status = if self.r_n > 0.0 && sticks {
            ContactStatus::Stick
        } else if self.r_n > 0.0 {
            ContactStatus::slipping(self.r_t)
        } else {
            ContactStatus::Open
        };
        NodeContact {
            normal: self.n.map(|n| n * self.r_n),
            friction: self.t.map(|t| t * self.r_t),
            status,
        }
    }
}
