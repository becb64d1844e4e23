//! Connectivity of an unstructured mesh: the corners of its elements, and its named sets.

use std::collections::BTreeMap;

/// Elements in a row: their numbers, displacements and forces together fit into the first cache.
pub(crate) const ROW: usize = 64;

/// Connectivity by numbers of nodes.
#[derive(Clone, Debug, PartialEq)]
pub struct Connectivity {
    /// Corners of all elements, anticlockwise.
    pub(crate) corners: Vec<[u32; 4]>,
    /// Beginning of each node's entries in `around`, and the end of the last.
    first: Vec<u32>,
    /// Corners at the nodes, 4 element + corner, ascending: the order in which forces on a node are summed.
    around: Vec<u32>,
    /// Named sets.
    pub(crate) sets: BTreeMap<String, NodeSet>,
}

/// A named set of nodes.
#[derive(Clone, Debug, PartialEq)]
pub enum NodeSet {
    /// Connected lines, each in order along the line; a closed one ends where it begins.
    Lines(Vec<Vec<u32>>),
    /// The nodes of a region.
    Region(Vec<u32>),
}

impl Connectivity {
    /// Elements by their corners, anticlockwise, on `nodes` nodes.
    pub fn new(
        nodes: usize,
        corners: Vec<[u32; 4]>,
        sets: BTreeMap<String, NodeSet>,
    ) -> Connectivity {
        let mut first = vec![0u32; nodes + 1];
        for node in corners.iter().flatten() {
            first[*node as usize + 1] += 1;
        }
        for node in 0..nodes {
            first[node + 1] += first[node];
        }
        let mut next = first.clone();
        let mut around = vec![0; 4 * corners.len()];
        for (corner, node) in corners.iter().flatten().enumerate() {
            let at = &mut next[*node as usize];
            around[*at as usize] = corner as u32;
            *at += 1;
        }
        Connectivity {
            corners,
            first,
            around,
            sets,
        }
    }

    /// The closed lines of the outline, the body on the left: anticlockwise around a part of the body, clockwise around a hole. A node in which two
    /// lines meet is a line of its own, and these two lines are mixed up.
    pub fn loops(&self) -> Vec<Vec<usize>> {
        let sides = |c: &[u32; 4]| [0, 1, 2, 3].map(|k| [c[k], c[(k + 1) % 4]].map(|n| n as usize));
        let sides = self.corners.iter().flat_map(sides);
        let outline = sides.filter(|[a, b]| self.outline(*a, *b).is_some());
        let (mut next, mut loops) = (BTreeMap::new(), Vec::new());
        for [a, b] in outline {
            if next.insert(a, b).is_some() {
                loops.push(vec![a]);
            }
        }
        while let Some((start, mut at)) = next.pop_first() {
            let mut line = vec![start];
            while let Some(after) = next.remove(&at) {
                line.push(std::mem::replace(&mut at, after));
            }
            if at == start {
                loops.push(line);
            }
        }
        loops
    }

    /// Elements by rows.
    pub(crate) fn rows(&self) -> impl Iterator<Item = &[[u32; 4]]> {
        self.corners.chunks(ROW)
    }

    /// Elements of a row.
    pub(crate) fn row(&self, row: usize) -> &[[u32; 4]] {
        let first = row * ROW;
        &self.corners[first..(first + ROW).min(self.corners.len())]
    }

    /// Number of nodes.
    pub(crate) fn nodes(&self) -> usize {
        self.first.len() - 1
    }

    /// Corners of elements at the node, 4 element + corner.
    pub(crate) fn corners_at(&self, node: usize) -> &[u32] {
        &self.around[self.first[node] as usize..self.first[node + 1] as usize]
    }

    /// The two ends of a side of one element, the body on the left; `None` where two elements share the side or no element has it.
    pub(crate) fn outline(&self, a: usize, b: usize) -> Option<[usize; 2]> {
        let mut sides = self.corners_at(a).iter().filter_map(|at| {
            let (element, corner) = (*at as usize / 4, *at as usize % 4);
            let at = |step: usize| self.corners[element][(corner + step) % 4] as usize;
            match (at(1) == b, at(3) == b) {
                (true, _) => Some([a, b]),
                (_, true) => Some([b, a]),
                _ => None,
            }
        });
        sides.next().filter(|_| sides.next().is_none())
    }
}

impl NodeSet {
    /// Nodes of the set, each once.
    pub fn nodes(&self) -> Vec<u32> {
        let lines = match self {
            NodeSet::Region(nodes) => return nodes.clone(),
            NodeSet::Lines(lines) => lines,
        };
        let mut seen = std::collections::HashSet::new();
        let nodes = lines.iter().flatten().copied();
        nodes.filter(|node| seen.insert(*node)).collect()
    }
}
