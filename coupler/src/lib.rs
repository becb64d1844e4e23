//! The coordinator and coupler of `thirdbody`: it launches solvers, joins them window by window, and records
//! everything that they say to each other.
//!
//! Modules, in reading order:
//! - [`shipped`]: scenes and studies inside the program; [`scenario`]: who takes part, who talks to whom, and how;
//! - [`log`]: the exchange log and its hash;
//! - [`scheme`]: coupling schemes as algorithms, mapping, ledgers, and the prediction of stability;
//! - [`participants`]: starting participants, keeping watch over them, speaking to them;
//! - [`output`]: signals, interface traction, progress; [`rundir`], [`summary`]: the files of a run;
//! - [`cost`]: where the time of a run went, and what its first windows foretell;
//! - [`run`]: the loop over windows, checkpoints, a whole run;
//! - [`replay`]: solvers and coupler again, against the log;
//! - [`validate`]: scenes against what must come out of them;
//! - [`study`]: a run beside a reference, and studies of many; [`report`]: pictures of it; [`bench`](mod@bench): what the machine gives;
//! - [`cli`]: the verbs of the command line;
//! - [`error`]: what can end a run, and the exit code it has.
//!
//! The library knows no solver: the binary hands its [`participants::Registry`] in.
//!
//! # Equations
//!
//! du is the increment of the continuum in a window of length H, lambda the force on it, v_g the velocity of the glued points and
//! F_g the force of the grains there; N takes the motion of nodes to that of points, C is the condensed compliance of the
//! continuum, D its impedance. RSB stands for Renouf, Saulot and Berthier (2006), who ran both scales separately: their equations
//! are those of the solvers.
//!
//! | equation | function | source |
//! |---|---|---|
//! | lambda = N^T F_g, equal places at the end of the window | [`dual_schur::solve`](scheme::dual_schur::solve) | dual Schur complement; subcycling after Gravouil and Combescure (2001) |
//! | a_g = N (du - C lambda) / H | [`Problem::free_velocity`](scheme::problem::Problem::free_velocity) | derived in [`scheme::dual_schur`] |
//! | v_g = a_g + W_g p, W_g = N C N^T / H^2 | [`Compliance::prepare`](scheme::compliance::Compliance::prepare), [`Mapping::condense`](scheme::mapping::Mapping::condense) | derived in [`scheme::dual_schur`] |
//! | C += y y^T / (y.s) - (C s)(C s)^T / (s.C s) | [`Compliance::update`](scheme::compliance::Compliance::update) | Broyden (1970), Fletcher (1970), Goldfarb (1970), Shanno (1970) |
//! | C = H^2 / (2 m sqrt(substeps)) | [`source::mass_only`](scheme::source::mass_only) | stated there |
//! | lambda = lambda_f + D v, equal velocities at the end | [`velocity::solve`](scheme::velocity::solve) | Gravouil and Combescure (2001) |
//! | lambda_k+1 = accelerated(lambda_k, N^T F_g), contraction \|1 - omega (1 + C S)\| | [`fixed_point::solve`](scheme::fixed_point::solve) | Causin, Gerbeau and Nobile (2005); Kuettler and Wall (2008) |
//! | the same with the roles exchanged, v' = v_0 + M_n^-1 (H N^T F_g - H lambda) | [`neumann_dirichlet::solve_fixed_point`](scheme::neumann_dirichlet::solve_fixed_point) | derived in [`scheme::neumann_dirichlet`] |
//! | one pass a window, one window late | [`staggered::solve`](scheme::staggered::solve), [`neumann_dirichlet::solve_staggered`](scheme::neumann_dirichlet::solve_staggered) | shown to fail: Causin, Gerbeau and Nobile (2005) |
//! | omega <- -omega r_old.(r - r_old) / \|r - r_old\|^2; x = x~ + W c | [`Accelerator::next`](scheme::acceleration::Accelerator::next) | Irons and Tuck (1969); Degroote, Bathe and Vierendeels (2009) |
//! | N: mean of the shape functions over a segment, affine correction | [`Mapping::mortar`](scheme::mapping::Mapping::mortar) | mortar; stated there |
//! | M_n = N^T M_p N | [`nodal_mass`](scheme::nodal_mass::nodal_mass) | stated there |
//! | \|N du - H v_g\| <= tolerance | [`criteria::open`](scheme::criteria::open) | stated there |
//! | F_g.(N du - H v_g), the energy that the interface makes or loses | [`InterfaceLedger::add`](scheme::ledger::InterfaceLedger::add) | stated there |
//! | W - dE - D of all sides | [`EnergySums::together`](scheme::ledger::EnergySums::together) | stated there |
//! | rho = lim \|M^k\|^(1/k), M the map of a window | [`growth`](scheme::predict::growth::growth), [`spectral_radius`](scheme::predict::growth::spectral_radius) | Gelfand (1941) |
//! | m_g (v_g - v_g0) = H k (q_1 - q_0) - p, m (v - v_0) = -H k (q_1 - q_0) | [`SprungMass::window`](scheme::predict::sprung_mass::SprungMass::window) | theta scheme: Moreau (1988), Jean (1999) |
//!
//! ```
//! use coupler::scheme::mapping::Mapping;
//! let nodes = [[0.0, 0.0], [1.0, 0.0]];
//! let mapping = Mapping::mortar(&nodes, &[[0.25, 0.0]]).expect("the point lies on the line");
//! assert_eq!(mapping.motion(&[0.0, 0.0, 4.0, 8.0]), [1.0, 2.0]);
//! ```

pub mod bench;
pub mod cli;
pub mod conform;
pub mod cost;
pub mod error;
pub mod log;
pub mod output;
pub mod participants;
pub mod plausible;
pub mod random;
pub mod replay;
pub mod report;
pub mod run;
pub mod rundir;
pub mod scenario;
pub mod scheme;
pub mod shipped;
pub mod study;
pub mod summary;
pub mod validate;
