//! The components of a reduced body that are exchanged, loaded or reported, over a window.

use nalgebra::DMatrix;
use serde::{Deserialize, Serialize};

use super::modes::{add, add_columns, dot};
use super::near::{NearChoice, NearField};
use super::oscillator::{ModeLoss, ModeState, WindowMap, stepped};
use super::{ReducedBody, factor};
use crate::error::KernelError;
use crate::scheme::NewmarkScheme;
use crate::statics::problem::StaticProblem;

/// Modes and flexibility of the components that a run reads, the exchanged ones first.
#[derive(Serialize, Deserialize)]
pub struct ReducedSurface {
    /// The scheme that moves the modes.
    pub scheme: NewmarkScheme,
    omega: Vec<f64>,
    exchanged: usize,
    rows: usize,
    /// phi of all rows, mode after mode.
    shapes: Vec<f64>,
    /// phi of the exchanged rows, row after row.
    amplitudes: Vec<f64>,
    /// F_res of the exchanged components (m/N).
    residual: DMatrix<f64>,
    /// F_res of the other rows under a unit force on each exchanged component (m/N), column after column.
    beside: Vec<f64>,
    /// Responses to the loads of sets.
    loads: Vec<LoadResponse>,
    /// Share of the static flexibility of the exchanged components that F_res carries.
    pub residual_share: f64,
}

/// Response to a load of a set, at full load.
#[derive(Serialize, Deserialize)]
struct LoadResponse {
    /// Phi^T f of each mode.
    modal: Vec<f64>,
    /// F_res f of all rows (m).
    residual: Vec<f64>,
    /// Work of each load on F_res f (J).
    works: Vec<f64>,
}

/// A window of n steps of a surface.
#[derive(Serialize, Deserialize)]
pub struct ReducedWindow {
    substeps: u32,
    maps: Vec<WindowMap>,
    /// The compliance of the exchanged components.
    pub field: NearField,
}

/// The part of a reduced body that windows change.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ReducedState {
    /// Displacement and velocity of each mode.
    pub modes: Vec<ModeState>,
    /// Interface force of the last window (N).
    pub force: Vec<f64>,
    /// Displacements of the exchanged components (m).
    pub displacement: Vec<f64>,
    /// F_res f of the exchanged components (m).
    residual: Vec<f64>,
    /// Factor of each load, and its work on F_res f (J) at full load.
    loads: Vec<[f64; 2]>,
    /// Displacements of the exchanged components by the lag of the far field (m).
    lag: Vec<f64>,
}

impl ReducedState {
    /// Every number that changes a later one.
    pub fn numbers(&self) -> impl Iterator<Item = f64> + '_ {
        let modes = self.modes.iter().flat_map(|mode| [mode.u, mode.v]);
        let vectors = [&self.force, &self.displacement, &self.residual, &self.lag];
        let rest = self.loads.iter().flatten();
        modes.chain(rest.chain(vectors.into_iter().flatten()).copied())
    }
}

/// The motion of a window without interface force.
pub struct FreeMotion {
    displacement: Vec<f64>,
    /// C_far of the last interface force (m).
    far: Vec<f64>,
    /// Factor of each load, at the start and after each step.
    factors: Vec<Vec<f64>>,
}

/// The end of a window.
pub struct WindowEnd {
    /// The state.
    pub state: ReducedState,
    /// The energies.
    pub energies: ReducedEnergies,
    /// Displacements of the rows that are not exchanged (m).
    pub beside: Vec<f64>,
    /// C_far of the interface force (m).
    pub far: Vec<f64>,
}

/// Energies of a window (J): works, losses, and the energies stored at its end.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ReducedEnergies {
    /// lambda du.
    pub interface_work: f64,
    /// [(1-b) f + b f'] du of the loads, without the lag of the far field.
    pub applied_work: f64,
    /// Taken by the scheme and the mass damping of the modes.
    pub losses: ModeLoss,
    /// Taken by the residual flexibility, the acting forces less the means of their ends, times its displacement: dlambda dw/2 + (b-1/2) df dw with
    /// w = F_res (lambda + f).
    pub residual_loss: f64,
    /// Taken by the far field, lambda d(-C_far dlambda); of either sign.
    pub lag: f64,
    /// omega^2 u^2/2 of the modes, and f F_res f/2.
    pub strain: f64,
    /// v^2/2 of the modes.
    pub kinetic: f64,
}

impl ReducedSurface {
    /// The surface of a body with these exchanged components, other reported ones, and loads as components and forces (N).
    pub fn new(
        body: &mut ReducedBody,
        (problem, scheme): (&StaticProblem, NewmarkScheme),
        [exchanged, reported]: [&[usize]; 2],
        loads: &[&[(usize, f64)]],
    ) -> Result<ReducedSurface, KernelError> {
        let rows: Vec<usize> = exchanged.iter().chain(reported).copied().collect();
        let (count, sources) = (rows.len(), exchanged.len());
        let loads = load_responses(body, problem, &rows, loads)?;
        let (modes, factor) = (&body.modes, factor(&mut body.factor, problem)?);
        let by_row = rows.iter().map(|c| modes.amplitudes(factor, *c).collect());
        let by_row: Vec<Vec<f64>> = by_row.collect();
        let omega = modes.omega.clone();
        let shapes: Vec<f64> = (0..omega.len())
            .flat_map(|k| by_row.iter().map(move |row| row[k]))
            .collect();
        let softness: Vec<f64> = omega.iter().map(|omega| 1.0 / (omega * omega)).collect();
        let flexibility = factor.columns(exchanged, &rows);
        let of_modes = |i: usize, j: usize| {
            let products = by_row[i].iter().zip(&by_row[j]).zip(&softness);
            products.map(|((a, b), s)| a * b * s).sum::<f64>()
        };
        let mut residual =
            DMatrix::from_fn(count, sources, |i, j| flexibility[j][i] - of_modes(i, j));
        for (i, j) in (0..sources).flat_map(|i| (0..i).map(move |j| (i, j))) {
            let mean = 0.5 * (residual[(i, j)] + residual[(j, i)]);
            (residual[(i, j)], residual[(j, i)]) = (mean, mean);
        }
        let trace = |of: &dyn Fn(usize) -> f64| (0..sources).map(of).sum::<f64>();
        let share = trace(&|i| residual[(i, i)]) / trace(&|i| flexibility[i][i]);
        Ok(ReducedSurface {
            scheme,
            exchanged: sources,
            rows: count,
            shapes,
            amplitudes: by_row[..sources].concat(),
            beside: residual
                .rows(sources, count - sources)
                .iter()
                .copied()
                .collect(),
            residual: residual.rows(0, sources).into_owned(),
            loads,
            residual_share: if sources > 0 { share } else { 0.0 },
            omega,
        })
    }

    /// At rest, undeformed.
    pub fn at_rest(&self) -> ReducedState {
        let zero = || vec![0.0; self.exchanged];
        ReducedState {
            modes: vec![ModeState::default(); self.omega.len()],
            force: zero(),
            displacement: zero(),
            residual: zero(),
            loads: vec![[0.0; 2]; self.loads.len()],
            lag: zero(),
        }
    }

    /// True where a state has the lengths of this surface.
    pub fn fits(&self, state: &ReducedState) -> bool {
        let lengths = |s: &ReducedState| {
            let vectors = [&s.force, &s.displacement, &s.residual, &s.lag];
            (s.modes.len(), s.loads.len(), vectors.map(Vec::len))
        };
        lengths(state) == lengths(&self.at_rest())
    }

    /// A window of these steps; `distance` is the distance of two exchanged components (m).
    pub fn window(
        &self,
        substeps: u32,
        distance: impl Fn(usize, usize) -> f64,
        choice: NearChoice,
    ) -> ReducedWindow {
        let maps = self.omega.iter();
        let maps = maps.map(|omega| WindowMap::new(&self.scheme, *omega, substeps));
        let maps: Vec<WindowMap> = maps.collect();
        let row = |i: usize| &self.amplitudes[i * maps.len()..(i + 1) * maps.len()];
        let compliance = |i: usize, j: usize| {
            let (i, j) = (i.min(j), i.max(j));
            let products = row(i).iter().zip(row(j)).zip(&maps);
            let moved: f64 = products.map(|((a, b), map)| a * b * map.compliance()).sum();
            moved + self.residual[(i, j)]
        };
        let compliance = DMatrix::from_fn(self.exchanged, self.exchanged, compliance);
        ReducedWindow {
            substeps,
            field: NearField::choose(&compliance, distance, choice),
            maps,
        }
    }

    /// The motion of a window from this state without interface force; `factor` is the factor of a load after a number of steps of the window, `far` the
    /// C_far of the present interface force in such windows, if it is known.
    pub fn free(
        &self,
        window: &ReducedWindow,
        state: &ReducedState,
        factor: impl Fn(usize, u32) -> f64,
        far: Option<Vec<f64>>,
    ) -> FreeMotion {
        let all = |load: usize| (0..=window.substeps).map(|k| factor(load, k)).collect();
        let factors: Vec<Vec<f64>> = (0..self.loads.len()).map(all).collect();
        let none = vec![0.0; self.omega.len()];
        let moved = self.moved(window, state, &none, &factors);
        let modes: Vec<ModeState> = moved.into_iter().map(|(end, ..)| end).collect();
        let far = far.unwrap_or_else(|| window.field.far(&state.force));
        let mut displacement = far.clone();
        self.add_modes(&modes, 0, &mut displacement);
        for (load, factors) in self.loads.iter().zip(&factors) {
            let residual = &load.residual[..self.exchanged];
            let last = factors[window.substeps as usize];
            add(&mut displacement, last, residual);
        }
        FreeMotion {
            displacement,
            far,
            factors,
        }
    }

    /// Displacements of the exchanged components at the end of the window under this interface force (m).
    pub fn displacement(
        &self,
        window: &ReducedWindow,
        free: &FreeMotion,
        force: &[f64],
    ) -> Vec<f64> {
        let mut displacement = free.displacement.clone();
        window.field.add_near(force, &mut displacement);
        displacement
    }

    /// The end of the window under this interface force, with the displacements that it gave.
    pub fn commit(
        &self,
        window: &ReducedWindow,
        (state, free): (&ReducedState, &FreeMotion),
        force: &[f64],
        displacement: &[f64],
    ) -> WindowEnd {
        let modal = self.modal_force(force);
        let moved = self.moved(window, state, &modal, &free.factors);
        let modes: Vec<ModeState> = moved.iter().map(|(end, ..)| *end).collect();
        let far = window.field.far(force);
        let both = free.far.iter().zip(&far);
        let lag: Vec<f64> = both.map(|(old, new)| old - new).collect();
        // u = Phi eta + F_res f + lag, without another product with F_res.
        let mut residual: Vec<f64> = vec![0.0; self.exchanged];
        self.add_modes(&modes, 0, &mut residual);
        for ((sum, u), lag) in residual.iter_mut().zip(displacement).zip(&lag) {
            *sum = u - *sum - lag;
        }
        let end = ReducedState {
            loads: self.load_works(force, &free.factors, window.substeps as usize),
            modes,
            force: force.to_vec(),
            displacement: displacement.to_vec(),
            residual,
            lag,
        };
        let mut energies = self.energies(state, &end, &free.factors);
        for (_, loss, _) in &moved {
            energies.losses.numerical += loss.numerical;
            energies.losses.mass_damping += loss.mass_damping;
        }
        let loads = self.loads.iter().zip(&free.factors);
        let works =
            loads.map(|(load, factors)| modal_work(load, factors, &moved, self.scheme.damping));
        energies.applied_work += works.sum::<f64>();
        WindowEnd {
            beside: self.displacements_beside(&end),
            state: end,
            energies,
            far,
        }
    }

    /// Displacements of the rows that are not exchanged (m).
    fn displacements_beside(&self, end: &ReducedState) -> Vec<f64> {
        let mut beside = vec![0.0; self.rows - self.exchanged];
        let columns = (self.beside.as_slice(), beside.len(), 0);
        add_columns(&mut beside, columns, end.force.iter().copied());
        for (load, [factor, _]) in self.loads.iter().zip(&end.loads) {
            add(&mut beside, *factor, &load.residual[self.exchanged..]);
        }
        self.add_modes(&end.modes, self.exchanged, &mut beside);
        beside
    }

    /// Velocities of all rows (m/s).
    pub fn velocities(&self, state: &ReducedState) -> Vec<f64> {
        let mut velocities = vec![0.0; self.rows];
        let columns = (self.shapes.as_slice(), self.rows, 0);
        let rates = state.modes.iter().map(|mode| mode.v);
        add_columns(&mut velocities, columns, rates);
        velocities
    }

    /// Phi^T lambda of each mode.
    fn modal_force(&self, force: &[f64]) -> Vec<f64> {
        let mut modal = vec![0.0; self.omega.len()];
        let rows = (self.amplitudes.as_slice(), modal.len(), 0);
        add_columns(&mut modal, rows, force.iter().copied());
        modal
    }

    /// Adds Phi eta to the displacements of the rows from `first` on.
    fn add_modes(&self, modes: &[ModeState], first: usize, displacement: &mut [f64]) {
        let columns = (self.shapes.as_slice(), self.rows, first);
        add_columns(displacement, columns, modes.iter().map(|mode| mode.u));
    }

    /// Each mode over the window under its constant force and the loads: its end, its losses, and du of each step, or of the window where the loads are
    /// constant.
    fn moved(
        &self,
        window: &ReducedWindow,
        state: &ReducedState,
        modal: &[f64],
        factors: &[Vec<f64>],
    ) -> Vec<(ModeState, ModeLoss, Vec<f64>)> {
        let of_loads = |k: usize, step: usize| -> f64 {
            let loads = self.loads.iter().zip(factors);
            loads
                .map(|(load, factors)| factors[step] * load.modal[k])
                .sum()
        };
        let is_constant = is_constant(factors);
        let of_mode = |(k, start): (usize, ModeState)| {
            if is_constant {
                let map = &window.maps[k];
                let force = modal[k] + of_loads(k, 0);
                let end = map.end(start, force);
                return (end, map.loss(start, force), vec![end.u - start.u]);
            }
            let steps = 0..=window.substeps as usize;
            let forces: Vec<f64> = steps.map(|step| modal[k] + of_loads(k, step)).collect();
            stepped(&self.scheme, self.omega[k], start, &forces)
        };
        let modes = state.modes.iter().copied();
        modes.enumerate().map(of_mode).collect()
    }

    /// Factor of each load at a step, and its work on F_res f (J) at full load.
    fn load_works(&self, force: &[f64], factors: &[Vec<f64>], step: usize) -> Vec<[f64; 2]> {
        let of = |(load, own): (&LoadResponse, &Vec<f64>)| {
            let others = load.works.iter().zip(factors);
            let others: f64 = others.map(|(work, factors)| work * factors[step]).sum();
            [
                own[step],
                dot(&load.residual[..self.exchanged], force) + others,
            ]
        };
        self.loads.iter().zip(factors).map(of).collect()
    }

    /// All energies but for those that the modes lose, and the work of the loads on the modes.
    fn energies(
        &self,
        start: &ReducedState,
        end: &ReducedState,
        factors: &[Vec<f64>],
    ) -> ReducedEnergies {
        let b = self.scheme.damping;
        let change = |new: &[f64], old: &[f64]| -> Vec<f64> {
            new.iter().zip(old).map(|(new, old)| new - old).collect()
        };
        let moved = change(&end.residual, &start.residual);
        let jump = change(&end.force, &start.force);
        let mut energies = ReducedEnergies {
            interface_work: dot(&end.force, &change(&end.displacement, &start.displacement)),
            residual_loss: 0.5 * dot(&jump, &moved),
            lag: dot(&end.force, &change(&end.lag, &start.lag)),
            strain: 0.5 * dot(&end.force, &end.residual),
            ..ReducedEnergies::default()
        };
        for (([last, work], [before, done]), factors) in
            end.loads.iter().zip(&start.loads).zip(factors)
        {
            // A load may begin with a jump: then `before` is 0 and its factor at the start is not.
            let acting = (1.0 - b) * factors[0] + b * last;
            energies.applied_work += acting * (work - done);
            energies.residual_loss += (acting - 0.5 * (before + last)) * (work - done);
            energies.strain += 0.5 * last * work;
        }
        for (state, omega) in end.modes.iter().zip(&self.omega) {
            energies.strain += 0.5 * (omega * state.u).powi(2);
            energies.kinetic += 0.5 * state.v * state.v;
        }
        energies
    }
}

/// True where no load changes.
fn is_constant(factors: &[Vec<f64>]) -> bool {
    factors
        .iter()
        .all(|factors| factors.iter().all(|f| *f == factors[0]))
}

/// Responses to the loads, each a list of components and forces.
fn load_responses(
    body: &mut ReducedBody,
    problem: &StaticProblem,
    rows: &[usize],
    loads: &[&[(usize, f64)]],
) -> Result<Vec<LoadResponse>, KernelError> {
    let responses = loads.iter().map(|load| {
        let mut force = vec![0.0; problem.body.layout.len()];
        load.iter()
            .for_each(|(component, f)| force[*component] += f);
        let none = vec![ModeState::default(); body.modes.omega.len()];
        let [residual, _] = body.recovered(problem, &none, &force)?;
        let (modes, factor) = (&body.modes, factor(&mut body.factor, problem)?);
        let products = load
            .iter()
            .map(|(c, f)| modes.amplitudes(factor, *c).map(move |a| a * f));
        let mut modal = vec![0.0; body.modes.omega.len()];
        products.for_each(|products| {
            let sums = modal.iter_mut().zip(products);
            sums.for_each(|(sum, product)| *sum += product);
        });
        let work = |other: &&[(usize, f64)]| other.iter().map(|(c, f)| f * residual[*c]).sum();
        Ok(LoadResponse {
            modal,
            works: loads.iter().map(work).collect(),
            residual: rows.iter().map(|c| residual[*c]).collect(),
        })
    });
    responses.collect()
}

/// [(1-b) f + b f'] du of a load on the modes (J), step by step or over the window.
fn modal_work(
    load: &LoadResponse,
    factors: &[f64],
    moved: &[(ModeState, ModeLoss, Vec<f64>)],
    b: f64,
) -> f64 {
    let weight = |step: usize| (1.0 - b) * factors[step] + b * factors[step + 1];
    let of_mode = |((.., increments), g): (&(ModeState, ModeLoss, Vec<f64>), &f64)| {
        let steps = increments.iter().enumerate();
        g * steps.map(|(step, du)| weight(step) * du).sum::<f64>()
    };
    moved.iter().zip(&load.modal).map(of_mode).sum()
}
