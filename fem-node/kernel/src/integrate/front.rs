//! The nodes of a body in one step of a repeat.

use std::ops::Range;

/// Nodes A_k that are stepped together.
#[derive(Clone, Debug, PartialEq)]
pub enum Front {
    /// Columns of nodes in each row of a structured mesh; empty where both ends are equal.
    Columns(Vec<[usize; 2]>),
    /// Nodes of an unstructured mesh.
    Nodes(PartOfNodes),
}

/// Part of an unstructured mesh.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PartOfNodes {
    /// Runs of nodes.
    pub(super) nodes: Vec<Range<usize>>,
    /// Rows of elements that touch them.
    pub(super) rows: Vec<usize>,
}

impl PartOfNodes {
    /// Both components of each run of nodes, `stride` apart.
    pub(super) fn spans(&self, stride: usize) -> impl Iterator<Item = Range<usize>> + '_ {
        let both = move |run: &Range<usize>| [run.clone(), stride + run.start..stride + run.end];
        self.nodes.iter().flat_map(both)
    }

    /// Components of the nodes.
    pub(super) fn components(&self, stride: usize) -> impl Iterator<Item = usize> + '_ {
        self.spans(stride).flatten()
    }
}

/// Columns from the first to the last of two rows, either of which may be empty.
pub(super) fn joined(one: [usize; 2], other: [usize; 2]) -> [usize; 2] {
    match (one[0] == one[1], other[0] == other[1]) {
        (true, _) => other,
        (_, true) => one,
        _ => [one[0].min(other[0]), one[1].max(other[1])],
    }
}
