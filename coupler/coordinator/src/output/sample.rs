//! Results of the interfaces in the phase that a participant marks for sampling ([`Phase::sampled`]).

use kit::cycle_drift::Mean;
use protocol::{Description, Phase, Window};
use serde::{Deserialize, Serialize};

use runs::profile::InterfaceTraction;
use scheme::keys::Interface;
use scheme::window::InterfaceSignals;

kit::results! {
    /// # Load and approach
    /// - `interface_force_n`: Normal force through the interface, mean over the last half of the
    ///   hold.
    /// - `p0_1mm_pa`: Largest mean of the pressure on the coupled surface over boxes of 1 mm, centred at multiples of
    ///   1 mm, at the end of the hold. Absent if the surface is shorter.
    /// - `half_width_98_m`: Distance from the middle of the last node that the nodes need to carry 98 % of the normal
    ///   force, counted outwards from the middle.
}

/// The load history of a run: the first participant's that has one.
pub fn load_history<'a>(participants: impl Iterator<Item = &'a Description>) -> Vec<Phase> {
    let mut histories = participants.map(|description| &description.phases);
    let found = histories.find(|phases| !phases.is_empty());
    found.cloned().unwrap_or_default()
}

/// Means over the last half of the sampled phase, after the transients of the loading, and the traction at its end.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct SampledMeans {
    /// Start and end of the second half (s).
    span: Option<(f64, f64)>,
    interfaces: Vec<InterfaceMean>,
}

/// Means and traction of one interface.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
struct InterfaceMean {
    /// Prefix of its results; empty for the only interface.
    prefix: String,
    /// Force through it (N).
    force_n: Mean,
    /// Force that pushes the continuum down (N).
    down_n: Mean,
    traction: Option<InterfaceTraction>,
}

impl SampledMeans {
    /// Means for a load history; empty without a sampled phase.
    pub fn new(phases: &[Phase], interfaces: &[Interface]) -> SampledMeans {
        let sampled = phases.iter().find(|phase| phase.sampled);
        let mean = |interface: &Interface| InterfaceMean {
            prefix: interface.prefix_among(interfaces.len()),
            ..InterfaceMean::default()
        };
        SampledMeans {
            span: sampled.map(|phase| (0.5 * (phase.t0_s + phase.t1_s), phase.t1_s)),
            interfaces: interfaces.iter().map(mean).collect(),
        }
    }

    /// Adds an accepted window of an interface with the forces on its continuum.
    pub fn add(&mut self, window: &Window, interface: usize, signals: &InterfaceSignals) {
        let inside =
            |(start, end): (f64, f64)| window.t0_s >= start && window.t1_s <= end * (1.0 + 1e-9);
        if self.span.is_some_and(inside) {
            let mean = &mut self.interfaces[interface];
            mean.force_n.add(signals.pressing_n);
            mean.down_n.add(-signals.force_n[1]);
        }
    }

    /// Keeps the traction of an interface at the end of the phase.
    pub fn keep_traction(&mut self, interface: usize, traction: InterfaceTraction) {
        self.interfaces[interface].traction = Some(traction);
    }

    /// Mean force that pushes the continuum of each interface down (N), if windows were sampled.
    pub fn down_n(&self) -> Vec<Option<f64>> {
        self.interfaces.iter().map(|of| of.down_n.value()).collect()
    }

    /// Results by their names in summary.json.
    pub fn results(&self) -> Vec<(String, f64)> {
        let mut results = Vec::new();
        for interface in &self.interfaces {
            let mut add = |name: &str, value| {
                results.push((format!("{}{name}", interface.prefix), value));
            };
            if let Some(mean) = interface.force_n.value() {
                add("interface_force_n", mean);
            }
            if let Some(traction) = &interface.traction {
                if let Some(peak) = traction.peak_of_means(1e-3) {
                    add("p0_1mm_pa", peak);
                }
                add("half_width_98_m", traction.half_width(0.98));
            }
        }
        results
    }
}
