//! Non-Smooth Contact Dynamics of the third body: disks in the plane, walls, a glued base and a rigid wheel.
//!
//! Grains are rigid disks with unilateral contact, Coulomb friction and, if wanted, elastic contacts; steps are implicit
//! (Moreau-Jean). The base of a layer is a row of *glued* disks: a wall that yields to the contact forces as the rail
//! that the coupler speaks for. The crate does not know that rail, nor any other solver.
//!
//! Modules, in reading order:
//! - [`config`]: the keys of a scenario and their limits;
//! - [`sample`]: where the grains come from: listed one by one, or a pressed layer cut to follow a crown;
//! - [`bodies`], [`state`]: what stays and what changes;
//! - [`faces`], [`cluster`]: rigid walls, and grains that move together;
//! - [`bounds`], [`mass_scaling`]: how long a step may be, and what scaled masses cost;
//! - [`geometry`], [`detect`]: how near two bodies are, and who may touch whom;
//! - [`law`], [`cohesion`], [`bond`]: contact laws in closed form, with or without bonds;
//! - [`boundary`], [`wheel`], [`prescribed_opening`]: the glued rows, the wheel's program, and a pair that is prescribed_velocity apart;
//! - [`solver`]: the contact problem and its solvers;
//! - [`repair`]: overlaps of rigid grains, repaired without velocity;
//! - [`mod@step`]: one step of the scheme;
//! - [`ledger`], [`structure`], [`report`], [`snapshot`]: energy, how contacts are arranged, signals and results, fields;
//! - [`interface`]: which glued rows a coupler moves;
//! - [`setup`]: from the keys to the types of the steps;
//! - [`node`]: all of it as a participant of a run;
//! - [`mod@bench`]: what a contact costs, beside what the machine allows.
//!
//! A disk that falls on a floor and stays there:
//!
//! ```
//! use protocol::{Node, Setting, Window};
//! use serde_json::json;
//!
//! let config = protocol::read_config(&json!({
//!     "law": {"kind": "signorini"},
//!     "solver": {"kind": "nsgs", "tolerance": 1e-8, "max_iterations": 100, "min_iterations": 1},
//!     "time": {"step_s": 1e-4, "pressure_pa": 1.0},
//!     "density_kg_per_m3": 7800.0,
//!     "gravity_m_per_s2": [0.0, -9.81],
//!     "sample": {
//!         "kind": "disks",
//!         "disks": [{"x_m": 0.0, "y_m": 2e-3, "radius_m": 1e-3}],
//!         "walls": [{"x_m": 0.0, "y_m": 0.0, "nx": 0.0, "ny": 1.0}]
//!     }
//! }))?;
//! let setting = Setting {
//!     participant: "grains".into(), seed: 1, thickness_m: 1e-3, threads: 1, fields: None,
//! };
//! let mut grains = dem_node::Dem::new(&config, &setting)?;
//! grains.advance_alone(&Window { substeps: 1000, ..Window::default() })?;
//! let height = grains.state().centres[0][1];
//! assert!((height - 1e-3).abs() < 1e-12);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod bench;
pub mod bodies;
pub mod bond;
pub mod boundary;
pub mod bounds;
pub mod cluster;
pub mod cohesion;
pub mod config;
pub mod detect;
pub mod error;
pub mod faces;
pub mod geometry;
pub mod initial_bonds;
pub mod interface;
mod lanes;
pub mod law;
pub mod ledger;
pub mod mass_scaling;
pub mod node;
pub mod positions;
pub mod prescribed_opening;
pub mod repair;
pub mod report;
pub mod sample;
pub mod setup;
pub mod snapshot;
pub mod solver;
pub mod state;
pub mod step;
pub mod structure;
mod threads;
pub mod wheel;

use protocol::{ConfigError, Node, NodeError, Session, Setting};

pub use config::Config;
pub use error::DemError;
pub use node::Dem;

/// Checks the participant's keys without preparing its sample. Returns what the user should know before a long run.
pub fn check(config: &serde_json::Value, setting: &Setting) -> Result<Vec<String>, ConfigError> {
    let config: Config = protocol::read_config(config)?;
    config.validate()?;
    check_setting(setting)?;
    match config.time.step_s {
        None => Ok(Vec::new()),
        Some(step) => bounds::Bounds::new(&config)
            .assess(step)
            .map_err(|error| ConfigError::new("time.step_s", error.to_string())),
    }
}

/// Builds the participant of a session: reads its keys and prepares its sample.
pub fn build(session: &Session) -> Result<Box<dyn Node>, NodeError> {
    let config: Config = protocol::read_config(&session.config)?;
    check_setting(&session.setting)?;
    Ok(Box::new(Dem::new(&config, &session.setting)?))
}

fn check_setting(setting: &Setting) -> Result<(), ConfigError> {
    if setting.thickness_m > 0.0 && setting.thickness_m.is_finite() {
        return Ok(());
    }
    Err(ConfigError::new(
        "run.thickness_m",
        format!("must be positive, got {:e} (m)", setting.thickness_m),
    ))
}
