//! Non-Smooth Contact Dynamics of the third body: disks in the plane, walls, a glued base, bare surfaces and a rigid wheel.
//!
//! Grains are rigid disks. [`dem_kernel`] solves their contacts and makes their steps; its first page has problem, symbols and equations. This crate
//! reads the keys of a scenario, prepares samples, measures, and takes part in a run. The base of a layer is a row of *glued* disks on a *compliant
//! boundary*, which yields to contact forces like the rail that the coupler represents. The crate does not know that rail, nor any other solver.
//!
//! # The step's length
//!
//! An unbalanced grain crosses its diameter in the inertial time t_i = d sqrt(rho/P) ([`StepBounds::inertial_time`]): d is the mean
//! diameter, rho the scaled density, P `time.pressure_pa`. Up to 0.05 t_i forces are clean. Longer steps get a warning, steps above t_i are refused
//! ([`setup::bounds`]). At 1 GPa and the density of steel t_i is some 4e-7 s. Grains of the shipped scenes are therefore a thousand times as heavy as
//! real ones; [`setup::mass_scaling`] has the price. Loads and the wheel's mass are never scaled.
//!
//! # Checks
//!
//! - The natural-map residual of each step, an error above `solver.tolerance`, never a silent pass: a solve of few sweeps gives garbage while the
//!   interface still has a gap of zero.
//! - Masses of third body at each step: in the zone = detached - re-attached + fed + entered - left ([`measure::flow`]).
//! - Plausibility: travel of grains in a step, walls met from behind, grains behind a surface, overlaps, lost grains, wheel at rest, forces above
//!   against below, inertia of scaled masses.
//! - Exact answers: impacts, slopes, columns, pyramids, chains, bonds; published ones for packings and plane shear (`tests/verification/dem*.rs`).
//!
//! # Limits
//!
//! Disks do not deform: overlaps beyond 0.3 of a radius get a warning. Pressures of single grains and of rough faces vary with the seed; means over
//! many grains vary less.
//!
//! # Modules
//!
//! In reading order, each with a list of its own:
//! - [`config`]: the keys of a scenario and their limits;
//! - [`sample`]: grains listed one by one, a pressed layer cut to follow a crown, or a rail of grains;
//! - [`setup`]: from the keys to the types of the steps, the wheel's program, bounds on the step;
//! - [`measure`]: stress, flows of third body, forces on named bodies, signals, results and fields;
//! - [`node`]: the crate as a participant of a run, which answers F_g = p/h, v_g, iterations and residual, and commits only what the coupler accepts;
//! - [`error`]: reasons for which it cannot go on.
//!
//! # Equations, functions, sources
//!
//! The equations of laws, contacts, solvers and steps are in [`dem_kernel`], which also spells out RSB.
//!
//! | equation | function | source |
//! |---|---|---|
//! | pressure in a grain, trace of sum f (x_c - x) / V | [`measure::snapshot::pressures`] | Love 1927; Weber 1966 |
//! | stress of cells, -(1/V) sum f (x_c - x) | [`measure::stress::StressMap::measure`] | Love 1927; Weber 1966; Moreau 1997 |
//! | the part of a grain in a cell, by its tile | [`measure::tiles::tiles`] | Bagi 1996 |
//! | fabric, mean of n (x) n | [`measure::structure::results`] | Satake 1982 |
//! | wheel D(t) = A sin(2 pi f (t - t_s)) | [`kit::wheel::WheelProgram::displacement_at`] | RSB, section 6 |
//! | inertial time t_i = d sqrt(rho/P), bounds on the window | [`setup::bounds::StepBounds::new`], [`setup::bounds::StepBounds::assess`] | GDR MiDi 2004 |
//! | mass scaling: inertial number, inertial pressure | [`setup::mass_scaling::MassScaling::new`] | GDR MiDi 2004 |
//! | radii, p ~ r^-2 and others | [`config::radii::Radii::at`] | LMGC90 (granulometry) |
//!
//! # Example
//! A disk that falls on a floor and stays there:
//!
//! ```
//! use protocol::{Node, Setting, Window};
//! use serde_json::json;
//!
//! let config = kit::read_config(&json!({
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
//!     participant: "grains".into(), seed: 1, thickness_m: 1e-3, threads: 1, fields: None, cache: None,
//! };
//! let mut grains = dem_node::Dem::new(&config, &setting)?;
//! grains.advance_alone(&Window { substeps: 1000, ..Window::default() })?;
//! let height = grains.state().centres[0][1];
//! assert!((height - 1e-3).abs() < 1e-12);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod config;
pub mod error;
pub mod measure;
pub mod node;
pub mod sample;
pub mod setup;

use kit::ConfigError;
use protocol::{Node, NodeError, Session, Setting};

use config::sample::SampleConfig;
use setup::bounds::StepBounds;
use setup::mass_scaling;

pub use config::DemConfig;
pub use error::DemError;
pub use node::dem::Dem;

/// Checks the participant's keys without preparing its sample. Returns advice for the user before a long run.
pub fn check(config: &serde_json::Value, setting: &Setting) -> Result<Vec<String>, ConfigError> {
    let config: DemConfig = kit::read_config(config)?;
    let config = config.resolved()?;
    config.validate()?;
    check_setting(setting)?;
    config.validate_feed(setting.thickness_m)?;
    let mut advice = match config.time.step_s {
        None => Vec::new(),
        Some(step) => StepBounds::new(&config).assess(step).map_err(|error| {
            ConfigError::new("time.step_s", error.to_string()).because(error.cause())
        })?,
    };
    advice.extend(mass_scaling::advice(&config, setting.thickness_m));
    advice.extend(mass_scaling::advice_on_flow(&config));
    advice.extend(mass_scaling::advice_on_flight(&config));
    if let SampleConfig::Layer(layer) = &config.sample {
        advice.extend(layer.advice(config.law.contact_stiffness_pa));
    }
    Ok(advice)
}

/// The keys of a participant as a JSON Schema, for editors.
pub fn schema() -> serde_json::Value {
    kit::schema::schema_of::<DemConfig>()
}

/// Builds the participant of a session: reads its keys and prepares its sample.
pub fn build(session: &Session) -> Result<Box<dyn Node>, NodeError> {
    let config: DemConfig = kit::read_config(&session.config)?;
    check_setting(&session.setting)?;
    Ok(Box::new(Dem::new(&config, &session.setting)?))
}

fn check_setting(setting: &Setting) -> Result<(), ConfigError> {
    kit::limits::positive("run.thickness_m", setting.thickness_m, "m")
}
