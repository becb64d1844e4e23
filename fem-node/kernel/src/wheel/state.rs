//! The state of the wheel at the end of a step.

use serde::{Deserialize, Serialize};

use super::node_contact::{NodeContact, count, force_on_wheel};
use super::rigid::Wheel;
use super::statistics::CycleStatistics;

kit::results! {
    /// # Signals
    /// - `sn_pct`: Share of sliding nodes among those in contact with the wheel.
    /// - `contact_nodes`: Nodes in contact with the wheel.
}

/// Cumulative energies of the wheel and its contact since the start (J); `WheelRun::add_energies` has the formulas.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Energies {
    /// Work of the load.
    pub load: f64,
    /// Work of the sideways drive.
    pub drive: f64,
    /// Dissipated by friction.
    pub friction: f64,
    /// Dissipated where nodes close and open.
    pub impact: f64,
    /// Dissipated by the damping of the start phase, the wheel's part.
    pub mass_damping: f64,
    /// Dissipated by the scheme, the wheel's part.
    pub numerical: f64,
}

/// State of the wheel and its contact.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct WheelState {
    /// Lowest point of the face (m).
    pub(crate) height: f64,
    /// Upwards (m/s).
    pub(crate) velocity: f64,
    /// Upwards (m/s2).
    pub(crate) acceleration: f64,
    /// Contact of each node of the upper edge.
    pub contacts: Vec<NodeContact>,
    /// Energies since the start.
    pub energies: Energies,
    /// Statistics over all steps so far.
    pub statistics: CycleStatistics,
    /// Own steps since the start.
    pub(super) step: u64,
}

impl WheelState {
    /// At rest, just touching the undeformed body.
    pub fn at_rest(wheel: &Wheel) -> WheelState {
        WheelState {
            height: wheel.first_height,
            contacts: vec![NodeContact::default(); wheel.points.len()],
            ..WheelState::default()
        }
    }

    /// At rest on a body in equilibrium, the face by `approach` (m) below its first contact.
    pub fn resting(wheel: &Wheel, approach: f64, contacts: Vec<NodeContact>) -> WheelState {
        let mut state = WheelState {
            height: wheel.first_height - approach,
            contacts,
            ..WheelState::default()
        };
        state.statistics.begin_at_rest(state.force()[1]);
        state
    }

    /// True where it touches the body.
    pub fn is_touching(&self) -> bool {
        self.contacts.iter().any(NodeContact::closed)
    }

    /// Kinetic energy of the vertical motion (J).
    pub fn kinetic(&self, wheel: &Wheel) -> f64 {
        0.5 * wheel.numbers.mass * self.velocity * self.velocity
    }

    /// Force of the body on the wheel (N).
    pub fn force(&self) -> [f64; 2] {
        force_on_wheel(&self.contacts)
    }

    /// Approach of the wheel since it touched the body (m).
    pub fn approach(&self, wheel: &Wheel) -> f64 {
        wheel.first_height - self.height
    }

    /// Its signals by name. `wheel_fn_n` and `wheel_ft_n` are the force of the body on the wheel, upwards and towards +x; `wheel_y_m` is
    /// the lowest point of the face, `sn_pct` the share of sliding nodes among those in contact.
    pub fn signals(&self, wheel: &Wheel) -> [(String, f64); 7] {
        let t = self.step as f64 * wheel.step;
        let [ft, fn_] = self.force();
        let count = count(&self.contacts);
        [
            ("wheel_x_m", wheel.program.displacement_at(t)),
            ("wheel_y_m", self.height),
            ("wheel_vx_m_per_s", wheel.program.speed_at(t)),
            ("wheel_fn_n", fn_),
            ("wheel_ft_n", ft),
            ("sn_pct", count.sliding_pct()),
            ("contact_nodes", count.closed as f64),
        ]
        .map(|(name, value)| (name.into(), value))
    }

    /// Numbers that can change a later bit.
    pub fn numbers(&self) -> Vec<f64> {
        let e = &self.energies;
        let mut numbers = vec![self.height, self.velocity, self.acceleration];
        numbers.extend([e.load, e.drive, e.friction]);
        numbers.extend([e.impact, e.mass_damping, e.numerical]);
        for contact in &self.contacts {
            numbers.extend(contact.normal);
            numbers.extend(contact.friction);
        }
        numbers
    }
}
