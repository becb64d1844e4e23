//! What the body says of itself: signals and energies of a window, fields, results and the hash of its state.

use std::collections::BTreeMap;

use protocol::Phase;

use super::FemNode;
use crate::error::FemError;
use crate::integrate::State;
use crate::ledger::Terms;
use crate::probe;
use crate::profile::Profile;
use crate::vtu;
use crate::window::Request;

/// The snapshot of this name fixes the state whose pressures are reported.
pub(crate) const HOLD: &str = "hold";

impl FemNode {
    pub(super) fn report(&self, request: &Request) -> Vec<f64> {
        let mut report = probe::surface_signals(&self.model, &self.committed);
        let force = request.interface.chunks_exact(2);
        let total = force.fold([0.0, 0.0], |sum, point| {
            [sum[0] + point[0].1, sum[1] + point[1].1]
        });
        report.extend(total);
        if let Some((wheel, state)) = self.model.wheel.as_ref().zip(self.wheel.as_ref()) {
            report.extend(state.signals(wheel));
        }
        report.extend(self.terms().values(&self.ledger));
        report
    }

    pub(super) fn terms(&self) -> Terms {
        Terms {
            applied: !self.model.tractions.is_empty(),
            mass_damping: self.model.damping_at(0) > 0.0,
            stiffness_damping: self.model.scheme.stiffness_damping > 0.0,
            wheel: self.model.wheel.is_some(),
            driven: !self.model.drives.is_empty(),
            plastic: self.model.plastic().is_some(),
        }
    }

    /// Results of the hold, or of the last state where there was none.
    pub(super) fn results(&self) -> BTreeMap<String, f64> {
        let mut results = BTreeMap::new();
        let mut maxima = self.hold;
        if let Some((wheel, state)) = self.model.wheel.as_ref().zip(self.wheel.as_ref()) {
            let last = || probe::held(&self.model, &self.committed, (wheel, state));
            let held = self.held.clone().unwrap_or_else(last);
            maxima = Some(held.maxima);
            results = state.journal.results(wheel);
            results.insert("p0_pa".into(), held.profile.peak());
            let width = held.profile.half_width();
            results.extend(width.map(|a| ("contact_half_width_m".into(), a)));
            results.insert("approach_m".into(), held.approach);
        }
        let last = || probe::pressure_maxima(&self.model, &self.committed);
        let maxima = maxima.unwrap_or_else(last);
        results.insert("p_max_centroid_pa".into(), maxima.centroid);
        results.insert("p_max_gauss_pa".into(), maxima.gauss);
        results.insert("p_max_nodal_pa".into(), maxima.nodal);
        results.extend(probe::outward_displacements(&self.model, &self.committed));
        results
    }

    /// blake3 of every number that can change a later bit: displacements, velocities, histories, energies, time.
    pub(super) fn state_hash(&self) -> String {
        let mut hasher = blake3::Hasher::new();
        hasher.update(&self.steps.to_le_bytes());
        let ledger = Terms {
            applied: true,
            mass_damping: true,
            stiffness_damping: self.terms().stiffness_damping,
            wheel: true,
            driven: true,
            plastic: true,
        }
        .values(&self.ledger);
        let State {
            u,
            v,
            history,
            resistance,
            ..
        } = &self.committed;
        for field in [u, v, history, resistance, &ledger] {
            for value in field {
                hasher.update(&value.to_le_bytes());
            }
        }
        if let Some(wheel) = &self.wheel {
            for value in wheel.numbers().iter().chain(&self.committed.a) {
                hasher.update(&value.to_le_bytes());
            }
        }
        hasher.finalize().to_hex().to_string()
    }

    /// Parts of the body's own load history, where it has one and the run has an end.
    pub(super) fn phases(&self) -> Vec<Phase> {
        if let Some(wheel) = &self.model.wheel {
            return wheel.program.phases();
        }
        let (tractions, drives) = (&self.model.tractions, &self.model.drives);
        let loaded = !tractions.is_empty() || !drives.is_empty();
        let Some(end) = self.model.end.filter(|_| loaded) else {
            return Vec::new();
        };
        let ramps = tractions.iter().map(|traction| traction.ramp());
        let ramps = ramps.chain(drives.iter().map(|drive| drive.ramp()));
        let ramp = ramps.fold(0.0, f64::max).min(end);
        let phase = |name: &str, t0_s: f64, t1_s: f64| Phase {
            name: name.into(),
            t0_s,
            t1_s,
            sampled: name == HOLD,
            picture: name == HOLD,
        };
        let phases = [phase("ramp", 0.0, ramp), phase(HOLD, ramp, end)];
        phases
            .into_iter()
            .filter(|phase| phase.t1_s > phase.t0_s)
            .collect()
    }

    pub(super) fn try_snapshot(&mut self, name: &str) -> Result<(), FemError> {
        let plain = |c: char| c.is_ascii_alphanumeric() || "-_.".contains(c);
        if name.is_empty() || !name.chars().all(plain) {
            return Err(FemError::SnapshotName { name: name.into() });
        }
        if name == HOLD {
            self.hold = Some(probe::pressure_maxima(&self.model, &self.committed));
        }
        let Some(folder) = &self.fields else {
            return Ok(());
        };
        let path = folder.join(format!("{}-{name}.vtu", self.participant));
        let touches = self.wheel.as_ref().map_or(&[][..], |wheel| &wheel.touches);
        vtu::write(&path, &self.model, &self.committed, touches)?;
        if touches.is_empty() {
            return Ok(());
        }
        let path = folder.join(format!("{}-{name}-profile.csv", self.participant));
        match &self.held {
            Some(held) if name == HOLD => held.profile.write(path),
            _ => Profile::in_motion(&self.model, touches).write(path),
        }
    }
}
