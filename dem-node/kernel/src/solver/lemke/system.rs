//! Linear equations that gain or lose one unknown at a time, with their solution.

use crate::law::lanes::widest;

/// Number that is linear in the parameter of a path: its value at 0 and its slope.
pub(super) type Linear = [f64; 2];

/// A y = c with A^-1, kept up to date by bordering (Frobenius and Schur's inverse of a matrix with one more row and column).
#[derive(Clone, Debug, Default)]
pub(super) struct System {
    /// Columns of A^-1.
    columns: Vec<Vec<f64>>,
    /// y.
    pub solution: Vec<Linear>,
}

impl System {
    /// Number of unknowns.
    pub(super) fn len(&self) -> usize {
        self.solution.len()
    }

    /// Adds an unknown with its entries in the present equations, and an equation with its entries at the present unknowns, both as (index, entry);
    /// `corner` is the entry where both meet, `right` the right side. False if A becomes singular.
    pub(super) fn border(
        &mut self,
        column: &[(usize, f64)],
        row: &[(usize, f64)],
        corner: f64,
        right: Linear,
    ) -> bool {
        let mut p = vec![0.0; self.len()];
        for (equation, entry) in column {
            add(&mut p, *entry, &self.columns[*equation]);
        }
        let sum = |of: &dyn Fn(usize) -> f64| -> f64 {
            row.iter()
                .map(|(unknown, entry)| entry * of(*unknown))
                .sum()
        };
        let complement = corner - sum(&|i| p[i]);
        if complement == 0.0 || !complement.is_finite() {
            return false;
        }
        let last = [0, 1].map(|k| (right[k] - sum(&|i| self.solution[i][k])) / complement);
        for (y, p) in self.solution.iter_mut().zip(&p) {
            *y = [y[0] - p * last[0], y[1] - p * last[1]];
        }
        self.solution.push(last);
        for inverse in &mut self.columns {
            let dot: f64 = row.iter().map(|(i, entry)| entry * inverse[*i]).sum();
            let q = dot / complement;
            add(inverse, q, &p);
            inverse.push(-q);
        }
        p.iter_mut().for_each(|p| *p /= -complement);
        p.push(1.0 / complement);
        self.columns.push(p);
        true
    }

    /// Removes an unknown and an equation of the same index; the last ones get this index. False if A becomes singular.
    pub(super) fn remove(&mut self, index: usize) -> bool {
        let removed = self.columns.swap_remove(index);
        let pivot = removed[index];
        if pivot == 0.0 || !pivot.is_finite() {
            return false;
        }
        let mut p = removed;
        p.swap_remove(index);
        let last = self.solution.swap_remove(index);
        for (y, p) in self.solution.iter_mut().zip(&p) {
            *y = [y[0] - p * last[0] / pivot, y[1] - p * last[1] / pivot];
        }
        for inverse in &mut self.columns {
            let entry = inverse.swap_remove(index);
            add(inverse, -entry / pivot, &p);
        }
        true
    }

    /// Exchanges an unknown w for `factor` times the unknown v less w.
    pub(super) fn mirror(&mut self, w: usize, v: usize, factor: f64) {
        for inverse in &mut self.columns {
            inverse[w] = factor * inverse[v] - inverse[w];
        }
        let (of_v, of_w) = (self.solution[v], self.solution[w]);
        self.solution[w] = [0, 1].map(|k| factor * of_v[k] - of_w[k]);
    }

    /// Subtracts A^-1 e from the solution, e being the error of the equations.
    pub(super) fn correct(&mut self, error: &[Linear]) {
        for k in 0..2 {
            let mut change = vec![0.0; self.len()];
            for (inverse, error) in self.columns.iter().zip(error) {
                add(&mut change, error[k], inverse);
            }
            for (y, change) in self.solution.iter_mut().zip(&change) {
                y[k] -= change;
            }
        }
    }
}

fn add(sum: &mut [f64], factor: f64, vector: &[f64]) {
    if factor != 0.0 {
        widest!({
            for (sum, entry) in sum.iter_mut().zip(vector) {
                *sum += factor * entry;
            }
        });
    }
}
