//! From the checked keys to everything that does not change during a run.
//!
//! - `supports`: components that do not move;
//! - [`boundary`]: loads and prescribed motions of named sets;
//! - [`motion`]: prescribed motions over time;
//! - `initial`: initial velocities;
//! - `heat`: temperatures;
//! - `rolling`: a wheel that rolls along the body;
//! - `probe_points`: the points whose motion is reported.

pub mod boundary;
pub(crate) mod heat;
pub(crate) mod initial;
pub mod motion;
pub(crate) mod probe_points;
pub(crate) mod rolling;
mod supports;

use std::collections::BTreeMap;

use fem_kernel::element::body::{Body, ElementKind};
use fem_kernel::integrate::dissipation::Mechanisms;
use fem_kernel::integrate::state::NodalState;
use fem_kernel::material::Elastic;
use fem_kernel::material::j2::J2;
use fem_kernel::material::nonlinear::NonlinearLaw;
use fem_kernel::mesh::connectivity::Connectivity;
use fem_kernel::mesh::{Edge, Mesh};
use fem_kernel::scheme::{Damping, NewmarkScheme};
use fem_kernel::spectrum;
use fem_kernel::statics::problem::StaticProblem;
use fem_kernel::wheel::rigid::{Wheel, WheelNumbers};
use kit::ConfigError;
use kit::limits::positive;
use protocol::{Cause, Setting, larger};

use crate::config::boundary::SetConfig;
use crate::config::choice::{Analysis, Base, Kinematics, Plane, Sides, Start};
use crate::config::keys::FemConfig;
use crate::config::keys::FemPlausible;
use crate::config::material::MaterialKind;
use crate::config::mesh::MeshSource;
use crate::mesh::{gmsh, graded, listed_sets};
use crate::model::boundary::Traction;
use crate::model::motion::PrescribedMotion;
use crate::model::probe_points::ProbePoint;

/// Share of the stability limit that `step_s = "auto"` takes by default.
const SAFETY: f64 = 0.9;

/// Least radius of a round wheel in nodal distances: several nodes then resolve its face.
const SPACINGS_MIN: f64 = 4.0;

/// Least number of steps in a period of the sideways motion: 20 chords follow a sine within 1.3 % of its amplitude.
const STEPS_PER_PERIOD: f64 = 20.0;

/// Largest number of sides of a hole that may stand for missing elements: four elements around a node.
const HOLE_SIDES: usize = 8;

/// A size that jumps by more than this from one element to the next reflects waves noticeably.
const RATIO_MAX: f64 = 1.5;

/// Mesh, discretised body, scheme and loads.
#[derive(Clone, Debug)]
pub struct Model {
    /// The mesh.
    pub mesh: Mesh,
    /// Larger of the width and the height of the mesh (m).
    pub(crate) size: f64,
    /// The law of the material.
    pub elastic: Elastic,
    /// Law beyond linear elasticity in small strain, where the scenario has one.
    pub law: Option<NonlinearLaw>,
    /// Kind of element.
    pub element: ElementKind,
    /// Thickness (m).
    pub thickness: f64,
    /// The discretised body.
    pub body: Body,
    /// Step and damping.
    pub scheme: NewmarkScheme,
    /// Largest natural frequency (1/s).
    pub omega_max: f64,
    /// Longest stable step (s).
    pub step_limit: f64,
    /// End of the run (s), where the scenario gives one.
    pub end: Option<f64>,
    /// Loads on named sets.
    pub tractions: Vec<Traction>,
    /// The body's own wheel.
    pub wheel: Option<Wheel>,
    /// True where the bottom is held, so that nothing can be coupled to it.
    pub(crate) supported: bool,
    /// True along x and y where no component is held or moved, so that only forces on the body change its momentum.
    pub(crate) free: [bool; 2],
    /// Prescribed motions of named sets.
    pub motions: Vec<PrescribedMotion>,
    /// Velocity at the start of each component that has one (m/s).
    pub(crate) initial_velocity: BTreeMap<usize, f64>,
    /// Points whose motion is reported.
    pub(crate) probes: Vec<ProbePoint>,
    /// Sets with a prescribed motion of their own.
    pub(crate) moved_sets: Vec<String>,
    /// Times (s) at which keys take effect.
    pub(crate) moments: BTreeMap<String, f64>,
    /// Warnings for the user, before a long run.
    pub warnings: Vec<String>,
    /// The rolling of the wheel, where it rolls.
    pub(crate) roll: Option<rolling::Roll>,
    /// Radius of the wheel's face (m), 0 for a flat face or without a wheel.
    pub(crate) wheel_radius: f64,
    /// The heat of the body, where it has one.
    pub(crate) heat: Option<heat::BodyHeat>,
    /// Bounds of the checks of plausibility.
    pub(crate) plausible: FemPlausible,
}

impl Model {
    /// Builds the body and judges the step.
    pub fn new(config: &FemConfig, setting: &Setting) -> Result<Model, ConfigError> {
        config.check()?;
        positive("thickness_m", setting.thickness_m, "m")?;
        let mut mesh = match &config.mesh {
            MeshSource::Graded(numbers) => graded::build(numbers)?,
            MeshSource::Gmsh(file) => gmsh::read(file)?,
        };
        if let Some(seed) = config.perturb_seed {
            mesh.perturb(seed);
        }
        check_sets(config, &mesh)?;
        let elastic = elastic(config);
        let law = law(config, &elastic);
        let (element, thickness) = (config.element(), setting.thickness_m);
        let mut body = Body::new(&mesh, element, &elastic, thickness);
        let fixed = supports::fixed_components(&mesh, body.layout, (config.base, config.sides));
        body.fix(fixed.into_iter());
        let (tractions, motions, held) = boundary::build(config, &mesh, &mut body, thickness)?;
        let initial_velocity = initial::velocities(&config.initial, &mesh, &body)?;
        let probes = probe_points::locate(&config.probes, &mesh)?;
        let omega_max = spectrum::omega_max(&body);
        let stiffness_damping = config.time.stiffness_damping_s.unwrap_or(0.0);
        let step_limit = spectrum::step_limit(omega_max, config.time.damping, stiffness_damping);
        check_limit(config, step_limit)?;
        let step = choose_step(config, step_limit)?;
        check_wheel(config, &mesh)?;
        check_frequencies(config, step)?;
        let scheme = NewmarkScheme {
            step,
            damping: config.time.damping,
            mass_damping: config.time.mass_damping_per_s.unwrap_or(0.0),
            stiffness_damping,
        };
        let start_damping = config.time.start_mass_damping_per_s.unwrap_or(0.0);
        let mut history = config.wheel.clone();
        if let Some(wheel) = history.as_mut().filter(|_| config.start == Start::Static) {
            // The equilibrium takes the place of the ramp.
            wheel.ramp_s = 0.0;
        }
        let parts = history.as_ref().zip(config.contact.as_ref());
        let wheel = parts.map(|(wheel, contact)| {
            let numbers = WheelNumbers {
                mass: wheel.mass_kg,
                radius: wheel.radius_m,
                friction: contact.friction,
                friction_while_loading: contact.friction_while_loading,
                start_damping,
                thickness,
            };
            let program = wheel.program(mesh.period())?;
            Ok(Wheel::new(program, numbers, &mesh, &body, step))
        });
        let wheel = wheel.transpose()?;
        let roll = wheel
            .as_ref()
            .and_then(|wheel| wheel.program.rolling.as_ref());
        let roll =
            roll.map(|rolling| rolling::Roll::new(config, &mesh, &elastic, thickness, rolling));
        let roll = roll.transpose()?;
        let end = wheel.as_ref().map(|wheel| wheel.program.end());
        let total = end.or(config.time.end_s).map(|end| end / step);
        let total = total.filter(|_| config.analysis == Analysis::Dynamic);
        let heat = heat::BodyHeat::new(config, (&mesh, &elastic), thickness, total)?;
        if let (Analysis::Dynamic, Some(heat)) = (config.analysis, &heat) {
            heat.check_step(step * (heat.every as f64).min(total.unwrap_or(f64::INFINITY)))?;
        }
        let mut warnings = warnings(config, &mesh, &scheme, step_limit);
        warnings.extend(roll.iter().flat_map(rolling::Roll::warnings));
        warnings.extend(held);
        Ok(Model {
            size: mesh.size(),
            heat,
            mesh,
            elastic,
            law,
            moments: config.moments(wheel.as_ref().map(|wheel| &wheel.program)),
            element,
            thickness,
            body,
            scheme,
            omega_max,
            step_limit,
            end: end.or(config.time.end_s),
            tractions,
            wheel,
            free: free(config),
            motions,
            initial_velocity,
            probes,
            supported: config.base != Base::Free,
            moved_sets: config.boundary.moved_sets().map(String::from).collect(),
            warnings,
            roll,
            wheel_radius: config.wheel.as_ref().map_or(0.0, |wheel| wheel.radius_m),
            plausible: config.plausible.clone(),
        })
    }

    /// Mass damping at the end of a step (1/s), with the start phase's damping.
    pub(crate) fn damping_at(&self, step: u64) -> f64 {
        let start = self.wheel.as_ref().map(|wheel| wheel.damping_at(step));
        self.scheme.mass_damping + start.unwrap_or(0.0)
    }

    /// Mass damping at both ends of the step that begins after `step`.
    pub(crate) fn damping_over(&self, step: u64) -> Damping {
        Damping {
            start: self.damping_at(step),
            end: self.damping_at(step + 1),
        }
    }

    /// Mechanisms by which the body dissipates.
    pub(crate) fn dissipates(&self) -> Mechanisms {
        Mechanisms {
            numerical: self.scheme.damping > 0.5,
            mass_damping: self.damping_at(0) > 0.0,
            stiffness_damping: self.scheme.stiffness_damping > 0.0,
            plastic: self.plastic().is_some(),
        }
    }

    /// The plastic law, where the material has one.
    pub fn plastic(&self) -> Option<&J2> {
        self.law.as_ref().and_then(NonlinearLaw::plastic)
    }

    /// The body in equilibrium with its full tractions.
    pub fn static_problem(&self) -> StaticProblem<'_> {
        let mut tractions = vec![0.0; self.body.layout.len()];
        for (index, force) in self.tractions.iter().flat_map(|t| &t.forces) {
            tractions[*index] += force;
        }
        StaticProblem {
            mesh: &self.mesh,
            body: &self.body,
            elastic: &self.elastic,
            element: self.element,
            thickness: self.thickness,
            tractions,
        }
    }

    /// True where warmth expands the body.
    pub(crate) fn expands(&self) -> bool {
        self.heat.as_ref().is_some_and(heat::BodyHeat::expands)
    }

    /// Nodal forces (N) of the stresses of [`NodalState::thermal`], on elements that push outwards: the integral of B^T (s, s, 0).
    pub(crate) fn thermal_forces(&self, thermal: &[f64]) -> Vec<f64> {
        let layout = self.body.layout;
        let mut forces = vec![0.0; if thermal.is_empty() { 0 } else { layout.len() }];
        for (element, stress) in self.mesh.element_indices().zip(thermal) {
            let [column, row] = element;
            let p = self.mesh.corner_points(element);
            let nodes = self.mesh.corners(column, row);
            for (k, node) in nodes.into_iter().enumerate() {
                let (next, last) = (p[(k + 1) % 4], p[(k + 3) % 4]);
                let half = 0.5 * self.thickness * stress;
                for (component, side) in [(0, next[1] - last[1]), (1, last[0] - next[0])] {
                    forces[layout.tied_to(layout.index(node, component))] += half * side;
                }
            }
        }
        forces
    }

    /// Gives a state the yield stresses and the thermal stresses of these temperatures, where they depend on them.
    pub(crate) fn warm(&self, state: &mut heat::HeatState, body: &mut NodalState) {
        if let Some(heat) = self.heat.as_ref().filter(|heat| heat.expands()) {
            let elements = self.mesh.element_indices();
            let now = elements.map(|element| heat.thermal_stress(state, element));
            body.thermal[1] = now.collect();
            let count = body.thermal[1].len();
            body.thermal[0].resize(count, 0.0);
        }
        if let Some(heat) =
            (self.heat.as_ref()).filter(|_| self.plastic().is_some_and(|j2| j2.softens))
        {
            let factor = |element| heat.yield_factor(state, element);
            let changed = self.body.soften(&mut body.history, factor);
            state.yielding = larger(state.yielding, changed);
        }
    }

    /// 4 L / c_p (s), the first period of a column of the largest height L, held at its base and free at its top: a pressure wave crosses it four
    /// times.
    pub fn first_period(&self) -> f64 {
        let [_, height] = self.mesh.extents();
        4.0 * height / (self.elastic.c11 / self.elastic.density).sqrt()
    }
}

/// Directions in which nothing holds or moves a part of the body.
fn free(config: &FemConfig) -> [bool; 2] {
    let free = config.base == Base::Free && config.sides == Sides::Free;
    let motions = || config.boundary.0.values().filter_map(SetConfig::prescribed);
    [0, 1].map(|k| free && motions().all(|motion| motion.components()[k].0.is_none()))
}

/// An unstructured mesh must name the edges that other keys use.
fn check_sets(config: &FemConfig, mesh: &Mesh) -> Result<(), ConfigError> {
    if mesh.connectivity.is_none() {
        return Ok(());
    }
    let has = |edge: Edge| mesh.set(edge.name()).is_some();
    let refusals = [
        (
            config.base != Base::Free && !has(Edge::Bottom),
            "base",
            "holds the group `bottom` of the mesh, which has none; name it, or write base = \"free\"",
        ),
        (
            config.sides == Sides::FixedX && !has(Edge::Left) && !has(Edge::Right),
            "sides",
            "holds the groups `left` and `right` of the mesh, which has neither; name one, or write sides = \"free\"",
        ),
        (
            config.wheel.is_some() && mesh.open_line(Edge::Top.name()).is_none(),
            "wheel",
            "presses on the group `top` of the mesh, which must be one open line on the outline of the body",
        ),
    ];
    if let Some((_, key, problem)) = refusals.into_iter().find(|(refused, ..)| *refused) {
        return Err(ConfigError::new(key, problem)
            .because(Cause::UnknownName)
            .help(listed_sets(mesh)));
    }
    Ok(())
}

/// Only a body that is moved everywhere has no limit.
fn check_limit(config: &FemConfig, limit: f64) -> Result<(), ConfigError> {
    let moved = config.boundary.moved_sets().next().is_some();
    if moved || (limit > 0.0 && limit.is_finite()) {
        return Ok(());
    }
    let problem = format!(
        "gives a body whose stability limit is {limit:e} s: its numbers overflow or underflow"
    );
    Err(ConfigError::new("material", problem)
        .help("check the units of run.thickness_m, mesh and material (SI)"))
}

/// A round face between two nodes touches neither.
fn check_wheel(config: &FemConfig, mesh: &Mesh) -> Result<(), ConfigError> {
    let Some(wheel) = &config.wheel else {
        return Ok(());
    };
    let spacing = spacing_below_wheel(mesh);
    if wheel.radius_m > 0.0 && wheel.radius_m < SPACINGS_MIN * spacing {
        let problem = format!(
            "{:e} m is less than {SPACINGS_MIN} times the {spacing:.3e} m between the nodes below the wheel, which would fall between them",
            wheel.radius_m
        );
        return Err(ConfigError::new("wheel.radius_m", problem).help(
            "check the unit (m), enlarge it, refine mesh.size_m, or write 0 for a flat face",
        ));
    }
    Ok(())
}

/// A few steps in a period do not follow the prescribed motion.
fn check_frequencies(config: &FemConfig, step: f64) -> Result<(), ConfigError> {
    if config.analysis != Analysis::Dynamic || config.time.unsafe_step {
        return Ok(());
    }
    let wheel = config.wheel.iter().filter(|wheel| wheel.cycles > 0.0);
    let wheel = wheel.map(|wheel| ("wheel".to_string(), wheel.frequency_hz));
    let moved = config.boundary.0.iter().filter_map(|(name, set)| {
        let motion = set.motion.as_ref()?;
        Some((format!("boundary.{name}.motion"), motion.frequency_hz))
    });
    for (key, frequency) in wheel.chain(moved) {
        if frequency * step * STEPS_PER_PERIOD > 1.0 {
            let problem = format!(
                "a period of {:e} s holds fewer than {STEPS_PER_PERIOD} steps of {step:.3e} s",
                1.0 / frequency
            );
            return Err(ConfigError::new(&format!("{key}.frequency_hz"), problem)
                .because(Cause::StepTooLong)
                .help("check the unit (1/s), lower it, or shorten time.step_s"));
        }
    }
    Ok(())
}

/// Distance of the two nodes of the upper edge between or at which the wheel comes down (m).
fn spacing_below_wheel(mesh: &Mesh) -> f64 {
    let points = mesh.surface_points(Edge::Top);
    let nearest = |pair: &[[f64; 2]]| pair[0][0].abs().max(pair[1][0].abs());
    points
        .windows(2)
        .min_by(|a, b| nearest(a).total_cmp(&nearest(b)))
        .map_or(0.0, |pair| {
            (pair[1][0] - pair[0][0]).hypot(pair[1][1] - pair[0][1])
        })
}

/// The plane reduction of the material.
fn elastic(config: &FemConfig) -> Elastic {
    let material = &config.material;
    let (young, density) = (material.young_pa, material.density_kg_per_m3);
    match config.plane {
        Plane::Strain => Elastic::plane_strain(young, material.poisson, density),
        Plane::Stress => Elastic::plane_stress(young, material.poisson, density),
    }
}

/// The law, unless it is linear elasticity in small strain.
fn law(config: &FemConfig, elastic: &Elastic) -> Option<NonlinearLaw> {
    let (material, heat) = (&config.material, config.heat.as_ref());
    match (material.law(), config.kinematics) {
        (MaterialKind::J2, _) => Some(NonlinearLaw::Plastic(J2 {
            mu: elastic.c33,
            yield_stress: material.yield_pa?,
            isotropic: material.hardening_pa.unwrap_or(0.0),
            kinematic: material.kinematic_hardening_pa.unwrap_or(0.0),
            softens: heat.is_some_and(|heat| heat.softening.is_some()),
        })),
        (MaterialKind::Elastic, Kinematics::Corotational) => Some(NonlinearLaw::Corotational),
        (MaterialKind::Elastic, Kinematics::Small) => None,
    }
}

/// The stability limit in words.
pub(crate) fn limit_name(stiffness_damping: f64) -> &'static str {
    if stiffness_damping > 0.0 {
        "stability limit (sqrt(2/damping + 4 xi^2) - 2 xi)/omega_max, xi = stiffness_damping_s omega_max/2,"
    } else {
        "stability limit sqrt(2/damping)/omega_max"
    }
}

fn choose_step(config: &FemConfig, limit: f64) -> Result<f64, ConfigError> {
    let time = &config.time;
    match time.step_s.0 {
        // A static analysis takes no steps in time.
        _ if config.analysis == Analysis::Static => Ok(SAFETY * limit),
        None => Ok(time.safety.unwrap_or(SAFETY) * limit),
        Some(step) if step < limit || time.unsafe_step => Ok(step),
        Some(step) => {
            let problem = format!(
                "{step:.4e} s is not below the {} = {limit:.4e} s of this mesh",
                limit_name(time.stiffness_damping_s.unwrap_or(0.0))
            );
            Err(ConfigError::new("time.step_s", problem)
                .because(Cause::StepTooLong)
                .help(format!(
                "take {:.2e} or \"auto\"; `unsafe_step = true` runs it all the same, to show how it diverges",
                SAFETY * limit
            )))
        }
    }
}

fn warnings(config: &FemConfig, mesh: &Mesh, scheme: &NewmarkScheme, limit: f64) -> Vec<String> {
    let mut warnings = Vec::new();
    if scheme.step >= limit {
        warnings.push(format!(
            "time.step_s: {:.4e} s is above the stability limit {limit:.4e} s, the run will diverge; `unsafe_step` accepts it",
            scheme.step
        ));
    }
    let dynamic = config.analysis == Analysis::Dynamic;
    if dynamic && config.time.safety.is_some() && config.time.step_s.0.is_some() {
        warnings.push("time.safety: has no effect on a step in seconds".into());
    }
    let elastic = config.material.law() == MaterialKind::Elastic;
    let wheel = config.wheel.as_ref();
    let cycles = wheel.is_some_and(|wheel| wheel.cycles > 0.0);
    let of_heat = [
        "heat_balance_rel",
        "thermal_depth_rel",
        "heat_exchange_rel",
        "heat_steps_rel",
        "surface_temperature_k",
        "below_zero_k",
        "wheel_points_rel",
    ];
    let of_wheels = ["wheel_force_rel", "contact_reach_rel", "contact_resolution"];
    warnings.extend(config.plausible.idle(&[
        (
            config.reduced.is_none(),
            "without reduced",
            &["far_field_rel"],
        ),
        (elastic, "on an elastic material", &["plastic_element"]),
        (config.heat.is_none(), "without heat", &of_heat),
        (wheel.is_none(), "without a wheel", &of_wheels),
        (!cycles, "without cycles of a wheel", &["cycle_drift_rel"]),
    ]));
    let unused = config.unused_keys();
    if !unused.is_empty() {
        let kind = ["dynamic", "static"][usize::from(!dynamic)];
        warnings.push(format!(
            "{}: not used in a {kind} analysis of these keys",
            unused.join(", ")
        ));
    }
    for (key, ratio) in [
        ("mesh.side_columns", mesh.ratio_columns),
        ("mesh.depth_rows", mesh.ratio_rows),
    ] {
        if ratio > RATIO_MAX {
            let effect = if dynamic {
                "will reflect waves"
            } else {
                "the outer elements err"
            };
            warnings.push(format!(
                "{key}: sizes grow {ratio:.2}-fold from one element to the next and {effect}; take more of them"
            ));
        }
    }
    warnings.extend(mesh.connectivity.iter().flat_map(|all| pieces(mesh, all)));
    warnings
}

/// Small holes and loose parts of a mesh from a file.
fn pieces(mesh: &Mesh, connectivity: &Connectivity) -> Vec<String> {
    let (mut warnings, mut parts) = (Vec::new(), 0);
    for line in connectivity.loops() {
        let sides = line.len();
        let point = |k: usize| mesh.points[line[k % sides]];
        let [x, y] = [0, 1].map(|c| (0..sides).map(|k| point(k)[c]).sum::<f64>() / sides as f64);
        let swept = |[p, q]: [[f64; 2]; 2]| (p[0] - x) * (q[1] - y) - (p[1] - y) * (q[0] - x);
        let area: f64 = (0..sides).map(|k| swept([point(k), point(k + 1)])).sum();
        parts += usize::from(area > 0.0);
        if area > 0.0 && parts > 1 {
            warnings.push(format!("mesh.gmsh: part {parts} of the body, around ({x:.4e}, {y:.4e}) m, shares no node with the others and moves by itself; close the seam and mesh anew where it is meant to be joined (`Coherence;`)"));
        } else if sides == 1 {
            warnings.push(format!("mesh.gmsh: two parts of the outline meet in the node at ({x:.4e}, {y:.4e}) m, a hinge; join them by sides of elements, or keep them apart"));
        } else if area < 0.0 && sides <= HOLE_SIDES {
            warnings.push(format!("mesh.gmsh: the mesh has a hole of {sides} sides around ({x:.4e}, {y:.4e}) m: are elements missing there? An intended hole is rounder, with more than {HOLE_SIDES} sides"));
        }
    }
    warnings
}
