//! The contact zone: the part of the x axis that carries the wheel, the part below a lid, or the whole of a strip that repeats.

use std::collections::BTreeMap;

use dem_kernel::bodies::Bodies;
use dem_kernel::step::state::GrainState;
use serde::{Deserialize, Serialize};

use crate::config::flow::FlowConfig;

/// The zone, from one end to the other (m).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Zone {
    /// Its ends.
    pub ends: [f64; 2],
}

impl Zone {
    /// The interval that carries the wheel, widened by the margin; `diameter` is the mean diameter (m). `None` while the wheel has borne no load.
    ///
    /// By ascending x of the loads, the end is the first load with which the sum of the normal forces exceeds half of the part beyond `zone_share`;
    /// the other end follows likewise from the other side.
    pub fn find(config: &FlowConfig, loads: &ZoneLoads, diameter: f64) -> Option<Zone> {
        let total = loads.force();
        let dropped = 0.5 * (1.0 - config.zone_share) * total;
        let margin = config.margin_diameters * diameter;
        let left = end(loads.cells.values(), dropped)?;
        let right = end(loads.cells.values().rev(), dropped)?;
        let ends = [left - margin, right + margin];
        Some(Zone { ends })
    }

    /// The zone with each end kept, unless the new end is further off than `slack` (m).
    pub fn moved_to(self, new: Zone, slack: f64) -> Zone {
        let follow = |k: usize| {
            if (new.ends[k] - self.ends[k]).abs() > slack {
                new.ends[k]
            } else {
                self.ends[k]
            }
        };
        let ends = [0, 1].map(follow);
        Zone { ends }
    }

    /// Its middle half.
    pub fn middle_half(self) -> Zone {
        let [left, right] = self.ends;
        let quarter = 0.25 * (right - left);
        let ends = [left + quarter, right - quarter];
        Zone { ends }
    }

    /// True for an x in the zone (m).
    pub fn holds(&self, x: f64) -> bool {
        (self.ends[0]..=self.ends[1]).contains(&x)
    }
}

/// The normal force on the wheel over x, averaged over some time: in a loose layer a few grains carry it, and others after the next step.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ZoneLoads {
    /// Force (N) and its mean x (m) in cells of a mean diameter each, by ascending x.
    cells: BTreeMap<i64, [f64; 2]>,
}

impl ZoneLoads {
    /// Adds the forces of a state to the exponential mean, whose older part loses this `share`; `diameter` is the mean diameter (m).
    pub fn update(&mut self, bodies: &Bodies, state: &GrainState, diameter: f64, share: f64) {
        self.cells.retain(|_, [force, _]| {
            *force *= 1.0 - share;
            *force > 0.0
        });
        for [at, pressing] in state.on_wheel(bodies) {
            let added = share * pressing;
            let cell = (at / diameter).floor() as i64;
            let [force, x] = self.cells.entry(cell).or_default();
            *force += added;
            *x += (at - *x) * (added / *force);
        }
    }

    /// The mean force on the wheel (N).
    pub fn force(&self) -> f64 {
        self.cells.values().map(|[force, _]| force).sum()
    }

    /// All its numbers.
    pub fn numbers(&self) -> impl Iterator<Item = f64> {
        let cells = self.cells.iter();
        cells.flat_map(|(cell, [force, x])| [*cell as f64, *force, *x])
    }
}

/// The x of the first of these loads, (N, m) each, with which their sum exceeds a force.
fn end<'a>(loads: impl Iterator<Item = &'a [f64; 2]>, dropped: f64) -> Option<f64> {
    let mut sum = 0.0;
    for [force, x] in loads {
        sum += force;
        if sum > dropped {
            return Some(*x);
        }
    }
    None
}
