//! Explicit finite-element dynamics of the first bodies: plane, elastic or plastic, one body for each participant.
//!
//! Modules, in reading order:
//! - [`config`]: the keys of `[participant.config]`;
//! - [`mesh`]: graded structured meshes;
//! - [`gmsh`]: meshes that Gmsh wrote;
//! - [`material`]: linear elasticity in the plane, plasticity, large rotations;
//! - [`element`]: the discretised body, masses, supports and internal forces;
//! - [`boundary`]: loads and prescribed motions of named sets;
//! - [`spectrum`]: the largest frequency and the longest stable step;
//! - [`integrate`]: the time scheme and the energies that a step moves;
//! - [`wheel`]: the body's own rigid wheel and the contact with it;
//! - [`model`]: everything that does not change during a run;
//! - [`statics`]: equilibrium, alone or as the start of dynamics;
//! - [`ledger`]: the energies that are reported;
//! - [`probe`]: signals, stresses and pressures;
//! - [`profile`]: the pressure between wheel and body;
//! - [`node`]: the body as a participant, with its windows, interface and compliance;
//! - [`mod@bench`]: time of whole steps beside what memory and arithmetic allow.
//!
//! # Equations
//!
//! h is the step, b the damping parameter, c the mass damping, beta the stiffness damping, F the internal force, f the
//! applied ones; a prime marks the end of a step. RSB stands for Renouf, Saulot and Berthier (2006), whose eqs 1 to 5 are
//! the equation of motion M u'' + F = f + H r that all of this solves.
//!
//! | equation | function | source |
//! |---|---|---|
//! | u' = u + h v + h^2/2 a | [`Scheme::predicted`](integrate::Scheme::predicted) | Newmark (1959), beta = 0; RSB eq 12, corrected |
//! | a' = p - c (v + h [(1-b) a + b p]) / (1 + b h c), p = M^-1 (f' - F') | [`NodeRow::accelerate`](integrate::node_row::NodeRow::accelerate) | the same, gamma = b |
//! | v' = v + h [(1-b) a + b a'] | [`NodeRow::new_velocity`](integrate::node_row::NodeRow::new_velocity) | the same |
//! | d' = (beta/h) (F' - F) | [`NodeRow::damp_stiffness`](integrate::node_row::NodeRow::damp_stiffness) | Rayleigh (1877), section 102 |
//! | h < sqrt(2/b)/omega_max | [`step_limit`](spectrum::step_limit) | spectral radius, stated there |
//! | h < (sqrt(2/b + 4 xi^2) - 2 xi)/omega_max | [`damped_step_limit`](spectrum::damped_step_limit) | Belytschko, Liu and Moran (2000), section 6.2 |
//! | K phi = omega^2 M phi, the largest omega | [`omega_max`](spectrum::omega_max) | Lanczos (1950); Parlett (1980), ch. 13 |
//! | m_a = sum of rho t A/4 | [`lump`](element::body::lump) | row-sum lumping |
//! | f = t A B^T s + G Q, one point and hourglass stiffness | [`Q4OnePoint`](element::q4_1point::Q4OnePoint) | Flanagan and Belytschko (1981) |
//! | f = sum of t J B^T s over 2 x 2 points | [`integrate`](element::q4_2x2::integrate) | Gauss quadrature |
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
//! | C(1) = h^2/2 M^-1, columns of unit forces | [`compliance`](compliance::compliance) | stated there |
//! | H D = M_i + H^2/2 K_i + sum L L^T (1 - cos(omega H)) | [`impedance`](compliance::impedance) | stated there |
//! | f' = M (1 + b h c) (a_s - a_0') | [`PrescribedVelocity::step`](prescribed_velocity::PrescribedVelocity::step) | derived in its module |
//! | r = F + d - f of a prescribed motion | [`reaction`](window::works::reaction) | derived in [`boundary`] |
//! | W = [(1-b) f + b f'] du | [`applied_work`](window::works::applied_work) | derived in [`integrate`](mod@integrate) |
//! | (b-1/2) (du dF - b h^2/2 da M da) - (b h^2/4) d(a M a) | [`NodeRow::numerical_dissipation`](integrate::node_row::NodeRow::numerical_dissipation), [`WindowRun::close`](window::WindowRun::close) | derived in [`integrate`](mod@integrate) |
//! | [(1-b) c v + b c' v'] M du | [`NodeRow::mass_damping`](integrate::node_row::NodeRow::mass_damping) | derived in [`integrate`](mod@integrate) |
//! | energies of wheel and contact | [`WheelRun::add_energies`](wheel::run::WheelRun::add_energies) | derived in [`integrate`](mod@integrate) |
//!
//! # Example
//! ```
//! use protocol::{Node, Setting, Window};
//! let config = serde_json::json!({
//!     "mesh": {"width_m": 4e-3, "height_m": 2e-3, "size_m": 1e-3},
//!     "material": {"young_pa": 102.5e9, "poisson": 0.3, "density_kg_per_m3": 7800.0},
//!     "time": {"step_s": "auto", "damping": 0.75},
//!     "boundary": {"top": {"traction_pa": [0.0, -1e6]}},
//! });
//! let setting = Setting { participant: "rail".into(), seed: 0, thickness_m: 1e-3, threads: 1, fields: None, cache: None };
//! let mut rail = fem_node::FemNode::new(&protocol::read_config(&config)?, &setting)?;
//! let report = rail.advance_alone(&Window { substeps: 10, ..Window::default() })?;
//! assert!(report[0] < 0.0, "the surface sinks");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

#![allow(
    rustdoc::private_intra_doc_links,
    reason = "the table of equations names private functions; they are linked in docs with private items"
)]

pub mod bench;
pub mod boundary;
pub mod config;
pub mod element;
pub mod gmsh;
pub mod integrate;
pub mod ledger;
pub mod material;
pub mod mesh;
pub mod model;
pub mod node;
pub mod probe;
pub mod profile;
pub mod spectrum;
pub mod statics;
pub mod wheel;

mod committed;
mod compliance;
mod error;
mod initial;
mod interface;
mod pack;
mod plausible;
mod prescribed_velocity;
mod probe_points;
mod snapshot;
mod vtk;
mod vtu;
mod window;

use protocol::{ConfigError, Node, NodeError, Session, Setting, read_config};
use serde_json::Value;

use config::Analysis;

pub use config::Config;
pub use error::FemError;
pub use node::FemNode;
pub use statics::StaticNode;

/// Checks the keys of a participant: everything that can be wrong before a run, the mesh and the step included.
/// Returns warnings for the user.
pub fn check(config: &Value, setting: &Setting) -> Result<Vec<String>, ConfigError> {
    let config: Config = read_config(config)?;
    Ok(model::Model::new(&config, setting)?.warnings)
}

/// Builds the participant of a session.
pub fn build(session: &Session) -> Result<Box<dyn Node>, NodeError> {
    let config: Config = read_config(&session.config)?;
    Ok(match config.analysis {
        Analysis::Dynamic => Box::new(FemNode::new(&config, &session.setting)?),
        Analysis::Static => Box::new(StaticNode::new(&config, &session.setting)?),
    })
}
