//! The interface: the glued rows and surfaces that a coupler moves, and the order in which their disks and points are exchanged.

use std::collections::BTreeMap;
use std::f64::consts::PI;

use dem_kernel::bodies::Bodies;
use dem_kernel::bodies::geometry::Period;
use protocol::{Cause, NodeError, Surface};

use crate::config::sample::CutLine;

/// The sets on the bodies below and above, by name: their glued disks and points of the surface, by ascending x and by their numbers in the
/// boundary.
fn rows(bodies: &Bodies) -> impl Iterator<Item = (&'static str, Vec<usize>)> {
    let disks = [bodies.glued(), bodies.base];
    let rows = [("base", false), ("lid", true)];
    let rows = rows.map(|(name, above)| {
        let numbers = 0..bodies.boundary_points();
        let on_side = |number: &usize| bodies.surface.is_point_above(*number, disks) == above;
        let mut numbers: Vec<usize> = numbers.filter(on_side).collect();
        let x = |number: &usize| bodies.boundary_point(*number)[0];
        numbers.sort_by(|i, j| x(i).total_cmp(&x(j)));
        (name, numbers)
    });
    rows.into_iter().filter(|(_, disks)| !disks.is_empty())
}

fn by_set<T>(bodies: &Bodies, of: impl Fn(&str, Vec<usize>) -> T) -> BTreeMap<String, T> {
    let rows = rows(bodies);
    rows.map(|(name, disks)| (name.to_string(), of(name, disks)))
        .collect()
}

/// The sets that can be coupled: rows that have disks.
pub fn sets(bodies: &Bodies) -> Vec<String> {
    rows(bodies).map(|(name, _)| name.to_string()).collect()
}

/// Masses of the glued disks of each set (kg), pi r^2 times `mass_per_area` (kg/m2); a point has the mass of a mean grain. No equation here uses
/// them.
pub fn masses(bodies: &Bodies, mass_per_area: f64) -> BTreeMap<String, Vec<f64>> {
    let of_grain = |r: f64| if r > 0.0 { r } else { bodies.mean_radius() };
    let mass = |disk: usize| mass_per_area * PI * of_grain(radius(bodies, disk)).powi(2);
    by_set(bodies, |_, disks| disks.into_iter().map(mass).collect())
}

/// Radius of a glued disk, 0 of a point (m).
fn radius(bodies: &Bodies, number: usize) -> f64 {
    if number < bodies.glued() {
        bodies.radii[bodies.free + number]
    } else {
        0.0
    }
}

/// Outward normals of the sets: the base lies on a body below, the lid hangs on one above.
pub fn outward(bodies: &Bodies) -> BTreeMap<String, [f64; 2]> {
    by_set(bodies, |name, _| [0.0, side(name)])
}

fn side(name: &str) -> f64 {
    if name == "base" { -1.0 } else { 1.0 }
}

/// Lengths along x (m) after which the sets repeat: the strip's, where the sample is one.
pub fn periods(bodies: &Bodies) -> BTreeMap<String, f64> {
    let of_all = |period: Period| by_set(bodies, |_, _| period.length);
    bodies.period.map_or_else(BTreeMap::new, of_all)
}

/// Points on the lines under and over the disks of the base and the lid (m): a sample is cut along them, through disks at random.
pub fn smooth(bodies: &Bodies, [base, lid]: [CutLine; 2]) -> BTreeMap<String, Vec<[f64; 2]>> {
    by_set(bodies, |name, disks| {
        let line = if name == "base" { base } else { lid };
        let points = disks.into_iter().map(|disk| bodies.boundary_point(disk));
        let smooth = |[x, _]: [f64; 2]| [x, line.height_at(x, side(name))];
        points.map(smooth).collect()
    })
}

/// Glued disks and points in the order in which a coupler knows them; a row that no interface couples stays where it is.
#[derive(Clone, Debug, Default)]
pub struct InterfaceDisks {
    /// Their numbers in the boundary.
    pub disks: Vec<usize>,
}

impl InterfaceDisks {
    /// Couples a row and returns its points.
    pub fn couple(
        &mut self,
        bodies: &Bodies,
        participant: &str,
        set: &str,
    ) -> Result<Surface, NodeError> {
        let Some((_, disks)) = rows(bodies).find(|(name, _)| *name == set) else {
            let known = sets(bodies);
            let help = if known.is_empty() {
                "; its sample has neither glued disks nor a surface".into()
            } else {
                format!("; it has `{}`", known.join("`, `"))
            };
            return Err(NodeError::of(
                Cause::UnknownSet,
                format!("{participant} has no set `{set}` to couple{help}"),
            ));
        };
        if self.disks.contains(&disks[0]) {
            return Err(NodeError::of(
                Cause::SetCoupledTwice,
                format!("the set `{set}` is already coupled: one interface carries it"),
            ));
        }
        let surface = surface(bodies, &disks);
        if let Some(point) = surface.length_m.iter().position(|length| *length <= 0.0) {
            return Err(NodeError::of(
                Cause::ConflictingKeys,
                format!(
                    "{participant} has two points of the set `{set}` at x = {:e} m, and each carries the length to its neighbours along x: move one of them",
                    surface.x_m[point]
                ),
            ));
        }
        self.disks.extend(disks);
        Ok(surface)
    }

    /// Names of the coupled sets.
    pub fn names(&self, bodies: &Bodies) -> impl Iterator<Item = &'static str> {
        let coupled = rows(bodies).filter(|(_, disks)| self.disks.contains(&disks[0]));
        coupled.map(|(name, _)| name)
    }

    /// Maps exchanged components to the components of all `glued` disks; the others are zero.
    pub fn scatter(&self, exchanged: &[f64], glued: usize) -> Vec<f64> {
        let mut all = vec![0.0; 2 * glued];
        for (disk, pair) in self.disks.iter().zip(exchanged.chunks_exact(2)) {
            all[2 * disk..2 * disk + 2].copy_from_slice(pair);
        }
        all
    }

    /// Maps components of all glued disks to the exchanged ones.
    pub fn gather(&self, all: &[f64]) -> Vec<f64> {
        let pair = |disk: &usize| [all[2 * disk], all[2 * disk + 1]];
        self.disks.iter().flat_map(pair).collect()
    }

    /// A matrix over exchanged components, 2 n x 2 n, column-major, as one over all `glued` disks. A row that is not
    /// coupled does not yield.
    pub fn scatter_square(&self, exchanged: &[f64], glued: usize) -> Vec<f64> {
        let size = 2 * self.disks.len();
        let mut all = vec![0.0; 4 * glued * glued];
        for column in 0..size {
            let index = 2 * self.disks[column / 2] + column % 2;
            let values = self.scatter(&exchanged[column * size..(column + 1) * size], glued);
            all[index * 2 * glued..(index + 1) * 2 * glued].copy_from_slice(&values);
        }
        all
    }
}

/// Glued disks and points of a surface as points: to each belong half the distances to its neighbours.
fn surface(bodies: &Bodies, row: &[usize]) -> Surface {
    let points = row.iter().map(|number| bodies.boundary_point(*number));
    let (x, y): (Vec<f64>, Vec<f64>) = points.map(<(f64, f64)>::from).unzip();
    let radius_m: Vec<f64> = row.iter().map(|number| radius(bodies, *number)).collect();
    Surface {
        length_m: match bodies.period {
            None => lengths(&x, &y, radius_m[0]),
            Some(period) => repeating_lengths(&x, period),
        },
        y_m: y,
        mass_kg: vec![0.0; x.len()],
        radius_m,
        x_m: x,
    }
}

/// Width over height up to which neighbours stand one above the other.
const UPRIGHT: f64 = 1e-9;

/// Half the distances to the neighbours of points by ascending x (m), at the ends symmetrically; a disk by itself has its width. Distances are along
/// x, and along y in an upright row, all of whose points have one x.
fn lengths(x: &[f64], y: &[f64], radius: f64) -> Vec<f64> {
    let n = x.len();
    let along = |of: &[f64], i: usize, j: usize| (of[j] - of[i]).abs();
    let upright = (1..n).all(|i| along(x, i - 1, i) <= UPRIGHT * along(y, i - 1, i));
    let of = if upright { y } else { x };
    let between = |i: usize, j: usize| along(of, i, j);
    let length = (0..n).map(|i| match i {
        _ if n == 1 => 2.0 * radius,
        0 => between(0, 1),
        i if i == n - 1 => between(n - 2, n - 1),
        i => 0.5 * between(i - 1, i + 1),
    });
    length.collect()
}

/// The same in a strip that repeats (m), whose length they add up to; the last neighbour of one end is the first of the other.
fn repeating_lengths(x: &[f64], period: Period) -> Vec<f64> {
    let mut order: Vec<usize> = (0..x.len()).collect();
    let inside = |i: usize| period.inside(x[i]);
    order.sort_by(|i, j| inside(*i).total_cmp(&inside(*j)));
    let mut lengths = vec![0.0; x.len()];
    for (k, i) in order.iter().enumerate() {
        let next = order[(k + 1) % order.len()];
        let is_last = k + 1 == order.len();
        let turn = if is_last { period.length } else { 0.0 };
        let half = 0.5 * (inside(next) + turn - inside(*i));
        lengths[*i] += half;
        lengths[next] += half;
    }
    lengths
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_of_a_strip_that_repeats_covers_it_once() {
        let strip = Period::between([-1.0, 7.0]);
        let places = [0.0, 2.0, 5.0, 6.0];
        let along = [2.0, 2.5, 2.0, 1.0];
        assert_eq!(lengths(&places, &[0.0; 4], 1.0), along);
        assert_eq!(lengths(&[0.0; 4], &places, 1.0), along, "upright");
        // 13 is the image of 5, beyond the end.
        let row = [0.0, 2.0, 6.0, 13.0];
        assert_eq!(repeating_lengths(&row, strip), [2.0, 2.5, 1.5, 2.0]);
        assert_eq!(repeating_lengths(&[3.0], strip), [8.0]);
    }

    #[test]
    fn scattered_components_are_gathered_in_the_coupled_order() {
        let exchange = InterfaceDisks { disks: vec![2, 0] };
        let all = exchange.scatter(&[1.0, 2.0, 3.0, 4.0], 3);
        assert_eq!(all, [3.0, 4.0, 0.0, 0.0, 1.0, 2.0]);
        assert_eq!(exchange.gather(&all), [1.0, 2.0, 3.0, 4.0]);
        let square: Vec<f64> = (0..16).map(f64::from).collect();
        let matrix = exchange.scatter_square(&square, 3);
        // Exchanged column 3, row 0 is component y of disk 0, row x of disk 2.
        assert_eq!(matrix[6 + 4], square[12]);
        assert!(matrix[2 * 6..4 * 6].iter().all(|w| *w == 0.0));
    }
}
