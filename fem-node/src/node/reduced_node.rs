//! A supported linear body in motion as its lowest modes.

use std::collections::BTreeMap;

use fem_kernel::integrate::state::NodalState;
use fem_kernel::mesh::Edge;
use fem_kernel::pack::largest;
use fem_kernel::reduced::ReducedBody;
use fem_kernel::reduced::modes::ModeChoice;
use fem_kernel::reduced::near::NearChoice;
use fem_kernel::reduced::surface::{FreeMotion, ReducedState, ReducedSurface, ReducedWindow};
use kit::keys::refuse_if;
use kit::rolling::nearest_image;
use protocol::{Setting, Window};
use serde::{Deserialize, Serialize};

use super::reduced_kept::KeptParts;
use super::windows::{FORCE, diverged, gained};
use crate::config::keys::FemConfig;
use crate::config::reduced::{NearReach, ReducedConfig};
use crate::error::FemError;
use crate::interface::Interface;
use crate::interface::window::{EXCESS, EnergyExcess};
use crate::model::Model;
use crate::model::heat::{BodyHeat, HeatState};
use crate::output::probe::PressureMaxima;
use crate::output::reduced_ledger::ReducedLedger;
use crate::output::snapshot::Snapshots;

/// Distances of neighbouring exchanged points in the shortest near field that is chosen.
const SPACINGS_MIN: f64 = 2.0;

/// Number of steps of a window, force and displacements at its end.
type WindowMotion = (u32, [Vec<f64>; 2]);

/// A linear body as its lowest modes and its static flexibility ([`fem_kernel::reduced`]).
pub struct ReducedNode {
    /// Mesh, body, scheme and loads.
    pub model: Model,
    pub(super) snapshots: Snapshots,
    pub(super) body: ReducedBody,
    pub(super) kept: KeptParts,
    pub(super) near: NearReach,
    pub(super) interface: Interface,
    /// Components that reports read, beside the exchanged ones.
    reported: Vec<usize>,
    /// The surface of the present selection.
    surface: Option<ReducedSurface>,
    /// Windows by numbers of steps.
    pub(super) windows: BTreeMap<u32, ReducedWindow>,
    /// The motion of the next window without interface force, and its number of steps.
    pub(super) free: Option<(u32, FreeMotion)>,
    /// C_far of the committed force in windows of this number of steps.
    pub(super) far: Option<(u32, Vec<f64>)>,
    pub(super) committed: ReducedCommitted,
    /// Last window advanced: index, and its steps and motion.
    pub(super) pending: Option<(u64, WindowMotion)>,
    /// True after a window with more kinetic energy than the loads gave.
    pub(super) suspected: bool,
    /// The committed state in the reported components only.
    pub(super) seen: NodalState,
}

/// Everything that accepted windows change.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(super) struct ReducedCommitted {
    pub(super) state: ReducedState,
    pub(super) ledger: ReducedLedger,
    /// Own steps since the start.
    pub(super) steps: u64,
    /// Steps of all windows, repeated ones included.
    pub(super) steps_done: u64,
    /// Windows of modes computed, repeated ones included.
    pub(super) mode_windows: u64,
    /// Steps of the longest window.
    pub(super) longest: u32,
    /// Largest pressures at the snapshot of the hold.
    pub(super) hold_maxima: Option<PressureMaxima>,
    /// Temperatures, where the body has them.
    pub(super) heat: HeatState,
    /// Largest strain at the ends of the phases so far.
    pub(super) strain_max: f64,
}

impl ReducedNode {
    /// Builds the body and computes its modes; it starts undeformed and at rest.
    pub fn new(
        config: &FemConfig,
        reduced: ReducedConfig,
        setting: &Setting,
    ) -> Result<ReducedNode, FemError> {
        let model = Model::new(config, setting)?;
        let count = reduced.modes.map(|count| ModeChoice::Count(count as usize));
        let choice = count.or(reduced.omega_max_per_s.map(ModeChoice::UpTo));
        let choice = choice.expect("the configuration has been checked");
        let mut body = ReducedBody::default();
        let mut kept = KeptParts::new(&model, choice, setting);
        let modes = || body.lowest(&model.static_problem(), choice);
        body.modes = kept.value("modes", "", modes)?;
        refuse_if(
            body.modes.omega.is_empty(),
            "reduced.omega_max_per_s",
            format!(
                "lies below the lowest frequency of the body, {:.3e} 1/s, and a body without modes has no mass",
                body.modes.neglected.unwrap_or_default()
            ),
            "raise it, or give modes = 50",
        )?;
        let heat = model.heat.as_ref().map(BodyHeat::at_start);
        Ok(ReducedNode {
            snapshots: Snapshots::new(setting),
            body,
            kept,
            near: reduced.near_m,
            interface: Interface::default(),
            reported: Vec::new(),
            surface: None,
            windows: BTreeMap::new(),
            free: None,
            far: None,
            committed: ReducedCommitted {
                heat: heat.unwrap_or_default(),
                ..ReducedCommitted::default()
            },
            pending: None,
            suspected: false,
            seen: NodalState::at_rest(&model.body),
            model,
        })
    }

    /// Forgets everything that belongs to another selection.
    pub(super) fn reselect(&mut self) {
        (self.surface, self.free, self.pending) = (None, None, None);
        self.far = None;
        self.windows.clear();
    }

    /// The surface of the present selection.
    pub(super) fn surface(&mut self) -> Result<&ReducedSurface, FemError> {
        let surface = match self.surface.take() {
            Some(surface) => surface,
            None => self.built()?,
        };
        Ok(self.surface.insert(surface))
    }

    fn built(&mut self) -> Result<ReducedSurface, FemError> {
        let (exchanged, model) = (&self.interface.components, &self.model);
        self.reported = reported_components(model);
        self.reported
            .retain(|component| !exchanged.contains(component));
        let rows = [&exchanged[..], &self.reported[..]];
        let loads = model.tractions.iter();
        let loads: Vec<&[(usize, f64)]> = loads.map(|load| &*load.forces).collect();
        let recipe = format!(", surface {rows:?} with the loads {loads:?}");
        let (body, problem) = (&mut self.body, (&model.static_problem(), model.scheme));
        let make = || ReducedSurface::new(body, problem, rows, &loads);
        let mut surface = self.kept.value("surface", &recipe, make)?;
        // The scheme decides nothing else of a surface.
        surface.scheme = model.scheme;
        self.committed.state = surface.at_rest();
        Ok(surface)
    }

    /// Builds the surface, and the window of these steps, unless they are known.
    pub(super) fn prepare(&mut self, substeps: u32) -> Result<(), FemError> {
        if substeps == 0 {
            return Err(FemError::NoSteps);
        }
        self.surface()?;
        if self.windows.contains_key(&substeps) {
            return Ok(());
        }
        let window = self.split(substeps, None)?;
        if !window.field.is_stable() {
            let needed = self.split(substeps, Some(window.field.reach))?;
            return Err(FemError::NearTooShort {
                near_m: window.field.reach,
                radius: window.field.radius,
                needed_m: needed.field.reach,
                modes: self.body.modes.omega.len(),
                substeps,
                window_s: self.model.scheme.step * f64::from(substeps),
            });
        }
        self.windows.insert(substeps, window);
        self.committed.longest = self.committed.longest.max(substeps);
        Ok(())
    }

    /// A window of these steps, its near field as configured or the least stable one from this distance on (m).
    fn split(&mut self, substeps: u32, from: Option<f64>) -> Result<ReducedWindow, FemError> {
        let (model, interface) = (&self.model, &self.interface);
        let points = interface.exchanged.iter();
        let points: Vec<[f64; 2]> = points.map(|n| model.mesh.point(n[0], n[1])).collect();
        let period = model.mesh.period();
        let distance = |i: usize, j: usize| {
            let [p, q] = [points[i / 2], points[j / 2]];
            nearest_image(p[0] - q[0], period).hypot(p[1] - q[1])
        };
        let spacing = (1..points.len()).map(|i| distance(2 * i, 2 * i - 2));
        let least = spacing.fold(f64::INFINITY, f64::min).min(model.size);
        let choice = match (from, self.near.0) {
            (Some(from), _) => NearChoice::From(from.max(least)),
            (None, None) => NearChoice::From(SPACINGS_MIN * least),
            (None, Some(reach)) => NearChoice::Exactly(reach),
        };
        let (scheme, exchanged) = (model.scheme, &interface.components);
        let recipe =
            format!(", {substeps} steps of {scheme:?} with {choice:?} between {exchanged:?}");
        let surface = self.surface.as_ref().expect("it was built before");
        let make = || Ok(surface.window(substeps, distance, choice));
        Ok(self.kept.value("window", &recipe, make)?)
    }

    /// Runs a window under an interface force, and returns the increments of the exchanged components (m).
    pub(super) fn try_window(
        &mut self,
        window: &Window,
        force: &[f64],
    ) -> Result<Vec<f64>, FemError> {
        FORCE.admit(window, force, self.interface.components.len())?;
        self.pending = None;
        self.prepare(window.substeps)?;
        let (model, committed) = (&self.model, &mut self.committed);
        let (surface, of_window) = (self.surface.as_ref(), &self.windows[&window.substeps]);
        let surface = surface.expect("it was prepared");
        let known = self.free.as_ref().map(|(substeps, _)| *substeps);
        if known != Some(window.substeps) {
            let (start, h) = (committed.steps, model.scheme.step);
            let factor = |load: usize, k: u32| {
                model.tractions[load].factor((start + u64::from(k)) as f64 * h)
            };
            let far = self.far.take().filter(|(n, _)| *n == window.substeps);
            let far = far.map(|(_, far)| far);
            let free = surface.free(of_window, &committed.state, factor, far);
            self.free = Some((window.substeps, free));
        }
        let (_, free) = self.free.as_ref().expect("it was just made");
        let displacement = surface.displacement(of_window, free, force);
        committed.steps_done += u64::from(window.substeps);
        committed.mode_windows += self.body.modes.omega.len() as u64;
        let far = largest(displacement.iter().map(|u| u.abs()));
        if far.is_nan() || far >= model.size {
            let steps = committed.steps + u64::from(window.substeps);
            return Err(diverged(model, window, steps, far));
        }
        let before = &committed.state.displacement;
        let increments = displacement.iter().zip(before).map(|(new, old)| new - old);
        let increments = increments.collect();
        let input = [force.to_vec(), displacement];
        self.pending = Some((window.index, (window.substeps, input)));
        Ok(increments)
    }

    /// Makes the last window the committed state.
    pub(super) fn try_commit(&mut self, window: &Window) -> Result<(), FemError> {
        let advanced = FemError::advanced(window, self.pending.take())?;
        let (substeps, [force, displacement]) = advanced;
        let (surface, free) = (self.surface.as_ref(), self.free.take());
        let (surface, (_, free)) = surface.zip(free).expect("the window was advanced");
        let committed = &mut self.committed;
        let motion = (&committed.state, &free);
        let of_window = &self.windows[&substeps];
        let end = surface.commit(of_window, motion, &force, &displacement);
        committed.ledger.add(&end.energies);
        let before = committed.steps;
        (committed.state, committed.steps) = (end.state, before + u64::from(substeps));
        if let Some(heat) = &self.model.heat {
            let time = (committed.steps, self.model.scheme.step);
            heat.pass(&mut committed.heat, time);
        }
        self.far = Some((substeps, end.far));
        self.see(&end.beside);
        self.check_energy(window)
    }

    /// Refuses a diverging run long before its displacements are large. In one window alone the modes may move before a load has done work.
    fn check_energy(&mut self, window: &Window) -> Result<(), FemError> {
        let (ledger, steps) = (&self.committed.ledger, self.committed.steps);
        let before = std::mem::take(&mut self.suspected);
        if ledger.kinetic <= EXCESS * ledger.supplied {
            return Ok(());
        }
        self.suspected = true;
        if !before && ledger.kinetic.is_finite() {
            return Ok(());
        }
        let found = EnergyExcess {
            step: steps,
            kinetic: ledger.kinetic,
            supplied: ledger.supplied,
        };
        Err(gained(&self.model, window, found))
    }

    /// Enters the displacements of the surface, those beside the exchanged ones given, and the velocities of probes.
    fn see(&mut self, beside: &[f64]) {
        let exchanged = &self.interface.components;
        let rows = || exchanged.iter().chain(&self.reported);
        let moved = self.committed.state.displacement.iter().chain(beside);
        rows()
            .zip(moved)
            .for_each(|(component, u)| self.seen.u[*component] = *u);
        let surface = self.surface.as_ref();
        if let Some(surface) = surface.filter(|_| !self.model.probes.is_empty()) {
            let velocities = surface.velocities(&self.committed.state);
            rows()
                .zip(velocities)
                .for_each(|(component, v)| self.seen.v[*component] = v);
        }
    }

    /// Displacements and velocities of the whole body.
    pub(super) fn recovered(&mut self) -> Result<NodalState, FemError> {
        self.surface()?;
        let committed = &self.committed;
        let mut force = vec![0.0; self.model.body.layout.len()];
        let t = committed.steps as f64 * self.model.scheme.step;
        for load in &self.model.tractions {
            let factor = load.factor(t);
            load.forces
                .iter()
                .for_each(|(c, f)| force[*c] += factor * f);
        }
        let exchanged = self.interface.components.iter();
        exchanged
            .zip(&committed.state.force)
            .for_each(|(c, f)| force[*c] += f);
        let (problem, modes) = (self.model.static_problem(), &committed.state.modes);
        let [u, v] = self.body.recovered(&problem, modes, &force)?;
        let mut state = NodalState::at_rest(&self.model.body);
        state.u.copy_from_slice(&u);
        state.v.copy_from_slice(&v);
        Ok(state)
    }

    pub(super) fn residual_share(&self) -> f64 {
        self.surface
            .as_ref()
            .map_or(0.0, |surface| surface.residual_share)
    }
}

/// Components of the upper edge, and of the nodes around probes.
fn reported_components(model: &Model) -> Vec<usize> {
    let layout = model.body.layout;
    let probes = model.probes.iter().flat_map(|probe| probe.at());
    let probes = probes.flat_map(|node| layout.components(node));
    let edge = model.mesh.edge(Edge::Top).into_iter();
    let edge = edge.map(|node| layout.index(node, 1));
    let mut all: Vec<usize> = edge.chain(probes).collect();
    all.sort_unstable();
    all.dedup();
    all
}
