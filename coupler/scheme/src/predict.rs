//! Predictions for a coupled run before its first window: whether its scheme is stable, with what margin, and which
//! bound decides.
//!
//! The handshake tells the continuum's step, step limit, first period and compliance, and the masses behind a point of
//! the layer ([`inputs`]). In the softest motion of the interface the continuum is taken for the elastic bar that agrees with
//! all of this ([`response`]), the layer for a mass behind a spring ([`sprung_mass`]); the two are participants in memory
//! ([`linear_pair`]), the scheme itself runs on them ([`growth`]), and it is stable if no disturbance grows ([`prediction`]).
//!
//! Schemes that send force one way and motion the other fail by *added mass*: the light continuum is pushed by the
//! inertia of a heavy layer. With C the continuum's compliance in the window and S the layer's resistance -dF/du, the
//! number that counts is C S, the layer's mass over the mass that the continuum moves in a window. A fixed point with
//! relaxation omega contracts by |1 - omega (1 + C S)| a repeat, so it converges for omega < 2 / (1 + C S) (Causin,
//! Gerbeau and Nobile 2005, relaxed Dirichlet-Neumann iterations); without repeats the force comes back C S times as
//! large one window later, and the limit is that of the window's map. With `dirichlet = "continuum"` it is the
//! motion that comes back, 1 / (C S) times as large: omega < 2 / (1 + 1 / (C S)), where C is H over the impedance of
//! the *stiffest* motion and S holds the masses of the points.

pub mod growth;
pub mod inputs;
pub mod linear_pair;
pub mod prediction;
pub mod response;
pub mod sprung_mass;
