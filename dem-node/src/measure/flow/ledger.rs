//! The ledger of the third body: masses that were detached, entered, left, and were worn.

use serde::{Deserialize, Serialize};

kit::results! {
    /// # Flows of third body
    /// - `q_source_kg`: Qs: mass that was detached from the first bodies within the zone.
    /// - `q_detached_total_kg`: Mass detached anywhere.
    /// - `q_reattached_kg`: Mass that bonds joined to a first body again.
    /// - `q_external_kg`: Qe: mass fed into the zone.
    /// - `q_injected_total_kg`: Mass fed in anywhere.
    /// - `q_ejected_kg`: Mass that left the zone by its own motion.
    /// - `q_left_by_zone_kg`: Mass left outside as the zone moved away.
    /// - `q_recirculated_kg`: Qr: mass that came back into the zone.
    /// - `q_entered_kg`: Mass that came into the zone for the first time by its own motion.
    /// - `q_entered_by_zone_kg`: Mass that the moving zone took in.
    /// - `q_wear_kg`: Qw: mass that stayed outside for `flow.wear_s`.
    /// - `q_wear_returned_kg`: Worn mass that came back.
    /// - `q_internal_net_kg`: Qi: mass through the section x = 0 towards +x, less the mass towards -x.
    /// - `q_internal_abs_kg`: Mass through the section x = 0 in both directions together.
}

/// Unscaled masses since the start (kg); all but `internal_net` only grow.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct MassLedger {
    /// Qs: turned from first to third body in the zone.
    pub source: f64,
    /// Turned from first to third body anywhere.
    pub detached: f64,
    /// Turned from third to first body in the zone.
    pub reattached: f64,
    /// Left the zone by its own motion.
    pub ejected: f64,
    /// Left outside by the motion of the zone.
    pub uncovered: f64,
    /// Qr: came back into the zone by its own motion.
    pub recirculated: f64,
    /// Came into the zone by its own motion for the first time.
    pub entered: f64,
    /// Taken in by the motion of the zone.
    pub covered: f64,
    /// Qe: fed into the zone.
    pub external: f64,
    /// Fed in anywhere.
    pub injected: f64,
    /// Qw: stayed outside for T_w.
    pub wear: f64,
    /// Came back after that, by any motion.
    pub wear_returned: f64,
    /// Ql: left the zone sideways, out of the plane.
    pub lateral: f64,
    /// Qi: through the section x = 0 towards +x, less the mass towards -x.
    pub internal_net: f64,
    /// Through that section in both directions.
    pub internal_abs: f64,
}

impl MassLedger {
    /// Masses that came into the zone as third body, and masses that went (kg).
    fn sides(&self) -> [f64; 2] {
        [
            self.source + self.external + self.recirculated + self.entered + self.covered,
            self.reattached + self.ejected + self.uncovered + self.lateral,
        ]
    }

    /// Third body in the zone by the ledger (kg): detached - re-attached + fed + entered - left.
    pub fn zone(&self) -> f64 {
        let [came, went] = self.sides();
        came - went
    }

    /// Sum of the masses that came and went (kg).
    pub fn turnover(&self) -> f64 {
        let [came, went] = self.sides();
        came + went
    }

    /// The masses under their names in signals and results.
    pub fn named(&self) -> [(&'static str, f64); 14] {
        [
            ("q_source_kg", self.source),
            ("q_external_kg", self.external),
            ("q_injected_total_kg", self.injected),
            ("q_wear_kg", self.wear),
            ("q_recirculated_kg", self.recirculated),
            ("q_internal_net_kg", self.internal_net),
            ("q_internal_abs_kg", self.internal_abs),
            ("q_reattached_kg", self.reattached),
            ("q_detached_total_kg", self.detached),
            ("q_wear_returned_kg", self.wear_returned),
            ("q_ejected_kg", self.ejected),
            ("q_left_by_zone_kg", self.uncovered),
            ("q_entered_kg", self.entered),
            ("q_entered_by_zone_kg", self.covered),
        ]
    }
}
