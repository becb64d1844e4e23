//! Reports of the body: signals and energies of a window, fields, results and the hash of its state.

use std::collections::BTreeMap;

use fem_kernel::integrate::tally::kinetic_energy;
use kit::cycle_drift::CYCLE_DRIFT;
use kit::table::last_change;
use kit::wheel::{HOLD, phases};
use protocol::{Description, Finding, Phase, Term};

use super::fem_node::FemNode;
use crate::error::FemError;
use crate::interface::window::extent::WindowInput;
use crate::interface::{coupling_sets, outward_normals, periods};
use crate::model::rolling::Roll;
use crate::model::{Model, limit_name};
use crate::output::ledger::NamedTerm;
use crate::output::plausible;
use crate::output::probe;
use crate::output::profile::ContactProfile;

kit::results! {
    /// # Load and approach
    /// - `p0_pa`: Largest contact pressure at the end of the hold, over the nodes.
    /// - `contact_half_width_m`: Half width of the contact at the end of the hold, where a straight
    ///   line through p² over x² is zero.
    /// # Forces and places of sets
    /// - `<set>_reaction_x_n`: Force along x that the moved set exerts on the rest of its body, at the end.
    /// - `<set>_reaction_y_n`: Force along y that the moved set exerts on the rest of its body, at the end.
    /// # Signals
    /// - `interface_force_x_n`: Force along x on the coupled surfaces of a participant.
    /// - `interface_force_y_n`: Force along y on the coupled surfaces of a participant.
}

/// Share of the work of the wheel's load over its approach below which energies are noise, as for grains.
const NOISE: f64 = 1e-6;

impl FemNode {
    /// Signals by name, in the order of a report.
    pub(super) fn signals(&self, input: &WindowInput) -> Vec<(String, f64)> {
        let (model, committed) = (&self.model, &self.committed);
        let (layout, state) = (model.body.layout, &committed.state);
        let mut signals = probe::surface_signals(model, state);
        let force = input.interface.iter().map(|(_, force)| *force);
        signals.extend(probe::interface_force(force));
        if let Some((wheel, state)) = model.wheel.as_ref().zip(committed.wheel.as_ref()) {
            signals.extend(state.signals(wheel));
        }
        let probes = model.probes.iter();
        signals.extend(probes.flat_map(|probe| probe.signals(layout, state, true)));
        signals.extend(self.reactions());
        let t = committed.steps as f64 * model.scheme.step;
        let motions = model.motions.iter();
        signals.extend(motions.flat_map(|motion| motion.displacements(layout, t)));
        signals.extend(probe::momentum(model, state));
        let heat = model.heat.iter();
        signals.extend(heat.flat_map(|heat| heat.signals(&committed.heat)));
        signals
    }

    /// Forces that prescribed motions exert on the body (N), by the names of their signals.
    fn reactions(&self) -> impl Iterator<Item = (String, f64)> {
        let motions = self.model.motions.iter().zip(&self.committed.reactions);
        motions.flat_map(|(motion, force)| motion.reactions(*force))
    }

    /// Energies that the keys of this body require. They are 0 where all are noise compared with the work of a wheel at rest: a body that starts in
    /// equilibrium moves only when its wheel does.
    pub(super) fn terms(&self) -> impl Iterator<Item = NamedTerm> {
        let model = &self.model;
        let present = |(_, name, _): &NamedTerm| match *name {
            "applied_work" => !model.tractions.is_empty() || model.expands(),
            "drive_work" => !model.motions.is_empty(),
            "mass_damping" => model.damping_at(0) > 0.0,
            "stiffness_damping" => model.scheme.stiffness_damping > 0.0,
            "plastic" => model.plastic().is_some(),
            "wheel_load" | "wheel_drive" | "wheel_kinetic" | "friction" | "impact" => {
                model.wheel.is_some()
            }
            _ => true,
        };
        let terms = self.committed.ledger.terms();
        let wheel = self.model.wheel.as_ref().zip(self.committed.wheel.as_ref());
        let done = wheel.map_or(0.0, |(wheel, state)| {
            wheel.program.load_n * state.approach(wheel).abs()
        });
        let rests = terms.iter().all(|term| term.2.abs() < NOISE * done);
        let shown = f64::from(u8::from(!rests));
        let terms = terms.into_iter().filter(present);
        terms.map(move |(role, name, value)| (role, name, shown * value))
    }

    /// Results of the hold, or of the last state without a hold.
    pub(super) fn results(&self) -> BTreeMap<String, f64> {
        let mut results = BTreeMap::new();
        let mut maxima = self.committed.hold_maxima;
        if let Some((wheel, state)) = self.model.wheel.as_ref().zip(self.committed.wheel.as_ref()) {
            let last = || probe::hold_record(&self.model, &self.committed.state, wheel, state);
            let record = self.committed.hold_record.clone().unwrap_or_else(last);
            maxima = Some(record.maxima);
            results = state.statistics.results(wheel, self.committed.steps);
            results.insert("p0_pa".into(), record.profile.peak());
            let width = record
                .profile
                .half_width(wheel.start(), self.model.mesh.period());
            results.extend(width.map(|a| ("contact_half_width_m".into(), a)));
            results.insert("approach_m".into(), record.approach);
            results.extend(state.rolling_results(wheel));
            let shift = self.model.roll.as_ref().map(Roll::box_shift);
            results.extend(shift.map(|shift| ("creepage_box_shift".into(), shift)));
        }
        let last = || probe::pressure_maxima(&self.model, &self.committed.state);
        let maxima = maxima.unwrap_or_else(last);
        results.extend(maxima.results());
        let state = &self.committed.state;
        results.extend(probe::outward_displacements(&self.model, state));
        results.extend(self.reactions());
        let heat = self.model.heat.iter();
        results.extend(heat.flat_map(|heat| heat.results(&self.committed.heat, self.heating())));
        results
    }

    /// Lets the heat of the last steps pass: the slip and the time since the last step of heat.
    pub(super) fn end_heat(&mut self) {
        let (model, committed) = (&self.model, &mut self.committed);
        if let Some(heat) = &model.heat {
            if let Some(wheel) = &committed.wheel {
                committed.heat.rub(heat, wheel.rubbed());
            }
            let time = (committed.steps, model.scheme.step);
            heat.end(&mut committed.heat, time);
        }
    }

    /// Losses in the ledger that may become heat: by friction and by plastic flow (J).
    fn heating(&self) -> [f64; 2] {
        let ledger = &self.committed.ledger;
        [ledger.wheel.friction, ledger.plastic]
    }

    /// Values beyond their bounds.
    pub(super) fn findings(&self) -> Vec<Finding> {
        let (model, committed) = (&self.model, &self.committed);
        let strain = plausible::strain_so_far(committed.strain_max, model, &committed.state);
        let terms = self.terms().map(|(.., value)| value.abs());
        let moved = kinetic_energy(&model.body, &committed.state.v) + terms.sum::<f64>();
        let mut findings = vec![
            plausible::strain(model, strain),
            plausible::plastic_element(model, &committed.state),
            plausible::locking(model, &committed.state, moved),
        ];
        if let Some((wheel, state)) = model.wheel.as_ref().zip(committed.wheel.as_ref()) {
            let load = wheel.program.load_n;
            let range = state.statistics.held_range();
            findings.push(range.and_then(|range| plausible::wheel_at_rest(model, load, range)));
            let bounds = model.plausible.of(&CYCLE_DRIFT);
            findings.push(state.statistics.drift.judge(&wheel.program, bounds));
            let last = ContactProfile::in_motion(model, &state.contacts);
            let held = committed.hold_record.as_ref().map(|record| &record.profile);
            let sampled = held.unwrap_or(&last);
            findings.push(plausible::contact_resolution(model, sampled));
            let both = [sampled, &last].into_iter();
            findings.push(plausible::contact_reach(model, both));
            let rolling = wheel.program.rolling.as_ref();
            let creepage = rolling.map(|_| state.rolled.creepage());
            let sliding = (creepage, wheel.program.amplitude_m);
            findings.push(plausible::wheel_points(model, &last, sliding));
        }
        let heat = plausible::heat(model, &committed.heat, self.heating());
        findings.into_iter().flatten().chain(heat).collect()
    }

    /// blake3 of every number that can change a later bit: displacements, velocities, histories, energies, time.
    pub(crate) fn state_hash(&self) -> String {
        // All terms except stiffness damping that the body does not have.
        let damped = self.model.scheme.stiffness_damping > 0.0;
        let terms = self.committed.ledger.terms().into_iter();
        let terms = terms.filter(|(_, name, _)| damped || *name != "stiffness_damping");
        let ledger: Vec<f64> = terms.map(|(_, _, value)| value).collect();
        let state = self.state();
        let mut fields = vec![&state.u[..], &state.v, &state.history];
        fields.extend([&state.damping_force[..], &ledger]);
        let wheel = self.committed.wheel.as_ref().map(|wheel| wheel.numbers());
        if let Some(wheel) = &wheel {
            fields.extend([&wheel[..], &state.a]);
        }
        fields.extend(state.thermal.iter().map(|thermal| &thermal[..]));
        let heat = self.model.heat.iter();
        let heat = heat.flat_map(|_| self.committed.heat.numbers());
        let numbers = fields.into_iter().flatten().chain(heat).copied();
        hash_of(&self.committed.steps.to_le_bytes(), numbers)
    }

    /// Writes the fields and the contact profile of the committed state; a snapshot of the hold also records its pressures.
    pub(super) fn try_snapshot(&mut self, name: &str) -> Result<(), FemError> {
        refuse_name(name)?;
        let committed = &mut self.committed;
        committed.strain_max =
            plausible::strain_so_far(committed.strain_max, &self.model, &committed.state);
        if name == HOLD {
            let maxima = probe::pressure_maxima(&self.model, &committed.state);
            committed.hold_maxima = Some(maxima);
        }
        let (mut contacts, mut profile) = (&[][..], None);
        if let Some(wheel) = &committed.wheel {
            contacts = &wheel.contacts;
            profile = Some(match &committed.hold_record {
                Some(record) if name == HOLD => record.profile.clone(),
                _ => ContactProfile::in_motion(&self.model, contacts),
            });
        }
        let surface = (contacts, profile.as_ref(), &committed.heat);
        self.snapshots
            .write(name, &self.model, &committed.state, surface)
    }
}

/// Values of the signals, then the energies.
pub(super) fn reported(
    signals: Vec<(String, f64)>,
    terms: impl Iterator<Item = NamedTerm>,
) -> Vec<f64> {
    let signals = signals.into_iter().map(|(_, value)| value);
    signals.chain(terms.map(|(.., value)| value)).collect()
}

/// blake3 of some bytes and numbers, in hexadecimal.
pub(super) fn hash_of(first: &[u8], numbers: impl Iterator<Item = f64>) -> String {
    let mut hasher = blake3::Hasher::new();
    hasher.update(first);
    for number in numbers {
        hasher.update(&number.to_le_bytes());
    }
    hasher.finalize().to_hex().to_string()
}

/// A body in motion with these signals and energies, without its capabilities.
pub(super) fn described(
    model: &Model,
    signals: Vec<(String, f64)>,
    terms: impl Iterator<Item = NamedTerm>,
) -> Description {
    let term = |(role, name, _): NamedTerm| Term {
        name: name.into(),
        role,
    };
    Description {
        kind: "fem".into(),
        software: format!("fem-node {}", env!("CARGO_PKG_VERSION")),
        step_s: Some(model.scheme.step),
        step_limit_s: Some(model.step_limit),
        step_limit_name: limit_name(model.scheme.stiffness_damping).into(),
        end_s: model.end,
        phases: phases_of(model),
        moments: model.moments.clone(),
        sets: coupling_sets(model),
        signals: signals.into_iter().map(|(name, _)| name).collect(),
        ledger: terms.map(term).collect(),
        warnings: model.warnings.clone(),
        first_period_s: Some(model.first_period()),
        outward: outward_normals(model),
        period_m: periods(model),
        ..Description::default()
    }
}

/// Parts of the body's own load history, where it has one and the run has an end.
fn phases_of(model: &Model) -> Vec<Phase> {
    if let Some(wheel) = &model.wheel {
        return wheel.program.phases();
    }
    let (loads, motions) = (model.tractions.iter(), model.motions.iter());
    let loads = loads.map(|traction| last_change(Some(&traction.factors)).unwrap_or(0.0));
    let ramps = loads.chain(motions.clone().map(|motion| motion.history.settled_at()));
    let Some((ramp, end)) = ramps.reduce(f64::max).zip(model.end) else {
        return Vec::new();
    };
    let ramp = ramp.max(0.0).min(end);
    let cycles = motions.filter_map(|motion| motion.history.cycles_from());
    let cycles = cycles.fold(end, f64::min).max(ramp);
    phases([
        ("ramp", 0.0, ramp),
        (HOLD, ramp, cycles),
        ("cycling", cycles, end),
    ])
}

/// Refuses the name of a snapshot that is no part of a plain file name.
pub(super) fn refuse_name(name: &str) -> Result<(), FemError> {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_.".contains(c);
    if name.is_empty() || !name.chars().all(plain) {
        return Err(FemError::SnapshotName { name: name.into() });
    }
    Ok(())
}
