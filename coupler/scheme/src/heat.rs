//! Heat through the interfaces of a group.
//!
//! ```text
//!   layers:   Q since the last exchange, into the boundary at each glued point, and h = -dQ/dT_p at given grains
//!   continua: T of their nodes                                                                         T_p = N T
//!   Q_i = sum N_pi (Q_p + h_p (T_p - T_i))      no heat is lost, and each node takes by its own temperature
//! ```
//! Every few windows the layers get the temperatures that the continua had at the exchange before, and give the heat that has passed since: conduction
//! is slower than any window, so that neither side waits for the other.

use protocol::Window;
use serde::{Deserialize, Serialize};

use super::group::Group;
use super::participants::{HeatRequest, Participants};
use crate::error::Result;

/// Heat through the interfaces so far.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct HeatState {
    /// Temperatures of the exchanged nodes (K); empty before the first exchange.
    temperature: Vec<f64>,
    /// Those that the layers had up to the last exchange (K), under which they gave its heat.
    shown: Vec<f64>,
    /// Heat that has passed into the continuum through each interface (J).
    pub passed: Vec<f64>,
}

impl HeatState {
    /// Gives the layers the temperatures at the start, before the window.
    pub(super) fn begin(
        &mut self,
        group: &Group,
        participants: &mut dyn Participants,
        window: &Window,
    ) -> Result<()> {
        if !self.temperature.is_empty() {
            return Ok(());
        }
        self.passed = vec![0.0; group.patches.len()];
        self.take(group, participants, window, &vec![0.0; group.nodes.len()])?;
        self.shown.clone_from(&self.temperature);
        self.give(group, participants, window)?;
        Ok(())
    }

    /// Exchanges heat and temperatures after the window.
    pub(super) fn exchange(
        &mut self,
        group: &Group,
        participants: &mut dyn Participants,
        window: &Window,
    ) -> Result<()> {
        let [given, per_kelvin] = self.give(group, participants, window)?;
        for (passed, patch) in self.passed.iter_mut().zip(&group.patches) {
            *passed += given[patch.points.clone()].iter().sum::<f64>();
        }
        let heat = group.mapping.spread(&given, &per_kelvin, &self.shown);
        self.take(group, participants, window, &heat)
    }

    /// Heat of the continua's nodes (J) for their temperatures.
    fn take(
        &mut self,
        group: &Group,
        participants: &mut dyn Participants,
        window: &Window,
        heat: &[f64],
    ) -> Result<()> {
        let sides = group.force_driven.iter();
        let asked = sides.map(|side| {
            let heat = HeatRequest::Heat(&heat[side.range.clone()]);
            participants.exchange_heat(side.peer, &side.window(window), heat)
        });
        let answered = asked.collect::<Result<Vec<_>>>()?.concat();
        self.shown = std::mem::replace(&mut self.temperature, answered);
        Ok(())
    }

    /// Temperatures of the layers' points for the heat that they have given (J), and their heat per kelvin (J/K).
    fn give(
        &self,
        group: &Group,
        participants: &mut dyn Participants,
        window: &Window,
    ) -> Result<[Vec<f64>; 2]> {
        let temperature = group.mapping.means(&self.temperature);
        let mut given = [Vec::new(), Vec::new()];
        for side in &group.motion_driven {
            let kelvins = HeatRequest::Temperatures(&temperature[side.range.clone()]);
            let answer = participants.exchange_heat(side.peer, window, kelvins)?;
            let (heat, per_kelvin) = answer.split_at(side.range.len());
            given[0].extend(heat);
            given[1].extend(per_kelvin);
        }
        Ok(given)
    }
}
