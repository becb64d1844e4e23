//! A contact of the problem, and the record of a body that it reads and writes.

use crate::law::lanes::Real;
use crate::law::local::{DelassusBlock, LocalLaw};

/// Velocity and inertia of a body in the contact problem: one aligned record, so that a contact loads each of its
/// bodies as a whole.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(align(32))]
pub struct BodyRecord {
    /// v_x, v_y and spin times radius (m/s).
    pub velocity: [f64; 3],
    /// 1/m (1/kg). A disk turns with r^2/I = 2/m, the wheel moves by impulses along y only; 0 where all motion is
    /// prescribed.
    pub inverse_mass: f64,
}

impl BodyRecord {
    /// Adds the impulse (r_n, r_t) of a contact to the velocity of a free disk with this lever over its radius; `force` is that
    /// impulse in x and y on the disk (N s). The lever is -r n on a and +r n on b, and the impulses are opposite: both
    /// disks turn the same way.
    #[inline(always)]
    pub(crate) fn push(&mut self, lever: f64, force: [f64; 2], impulse: [f64; 2]) {
        self.velocity[0] += self.inverse_mass * force[0];
        self.velocity[1] += self.inverse_mass * force[1];
        self.velocity[2] -= 2.0 * self.inverse_mass * lever * impulse[1];
    }
}

/// The index of a contact without bond.
pub const NO_BOND: u32 = u32::MAX;

/// The levers of a contact of two disks, or of a disk with a wall or the wheel.
pub const NO_LEVERS: u32 = u32::MAX;

/// A contact of the problem: three cache lines, of which most passes need the first.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(64))]
pub struct Contact {
    /// Candidate; the normal points to it.
    pub a: u32,
    /// Antagonist.
    pub b: u32,
    /// Index of its bond in [`crate::solver::problem::Problem::bonds`], or [`NO_BOND`].
    pub bond: u32,
    /// Index of its levers in [`crate::solver::problem::Problem::levers`], or [`NO_LEVERS`].
    pub levers: u32,
    /// Index of the law of its pair plus one, as in [`crate::solver::problem::Problem::frictions`]; 0 for the law of most contacts.
    pub pair_law: u32,
    /// True if a or b is a glued disk.
    pub glued: bool,
    /// True for a contact of two single free grains whose block and law detection has set.
    pub(crate) prepared: bool,
    /// Unit normal; the tangent is (-n_y, n_x).
    pub normal: [f64; 2],
    /// Gap over the sum of the radii of two disks. Both turn about the point that divides the line between the centres
    /// like their radii: one point for both, or a gap or an overlap would create angular momentum.
    pub relative_gap: f64,
    /// Impulse, normal and tangential (N s).
    pub impulse: [f64; 2],
    /// Gap at detection (m); for a bond, over its reference.
    pub gap: f64,
    /// The law's own term of U in addition to u, for instance g/h and d_t/h (m/s).
    pub bias: [f64; 2],
    /// Springs on the diagonal, 1/(k h^2) (1/kg).
    pub compliance: [f64; 2],
    /// Block of W, without springs; the solver sets it, and the law.
    pub(crate) block: DelassusBlock,
    /// The law prepared for the block with its springs; for a bond, its law in compression.
    pub(crate) law: LocalLaw,
}

impl Contact {
    /// Lever of each disk over its radius.
    #[inline(always)]
    pub(crate) fn lever(&self) -> f64 {
        1.0 + self.relative_gap
    }

    /// An impulse (r_n, r_t) in x and y, as it acts on a (N s).
    #[inline(always)]
    pub(crate) fn in_xy(&self, impulse: [f64; 2]) -> [f64; 2] {
        let ([nx, ny], [r_n, r_t]) = (self.normal, impulse);
        [r_n * nx - r_t * ny, r_n * ny + r_t * nx]
    }

    /// Adds an impulse (r_n, r_t) of this contact of two free disks (N s) to their velocities; the bodies count from `first`.
    #[inline(always)]
    pub(crate) fn push(&self, bodies: &mut [BodyRecord], first: usize, impulse: [f64; 2]) {
        let (lever, [x, y]) = (self.lever(), self.in_xy(impulse));
        bodies[self.a as usize - first].push(lever, [x, y], impulse);
        bodies[self.b as usize - first].push(lever, [-x, -y], impulse);
    }

    /// Diagonal of W with springs, D (1/kg).
    #[inline(always)]
    pub(crate) fn diagonal(&self) -> [f64; 2] {
        [
            self.block.nn + self.compliance[0],
            self.block.tt + self.compliance[1],
        ]
    }

    /// u = H^T v of two disks that move with the velocities v_a and v_b (m/s), see [`relative_velocity`].
    #[inline(always)]
    pub(crate) fn relative_velocity(&self, a: [f64; 3], b: [f64; 3]) -> [f64; 2] {
        relative_velocity(self.normal, self.lever(), a, b)
    }

    /// b = u + bias - W r at this relative velocity u: U without the contact's own impulse (m/s).
    #[inline(always)]
    pub(crate) fn without_impulse(&self, [u_n, u_t]: [f64; 2]) -> [f64; 2] {
        let (block, [r_n, r_t]) = (self.block, self.impulse);
        [
            u_n + self.bias[0] - block.nn * r_n - block.nt * r_t,
            u_t + self.bias[1] - block.nt * r_n - block.tt * r_t,
        ]
    }
}

/// u = H^T v of two disks that move with the velocities v_a and v_b (m/s):
/// u_n = n.(v_a - v_b), u_t = t.(v_a - v_b) - l (w_a + w_b), with w the spin times the radius and l the lever over the
/// radius (Jean 1999; v = H* q' in equations 1 to 5 of Renouf, Saulot and Berthier 2006).
#[inline(always)]
pub(crate) fn relative_velocity<T: Real>(
    [nx, ny]: [T; 2],
    lever: T,
    a: [T; 3],
    b: [T; 3],
) -> [T; 2] {
    let (dx, dy) = (a[0] - b[0], a[1] - b[1]);
    [nx * dx + ny * dy, nx * dy - ny * dx - lever * (a[2] + b[2])]
}
