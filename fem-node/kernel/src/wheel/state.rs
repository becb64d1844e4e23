//! The state of the wheel at the end of a step.

use kit::rolled::RollingRecord;
use kit::rolling::nearest_image;
use serde::{Deserialize, Serialize};

use super::newmark::Newmark;
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
    /// Velocity and acceleration of a face that turns freely, R omega (m/s, m/s2).
    pub(super) spin: [f64; 2],
    /// The way that it has rolled.
    pub rolled: RollingRecord,
    /// Energy that friction has dissipated at each node of the upper edge (J).
    pub slid: Vec<f64>,
}

impl WheelState {
    /// At rest, just touching the undeformed body.
    pub fn at_rest(wheel: &Wheel) -> WheelState {
        WheelState {
            height: wheel.first_height,
            contacts: vec![NodeContact::default(); wheel.points.len()],
            slid: vec![0.0; wheel.points.len()],
            ..WheelState::default()
        }
    }

    /// At rest on a body in equilibrium, the face by `approach` (m) below its first contact.
    pub fn resting(wheel: &Wheel, approach: f64, contacts: Vec<NodeContact>) -> WheelState {
        let mut state = WheelState {
            height: wheel.first_height - approach,
            slid: vec![0.0; contacts.len()],
            contacts,
            ..WheelState::default()
        };
        state.statistics.begin_at_rest(state.force()[1]);
        state
    }

    /// Results of its rolling by name.
    pub fn rolling_results(&self, wheel: &Wheel) -> Vec<(String, f64)> {
        let rolling = wheel.program.rolling.iter();
        let results = rolling.flat_map(|all| self.rolled.results(all, wheel.numbers.radius));
        results.map(|(name, value)| (name.into(), value)).collect()
    }

    /// The table of its passages, empty without one.
    pub fn passages(&self, wheel: &Wheel) -> String {
        let rolling = wheel.program.rolling.as_ref();
        rolling.map_or(String::new(), |all| {
            self.rolled.csv(all, wheel.numbers.radius)
        })
    }

    /// Energy that friction has dissipated at each node (J), and the nodes that it touches.
    pub fn rubbed(&self) -> (&[f64], impl Iterator<Item = bool>) {
        (&self.slid, self.contacts.iter().map(NodeContact::closed))
    }

    /// True where it touches the body.
    pub fn is_touching(&self) -> bool {
        self.contacts.iter().any(NodeContact::closed)
    }

    /// Kinetic energy of the vertical motion and of a free spin (J).
    pub fn kinetic(&self, wheel: &Wheel) -> f64 {
        let vertical = 0.5 * wheel.numbers.mass * self.velocity * self.velocity;
        let spin = wheel.spin(self.step);
        vertical + spin.map_or(0.0, |[mass, _]| 0.5 * mass * self.spin[0] * self.spin[0])
    }

    /// Length of the face that rolls off in the next step without tangential forces now, and its change for each unit of force (m, m/N). A wheel
    /// that spins freely begins without creepage, and its drive gives the energy.
    pub(super) fn free_turn(&mut self, wheel: &Wheel, scheme: Newmark) -> [f64; 2] {
        let step = self.step;
        let Some([mass, brake]) = wheel.spin(step).filter(|_| step >= wheel.motion_step) else {
            return [wheel.turn_over(step).unwrap_or(0.0), 0.0];
        };
        if step > wheel.motion_step {
            let turn = scheme.next(0.0, self.spin, -brake / mass);
            return [turn, scheme.weight() / mass];
        }
        let rolling = wheel.program.rolling.as_ref();
        let speed = rolling.map_or(0.0, |rolling| rolling.speed);
        self.spin = [speed, 0.0];
        self.energies.drive += 0.5 * mass * speed * speed;
        let half = 0.5 * wheel.step * wheel.step / mass;
        [wheel.step * speed - half * brake, half]
    }

    /// The spin at the end of the step, once the tangential forces are known.
    pub(super) fn spin_on(&mut self, wheel: &Wheel, scheme: Newmark) {
        let step = self.step;
        let Some([mass, brake]) = wheel.spin(step).filter(|_| step >= wheel.motion_step) else {
            return;
        };
        let drag: f64 = self.contacts.iter().map(NodeContact::dragging).sum();
        let push = (drag - brake) / mass;
        if step == wheel.motion_step {
            self.spin[1] = push;
        } else {
            self.spin = scheme.rates(self.spin, push);
        }
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
    pub fn signals(&self, wheel: &Wheel) -> Vec<(String, f64)> {
        let t = self.step as f64 * wheel.step;
        let [ft, fn_] = self.force();
        let count = count(&self.contacts);
        let named = [
            (
                "wheel_x_m",
                nearest_image(wheel.program.displacement_at(t), wheel.period),
            ),
            ("wheel_y_m", self.height),
            ("wheel_vx_m_per_s", wheel.program.speed_at(t)),
            ("wheel_fn_n", fn_),
            ("wheel_ft_n", ft),
            ("sn_pct", count.sliding_pct()),
            ("contact_nodes", count.closed as f64),
        ];
        let mut signals = Vec::from(named.map(|(name, value)| (name.into(), value)));
        if wheel.program.rolling.is_some() {
            let rolled = self.rolled.signals();
            signals.extend(rolled.map(|(name, value)| (name.into(), value)));
        }
        signals
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
        if self.spin != [0.0; 2] {
            numbers.extend(self.spin);
        }
        numbers
    }
}
