//! Storage of the components of nodal fields.

use std::ops::Range;

use crate::mesh::Mesh;
use crate::pack::lanes::LANES;
use crate::pack::line::LINE;

/// Storage of the components of the nodes, row after row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Layout {
    /// Elements in a row.
    pub columns: usize,
    /// Rows of elements.
    pub rows: usize,
    /// Nodes in a row.
    pub nodes_in_row: usize,
    /// Rows of nodes.
    pub node_rows: usize,
    /// Numbers that a row of nodes keeps for one component: all nodes, and room to load a whole pack from any of them.
    pub stride: usize,
    /// True where the last node of each row is the first one.
    pub periodic: bool,
    /// Divisor of the stride.
    unit: usize,
}

impl Layout {
    pub(super) fn new(mesh: &Mesh) -> Layout {
        let nodes_in_row = mesh.nodes_in_row();
        let mut layout = Layout {
            columns: mesh.columns,
            rows: mesh.rows,
            nodes_in_row,
            node_rows: mesh.points.len() / nodes_in_row,
            stride: nodes_in_row.next_multiple_of(LANES) + LANES,
            periodic: mesh.periodic,
            unit: LANES,
        };
        if mesh.connectivity.is_none() {
            layout.stride = layout.element_stride();
        }
        layout
    }

    /// The layout of the piece with these columns of nodes; each of its components begins on a cache line.
    pub(super) fn piece(self, columns: &Range<usize>) -> Layout {
        let mut piece = Layout {
            columns: columns.len() - 1,
            nodes_in_row: columns.len(),
            unit: LINE,
            ..self
        };
        piece.stride = piece.element_stride();
        piece
    }

    /// Forces on a row of nodes: the last node of a periodic row adds its force to the first, so that each counts once.
    pub(crate) fn fold_period(self, force: &mut [f64]) {
        if !self.periodic {
            return;
        }
        for component in force.chunks_exact_mut(self.stride) {
            component[0] += component[self.columns];
            component[self.columns] = 0.0;
        }
    }

    /// Rows of displacements or their rates: the last node of a periodic row moves like the first.
    pub fn repeat_period(self, motion: &mut [f64]) {
        if !self.periodic {
            return;
        }
        for component in motion.chunks_exact_mut(self.stride) {
            component[self.columns] = component[0];
        }
    }

    /// The component that this one moves with, itself except in the last node of a periodic row.
    pub fn tied_to(self, index: usize) -> usize {
        if self.periodic && index % self.stride == self.columns {
            index - self.columns
        } else {
            index
        }
    }

    /// Numbers that a row of elements keeps for one component at its corners: room to load and to store a whole pack
    /// one column to the right of any element.
    pub(super) fn element_stride(self) -> usize {
        (self.padded_columns() + LANES).next_multiple_of(self.unit)
    }

    /// Elements in a row, rounded up to whole packs.
    pub(crate) fn padded_columns(self) -> usize {
        self.columns.next_multiple_of(LANES)
    }

    /// Numbers in a row of nodes.
    pub fn row_len(self) -> usize {
        2 * self.stride
    }

    /// Numbers in a field.
    pub fn len(self) -> usize {
        self.node_rows * self.row_len()
    }

    /// True for an empty field, which does not occur.
    pub fn is_empty(self) -> bool {
        self.len() == 0
    }

    /// Index of component 0 (x) or 1 (y) of the node (column, row).
    pub fn index(self, node: [usize; 2], component: usize) -> usize {
        node[1] * self.row_len() + component * self.stride + node[0]
    }

    /// Indices of both components of a node.
    pub fn components(self, node: [usize; 2]) -> [usize; 2] {
        [0, 1].map(|k| self.index(node, k))
    }

    /// 0 (x) or 1 (y), the direction of the component at this index.
    pub fn direction(self, index: usize) -> usize {
        index % self.row_len() / self.stride
    }

    /// The row of nodes that holds this index.
    pub fn row_of(self, index: usize) -> usize {
        index / self.row_len()
    }

    /// Column at which the register with this column begins; in a piece, its cache line.
    pub(crate) fn unit_of(self, column: usize) -> usize {
        column / self.unit * self.unit
    }

    /// Elements in a row that the nodes of these columns touch, and others to fill whole packs; `columns` is not empty.
    pub(crate) fn elements_at(self, columns: [usize; 2]) -> Range<usize> {
        let [first, end] = columns;
        self.unit_of(first.saturating_sub(1))
            ..end.next_multiple_of(LANES).min(self.padded_columns())
    }

    /// Both components of these columns in a row of nodes.
    pub(crate) fn spans(self, [first, end]: [usize; 2]) -> [Range<usize>; 2] {
        [first..end, self.stride + first..self.stride + end]
    }

    /// Indices of a row of nodes.
    pub fn row(self, row: usize) -> Range<usize> {
        row * self.row_len()..(row + 1) * self.row_len()
    }
}
