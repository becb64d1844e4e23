//! What all elements of a structured block share: corner displacements by packs, numbers by rows, and the
//! forces that a row of elements hands to the nodes above and below it.

use crate::element::Layout;
use crate::material::j2::{HISTORY, Past, PointHistory, past};
use crate::mesh::Mesh;
use crate::pack::{LANES, Pack, widest};

/// N numbers of each element, row after row: for each row N arrays of [`Layout::padded_columns`], zero in the padding.
pub(super) fn row_numbers<const N: usize>(
    mesh: &Mesh,
    layout: Layout,
    of_element: impl Fn(&[[f64; 2]; 4]) -> [f64; N],
) -> Vec<f64> {
    let padded = layout.padded_columns();
    let mut numbers = vec![0.0; mesh.rows() * N * padded];
    for [i, j] in mesh.places() {
        let row = &mut numbers[j * N * padded..(j + 1) * N * padded];
        let corners = mesh.corners(i, j).map(|n| mesh.point(n[0], n[1]));
        for (array, number) in row.chunks_exact_mut(padded).zip(of_element(&corners)) {
            array[i] = number;
        }
    }
    numbers
}

/// One displacement component at the corners of a pack of elements.
pub(super) struct Corners {
    u1: Pack,
    u2: Pack,
    u3: Pack,
    u4: Pack,
}

/// A field at the corners of a row of elements, one slice for each corner, anticlockwise from the lower left one:
/// element i finds its x component at i and its y component at [`Layout::element_stride`] + i.
#[derive(Clone, Copy)]
pub(crate) struct CornerRows<'a>([&'a [f64]; 4]);

impl<'a> CornerRows<'a> {
    /// Each corner in a slice of its own.
    pub(super) fn apart(corners: [&'a [f64]; 4]) -> CornerRows<'a> {
        CornerRows(corners)
    }

    /// Between an upper and a lower row of nodes of a block, where neighbours share their corners. Empty rows give
    /// empty slices: what nobody asks for.
    #[inline(always)]
    pub(crate) fn between([upper, lower]: [&'a [f64]; 2]) -> CornerRows<'a> {
        let right = |row: &'a [f64]| row.get(1..).unwrap_or_default();
        CornerRows([lower, right(lower), right(upper), upper])
    }

    /// Both components at the corners of the elements from `i` on.
    #[inline(always)]
    pub(super) fn load(self, stride: usize, i: usize) -> [Corners; 2] {
        [self.corners(i), self.corners(stride + i)]
    }

    #[inline(always)]
    fn corners(self, at: usize) -> Corners {
        let [u1, u2, u3, u4] = self.0;
        Corners {
            u1: Pack::load(u1, at),
            u2: Pack::load(u2, at),
            u3: Pack::load(u3, at),
            u4: Pack::load(u4, at),
        }
    }
}

impl Corners {
    #[inline(always)]
    pub(super) fn gradient(&self, bx: [Pack; 2], by: [Pack; 2]) -> (Pack, Pack) {
        let (d13, d24) = (self.u1 - self.u3, self.u2 - self.u4);
        (bx[0] * d13 + bx[1] * d24, by[0] * d13 + by[1] * d24)
    }

    /// Four times the means of u,xi and u,eta over the element.
    #[inline(always)]
    pub(super) fn natural(&self) -> (Pack, Pack) {
        let (d31, d24) = (self.u3 - self.u1, self.u2 - self.u4);
        (d31 + d24, d31 - d24)
    }

    /// h.u
    #[inline(always)]
    pub(super) fn hourglass(&self) -> Pack {
        (self.u1 + self.u3) - (self.u2 + self.u4)
    }
}

/// A row of elements under more than linear elasticity: displacements of its corners, what they changed by in the last
/// step, and what the points remember.
pub(crate) struct Course<'a> {
    pub(crate) u: CornerRows<'a>,
    /// The last increments; empty where nothing is remembered.
    pub(crate) du: CornerRows<'a>,
    /// Histories of this row: for each point [`crate::material::j2::HISTORY`] arrays of [`Layout::padded_columns`].
    pub(crate) history: &'a mut [f64],
}

impl Course<'_> {
    /// The histories of one of the points.
    #[inline(always)]
    pub(super) fn point(&mut self, point: usize, padded: usize) -> PointHistory<'_> {
        let size = HISTORY * padded;
        let places = match self.history.is_empty() {
            true => 0..0,
            false => point * size..(point + 1) * size,
        };
        PointHistory {
            values: &mut self.history[places],
            stride: padded,
        }
    }
}

/// Displacements and histories of a row of elements, as they are.
#[derive(Clone, Copy)]
pub(crate) struct Standing<'a> {
    pub(crate) u: CornerRows<'a>,
    pub(crate) history: &'a [f64],
}

impl Standing<'_> {
    /// What one of the points remembers; nothing where points do not.
    #[inline(always)]
    pub(super) fn past(&self, point: usize, padded: usize, i: usize) -> Past {
        match self.history.is_empty() {
            true => Past::default(),
            false => past(self.history, padded, point * HISTORY * padded + i),
        }
    }
}

/// Forces of a row of elements on the nodes above and below it, kept until the row below has added its own.
///
/// A node takes from two elements of each row: `left` holds what each node gets from the element on its right,
/// whose left corner it is, `right` what it gets from the element on its left.
#[derive(Clone, Debug)]
pub(crate) struct RowForces {
    upper_left: Vec<f64>,
    upper_right: Vec<f64>,
    lower_left: Vec<f64>,
    lower_right: Vec<f64>,
    carried_left: Vec<f64>,
    carried_right: Vec<f64>,
}

impl RowForces {
    pub(crate) fn new(layout: Layout) -> RowForces {
        let zero = vec![0.0; 2 * layout.element_stride()];
        RowForces {
            upper_left: zero.clone(),
            upper_right: zero.clone(),
            lower_left: zero.clone(),
            lower_right: zero.clone(),
            carried_left: zero.clone(),
            carried_right: zero,
        }
    }

    /// Corner forces f1 = F1 + Q, f2 = F2 - Q, f3 = -F1 + Q, f4 = -F2 - Q.
    #[inline(always)]
    pub(super) fn store(&mut self, i: usize, f1: Pack, f2: Pack, q: Pack) {
        (f1 + q).store(&mut self.lower_left, i);
        (f2 - q).store(&mut self.lower_right, i + 1);
        (q - f1).store(&mut self.upper_right, i + 1);
        (Pack::splat(0.0) - f2 - q).store(&mut self.upper_left, i);
    }

    /// Forces (x1, y1, x2, ..) on the corners of element `i`, `stride` being that of the elements.
    pub(super) fn of_element(&self, stride: usize, i: usize) -> [f64; 8] {
        let places = [
            (&self.lower_left, i),
            (&self.lower_right, i + 1),
            (&self.upper_right, i + 1),
            (&self.upper_left, i),
        ];
        std::array::from_fn(|k| places[k / 2].0[places[k / 2].1 + (k % 2) * stride])
    }

    /// There are no elements below the last row of nodes.
    pub(crate) fn clear_upper(&mut self) {
        self.upper_left.fill(0.0);
        self.upper_right.fill(0.0);
    }

    /// There are no elements above the first row of nodes.
    pub(crate) fn clear_carried(&mut self) {
        self.carried_left.fill(0.0);
        self.carried_right.fill(0.0);
    }

    /// The force on a row of nodes: from the elements above it, then from those below it.
    pub(crate) fn assemble(&self, force: &mut [f64]) {
        widest(
            #[inline(always)]
            || {
                for k in (0..force.len()).step_by(LANES) {
                    let above =
                        Pack::load(&self.carried_left, k) + Pack::load(&self.carried_right, k);
                    let below = Pack::load(&self.upper_left, k) + Pack::load(&self.upper_right, k);
                    (above + below).store(force, k);
                }
            },
        );
    }

    /// Goes down by one row: what acted on the lower nodes is carried to them.
    pub(crate) fn advance(&mut self) {
        std::mem::swap(&mut self.carried_left, &mut self.lower_left);
        std::mem::swap(&mut self.carried_right, &mut self.lower_right);
    }
}
