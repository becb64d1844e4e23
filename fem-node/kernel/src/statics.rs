//! Equilibrium of the body under its tractions and its rigid wheel, with Signorini-Coulomb contact.
//!
//! K u = f + H r is condensed onto the upper edge: the columns of K^-1 for forces on the nodes that may touch the
//! wheel are computed once from a sparse Cholesky factor, which leaves a dense problem in the contact forces
//! and the position of the wheel.
//!
//! Coulomb's law is a law of rates. A node that touched early has been dragged along by all the load that came after,
//! so the load must grow in small increments, each with its own complementarity problem. A single increment gives 646 MPa of hydrostatic pressure
//! under the wheel of the paper instead of 671.
//!
//! - [`problem`]: the body, and its loads without a wheel;
//! - [`contact`]: contact forces and statuses of the nodes;
//! - `factor`: the stiffness of the body and its Cholesky factor;
//! - `face`: position of the wheel, and the gaps below it;
//! - `edge`: the compliance of the upper edge;
//! - `active_set`: one increment of the contact problem;
//! - [`history`]: the increments of a load.

pub(crate) mod active_set;
pub mod contact;
mod edge;
mod face;
pub(crate) mod factor;
pub mod history;
pub mod problem;
