//! The reports of the grains: signals and energies of a window, results of the run.

use std::collections::BTreeMap;

use protocol::{BoundaryInertia, Role, Term};

use super::dem::Dem;
use crate::bond;
use crate::prescribed_opening;
use crate::report::{self, BONDS};
use crate::step::StepSummary;

impl Dem {
    pub(super) fn report(&self, summary: &StepSummary) -> Vec<f64> {
        let now = self.progress.state.energies(&self.bodies);
        let since = [0, 1, 2, 3].map(|k| now[k] - self.initial_energy[k]);
        let signals = report::signals(&self.bodies, &self.progress.state, summary);
        let mut report = signals.map(|(_, value)| value).to_vec();
        if self.bodies.law.cohesion.is_some() {
            report.push(bond::count(&self.progress.state.bonds) as f64);
        }
        report.extend(
            self.opening
                .iter()
                .flat_map(|opening| opening.signals(&self.progress.state)),
        );
        report.extend(self.ledger(since).map(|(_, _, value)| value));
        report
    }

    /// The energy balance: names, roles and values of its terms, with the energies stored since the start (J).
    fn ledger(&self, stored: [f64; 4]) -> impl Iterator<Item = (&'static str, Role, f64)> {
        let accounts = &self.progress.state.accounts;
        let walls = (self.bodies.wall_speed() > 0.0).then(|| accounts.of_walls());
        accounts.terms(stored).into_iter().chain(walls)
    }

    pub(super) fn ledger_terms(&self) -> Vec<Term> {
        let terms = self.ledger([0.0; 4]).map(|(name, role, _)| Term {
            name: name.into(),
            role,
        });
        terms.collect()
    }

    pub(super) fn signal_names(&self) -> Vec<String> {
        let bonds = self.bodies.law.cohesion.map(|_| BONDS);
        let prescribed_velocity = self
            .opening
            .map(|_| prescribed_opening::SIGNALS)
            .into_iter()
            .flatten();
        let signals = report::signals(&self.bodies, &self.progress.state, &StepSummary::default());
        let names = signals
            .into_iter()
            .map(|(name, _)| name)
            .chain(bonds)
            .chain(prescribed_velocity);
        names.map(String::from).collect()
    }

    /// A glued disk's share of all that can move, behind the two grains that it carries on average.
    pub(super) fn boundary_inertia(&self) -> BoundaryInertia {
        let grains: f64 = self.bodies.masses.iter().sum();
        let movable = grains + self.bodies.wheel_mass.unwrap_or(0.0);
        BoundaryInertia {
            glued_mass_kg: 0.0,
            mass_kg: movable / self.bodies.glued() as f64,
            stiffness_n_per_m: self.bodies.law.springs.map(|springs| 2.0 * springs.normal),
            theta: self.theta,
            may_part: true,
        }
    }

    pub(super) fn results(&self) -> BTreeMap<String, f64> {
        let mut results = self.progress.statistics.results(
            self.program.as_ref(),
            &self.bodies,
            &self.progress.state,
        );
        if self.solid_fraction > 0.0 {
            results.insert("solid_fraction".into(), self.solid_fraction);
        }
        if self.bodies.law.cohesion.is_some() {
            let bonds = bond::count(&self.progress.state.bonds);
            results.insert("bonds".into(), bonds as f64);
            results.insert(
                "bonds_broken".into(),
                (self.initial_bond_count - bonds) as f64,
            );
        }
        if let Some(limit) = self.bond_step_limit {
            results.insert("bond_step_limit_s".into(), limit);
        }
        if let Some(scaling) = self.scaling {
            results.insert("inertial_number".into(), scaling.inertial_number);
            results.insert("inertia_pressure_pa".into(), scaling.pressure);
        }
        if let Some(step) = self.window.or(self.own_step) {
            results.insert(
                "step_over_inertial_time".into(),
                step / self.bounds.inertial_time,
            );
        }
        results
    }
}
