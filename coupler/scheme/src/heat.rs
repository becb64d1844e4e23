//! Heat through the interfaces of a group.
//!
//! ```text
//!   layers:   Q since the last exchange, into the boundary at each glued point      Q_n = N^T Q: no heat is lost
//!   continua: T of their nodes, with Q_n                                            T_p = N T
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
        let given = self.give(group, participants, window)?;
        for (passed, patch) in self.passed.iter_mut().zip(&group.patches) {
            *passed += given[patch.points.clone()].iter().sum::<f64>();
        }
        let heat = group.mapping.spread(&given);
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
        self.temperature = asked.collect::<Result<Vec<_>>>()?.concat();
        Ok(())
    }

    /// Temperatures of the layers' points for the heat that they have given (J).
    fn give(
        &self,
        group: &Group,
        participants: &mut dyn Participants,
        window: &Window,
    ) -> Result<Vec<f64>> {
        let temperature = group.mapping.means(&self.temperature);
        let sides = group.motion_driven.iter();
        let asked = sides.map(|side| {
            let kelvins = HeatRequest::Temperatures(&temperature[side.range.clone()]);
            participants.exchange_heat(side.peer, window, kelvins)
        });
        Ok(asked.collect::<Result<Vec<_>>>()?.concat())
    }
}
