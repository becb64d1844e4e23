//! Reports of a reduced body: signals, energies, results, findings and snapshots.

use std::collections::BTreeMap;

use fem_kernel::integrate::state::NodalState;
use kit::judge;
use kit::wheel::HOLD;
use protocol::Finding;

use super::reduced_node::ReducedNode;
use super::report::{hash_of, refuse_name};
use crate::error::FemError;
use crate::output::ledger::NamedTerm;
use crate::output::plausible;
use crate::output::probe;

kit::results! {
    /// # Quality of the solution
    /// - `reduced_modes`: Number of modes of a reduced body.
    /// - `reduced_omega_max_per_s`: Largest natural frequency of these modes.
    /// - `reduced_window_turns`: Periods of the lowest mode that is left out in one window; absent where
    ///   all modes are kept. Modes left out follow the load as in equilibrium.
    /// - `reduced_static_share`: Share of the static flexibility of the coupled points that moves without mass.
    /// - `reduced_near_m`: Distance within which a force moves points in the same window.
    /// - `reduced_near_radius`: Spectral radius of far over near compliance: how much of a change of force returns one window later.
}

kit::findings! {
    /// The far field of a reduced body gives energy.
    ///
    /// - Why: forces change much from window to window, and points beyond `reduced.near_m` follow them one window late.
    /// - Do: make `reduced.near_m` larger, or the window shorter.
    /// - Judged: Energy that the far field gave, summed over the windows in which it gave some, over the largest work of all forces.
    /// - Valid: 0.001 (`quick-bonded` with 50 modes).
    /// - Wrong: 0.076 (a force that is drawn anew in each window).
    FAR_FIELD = "far_field": far_field_rel in fem = [0.02, 1e300];
}

impl ReducedNode {
    /// Signals by name, in the order of a report.
    pub(super) fn signals(&self) -> Vec<(String, f64)> {
        let (model, seen) = (&self.model, &self.seen);
        let mut signals = probe::surface_signals(model, seen);
        let force = self.committed.state.force.iter().copied();
        signals.extend(probe::interface_force(force));
        let heat = model.heat.iter();
        signals.extend(heat.flat_map(|heat| heat.signals(&self.committed.heat)));
        let layout = model.body.layout;
        let probes = model.probes.iter();
        signals.extend(probes.flat_map(|probe| probe.signals(layout, seen, true)));
        signals
    }

    /// Energies that the keys of this body require.
    pub(super) fn terms(&self) -> impl Iterator<Item = NamedTerm> {
        let model = &self.model;
        let present = |(_, name, _): &NamedTerm| match *name {
            "applied_work" => !model.tractions.is_empty(),
            "mass_damping" => model.scheme.mass_damping > 0.0,
            _ => true,
        };
        self.committed.ledger.terms().into_iter().filter(present)
    }

    /// Results of the hold, or of the last state without a hold.
    pub(super) fn results(&self, last: &NodalState) -> BTreeMap<String, f64> {
        let held = self.committed.hold_maxima;
        let maxima = held.unwrap_or_else(|| probe::pressure_maxima(&self.model, last));
        let mut results = BTreeMap::from(maxima.results());
        results.extend(probe::outward_displacements(&self.model, last));
        let modes = &self.body.modes;
        let mut add = |name: &str, value: f64| results.insert(format!("reduced_{name}"), value);
        add("modes", modes.omega.len() as f64);
        add(
            "omega_max_per_s",
            modes.omega.last().copied().unwrap_or(0.0),
        );
        add("static_share", self.residual_share());
        if let Some((substeps, window)) = self.windows.last_key_value() {
            let window_s = self.model.scheme.step * f64::from(*substeps);
            let turns = |omega: f64| omega * window_s / std::f64::consts::TAU;
            modes
                .neglected
                .map(|omega| add("window_turns", turns(omega)));
            add("near_m", window.field.reach);
            add("near_radius", window.field.radius);
        }
        let heat = self.model.heat.iter();
        results.extend(heat.flat_map(|heat| heat.results(&self.committed.heat, [0.0; 2])));
        results
    }

    /// Values beyond their bounds.
    pub(super) fn findings(&self, last: &NodalState) -> Vec<Finding> {
        let (model, committed) = (&self.model, &self.committed);
        let strain = plausible::strain_so_far(committed.strain_max, model, last);
        let moved: f64 = self.terms().map(|(.., value)| value.abs()).sum();
        let ledger = &committed.ledger;
        let given = ledger.far_given / ledger.supplied.max(f64::MIN_POSITIVE);
        let far = judge!(model.plausible => FAR_FIELD, given;
            "points beyond reduced.near_m follow the force one window late, and gave {given:.3} of the work: make reduced.near_m larger, or the window shorter");
        let found = [
            plausible::strain(model, strain),
            plausible::locking(model, last, moved),
            far,
        ];
        let heat = plausible::heat(model, &committed.heat, [0.0; 2]);
        found.into_iter().flatten().chain(heat).collect()
    }

    /// blake3 of every number that can change a later bit.
    pub(super) fn state_hash(&self) -> String {
        let (state, ledger) = (&self.committed.state, &self.committed.ledger);
        let energies = ledger.terms().map(|(.., value)| value);
        let heat = self.model.heat.iter();
        let heat = heat.flat_map(|_| self.committed.heat.numbers());
        let numbers = state.numbers().chain(energies).chain(heat.copied());
        hash_of(&self.committed.steps.to_le_bytes(), numbers)
    }

    /// Writes the fields of the committed state; a snapshot of the hold also records its pressures.
    pub(super) fn try_snapshot(&mut self, name: &str) -> Result<(), FemError> {
        refuse_name(name)?;
        let state = self.recovered()?;
        let (model, committed) = (&self.model, &mut self.committed);
        committed.strain_max = plausible::strain_so_far(committed.strain_max, model, &state);
        if name == HOLD {
            committed.hold_maxima = Some(probe::pressure_maxima(model, &state));
        }
        let surface = (&[][..], None, &committed.heat);
        self.snapshots.write(name, model, &state, surface)
    }
}
