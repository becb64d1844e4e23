//! The reports of the grains: signals and energies of a window, results of the run.

use std::collections::BTreeMap;

use dem_kernel::contact::bond;
use dem_kernel::law::Law;
use dem_kernel::step::StepSummary;
use protocol::{BoundaryInertia, Role, Term};

use super::dem::Dem;
use crate::measure::flow::Flow;
use crate::measure::plausible::FinishedRun;
use crate::measure::report;
use crate::measure::rolled_layer;

kit::results! {
    /// # Grains
    /// - `solid_fraction`: Share of the layer's area that disks cover at the start.
    /// - `spring_restitution`: Least part of its speed that an elastic rebound of the two lightest grains keeps at this time step.
    /// - `numerical_share`: Part of all dissipated energy that the time integration dissipates, not friction, impacts, dampers or bonds.
    /// - `radii_shrunk_rel`: Part by which radii were reduced for a start without overlaps.
    /// - `inertial_number`: Shear rate times sqrt(m/P): small where a layer shears slowly enough to
    ///   be in equilibrium.
    /// - `inertia_pressure_pa`: Shear stress rho H (2 pi f)^2 A that accelerates a layer of height H with a wheel that moves
    ///   sideways.
    /// - `step_over_inertial_time`: Largest step of the grains over their inertial time d sqrt(ρ/P); small
    ///   steps resolve rearrangements.
    /// # Bonds
    /// - `bonds`: Bonds that are left at the end.
    /// - `bonds_broken`: Bonds that broke.
    /// - `bonds_broken_share`: Bonds that broke over those at the start.
    /// - `layer_tension_pa`: Tensile strength of the bonded layer as a material, phi Z F/(pi d t):
    ///   Rumpf's, in the plane, from the bonds at the start.
    /// - `layer_shear_pa`: Shear strength of the bonded layer as a material: `layer_tension_pa` with the
    ///   force F that breaks a bond in shear.
    /// - `bonds_made`: Bonds that healing made between pairs without one.
    /// - `healing_j`: Surface energy that healing bonds gained, without any work.
    /// - `adhesion_mean`: Mean intensity of adhesion over the bonds of the start: 1 is whole, 0 is
    ///   broken.
    /// - `bond_step_limit_s`: Step above which a bond may withstand more than its fracture energy.
    /// - `bond_load_max`: Largest force of a bond over its strength; at 1, the most, its adhesion begins to fall.
    /// - `bond_energy_rel`: Energy that breaking bonds dissipated over the surface energy that they lost; 1 in steps short enough for the speed at
    ///   which they opened.
}

impl Dem {
    pub(super) fn report(&self, summary: &StepSummary) -> Vec<f64> {
        let since = self.stored();
        let signals = self.signals(summary).into_iter().map(|(_, value)| value);
        let signals = signals.chain(self.force_signals().map(|(_, value)| value));
        let ledger = self.ledger(since).map(|(_, _, value)| value);
        signals.chain(ledger).collect()
    }

    /// Energies stored since the start (J).
    fn stored(&self) -> [f64; 5] {
        let now = self.progress.state.energies(&self.bodies);
        std::array::from_fn(|k| now[k] - self.initial_energy[k])
    }

    /// The signals of a step; cohesive laws add `bonds`, the count of bonds with more than 0.01 of adhesion.
    fn signals(&self, summary: &StepSummary) -> Vec<(&'static str, f64)> {
        let state = &self.progress.state;
        let mut signals = report::signals(&self.bodies, state, summary).to_vec();
        if self.bodies.law.cohesion.is_some() {
            signals.push(("bonds", bond::count(&state.bonds) as f64));
        }
        if self.bodies.rolls {
            let [creepage, force] = self.progress.rolled.record.signals();
            signals.extend([creepage, force]);
        }
        if let Some(law) = &self.bodies.heat {
            let [mean, highest] = state.heat.mean_and_highest(&self.bodies, law);
            signals.extend([("temperature_mean_k", mean), ("temperature_max_k", highest)]);
        }
        signals.extend(self.progress.flow.iter().flat_map(Flow::signals));
        if let Some(opening) = &self.opening {
            signals.extend(opening.signals(state));
        }
        signals
    }

    /// The energy balance: names, roles and values of its terms, with the energies stored since the start (J). Grains alone may be at rest, with
    /// terms that are noise: then they are 0 where the grains have a boundary, and elsewhere the bound stands beside them. With a boundary the names
    /// must not depend on whether an interface joins it.
    fn ledger(&self, stored: [f64; 5]) -> impl Iterator<Item = (&'static str, Role, f64)> {
        let (ledger, bodies) = (&self.progress.state.ledger, &self.bodies);
        let clusters = &bodies.clusters;
        let moved = bodies.wall_speed() > 0.0 || clusters.driven().next().is_some();
        let (fed, repairs) = (bodies.injection.is_some(), bodies.law.penetration.repairs());
        let damped = clusters.driven().any(|(_, _, drive)| drive.damping > 0.0)
            || bodies.any_law(Law::is_damped);
        let flow = self.measures.flow.as_ref();
        let lateral = flow.is_some_and(|flow| flow.config.lateral.is_some());
        let [kinetic, normal, tangential, bonds, adhesion] = stored;
        let some = [
            (
                bodies.heals(),
                ("relaxation", Role::Dissipated, ledger.relaxation),
            ),
            (bodies.attracts(), ("adhesion", Role::Stored, adhesion)),
            (moved, ("walls", Role::Work, ledger.walls)),
            (fed, ("injection", Role::Work, ledger.injection)),
            (repairs, ("repair", Role::Dissipated, ledger.repair)),
            (lateral, ("lateral", Role::Dissipated, ledger.lateral)),
            (damped, ("damping", Role::Dissipated, ledger.damping)),
        ];
        let some = some.into_iter().filter(|(there, _)| *there);
        let mut terms = ledger.terms([kinetic, normal, tangential, bonds]).to_vec();
        terms.extend(some.map(|(_, term)| term));
        let start = self.initial_energy[0];
        if self.interface.disks.is_empty() {
            let rounding = self.progress.steps as f64 * self.progress.state.rounding(bodies);
            let noise = bodies.noise(0.0, start) + rounding;
            let is_noise = |(.., value): &(_, _, f64)| value.abs() < noise;
            if bodies.boundary_points() == 0 {
                terms.push(("rounding", Role::Rounding, noise));
            } else if terms.iter().all(is_noise) {
                terms.iter_mut().for_each(|(.., value)| *value = 0.0);
            }
        }
        terms.into_iter()
    }

    pub(super) fn ledger_terms(&self) -> Vec<Term> {
        let terms = self.ledger([0.0; 5]).map(|(name, role, _)| Term {
            name: name.into(),
            role,
        });
        terms.collect()
    }

    pub(super) fn signal_names(&self) -> Vec<String> {
        let signals = self.signals(&StepSummary::default()).into_iter();
        let names = signals.map(|(name, _)| name.to_string());
        names
            .chain(self.force_signals().map(|(name, _)| name))
            .collect()
    }

    /// A glued disk's share of the mass that can move, and the stiffness of the two grains that it carries on average.
    pub(super) fn boundary_inertia(&self) -> BoundaryInertia {
        let present = self.progress.state.present(&self.bodies);
        let grains: f64 = self.bodies.masses[..present].iter().sum();
        let movable = grains + self.bodies.wheel_mass.unwrap_or(0.0);
        let carriers = match self.bodies.glued() {
            0 => self.bodies.boundary_points(),
            glued => glued,
        };
        BoundaryInertia {
            glued_mass_kg: 0.0,
            mass_kg: movable / carriers as f64,
            stiffness_n_per_m: self.bodies.law.springs.map(|springs| 2.0 * springs.normal),
            theta: self.time.theta,
            may_part: true,
        }
    }

    pub(super) fn results(&self) -> BTreeMap<String, f64> {
        let state = &self.progress.state;
        let statistics = &self.progress.statistics;
        let mut results = statistics.results(self.program.as_ref(), &self.bodies, state);
        let count = bond::count(&state.bonds);
        let bonds = self.bodies.law.cohesion.map(|_| count as f64);
        let made = state.ledger.bonds_made as usize;
        let broken =
            bonds.map(|_| (self.sample.initial_bond_count + made).saturating_sub(count) as f64);
        let heals = self.bodies.heals();
        let per_bond = |sum: f64| {
            let start = self.sample.initial_bond_count;
            bonds.filter(|_| start > 0).map(|_| sum / start as f64)
        };
        let adhesions = state.bonds.iter().map(|bond| bond.adhesion);
        let adhesion = per_bond(adhesions.fold(0.0, |sum, adhesion| sum + adhesion));
        // The last window is cut at the end of the run.
        let step = Some(statistics.largest.step).filter(|step| *step > 0.0);
        let step = step.map(|step| step / self.time.bounds.inertial_time);
        let restitution = self.time.stiffness.restitution(statistics.largest.step);
        let solid_fraction = Some(self.sample.solid_fraction).filter(|x| *x > 0.0);
        results.extend(report::given([
            ("solid_fraction", solid_fraction),
            (
                "layer_tension_pa",
                self.sample.strength.map(|[tension, _]| tension),
            ),
            (
                "layer_shear_pa",
                self.sample.strength.map(|[_, shear]| shear),
            ),
            ("radii_shrunk_rel", self.sample.radii_shrunk),
            ("bonds", bonds),
            ("bonds_broken", broken),
            ("bonds_broken_share", broken.and_then(per_bond)),
            ("bonds_made", heals.then_some(made as f64)),
            ("healing_j", heals.then_some(state.ledger.healing)),
            ("adhesion_mean", adhesion),
            ("bond_step_limit_s", self.time.stiffness.bonds_s),
            ("bond_load_max", bonds.map(|_| statistics.largest.bond_load)),
            ("bond_energy_rel", state.ledger.decohesion_share()),
            ("numerical_share", state.ledger.numerical_share()),
            ("spring_restitution", restitution.map(|[low, _]| low)),
            (
                "inertial_number",
                self.time.scaling.map(|s| s.inertial_number),
            ),
            ("inertia_pressure_pa", self.time.scaling.map(|s| s.pressure)),
            ("step_over_inertial_time", step),
        ]));
        if state.worn.detaches() {
            let real = 1.0 - self.bodies.added_mass_rel;
            results.extend(state.worn.results(state.feed.delivered, real));
        }
        results.extend(self.progress.flow.iter().flat_map(Flow::results));
        if let Some(config) = &self.measures.profile {
            let grains = (&self.bodies, state, self.setting.thickness_m);
            results.extend(self.progress.profile.results(config, grains));
        }
        results.extend(self.stress_results());
        let programs = self.program.iter();
        let record = &self.progress.rolled.record;
        for rolling in programs.filter_map(|program| program.rolling.as_ref()) {
            let waves = rolled_layer::wave_speed(&self.bodies, state);
            let speed = waves.map(|waves| ("rolling_speed_rel", rolling.speed.abs() / waves));
            results.extend(record.results(rolling, self.bodies.wheel_radius));
            results.extend(speed);
        }
        let results = results.into_iter().map(|(name, x)| (name.to_string(), x));
        let cycles = self.progress.cycles.results(self.measures.flow.is_some());
        let heat = state.heat.results(&self.bodies, &state.ledger);
        let results = results.chain(heat).chain(cycles);
        results.chain(self.force_results()).collect()
    }

    /// The run at its end, for the checks of plausibility.
    pub(super) fn finished_run(&self) -> FinishedRun<'_> {
        FinishedRun {
            bounds: &self.measures.plausible,
            bodies: &self.bodies,
            state: &self.progress.state,
            stored: self.stored(),
            stiffness: self.time.stiffness,
            flow: self.progress.flow.as_ref(),
            statistics: &self.progress.statistics,
            cycles: &self.progress.cycles,
            program: self.program.as_ref(),
            alone: self.interface.disks.is_empty(),
            ends: self.sample.ends,
        }
    }
}
