//! The contact zone: the part of the x axis that carries the wheel.

use serde::{Deserialize, Serialize};

use crate::bodies::Bodies;
use crate::config::FlowConfig;
use crate::state::State;

/// The zone, from one end to the other (m).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Zone {
    /// Its ends.
    pub ends: [f64; 2],
}

impl Zone {
    /// The interval that carries the wheel, widened by the margin; `diameter` is the mean one (m). `None` where the wheel bears
    /// nothing.
    ///
    /// By ascending x of the disks that press on the wheel, the end is the first disk with which the sum of the normal forces exceeds
    /// half of what `zone_share` leaves; the other end likewise from the other side.
    pub fn find(
        config: &FlowConfig,
        bodies: &Bodies,
        state: &State,
        diameter: f64,
    ) -> Option<Zone> {
        let wheel = bodies.wheel()?;
        let slots = state.list.slots.iter();
        let pressing = slots.filter(|slot| slot.b as usize == wheel && slot.force[0] > 0.0);
        let mut loads: Vec<[f64; 2]> = pressing
            .map(|slot| [state.centres[slot.a as usize][0], slot.force[0]])
            .collect();
        // Stable, and equal places make equal ends.
        loads.sort_by(|a, b| a[0].total_cmp(&b[0]));
        let total: f64 = loads.iter().map(|[_, force]| force).sum();
        let dropped = 0.5 * (1.0 - config.zone_share) * total;
        let margin = config.margin_diameters * diameter;
        let left = end(loads.iter(), dropped)?;
        let right = end(loads.iter().rev(), dropped)?;
        Some(Zone {
            ends: [left - margin, right + margin],
        })
    }

    /// The zone with each end where it was, unless the new one is further off than `slack` (m).
    pub fn moved_to(self, new: Zone, slack: f64) -> Zone {
        let follow = |k: usize| {
            if (new.ends[k] - self.ends[k]).abs() > slack {
                new.ends[k]
            } else {
                self.ends[k]
            }
        };
        Zone {
            ends: [0, 1].map(follow),
        }
    }

    /// True for a place in the zone (m).
    pub fn holds(&self, x: f64) -> bool {
        (self.ends[0]..=self.ends[1]).contains(&x)
    }
}

/// Place of the first of these loads, (m, N) each, with which their sum exceeds a force.
fn end<'a>(loads: impl Iterator<Item = &'a [f64; 2]>, dropped: f64) -> Option<f64> {
    let mut sum = 0.0;
    for [x, force] in loads {
        sum += force;
        if sum > dropped {
            return Some(*x);
        }
    }
    None
}
