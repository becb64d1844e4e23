//! Rings of elements around nodes of a mesh.

use std::ops::Range;

use super::front::{Front, PartOfNodes, joined};
use crate::element::body::Body;
use crate::element::layout::Layout;
use crate::mesh::connectivity::Connectivity;

/// How nodes are added ring by ring.
pub(super) struct Rings<'a> {
    layout: Layout,
    /// Connectivity of an unstructured mesh.
    connectivity: Option<&'a Connectivity>,
    /// True where a row is reached as a whole: all nodes of a row of a structured mesh, the nodes of all elements of a row of an unstructured one.
    /// False where a structured row is reached from its first to its last reached column.
    whole: bool,
}

impl Rings<'_> {
    /// For a body whose law has a history or not. A row of elements with a history is stepped as a whole, and so is a periodic row, whose ends are
    /// the same nodes.
    pub(super) fn new(body: &Body, history: bool) -> Rings<'_> {
        Rings {
            layout: body.layout,
            connectivity: body.connectivity.as_deref(),
            whole: history || body.layout.periodic,
        }
    }

    /// Nodes of these components.
    pub(super) fn around(&self, components: &[usize]) -> Front {
        let layout = self.layout;
        if let Some(connectivity) = self.connectivity {
            let mut nodes = vec![false; layout.stride];
            for index in components {
                nodes[index % layout.stride] = true;
            }
            return part(connectivity, &nodes);
        }
        let mut rows = vec![[0, 0]; layout.node_rows];
        for index in components {
            let column = index % layout.row_len() % layout.stride;
            let row = &mut rows[layout.row_of(*index)];
            *row = joined(*row, [column, column + 1]);
        }
        self.widened(rows)
    }

    /// The front and one ring more.
    pub(super) fn grown(&self, front: &Front) -> Front {
        match (front, self.connectivity) {
            (Front::Nodes(reached), Some(connectivity)) => {
                let mut nodes = self.flags(reached);
                let before = nodes.clone();
                for row in &reached.rows {
                    let touches = |element: &&[u32; 4]| {
                        self.whole || element.iter().any(|node| before[*node as usize])
                    };
                    let elements = connectivity.row(*row).iter();
                    for node in elements.filter(touches).flatten() {
                        nodes[*node as usize] = true;
                    }
                }
                part(connectivity, &nodes)
            }
            (Front::Columns(rows), _) => {
                let beside = |row: usize| &rows[row.saturating_sub(1)..(row + 2).min(rows.len())];
                let grown = (0..rows.len()).map(|row| {
                    let [first, end] = beside(row).iter().copied().fold([0, 0], joined);
                    if first == end {
                        [0, 0]
                    } else {
                        [
                            first.saturating_sub(1),
                            (end + 1).min(self.layout.nodes_in_row),
                        ]
                    }
                });
                self.widened(grown.collect())
            }
            _ => unreachable!("only an unstructured mesh has lists of nodes"),
        }
    }

    /// Indices of the components of a front, without the components of another front.
    pub(super) fn components(&self, front: &Front, without: Option<&Front>) -> Vec<Range<usize>> {
        let layout = self.layout;
        let mut ranges = Vec::new();
        match front {
            Front::Columns(rows) => {
                for (row, [first, end]) in rows.iter().enumerate() {
                    let inner = match without {
                        Some(Front::Columns(rows)) if rows[row][0] < rows[row][1] => rows[row],
                        _ => [*end, *end],
                    };
                    for columns in [[*first, inner[0]], [inner[1], *end]] {
                        let start = layout.row(row).start;
                        let spans = layout.spans(columns).into_iter();
                        ranges.extend(spans.map(|span| start + span.start..start + span.end));
                    }
                }
            }
            Front::Nodes(part) => {
                let mut nodes = self.flags(part);
                if let Some(Front::Nodes(inner)) = without {
                    for node in inner.nodes.iter().cloned().flatten() {
                        nodes[node] = false;
                    }
                }
                let ring = PartOfNodes {
                    nodes: runs(&nodes),
                    rows: Vec::new(),
                };
                ranges.extend(ring.spans(layout.stride));
            }
        }
        ranges.retain(|range| !range.is_empty());
        ranges
    }

    /// Rows of elements that touch the front.
    pub(super) fn rows(&self, front: &Front) -> Vec<usize> {
        match front {
            Front::Nodes(part) => part.rows.clone(),
            Front::Columns(rows) => {
                let touched = |pair: &[[usize; 2]]| pair.iter().any(|[first, end]| first < end);
                let pairs = rows.windows(2).enumerate();
                pairs
                    .filter(|(_, pair)| touched(pair))
                    .map(|(row, _)| row)
                    .collect()
            }
        }
    }

    /// Elements that a step of the front computes.
    pub(super) fn work(&self, front: &Front) -> u64 {
        let elements: usize = match front {
            Front::Columns(rows) => {
                let columns = rows.windows(2).map(|pair| joined(pair[0], pair[1]));
                let reached = columns.filter(|[first, end]| first < end);
                reached
                    .map(|columns| self.layout.elements_at(columns).len())
                    .sum()
            }
            Front::Nodes(part) => {
                let connectivity = self.connectivity.into_iter();
                let rows = connectivity.flat_map(|all| part.rows.iter().map(|row| all.row(*row)));
                rows.map(<[_]>::len).sum()
            }
        };
        elements as u64
    }

    /// The front of these columns; whole rows, with their padding, where they are stepped as a whole.
    fn widened(&self, mut rows: Vec<[usize; 2]>) -> Front {
        for row in rows.iter_mut().filter(|row| self.whole && row[0] < row[1]) {
            *row = [0, self.layout.stride];
        }
        Front::Columns(rows)
    }

    /// True for each node of a part.
    fn flags(&self, part: &PartOfNodes) -> Vec<bool> {
        let mut nodes = vec![false; self.layout.stride];
        for node in part.nodes.iter().cloned().flatten() {
            nodes[node] = true;
        }
        nodes
    }
}

/// These nodes of an unstructured mesh, and the rows of elements that touch them.
fn part(connectivity: &Connectivity, nodes: &[bool]) -> Front {
    let touched = |elements: &[[u32; 4]]| elements.iter().flatten().any(|n| nodes[*n as usize]);
    let rows = connectivity.rows().enumerate();
    let touched = rows.filter(|(_, elements)| touched(elements));
    Front::Nodes(PartOfNodes {
        nodes: runs(nodes),
        rows: touched.map(|(row, _)| row).collect(),
    })
}

/// Runs of true values.
fn runs(flags: &[bool]) -> Vec<Range<usize>> {
    let mut runs: Vec<Range<usize>> = Vec::new();
    for (k, _) in flags.iter().enumerate().filter(|(_, flag)| **flag) {
        match runs.last_mut() {
            Some(run) if run.end == k => run.end = k + 1,
            _ => runs.push(k..k + 1),
        }
    }
    runs
}
