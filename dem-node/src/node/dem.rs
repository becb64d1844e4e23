//! The participant's data: the grains with their wheel and walls, committed and on trial, and a step of the grains.

use std::collections::BTreeMap;

use dem_kernel::bodies::Bodies;
use dem_kernel::bodies::faces::Face;
use dem_kernel::contact::bond;
use dem_kernel::contact::boundary::CompliantBoundary;
use dem_kernel::solver::acceleration::FIRST_TURNS;
use dem_kernel::step::state::GrainState;
use dem_kernel::step::stiffness::StiffnessBounds;
use dem_kernel::step::{StepInput, StepSummary, Stepper, WheelTurn, repair, threads};
use protocol::{PreparedSample, Setting, Window};
use rayon::ThreadPool;
use serde::{Deserialize, Serialize};

use crate::config::DemConfig;
use crate::config::DemPlausible;
use crate::config::profile::ProfileConfig;
use crate::config::sample::CutLine;
use crate::config::solver::{Algorithm, SolverConfig};
use crate::config::stress::StressConfig;
use crate::error::DemError;
use crate::measure::cycles::WheelCycles;
use crate::measure::flow::{Flow, FlowScene};
use crate::measure::force_means::ForceMeans;
use crate::measure::plausible::GRAIN_TRAVEL;
use crate::measure::profile::GrainProfile;
use crate::measure::report::RunStatistics;
use crate::measure::rolled::{self, RolledWay};
use crate::measure::stress::{self, StressMap};
use crate::measure::structure::bonded_strength;
use crate::node::interface::InterfaceDisks;
use crate::sample::prepared;
use crate::sample::types::Sample;
use crate::sample::{fed, perturb, surface, wheel_face};
use crate::setup;
use crate::setup::bounds::{StepBounds, advice_on_positions, advice_on_travel};
use crate::setup::mass_scaling::MassScaling;
use crate::setup::prescribed_opening::PrescribedOpening;
use kit::kept::{Store, WORTH};
use kit::wheel::{WheelProgram, ends_at};

/// A layer or heap of grains, with its wheel and walls, ready to step: the participant.
pub struct Dem {
    pub(super) setting: Setting,
    pub(super) sample: SampleFacts,
    pub(super) time: TimeFacts,
    pub(super) measures: Measures,
    /// The contact solver and its stopping criteria.
    pub(super) solver: SolverConfig,
    /// The threads of the contact solver, if there are several.
    pub(super) pool: Option<ThreadPool>,
    pub(super) bodies: Bodies,
    pub(super) program: Option<WheelProgram>,
    pub(super) opening: Option<PrescribedOpening>,
    /// Times (s) from which keys have had an effect.
    pub(super) moments: BTreeMap<String, f64>,
    pub(super) warnings: Vec<String>,
    pub(super) progress: Progress,
    /// The state at the end of the window being solved.
    pub(super) trial: GrainState,
    pub(super) stepper: Stepper,
    pub(super) interface: InterfaceDisks,
    /// Length of the announced windows (s).
    pub(super) window: Option<f64>,
    /// The window whose end `trial` holds, with the summary of its step, until it is committed.
    pub(super) pending: Option<(Window, StepSummary)>,
    pub(super) initial_energy: [f64; 5],
}

/// The sample at its start.
pub(super) struct SampleFacts {
    /// Its origin, where a recipe made it.
    pub prepared_sample: Option<PreparedSample>,
    pub solid_fraction: f64,
    /// Part of the radii that the preparation took off, where it reports one.
    pub radii_shrunk: Option<f64>,
    /// Ends of a layer that does not repeat, in |x| (m).
    pub ends: Option<[f64; 2]>,
    /// The lines that a layer or a rail is cut along.
    pub cut_lines: Option<[CutLine; 2]>,
    pub initial_bond_count: usize,
    /// Tensile and shear strength of a bonded layer (Pa).
    pub strength: Option<[f64; 2]>,
    /// Centres of all disks (m), for the fields; empty where these are not written.
    pub start: Vec<[f64; 2]>,
}

/// Scheme, step and the bounds on it.
pub(super) struct TimeFacts {
    /// Mass of a disk over its area, scaled (kg/m2).
    pub mass_per_area: f64,
    pub theta: f64,
    /// Step of a run alone (s).
    pub own_step: Option<f64>,
    /// End of the history (s).
    pub end: Option<f64>,
    pub bounds: StepBounds,
    /// Bounds on the step from bonds and contact springs.
    pub stiffness: StiffnessBounds,
    pub scaling: Option<MassScaling>,
}

/// Measurements, and the bounds of checks.
pub(super) struct Measures {
    pub plausible: DemPlausible,
    pub profile: Option<ProfileConfig>,
    pub stress: Option<StressConfig>,
    pub flow: Option<FlowScene>,
}

/// Everything that committed windows change: the checkpoint. The rest follows from configuration and handshake.
#[derive(Default, Serialize, Deserialize)]
pub(super) struct Progress {
    /// The committed state.
    pub state: GrainState,
    pub statistics: RunStatistics,
    pub cycles: WheelCycles,
    pub rolled: RolledWay,
    pub forces: ForceMeans,
    pub profile: GrainProfile,
    /// The stress at its moment, once that has come; `Some(None)` where no grain bore a force.
    pub held_stress: Option<Option<StressMap>>,
    /// The flows of third body, where they are measured.
    pub flow: Option<Flow>,
    pub steps: u64,
    pub contact_iterations: f64,
}

impl Progress {
    /// Hash of the state, and of the flows where there are any, in hexadecimal.
    pub fn hash(&self) -> String {
        let hash = self.state.hash();
        self.flow
            .as_ref()
            .map_or(hash.clone(), |flow| flow.hash(&hash))
    }
}

impl Dem {
    /// Prepares the sample of a configuration and everything around it.
    pub fn new(config: &DemConfig, setting: &Setting) -> Result<Dem, DemError> {
        let config = &config.resolved()?;
        config.validate()?;
        config.validate_feed(setting.thickness_m)?;
        let bounds = StepBounds::new(config);
        let mut warnings = match config.time.step_s {
            Some(step) => bounds.assess(step)?,
            None => Vec::new(),
        };
        let store = Store {
            folder: setting.cache.as_deref(),
            worth: WORTH,
        };
        let prepared = prepared::prepare(&store, config, setting.seed)?;
        let mut sample = prepared.sample;
        warnings.extend(prepared.warnings);
        if let Some(seed) = config.perturb_seed {
            perturb(&mut sample, seed);
        }
        if let Some(wheel) = &config.wheel {
            sample.face = wheel_face::row(wheel, &config.sample, setting.seed);
        }
        sample.surface = surface::surface(&config.sample, &sample, setting.seed);
        setup::refuse_deep_layers(config, &sample)?;
        let fed = fed::store(config, setting.thickness_m, &sample, setting.seed);
        let scaling = MassScaling::new(config, &bounds, &sample);
        sample.free.extend(&fed);
        let mut bodies = setup::bodies(config, setting.thickness_m, &sample, fed.len());
        let (state, opening) = start(config, &mut bodies, &sample)?;
        let program = config.program();
        let feed = bodies.injection.as_ref();
        let moments = config.moments(feed.and_then(|feed| Some(feed.point()?.start + feed.growth)));
        let ends = [program.as_ref().map(|p| p.end()), opening.map(|p| p.end())];
        let end = ends[0].or(ends[1]).or(config.time.end_s);
        if let (Some(step), None) = (config.time.step_s, opening) {
            let bound = config.plausible.of(&GRAIN_TRAVEL).warn;
            let numbers = [step, end.unwrap_or(0.0), bound];
            warnings.extend(advice_on_travel(&bodies, &state, numbers));
        }
        warnings.extend(advice_on_positions(&bodies, &state));
        warnings.extend(idle_bounds(config, &bodies));
        let mut stepper = Stepper::default();
        stepper.problem.boundary = CompliantBoundary::fixed(bodies.boundary_points());
        Ok(Dem {
            sample: SampleFacts {
                prepared_sample: prepared.origin,
                solid_fraction: sample.solid_fraction,
                radii_shrunk: sample.radii_shrunk,
                ends: config.sample.ends(),
                cut_lines: config.sample.cut_lines(),
                initial_bond_count: bond::count(&state.bonds),
                strength: strength(&sample, &bodies, &state, setting.thickness_m),
                start: match setting.fields {
                    Some(_) => state.centres.clone(),
                    None => Vec::new(),
                },
            },
            time: TimeFacts {
                mass_per_area: config.mass_scale * config.density_kg_per_m3 * setting.thickness_m,
                theta: config.time.theta,
                own_step: opening.map(|p| p.step()).or(config.time.step_s),
                end,
                bounds,
                stiffness: StiffnessBounds::new(&bodies, &state),
                scaling,
            },
            measures: Measures {
                plausible: config.plausible.clone(),
                profile: config.profile,
                stress: config.stress,
                flow: config.flow.map(|flow| {
                    let moves = program.as_ref().map_or(0.0, WheelProgram::motion_start);
                    FlowScene::new(flow, &bodies, config.mass_scale, (moves, setting.seed))
                }),
            },
            setting: setting.clone(),
            solver: config.solver,
            pool: threads::pool(setting.threads)?,
            initial_energy: state.energies(&bodies),
            opening,
            trial: state.clone(),
            progress: Progress {
                statistics: RunStatistics::new(state.wheel.position[1]),
                cycles: WheelCycles::new(state.wheel.position[1], setting.thickness_m),
                flow: (config.flow).map(|flow| Flow::new(&flow, &bodies, &state)),
                state,
                ..Progress::default()
            },
            bodies,
            program,
            moments,
            warnings,
            stepper,
            interface: InterfaceDisks::default(),
            window: None,
            pending: None,
        })
    }

    /// The committed state.
    pub fn state(&self) -> &GrainState {
        &self.progress.state
    }

    /// The bodies, which do not change.
    pub fn bodies(&self) -> &Bodies {
        &self.bodies
    }

    /// Advances the trial state, or the committed one, from `start` to `end` by a step of the length `step` (s), with the
    /// velocities a_g of the glued disks (2 n).
    pub(super) fn advance(
        &mut self,
        [start, end]: [f64; 2],
        step: f64,
        free_velocity: &[f64],
        trial: bool,
    ) -> Result<StepSummary, DemError> {
        let loaded = start + self.time.theta * (end - start);
        let (program, times) = (self.program.as_ref(), [start, end, loaded]);
        let turn = program.map_or(WheelTurn::Held, |program| {
            rolled::turn(program, times, step, self.bodies.wheel_radius)
        });
        let input = StepInput {
            bodies: &self.bodies,
            step,
            theta: self.time.theta,
            load: program.map_or(0.0, |program| program.load_at(loaded)),
            wheel_x: program.map_or(0.0, |program| program.displacement_at(end)),
            turn,
            loaded,
            free_velocity,
        };
        let state = if trial {
            &mut self.trial
        } else {
            &mut self.progress.state
        };
        if let (WheelTurn::Free { .. }, Some(speed)) = (
            turn,
            program.and_then(|program| program.starts_in(start, end)),
        ) {
            state.begin_to_spin(&self.bodies, -speed);
        }
        // Waking the threads costs as much as some thousand contacts.
        let pool = self.pool.as_ref().filter(|_| self.stepper.is_partitioned());
        let criteria = self.solver.criteria(pool.is_some());
        let stepper = &mut self.stepper;
        let summary = threads::in_pool(pool, || stepper.advance(state, &input, &criteria))?;
        self.progress.steps += 1;
        self.progress.contact_iterations +=
            (summary.listed * summary.convergence.iterations) as f64;
        Ok(summary)
    }

    /// The error of a step that did not converge.
    pub(super) fn not_converged(&self, window: &Window, summary: &StepSummary) -> DemError {
        let solve = &summary.convergence;
        let (residual, iterations) = (solve.residual, solve.iterations);
        if summary.repair_failed {
            return DemError::NotRepaired {
                window: window.index,
                residual,
                iterations,
                tolerance: repair::TOLERANCE,
            };
        }
        let pivots = self.solver.algorithm == Algorithm::Nsgs
            && self.bodies.law.friction > 0.0
            && self.bodies.law.cohesion.is_none();
        DemError::NotConverged {
            window: window.index,
            residual,
            iterations,
            tolerance: self.solver.tolerance,
            rigid: self.bodies.law.springs.is_none(),
            friction: self.bodies.law.friction,
            pivots_after: pivots.then_some(FIRST_TURNS),
        }
    }

    /// Records a committed step.
    pub(super) fn record(&mut self, start: f64, end: f64, summary: &StepSummary) {
        let progress = &mut self.progress;
        let state = &progress.state;
        if let Some(config) = &self.measures.profile {
            let grains = (&self.bodies, state, self.setting.thickness_m);
            progress.profile.record(config, grains, [start, end]);
        }
        let hold_end = self.program.as_ref().and_then(WheelProgram::hold_end);
        if let Some(config) = &self.measures.stress
            && let Some(moment) = config.at_s.or(hold_end)
            && ends_at(moment, [start, end])
        {
            let thickness = self.setting.thickness_m;
            let stress = StressMap::measure(config, &self.bodies, state, thickness);
            progress.held_stress = Some(stress);
        }
        if let (Some(scene), Some(flow)) = (&self.measures.flow, &mut progress.flow) {
            flow.record(scene, (&self.bodies, state), end, end - start);
        }
        progress
            .forces
            .record(&self.stepper.on_named, start, self.time.end);
        if let Some(program) = &self.program {
            let flow = progress.flow.as_ref();
            let impulses = &self.stepper.problem.boundary.impulse;
            let grains = (&self.bodies, state, summary);
            (progress.cycles).record(program, [start, end], grains, impulses, flow);
            progress.rolled.record(program, grains, [start, end]);
        }
        let (program, grains) = (self.program.as_ref(), (&self.bodies, state));
        progress
            .statistics
            .record(program, grains, summary, [start, end]);
        if let (Some(scene), Some(flow)) = (&self.measures.flow, &mut progress.flow) {
            for grain in flow.leave_sideways(scene, (&self.bodies, state), end - start) {
                progress.state.take(&self.bodies, grain);
            }
        }
    }
}

/// Tensile and shear strength of a bonded sample whose solid fraction is known (Pa).
fn strength(
    sample: &Sample,
    bodies: &Bodies,
    state: &GrainState,
    thickness_m: f64,
) -> Option<[f64; 2]> {
    let solid_fraction = Some(sample.solid_fraction).filter(|known| *known > 0.0)?;
    let cold = bonded_strength(bodies, &state.bonds, solid_fraction, thickness_m)?;
    if !bodies.softens() {
        return Some(cold);
    }
    let law = bodies.law.cohesion?;
    let shares = state.bonds.iter().map(|bond| {
        let warm = state.law_of(bodies, [bond.a, bond.b]).cohesion;
        warm.map_or(1.0, |warm| (warm.energy / law.energy).sqrt())
    });
    let share = shares.sum::<f64>() / state.bonds.len() as f64;
    Some(cold.map(|strength| share * strength))
}

/// Warnings about bounds of checks that the scene does not have.
fn idle_bounds(config: &DemConfig, bodies: &Bodies) -> Vec<String> {
    let of_wheels = [
        "wheel_force_rel",
        "wheel_drift_rel",
        "wheel_inside_rel",
        "wheel_contact_share",
        "contact_width_rel",
    ];
    let bonded = bodies.any_law(|law| law.cohesion.is_some());
    let sprung = bodies.law.springs.is_some();
    let wheel = config.wheel.as_ref();
    let cycles = wheel.is_some_and(|wheel| wheel.cycles > 0.0);
    let mut walls = bodies.walls.iter();
    let segments = walls.any(|wall| matches!(wall.face, Face::Segment(_)));
    config.plausible.idle(&[
        (config.wheel.is_none(), "without a wheel", &of_wheels),
        (
            config.heat.is_none(),
            "without heat",
            &[
                "heat_balance_rel",
                "heat_steps_rel",
                "below_zero_k",
                "grain_temperature_k",
            ],
        ),
        (!cycles, "without cycles of a wheel", &["cycle_drift_rel"]),
        (
            config.wheel.is_none() || bodies.glued() == 0 || !bodies.walls.is_empty(),
            "without a wheel over glued disks alone",
            &["boundary_force_rel"],
        ),
        (
            bodies.glued() == 0 || bodies.walls.is_empty(),
            "without glued disks beside walls",
            &["glued_behind_wall_rel"],
        ),
        (!segments, "without a wall of points", &["behind_wall_rel"]),
        (
            !sprung,
            "without law.contact_stiffness_pa",
            &["overlap_rel"],
        ),
        (
            sprung,
            "with law.contact_stiffness_pa",
            &["overlap_rigid_rel"],
        ),
        (
            !bodies.is_elastic(),
            "without springs, bonds or attraction",
            &["detection_rel"],
        ),
        (
            !bodies.any_law(|law| law.springs.is_none()),
            "without rigid contacts",
            &["impact_energy_rel"],
        ),
        (
            config.mass_scale == 1.0,
            "with real masses",
            &["added_inertia_rel"],
        ),
        (
            !bonded,
            "without bonds",
            &["bond_step_rel", "bond_energy_rel"],
        ),
        (config.flow.is_none(), "without flow", &["flow_kinetic_rel"]),
        (
            bodies.injection.is_none(),
            "without injection or detachment",
            &["injection_rel", "not_steady_rel"],
        ),
        (
            config.detachment.is_none(),
            "without detachment",
            &["detachment_rel"],
        ),
        (
            bodies.clusters.list.is_empty(),
            "without clusters",
            &["shared_damping_diff"],
        ),
        (
            bodies.surface.points.is_empty(),
            "without a bare surface",
            &["surface_segment_share"],
        ),
    ])
}

/// The state at the start, and the prescribed motion of a pair that is pulled apart.
fn start(
    config: &DemConfig,
    bodies: &mut Bodies,
    sample: &Sample,
) -> Result<(GrainState, Option<PrescribedOpening>), DemError> {
    let mut state = GrainState::new(bodies, &sample.free, &sample.glued);
    if let Some(wheel) = &config.wheel {
        setup::refuse_idle_wheel(&state)?;
        state.wheel.velocity[1] = wheel.vy_m_per_s;
    }
    setup::refuse_grains_behind(config, bodies, &state)?;
    setup::refuse_rigid_overlaps(bodies, &state)?;
    if let Some(config) = &config.stress {
        stress::refuse_misfit(config, bodies, &state)?;
    }
    let opening = match &config.drive {
        None => None,
        Some(drive) => Some(PrescribedOpening::new(drive, bodies, &state)?),
    };
    if let Some(opening) = &opening {
        let [x, y] = opening.velocity(&state);
        bodies.prescribed_velocity = Some([x, y]);
        state.velocities[0] = [x, y, 0.0];
    }
    if let Some(step) = config.time.step_s.filter(|_| config.time.theta < 1.0) {
        state.load_springs(bodies, (1.0 - config.time.theta) * step);
    }
    Ok((state, opening))
}
