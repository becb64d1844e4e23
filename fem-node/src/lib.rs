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
//! ```
//! use protocol::{Node, Setting, Window};
//! let config = serde_json::json!({
//!     "mesh": {"width_m": 4e-3, "height_m": 2e-3, "size_m": 1e-3},
//!     "material": {"young_pa": 102.5e9, "poisson": 0.3, "density_kg_per_m3": 7800.0},
//!     "time": {"step_s": "auto", "damping": 0.75},
//!     "boundary": {"top": {"traction_pa": [0.0, -1e6]}},
//! });
//! let setting = Setting { participant: "rail".into(), seed: 0, thickness_m: 1e-3, threads: 1, fields: None };
//! let mut rail = fem_node::FemNode::new(&protocol::read_config(&config)?, &setting)?;
//! let report = rail.advance_alone(&Window { substeps: 10, ..Window::default() })?;
//! assert!(report[0] < 0.0, "the surface sinks");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

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
mod interface;
mod pack;
mod prescribed_velocity;
mod snapshot;
mod vtu;
mod window;

use protocol::{ConfigError, Node, NodeError, Session, Setting, read_config};
use serde_json::Value;

use config::Analysis;

pub use config::Config;
pub use error::FemError;
pub use node::FemNode;
pub use statics::StaticNode;

/// Judges the keys of a participant: everything that can be wrong before a run, the mesh and the step included.
/// Returns what the user should know all the same.
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
