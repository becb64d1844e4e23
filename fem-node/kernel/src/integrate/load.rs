//! Applied nodal forces.

use crate::element::body::Body;

/// Applied nodal forces (N), nearly all of them zero.
#[derive(Clone, Debug, Default)]
pub struct Load {
    pub values: Vec<f64>,
    touched: Vec<usize>,
    loaded_rows: Vec<bool>,
    row_len: usize,
    zero_row: Vec<f64>,
}

impl Load {
    pub(crate) fn none(body: &Body) -> Load {
        let layout = body.layout;
        Load {
            values: vec![0.0; layout.len()],
            loaded_rows: vec![false; layout.node_rows],
            row_len: layout.row_len(),
            zero_row: vec![0.0; layout.row_len()],
            ..Load::default()
        }
    }

    pub fn clear(&mut self) {
        for index in self.touched.drain(..) {
            self.values[index] = 0.0;
            self.loaded_rows[index / self.row_len] = false;
        }
    }

    pub fn add(&mut self, index: usize, force: f64) {
        self.values[index] += force;
        self.touched.push(index);
        self.loaded_rows[index / self.row_len] = true;
    }

    /// A row of nodes; the many rows without load share one row of zeros, which stays in the cache.
    pub fn row(&self, row: usize) -> &[f64] {
        if self.loaded_rows[row] {
            &self.values[row * self.row_len..(row + 1) * self.row_len]
        } else {
            &self.zero_row
        }
    }
}
