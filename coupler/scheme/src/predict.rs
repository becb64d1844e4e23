//! Predicts before the first window of a coupled run whether its scheme is stable, with which margin, and which bound
//! decides.
//!
//! The handshake provides the continuum's step, step limit, first period and compliance, and the masses behind a point
//! of the layer ([`inputs`]). In the softest motion of the interface an elastic bar with these values replaces the
//! continuum ([`response`]) and a mass behind a spring replaces the layer ([`sprung_mass`]). The two are participants
//! in memory ([`linear_pair`]), and the scheme itself runs on them ([`growth`]). It is stable if no disturbance grows
//! ([`prediction`]).
//!
//! Schemes that send force one way and motion the other fail by *added mass*: the inertia of a heavy layer pushes the
//! light continuum. With C the continuum's compliance in the window and S the layer's resistance -dF/du, the decisive
//! number is C S, the layer's mass over the mass that the continuum moves in a window. A fixed point with relaxation
//! omega contracts by |1 - omega (1 + C S)| a repeat, so it converges for omega < 2 / (1 + C S) (Causin, Gerbeau and
//! Nobile 2005, relaxed Dirichlet-Neumann iterations). Without repeats the force returns C S times as large one window
//! later, and the map of a window sets the limit. With `dirichlet = "continuum"` the motion returns, 1 / (C S) times as
//! large: omega < 2 / (1 + 1 / (C S)), where C is H over the impedance of the *stiffest* motion and S includes the
//! masses of the points.

pub mod growth;
pub mod inputs;
pub mod linear_pair;
pub mod prediction;
pub mod response;
pub mod sprung_mass;
