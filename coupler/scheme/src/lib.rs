//! Coupling schemes as algorithms: no process, no message, no file.
//!
//! # Problem
//!
//! A surface of a continuum carries a row of *glued* points that belong to another solver: grains that stand on a rail.
//! In each window of length H the continuum makes m explicit steps under a force lambda on its surface nodes, and the
//! grains make one implicit step on a moving boundary. Forces and motions must agree: the same force on both sides, the
//! same position at the end of the window, and no spurious energy.
//!
//! ```text
//! continuum   du  = du_free + C lambda    exact for a linear one
//! grains      F_g = contacts(v_g)         set-valued, not smooth
//! interface   lambda = N^T F_g,   N du = H v_g
//! ```
//!
//! # Symbols
//!
//! Vectors hold two components a point, (x0, y0, x1, y1, ...), in SI.
//!
//! | symbol | meaning | unit | in the code |
//! |---|---|---|---|
//! | H, m | length of a window, explicit steps in it | s, - | [`Window`](protocol::Window), key `substeps` |
//! | lambda | force on the surface nodes, constant in a window | N | [`InterfaceState::lambda`](window::InterfaceState::lambda) |
//! | du | increment of the nodes' displacement in a window | m | [`SolvedWindow::increment`](window::SolvedWindow::increment) |
//! | N | motion of nodes to motion of points (points x nodes); N^T takes forces back | - | [`Mapping`](mapping::Mapping) |
//! | C, D | compliance of the nodes over a window; impedance | m/N, kg/s | [`Compliance`](compliance::Compliance), [`source`] |
//! | W_g, a_g | compliance of the points; their velocity without contact forces | 1/kg, m/s | [`WindowProblem`](problem::WindowProblem) |
//! | F_g, v_g, p | force of the grains on the points; velocity of these; impulse H F_g | N, m/s, N s | [`Answer`](window::Answer) |
//! | S, omega | resistance -dF_g/du of the grains; relaxation of a fixed point | N/m, - | [`predict`], key `relaxation` |
//! | rho | growth of a disturbance from window to window | - | [`growth`](predict::growth) |
//!
//! # The default: dual Schur complement on displacement
//!
//! The continuum's response to a force is known in advance. The grains therefore stand on a boundary that yields as the
//! continuum would, and the contact problem contains both sides at once:
//!
//! ```text
//! du_k    = advance(lambda_k)
//! a_g     = N (du_k - C lambda_k) / H
//! v_g     = a_g + W_g p,   W_g = N C N^T / H^2
//! lambda_k+1 = N^T F_g
//! |N du_k+1 - H v_g| <= tolerance
//! ```
//!
//! With exact columns C, a linear continuum runs twice a window and the grains once, for any contacts. Two choices
//! matter: the compliance from a *constant* force to the *displacement* at the end is sum phi phi^T (1 - cos(omega
//! H))/omega^2 over the modes phi, which is never negative. The velocity at the end of a constant force has no such
//! sign, nor has the displacement under a force that is linear in time. A coupling on either can grow. For a nonlinear
//! continuum the secant update learns C from window to window (Broyden, Fletcher, Goldfarb and Shanno 1970). The other
//! schemes, their purpose and their cost are described below and in the book, `concepts/coupling-schemes`.
//!
//! # Checks
//!
//! - Gap: |N du - H v_g| at the end of each window, over the node spacing: `gap_max_rel`. It decides.
//! - Contact solves: by their true residual ([`starved`](criteria::starved)). A solve with too few iterations still has
//!   a gap of zero.
//! - Momentum: both sides bear the same force in a window, and N^T conserves its sum and moment: `force_residual_rel`.
//! - Energy: F_g.(N du - H v_g) of each window at the interface, exactly
//!   ([`InterfaceLedger`](ledger::InterfaceLedger)); the work that a participant reports against the exchanged work;
//!   and work, stored and dissipated energy of all sides together.
//! - Bits: equal scenarios give equal hashes of exchange and state, with any number of threads and either transport.
//! - Answers on paper: split bars, added masses, impacts, static patches, columns between strip and wheel (`tests/coupling`).
//!
//! # Limits
//!
//! One compliance matrix is stored in full: (2 n)^2 numbers for n exchanged nodes. Windows longer than a quarter of the
//! continuum's first period lose accuracy, as `check` reports; windows beyond the bounds of the grains are refused. The
//! mapping is for a line of nodes and a row of points along it; a point off the line moves with the nodes below it. A
//! body that carries several layers feels each of them one repeat late. More repeats remove the error: for two layers
//! in any window, for more while the others together move a layer less than it moves itself ([`dual_schur`]). The
//! coupler sees only the physics that crosses the interface; it cannot find wrong units inside a participant.
//!
//! # Modules
//!
//! From the ground up; each module uses only those before it:
//! - [`clock`]: windows in integer steps; [`mapping`]: glued points as weighted means of surface nodes; [`nodal_mass`]:
//!   the points' masses on the nodes; [`ledger`]: work, momentum and gap of an interface, energies of both sides;
//! - [`group`]: interfaces solved together;
//! - [`participants`]: the trait through which schemes call solvers;
//! - [`join`](mod@join): the interfaces of a scenario made ready for their first window;
//! - [`source`], [`compliance`]: C of the continua, and the boundary that the contacts get from it;
//! - [`heat`]: heat through the interfaces; [`window`]: the answers of all sides; [`criteria`]: their judgement; [`vectors`], [`problem`]: a window as a scheme sees it;
//! - [`dual_schur`], [`velocity`], [`staggered`], [`fixed_point`] with [`acceleration`], [`neumann_dirichlet`]: one
//!   scheme in each file;
//! - [`coupling`]: a group with its scheme, its state and its policy;
//! - [`predict`]: stability before the first window, by running the scheme itself on linear participants.
//!
//! # Equations, functions, sources
//!
//! du is the increment of the continuum in a window of length H, lambda the force on it, v_g the velocity of the glued
//! points and F_g the force of the grains there; N maps the motion of nodes to the motion of points, C is the condensed
//! compliance of the continuum, D its impedance. Renouf, Saulot and Berthier (2006) ran both scales separately; the
//! solvers use their equations.
//!
//! | equation | function | source |
//! |---|---|---|
//! | lambda = N^T F_g, equal positions at the end of the window | [`dual_schur::solve`] | dual Schur complement; subcycling after Gravouil and Combescure (2001) |
//! | a_g = N (du - C lambda) / H | [`WindowProblem::free_velocity`](problem::WindowProblem::free_velocity) | derived in [`dual_schur`] |
//! | v_g = a_g + W_g p, W_g = N C N^T / H^2 | [`Compliance::prepare`](compliance::Compliance::prepare), [`Mapping::condense`](mapping::Mapping::condense) | derived in [`dual_schur`] |
//! | C += y y^T / (y.s) - (C s)(C s)^T / (s.C s) | [`Compliance::update`](compliance::Compliance::update) | Broyden (1970), Fletcher (1970), Goldfarb (1970), Shanno (1970) |
//! | C = H^2 / (2 m sqrt(substeps)) | [`source::mass_only`] | stated there |
//! | lambda = lambda_f + D v, equal velocities at the end | [`velocity::solve`] | Gravouil and Combescure (2001) |
//! | lambda_k+1 = accelerated(lambda_k, N^T F_g), contraction \|1 - omega (1 + C S)\| | [`fixed_point::solve`] | Causin, Gerbeau and Nobile (2005); Kuettler and Wall (2008) |
//! | the same with the roles exchanged, v' = v_0 + M_n^-1 (H N^T F_g - H lambda) | [`neumann_dirichlet::solve_fixed_point`] | derived in [`neumann_dirichlet`] |
//! | one pass a window, one window late | [`staggered::solve`], [`neumann_dirichlet::solve_staggered`] | shown to fail: Causin, Gerbeau and Nobile (2005) |
//! | omega <- -omega r_old.(r - r_old) / \|r - r_old\|^2; x = x~ + W c | [`Accelerator::next`](acceleration::Accelerator::next) | Irons and Tuck (1969); Degroote, Bathe and Vierendeels (2009) |
//! | N: mean of the shape functions over a segment, affine correction | [`Mapping::new`](mapping::Mapping::new) | mortar; stated there |
//! | M_n = N^T M_p N | [`nodal_mass`](nodal_mass::nodal_mass) | stated there |
//! | \|N du - H v_g\| <= tolerance | [`criteria::open`] | stated there |
//! | F_g.(N du - H v_g), the energy that the interface makes or loses | [`InterfaceLedger::add`](ledger::InterfaceLedger::add) | stated there |
//! | W - dE - D of all sides | [`EnergySums::together`](ledger::EnergySums::together) | stated there |
//! | rho = lim \|M^k\|^(1/k), M the map of a window | [`growth`](predict::growth::growth), [`spectral_radius`](predict::growth::spectral_radius) | Gelfand (1941) |
//! | m_g (v_g - v_g0) = H k (q_1 - q_0) - p, m (v - v_0) = -H k (q_1 - q_0) | [`SprungMass::window`](predict::sprung_mass::SprungMass::window) | theta scheme: Moreau (1988), Jean (1999) |
//!
//! # Example
//! A point on the middle of the first quarter of an element moves with both of its nodes:
//!
//! ```
//! use scheme::keys::MappingKind;
//! use scheme::mapping::Mapping;
//! let nodes = [[0.0, 0.0], [1.0, 0.0]];
//! let mapping = Mapping::new(MappingKind::Mortar, &nodes, &[[0.25, 0.0]], None).expect("it lies on the line");
//! assert_eq!(mapping.motion(&[0.0, 0.0, 4.0, 8.0]), [1.0, 2.0]);
//! ```

pub mod error;
pub mod keys;

pub mod acceleration;
pub mod clock;
pub mod compliance;
pub mod coupling;
pub mod criteria;
pub mod dual_schur;
pub mod fixed_point;
pub mod group;
pub mod heat;
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
