//! Non-Smooth Contact Dynamics of the third body: disks in the plane, walls, a glued base, bare surfaces and a rigid wheel.
//!
//! Grains are rigid disks with unilateral contact, Coulomb friction and, if wanted, elastic contacts; steps are implicit
//! (Moreau-Jean). The base of a layer is a row of *glued* disks on a *compliant boundary*, which yields to the contact forces
//! as the rail that the coupler speaks for. The crate does not know that rail, nor any other solver.
//!
//! # Problem
//!
//! N rigid disks, or rigid clusters of disks, between walls, glued rows and a wheel. Velocities jump where grains meet, so the motion is
//! an equation of measures, integrated over a step at once: no contact is an event, all contacts of a step are one problem
//! (Moreau 1988; Jean 1999).
//!
//! ```text
//! M dv = F dt + H r               Renouf, Saulot and Berthier (2006), eqs 1 to 5
//! u    = H^T v                    relative velocities at the contacts
//! law(u, g, r) at each contact    unilateral, with friction, springs or bonds
//! ```
//!
//! # Symbols
//!
//! All values are SI; r is an impulse here, and a force in `fem-node`. The normal of a contact points from body b to body a.
//!
//! | symbol | meaning | unit | in the code |
//! |---|---|---|---|
//! | q, v | position; velocity (v_x, v_y, spin times radius) | m, m/s | [`GrainState::centres`](step::state::GrainState::centres), [`GrainState::velocities`](step::state::GrainState::velocities) |
//! | M, F | masses, `mass_scale` included; weight, loads | kg, N | [`Bodies::masses`](bodies::Bodies::masses), [`StepInput`](step::StepInput) |
//! | h, theta | step, which is the window of a coupled run; weight of the end velocity | s, - | [`StepInput::step`](step::StepInput::step), [`StepInput::theta`](step::StepInput::theta) |
//! | g | gap, below 0 where bodies overlap | m | [`Contact::gap`](solver::contact::Contact::gap) |
//! | u, U | relative velocity, u_n > 0 when separating; the same with what gap and springs add | m/s | [`Problem::relative_velocity`](solver::problem::Problem::relative_velocity) |
//! | r | impulse of a contact, r_n > 0 in compression | N s | [`Contact::impulse`](solver::contact::Contact::impulse) |
//! | W | Delassus operator H^T M^-1 H; its block of a contact has W_nn, W_nt, W_tt | 1/kg | [`DelassusBlock`](law::local::DelassusBlock) |
//! | mu, e | coefficients of friction and restitution | - | [`Law::friction`](law::Law::friction), [`Law::restitution`](law::Law::restitution) |
//! | kn, kt, d_t | stiffness of compliant contacts; elongation of the tangential spring | N/m, m | [`Springs`](law::Springs), [`Slot::spring`](contact::detect::Slot::spring) |
//! | a | adhesion of a bond, 1 to 0 (the paper's beta) | - | [`Bond::adhesion`](contact::bond::Bond::adhesion) |
//! | Cn, Ct, w, b, p | stiffness, surface energy, viscosity and exponent of a bond | Pa/m, J/m2, Pa m s^p, - | [`Cohesion`](law::cohesion::Cohesion) |
//! | l | area of a bond, r_1 r_2/(r_1 + r_2) t, with t the thickness | m2 | [`Bond::area`](contact::bond::Bond::area) |
//! | delta | opening of a bond since it was made | m | [`Bond::opening`](contact::bond::Bond::opening) |
//! | v_g, a_g, p, W_g | velocity of the glued disks, that without contact forces, impulse on them, compliance of what carries them | m/s, m/s, N s, 1/kg | [`CompliantBoundary`](contact::boundary::CompliantBoundary) |
//! | t_i | inertial time d sqrt(rho/P), d the mean diameter, P `time.pressure_pa` | s | [`StepBounds::inertial_time`](setup::bounds::StepBounds::inertial_time) |
//!
//! # A step
//!
//! ```text
//! q_m    = q + h (1 - theta) v    contacts are detected here
//! v_free = v + h M^-1 F
//! v'     = v_free + M^-1 H r      RSB eq 7; r from the contact problem
//! q'     = q_m + h theta v'
//! ```
//!
//! With W = H^T M^-1 H the contact problem is RSB eq 8, with one law per contact:
//!
//! ```text
//! u = H^T v_free + W r
//! rigid      U_n = u_n + max(0, g)/h           IQS: an overlap stays, and adds no speed
//!            U_n = u_n + e u_n(t_i)            where g <= 0: Newton's restitution
//! springs    U_n = u_n + g/h + r_n/(kn h^2)    signed gap
//!            U_t = u_t + d_t/h + r_t/(kt h^2)
//! Signorini  U_n >= 0,  r_n >= 0,  U_n r_n = 0
//! Coulomb    |r_t| <= mu r_n;  U_t = 0, or r_t = -+mu r_n opposed to it
//! ```
//!
//! # Bonds
//!
//! Raous, Cangemi and Cocou (1999), RSB eqs 9 and 10 with their signs corrected; here r_n is a force:
//!
//! ```text
//! r_n = -l Cn a^2 delta_n    in tension
//! r_t = -l Ct a^2 delta_t    along the contact
//! a'  = -[(1/b) (w h'(a) - a D)^-]^(1/p),   D = Cn delta_n^2 + Ct delta_t^2
//! ```
//!
//! A bond opens from delta_0 = sqrt(w/Cn) on, under the stress sqrt(w Cn). Adhesion is held while the contact problem is
//! solved, then lowered as far as that solution asks, and the problem solved anew until nothing falls any further; with
//! h < 1/(sqrt(3) omega), omega = sqrt(l Cn/m), there is one solution only ([`setup::bounds::step_limit`]). Above it this is the first
//! solution on the way from the intact bond, the one that a descent of the incremental energy reaches: a bond may then hold
//! against more than its fracture energy, and the run is warned of it where bonds came near to their strength.
//!
//! A bond takes w l as it breaks, less by some 0.2 h sqrt(3) omega. Its pair goes on touching at the gap at which the bond was made
//! until it has come apart once ([`Slot::gap`](contact::detect::Slot::gap)): no overlap or void appears that was not there.
//!
//! # The base that yields
//!
//! Glued disks have neither mass nor spin. They lie on a body that another solver moves, and know of it one linear relation only:
//!
//! ```text
//! v_g = a_g + W_g p    a_g, W_g: given by the coupler for this window
//! ```
//!
//! Beside the disks, or in their place, the boundary may have points of a surface, on whose segments grains lie ([`bodies::surface`]): a grain
//! with the foot (1 - s, s) between two of them sees S v_g and hands S^T p on.
//!
//! It enters the sweeps like any other velocity ([`contact::boundary`]). v_g is the mean velocity of the window and the end velocity of
//! the grains at once, which is consistent for theta = 1 only: a coupled run with another theta is refused.
//!
//! # One step, module by module
//!
//! 1. [`step::injection::feed`] puts in what is fed; [`GrainState::drift`](step::state::GrainState::drift) moves to q_m; [`contact::detect`] lists pairs by linked
//!    cells and a Verlet list, whose slots remember forces and springs; [`law`] turns gaps into biases.
//! 2. [`solver::nsgs`] sweeps over the contacts, each taking its impulse in closed form ([`law::local`], by packs
//!    [`law::vector`]), from the impulses of the step before. Without friction [`solver::pcg`] needs fewer iterations.
//! 3. [`solver::residual`] decides, not the change of a sweep: `|W (r - P(r - U/W))| / |W r| <= tolerance`. Sweeps that creep or circle are
//!    extrapolated, averaged, and at last replaced by pivoting.
//! 4. [`contact::bond::end_step`] and [`contact::loss::contact_loss`] record what contacts stored and lost; the bodies move to q'; [`step::repair`] takes overlaps
//!    of rigid grains away, if asked.
//! 5. [`node`] answers F_g = p/h, v_g, iterations and residual. Nothing is committed before the coupler says so.
//!
//! # The step's length
//!
//! An unbalanced grain crosses its diameter in t_i. Up to 0.05 t_i forces are clean; above it the step is warned of, above t_i refused
//! ([`setup::bounds`]). At 1 GPa and the density of steel t_i is some 4e-7 s, which is why grains of the shipped scenes are a thousand times as
//! heavy as real ones: [`setup::mass_scaling`] tells what that costs. Loads and the wheel's mass are never scaled.
//!
//! # Checks
//!
//! - The natural-map residual of each step, above `solver.tolerance` an error, never a silent pass: a solve of few sweeps gives
//!   garbage while the interface still reads a gap of zero.
//! - Energy ([`step::ledger`]): work of loads, drives, weight and interface against kinetic energy, springs and bonds, and losses by
//!   impact, friction, dampers and decohesion, each by its own formula. What the scheme loses, and what detection finds otherwise than
//!   the step left it, are terms too.
//! - Momentum: forces on the free grains against the change of their momentum, `momentum_defect_max_n`.
//! - Masses of third body at each step: in the zone = detached - re-attached + fed + entered - left ([`measure::flow`]).
//! - Rigid contacts only take energy: what friction and rebounds make is summed contact by contact ([`step::ledger::GrainLedger::made`]).
//! - Plausibility: ways of grains in a step, walls met from behind, grains behind a surface, overlaps, lost grains, wheel at rest, forces above against below, inertia that scaled masses add.
//! - Exact answers: impacts, slopes, columns, pyramids, chains, bonds; published ones for packings and plane shear (`tests/verification/dem*.rs`).
//!
//! # Limits
//!
//! Disks and clusters of disks in the plane, which do not deform: compliance is in the contacts, and overlaps beyond 0.3 of a radius are
//! warned of. Bonds are made at the start, and by healing between pairs that stay the same as they roll, which segments of
//! faces do not. With friction a rigid packing may have many
//! solutions; sweeps find one of them, the same for any number of threads. Pressures of single grains and of rough faces vary with the
//! seed; means over many grains do so less.
//!
//! # Modules
//!
//! In reading order, each with a list of its own:
//! - [`law`]: the contact laws in closed form, bonds included;
//! - [`bodies`]: the bodies, how far apart they are, and what moves them;
//! - [`contact`]: pairs that may touch, bonds between grains, the compliant boundary of the glued disks;
//! - [`config`]: the keys of a scenario and their limits;
//! - [`solver`]: the contact problem and its solvers;
//! - [`sample`]: grains listed one by one, a pressed layer cut to follow a crown, or a rail of grains;
//! - [`mod@step`]: one step of the scheme, the state that it moves on and the energy balance;
//! - [`setup`]: from the keys to the types of the steps, the wheel's program, bounds on the step;
//! - [`measure`]: stress, flows of third body, forces on named bodies, signals, results and fields;
//! - [`node`]: all of it as a participant of a run.
//!
//! # Equations, functions, sources
//!
//! RSB is Renouf, Saulot and Berthier, *Third-body flow during wheel-rail interaction*, 2006; its equations 11 to 17 belong
//! to the continuum.
//!
//! | equation | function | source |
//! |---|---|---|
//! | relative velocity u = H^T v, and v += M^-1 H r | [`solver::problem::Problem::relative_velocity`], [`solver::problem::Problem::apply`] | RSB (1)-(5); Jean 1999 |
//! | theta scheme q_m = q + h (1 - theta) v, q' = q_m + h theta v' | [`step::Stepper::advance`], [`step::state::GrainState::drift`] | RSB (7); Moreau 1988; Jean 1999 |
//! | v_free = v + h M^-1 F | [`step::Stepper::free_records`] | RSB (7) |
//! | Delassus operator W = H^T M^-1 H, block of a contact | [`solver::problem::Problem::block`] | RSB (8); Jean 1999 |
//! | local problem b = u + bias - W r, U = b + W r | [`solver::problem::Problem::local_solution`] | RSB (8); Jean 1999 |
//! | Signorini and Coulomb: open, stick or slide | [`law::local::LocalLaw::impulse`] | Jean 1999 |
//! | the same for several contacts, W_nt = 0 | [`law::vector::normal_impulse`], [`law::vector::tangential_impulse`] | Jean 1999 |
//! | projection on the Coulomb sector | [`law::local::coulomb_projection`] | Alart and Curnier 1991 |
//! | natural-map residual | [`solver::residual`] | Alart and Curnier 1991 |
//! | block non-linear Gauss-Seidel, its criterion | [`solver::nsgs::solve`], [`solver::residual::Quad`] | RSB (8); Jourdan, Alart and Jean 1998; Jean 1999 |
//! | projected conjugate gradient (CPG) | [`solver::pcg::solve`] | Renouf and Alart 2005 |
//! | springs: U += g/h, W += 1/(k h^2) | [`law::Law::compliance`], [`law::Law::bias`] | LMGC90 (elastic repel) |
//! | dampers: both times 1/(1 + c/(kn h)), c = 2 zeta sqrt(kn m) | [`law::Springs::damped_share`], [`law::Springs::damping_ratio`] | Schwager and Pöschel 2007 |
//! | bonds with dampers: delta/h, delta_t/h and 1/kappa times 1/(1 + c/(k h)) | [`law::damped_share`], [`law::relaxation`] | Kelvin and Voigt |
//! | rebound that the step leaves, e = exp(-pi h omega / 2) | [`setup::bounds::numerical_restitution`] | Jean 1999; this project |
//! | gap and IQS, restitution U = u_n + e u_n(t_i) | [`law::Law::bias`] | Moreau 1988; LMGC90 |
//! | split impulse and projection of positions | [`step::repair::Repair::make`] | [`step::repair`] |
//! | rolling resistance, \|M\| <= mu_r r r_n | [`solver::rolling`] | Jiang, Yu and Harris 2005; Estrada, Taboada and Radjai 2008 |
//! | attraction, r_n + N_c >= 0, \|r_t\| <= mu (r_n + N_c) | [`law::adhesion::Adhesion::attraction`], [`contact::loss::attraction_loss`] | Radjai, Preechawuttipong and Peyroux 2001 |
//! | cohesive zone: adhesion a' = -((w h' - a D)^- / b)^(1/p) | [`law::cohesion::Cohesion::adhesion_after`] | RSB (9)-(10), signs corrected; Raous, Cangemi and Cocou 1999 |
//! | healing a' = 1/T under pressure, friction beside it mu (1 - a) | [`law::healing::Healing::grown`], [`law::Law::friction_share`] | Raous and Monerie 2002; this project |
//! | cohesive force r_n = -kappa_n U, kappa = h^2 l C a^2 | [`law::local::BondLaw::impulse`] | RSB (9)-(10); Raous, Cangemi and Cocou 1999 |
//! | unique end of a step with bonds, h < 1/(sqrt(3) omega) | [`setup::bounds::step_limit`] | [`contact::bond`] |
//! | feet on a surface, v = S v_g, p = S^T f | [`bodies::surface::Foot`], [`contact::boundary::CompliantBoundary::feet`] | virtual work |
//! | compliant boundary v_g = a_g + W_g p | [`contact::boundary::CompliantBoundary::evaluate`] | Gravouil and Combescure 2001 |
//! | energy lost by a contact, by a bond | [`contact::loss::contact_loss`], [`contact::bond::end_step`] | [`step::ledger`] |
//! | energy stored: kinetic, springs, bonds | [`step::state::GrainState::energies`] | [`step::ledger`] |
//! | pressure in a grain, trace of sum f (x_c - x) / V | [`measure::snapshot::pressures`] | Love 1927; Weber 1966 |
//! | stress of cells, -(1/V) sum f (x_c - x) | [`measure::stress::StressMap::measure`] | Love 1927; Weber 1966; Moreau 1997 |
//! | the part of a grain in a cell, by its tile | [`measure::tiles::tiles`] | Bagi 1996 |
//! | fabric, mean of n (x) n | [`measure::structure::results`] | Satake 1982 |
//! | wheel D(t) = A sin(2 pi f (t - t_s)) | [`kit::wheel::WheelProgram::displacement_at`] | RSB, section 6 |
//! | inertial time t_i = d sqrt(rho/P), bounds on the window | [`setup::bounds::StepBounds::new`], [`setup::bounds::StepBounds::assess`] | GDR MiDi 2004 |
//! | mass scaling: inertial number, inertial pressure | [`setup::mass_scaling::MassScaling::new`] | GDR MiDi 2004 |
//! | fed grains, Qe of the circuit | [`step::injection::feed`] | RSB, figure 1; this project |
//! | steel that comes off bare surfaces, Qs | [`step::detachment`] | Fleischer 1973 (energy density of wear); this project |
//! | radii, p ~ r^-2 and others | [`sample::random::RandomNumbers::radius`] | LMGC90 (granulometry) |
//! | relaxation of a bed (FIRE) | [`sample::relax::Packing::relax`] | Bitzek et al. 2006 |
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

pub mod bodies;
pub mod config;
pub mod contact;
pub mod error;
pub mod law;
pub mod measure;
pub mod node;
pub mod sample;
pub mod setup;
pub mod solver;
pub mod step;

use kit::ConfigError;
use protocol::{Node, NodeError, Session, Setting};

use config::sample::SampleConfig;
use setup::bounds::StepBounds;
use setup::mass_scaling;

pub use config::DemConfig;
pub use error::DemError;
pub use node::dem::Dem;

/// Checks the participant's keys without preparing its sample. Returns what the user should know before a long run.
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
