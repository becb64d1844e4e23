//! Meshes of quadrilaterals: graded structured ones from a few numbers, and any others by their elements.

mod cells;

use std::sync::Arc;

use protocol::ConfigError;

use crate::config::MeshConfig;

/// More elements than this are taken for a mistyped size: they would need some 4 GB. An explicit run of 1 000 x 1 000 one-point
/// elastic elements peaks at 432 MB, program included; 28 080 elements at 30 MB.
const ELEMENTS_MAX: f64 = 1e7;

pub(crate) use cells::{Cells, NodeSet};

/// Quadrilaterals, most often a structured block. Node (column, row) counts from the upper left corner: row 0 is the
/// upper edge, row [`Mesh::rows`] the lower one.
///
/// A mesh that is no block has all its nodes in row 0, those of its set `top` first, and its elements in rows whose
/// length has no meaning; the last one may be shorter.
#[derive(Clone, Debug, PartialEq)]
pub struct Mesh {
    columns: usize,
    rows: usize,
    points: Vec<[f64; 2]>,
    /// Whether the nodes of the last column are those of the first.
    periodic: bool,
    cells: Option<Arc<Cells>>,
    /// Growth of the size from one graded column to the next, outwards; 1 without grading.
    pub ratio_columns: f64,
    /// Growth of the size from one graded row to the next, downwards; 1 without grading.
    pub ratio_rows: f64,
}

/// An edge of the block, the node sets that the scenario can name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Edge {
    /// Row 0.
    Top,
    /// The last row.
    Bottom,
    /// Column 0.
    Left,
    /// The last column.
    Right,
}

impl Edge {
    /// All edges with their names.
    pub const ALL: [(&'static str, Edge); 4] = [
        ("top", Edge::Top),
        ("bottom", Edge::Bottom),
        ("left", Edge::Left),
        ("right", Edge::Right),
    ];

    /// The edge of this name.
    pub fn named(name: &str) -> Option<Edge> {
        Edge::ALL
            .iter()
            .find(|(known, _)| *known == name)
            .map(|(_, edge)| *edge)
    }

    /// Its name.
    pub fn name(self) -> &'static str {
        let mut all = Edge::ALL.iter().filter(|(_, edge)| *edge == self);
        all.next().expect("all of them are listed").0
    }
}

impl Mesh {
    /// The block of the scenario: with d the depth below the crown, H the height and c(x) = R - sqrt(R^2 - x^2)
    /// the drop of the crown, y = -c(x) (1 - d/H) - d. The top of the crown is the origin, the base is flat.
    pub fn graded(config: &MeshConfig) -> Result<Mesh, ConfigError> {
        check_count(config)?;
        let (x, ratio_columns) = columns(config)?;
        let (depth, ratio_rows) = rows(config)?;
        let radius = config.crown_radius_m.unwrap_or(0.0);
        check_crown(config, radius)?;
        let mesh = Mesh::structured(x.len() - 1, depth.len() - 1, |i, j| {
            let (x, d) = (x[i], depth[j]);
            [x, -drop(radius, x) * (1.0 - d / config.height_m) - d]
        });
        Ok(Mesh {
            periodic: config.periodic_x,
            ratio_columns,
            ratio_rows,
            ..mesh
        })
    }

    /// A block of `columns` x `rows` quadrilaterals with the node (column, row) at `place`.
    pub fn structured(
        columns: usize,
        rows: usize,
        place: impl Fn(usize, usize) -> [f64; 2],
    ) -> Mesh {
        let nodes = (0..=rows).flat_map(|j| (0..=columns).map(move |i| (i, j)));
        Mesh {
            columns,
            rows,
            points: nodes.map(|(i, j)| place(i, j)).collect(),
            periodic: false,
            cells: None,
            ratio_columns: 1.0,
            ratio_rows: 1.0,
        }
    }

    /// Any quadrilaterals.
    pub(crate) fn of_cells(points: Vec<[f64; 2]>, cells: Cells) -> Mesh {
        let elements = cells.corners().len();
        Mesh {
            columns: elements.min(cells::ROW),
            rows: elements.div_ceil(cells::ROW),
            points,
            periodic: false,
            cells: Some(Arc::new(cells)),
            ratio_columns: 1.0,
            ratio_rows: 1.0,
        }
    }

    /// Elements and sets of a mesh that is no block.
    pub(crate) fn cells(&self) -> Option<&Arc<Cells>> {
        self.cells.as_ref()
    }

    /// Elements in a row; the last row of a mesh that is no block may be shorter.
    pub fn columns(&self) -> usize {
        self.columns
    }

    /// Rows of elements.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Number of elements.
    pub fn elements(&self) -> usize {
        match &self.cells {
            None => self.columns * self.rows,
            Some(cells) => cells.corners().len(),
        }
    }

    /// All elements (column, row), row after row.
    pub fn places(&self) -> impl Iterator<Item = [usize; 2]> + use<> {
        let columns = self.columns;
        (0..self.elements()).map(move |k| [k % columns, k / columns])
    }

    /// All nodes (column, row), row after row.
    pub fn nodes(&self) -> impl Iterator<Item = [usize; 2]> + use<> {
        let in_row = self.nodes_in_row();
        (0..self.points.len()).map(move |k| [k % in_row, k / in_row])
    }

    /// Nodes in a row.
    pub fn nodes_in_row(&self) -> usize {
        match self.cells {
            None => self.columns + 1,
            Some(_) => self.points.len(),
        }
    }

    /// The position of a node in [`Mesh::points`].
    pub fn number(&self, [column, row]: [usize; 2]) -> usize {
        row * self.nodes_in_row() + column
    }

    /// Positions of all nodes, row after row (m).
    pub fn points(&self) -> &[[f64; 2]] {
        &self.points
    }

    /// Position of node (column, row) (m).
    pub fn point(&self, column: usize, row: usize) -> [f64; 2] {
        self.points[self.number([column, row])]
    }

    /// The larger of width and height (m).
    pub fn size(&self) -> f64 {
        let [width, height] = self.extents();
        width.max(height)
    }

    /// Width and height (m).
    pub fn extents(&self) -> [f64; 2] {
        [0, 1].map(|k| {
            let ends = |[low, high]: [f64; 2], p: &[f64; 2]| [low.min(p[k]), high.max(p[k])];
            let [low, high] = self
                .points
                .iter()
                .fold([f64::INFINITY, f64::NEG_INFINITY], ends);
            high - low
        })
    }

    /// The nodes (column, row) of an edge, from left to right or from the top down; of a mesh that is no block those of
    /// the set with its name, none where there is no such set.
    pub fn edge(&self, edge: Edge) -> Vec<[usize; 2]> {
        if self.cells.is_some() {
            return self.set(edge.name()).unwrap_or_default();
        }
        match edge {
            Edge::Top => (0..=self.columns).map(|i| [i, 0]).collect(),
            Edge::Bottom => (0..=self.columns).map(|i| [i, self.rows]).collect(),
            Edge::Left => (0..=self.rows).map(|j| [0, j]).collect(),
            Edge::Right => (0..=self.rows).map(|j| [self.columns, j]).collect(),
        }
    }

    /// Whether the left and the right edge are one: each node of the last column moves with that of the first.
    pub fn periodic(&self) -> bool {
        self.periodic
    }

    /// The node that this one moves with, itself except on the right edge of a periodic block.
    pub fn tied_to(&self, [column, row]: [usize; 2]) -> [usize; 2] {
        match self.periodic && column == self.columns {
            true => [0, row],
            false => [column, row],
        }
    }

    /// The nodes of an edge that move by themselves, in the order of [`Mesh::edge`], and the length that belongs to each
    /// (m). In a periodic block the first node of the upper and lower edge has a segment on both sides.
    pub fn surface(&self, edge: Edge) -> (Vec<[usize; 2]>, Vec<f64>) {
        let mut nodes = self.edge(edge);
        let mut lengths = self.tributary(&nodes);
        if self.periodic && matches!(edge, Edge::Top | Edge::Bottom) {
            nodes.pop();
            lengths[0] += lengths.pop().expect("an edge has nodes");
        }
        (nodes, lengths)
    }

    /// Length of the edge that belongs to each of its nodes (m): half of the two segments beside it.
    pub fn tributary(&self, nodes: &[[usize; 2]]) -> Vec<f64> {
        let mut lengths = vec![0.0; nodes.len()];
        for (k, pair) in nodes.windows(2).enumerate() {
            let ([xa, ya], [xb, yb]) = (
                self.point(pair[0][0], pair[0][1]),
                self.point(pair[1][0], pair[1][1]),
            );
            let half = 0.5 * (xb - xa).hypot(yb - ya);
            lengths[k] += half;
            lengths[k + 1] += half;
        }
        lengths
    }

    /// Names of its node sets.
    pub fn sets(&self) -> Vec<&str> {
        let ends = |edge: &Edge| matches!(edge, Edge::Left | Edge::Right);
        match &self.cells {
            None => Edge::ALL
                .iter()
                .filter(|(_, edge)| !(self.periodic && ends(edge)))
                .map(|(name, _)| *name)
                .collect(),
            Some(cells) => cells.sets().keys().map(String::as_str).collect(),
        }
    }

    /// The nodes of a set, each once, in the order of a walk along it.
    pub fn set(&self, name: &str) -> Option<Vec<[usize; 2]>> {
        match &self.cells {
            None => Edge::named(name).map(|edge| self.edge(edge)),
            Some(cells) => cells.sets().get(name).map(|set| in_row(&set.nodes())),
        }
    }

    /// The lines that a set consists of, each in the order of a walk; a closed one ends where it begins. None for a
    /// region and an unknown name.
    pub fn lines(&self, name: &str) -> Option<Vec<Vec<[usize; 2]>>> {
        let Some(cells) = &self.cells else {
            let known = self.sets().contains(&name);
            let edge = Edge::named(name).filter(|_| known);
            return edge.map(|edge| vec![self.edge(edge)]);
        };
        match cells.sets().get(name)? {
            NodeSet::Lines(lines) => Some(lines.iter().map(|line| in_row(line)).collect()),
            NodeSet::Region(_) => None,
        }
    }

    /// The nodes of a set that is one open line on the outline of the body, in the order of a walk.
    pub fn open_line(&self, name: &str) -> Option<Vec<[usize; 2]>> {
        let mut lines = self.lines(name)?;
        let line = lines.pop().filter(|_| lines.is_empty())?;
        let open = line.first() != line.last();
        let outside = |pair: &[[usize; 2]]| self.outline(pair[0], pair[1]).is_some();
        (open && line.windows(2).all(outside)).then_some(line)
    }

    /// The two ends of a segment of the outline, ordered so that the body lies on the left; none for a segment inside.
    pub fn outline(&self, a: [usize; 2], b: [usize; 2]) -> Option<[[usize; 2]; 2]> {
        if let Some(cells) = &self.cells {
            return cells.outline(a[0], b[0]).map(|ends| ends.map(|k| [k, 0]));
        }
        let upper_or_left = match a[1] == b[1] {
            true => (a[1] == 0) == (a[0] < b[0]),
            false => (a[0] == 0) != (a[1] < b[1]),
        };
        Some(match upper_or_left {
            true => [b, a],
            false => [a, b],
        })
    }

    /// Corners of the element in column i, row j, anticlockwise from the lower left one, as (column, row).
    pub fn corners(&self, i: usize, j: usize) -> [[usize; 2]; 4] {
        match &self.cells {
            None => [[i, j + 1], [i + 1, j + 1], [i + 1, j], [i, j]],
            Some(cells) => cells.corners()[j * self.columns + i].map(|k| [k as usize, 0]),
        }
    }
}

/// Nodes of a mesh that is no block, by their numbers.
fn in_row(numbers: &[u32]) -> Vec<[usize; 2]> {
    numbers.iter().map(|k| [*k as usize, 0]).collect()
}

/// Drop of a circle of this radius below its crown; radius 0 means flat.
fn drop(radius: f64, x: f64) -> f64 {
    if radius == 0.0 {
        return 0.0;
    }
    // R - sqrt(R^2 - x^2) without the cancellation at small x.
    x * x / (radius + (radius * radius - x * x).sqrt())
}

fn check_count(config: &MeshConfig) -> Result<(), ConfigError> {
    let columns = config.fine_width_m.unwrap_or(config.width_m) / config.size_m
        + 2.0 * config.side_columns as f64;
    let rows =
        config.fine_depth_m.unwrap_or(config.height_m) / config.size_m + config.depth_rows as f64;
    if columns * rows <= ELEMENTS_MAX {
        return Ok(());
    }
    let problem = format!(
        "{:?} m gives about {:.1e} elements, more than {ELEMENTS_MAX:.0e}",
        config.size_m,
        columns * rows
    );
    Err(ConfigError::new("mesh.size_m", problem).help("check the unit (m) or enlarge the size"))
}

fn check_crown(config: &MeshConfig, radius: f64) -> Result<(), ConfigError> {
    let half = 0.5 * config.width_m;
    if radius == 0.0 || (radius >= half && drop(radius, half) < config.height_m) {
        return Ok(());
    }
    let problem = format!("a crown of {radius:?} m leaves no height at the edges of the body");
    Err(ConfigError::new("mesh.crown_radius_m", problem)
        .help("enlarge the radius, or leave the key out for a flat top"))
}

/// Abscissae of the columns of nodes, symmetric about 0, and the growth of the graded ones.
fn columns(config: &MeshConfig) -> Result<(Vec<f64>, f64), ConfigError> {
    let zone = Zone {
        total: ("mesh.width_m", config.width_m),
        fine: ("mesh.fine_width_m", config.fine_width_m),
        graded: ("mesh.side_columns", config.side_columns),
        sides: 2.0,
        size: config.size_m,
    };
    let (count, fine) = zone.uniform()?;
    let (side, ratio) = zone.grading(fine)?;
    let mut x: Vec<f64> = side.iter().rev().map(|s| -(0.5 * fine + s)).collect();
    x.extend((0..=count).map(|k| fine * (k as f64 / count as f64 - 0.5)));
    x.extend(side.iter().map(|s| 0.5 * fine + s));
    Ok((x, ratio))
}

/// Depths of the rows of nodes, from 0 on, and the growth of the graded ones.
fn rows(config: &MeshConfig) -> Result<(Vec<f64>, f64), ConfigError> {
    let zone = Zone {
        total: ("mesh.height_m", config.height_m),
        fine: ("mesh.fine_depth_m", config.fine_depth_m),
        graded: ("mesh.depth_rows", config.depth_rows),
        sides: 1.0,
        size: config.size_m,
    };
    let (count, fine) = zone.uniform()?;
    let (below, ratio) = zone.grading(fine)?;
    let mut depth: Vec<f64> = (0..=count)
        .map(|k| fine * (k as f64 / count as f64))
        .collect();
    depth.extend(below.iter().map(|s| fine + s));
    Ok((depth, ratio))
}

/// One direction of the mesh, with the names of its keys.
struct Zone {
    total: (&'static str, f64),
    fine: (&'static str, Option<f64>),
    graded: (&'static str, usize),
    sides: f64,
    size: f64,
}

impl Zone {
    /// Number of uniform elements and the length that they fill.
    fn uniform(&self) -> Result<(usize, f64), ConfigError> {
        let (total_key, total) = self.total;
        let (fine_key, fine) = self.fine;
        let (graded_key, graded) = self.graded;
        let (key, length) = match fine {
            Some(length) => (fine_key, length),
            None if graded == 0 => (total_key, total),
            None => {
                let problem = format!("is required with {graded_key} = {graded}");
                return Err(ConfigError::new(fine_key, problem).help(format!(
                    "give the length of the zone of uniform size, or set {graded_key} to 0"
                )));
            }
        };
        let count = (length / self.size).round();
        if count < 1.0 || (count * self.size - length).abs() > 1e-6 * length {
            let problem = format!(
                "{length:?} m is not a whole number of elements of mesh.size_m = {:?} m",
                self.size
            );
            return Err(ConfigError::new(key, problem)
                .help(format!("write {:.6e}", count.max(1.0) * self.size)));
        }
        Ok((count as usize, length))
    }

    /// Distances of the graded nodes from the fine zone, and the ratio r: the sizes are size r^k,
    /// k = 0 .. n-1, and fill the length L that the fine zone leaves: (r^n - 1)/(r - 1) = L/size.
    fn grading(&self, fine: f64) -> Result<(Vec<f64>, f64), ConfigError> {
        let (graded_key, graded) = self.graded;
        let length = (self.total.1 - fine) / self.sides;
        let relative = length / self.size;
        if graded == 0 {
            return self.nothing_left(relative);
        }
        if relative < graded as f64 - 1e-6 || (graded == 1 && relative > 1.0 + 1e-6) {
            return Err(self.no_room(length, relative));
        }
        let ratio = solve_ratio(graded, relative);
        if !ratio.is_finite() || ratio > 10.0 {
            let problem =
                format!("{graded} would have to grow {ratio:.1}-fold from one to the next");
            return Err(ConfigError::new(graded_key, problem).help("take more of them"));
        }
        let scale = length / geometric_sum(graded, ratio);
        let distances = (1..=graded).map(|k| scale * geometric_sum(k, ratio));
        Ok((distances.collect(), ratio))
    }

    fn nothing_left(&self, relative: f64) -> Result<(Vec<f64>, f64), ConfigError> {
        if relative.abs() <= 1e-6 * self.total.1 / self.size {
            return Ok((Vec::new(), 1.0));
        }
        let problem = format!(
            "without {} the fine zone must fill {}",
            self.graded.0, self.total.0
        );
        Err(ConfigError::new(self.fine.0, problem)
            .help(format!("leave it out, or set {} above 0", self.graded.0)))
    }

    fn no_room(&self, length: f64, relative: f64) -> ConfigError {
        let (key, graded) = self.graded;
        let problem = format!(
            "{graded} graded from {:?} m on do not fit the {length:.6e} m that {} leaves of {}: their sizes would have to shrink outwards or jump",
            self.size, self.fine.0, self.total.0
        );
        let most = relative.floor().max(0.0);
        ConfigError::new(key, problem).help(match most {
            m if m < 2.0 => format!("shorten {}", self.fine.0),
            _ => format!("take 2 to {most}, or shorten {}", self.fine.0),
        })
    }
}

/// 1 + r + ... + r^(n-1), also for r = 1.
fn geometric_sum(n: usize, ratio: f64) -> f64 {
    (0..n).fold(0.0, |sum, _| sum * ratio + 1.0)
}

/// The ratio r >= 1 whose geometric sum of n terms is `sum` >= n. r^(n-1) <= sum brackets it.
fn solve_ratio(n: usize, sum: f64) -> f64 {
    if n == 1 {
        return 1.0;
    }
    let (mut low, mut high) = (1.0, sum.max(1.0).powf(1.0 / (n as f64 - 1.0)));
    for _ in 0..100 {
        let middle = 0.5 * (low + high);
        match geometric_sum(n, middle) < sum {
            true => low = middle,
            false => high = middle,
        }
    }
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn strip() -> MeshConfig {
        MeshConfig {
            width_m: 4.0,
            height_m: 2.0,
            size_m: 1.0,
            fine_width_m: None,
            fine_depth_m: None,
            side_columns: 0,
            depth_rows: 0,
            crown_radius_m: None,
            periodic_x: false,
        }
    }

    #[test]
    fn a_uniform_strip_needs_three_numbers() {
        let mesh = Mesh::graded(&strip()).expect("4 x 2 elements");
        assert_eq!((mesh.columns(), mesh.rows()), (4, 2));
        assert_eq!(mesh.point(0, 0), [-2.0, 0.0]);
        assert_eq!(mesh.point(4, 2), [2.0, -2.0]);
    }

    #[test]
    fn doubling_sizes_are_found() {
        let config = MeshConfig {
            width_m: 16.0,
            fine_width_m: Some(2.0),
            side_columns: 3,
            ..strip()
        };
        let mesh = Mesh::graded(&config).expect("1 + 2 + 4 on each side");
        assert!((mesh.ratio_columns - 2.0).abs() < 1e-12);
        let x: Vec<f64> = mesh
            .edge(Edge::Top)
            .iter()
            .map(|n| mesh.point(n[0], n[1])[0])
            .collect();
        let expected = [-8.0, -4.0, -2.0, -1.0, 0.0, 1.0, 2.0, 4.0, 8.0];
        assert!(
            x.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12),
            "{x:?}"
        );
    }

    #[test]
    fn grading_without_room_is_refused_by_name() {
        let config = MeshConfig {
            fine_width_m: Some(2.0),
            side_columns: 2,
            ..strip()
        };
        let error = Mesh::graded(&config).expect_err("1 m is left on each side for 2 columns");
        assert_eq!(error.key, "mesh.side_columns");
        assert!(error.help.is_some());
    }

    #[test]
    fn a_gap_that_nothing_fills_is_refused_by_name() {
        let config = MeshConfig {
            fine_depth_m: Some(1.0),
            ..strip()
        };
        let error = Mesh::graded(&config).expect_err("1 m is left below");
        assert_eq!(error.key, "mesh.fine_depth_m");
    }

    #[test]
    fn a_broken_number_of_elements_is_refused_by_name() {
        let config = MeshConfig {
            width_m: 4.3,
            ..strip()
        };
        let error = Mesh::graded(&config).expect_err("4.3 elements");
        assert_eq!(error.key, "mesh.width_m");
    }

    #[test]
    fn a_crown_narrower_than_the_body_is_refused() {
        let config = MeshConfig {
            crown_radius_m: Some(1.9),
            ..strip()
        };
        let error = Mesh::graded(&config).expect_err("half the width is 2");
        assert_eq!(error.key, "mesh.crown_radius_m");
    }

    #[test]
    fn tributary_lengths_add_up_to_the_edge() {
        let mesh = Mesh::graded(&strip()).expect("valid");
        let lengths = mesh.tributary(&mesh.edge(Edge::Right));
        assert_eq!(lengths, vec![0.5, 1.0, 0.5]);
    }
}
