//! The compliant boundary: massless glued disks, and points of surfaces, on a body that another solver moves, v_g = a_g + W_g p.

use std::ops::Range;

use crate::bodies::surface::Foot;
use crate::law::lanes::widest;

/// Number of components that are moved together: a vector register holds as many.
const TOGETHER: usize = 4;

/// The boundary of n glued disks during a step: their velocities are v_g = a_g + W_g p, with a_g without contact forces,
/// p the contact impulses on them and W_g the compliance of the body over a window (the dual Schur relation of Gravouil and Combescure 2001,
/// announced by the coupler). Velocities and impulses are (2 n): x0, y0, x1, y1, ...
///
/// After the n disks and points come the *feet* of the grains that touch a segment of a surface in this step. A foot moves with its two points, and
/// passes its impulse to them, by its shares: with S the matrix of shares v = S v_g and p = S^T f, so that no power is lost. The grains see S W_g
/// S^T, and only of the points that they touch.
#[derive(Clone, Debug, Default)]
pub struct CompliantBoundary {
    /// W_g (1/kg), 2 n x 2 n, column-major; empty for a fixed boundary.
    compliance: Vec<f64>,
    /// Its columns, disk by disk.
    columns: Vec<Columns>,
    /// a_g (m/s).
    free_velocity: Vec<f64>,
    /// v_g (m/s).
    pub velocity: Vec<f64>,
    /// Contact impulses on the glued disks, p (N s).
    pub impulse: Vec<f64>,
    /// The feet in the order of their numbers.
    pub feet: Vec<Foot>,
}

impl CompliantBoundary {
    /// A fixed boundary of this many glued disks.
    pub fn fixed(glued: usize) -> CompliantBoundary {
        CompliantBoundary {
            free_velocity: vec![0.0; 2 * glued],
            velocity: vec![0.0; 2 * glued],
            impulse: vec![0.0; 2 * glued],
            ..CompliantBoundary::default()
        }
    }

    /// A boundary with this compliance (1/kg), 2 n x 2 n, column-major.
    pub fn compliant(glued: usize, compliance: Vec<f64>) -> CompliantBoundary {
        // Rigid motion costs nothing when the whole matrix is zero.
        let rigid = compliance.iter().all(|w| *w == 0.0);
        if rigid {
            return CompliantBoundary::fixed(glued);
        }
        let columns = (0..glued).map(|disk| Columns::new(&compliance, 2 * glued, disk));
        CompliantBoundary {
            columns: columns.collect(),
            compliance,
            ..CompliantBoundary::fixed(glued)
        }
    }

    /// True if it yields to forces.
    pub fn is_compliant(&self) -> bool {
        !self.compliance.is_empty()
    }

    /// Starts a step: the boundary moves with a_g (2 n), no impulse acts on it.
    pub fn start(&mut self, free_velocity: &[f64]) {
        self.free_velocity.clear();
        self.free_velocity.extend_from_slice(free_velocity);
        self.velocity.clear();
        self.velocity.extend_from_slice(free_velocity);
        self.impulse.fill(0.0);
    }

    /// The foot with this number among disks, points and feet.
    #[inline(always)]
    pub fn foot(&self, disk: usize) -> Option<&Foot> {
        self.feet.get(disk.wrapping_sub(self.disks()))
    }

    /// Adds an impulse (N s) on a glued disk; all glued disks follow with two columns of W_g.
    #[inline(always)]
    pub fn apply(&mut self, disk: usize, impulse: [f64; 2]) {
        match self.foot(disk).map(|foot| foot.parts(impulse)) {
            None => self.push(disk, impulse),
            Some(parts) => self.push_foot(parts),
        }
    }

    /// A function of its own, or the sweeps over disks become a quarter slower.
    #[cold]
    #[inline(never)]
    fn push_foot(&mut self, parts: [(usize, [f64; 2]); 2]) {
        widest!(parts.into_iter().for_each(|(i, part)| self.push(i, part)));
    }

    /// The same for a disk or a point.
    #[inline(always)]
    fn push(&mut self, disk: usize, impulse: [f64; 2]) {
        self.add_impulse(disk, impulse);
        if let Some(columns) = self.columns.get(disk) {
            columns.add(&self.compliance, disk, &mut self.velocity, impulse);
        }
    }

    /// Adds an impulse (N s) to which the boundary yields at the next [`CompliantBoundary::evaluate`].
    #[inline(always)]
    pub fn gather(&mut self, disk: usize, impulse: [f64; 2]) {
        match self.foot(disk).map(|foot| foot.parts(impulse)) {
            None => self.add_impulse(disk, impulse),
            Some(parts) => parts
                .into_iter()
                .for_each(|(i, part)| self.add_impulse(i, part)),
        }
    }

    #[inline(always)]
    fn add_impulse(&mut self, disk: usize, impulse: [f64; 2]) {
        self.impulse[2 * disk] += impulse[0];
        self.impulse[2 * disk + 1] += impulse[1];
    }

    /// W_g p of any impulses (2 n), without changing the boundary.
    pub fn times_compliance(&self, impulse: &[f64], velocity: &mut [f64]) {
        velocity.fill(0.0);
        self.add_product(impulse, velocity);
    }

    fn add_product(&self, impulse: &[f64], velocity: &mut [f64]) {
        let disks = self.columns.iter().enumerate();
        widest!({
            for ((disk, columns), p) in disks.zip(impulse.chunks_exact(2)) {
                columns.add(&self.compliance, disk, velocity, [p[0], p[1]]);
            }
        });
    }

    /// Number of its glued disks and points.
    pub fn disks(&self) -> usize {
        self.velocity.len() / 2
    }

    /// Velocity of a glued disk (m/s).
    #[inline(always)]
    pub fn velocity_of(&self, disk: usize) -> [f64; 2] {
        if let Some(foot) = self.foot(disk) {
            return foot.mean(&self.velocity);
        }
        [self.velocity[2 * disk], self.velocity[2 * disk + 1]]
    }

    /// The block of W_g at a glued disk, 2 x 2, row by row (1/kg). A measured block is not quite symmetric.
    #[inline(always)]
    pub fn block(&self, disk: usize) -> [[f64; 2]; 2] {
        match self.foot(disk) {
            None => self.columns.get(disk).map_or([[0.0; 2]; 2], |c| c.block),
            Some(foot) => self.block_of(foot),
        }
    }

    #[cold]
    #[inline(never)]
    fn block_of(&self, foot: &Foot) -> [[f64; 2]; 2] {
        let mut block = [[0.0; 2]; 2];
        if self.is_compliant() {
            // A column of S W_g S^T is the velocity of the foot under a unit impulse on it.
            for column in 0..2 {
                let mut unit = [0.0; 2];
                unit[column] = 1.0;
                for (point, part) in foot.parts(unit) {
                    let (x, y) = columns_of(&self.compliance, self.velocity.len(), point);
                    let [vx, vy] = [foot.mean(x), foot.mean(y)];
                    block[0][column] += vx[0] * part[0] + vy[0] * part[1];
                    block[1][column] += vx[1] * part[0] + vy[1] * part[1];
                }
            }
        }
        block
    }

    /// Evaluates v_g = a_g + W_g p again, without the rounding errors of many small changes (Gravouil and Combescure 2001).
    pub fn evaluate(&mut self) {
        if !self.is_compliant() {
            return;
        }
        let mut velocity = std::mem::take(&mut self.velocity);
        velocity.copy_from_slice(&self.free_velocity);
        self.add_product(&self.impulse, &mut velocity);
        self.velocity = velocity;
    }
}

/// The two consecutive columns of W_g of a glued disk.
#[derive(Clone, Debug)]
struct Columns {
    /// Outside of these rows both are zero: in the window of an explicit solver waves do not travel far. For a rail under 16 mm of layer three in
    /// five entries of W_g are zero.
    reach: Range<usize>,
    /// The rows of the disk itself.
    block: [[f64; 2]; 2],
}

impl Columns {
    fn new(compliance: &[f64], components: usize, disk: usize) -> Columns {
        let (x, y) = columns_of(compliance, components, disk);
        let mut moved = (0..components).filter(|row| x[*row] != 0.0 || y[*row] != 0.0);
        let first = moved.next().unwrap_or(0);
        let rows = moved.next_back().map_or(1, |last| last + 1 - first);
        Columns {
            // Whole registers, within the rows.
            reach: first..(first + rows.next_multiple_of(TOGETHER)).min(components),
            block: [2 * disk, 2 * disk + 1].map(|row| [x[row], y[row]]),
        }
    }

    /// Adds their product with an impulse to the velocities.
    #[inline(always)]
    fn add(&self, compliance: &[f64], disk: usize, velocity: &mut [f64], [p_x, p_y]: [f64; 2]) {
        if p_x == 0.0 && p_y == 0.0 {
            return;
        }
        let (x, y) = columns_of(compliance, velocity.len(), disk);
        let add = |(v, (x, y)): (&mut f64, (&f64, &f64))| *v += x * p_x + y * p_y;
        let (v, v_rest) = velocity[self.reach.clone()].as_chunks_mut::<TOGETHER>();
        let (x, x_rest) = x[self.reach.clone()].as_chunks::<TOGETHER>();
        let (y, y_rest) = y[self.reach.clone()].as_chunks::<TOGETHER>();
        for (v, (x, y)) in v.iter_mut().zip(x.iter().zip(y)) {
            v.iter_mut().zip(x.iter().zip(y)).for_each(add);
        }
        v_rest
            .iter_mut()
            .zip(x_rest.iter().zip(y_rest))
            .for_each(add);
    }
}

#[inline(always)]
fn columns_of(compliance: &[f64], components: usize, disk: usize) -> (&[f64], &[f64]) {
    compliance[2 * disk * components..(2 * disk + 2) * components].split_at(components)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn impulses_move_every_glued_disk_by_their_columns() {
        let compliance: Vec<f64> = (0..16).map(f64::from).collect();
        let mut boundary = CompliantBoundary::compliant(2, compliance);
        boundary.start(&[1.0, 0.0, 0.0, 0.0]);
        boundary.apply(1, [1.0, -1.0]);
        // columns 2 = (8..12) and 3 = (12..16): their difference is -4 everywhere
        assert_eq!(boundary.velocity, [-3.0, -4.0, -4.0, -4.0]);
        boundary.evaluate();
        assert_eq!(boundary.velocity, [-3.0, -4.0, -4.0, -4.0]);
        assert_eq!(boundary.block(1), [[10.0, 14.0], [11.0, 15.0]]);
    }

    /// Five disks whose columns reach from one to all rows, off the diagonal as well: the dense product is the reference.
    #[test]
    fn columns_reach_over_their_rows_that_are_not_zero() {
        let rows = [
            0..0,
            1..2,
            3..8,
            0..10,
            7..10,
            9..10,
            4..5,
            4..5,
            0..1,
            2..9,
        ];
        let entry = |i: usize| {
            if rows[i / 10].contains(&(i % 10)) {
                (i as f64).sin()
            } else {
                0.0
            }
        };
        let compliance: Vec<f64> = (0..100).map(entry).collect();
        let mut boundary = CompliantBoundary::compliant(5, compliance.clone());
        boundary.start(&[0.25; 10]);
        let mut expected = [0.25; 10];
        for disk in [4, 0, 2, 1, 3] {
            let [x, y] = [0.5 - disk as f64, 0.3];
            boundary.apply(disk, [x, y]);
            for (row, v) in expected.iter_mut().enumerate() {
                *v += compliance[20 * disk + row] * x + compliance[20 * disk + 10 + row] * y;
            }
            assert_eq!(boundary.velocity, expected);
        }
        let mut product = [f64::NAN; 10];
        boundary.times_compliance(&boundary.impulse, &mut product);
        boundary.evaluate();
        for ((v, w), expected) in boundary.velocity.iter().zip(product).zip(expected) {
            assert!((v - expected).abs() < 1e-15 && (w + 0.25 - expected).abs() < 1e-15);
        }
    }
}
