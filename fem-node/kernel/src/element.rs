//! The discretised body: masses and the internal forces of its elements.
//!
//! Every nodal field is stored row after row; a row of nodes holds its x components, then its y components,
//! each padded with zeros to [`Layout::stride`](layout::Layout::stride), so that packs of neighbours never need a special case. All nodes of an
//! unstructured mesh form one row, from which its elements gather their corners.
//!
//! - [`shape`]: shape functions, their slopes and the points of integration;
//! - [`layout`]: positions of a node's components in a field;
//! - [`stiffness`]: the stiffness of one element;
//! - `row_forces`, `corners`, `gather`: forces and motions of the corners of a row of elements;
//! - `modes`, `gauss`, `constants`: parts of the integration that the elements share;
//! - `linear`, `points`: a row of elements of a linear or a nonlinear material;
//! - `q4_bbar`, `q4_2x2`, `q4_1point`: the elements;
//! - [`body`]: all elements of a body.

pub mod body;
pub(crate) mod constants;
pub(crate) mod corners;
pub(crate) mod gather;
pub(crate) mod gauss;
pub mod layout;
pub(crate) mod linear;
pub(crate) mod modes;
pub(crate) mod points;
pub mod q4_1point;
pub(crate) mod q4_2x2;
pub(crate) mod q4_bbar;
pub(crate) mod row_forces;
pub mod shape;
pub mod stiffness;
