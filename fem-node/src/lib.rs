//! Bodies of finite elements as participants: plane, elastic or plastic, in motion or in equilibrium, one body for each participant.
//!
//! Keys become a mesh and a [`Model`](model::Model); [`FemNode`] and [`StaticNode`] answer a coupler. The work of a step on each element and node is
//! in [`fem_kernel`], whose first page has the problem, the symbols and the equations.
//!
//! # One window, step by step
//!
//! 1. [`FemNode`] restores the committed state; every repeat of a window begins there.
//! 2. The interface force is added to the loads of the named sets ([`boundary`](model::boundary)), and a is computed anew.
//! 3. For each step [`Integrator::step`](fem_kernel::integrate::integrator::Integrator::step) finds u', F(u') element by element, the
//!    contact forces ([`wheel`](mod@fem_kernel::wheel)), a' and v', and the energies of the step.
//! 4. The answer is the increment of u on the interface. A second run of the same window computes only the part that a changed force can have
//!    reached: each step carries it one ring of elements further.
//! 5. The commit makes the last run the state, adds its energies to the [`Ledger`](output::ledger::Ledger), and reports.
//!
//! Before the first window the coupler may ask for C, or D of a prescribed velocity: [`compliance`](fem_kernel::interface::compliance::compliance())
//! runs one window from rest under each unit force.
//!
//! # Checks
//!
//! - Energy: each term of [`Ledger`](output::ledger::Ledger) has its own formula; no term is the remainder of the others. `energy_balance_rel` is the
//!   difference of work and stored plus dissipated energy, over the work: rounding in small strain, 1e-6 where the body rotates.
//! - Step: a step above the limit is refused with the limit's name. At any step a run has diverged if its kinetic energy exceeds ten times the
//!   supplied energy, or if its points are farther apart than its size. A body that flies far as a whole has not diverged.
//! - Plausibility at the ends of the load's phases: wheel at rest and its height from cycle to cycle, nodes in the contact, its reach,
//!   strains, elements that lock in bending or under plastic flow. Bounds are keys; see the book, `concepts/plausible-results`.
//! - Exact answers: waves, patches, Lame, Hertz with friction, collapse loads, orders of convergence (`tests/verification/fem*.rs`).
//!
//! # Limits
//!
//! Two dimensions, 4-node quadrilaterals, one material per body. The body does not touch itself, and touches another body only through an interface;
//! the wheel is rigid and touches the upper edge only. Large rotations with small stretches, no large strains; plasticity in small strain only. C and
//! D hold for linear elasticity. The share of sliding nodes while the wheel slides depends on the step through (b - 1/2) h; pressure, forces and
//! friction loop hardly do.
//!
//! # Modules
//!
//! In reading order, each folder after the ones that it needs:
//! - [`config`]: the keys of `[participant.config]`;
//! - [`mesh`]: graded structured meshes, and meshes written by Gmsh;
//! - [`model`]: everything that does not change during a run: boundary and initial conditions, the step;
//! - [`output`]: energies, signals, pressures, fields and checks of plausibility;
//! - `interface`: the coupled sets, and the windows between two exchanges;
//! - [`node`]: the body as a participant, in motion, as its modes, or in equilibrium.
//!
//! # Equations, functions, sources
//!
//! Loads and prescribed motions over a window; the table of [`fem_kernel`] has all other equations.
//!
//! | equation | function | source |
//! |---|---|---|
//! | u' = D(t + h) of a prescribed motion | `move_to` of `interface::window::works` | stated in [`motion`](model::motion) |
//! | r = F + d - f of a prescribed motion | `reaction` there | derived in [`boundary`](model::boundary) |
//! | W = [(1-b) f + b f'] du | `applied_work` there | derived in [`integrate`](mod@fem_kernel::integrate) |
//! | (b-1/2) (du dF - b h^2/2 da M da) - (b h^2/4) d(a M a) | `WindowRun::close` of `interface::window` | derived in [`integrate`](mod@fem_kernel::integrate) |
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
//! let mut rail = fem_node::FemNode::new(&kit::read_config(&config)?, &setting)?;
//! let report = rail.advance_alone(&Window { substeps: 10, ..Window::default() })?;
//! assert!(report[0] < 0.0, "the surface sinks");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod config;
pub mod mesh;
pub mod model;
pub mod node;
pub mod output;

mod error;
mod interface;

use kit::schema::schema_of;
use kit::{ConfigError, read_config};
use protocol::{Node, NodeError, Session, Setting};
use serde_json::Value;

use config::choice::Analysis;

pub use config::keys::FemConfig;
pub use error::FemError;
pub use node::fem_node::FemNode;
pub use node::reduced_node::ReducedNode;
pub use node::static_node::StaticNode;

/// Checks the keys of a participant: everything that can be wrong before a run, the mesh and the step included.
/// Returns warnings for the user.
pub fn check(config: &Value, setting: &Setting) -> Result<Vec<String>, ConfigError> {
    let config: FemConfig = read_config(config)?;
    Ok(model::Model::new(&config, setting)?.warnings)
}

/// True for keys of a body that yields.
pub fn nonlinear(config: &Value) -> bool {
    let material = config.get("material");
    let has = |key: &str| material.and_then(|material| material.get(key));
    has("yield_pa").is_some() || has("kind").is_some_and(|kind| kind == "j2")
}

/// The keys of a participant as a JSON Schema, for editors.
pub fn schema() -> Value {
    schema_of::<FemConfig>()
}

/// Builds the participant of a session.
pub fn build(session: &Session) -> Result<Box<dyn Node>, NodeError> {
    let config: FemConfig = read_config(&session.config)?;
    let setting = &session.setting;
    Ok(match (config.analysis, config.reduced) {
        (Analysis::Dynamic, Some(reduced)) => {
            Box::new(ReducedNode::new(&config, reduced, setting)?)
        }
        (Analysis::Dynamic, None) => Box::new(FemNode::new(&config, setting)?),
        (Analysis::Static, _) => Box::new(StaticNode::new(&config, setting)?),
    })
}
