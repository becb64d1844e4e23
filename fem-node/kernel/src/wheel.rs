//! The body's own rigid wheel: vertical motion under its load, prescribed sideways motion, contact with the upper
//! edge, all in the step of the body.
//!
//! At t_n the internal forces are known and the contact forces r_n are not. They follow from their effect one step later (forward-increment Lagrange
//! multipliers: Carpenter, Taylor, Katona 1991; the paper's eqs 11-15, corrected). With the scheme of [`crate::integrate`], c the mass damping,
//!
//! ```text
//! u_free = u_n + h v_free + h^2/2 a_free            v_free, a_free: v_n and a_n without contact forces
//! w      = h^2 (b + 1/2) M^-1 / (1 + b h c)         displacement until t_n+1 by a unit force at t_n
//! g(u_free) + (H* w H) r >= 0,  r >= 0, complementary;  Coulomb's law on the slip from t_n to t_n+1
//! ```
//!
//! The factor is h^2 (b+1/2) and not h^2 because the force enters u_n+1 both through a_n and through v_n. With h^2
//! the pressures stay right, but every node slides forever and friction carries next to nothing.
//!
//! - `upper_row`: the nodes of the upper edge as the contact sees them;
//! - [`rigid`]: the constant data of the wheel;
//! - [`node_contact`]: force and status of one node;
//! - `problem`: the contact problem of one step;
//! - `coulomb`: the law of contact of one node;
//! - `flat`, `round`: solution of the problem under a flat and under a round face;
//! - `newmark`: the scheme for one component;
//! - `statistics`: signals over the sideways cycles;
//! - [`state`]: the data that a step changes;
//! - `run`: the steps.

pub(crate) mod coulomb;
pub(crate) mod flat;
pub(crate) mod newmark;
pub mod node_contact;
mod problem;
pub mod rigid;
pub mod rolled;
pub(crate) mod round;
pub mod run;
pub mod state;
pub(crate) mod statistics;
pub mod upper_row;
