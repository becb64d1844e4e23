//! Non-Smooth Contact Dynamics of the third body: disks in the plane, walls, a glued base and a rigid wheel.
//!
//! Grains are rigid disks with unilateral contact, Coulomb friction and, if wanted, elastic contacts; steps are implicit
//! (Moreau-Jean). The base of a layer is a row of *glued* disks on a *compliant boundary*, which yields to the contact forces
//! as the rail that the coupler speaks for. The crate does not know that rail, nor any other solver.
//!
//! Modules, in reading order:
//! - [`config`]: the keys of a scenario and their limits;
//! - [`geometry`]: normals and gaps of two bodies;
//! - [`faces`], [`cluster`]: rigid walls, and grains that move together;
//! - [`cohesion`], [`law`]: the contact laws, in closed form ([`law::local`]) and side by side ([`law::vector`]);
//! - [`sample`]: grains listed one by one, a pressed layer cut to follow a crown, or a rail of grains;
//! - [`prepared`]: samples that are kept for later runs;
//! - [`bodies`], [`positions`]: the bodies, and their positions at a moment;
//! - [`wheel`], [`bounds`], [`mass_scaling`]: the wheel's program, bounds on the step, and the price of scaled masses;
//! - [`detect`], [`bond`], [`initial_bonds`]: pairs that may touch, and bonds between grains;
//! - [`boundary`]: the compliant boundary of the glued disks;
//! - [`solver`]: the contact problem and its solvers;
//! - [`ledger`], [`state`]: the energy balance, and the state that is committed;
//! - [`prescribed_opening`]: a pair that is pulled apart;
//! - [`repair`]: overlaps of rigid grains, repaired without velocity;
//! - [`mod@step`]: one step of the scheme;
//! - [`loads`], [`stress`]: forces of the contacts grain by grain, and the stress that they make;
//! - [`flow`]: flows of third body, from the graph of bonds;
//! - [`structure`], [`report`], [`snapshot`]: arrangement of the contacts, signals and results, fields;
//! - [`interface`]: the glued rows that a coupler moves;
//! - [`setup`]: from the keys to the types of the steps;
//! - [`node`]: all of it as a participant of a run;
//! - [`mod@bench`]: the cost of a contact, beside the least that the machine allows.
//!
//! # Equations
//!
//! RSB is Renouf, Saulot and Berthier, *Third-body flow during wheel-rail interaction*, 2006; its equations 11 to 17 belong
//! to the continuum.
//!
//! | equation | function | source |
//! |---|---|---|
//! | relative velocity u = H^T v, and v += M^-1 H r | [`solver::Problem::relative_velocity`], [`solver::Problem::apply`] | RSB (1)-(5); Jean 1999 |
//! | theta scheme q_m = q + h (1 - theta) v, q' = q_m + h theta v' | [`step::Stepper::advance`], [`state::State::drift`] | RSB (7); Moreau 1988; Jean 1999 |
//! | v_free = v + h M^-1 F | [`step::Stepper::free_records`] | RSB (7) |
//! | Delassus operator W = H^T M^-1 H, block of a contact | [`solver::Problem::block`] | RSB (8); Jean 1999 |
//! | local problem b = u + bias - W r, U = b + W r | [`solver::Problem::local_solution`] | RSB (8); Jean 1999 |
//! | Signorini and Coulomb: open, stick or slide | [`law::local::LocalLaw::impulse`] | Jean 1999 |
//! | the same for several contacts, W_nt = 0 | [`law::vector::normal_impulse`], [`law::vector::tangential_impulse`] | Jean 1999 |
//! | projection on the Coulomb sector | [`law::local::coulomb_projection`] | Alart and Curnier 1991 |
//! | natural-map residual | [`solver::residual`] | Alart and Curnier 1991 |
//! | block non-linear Gauss-Seidel, its criterion | [`solver::nsgs::solve`], [`solver::Quad`] | RSB (8); Jourdan, Alart and Jean 1998; Jean 1999 |
//! | projected conjugate gradient (CPG) | [`solver::pcg::solve`] | Renouf and Alart 2005 |
//! | springs: U += g/h, W += 1/(k h^2) | [`law::Law::compliance`], [`law::Law::bias`] | LMGC90 (elastic repel) |
//! | gap and IQS, restitution U = u_n + e u_n(t_i) | [`law::Law::bias`] | Moreau 1988; LMGC90 |
//! | split impulse and projection of positions | [`repair::Repair::make`] | [`repair`] |
//! | cohesive zone: adhesion a' = -((w h' - a D)^- / b)^(1/p) | [`cohesion::Cohesion::adhesion_after`] | RSB (9)-(10), signs corrected; Raous, Cangemi and Cocou 1999 |
//! | cohesive force r_n = -kappa_n U, kappa = h^2 l C a^2 | [`law::local::BondLaw::impulse`] | RSB (9)-(10); Raous, Cangemi and Cocou 1999 |
//! | unique end of a step with bonds, h < 1/(sqrt(3) omega) | [`bond::step_limit`] | [`bond`] |
//! | compliant boundary v_g = a_g + W_g p | [`boundary::CompliantBoundary::evaluate`] | Gravouil and Combescure 2001 |
//! | energy lost by a contact, by a bond | [`ledger::contact_loss`], [`bond::end_step`] | [`ledger`] |
//! | energy stored: kinetic, springs, bonds | [`state::State::energies`] | [`ledger`] |
//! | pressure in a grain, trace of sum f (x_c - x) / V | [`snapshot::pressures`] | Love 1927; Weber 1966 |
//! | stress of cells, -(1/V) sum f (x_c - x) | [`stress::StressMap::measure`] | Love 1927; Weber 1966; Moreau 1997 |
//! | fabric, mean of n (x) n | [`structure::results`] | Satake 1982 |
//! | wheel D(t) = A sin(2 pi f (t - t_s)) | [`wheel::WheelProgram::displacement_at`] | RSB, section 6 |
//! | inertial time t_i = d sqrt(rho/P), bounds on the window | [`bounds::Bounds::new`], [`bounds::Bounds::assess`] | GDR MiDi 2004 |
//! | mass scaling: inertial number, inertial pressure | [`mass_scaling::MassScaling::new`] | GDR MiDi 2004 |
//! | fed grains, Qe of the circuit | [`injection::feed`] | RSB, figure 1; this project |
//! | radii, p ~ r^-2 and others | [`sample::random::RandomNumbers::radius`] | LMGC90 (granulometry) |
//! | relaxation of a bed (FIRE) | [`sample::relax::Pile::relax`] | Bitzek et al. 2006 |
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
//!     participant: "grains".into(), seed: 1, thickness_m: 1e-3, threads: 1, fields: None, cache: None,
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
mod drive;
pub mod error;
pub mod faces;
pub mod feed;
pub mod flow;
pub mod geometry;
pub mod initial_bonds;
pub mod injection;
pub mod interface;
mod lanes;
pub mod law;
pub mod ledger;
pub mod loads;
pub mod mass_scaling;
pub mod node;
mod pairs;
pub mod plausible;
pub mod positions;
pub mod prepared;
pub mod prescribed_opening;
mod profile;
pub mod repair;
pub mod report;
pub mod sample;
pub mod setup;
pub mod snapshot;
pub mod solver;
pub mod state;
pub mod step;
pub mod stress;
pub mod structure;
mod threads;
mod trend;
mod vtk;
pub mod wheel;
pub mod wheel_face;

use protocol::{ConfigError, Node, NodeError, Session, Setting};

pub use config::Config;
pub use error::DemError;
pub use node::Dem;

/// Checks the participant's keys without preparing its sample. Returns what the user should know before a long run.
pub fn check(config: &serde_json::Value, setting: &Setting) -> Result<Vec<String>, ConfigError> {
    let config: Config = protocol::read_config(config)?;
    let config = config.resolved()?;
    config.validate()?;
    check_setting(setting)?;
    config.validate_feed(setting.thickness_m)?;
    let mut advice = match config.time.step_s {
        None => Vec::new(),
        Some(step) => bounds::Bounds::new(&config)
            .assess(step)
            .map_err(|error| ConfigError::new("time.step_s", error.to_string()))?,
    };
    advice.extend(mass_scaling::advice(&config, setting.thickness_m));
    if let config::SampleConfig::Layer(layer) = &config.sample {
        advice.extend(layer.advice(config.law.contact_stiffness_pa));
    }
    Ok(advice)
}

/// Builds the participant of a session: reads its keys and prepares its sample.
pub fn build(session: &Session) -> Result<Box<dyn Node>, NodeError> {
    let config: Config = protocol::read_config(&session.config)?;
    check_setting(&session.setting)?;
    Ok(Box::new(Dem::new(&config, &session.setting)?))
}

fn check_setting(setting: &Setting) -> Result<(), ConfigError> {
    config::limits::positive("run.thickness_m", setting.thickness_m, "m")
}
