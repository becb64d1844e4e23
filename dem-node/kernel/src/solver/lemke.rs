//! The solution of a contact problem with friction by pivoting: the fallback where sweeps circle or stagnate.
//!
//! In the plane Signorini and Coulomb are linear piece by piece, so the problem is a linear complementarity problem. Gaps that all
//! open fast enough, U = W r + b + t d with d_n > mu |d_t| and t large, let no contact close: r = 0 is the solution. Along the path of
//! solutions from there
//!
//! ```text
//! (r, U)(t) obeys Signorini-Coulomb,     U = (W + eps D) r + b + t d
//! ```
//!
//! one contact at a time closes, opens, sticks or slips; between these events r is linear in t, and t may turn back for a while. The answer is the
//! point of the path at t = 0. This is Lemke's method ("Bimatrix equilibrium points and mathematical programming", Management Science 11 (1965)
//! 681-689) applied to the statuses of contacts. It ends at a solution for any friction: r.U <= 0 bounds r on every stretch of t as W + eps D is
//! positive definite, and leaves only r = 0 at large t, so the path can only go on to t = 0 (Anitescu and Potra, Nonlinear Dynamics 14 (1997)
//! 231-247, for the 3D problem with polyhedral cones). Its length is unknown beforehand: there are usually one to four events per closed contact, but
//! the path for a step of 300 rigid disks that flow at friction 1 was given up after 15 000.
//!
//! eps D, springs of negligible compliance, makes r unique where the forces of rigid grains are not. They leave a residual of eps, which proximal
//! steps (Rockafellar, SIAM J. Control Optim. 14 (1976) 877-898) remove for a tighter tolerance: b less eps D r of the last answer, in the same
//! statuses.

mod delassus;
mod system;
#[cfg(test)]
mod tests;
use super::contact::{Contact, NO_BOND};
use super::problem::Problem;
use super::residual::residual;
use delassus::Delassus;
use system::{Linear, System};

/// eps, over the tolerance, and its bounds.
const SOFTENING: f64 = 0.1;
const SOFTENING_BOUNDS: [f64; 2] = [1e-9, 1e-5];

/// Largest number of updated entries of inverses, some ten seconds of work.
const MOST_WORK: usize = 4_000_000_000;

/// Number of contacts that press in the sweeps' last answer above which this is not enough for two events each: 2 n of n^2 entries.
const MOST_PRESSING: usize = 1_250;

/// Error of the equations over the size of their terms above which the solution is corrected, and above which the path is given up.
const CORRECTED: f64 = 1e-11;
const LOST: f64 = 1e-6;

/// Start of the path over the t at which the first contact closes.
const BEFORE: f64 = 1.0 + 1e-9;

/// Proximal steps.
const PROXIMAL: usize = 5;

/// Part of d that differs from contact to contact: no two events may coincide.
const SPREAD: f64 = 0.5;

/// The problem with the impulses that solve it, which the true residual must judge. `None` with bonds, or where the path cannot be followed: it would
/// be too long where more than [`MOST_PRESSING`] contacts press.
pub(super) fn solve(problem: &Problem, tolerance: f64) -> Option<Problem> {
    let pressing = problem.contacts.iter().filter(|c| c.impulse[0] > 0.0);
    let bonded = problem.contacts.iter().any(|c| c.bond != NO_BOND);
    if bonded || pressing.count() > MOST_PRESSING {
        return None;
    }
    let softening = (SOFTENING * tolerance).clamp(SOFTENING_BOUNDS[0], SOFTENING_BOUNDS[1]);
    let w = Delassus::new(problem, softening)?;
    let without = with_impulses(problem, &vec![[0.0; 2]; problem.contacts.len()]);
    let mut path = Path::new(&without, &w);
    path.follow()?;
    let mut solved = with_impulses(&without, &path.impulses());
    for _ in 0..PROXIMAL {
        if residual(&solved) <= tolerance {
            break;
        }
        path.take_back(&softened(&solved, softening));
        solved = with_impulses(&without, &path.impulses());
    }
    Some(solved)
}

/// The problem with other impulses and the velocities under them.
fn with_impulses(problem: &Problem, impulses: &[[f64; 2]]) -> Problem {
    let mut changed = problem.clone();
    let mut contacts = std::mem::take(&mut changed.contacts);
    for (contact, [r_n, r_t]) in contacts.iter_mut().zip(impulses) {
        let old = contact.impulse;
        changed.apply(contact, [r_n - old[0], r_t - old[1]]);
        contact.impulse = [*r_n, *r_t];
    }
    changed.contacts = contacts;
    changed.boundary.evaluate();
    changed
}

/// eps D r (m/s).
fn softened(problem: &Problem, softening: f64) -> Vec<[f64; 2]> {
    let of = |contact: &Contact| {
        let (d, r) = (delassus::weights(contact), contact.impulse);
        [softening * d[0] * r[0], softening * d[1] * r[1]]
    };
    problem.contacts.iter().map(of).collect()
}

/// State of a contact. A side is the sign s of r_t = s mu r_n when it slips; a sticking contact keeps the sign of a side to which it may slip.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Status {
    Open,
    Slipping(f64),
    Sticking(f64),
}

/// Events that end a stretch of the path.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Event {
    Closes,
    Opens,
    Sticks,
    Slips,
    /// To the other side.
    SlipsBack,
}

/// The path and its present point. The unknowns are r_n of closed contacts and the reserve mu r_n - s r_t of sticking ones, the equations U_n = 0 and
/// U_t = 0.
struct Path<'a> {
    w: &'a Delassus,
    /// Coefficient of friction of each contact.
    friction: Vec<f64>,
    /// b and d of each contact, (normal, tangential).
    free: Vec<[Linear; 2]>,
    /// U.
    velocity: Vec<[Linear; 2]>,
    status: Vec<Status>,
    system: System,
    /// Contact and axis of each unknown, and of the equation of the same index.
    labels: Vec<(usize, usize)>,
    /// Indices of the unknowns of each contact, as far as its status has them.
    unknowns: Vec<[usize; 2]>,
    t: f64,
}

impl<'a> Path<'a> {
    /// The path of a problem under no impulses, where all contacts are open.
    fn new(problem: &Problem, w: &'a Delassus) -> Path<'a> {
        let line = |(i, contact): (usize, &Contact)| {
            // Multiples of irrational numbers fall evenly over 0..1.
            let spread = |number: f64| SPREAD * (i as f64 * number).fract();
            let d = [
                1.0 + spread(0.618_033_988_749_895),
                spread(0.414_213_562_373_095),
            ];
            let u = problem.relative_velocity(contact);
            [
                [u[0] + contact.bias[0], d[0]],
                [u[1] + contact.bias[1], d[1] / (1.0 + contact.law.friction)],
            ]
        };
        let friction = problem.contacts.iter().map(|c| c.law.friction);
        let free: Vec<[Linear; 2]> = problem.contacts.iter().enumerate().map(line).collect();
        let closing = |[[b, d], _]: &[Linear; 2]| -b / d;
        let first = free.iter().map(closing).fold(0.0, f64::max);
        Path {
            w,
            friction: friction.collect(),
            velocity: free.clone(),
            status: vec![Status::Open; free.len()],
            unknowns: vec![[usize::MAX; 2]; free.len()],
            free,
            system: System::default(),
            labels: Vec::new(),
            t: BEFORE * first,
        }
    }

    /// Follows the path to t = 0.
    fn follow(&mut self) -> Option<()> {
        let mut work = 0;
        // The margin that the last event released, which moves away from its bound.
        let mut released = None;
        loop {
            self.evaluate()?;
            let onwards = match released {
                None => -1.0,
                Some((contact, event)) => self.slope(contact, event)?.signum(),
            };
            let next = self.next(onwards, released);
            let step = next.map_or(f64::INFINITY, |(step, ..)| step);
            if onwards < 0.0 && self.t <= step {
                self.t = 0.0;
                return Some(());
            }
            let (step, contact, event) = next?;
            self.t += onwards * step;
            released = Some((contact, self.change(contact, event)?));
            work += self.labels.len().pow(2) + self.status.len();
            if work > MOST_WORK {
                return None;
            }
        }
    }

    /// The next event at t + `onwards` x step: (step, contact, event).
    fn next(&self, onwards: f64, released: Option<(usize, Event)>) -> Option<(f64, usize, Event)> {
        let mut first = None;
        let mut least = f64::INFINITY;
        for contact in 0..self.status.len() {
            for (event, [value, slope]) in self.margins(contact) {
                let falls = -onwards * slope;
                if falls > 0.0 && Some((contact, event)) != released {
                    let step = (value + self.t * slope).max(0.0) / falls;
                    if step < least {
                        (least, first) = (step, Some((step, contact, event)));
                    }
                }
            }
        }
        first
    }

    /// The margins that must stay positive at a contact, each with the event at its zero.
    fn margins(&self, contact: usize) -> [(Event, Linear); 2] {
        let [u_n, u_t] = self.velocity[contact];
        let unknown = |axis: usize| self.system.solution[self.unknowns[contact][axis]];
        match self.status[contact] {
            Status::Open => [(Event::Closes, u_n); 2],
            Status::Slipping(side) => [
                (Event::Opens, unknown(0)),
                (Event::Sticks, u_t.map(|u| -side * u)),
            ],
            Status::Sticking(_) => {
                let (r_n, reserve) = (unknown(0), unknown(1));
                let other = [0, 1].map(|k| 2.0 * self.friction[contact] * r_n[k] - reserve[k]);
                [(Event::Slips, reserve), (Event::SlipsBack, other)]
            }
        }
    }

    fn slope(&self, contact: usize, event: Event) -> Option<f64> {
        let margins = self.margins(contact);
        let (_, [_, slope]) = margins.iter().find(|margin| margin.0 == event)?;
        (*slope != 0.0 && slope.is_finite()).then_some(*slope)
    }

    /// Applies an event. Returns the event of the margin that it releases from zero; `None` if the equations become singular.
    fn change(&mut self, contact: usize, event: Event) -> Option<Event> {
        let unknowns = self.unknowns[contact];
        match (event, self.status[contact]) {
            (Event::Closes, _) => {
                let [_, [value, slope]] = self.velocity[contact];
                let side = if value + self.t * slope > 0.0 {
                    -1.0
                } else {
                    1.0
                };
                self.status[contact] = Status::Slipping(side);
                self.add(contact, 0, [1.0, side * self.friction[contact]])?;
                Some(Event::Opens)
            }
            (Event::Opens, _) => {
                self.status[contact] = Status::Open;
                self.remove(unknowns[0])?;
                Some(Event::Closes)
            }
            (Event::Sticks, Status::Slipping(side)) => {
                self.add(contact, 1, [0.0, -side])?;
                self.status[contact] = Status::Sticking(side);
                Some(Event::Slips)
            }
            (Event::Slips, Status::Sticking(side)) => {
                self.status[contact] = Status::Slipping(side);
                self.remove(unknowns[1])?;
                Some(Event::Sticks)
            }
            (Event::SlipsBack, Status::Sticking(side)) => {
                self.system
                    .mirror(unknowns[1], unknowns[0], 2.0 * self.friction[contact]);
                self.status[contact] = Status::Slipping(-side);
                self.remove(unknowns[1])?;
                Some(Event::Sticks)
            }
            _ => None,
        }
    }

    /// r of a contact, given the unknowns.
    fn impulse(&self, contact: usize) -> [Linear; 2] {
        let unknown = |axis: usize| self.system.solution[self.unknowns[contact][axis]];
        match self.status[contact] {
            Status::Open => [[0.0; 2]; 2],
            Status::Slipping(side) => {
                let r_n = unknown(0);
                [r_n, r_n.map(|r| side * self.friction[contact] * r)]
            }
            Status::Sticking(side) => {
                let (r_n, reserve) = (unknown(0), unknown(1));
                [
                    r_n,
                    [0, 1].map(|k| side * (self.friction[contact] * r_n[k] - reserve[k])),
                ]
            }
        }
    }

    /// r of all contacts at t = 0.
    fn impulses(&self) -> Vec<[f64; 2]> {
        let values = |contact: usize| self.impulse(contact).map(|[value, _]| value);
        (0..self.status.len()).map(values).collect()
    }

    /// Adds an unknown of a contact, `direction` being its r per unit, and the equation U = 0 along that axis.
    fn add(&mut self, contact: usize, axis: usize, direction: [f64; 2]) -> Option<()> {
        let times = |block: delassus::Block, row: usize, r: [f64; 2]| {
            block[row][0] * r[0] + block[row][1] * r[1]
        };
        let (mut column, mut row) = (Vec::new(), Vec::new());
        for (other, block) in &self.w.rows[contact] {
            for (k, theirs) in self.directions(*other).into_iter().enumerate() {
                let Some(theirs) = theirs.filter(|_| *other != contact || k < axis) else {
                    continue;
                };
                let unknown = self.unknowns[*other][k];
                let mirrored = self.w.block(*other, contact);
                column.push((unknown, times(mirrored, k, direction)));
                row.push((unknown, times(*block, axis, theirs)));
            }
        }
        let corner = times(self.w.block(contact, contact), axis, direction);
        let right = self.free[contact][axis].map(|free| -free);
        self.unknowns[contact][axis] = self.system.len();
        self.labels.push((contact, axis));
        self.system
            .border(&column, &row, corner, right)
            .then_some(())
    }

    fn remove(&mut self, unknown: usize) -> Option<()> {
        self.labels.swap_remove(unknown);
        if let Some((contact, axis)) = self.labels.get(unknown) {
            self.unknowns[*contact][*axis] = unknown;
        }
        self.system.remove(unknown).then_some(())
    }

    /// The r per unit of each unknown of a contact.
    fn directions(&self, contact: usize) -> [Option<[f64; 2]>; 2] {
        match self.status[contact] {
            Status::Open => [None; 2],
            Status::Slipping(side) => [Some([1.0, side * self.friction[contact]]), None],
            Status::Sticking(side) => [
                Some([1.0, side * self.friction[contact]]),
                Some([0.0, -side]),
            ],
        }
    }

    /// Computes U for the unknowns, which are corrected where the equations have a rounding error.
    fn evaluate(&mut self) -> Option<()> {
        let size = self.compute_velocity();
        if self.error(size) > CORRECTED {
            self.system.correct(&self.left());
            let size = self.compute_velocity();
            // Written so that a NaN is refused as well.
            let kept = self.error(size) <= LOST;
            return kept.then_some(());
        }
        Some(())
    }

    /// Computes U and returns the largest size of W r and of the free velocity, by value and slope.
    fn compute_velocity(&mut self) -> Linear {
        let impulses: Vec<[Linear; 2]> = (0..self.status.len()).map(|c| self.impulse(c)).collect();
        let mut size = [0.0f64; 2];
        for ((row, free), velocity) in self.w.rows.iter().zip(&self.free).zip(&mut self.velocity) {
            *velocity = *free;
            for (j, block) in row {
                let r = &impulses[*j];
                for (velocity, block) in velocity.iter_mut().zip(block) {
                    for k in 0..2 {
                        let term = [block[0] * r[0][k], block[1] * r[1][k]];
                        velocity[k] += term[0] + term[1];
                        size[k] = size[k].max(term[0].abs()).max(term[1].abs());
                    }
                }
            }
        }
        size
    }

    fn left(&self) -> Vec<Linear> {
        let of = |(contact, axis): &(usize, usize)| self.velocity[*contact][*axis];
        self.labels.iter().map(of).collect()
    }

    /// Largest error of an equation over the size of its terms.
    fn error(&self, size: Linear) -> f64 {
        let mut error: f64 = 0.0;
        for left in self.left() {
            for k in 0..2 {
                if left[k] != 0.0 {
                    let relative = left[k].abs() / size[k];
                    // Written so that a NaN stays NaN.
                    error = if relative <= error { error } else { relative };
                }
            }
        }
        error
    }

    /// Moves b by -`change` in the equations of a path at its end.
    fn take_back(&mut self, change: &[[f64; 2]]) {
        self.compute_velocity();
        let mut left = self.left();
        for ((contact, axis), left) in self.labels.iter().zip(&mut left) {
            left[0] -= change[*contact][*axis];
        }
        self.system.correct(&left);
    }
}
