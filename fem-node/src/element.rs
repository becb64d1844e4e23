//! The discretised body: masses, supports and the internal forces of its elements.
//!
//! Every nodal field is stored row after row; a row of nodes holds its x components, then its y components,
//! each padded with zeros to [`Layout::stride`], so that packs of neighbours never need a special case. All nodes of an
//! unstructured mesh form one row, and its elements gather from it what they need.

pub(crate) mod body;
mod constants;
mod corners;
mod gather;
pub(crate) mod gauss;
mod layout;
mod linear;
mod modes;
mod points;
pub(crate) mod q4_1point;
pub(crate) mod q4_2x2;
pub(crate) mod q4_bbar;
mod row_forces;
mod shape;
mod stiffness;
mod supports;

pub(crate) use body::ElementRow;
pub use body::{Body, stiffness};
pub(crate) use corners::{CornerRows, StrainPath};
pub(crate) use gather::{CORNER_FORCES, GatherBuffers, NodalFields, sum_corners};
pub use layout::Layout;
pub(crate) use row_forces::RowForces;
pub use shape::{GAUSS_POINTS, jacobian, slopes};
pub(crate) use shape::{area, natural_coordinates, shape_functions};
pub use stiffness::Stiffness;
pub use supports::Supports;
