//! Stress of the grains: a map of square cells, and the whole sample.
//!
//! sigma_ij = -(1/V) sum w f_i l_j over the grains and over the contacts of each, f being the force on the grain and l from its
//! centre to the contact: the internal moments of the grains (Moreau 1997), which is Love's stress (Love 1927; Weber 1966). w is the
//! part of the grain's tile that lies in V ([`crate::measure::tiles`]), so that an edge may cut grains: the stress of a lattice is exact in any V, up
//! to rounding. With V = 3.5 diameters squared on a hexagonal lattice, weights by centres (w = 0 or 1) miss the modulus by up to 27 %, by the part of
//! each lever in V by 16 %, by the part of each disk's area by 0.6 % (6 % on a square lattice).
//!
//! V is the area times the thickness, compression is positive. Contacts with bonds, walls, wheel and glued disks count like any other; glued disks
//! and driven clusters are not grains.

use std::fmt::Write as _;

use dem_kernel::bodies::Bodies;
use dem_kernel::bodies::geometry::range;
use dem_kernel::step::state::GrainState;
use kit::ConfigError;
use protocol::larger;
use serde::{Deserialize, Serialize};

use crate::config::stress::StressConfig;
use crate::measure::loads::{add_moment, ends, for_each_load, grains, shown};
use crate::measure::tiles::{Tile, tiles};

kit::results! {
    /// # Load and approach
    /// - `dem_p_max_tr3_pa`: Largest pressure of a cell of the grains' stress: a third of the in-plane trace, the convention of Renouf, Saulot and
    ///   Berthier (2006).
    /// - `dem_p_max_mean_pa`: Largest pressure of a cell of the grains' stress as half of the
    ///   in-plane trace, the mean stress of two dimensions.
    /// # Grains
    /// - `stress_xx_pa`: Mean stress of the region along x, compression positive; grains across its
    ///   edge count in part.
    /// - `stress_yy_pa`: Mean stress of the region along y, compression positive.
    /// - `stress_xy_pa`: Mean shear stress of the grains.
}

/// Least solid fraction of a cell that counts in the largest pressure, over the solid fraction around a mean grain: only a part of a cell across a
/// free surface has stress.
const FILLED: f64 = 0.5;

/// Sums over the grains of a cell, or of the sample.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct StressSums {
    /// -sum f_i l_j (N m): xx, xy, yx, yy.
    pub moment: [f64; 4],
    /// Area of the grains (m2).
    pub solid: f64,
    /// Number of grains, each by its part in V.
    pub grains: f64,
}

impl StressSums {
    fn add(&mut self, part: f64, other: &StressSums) {
        add_moment(&mut self.moment, part, other.moment);
        self.solid += part * other.solid;
        self.grains += part * other.grains;
    }

    /// sigma_xx, sigma_yy and the symmetric part of sigma_xy (Pa), of a volume (m3).
    fn stress(&self, volume: f64) -> [f64; 3] {
        let [xx, xy, yx, yy] = self.moment.map(|moment| moment / volume);
        [xx, yy, 0.5 * (xy + yx)]
    }
}

/// Stress of a state.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct StressMap {
    /// Sides of the region along x and y (m).
    pub sides: [[f64; 2]; 2],
    /// Grains in the region.
    pub whole: StressSums,
    /// Lower left corner of the first cell (m): the cells lie in the middle of the region.
    pub corner: [f64; 2],
    /// Cells of a row.
    pub columns: usize,
    /// All cells, row by row from below.
    pub cells: Vec<StressSums>,
    /// Side of a cell, and thickness (m).
    side: f64,
    thickness: f64,
}

impl StressMap {
    /// The stress under the forces of the last step; `None` where no grain bears any.
    pub fn measure(
        config: &StressConfig,
        bodies: &Bodies,
        state: &GrainState,
        thickness: f64,
    ) -> Option<StressMap> {
        let grains = sums_by_grain(bodies, state);
        let loaded = |disk: &usize| grains[bodies.clusters.leader_of(*disk)].moment != [0.0; 4];
        let sides = region(config, bodies, state, loaded)?;
        let [columns, rows] = config.grid(sides);
        let corner = [(0, columns), (1, rows)]
            .map(|(axis, count)| 0.5 * (sides[axis][0] + sides[axis][1] - count * config.cell_m));
        let mut map = StressMap {
            sides,
            corner,
            columns: columns.max(1.0) as usize,
            cells: vec![StressSums::default(); columns as usize * rows as usize],
            side: config.cell_m,
            thickness,
            ..StressMap::default()
        };
        let tiles = tiles(bodies, state, loaded);
        let mut areas = vec![0.0; bodies.free];
        for (disk, tile) in &tiles {
            areas[bodies.clusters.leader_of(*disk)] += tile.area();
        }
        let images = match bodies.period {
            None => vec![0.0],
            Some(period) => vec![-period.length, 0.0, period.length],
        };
        for (disk, tile) in &tiles {
            let [x, y] = shown(bodies, state.centres[*disk]);
            let leader = bodies.clusters.leader_of(*disk);
            for image in &images {
                map.add([x + image, y], tile, &grains[leader], areas[leader]);
            }
        }
        Some(map)
    }

    /// Adds a grain by the parts of its `area` (m2), the sum of its tiles, that this tile around `centre` (m) has in the region and in each cell.
    fn add(&mut self, centre: [f64; 2], tile: &Tile, grain: &StressSums, area: f64) {
        let part = |sides: [[f64; 2]; 2]| tile.between(centre, sides).area() / area;
        self.whole.add(part(self.sides), grain);
        let counts = [self.columns, self.cells.len() / self.columns];
        let [columns, rows] = [0, 1].map(|k| {
            let cell = |x: f64| ((centre[k] + x - self.corner[k]) / self.side).floor();
            let [low, high] = range(tile.0.iter().map(|corner| corner[k])).map(cell);
            (low.max(0.0) as usize)..((high + 1.0).max(0.0) as usize).min(counts[k])
        });
        let edges = |k: usize, i: usize| [i, i + 1].map(|i| self.corner[k] + i as f64 * self.side);
        for row in rows {
            for column in columns.clone() {
                let part = part([edges(0, column), edges(1, row)]);
                self.cells[row * self.columns + column].add(part, grain);
            }
        }
    }

    /// Volume of a cell (m3).
    fn cell_volume(&self) -> f64 {
        self.side * self.side * self.thickness
    }

    /// Largest in-plane trace sigma_xx + sigma_yy of the cells that count (Pa): cells with at least half the solid fraction around a mean grain, sum
    /// s^2 / sum s over the cells, which slivers of grains do not lower.
    fn largest_trace(&self) -> Option<f64> {
        let held = || self.cells.iter().filter(|cell| cell.solid > 0.0);
        let sum = |power: i32| held().map(|cell| cell.solid.powi(power)).sum::<f64>();
        let least = FILLED * sum(2) / sum(1);
        let traces = held().filter(|cell| cell.solid >= least).map(|cell| {
            let [xx, yy, _] = cell.stress(self.cell_volume());
            xx + yy
        });
        traces.reduce(larger)
    }

    /// `stress_xx_pa`, `stress_yy_pa`, `stress_xy_pa` of the region, and the largest pressure of a cell: `dem_p_max_tr3_pa` is a third of the
    /// in-plane trace, the convention of Renouf, Saulot and Berthier (2006), `dem_p_max_mean_pa` half the trace.
    pub fn results(&self) -> Vec<(&'static str, f64)> {
        let [width, height] = self.sides.map(|[low, high]| high - low);
        let [xx, yy, xy] = self.whole.stress(width * height * self.thickness);
        let mut results = vec![
            ("stress_xx_pa", xx),
            ("stress_yy_pa", yy),
            ("stress_xy_pa", xy),
        ];
        if let Some(trace) = self.largest_trace() {
            results.push(("dem_p_max_tr3_pa", trace / 3.0));
            results.push(("dem_p_max_mean_pa", trace / 2.0));
        }
        results
    }

    /// The cells as CSV, a line each: middle, stress, the two pressures, solid fraction and number of grains, each by its part.
    pub fn csv(&self) -> String {
        let mut text =
            "x_m,y_m,sxx_pa,syy_pa,sxy_pa,p_tr3_pa,p_mean_pa,solid_fraction,grains\n".to_string();
        for (index, cell) in self.cells.iter().enumerate() {
            let cell_index = [index % self.columns, index / self.columns];
            let [x, y] = [0, 1].map(|k| self.corner[k] + (cell_index[k] as f64 + 0.5) * self.side);
            let [xx, yy, xy] = cell.stress(self.cell_volume());
            let solid = cell.solid / (self.side * self.side);
            let trace = xx + yy;
            let _ = writeln!(
                text,
                "{x:e},{y:e},{xx:e},{yy:e},{xy:e},{:e},{:e},{solid:e},{:e}",
                trace / 3.0,
                trace / 2.0,
                cell.grains
            );
        }
        text
    }
}

/// Refuses a region that is too narrow for a cell, or too wide, with the grains of the start.
pub fn refuse_misfit(
    config: &StressConfig,
    bodies: &Bodies,
    state: &GrainState,
) -> Result<(), ConfigError> {
    match region(config, bodies, state, |_| true) {
        None => Ok(()),
        Some(sides) => config.refuse_misfit("stress.cell_m", sides),
    }
}

/// Sums of each grain, a cluster's at its first disk.
fn sums_by_grain(bodies: &Bodies, state: &GrainState) -> Vec<StressSums> {
    let mut sums = vec![StressSums::default(); bodies.free];
    for disk in grains(bodies, state) {
        let leader = bodies.clusters.leader_of(disk);
        sums[leader].solid += std::f64::consts::PI * bodies.radii[disk].powi(2);
        sums[leader].grains = 1.0;
    }
    for_each_load(bodies, state, |load| {
        let grain = &mut sums[bodies.clusters.leader_of(load.disk)];
        add_moment(&mut grain.moment, -1.0, load.moment());
    });
    sums
}

/// Sides of the region (m): from the keys, or the ends of a strip that repeats, or the edges of the chosen grains.
fn region(
    config: &StressConfig,
    bodies: &Bodies,
    state: &GrainState,
    chosen: impl Fn(&usize) -> bool,
) -> Option<[[f64; 2]; 2]> {
    let ends = |axis: usize| ends(bodies, state, axis, grains(bodies, state).filter(&chosen));
    let given = [config.x_m, config.y_m];
    let sides = [0, 1].map(|axis| given[axis].unwrap_or_else(|| ends(axis)));
    let finite = sides.iter().flatten().all(|side| side.is_finite());
    finite.then_some(sides)
}

#[cfg(test)]
mod tests;
