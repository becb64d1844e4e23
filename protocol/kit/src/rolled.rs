//! The results of a wheel that rolls: means over the last of several passages, or over the last half of the distance.

use std::fmt::Write;

use protocol::larger;
use serde::{Deserialize, Serialize};

use crate::rolling::Rolling;

crate::results! {
    /// # Rolling
    /// - `creepage`: Creepage (V - omega R)/V of a rolling wheel: a signal, and as a result the mean over
    ///   the last of several passages or the last half of the distance, as the results beside it.
    /// - `creep_force_n`: Tangential force T of a rolling wheel on what it rolls on, along the face;
    ///   positive brakes.
    /// - `torque_nm`: Braking torque T R on a rolling wheel.
    /// - `traction_ratio_scatter`: Standard deviation of T/N of a rolling wheel.
    /// - `rolling_resistance`: Force N e/R (N) by which the pressure, which leads the centre by e, holds a
    ///   rolling wheel back.
    /// - `slip_dissipation_j_per_m`: Energy that slip dissipates for each metre rolled.
    /// - `stick_share`: Share of the contact below a rolling wheel that sticks.
    /// - `contact_front_m`: Distance from the centre of a rolling wheel to the front end of its contact.
    /// - `contact_rear_m`: Distance from the centre of a rolling wheel to the rear end of its contact.
    /// - `p0_rolling_pa`: Largest contact pressure below a rolling wheel, over the nodes.
    /// - `creepage_slip_wheel`: Slip of a rolling wheel over the layer below, over V. With the seven results
    ///   that follow, it adds up to the creepage.
    /// - `creepage_layer_5`: Shear of the uppermost fifth of the layer below a rolling wheel, over V.
    /// - `creepage_layer_4`: Shear of the second fifth from above.
    /// - `creepage_layer_3`: Shear of the middle fifth.
    /// - `creepage_layer_2`: Shear of the fourth fifth from above.
    /// - `creepage_layer_1`: Shear of the lowest fifth.
    /// - `creepage_slip_base`: Slip of the layer over its base, over V.
    /// - `creepage_body`: Motion of the surface of the body below the layer, over V.
    /// - `nip_kg`: Grains between the ends of the contact of a rolling wheel.
    /// - `loose_nip_kg`: Grains without bonds between the ends of this contact.
    /// - `loose_ahead_kg`: Grains without bonds ahead of this contact, up to its own width.
    /// - `loose_behind_kg`: Grains without bonds behind this contact, up to its own width.
    /// - `damping_j_per_m`: Energy that dampers take for each metre rolled.
    /// - `cohesion_j_per_m`: Energy that bonds lose for each metre rolled.
    /// - `numerical_j_per_m`: Energy that the time scheme takes for each metre rolled.
}

/// Names of the losses of grains beside slip.
pub const LOSSES: [&str; 3] = ["damping_j_per_m", "cohesion_j_per_m", "numerical_j_per_m"];

/// Names of the results of a layer below the wheel: [`SITES`] shares of the creepage, then masses.
pub const LAYER: [&str; 12] = [
    "creepage_slip_wheel",
    "creepage_layer_5",
    "creepage_layer_4",
    "creepage_layer_3",
    "creepage_layer_2",
    "creepage_layer_1",
    "creepage_slip_base",
    "creepage_body",
    "nip_kg",
    "loose_nip_kg",
    "loose_ahead_kg",
    "loose_behind_kg",
];

/// Number of sites among them.
pub const SITES: usize = 8;

/// The contact of a rolling wheel over a piece of its way.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RolledPiece {
    /// Length of the piece (m).
    pub way: f64,
    /// Length of the face that has rolled off (m).
    pub turned: f64,
    /// Tangential force along the face (N), positive where it brakes.
    pub creep_force: f64,
    /// Force against the rolling, along x (N), the creep force included.
    pub force_x: f64,
    /// Normal force (N).
    pub normal: f64,
    /// Energy that slip dissipates (J).
    pub dissipated: f64,
    /// Share of the contact that sticks.
    pub stick: f64,
    /// Front and rear end of the contact before the centre (m).
    pub ends: [f64; 2],
    /// Largest pressure (Pa), where it is known.
    pub peak: Option<f64>,
    /// Results of a layer, by [`LAYER`].
    pub layer: Option<[f64; LAYER.len()]>,
    /// Losses of the grains (J), by [`LOSSES`].
    pub losses: Option<[f64; LOSSES.len()]>,
}

/// Ends and sticking share of a contact, point by point.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ContactExtent {
    ends: Option<[f64; 2]>,
    stuck: f64,
    closed: f64,
}

impl ContactExtent {
    /// Adds a point that touches at this distance before the centre (m); `weight` is its surface or its force.
    pub fn touch(&mut self, before: f64, weight: f64, sticks: bool) {
        let [front, rear] = self.ends.unwrap_or([before; 2]);
        self.ends = Some([larger(front, before), -larger(-rear, -before)]);
        self.closed += weight;
        if sticks {
            self.stuck += weight;
        }
    }

    /// Front and rear end (m), and the share of the weights that sticks; 0 without a contact.
    pub fn ends_and_stick(self) -> ([f64; 2], f64) {
        match self.ends {
            Some(ends) => (ends, self.stuck / self.closed),
            None => ([0.0; 2], 0.0),
        }
    }
}

/// Sums over a part of the way.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Sums {
    way: f64,
    turned: f64,
    creep_force: f64,
    force_x: f64,
    ratio: [f64; 2],
    ratio_peak: f64,
    dissipated: f64,
    stick: f64,
    ends: [f64; 2],
    peak: [f64; 2],
    layer: (f64, [f64; LAYER.len()]),
    losses: Option<[f64; LOSSES.len()]>,
}

impl Sums {
    fn add(&mut self, piece: &RolledPiece) {
        let way = piece.way;
        crate::add_fields!(self, piece; way, turned, dissipated);
        self.creep_force += way * piece.creep_force;
        self.force_x += way * piece.force_x;
        self.stick += way * piece.stick;
        self.ends = [0, 1].map(|k| self.ends[k] + way * piece.ends[k]);
        if piece.normal > 0.0 {
            let ratio = piece.creep_force / piece.normal;
            self.ratio = [
                self.ratio[0] + way * ratio,
                self.ratio[1] + way * ratio * ratio,
            ];
            self.ratio_peak = larger(self.ratio_peak, ratio.abs());
        }
        if let Some(peak) = piece.peak {
            self.peak = [self.peak[0] + way, self.peak[1] + way * peak];
        }
        if let Some(losses) = piece.losses {
            let sums = self.losses.get_or_insert_default();
            *sums = std::array::from_fn(|k| sums[k] + losses[k]);
        }
        if let Some(layer) = piece.layer {
            self.layer.0 += way;
            self.layer.1 = std::array::from_fn(|k| self.layer.1[k] + way * layer[k]);
        }
    }

    /// Means under the names of the results.
    fn means(&self, radius: f64) -> Vec<(&'static str, f64)> {
        let mean = |sum: f64| sum / self.way;
        let ratio = mean(self.ratio[0]);
        let [front, rear] = self.ends.map(mean);
        let mut means = vec![
            ("creepage", 1.0 - mean(self.turned)),
            ("traction_ratio_mean", ratio),
            ("traction_ratio_peak", self.ratio_peak),
            (
                "traction_ratio_scatter",
                (mean(self.ratio[1]) - ratio * ratio).max(0.0).sqrt(),
            ),
            ("creep_force_n", mean(self.creep_force)),
            ("torque_nm", mean(self.creep_force) * radius),
            ("rolling_resistance", mean(self.force_x - self.creep_force)),
            ("slip_dissipation_j_per_m", mean(self.dissipated)),
            ("stick_share", mean(self.stick)),
            ("contact_front_m", front),
            ("contact_rear_m", rear),
        ];
        if self.peak[0] > 0.0 {
            means.push(("p0_rolling_pa", self.peak[1] / self.peak[0]));
        }
        let losses = self.losses.iter().copied().flatten().map(mean);
        means.extend(LOSSES.into_iter().zip(losses));
        if self.layer.0 > 0.0 {
            let own = self.layer.1.map(|sum| sum / self.layer.0);
            means.extend(LAYER.into_iter().zip(own));
        }
        means
    }
}

/// All passages of a rolling wheel.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RollingRecord {
    passages: Vec<Sums>,
    judged: Sums,
    rolled: f64,
    /// Creepage and creep force (N) in the last piece.
    last: [f64; 2],
}

impl RollingRecord {
    /// Adds the piece of the way that ends the distance rolled so far. A piece counts where its middle lies.
    pub fn add(&mut self, rolling: &Rolling, piece: &RolledPiece) {
        let middle = self.rolled + 0.5 * piece.way;
        self.rolled += piece.way;
        self.last = [1.0 - piece.turned / piece.way, piece.creep_force];
        let passage = rolling.passage();
        let index = (middle / passage) as usize;
        self.passages
            .resize(self.passages.len().max(index + 1), Sums::default());
        self.passages[index].add(piece);
        if middle > rolling.judged_from() {
            self.judged.add(piece);
        }
    }

    /// Creepage in the last piece.
    pub fn creepage(&self) -> f64 {
        self.last[0]
    }

    /// Its signals by name.
    pub fn signals(&self) -> [(&'static str, f64); 2] {
        let [creepage, force] = self.last;
        [("creepage", creepage), ("creep_force_n", force)]
    }

    /// Results by name of a wheel of this radius (m); none before it has rolled its whole distance.
    pub fn results(&self, rolling: &Rolling, radius: f64) -> Vec<(&'static str, f64)> {
        if self.judged.way == 0.0 || self.rolled < (1.0 - 1e-6) * rolling.distance {
            return Vec::new();
        }
        self.judged.means(radius)
    }

    /// The table `<participant>-passages.csv`: one row for each passage that has ended.
    pub fn csv(&self, rolling: &Rolling, radius: f64) -> String {
        let passage = rolling.passage();
        let ended = (self.rolled / passage + 1e-6) as usize;
        let mut text = String::new();
        for (k, sums) in self.passages.iter().take(ended).enumerate() {
            let means = sums.means(radius);
            if k == 0 {
                let names: String = means.iter().map(|(name, _)| format!(",{name}")).collect();
                writeln!(text, "passage,from_m,to_m{names}").expect("a string");
            }
            let values: String = means.iter().map(|(_, x)| format!(",{x:e}")).collect();
            let [from, to] = [k, k + 1].map(|k| k as f64 * passage);
            writeln!(text, "{},{from:e},{to:e}{values}", k + 1).expect("a string");
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rolling::RollingConfig;

    /// Two passages of 1 m, in pieces of 0.25 m: the force is 1 N in the first and 3 N in the second, of 10 N.
    #[test]
    fn means_are_of_the_last_passage() {
        let config: RollingConfig =
            serde_json::from_str(r#"{"speed_m_per_s": 1.0, "creepage": 0.02, "passes": 2.0}"#)
                .expect("valid");
        let rolling = config.rolling(0.5, Some(1.0)).expect("valid");
        let mut record = RollingRecord::default();
        for k in 0..8 {
            assert!(record.results(&rolling, 0.5).is_empty(), "{k}");
            let force = if k < 4 { 1.0 } else { 3.0 };
            record.add(
                &rolling,
                &RolledPiece {
                    way: 0.25,
                    turned: 0.25 * 0.98,
                    creep_force: force,
                    force_x: force + 0.5,
                    normal: 10.0,
                    dissipated: 0.25 * 0.02 * force,
                    stick: 0.75,
                    ends: [0.1, -0.2],
                    peak: Some(7.0),
                    layer: None,
                    losses: None,
                },
            );
        }
        let results = record.results(&rolling, 0.5);
        let of = |name: &str| results.iter().find(|(n, _)| *n == name).expect(name).1;
        for (name, expected) in [
            ("creepage", 0.02),
            ("traction_ratio_mean", 0.3),
            ("traction_ratio_peak", 0.3),
            ("traction_ratio_scatter", 0.0),
            ("torque_nm", 1.5),
            ("rolling_resistance", 0.5),
            ("slip_dissipation_j_per_m", 0.06),
            ("stick_share", 0.75),
            ("contact_rear_m", -0.2),
            ("p0_rolling_pa", 7.0),
        ] {
            assert!((of(name) - expected).abs() < 1e-7, "{name}");
        }
        let csv = record.csv(&rolling, 0.5);
        assert_eq!(csv.lines().count(), 3, "{csv}");
    }
}
