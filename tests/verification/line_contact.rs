//! A rigid cylinder that rolls steadily on an elastic half-plane through a layer of springs, by boundary elements.
//!
//! Lengths are over a, tractions over p0 of Hertz, displacements over a p0/E*; positive x is the direction of rolling, U_z points into the body. Cells
//! of the width h carry a constant pressure p and shear q, which drags the body towards +x where positive:
//!
//! ```text
//! U_x(x) = -(2/pi) int q ln|x - s| ds - 2 beta int p        beta = (1 - 2 nu)/(2 (1 - nu))
//! U_z(x) = -(2/pi) int p ln|x - s| ds + 2 beta int q
//! closed:  U_z + lambda_n p = D - x^2                        lambda_n = E*/(a k_n), springs k_n and k per area (N/m3)
//! slip over a cell:  Z h + U_x(i+1) - U_x(i) + lambda (q(i+1) - q(i))      Z = zeta 2R/a, lambda = E*/(a k)
//! ```
//!
//! Source: K. L. Johnson, Contact Mechanics, 1985, equations 2.25 (half-plane) and 8.2 (creep of a steady contact).

use std::f64::consts::PI;

use nalgebra::{DMatrix, DVector};

/// Half of the width in which the contact lies, over a.
const REACH: f64 = 2.5;

/// Changes of friction in all cells at once, and then of one cell, the frontmost that is wrong; most changes in all.
const CHANGES: usize = 12;
const CHANGES_MAX: usize = 400;

/// A wheel with a given creep force.
#[derive(Clone, Copy, Debug)]
pub struct LineContact {
    /// Poisson's ratio of the half-plane, in plane strain.
    pub poisson: f64,
    /// Coefficient of friction.
    pub friction: f64,
    /// E*/(a k) and E*/(a k_n) of the layer.
    pub compliance: [f64; 2],
    /// T/(mu N).
    pub traction: f64,
    /// Cells for each half-width a.
    pub cells: usize,
}

/// The steady state of the wheel.
#[derive(Clone, Copy, Debug)]
pub struct Rolled {
    /// zeta R/(mu a).
    pub creepage: f64,
    /// Largest pressure over p0.
    pub peak: f64,
    /// Share of the contact that sticks.
    pub stick: f64,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Cell {
    Open,
    Stick,
    /// Slides, with the sign of its shear.
    Slip(f64),
}

impl LineContact {
    /// Solves for the steady state: pressure, shear, approach and creepage, with the sets of closed and sticking cells.
    ///
    /// # Panics
    /// The sets go on changing.
    pub fn roll(&self) -> Rolled {
        let count = 2 * (REACH * self.cells as f64) as usize;
        let grid = Grid::new(self, count);
        let start = |i: usize| {
            if grid.x(i).abs() < 1.0 {
                Cell::Stick
            } else {
                Cell::Open
            }
        };
        let mut cells: Vec<Cell> = (0..count).map(start).collect();
        let mut single = 0;
        for _ in 0..CHANGES_MAX {
            let contact = self.solve(&grid, &cells);
            let next = self.next(&grid, &cells, &contact);
            let opens = |i: &usize| next[*i] == Cell::Open || cells[*i] == Cell::Open;
            let changed = Vec::from_iter((0..count).filter(|i| next[*i] != cells[*i]));
            let friction = Vec::from_iter(changed.iter().copied().filter(|i| !opens(i)));
            if changed.is_empty() {
                let stuck = cells.iter().filter(|cell| **cell == Cell::Stick).count();
                return Rolled {
                    creepage: contact.creepage / (2.0 * self.friction),
                    peak: contact.pressure.iter().copied().fold(0.0, f64::max),
                    stick: stuck as f64 / contact.closed.len() as f64,
                };
            }
            single = if friction.is_empty() { 0 } else { single + 1 };
            match friction.last() {
                None => cells = next,
                Some(last) if single > CHANGES => cells[*last] = next[*last],
                Some(_) => friction.iter().for_each(|i| cells[*i] = next[*i]),
            }
        }
        panic!("the contact does not settle: {self:?}");
    }

    /// Solves for these sets.
    fn solve(&self, grid: &Grid, cells: &[Cell]) -> Contact {
        let closed = Vec::from_iter((0..cells.len()).filter(|i| cells[*i] != Cell::Open));
        let (n, h) = (closed.len(), grid.width);
        let [lambda, lambda_n] = self.compliance;
        let mut matrix = DMatrix::zeros(2 * n + 2, 2 * n + 2);
        let mut right = DVector::zeros(2 * n + 2);
        for (row, &i) in closed.iter().enumerate() {
            for (column, &j) in closed.iter().enumerate() {
                let [by_p, by_q] = grid.displacement(i, j);
                matrix[(row, column)] = by_p[1];
                matrix[(row, n + column)] = by_q[1];
                if cells[i] == Cell::Stick {
                    let [next_p, next_q] = grid.displacement(i + 1, j);
                    matrix[(n + row, column)] = next_p[0] - by_p[0];
                    matrix[(n + row, n + column)] = next_q[0] - by_q[0];
                }
            }
            matrix[(row, row)] += lambda_n;
            matrix[(row, 2 * n)] = -1.0;
            right[row] = -grid.x(i) * grid.x(i);
            if let Cell::Slip(sign) = cells[i] {
                matrix[(n + row, n + row)] = 1.0;
                matrix[(n + row, row)] = -sign * self.friction;
            } else {
                matrix[(n + row, n + row)] -= lambda;
                if closed.get(row + 1) == Some(&(i + 1)) {
                    matrix[(n + row, n + row + 1)] += lambda;
                }
                matrix[(n + row, 2 * n + 1)] = h;
            }
            matrix[(2 * n, row)] = h;
            matrix[(2 * n + 1, n + row)] = h;
        }
        right[2 * n] = 0.5 * PI;
        right[2 * n + 1] = 0.5 * PI * self.friction * self.traction;
        let solution = matrix
            .lu()
            .solve(&right)
            .expect("springs and a half-plane hold");
        let mut contact = Contact {
            pressure: vec![0.0; cells.len() + 1],
            shear: vec![0.0; cells.len() + 1],
            approach: solution[2 * n],
            creepage: solution[2 * n + 1],
            closed,
        };
        for (k, &i) in contact.closed.iter().enumerate() {
            (contact.pressure[i], contact.shear[i]) = (solution[k], solution[n + k]);
        }
        contact
    }

    /// The state of each cell under these tractions.
    fn next(&self, grid: &Grid, cells: &[Cell], contact: &Contact) -> Vec<Cell> {
        let at = |i: usize| {
            let mut sum = [0.0; 2];
            for &j in &contact.closed {
                let [by_p, by_q] = grid.displacement(i, j);
                let add = |c: usize| by_p[c] * contact.pressure[j] + by_q[c] * contact.shear[j];
                sum = [sum[0] + add(0), sum[1] + add(1)];
            }
            sum
        };
        let now = |(i, cell): (usize, &Cell)| {
            let (pressure, shear) = (contact.pressure[i], contact.shear[i]);
            match *cell {
                Cell::Open if at(i)[1] < contact.approach - grid.x(i) * grid.x(i) => Cell::Stick,
                Cell::Open => Cell::Open,
                Cell::Stick if shear.abs() > self.friction * pressure => Cell::Slip(shear.signum()),
                Cell::Stick => Cell::Stick,
                Cell::Slip(sign) => {
                    let stretch = at(i + 1)[0] - at(i)[0];
                    let spring = self.compliance[0] * (contact.shear[i + 1] - shear);
                    let slip = contact.creepage * grid.width + stretch + spring;
                    if slip * sign < 0.0 {
                        Cell::Stick
                    } else {
                        *cell
                    }
                }
            }
        };
        let mut next = Vec::from_iter(cells.iter().enumerate().map(now));
        // A cell parts once friction has settled.
        if closed_alike(&next, cells) {
            for i in contact
                .closed
                .iter()
                .filter(|i| contact.pressure[**i] <= 0.0)
            {
                next[*i] = Cell::Open;
            }
        }
        next
    }
}

/// True where friction acts in the same way in all closed cells.
fn closed_alike(next: &[Cell], cells: &[Cell]) -> bool {
    let mut pairs = next.iter().zip(cells);
    pairs.all(|(next, now)| next == now || *now == Cell::Open)
}

/// Tractions of the cells, approach and creepage.
struct Contact {
    closed: Vec<usize>,
    pressure: Vec<f64>,
    shear: Vec<f64>,
    approach: f64,
    creepage: f64,
}

/// Cells of one width, and the displacements of a cell by another.
struct Grid {
    width: f64,
    count: usize,
    /// Displacements (x, z) by unit pressure and by unit shear, over the distance.
    table: Vec<[[f64; 2]; 2]>,
}

impl Grid {
    fn new(problem: &LineContact, count: usize) -> Grid {
        let h = 1.0 / problem.cells as f64;
        let beta = (1.0 - 2.0 * problem.poisson) / (2.0 * (1.0 - problem.poisson));
        let primitive = |d: f64| d * d.abs().max(f64::MIN_POSITIVE).ln();
        let of = |k: usize| {
            let x = (k as f64 - count as f64) * h;
            let log = -2.0 / PI * (primitive(x + 0.5 * h) - primitive(x - 0.5 * h) - h);
            let ramp = 2.0 * beta * x.clamp(-0.5 * h, 0.5 * h);
            [[-ramp, log], [log, ramp]]
        };
        Grid {
            width: h,
            count,
            table: (0..=2 * count).map(of).collect(),
        }
    }

    /// Position of the middle of a cell.
    fn x(&self, i: usize) -> f64 {
        (i as f64 + 0.5 - 0.5 * self.count as f64) * self.width
    }

    fn displacement(&self, i: usize, j: usize) -> [[f64; 2]; 2] {
        self.table[self.count + i - j]
    }
}
