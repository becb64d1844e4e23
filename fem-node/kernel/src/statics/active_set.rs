//! One increment of the contact problem of Signorini and Coulomb, by an active set.
//!
//! Under the statuses of all nodes the problem is linear. With f_j = -r_n n_j + r_t t_j the force on node j and
//! C the compliance of the edge, u_i = sum C_ij f_j + u_i(tractions), d = (lateral, -approach) the wheel:
//!
//! ```text
//! every closed node     g_i = g0_i + n_i . (d - u_i) = 0
//! that sticks           t_i . (d - d_before - u_i + u_i,before) = 0
//! that slips            r_t = s friction r_n,  s = +1 or -1
//! the wheel             sum (r_n n_y - r_t t_y) = load
//! ```
//!
//! Then the sign that each condition leaves open shows whether the status is right, and wrong statuses change: a pulling force opens a node, a
//! negative gap closes one, a tangential force beyond the cone begins to slip in its own direction, a slip against its force sticks. This is Newton's
//! method on the projections of the laws (Hueeber, Stadler, Wohlmuth, SIAM J. Sci. Comput. 30 (2008) 572-596) and ends after two to five rounds where
//! the load increments are small. Coulomb's law has no potential, so rounds can repeat; then only the worst status changes, and if that does not end
//! either the increment is halved.

use nalgebra::{DMatrix, DVector};
use protocol::larger;
use serde::{Deserialize, Serialize};

use super::contact::WheelContact;
use super::edge::EdgeCompliance;
use super::face::Face;
use crate::wheel::node_contact::ContactStatus;

/// Rounds in which every wrong status changes; after that only the worst does.
const ROUNDS_ALL: usize = 30;

/// Rounds after which the increment is halved.
const ROUNDS_MAX: usize = 400;

/// Halvings of an increment before giving up.
const HALVINGS_MAX: u32 = 6;

/// Share of the largest force or displacement that counts as zero: the rounding of a dense solve.
const ROUNDING: f64 = 1e-10;

/// Reach of new columns: with the columns of a closed node the columns of this many neighbours on each side are computed. Contact grows from its
/// edge, and many columns at a time are cheaper.
const REACH: usize = 8;

/// Load and position of the wheel at the end of an increment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Target {
    /// Vertical force on the wheel (N).
    pub(super) load: f64,
    /// Sideways position of the wheel (m).
    pub(super) lateral: f64,
    /// Coefficient of friction.
    pub(super) friction: f64,
    /// The rolling of a wheel that rolls; `lateral` is then the abscissa of its centre.
    pub(super) turn: Option<Turn>,
}

/// Turning of a wheel that rolls, up to a way or a force.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Turn {
    /// Length of the face that has rolled off, towards +x (m).
    To(f64),
    /// It turns until its tangential force on the body, along +x, is this (N).
    Until(f64),
}

impl Target {
    /// True where friction can hold the node.
    fn friction_acts(&self, edge: &EdgeCompliance, node: usize) -> bool {
        self.friction > 0.0 && edge.free[node]
    }
}

/// Change of a status whose condition is violated.
#[derive(Clone, Copy, Debug)]
struct StatusChange {
    node: usize,
    status: ContactStatus,
    /// Violation of the condition, as a force (N).
    violation: f64,
}

/// An increment that did not converge.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct NotConverged {
    /// The worst violation of a law in the last round, as a force (N).
    pub(super) violation: f64,
    pub(super) iterations: usize,
}

/// The contact at the end of the last increment.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct ActiveSet {
    status: Vec<ContactStatus>,
    normal: Vec<f64>,
    tangential: Vec<f64>,
    /// Displacements of the nodes of the edge (m).
    u: Vec<[f64; 2]>,
    /// Position of the wheel: (lateral, -approach) (m), lateral relative to the face.
    wheel: [f64; 2],
    load: f64,
    /// Length of the face that has rolled off, towards +x (m).
    turned: f64,
    /// Energy that friction has dissipated at each node (J): mean force times slip, increment by increment.
    dissipated: Vec<f64>,
    /// Abscissa of the centre (m).
    centre: f64,
}

impl ActiveSet {
    /// The wheel just touches.
    pub(super) fn open(edge: &EdgeCompliance, centre: f64) -> ActiveSet {
        let nodes = edge.free.len();
        ActiveSet {
            status: vec![ContactStatus::Open; nodes],
            normal: vec![0.0; nodes],
            tangential: vec![0.0; nodes],
            u: vec![[0.0; 2]; nodes],
            wheel: [0.0; 2],
            load: 0.0,
            turned: 0.0,
            dissipated: vec![0.0; nodes],
            centre,
        }
    }

    /// Abscissa of the centre of the wheel (m).
    pub(super) fn centre(&self) -> f64 {
        self.centre
    }

    /// Displacements of the nodes and the approach (m).
    pub(super) fn displaced(&self) -> (&[[f64; 2]], f64) {
        (&self.u, -self.wheel[1])
    }

    /// True if both are of edges with the same number of nodes.
    pub(super) fn is_like(&self, other: &ActiveSet) -> bool {
        let lengths = |set: &ActiveSet| {
            let forces = [&set.normal, &set.tangential].map(Vec::len);
            (set.status.len(), forces, set.u.len())
        };
        lengths(self) == lengths(other)
    }

    pub(super) fn describe(&self, face: &Face) -> WheelContact {
        WheelContact {
            normals: face.normals.clone(),
            normal: self.normal.clone(),
            tangential: self.tangential.clone(),
            status: self.status.clone(),
            approach: -self.wheel[1],
            lateral: face.centre() + self.wheel[0],
            turned: self.turned,
            dissipated: self.dissipated.clone(),
        }
    }

    /// Goes to the target, in one increment if that converges; `extend` computes the columns of nodes.
    pub(super) fn advance(
        &mut self,
        face: &mut Face,
        edge: &mut EdgeCompliance,
        target: Target,
        extend: impl Fn(&mut EdgeCompliance, &[usize]),
    ) -> Result<(), NotConverged> {
        let (mut pieces, mut done, mut halvings) = (1u32, 0u32, 0);
        let rolls = target.turn.is_some();
        let lateral = if rolls { self.centre } else { self.wheel[0] };
        let (load, turned) = (self.load, self.turned);
        let pulled: f64 = self.tangential.iter().sum();
        while done < pieces {
            let share = f64::from(done + 1) / f64::from(pieces);
            let between = |from: f64, to: f64| from + share * (to - from);
            let piece = Target {
                load: between(load, target.load),
                lateral: between(lateral, target.lateral),
                friction: target.friction,
                turn: target.turn.map(|turn| match turn {
                    Turn::To(arc) => Turn::To(between(turned, arc)),
                    Turn::Until(force) => Turn::Until(between(pulled, force)),
                }),
            };
            let moved = rolls.then(|| face.rolled_to(piece.lateral, &self.u, -self.wheel[1]));
            let increment = ContactIncrement {
                before: self,
                face: moved.as_ref().unwrap_or(face),
                target: piece,
            };
            match increment.solve(edge, &extend) {
                Ok(mut after) => {
                    after.dissipate(self, increment.face);
                    *self = after;
                    if let Some(moved) = moved {
                        *face = moved;
                        self.centre = face.centre();
                    }
                    done += 1;
                }
                Err(failure) if halvings == HALVINGS_MAX => return Err(failure),
                Err(_) => {
                    halvings += 1;
                    (pieces, done) = (2 * pieces, 2 * done);
                }
            }
        }
        Ok(())
    }

    /// Closes the lowest node if all are open, so that the wheel rests on a node. Where friction begins now, closed nodes stick.
    fn start(&mut self, face: &Face, target: Target) {
        if self.status.iter().all(|s| *s == ContactStatus::Open) {
            let gap = |node: usize| face.gap(node, self.wheel, self.u[node]);
            let lowest = (0..self.status.len()).min_by(|a, b| gap(*a).total_cmp(&gap(*b)));
            self.status[lowest.expect("an edge has nodes")] = ContactStatus::Stick;
        }
        let no_force_yet = self.tangential.iter().all(|r| *r == 0.0);
        if target.friction > 0.0 && no_force_yet {
            let statuses = self.status.iter_mut();
            let closed = statuses.filter(|s| **s != ContactStatus::Open);
            closed.for_each(|status| *status = ContactStatus::Stick);
        }
    }

    /// Forces and wheel under the current statuses; false where these leave the wheel or a node undetermined.
    fn solve(&mut self, increment: &ContactIncrement, edge: &EdgeCompliance) -> bool {
        let system = System::new(self, increment, edge);
        let Some(solution) = system.matrix.lu().solve(&system.right) else {
            return false;
        };
        self.normal.fill(0.0);
        self.tangential.fill(0.0);
        for (unknown, value) in system.unknowns.iter().zip(solution.iter()) {
            let node = unknown.node;
            match unknown.along {
                Direction::Normal => {
                    self.normal[node] += value;
                    self.tangential[node] += unknown.drag * value;
                }
                Direction::Tangent => self.tangential[node] += value,
            }
        }
        let count = system.unknowns.len();
        let approach = system.scale * solution[count];
        self.wheel = [increment.sideways(), -approach];
        self.turned = match increment.target.turn {
            Some(Turn::To(arc)) => arc,
            Some(Turn::Until(_)) => increment.before.turned + system.scale * solution[count + 1],
            None => self.turned,
        };
        solution.iter().all(|value| value.is_finite())
    }

    fn move_nodes(&mut self, face: &Face, edge: &EdgeCompliance) {
        for (node, u) in self.u.iter_mut().enumerate() {
            *u = edge.under_tractions(node);
        }
        let closed: Vec<usize> = self.closed().collect();
        for source in closed {
            let force = face.force(source, self.normal[source], self.tangential[source]);
            edge.add_moved(source, force, &mut self.u);
        }
    }

    /// Changes of the statuses whose own condition is violated. Without friction the direction of the slip has no
    /// consequence and is only noted.
    fn violations(
        &mut self,
        increment: &ContactIncrement,
        edge: &EdgeCompliance,
    ) -> Vec<StatusChange> {
        let (face, target) = (increment.face, &increment.target);
        let zero = ROUNDING * target.load;
        let mut changes = Vec::new();
        for node in 0..self.status.len() {
            let slip = self.slip(increment.before, face, node);
            let friction_acts = target.friction_acts(edge, node);
            if self.status[node] != ContactStatus::Open && !friction_acts {
                self.status[node] = ContactStatus::slipping(slip);
            }
            let (normal, tangential) = (self.normal[node], self.tangential[node]);
            let excess = tangential.abs() - target.friction * normal;
            // The force that would have held a node which slips against its own; an open node has no direction.
            let against = match self.status[node] {
                ContactStatus::Open => slip / edge.known.scale,
                status => -slip * status.direction() / edge.known.scale,
            };
            let gap = face.gap(node, self.wheel, self.u[node]) / edge.known.scale;
            let (violation, status) = match self.status[node] {
                ContactStatus::Open if friction_acts => {
                    (-gap, held_or(slip, against.abs() > -gap * target.friction))
                }
                ContactStatus::Open => (-gap, ContactStatus::slipping(slip)),
                _ if normal < -zero => (-normal, ContactStatus::Open),
                _ if !friction_acts => (0.0, self.status[node]),
                ContactStatus::Stick => (excess, ContactStatus::slipping(tangential)),
                ContactStatus::SlipForward | ContactStatus::SlipBackward => (
                    against,
                    held_or(slip, against > 2.0 * target.friction * normal),
                ),
            };
            if violation > zero {
                changes.push(StatusChange {
                    node,
                    status,
                    violation,
                });
            }
        }
        changes
    }

    /// Motion of the wheel relative to the node along the tangent in this increment (m).
    fn slip(&self, before: &ActiveSet, face: &Face, node: usize) -> f64 {
        let tangent = face.tangent(node);
        let relative = |s: &ActiveSet, k: usize| s.wheel[k] - s.u[node][k];
        let along = (0..2).map(|k| tangent[k] * (relative(self, k) - relative(before, k)));
        along.sum::<f64>() + face.passed(node) - (self.turned - before.turned)
    }

    /// Adds the mean tangential force times slip since `before` at each node; nothing at a node whose friction has turned round on the way.
    fn dissipate(&mut self, before: &ActiveSet, face: &Face) {
        for node in 0..self.status.len() {
            if self.status[node].direction() != 0.0 {
                let force = 0.5 * (before.tangential[node] + self.tangential[node]);
                self.dissipated[node] += larger(0.0, force * self.slip(before, face, node));
            }
        }
    }

    /// Nodes that touch.
    fn closed(&self) -> impl Iterator<Item = usize> {
        (0..self.status.len()).filter(|node| self.status[*node] != ContactStatus::Open)
    }

    /// Closed nodes without columns, and their neighbours: contact grows from its edge.
    fn unknown_nodes(&self, edge: &EdgeCompliance) -> Vec<usize> {
        let missing: Vec<usize> = self.closed().filter(|node| !edge.knows(*node)).collect();
        let (Some(first), Some(last)) = (missing.first(), missing.last()) else {
            return missing;
        };
        let reach = first.saturating_sub(REACH)..(last + REACH + 1).min(edge.free.len());
        reach.filter(|node| !edge.knows(*node)).collect()
    }
}

/// Slip in this direction where a trial force is beyond the cone, else stick.
fn held_or(slip: f64, beyond: bool) -> ContactStatus {
    if beyond {
        ContactStatus::slipping(slip)
    } else {
        ContactStatus::Stick
    }
}

/// One increment from a state to a target.
pub(crate) struct ContactIncrement<'a> {
    before: &'a ActiveSet,
    face: &'a Face,
    target: Target,
}

impl ContactIncrement<'_> {
    /// Position of the wheel beside its face (m), which rolls along with it.
    fn sideways(&self) -> f64 {
        match self.target.turn {
            Some(_) => 0.0,
            None => self.target.lateral,
        }
    }

    /// The state at the target: Newton's method on the projections of the laws of contact.
    fn solve(
        &self,
        edge: &mut EdgeCompliance,
        extend: &impl Fn(&mut EdgeCompliance, &[usize]),
    ) -> Result<ActiveSet, NotConverged> {
        let mut trial = self.before.clone();
        trial.load = self.target.load;
        if self.target.load == 0.0 {
            return Ok(trial);
        }
        trial.start(self.face, self.target);
        let mut failure = NotConverged::default();
        for round in 0..ROUNDS_MAX {
            let unknown = trial.unknown_nodes(edge);
            if !unknown.is_empty() {
                extend(edge, &unknown);
            }
            if !trial.solve(self, edge) {
                return Err(failure);
            }
            trial.move_nodes(self.face, edge);
            let changes = trial.violations(self, edge);
            let by_violation =
                |a: &&StatusChange, b: &&StatusChange| a.violation.total_cmp(&b.violation);
            let Some(worst) = changes.iter().max_by(by_violation) else {
                return Ok(trial);
            };
            failure = NotConverged {
                violation: worst.violation,
                iterations: round + 1,
            };
            let worst = std::slice::from_ref(worst);
            let wrong = if round < ROUNDS_ALL { &changes } else { worst };
            wrong.iter().for_each(|c| trial.status[c.node] = c.status);
        }
        Err(failure)
    }
}

/// Direction of a contact force.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Direction {
    Normal,
    Tangent,
}

/// One contact force of the linear problem.
#[derive(Clone, Copy, Debug)]
struct Unknown {
    node: usize,
    along: Direction,
    /// Tangential force for each newton of normal force.
    drag: f64,
    /// The force on the node for a value of 1.
    direction: [f64; 2],
}

/// The linear problem under given statuses. After the forces follow the approach over a compliance and, where the wheel turns until it has a given
/// force, its turn over the compliance; the equations of the wheel are multiplied by it, so that all entries have a similar size.
pub(crate) struct System {
    unknowns: Vec<Unknown>,
    matrix: DMatrix<f64>,
    right: DVector<f64>,
    scale: f64,
}

impl System {
    /// Rows g_i = 0 of the closed nodes, t_i . (d - d_before - u_i + u_i,before) = 0 of sticking nodes, and sum (r_n n_y - r_t t_y) = load of the
    /// wheel. To the way past a sticking node rolling adds what has passed and subtracts the turn; sum r_t = T of a given force.
    pub(crate) fn new(
        now: &ActiveSet,
        increment: &ContactIncrement,
        edge: &EdgeCompliance,
    ) -> System {
        let (before, face, target) = (increment.before, increment.face, &increment.target);
        let unknowns = unknowns(now, increment, edge);
        let (count, scale) = (unknowns.len(), edge.known.scale);
        let until = match target.turn {
            Some(Turn::Until(force)) => Some(force),
            _ => None,
        };
        let size = count + 1 + usize::from(until.is_some());
        let mut matrix = DMatrix::zeros(size, size);
        let mut right = DVector::zeros(size);
        let axis = |unknown: &Unknown| match unknown.along {
            Direction::Normal => face.normals[unknown.node],
            Direction::Tangent => face.tangent(unknown.node),
        };
        for (j, source) in unknowns.iter().enumerate() {
            for (i, row) in unknowns.iter().enumerate() {
                let moved = edge.moved(row.node, source.node, source.direction);
                matrix[(i, j)] = dot(axis(row), moved);
            }
            matrix[(count, j)] = -scale * source.direction[1];
        }
        for (i, row) in unknowns.iter().enumerate() {
            let (axis, node) = (axis(row), row.node);
            matrix[(i, count)] = scale * axis[1];
            let wheel = [increment.sideways(), 0.0];
            let to_go = match row.along {
                Direction::Normal => face.gap(node, wheel, edge.under_tractions(node)),
                Direction::Tangent => {
                    let relative = |k: usize| {
                        (wheel[k] - before.wheel[k])
                            - (edge.under_tractions(node)[k] - before.u[node][k])
                    };
                    let turn = match target.turn {
                        Some(Turn::To(arc)) => arc - before.turned,
                        _ => 0.0,
                    };
                    dot(axis, [relative(0), relative(1)]) + face.passed(node) - turn
                }
            };
            right[i] = to_go;
        }
        right[count] = scale * target.load;
        if let Some(force) = until {
            for (i, unknown) in unknowns.iter().enumerate() {
                let (held, pull) = match unknown.along {
                    Direction::Normal => (0.0, unknown.drag),
                    Direction::Tangent => (scale, 1.0),
                };
                (matrix[(i, count + 1)], matrix[(count + 1, i)]) = (held, scale * pull);
            }
            right[count + 1] = scale * force;
        }
        System {
            unknowns,
            matrix,
            right,
            scale,
        }
    }
}

/// A normal force for each closed node, then a tangential force for each sticking node.
fn unknowns(now: &ActiveSet, increment: &ContactIncrement, edge: &EdgeCompliance) -> Vec<Unknown> {
    let ContactIncrement { face, target, .. } = increment;
    let normal = now.closed().map(|node| {
        let drag = if target.friction_acts(edge, node) {
            target.friction * now.status[node].direction()
        } else {
            0.0
        };
        Unknown {
            node,
            along: Direction::Normal,
            drag,
            direction: face.force(node, 1.0, drag),
        }
    });
    let sticks = |node: &usize| now.status[*node] == ContactStatus::Stick;
    let holds = |node: &usize| sticks(node) && target.friction_acts(edge, *node);
    let sticking = now.closed().filter(holds);
    let tangential = sticking.map(|node| Unknown {
        node,
        along: Direction::Tangent,
        drag: 0.0,
        direction: face.force(node, 0.0, 1.0),
    });
    normal.chain(tangential).collect()
}

fn dot(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}
