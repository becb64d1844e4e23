//! Meshes of quadrilaterals: structured ones by their columns and rows, and any others by their elements.
//!
//! - [`connectivity`]: elements and sets of an unstructured mesh.

pub mod connectivity;

use std::sync::Arc;

use connectivity::{Connectivity, NodeSet};

/// Irrational strides of the Weyl sequences of [`Mesh::perturb`]: the reciprocals of the golden and of the plastic number.
const GOLDEN: f64 = 0.618_033_988_749_894_9;
const PLASTIC: f64 = 0.754_877_666_246_692_8;
/// Seeds beyond this wrap around: a fraction of larger numbers keeps too few bits.
const WRAP: u64 = 1 << 20;

/// Mesh of quadrilaterals, most often structured. Node (column, row) counts from the upper left corner: row 0 is the
/// upper edge, row [`Mesh::rows`] the lower one.
///
/// An unstructured mesh has all its nodes in row 0, its set `top` first, and its elements in rows whose length has no meaning; the last row may be
/// shorter.
#[derive(Clone, Debug, PartialEq)]
pub struct Mesh {
    /// Elements in a row; the last row of an unstructured mesh may be shorter.
    pub columns: usize,
    /// Rows of elements.
    pub rows: usize,
    /// Positions of all nodes, row after row (m).
    pub points: Vec<[f64; 2]>,
    /// True where the left and the right edge are one: each node of the last column moves with the node of the first.
    pub periodic: bool,
    /// Elements and sets of an unstructured mesh.
    pub connectivity: Option<Arc<Connectivity>>,
    /// Growth of the size from one graded column to the next, outwards; 1 without grading.
    pub ratio_columns: f64,
    /// Growth of the size from one graded row to the next, downwards; 1 without grading.
    pub ratio_rows: f64,
}

/// Edge of a structured mesh, the node sets that the scenario can name.
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
        let mut all = Edge::ALL.into_iter();
        all.find_map(|(known, edge)| (known == name).then_some(edge))
    }

    /// The edge that it is once the mesh is [turned over](Mesh::turned_over).
    pub fn turned_over(self) -> Edge {
        match self {
            Edge::Top => Edge::Bottom,
            Edge::Bottom => Edge::Top,
            Edge::Left | Edge::Right => self,
        }
    }

    /// Its name.
    pub fn name(self) -> &'static str {
        let mut all = Edge::ALL.iter().filter(|(_, edge)| *edge == self);
        all.next().expect("all of them are listed").0
    }
}

impl Mesh {
    /// A structured mesh of `columns` x `rows` quadrilaterals with the node (column, row) at `position`.
    pub fn structured(
        columns: usize,
        rows: usize,
        position: impl Fn(usize, usize) -> [f64; 2],
    ) -> Mesh {
        let nodes = (0..=rows).flat_map(|j| (0..=columns).map(move |i| (i, j)));
        Mesh {
            columns,
            rows,
            points: nodes.map(|(i, j)| position(i, j)).collect(),
            periodic: false,
            connectivity: None,
            ratio_columns: 1.0,
            ratio_rows: 1.0,
        }
    }

    /// A structured mesh turned over: its lower edge is the upper one.
    pub fn turned_over(&self) -> Mesh {
        let rows = self.points.chunks_exact(self.columns + 1).rev();
        Mesh {
            points: rows.flatten().map(|[x, y]| [*x, -y]).collect(),
            ..self.clone()
        }
    }

    /// An unstructured mesh of any quadrilaterals.
    pub fn unstructured(points: Vec<[f64; 2]>, connectivity: Connectivity) -> Mesh {
        let elements = connectivity.corners.len();
        Mesh {
            columns: elements.min(connectivity::ROW),
            rows: elements.div_ceil(connectivity::ROW),
            points,
            periodic: false,
            connectivity: Some(Arc::new(connectivity)),
            ratio_columns: 1.0,
            ratio_rows: 1.0,
        }
    }

    /// Number of elements.
    pub fn elements(&self) -> usize {
        match &self.connectivity {
            None => self.columns * self.rows,
            Some(connectivity) => connectivity.corners.len(),
        }
    }

    /// All elements (column, row), row after row.
    pub fn element_indices(&self) -> impl Iterator<Item = [usize; 2]> + use<> {
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
        match self.connectivity {
            None => self.columns + 1,
            Some(_) => self.points.len(),
        }
    }

    /// The position of a node in [`Mesh::points`].
    pub fn number(&self, [column, row]: [usize; 2]) -> usize {
        row * self.nodes_in_row() + column
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

    /// Distance along x after which it repeats (m), if it does.
    pub fn period(&self) -> Option<f64> {
        self.periodic.then(|| self.extents()[0])
    }

    /// Width and height (m).
    pub fn extents(&self) -> [f64; 2] {
        [0, 1].map(|k| {
            let ends = |[low, high]: [f64; 2], p: &[f64; 2]| [low.min(p[k]), high.max(p[k])];
            let points = self.points.iter();
            let [low, high] = points.fold([f64::INFINITY, f64::NEG_INFINITY], ends);
            high - low
        })
    }

    /// Displaces each node along y by up to 1e-12 of the mean element size sqrt(width height / elements): a Weyl sequence whose
    /// beginning the seed chooses.
    pub fn perturb(&mut self, seed: u64) {
        let [width, height] = self.extents();
        let most = 1e-12 * (width * height / self.elements() as f64).sqrt();
        let nodes: Vec<[usize; 2]> = self.nodes().collect();
        for node in nodes {
            let number = self.number(self.tied_to(node)) as f64;
            let share = (GOLDEN * (number + 1.0) + PLASTIC * (1.0 + (seed % WRAP) as f64)).fract();
            let number = self.number(node);
            self.points[number][1] += most * (2.0 * share - 1.0);
        }
    }

    /// The nodes (column, row) of an edge, from left to right or from the top down; on an unstructured mesh the nodes of the set with its name, empty
    /// without such a set.
    pub fn edge(&self, edge: Edge) -> Vec<[usize; 2]> {
        if self.connectivity.is_some() {
            return self.set(edge.name()).unwrap_or_default();
        }
        match edge {
            Edge::Top => (0..=self.columns).map(|i| [i, 0]).collect(),
            Edge::Bottom => (0..=self.columns).map(|i| [i, self.rows]).collect(),
            Edge::Left => (0..=self.rows).map(|j| [0, j]).collect(),
            Edge::Right => (0..=self.rows).map(|j| [self.columns, j]).collect(),
        }
    }

    /// The node that this one moves with, itself except on the right edge of a periodic mesh.
    pub fn tied_to(&self, [column, row]: [usize; 2]) -> [usize; 2] {
        let is_seam = self.periodic && column == self.columns;
        [if is_seam { 0 } else { column }, row]
    }

    /// The nodes of an edge that move by themselves, in the order of [`Mesh::edge`], and the tributary length of each (m). In a periodic mesh the
    /// first node of the upper and lower edge has a segment on both sides.
    pub fn surface(&self, edge: Edge) -> (Vec<[usize; 2]>, Vec<f64>) {
        let mut nodes = self.edge(edge);
        let mut lengths = self.tributary(&nodes);
        if self.periodic && matches!(edge, Edge::Top | Edge::Bottom) {
            nodes.pop();
            lengths[0] += lengths.pop().expect("an edge has nodes");
        }
        (nodes, lengths)
    }

    /// Tributary length of each node of an edge (m): half of its two segments.
    pub fn tributary(&self, nodes: &[[usize; 2]]) -> Vec<f64> {
        let mut lengths = vec![0.0; nodes.len()];
        for (k, pair) in nodes.windows(2).enumerate() {
            let [a, b] = [pair[0], pair[1]].map(|node| self.points[self.number(node)]);
            let half = 0.5 * (b[0] - a[0]).hypot(b[1] - a[1]);
            lengths[k] += half;
            lengths[k + 1] += half;
        }
        lengths
    }

    /// Names of its node sets.
    pub fn sets(&self) -> Vec<&str> {
        let ends = |edge: &Edge| matches!(edge, Edge::Left | Edge::Right);
        match &self.connectivity {
            None => Edge::ALL
                .iter()
                .filter(|(_, edge)| !(self.periodic && ends(edge)))
                .map(|(name, _)| *name)
                .collect(),
            Some(connectivity) => connectivity.sets.keys().map(String::as_str).collect(),
        }
    }

    /// The nodes of a set, each once, in order along the set.
    pub fn set(&self, name: &str) -> Option<Vec<[usize; 2]>> {
        match &self.connectivity {
            None => Edge::named(name).map(|edge| self.edge(edge)),
            Some(connectivity) => connectivity.sets.get(name).map(|set| in_row(&set.nodes())),
        }
    }

    /// The lines of a set, each in order along the line; a closed one ends where it begins. `None` for a region or an unknown name.
    pub fn lines(&self, name: &str) -> Option<Vec<Vec<[usize; 2]>>> {
        let Some(connectivity) = &self.connectivity else {
            let known = self.sets().contains(&name);
            let edge = Edge::named(name).filter(|_| known);
            return edge.map(|edge| vec![self.edge(edge)]);
        };
        match connectivity.sets.get(name)? {
            NodeSet::Lines(lines) => Some(lines.iter().map(|line| in_row(line)).collect()),
            NodeSet::Region(_) => None,
        }
    }

    /// The nodes of a set that is one open line on the outline of the body, in order along the line.
    pub fn open_line(&self, name: &str) -> Option<Vec<[usize; 2]>> {
        let mut lines = self.lines(name)?;
        let line = lines.pop().filter(|_| lines.is_empty())?;
        let open = line.first() != line.last();
        let outside = |pair: &[[usize; 2]]| self.outline(pair[0], pair[1]).is_some();
        (open && line.windows(2).all(outside)).then_some(line)
    }

    /// The two ends of a segment of the outline, ordered so that the body lies on the left; `None` for a segment inside.
    pub fn outline(&self, a: [usize; 2], b: [usize; 2]) -> Option<[[usize; 2]; 2]> {
        if let Some(connectivity) = &self.connectivity {
            return connectivity
                .outline(a[0], b[0])
                .map(|ends| ends.map(|k| [k, 0]));
        }
        let upper_or_left = if a[1] == b[1] {
            (a[1] == 0) == (a[0] < b[0])
        } else {
            (a[0] == 0) != (a[1] < b[1])
        };
        Some(if upper_or_left { [b, a] } else { [a, b] })
    }

    /// Positions of the corners of the element (column, row) (m), anticlockwise from the lower left one.
    pub fn corner_points(&self, [i, j]: [usize; 2]) -> [[f64; 2]; 4] {
        self.corners(i, j)
            .map(|node| self.points[self.number(node)])
    }

    /// Positions of the nodes of [`Mesh::surface`] (m).
    pub fn surface_points(&self, edge: Edge) -> Vec<[f64; 2]> {
        let (nodes, _) = self.surface(edge);
        let points = nodes.iter().map(|node| self.points[self.number(*node)]);
        points.collect()
    }

    /// Corners of the element in column i, row j, anticlockwise from the lower left one, as (column, row).
    pub fn corners(&self, i: usize, j: usize) -> [[usize; 2]; 4] {
        match &self.connectivity {
            None => [[i, j + 1], [i + 1, j + 1], [i + 1, j], [i, j]],
            Some(connectivity) => {
                connectivity.corners[j * self.columns + i].map(|k| [k as usize, 0])
            }
        }
    }
}

/// Area of a quadrilateral (m2), positive when its corners run anticlockwise.
pub fn area(p: &[[f64; 2]; 4]) -> f64 {
    0.5 * ((p[2][0] - p[0][0]) * (p[3][1] - p[1][1]) - (p[3][0] - p[1][0]) * (p[2][1] - p[0][1]))
}

/// Drop of a circle of this radius beside its highest point (m), which lies at x = 0; a radius of 0 means flat.
pub fn circle_drop(radius: f64, x: f64) -> f64 {
    if radius == 0.0 {
        return 0.0;
    }
    // R - sqrt(R^2 - x^2) without the cancellation at small x.
    x * x / (radius + (radius * radius - x * x).sqrt())
}

/// Nodes of an unstructured mesh, by their numbers.
fn in_row(numbers: &[u32]) -> Vec<[usize; 2]> {
    numbers.iter().map(|k| [*k as usize, 0]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_area_of_a_trapezium_is_right() {
        assert_eq!(area(&[[0.0, 0.0], [4.0, 0.0], [3.0, 2.0], [1.0, 2.0]]), 6.0);
    }

    #[test]
    fn tributary_lengths_add_up_to_the_edge() {
        let mesh = Mesh::structured(4, 2, |i, j| [i as f64 - 2.0, -(j as f64)]);
        let lengths = mesh.tributary(&mesh.edge(Edge::Right));
        assert_eq!(lengths, vec![0.5, 1.0, 0.5]);
    }
}
