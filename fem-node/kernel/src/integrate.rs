//! Explicit time integration, and its energies.
//!
//! The scheme is Newmark's with beta = 0 and gamma = b (the paper's eq 12, regrouped so that a force that begins
//! at t_n acts from t_n on), C_d = c M the mass damping, f the sum of all applied forces:
//!
//! ```text
//! a  = M^-1 (f - F(u) - C_d v)                        at the start of a window
//! u' = u + h v + h^2/2 a                              then m times
//! a' = M^-1 (f' - F(u') - C_d v')
//! v' = v + h [(1-b) a + b a']
//! ```
//!
//! C_d is diagonal like M, so v' in a' costs nothing: with p = M^-1 (f' - F(u')),
//! a' = p - c (v + h [(1-b) a + b p]) / (1 + b h c). The limit h < sqrt(2/b)/omega_max then holds for any c: for one
//! mode 1 + trace + det = (4 - 2 b (omega h)^2 + 2 (2b-1) c h) / (1 + b c h). Taking v instead of v' in a' was tried:
//! the damping lags by a step and feeds the modes above omega h = sqrt(2) when b = 1/2.
//!
//! Stiffness damping, C = c M + beta K (Rayleigh 1877, section 102), takes the mean velocity of the last step,
//!
//! ```text
//! d' = beta K (u'-u)/h = (beta/h) (F(u') - F(u)),     a' = M^-1 (f' - F(u') - d' - C_d v')
//! ```
//!
//! which needs no second pass over the elements. For one mode z (z-1)^2 = -(omega h)^2 [(1/2-b) + (b+1/2) z] [(1+r) z - r], r = beta/h. Its root -1
//! gives 2 b (omega h)^2 (1 + 2 r) = 4: with xi = beta omega/2 at the largest omega h < (sqrt(2/b + 4 xi^2) - 2 xi)/omega_max, for b = 1/2 the
//! (2/omega_max) (sqrt(1 + xi^2) - xi) of Belytschko, Liu and Moran (2000), section 6.2.
//!
//! # Energy of one step
//! Write du = u'-u, da = a'-a, dF = F(u')-F(u). From the scheme h v = du - h^2/2 a, and the kinetic energy
//! K = v M v / 2 changes by
//!
//! ```text
//! dK = (v'-v) M (v + (v'-v)/2)
//!    = [(1-b) a + b a'] M du + (b h^2/2) [(1-b) a + b a'] M da
//! ```
//!
//! In the first term M a = f - F - C_d v, so it is W - [(1-b) F + b F'] du - D with
//!
//! ```text
//! W = [(1-b) f + b f'] du                             work of the applied forces
//! D = [(1-b) v + b v'] C_d du                         mass damping
//! ```
//!
//! (stiffness damping takes [(1-b) d + b d'] du in the same way)
//!
//! and (1-b) F + b F' = (F + F')/2 + (b-1/2) dF, where (F + F') du / 2 is the change of the strain energy.
//! In the second term (1-b) a + b a' = (a + a')/2 + (b-1/2) da. The rest is the numerical loss
//!
//! ```text
//! W - dU - dK - D = (b-1/2) (du dF - b h^2/2 da M da) - (b h^2/4) (a'Ma' - aMa)
//! ```
//!
//! The last bracket telescopes inside a window, not across windows: a is computed anew under the new force.
//!
//! # Modules
//! - `dissipation`, `load`, [`state`], `fields`: dissipated energies, applied forces, fields of the nodes, and all three together;
//! - `front`, `rings`, `region`, `cut`: the part of a body that a changed force can have reached;
//! - `node_row`, `node_pass`: one row of nodes through a step;
//! - `scratch`, `strip`: a structured body by rows; `unstructured`: any other;
//! - `tally`: sums in an order that does not depend on the number of threads;
//! - `integrator`: a step of the whole body.

pub mod cut;
pub mod dissipation;
pub mod fields;
pub(crate) mod front;
pub mod integrator;
pub(crate) mod load;
pub(crate) mod node_pass;
pub(crate) mod node_row;
pub mod region;
pub(crate) mod rings;
pub(crate) mod scratch;
pub mod state;
mod strip;
pub mod tally;
mod unstructured;
