//! Rings of elements around nodes of a mesh.

use std::ops::Range;

use super::front::{Front, PartOfNodes, joined};
use crate::element::body::Body;
use crate::element::layout::Layout;
use crate::mesh::connectivity::Connectivity;

/// The ways in which nodes are added ring by ring.
pub(super) enum Rings<'a> {
    /// Of a structured mesh: in each row the columns from the first to the last that are reached, or all of them.
    Rows { layout: Layout, whole: bool },
    /// Of an unstructured mesh: the nodes that are reached, or all nodes of the rows of elements that are.
    Graph {
        layout: Layout,
        connectivity: &'a Connectivity,
        whole: bool,
    },
}

impl Rings<'_> {
    /// For a body whose law has a history or not. A row of elements with a history is stepped as a whole, and so is a periodic
    /// one, whose ends are the same nodes.
    pub(super) fn new(body: &Body, history: bool) -> Rings<'_> {
        let layout = body.layout;
        match &body.connectivity {
            None => Rings::Rows {
                layout,
                whole: history || layout.is_periodic(),
            },
            Some(connectivity) => Rings::Graph {
                layout,
                connectivity,
                whole: history,
            },
        }
    }

    /// Nodes of these components.
    pub(super) fn around(&self, components: &[usize]) -> Front {
        match self {
            Rings::Rows { layout, whole } => {
                let mut rows = vec![[0, 0]; layout.node_rows];
                for index in components {
                    let column = index % layout.row_len() % layout.stride;
                    let row = &mut rows[layout.row_of(*index)];
                    *row = joined(*row, [column, column + 1]);
                }
                Front::Columns(widened(rows, *layout, *whole))
            }
            Rings::Graph { layout, .. } => {
                let mut nodes = vec![false; layout.stride];
                for index in components {
                    nodes[index % layout.stride] = true;
                }
                self.part(&nodes)
            }
        }
    }

    /// The front and one ring more.
    pub(super) fn grown(&self, front: &Front) -> Front {
        match (self, front) {
            (Rings::Rows { layout, whole }, Front::Columns(rows)) => {
                let beside = |row: usize| &rows[row.saturating_sub(1)..(row + 2).min(rows.len())];
                let grown = (0..rows.len()).map(|row| {
                    let [first, end] = beside(row).iter().copied().fold([0, 0], joined);
                    if first == end {
                        [0, 0]
                    } else {
                        [first.saturating_sub(1), (end + 1).min(layout.nodes_in_row)]
                    }
                });
                Front::Columns(widened(grown.collect(), *layout, *whole))
            }
            (Rings::Graph { connectivity, .. }, Front::Nodes(part)) => {
                let mut nodes = self.flags(part);
                let before = nodes.clone();
                let (rows, whole) = (&part.rows, self.is_whole());
                for row in rows {
                    let elements = &connectivity.corners[self.elements_of(*row)];
                    let touches = |element: &&[u32; 4]| {
                        whole || element.iter().any(|node| before[*node as usize])
                    };
                    for node in elements.iter().filter(touches).flatten() {
                        nodes[*node as usize] = true;
                    }
                }
                self.part(&nodes)
            }
            _ => unreachable!("a front is made by the rings of its mesh"),
        }
    }

    /// Indices of the components of a front, those of another one left out.
    pub(super) fn components(&self, front: &Front, without: Option<&Front>) -> Vec<Range<usize>> {
        let mut ranges = Vec::new();
        match (self, front) {
            (Rings::Rows { layout, .. }, Front::Columns(rows)) => {
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
            (Rings::Graph { layout, .. }, Front::Nodes(part)) => {
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
            _ => unreachable!("a front is made by the rings of its mesh"),
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
        let elements: usize = match (self, front) {
            (Rings::Rows { layout, .. }, Front::Columns(rows)) => {
                let of_row = |pair: &[[usize; 2]]| {
                    let columns = joined(pair[0], pair[1]);
                    if columns[0] == columns[1] {
                        0
                    } else {
                        layout.elements_at(columns).len()
                    }
                };
                rows.windows(2).map(of_row).sum()
            }
            (_, Front::Nodes(part)) => part
                .rows
                .iter()
                .map(|row| self.elements_of(*row).len())
                .sum(),
            _ => unreachable!("a front is made by the rings of its mesh"),
        };
        elements as u64
    }

    /// Elements of the body.
    pub(super) fn elements(&self) -> usize {
        match self {
            Rings::Rows { layout, .. } => layout.rows * layout.columns,
            Rings::Graph { connectivity, .. } => connectivity.corners.len(),
        }
    }

    fn is_whole(&self) -> bool {
        match self {
            Rings::Rows { whole, .. } | Rings::Graph { whole, .. } => *whole,
        }
    }

    /// Elements of a row of an unstructured mesh.
    fn elements_of(&self, row: usize) -> Range<usize> {
        match self {
            Rings::Rows { layout, .. } => 0..layout.columns,
            Rings::Graph {
                layout,
                connectivity,
                ..
            } => {
                let first = row * layout.columns;
                first..(first + layout.columns).min(connectivity.corners.len())
            }
        }
    }

    fn flags(&self, part: &PartOfNodes) -> Vec<bool> {
        let (Rings::Rows { layout, .. } | Rings::Graph { layout, .. }) = self;
        let mut nodes = vec![false; layout.stride];
        for node in part.nodes.iter().cloned().flatten() {
            nodes[node] = true;
        }
        nodes
    }

    fn part(&self, nodes: &[bool]) -> Front {
        let rows = match self {
            Rings::Rows { .. } => Vec::new(),
            Rings::Graph {
                layout,
                connectivity,
                ..
            } => {
                let touched = |elements: &[[u32; 4]]| {
                    elements.iter().flatten().any(|node| nodes[*node as usize])
                };
                let rows = connectivity.corners.chunks(layout.columns).enumerate();
                rows.filter(|(_, elements)| touched(elements))
                    .map(|(row, _)| row)
                    .collect()
            }
        };
        Front::Nodes(PartOfNodes {
            nodes: runs(nodes),
            rows,
        })
    }
}

/// Whole rows, with their padding, where they are stepped as a whole.
fn widened(mut rows: Vec<[usize; 2]>, layout: Layout, whole: bool) -> Vec<[usize; 2]> {
    for row in rows.iter_mut().filter(|row| whole && row[0] < row[1]) {
        *row = [0, layout.stride];
    }
    rows
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
