//! Linked cells: the disks near a disk, without a search of all disks.

use crate::bodies::geometry::{Period, between_points, range};

/// Linked cells over disks: answers which disks of higher index are nearer than `reach` to a disk.
/// Pairs of two disks from `movable` on are left out.
pub struct NearPairs<'a> {
    centres: &'a [[f64; 2]],
    radii: &'a [f64],
    movable: usize,
    reach: f64,
    period: Option<Period>,
    origin: [f64; 2],
    /// Width and height of a cell (m).
    cell_size: [f64; 2],
    columns: usize,
    rows: usize,
    /// First entry of each cell in `members`.
    starts: Vec<u32>,
    members: Vec<u32>,
    found: Vec<u32>,
}

impl<'a> NearPairs<'a> {
    /// Sorts the disks into cells.
    pub fn new(
        centres: &'a [[f64; 2]],
        radii: &'a [f64],
        movable: usize,
        reach: f64,
        period: Option<Period>,
    ) -> Self {
        let [x, y] = [0, 1].map(|axis| range(centres.iter().map(|c| c[axis])));
        let mut origin = [x[0], y[0]];
        let (mut width, height) = (x[1] - x[0], y[1] - y[0]);
        if let Some(period) = period {
            (origin[0], width) = (period.left, period.length);
        }
        let widest = radii.iter().copied().fold(0.0, f64::max);
        // A grain far away must not make the number of cells explode: four per disk suffice.
        let affordable = (width * height / (4.0 * centres.len() as f64)).sqrt();
        let along = width.max(height) / (4.0 * centres.len() as f64);
        let cell_size = (2.0 * widest + reach).max(affordable).max(along);
        let rows = 1 + (height / cell_size) as usize;
        // The columns of a strip fill it, no column is cut.
        let (columns, cell_width) = match period {
            None => (1 + (width / cell_size) as usize, cell_size),
            Some(_) => {
                let columns = ((width / cell_size) as usize).max(1);
                (columns, width / columns as f64)
            }
        };
        let mut cells = NearPairs {
            centres,
            radii,
            movable,
            reach,
            period,
            origin,
            cell_size: [cell_width, cell_size],
            columns,
            rows,
            starts: vec![0; columns * rows + 1],
            members: vec![0; centres.len()],
            found: Vec::new(),
        };
        cells.fill();
        cells
    }

    fn fill(&mut self) {
        let cells: Vec<usize> = self.centres.iter().map(|c| self.cell(*c)).collect();
        for cell in &cells {
            self.starts[cell + 1] += 1;
        }
        for cell in 1..self.starts.len() {
            self.starts[cell] += self.starts[cell - 1];
        }
        let mut next = self.starts.clone();
        for (disk, cell) in cells.into_iter().enumerate() {
            self.members[next[cell] as usize] = disk as u32;
            next[cell] += 1;
        }
    }

    fn column_and_row(&self, centre: [f64; 2]) -> (usize, usize) {
        let x = self.period.map_or(centre[0], |p| p.inside(centre[0]));
        let index = |axis: usize, x: f64| ((x - self.origin[axis]) / self.cell_size[axis]) as usize;
        (
            index(0, x).min(self.columns - 1),
            index(1, centre[1]).min(self.rows - 1),
        )
    }

    fn cell(&self, centre: [f64; 2]) -> usize {
        let (column, row) = self.column_and_row(centre);
        row * self.columns + column
    }

    /// The disks with an index above `a` nearer than `reach` to it, in ascending order.
    pub fn of(&mut self, a: usize) -> &[u32] {
        let (column, row) = self.column_and_row(self.centres[a]);
        self.found.clear();
        for r in row.saturating_sub(1)..=(row + 1).min(self.rows - 1) {
            for [left, right] in self.columns_near(column) {
                // The cells of a row are consecutive, and so are their members.
                let (first, last) = (r * self.columns + left, r * self.columns + right);
                for at in self.starts[first]..self.starts[last + 1] {
                    let b = self.members[at as usize] as usize;
                    if b > a && a < self.movable && self.is_near(a, b) {
                        self.found.push(b as u32);
                    }
                }
            }
        }
        self.found.sort_unstable();
        &self.found
    }

    /// Ranges of columns next to a column, itself included; there is a second range only at the seam of a strip.
    fn columns_near(&self, column: usize) -> impl Iterator<Item = [usize; 2]> + use<> {
        let last = self.columns - 1;
        let mut around = None;
        let mut near = [column.saturating_sub(1), (column + 1).min(last)];
        if self.period.is_some() && self.columns < 3 {
            near = [0, last];
        } else if self.period.is_some() && column == 0 {
            around = Some([last, last]);
        } else if self.period.is_some() && column == last {
            around = Some([0, 0]);
        }
        std::iter::once(near).chain(around)
    }

    fn is_near(&self, a: usize, b: usize) -> bool {
        let [dx, dy] = between_points(self.centres[a], self.centres[b], self.period);
        let reach = self.radii[a] + self.radii[b] + self.reach;
        dx * dx + dy * dy < reach * reach
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn linked_cells_find_the_pairs_of_the_double_loop() {
        let centres: Vec<[f64; 2]> = (0..60)
            .map(|i| [f64::from(i * 37 % 60), f64::from(i * i % 23)])
            .collect();
        let radii: Vec<f64> = (0..60).map(|i| 0.5 + f64::from(i % 4) * 0.4).collect();
        let mut near = NearPairs::new(&centres, &radii, 50, 0.3, None);
        for a in 0..60 {
            let expected: Vec<u32> = (a + 1..60)
                .filter(|b| a < 50 && near.is_near(a, *b))
                .map(|b| b as u32)
                .collect();
            assert_eq!(near.of(a), expected);
        }
    }

    #[test]
    fn linked_cells_of_a_strip_find_pairs_across_its_seam() {
        for length in [4.2, 8.0, 13.7, 60.0] {
            let period = Some(Period { left: -3.0, length });
            let centres: Vec<[f64; 2]> = (0..60)
                .map(|i| [f64::from(i * 37 % 60) * 1.7 - 40.0, f64::from(i * i % 23)])
                .collect();
            let radii: Vec<f64> = (0..60).map(|i| 0.3 + f64::from(i % 4) * 0.2).collect();
            let mut near = NearPairs::new(&centres, &radii, 60, 0.2, period);
            let mut wrapped = 0;
            for a in 0..60 {
                let expected: Vec<u32> = (a + 1..60)
                    .filter(|b| near.is_near(a, *b))
                    .map(|b| b as u32)
                    .collect();
                wrapped += expected.len();
                assert_eq!(near.of(a), expected, "length {length}");
            }
            assert!(wrapped > 0);
        }
    }

    #[test]
    fn a_stray_grain_does_not_blow_up_the_cells() {
        let mut centres = vec![[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]];
        centres.push([1e9, -1e9]);
        let near = NearPairs::new(&centres, &[0.5; 4], 4, 0.1, None);
        assert!(near.columns * near.rows <= 100);
    }
}
