//! Tiles: the part of the plane that belongs to each disk, which divides grains among cells.
//!
//! A tile ends at a line between its disk and each neighbour. The line is at right angles to the line of centres and divides it in the ratio of the
//! radii: it is the common tangent of two disks that touch. Tiles of equal disks are Voronoi's. The stress of a grain holds in its tile, the material
//! cell of Bagi (1996), *Stress and strain in granular assemblies*. Tiles also end at the faces of walls and wheel and at the edges of all grains
//! that bear forces, so that grains in a box have their tiles in the box. Sideways and upwards they end after sqrt(2) radii, where the square lattice
//! has its corners, so that a hole between grains belongs to no tile.

use dem_kernel::bodies::Bodies;
use dem_kernel::contact::detect::list_pairs;
use dem_kernel::step::state::GrainState;

use crate::measure::loads::{ends, grains};

/// Reach of a tile without neighbours along x and y, in radii.
const REACH: f64 = std::f64::consts::SQRT_2;
/// Least distance of a neighbour's line from a centre, in radii: a disk pressed through a wall keeps a tile.
const CORE: f64 = 0.1;

/// A convex polygon: its corners in order, seen from the centre of the disk (m).
#[derive(Clone, Debug)]
pub struct Tile(pub Vec<[f64; 2]>);

impl Tile {
    /// Area (m2): half the sum of the cross products of consecutive corners.
    pub fn area(&self) -> f64 {
        let crossed = self.sides().map(|([x, y], [u, v])| x * v - u * y);
        0.5 * crossed.sum::<f64>()
    }

    /// The part between these sides along x and y (m), the disk being at `centre` (m).
    pub fn between(&self, centre: [f64; 2], sides: [[f64; 2]; 2]) -> Tile {
        let [[left, right], [low, high]] = sides;
        let [x, y] = centre;
        let part = self.within([1.0, 0.0], right - x);
        let part = part.within([-1.0, 0.0], x - left);
        part.within([0.0, 1.0], high - y)
            .within([0.0, -1.0], y - low)
    }

    /// The part that lies no further than `distance` (m) along a unit vector (Sutherland and Hodgman 1974).
    fn within(&self, [nx, ny]: [f64; 2], distance: f64) -> Tile {
        let beyond = |[x, y]: [f64; 2]| nx * x + ny * y - distance;
        let mut corners = Vec::with_capacity(self.0.len() + 1);
        for (from, to) in self.sides() {
            let (start, end) = (beyond(from), beyond(to));
            if (start > 0.0) != (end > 0.0) {
                let part = start / (start - end);
                corners.push([0, 1].map(|k| from[k] + part * (to[k] - from[k])));
            }
            if end <= 0.0 {
                corners.push(to);
            }
        }
        Tile(corners)
    }

    fn sides(&self) -> impl Iterator<Item = ([f64; 2], [f64; 2])> {
        let before = self.0.iter().cycle().skip(self.0.len().saturating_sub(1));
        before.copied().zip(self.0.iter().copied())
    }
}

/// The disks of all grains with their tiles; `chosen` disks set the edges.
pub fn tiles(
    bodies: &Bodies,
    state: &GrainState,
    chosen: impl Fn(&usize) -> bool,
) -> Vec<(usize, Tile)> {
    let positions = state.positions(bodies);
    let edges = [0, 1].map(|axis| match (axis, bodies.period) {
        (0, Some(_)) => [f64::NEG_INFINITY, f64::INFINITY],
        _ => ends(bodies, state, axis, grains(bodies, state).filter(&chosen)),
    });
    let square = |disk: usize| {
        let (radius, centre) = (bodies.radii[disk], state.centres[disk]);
        let [[left, right], [low, high]] = [0, 1].map(|k| {
            let [low, high] = edges[k].map(|edge| edge - centre[k]);
            [
                low.clamp(-REACH * radius, -radius),
                high.clamp(radius, REACH * radius),
            ]
        });
        Tile(vec![[left, low], [right, low], [right, high], [left, high]])
    };
    let mut tiles: Vec<Tile> = (0..state.present(bodies)).map(square).collect();
    let widest = bodies.radii.iter().copied().fold(0.0, f64::max);
    for pair in list_pairs(&positions, widest) {
        let (a, b) = (pair.a as usize, pair.b as usize);
        let at = positions.proximity(a, b);
        // A wall is a disk without a radius: the line is its face.
        let radii = [a, b].map(|body| bodies.radii.get(body).copied().unwrap_or(0.0));
        let apart = 1.0 + at.gap / (radii[0] + radii[1]);
        for (disk, radius, sign) in [(a, radii[0], -1.0), (b, radii[1], 1.0)] {
            if let Some(tile) = tiles.get_mut(disk) {
                let normal = at.normal.map(|n| sign * n);
                *tile = tile.within(normal, radius * apart.max(CORE));
            }
        }
    }
    let disks = grains(bodies, state);
    disks.map(|disk| (disk, tiles[disk].clone())).collect()
}
