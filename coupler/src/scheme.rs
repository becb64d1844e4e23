//! Coupling schemes as algorithms: no process, no message, no file.
//!
//! From the ground up, each naming only those before it:
//! - [`clock`]: windows in integer steps; [`mapping`]: glued points as weighted means of surface nodes; [`nodal_mass`]: their
//!   masses on these; [`ledger`]: work, momentum and gap of an interface, energies of both sides;
//! - [`group`]: interfaces that are solved together;
//! - [`participants`]: the port through which schemes speak to solvers;
//! - [`join`](mod@join): the interfaces of a scenario made ready for their first window;
//! - [`source`], [`compliance`]: C of the continua, and the boundary that it makes for the contacts;
//! - [`window`]: the answers of all sides; [`criteria`]: their judgement; [`vectors`], [`problem`]: a window as a scheme sees it;
//! - [`dual_schur`], [`velocity`], [`staggered`], [`fixed_point`] with [`acceleration`], [`neumann_dirichlet`]: one scheme a file;
//! - [`coupling`]: a group with its scheme, its state and its policy;
//! - [`predict`]: stability before the first window, by the scheme itself on linear participants.

pub mod acceleration;
pub mod clock;
pub mod compliance;
pub mod coupling;
pub mod criteria;
pub mod dual_schur;
pub mod fixed_point;
pub mod group;
pub mod join;
pub mod ledger;
pub mod mapping;
pub mod neumann_dirichlet;
pub mod nodal_mass;
pub mod participants;
pub mod predict;
pub mod problem;
pub mod source;
pub mod staggered;
pub mod vectors;
pub mod velocity;
pub mod window;
