//! Finite elements of plane bodies: internal forces, explicit steps, contact with a rigid wheel, equilibrium.
//!
//! The crate computes with plain numbers and fields. It knows no keys of a scenario and no coupler; `fem-node` makes it a participant.
//!
//! # Problem
//!
//! A plane body of thickness t (plane strain, or plane stress) moves under loads and prescribed motions of named sets of nodes (over
//! time, to and fro), under a rigid wheel of its own, or under the force lambda of an interface that a coupler prescribes. Its weak form on 4-node
//! quadrilaterals is the equation of motion
//!
//! ```text
//! M u'' + C_d u' + F(u) = f + lambda + H r    Renouf, Saulot, Berthier (2006), eqs 1-5
//! ```
//!
//! The paper's rail, 65 mm wide and 20 mm high with a crown of 300 mm, clamped at its base, is `scenarios/wheel-rail-fe`.
//! The unknowns are the nodal displacements over time and, with a wheel, the contact forces r and the wheel's height.
//!
//! # Symbols
//!
//! All values are SI; r is a force here, and an impulse in `dem-node`.
//!
//! | symbol | meaning | unit | in the code |
//! |---|---|---|---|
//! | u, v, a | displacement, velocity, acceleration of the nodes, x and y components | m, m/s, m/s2 | [`NodalState`](integrate::state::NodalState) |
//! | F, f | internal force; applied forces, the interface's included | N | [`NodalState::force`](integrate::state::NodalState::force), [`Load`](integrate::load::Load) |
//! | M | lumped masses | kg | [`Body::mass`](element::body::Body::mass) |
//! | h, H | step; window of m steps, H = m h (in H r: the directions of the contacts, H* its transpose) | s | [`NewmarkScheme::step`](scheme::NewmarkScheme::step), [`Window::substeps`](protocol::Window::substeps) |
//! | b | damping parameter of the scheme, 1/2 to 1 (the paper's beta) | - | [`NewmarkScheme::damping`](scheme::NewmarkScheme::damping), key `time.damping` |
//! | c, beta | damping in proportion to the mass, to the stiffness | 1/s, s | keys `time.mass_damping_per_s`, `time.stiffness_damping_s` |
//! | omega | natural frequency | 1/s | [`omega_max`](spectrum::omega_max) |
//! | t | thickness | m | [`Setting::thickness_m`](protocol::Setting::thickness_m) |
//! | e, s | strain and stress | -, Pa | [`Elastic::stress`](material::Elastic::stress) |
//! | Y, H, K | yield stress, isotropic and kinematic hardening (of [`material::j2`] only) | Pa | [`J2`](material::j2::J2) |
//! | r_n, r_t | normal and tangential contact force of a node, r_n > 0 in compression | N | [`NodeContact`](wheel::node_contact::NodeContact) |
//! | g, mu | gap to the wheel, g > 0 where it is open; coefficient of friction | m, - | `wheel::problem`, key `contact.friction` |
//! | lambda, C, D | interface force; compliance and impedance of the interface over a window | N, m/N, kg/s | `compliance` |
//!
//! # Time
//!
//! Newmark's scheme (1959) with beta_N = 0 and gamma = b, explicit and of a diagonal mass. A window begins with the acceleration under
//! its own forces, then m steps follow; the derivation of everything below is in [`mod@integrate`].
//!
//! ```text
//! a  = M^-1 (f - F(u) - c M v)       once, at the start of the window
//! u' = u + h v + h^2/2 a             RSB eq 12, corrected and regrouped
//! a' = M^-1 (f' - F(u') - c M v')    v' eliminated, since M is diagonal
//! v' = v + h [(1-b) a + b a']
//! h  < sqrt(2/b) / omega_max         1 + trace + det = 0 of the map of one mode
//! ```
//!
//! The grouping matters: a force that begins at t_n acts from t_n on. With the paper's shift by half a step, the compliance of a window under a
//! constant force can be negative, and a coupling grows. b = 1/2 keeps the energy; above it a mode is damped by about (b - 1/2) omega h / 2 of
//! critical.
//!
//! # Space and material
//!
//! Masses are lumped by rows. Internal forces come from one of three elements: one point with hourglass stiffness (fast,
//! [`q4_1point`](element::q4_1point)), 2 x 2 points ([`q4_2x2`](element::q4_2x2)), or 2 x 2 points with one mean dilatation
//! ([`q4_bbar`](element::q4_bbar)), for plastic flow. The material is linear in small strain, linear in the stretch of a rotated frame
//! ([`material::nonlinear`]), or von Mises with linear hardening and an exact return ([`material::j2`]).
//!
//! ```text
//! f = sum over points of t J B^T s    virtual work
//! s = L tr(e) 1 + 2 G e               Hooke, plane strain; Lame's L and G, c11 = L + 2 G
//! p = -(sxx + syy + szz) / 3          pressure of all results, compression positive
//! ```
//!
//! # Contact with the wheel
//!
//! The contact forces at t_n leave no overlap at t_n+1: they are the forward increment Lagrange multipliers of Carpenter, Taylor and Katona (1991),
//! the paper's eqs 11 to 15, with one factor corrected ([`mod@wheel`]).
//!
//! ```text
//! u_free = u' + h v_free + h^2/2 a_free     v_free, a_free: without contact forces
//! w = h^2 (b + 1/2) M^-1 / (1 + b h c)      displacement until t_n+1 by a unit force
//! g(u_free) + (H* w H) r >= 0,  r_n >= 0    complementary
//! |r_t| <= mu r_n                           opposed to the slip from t_n to t_n+1
//! ```
//!
//! Under a flat face this is a monotone equation in one unknown, the total normal force; under a round face Gauss-Seidel sweeps over the nodes' 2 x 2
//! blocks solve it.
//!
//! # Equilibrium
//!
//! `analysis = "static"`, and `start = "static"` of dynamics, solve K u = f + H r by a sparse Cholesky factor that is condensed to the
//! upper edge, with an active set for contact and friction, in small increments of the load ([`statics`]). The increments do not serve convergence:
//! friction depends on the path. A single increment gives another pressure, 646 MPa instead of 671.
//!
//! # Modules
//!
//! In reading order, each folder after the ones that it needs:
//! - [`pack`]: packs of four doubles, which the compiler turns into vector code;
//! - [`mesh`]: structured and unstructured meshes of quadrilaterals;
//! - [`material`]: linear elasticity in the plane, plasticity, large rotations;
//! - [`element`]: the discretised body, its masses and internal forces;
//! - [`spectrum`]: the largest natural frequency, and the longest stable step;
//! - [`scheme`]: the parameters of the time scheme, which body and wheel share;
//! - [`wheel`]: the body's own rigid wheel and the contact with it;
//! - [`mod@integrate`]: a step of the body with its wheel, and the energies;
//! - [`interface`]: prescribed velocities of exchanged components, their compliance and impedance;
//! - [`statics`]: equilibrium, alone or as the start of dynamics;
//! - [`reduced`]: a body as its lowest modes and its static flexibility;
//! - [`error`]: failures of a step and of an equilibrium.
//!
//! # Equations, functions, sources
//!
//! h is the step, b the damping parameter, c the mass damping, beta the stiffness damping, F the internal force, f the applied force; a prime marks
//! the end of a step. RSB stands for Renouf, Saulot and Berthier (2006), whose eqs 1 to 5 are the equation of motion M u'' + F = f + H r solved here.
//!
//! | equation | function | source |
//! |---|---|---|
//! | u' = u + h v + h^2/2 a | [`NewmarkScheme::predicted`](scheme::NewmarkScheme::predicted) | Newmark (1959), beta = 0; RSB eq 12, corrected |
//! | a' = p - c (v + h [(1-b) a + b p]) / (1 + b h c), p = M^-1 (f' - F') | [`NodeRow::accelerate`](integrate::node_row::NodeRow::accelerate) | the same, gamma = b |
//! | v' = v + h [(1-b) a + b a'] | [`NodeRow::new_velocity`](integrate::node_row::NodeRow::new_velocity) | the same |
//! | d' = (beta/h) (F' - F) | [`NodeRow::damp_stiffness`](integrate::node_row::NodeRow::damp_stiffness) | Rayleigh (1877), section 102 |
//! | h < sqrt(2/b)/omega_max | [`step_limit`](spectrum::step_limit) | spectral radius, stated there |
//! | h < (sqrt(2/b + 4 xi^2) - 2 xi)/omega_max | [`step_limit`](spectrum::step_limit) | Belytschko, Liu and Moran (2000), section 6.2 |
//! | K phi = omega^2 M phi, the largest omega | [`omega_max`](spectrum::omega_max) | Lanczos (1950); Parlett (1980), ch. 13 |
//! | m_a = sum of rho t A/4 | [`lump`](element::body::lump) | row-sum lumping |
//! | f = t A B^T s + G Q, one point and hourglass stiffness | [`Q4OnePoint`](element::q4_1point::Q4OnePoint) | Flanagan and Belytschko (1981) |
//! | f = sum of t J B^T s over 2 x 2 points | [`integrate`](element::gauss::integrate) | Gauss quadrature |
//! | s = D e + k (E - e) 1, one mean dilatation E | [`add_mean_pressure`](element::q4_bbar::add_mean_pressure) | Hughes (1980) |
//! | s = D e | [`Elastic::stress`](material::Elastic::stress), by packs [`hooke`](material::nonlinear::hooke) | Hooke |
//! | g = (\|x_trial\| - sqrt(2/3) (Y + H a)) / (2 mu + 2/3 (H + K)) | [`J2::return_map`](material::j2::J2::return_map) | Simo and Hughes (1998), section 3.3 |
//! | E = U - 1, 1 + grad u = R U | [`stretch`](material::nonlinear::stretch) | Biot (1965); Ogden (1984), section 6.1.4 |
//! | u_free = u' + h v' + h^2/2 a', w = h^2 (b + 1/2)/(1 + b h c) | [`Newmark::next`](wheel::newmark::Newmark::next), [`Newmark::weight`](wheel::newmark::Newmark::weight) | Carpenter, Taylor and Katona (1991); RSB eqs 11 to 15, corrected |
//! | r_n = max(0, r_n*), r_t = r_t* clipped to +-mu r_n | [`admissible`](wheel::coulomb::admissible) | Signorini (1933), Coulomb (1785) |
//! | S = sum max(0, -(g_i + W_w S)/W_i) | [`total`](wheel::flat::total) | RSB eqs 11 to 15 for a flat face |
//! | W (r_n, r_t) = (-gap, slip) | [`LocalProblem::closed`](wheel::round::LocalProblem::closed) | Jourdan, Alart and Jean (1998) |
//! | g_i = 0, slip_i = 0 or r_t = +-mu r_n, sum of r_y = load | [`System::new`](statics::active_set::System::new) | Hueeber, Stadler and Wohlmuth (2008) |
//! | K u = f, K = L L^T | [`Factor::solve`](statics::factor::Factor::solve) | Cholesky |
//! | K phi = omega^2 M phi, the lowest omega | [`Modes::lowest`](reduced::modes::Modes::lowest) | Golub and Underwood (1977) |
//! | u = Phi eta + F_res f - C_far (f - f_prev) | [`ReducedSurface::commit`](reduced::surface::ReducedSurface::commit) | MacNeal (1971); derived in [`reduced`] |
//! | C(1) = h^2/2 M^-1, columns of unit forces | [`compliance`](interface::compliance::compliance) | stated there |
//! | H D = M_i + H^2/2 K_i + sum L L^T (1 - cos(omega H)) | [`impedance`](interface::compliance::impedance) | stated there |
//! | f' = M (1 + b h c) (a_s - a_0') | [`PrescribedVelocity::step`](interface::prescribed_velocity::PrescribedVelocity::step) | derived in its module |
//! | (b-1/2) (du dF - b h^2/2 da M da) - (b h^2/4) d(a M a) | [`NodeRow::numerical_dissipation`](integrate::node_row::NodeRow::numerical_dissipation) | derived in [`integrate`](mod@integrate) |
//! | [(1-b) c v + b c' v'] M du | [`NodeRow::mass_damping`](integrate::node_row::NodeRow::mass_damping) | derived in [`integrate`](mod@integrate) |
//! | energies of wheel and contact | [`WheelRun::add_energies`](wheel::run::WheelRun::add_energies) | derived in [`integrate`](mod@integrate) |
//!
//! # Example
//! ```
//! use fem_kernel::element::body::{Body, ElementKind};
//! use fem_kernel::integrate::{dissipation::Mechanisms, fields::StepFields, integrator::Integrator};
//! use fem_kernel::material::Elastic;
//! use fem_kernel::mesh::{Edge, Mesh};
//! use fem_kernel::scheme::NewmarkScheme;
//! use fem_kernel::spectrum::{omega_max, step_limit};
//!
//! let mesh = Mesh::structured(4, 2, |i, j| [1e-3 * i as f64, -1e-3 * j as f64]);
//! let steel = Elastic::plane_strain(210e9, 0.3, 7800.0);
//! let mut body = Body::new(&mesh, ElementKind::Q4OnePoint, &steel, 1e-3);
//! let (layout, bottom) = (body.layout, mesh.edge(Edge::Bottom).into_iter());
//! body.fix(bottom.flat_map(|node| [0, 1].map(|k| layout.index(node, k))));
//!
//! let step = 0.9 * step_limit(omega_max(&body), 0.75, 0.0);
//! let scheme = NewmarkScheme { step, damping: 0.75, mass_damping: 0.0, stiffness_damping: 0.0 };
//! let mut integrator = Integrator::new(&body, scheme, None, 1);
//! let mut fields = StepFields::at_rest(&body, None, Mechanisms::default());
//! let loaded = layout.index([2, 0], 1);
//! fields.load.add(loaded, -1.0);
//! fields.accelerate(&body, 0.0);
//! for _ in 0..10 {
//!     integrator.step(&body, &mut fields, [0, layout.node_rows], None);
//! }
//! assert!(fields.state.u[loaded] < 0.0, "the loaded node sinks");
//! ```

#![allow(
    rustdoc::private_intra_doc_links,
    reason = "the table of equations names private functions; they are linked in docs with private items"
)]

pub mod element;
pub mod error;
pub mod heat;
pub mod integrate;
pub mod interface;
pub mod material;
pub mod mesh;
pub mod pack;
pub mod reduced;
pub mod scheme;
pub mod spectrum;
pub mod statics;
pub mod wheel;
