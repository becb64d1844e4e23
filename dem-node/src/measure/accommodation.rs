//! The sites of velocity accommodation (Berthier, Godet and Brendle 1989): the motion of the wheel goes into slip of the layer, into the body
//! below it, and the rest into shear of the layer itself.
//!
//! ```text
//!      T |      ______   d, the way of the wheel against the base, turns back at the ends of a stroke. Behind a spring k a Coulomb contact
//!        |     /     /   then sticks over 2 F/k, passing T = 0 after F/k, and slides over the rest. A stroke of the length b, which T = 0
//!   -----|----/-----/--  divides at a, slides over b - 2 a, for any k and F. The base moves with v = sum p v_x/sum p, p being the
//!        |   /_____/     impulses that press its points down.
//!              d
//! ```
//!
//! - `slip_amplitude_m`: half of the way that slides, mean over the strokes that end in a cycle;
//! - `accommodated_by_body_m`: half the range of the displacement of the base in a cycle;
//! - `p0_1mm_pa`: largest mean over 1 mm of the pressure on the base, itself a mean over a cycle.

use kit::boxes::peak_of_means;
use kit::cycle_drift::Mean;
use kit::traction::GrossSliding;
use protocol::larger;
use serde::{Deserialize, Serialize};

use dem_kernel::bodies::Bodies;
use dem_kernel::step::state::GrainState;

/// Width of the boxes over which the pressure is averaged (m).
const BOX_M: f64 = 1e-3;

/// The strokes and the base since the start of the cycle.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Accommodation {
    /// Displacement of the base, and its least and largest value in the cycle (m).
    base: f64,
    range: [f64; 2],
    /// Impulse that pressed each point of the base down (N s), and its time (s).
    pressed: Vec<f64>,
    time: f64,
    thickness_m: f64,
    /// Way of the wheel against the base (m), and the force on it (N).
    now: [f64; 3],
    stroke: Option<Stroke>,
    slips: Mean,
}

/// A motion of the wheel from one end to the other.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
struct Stroke {
    /// Way and force at its start (m, N).
    start: [f64; 3],
    /// Distance from the start at which the force passed 0 (m).
    zero: Option<f64>,
    /// The slip of the stroke.
    sliding: GrossSliding,
}

impl Accommodation {
    /// An empty record, for a scene of this thickness (m).
    pub fn new(thickness_m: f64) -> Accommodation {
        Accommodation {
            thickness_m,
            ..Accommodation::default()
        }
    }

    /// Records a step of the length h (s) that left this state, a force on the wheel (N) and these impulses on the points of the boundary
    /// (2 n).
    pub fn record(
        &mut self,
        h: f64,
        state: &GrainState,
        [tangential, normal]: [f64; 2],
        impulses: &[f64],
    ) {
        self.pressed.resize(impulses.len() / 2, 0.0);
        let [mut all, mut moved] = [0.0; 2];
        let points = self.pressed.iter_mut().zip(impulses.chunks_exact(2));
        for ((sum, impulse), velocity) in points.zip(state.glued_velocity.chunks_exact(2)) {
            let down = -impulse[1];
            *sum += down;
            all += down.max(0.0);
            moved += down.max(0.0) * velocity[0];
        }
        self.time += h;
        if all > 0.0 {
            self.base += h * moved / all;
        }
        let [low, high] = self.range;
        self.range = [low.min(self.base), larger(high, self.base)];
        let now = [state.wheel.position[0] - self.base, tangential, normal];
        if let Some(stroke) = &mut self.stroke {
            stroke.move_on(self.now, now);
        }
        self.now = now;
    }

    /// The wheel turns back. Returns the slip of the stroke that ends.
    pub fn turn(&mut self) -> GrossSliding {
        let next = Stroke {
            start: self.now,
            ..Stroke::default()
        };
        let Some(stroke) = self.stroke.replace(next) else {
            return GrossSliding::default();
        };
        let length = (self.now[0] - stroke.start[0]).abs();
        if let Some(zero) = stroke.zero {
            self.slips.add(0.5 * larger(0.0, length - 2.0 * zero));
        }
        GrossSliding {
            way: length,
            ..stroke.sliding
        }
    }

    /// Ends a cycle: slip and amplitude of the base (m), and the largest mean over 1 mm of the pressure on it (Pa). Missing values are NaN.
    pub fn end_cycle(&mut self, bodies: &Bodies) -> [f64; 3] {
        let [low, high] = self.range;
        let slip = self.slips.value().unwrap_or(f64::NAN);
        let pieces = pieces(bodies, &self.pressed);
        let period = bodies.period.map(|period| period.length);
        let peak = peak_of_means(pieces.into_iter(), BOX_M, period);
        let pressure = peak.map_or(f64::NAN, |peak| peak / (self.time * self.thickness_m));
        self.slips = Mean::default();
        self.range = [self.base; 2];
        self.pressed.fill(0.0);
        self.time = 0.0;
        [slip, 0.5 * (high - low), pressure]
    }
}

impl Stroke {
    /// Moves from one way and force (m, N) to the next: beyond twice the distance to T = 0 the wheel slides.
    fn move_on(&mut self, before: [f64; 3], now: [f64; 3]) {
        let way = |[d, ..]: [f64; 3]| (d - self.start[0]).abs();
        let [from, to] = [way(before), way(now)];
        match self.zero {
            Some(zero) if from >= 2.0 * zero => {
                self.sliding.slide(to - from, [now[1], now[2]]);
            }
            None if now[1] * self.start[1] <= 0.0 => {
                let share = before[1] / (before[1] - now[1]);
                let share = if share.is_finite() { share } else { 0.0 };
                self.zero = Some(from + share * (to - from));
            }
            _ => {}
        }
    }
}

/// The points of the base from left to right, each with its load, spread to the middles between it and its neighbours (m).
fn pieces(bodies: &Bodies, borne: &[f64]) -> Vec<([f64; 2], f64)> {
    let places = borne.iter().enumerate();
    let places = places.map(|(point, borne)| (bodies.boundary_point(point)[0], *borne));
    let mut places: Vec<(f64, f64)> = places.collect();
    places.sort_by(|a, b| a.0.total_cmp(&b.0));
    let middle = |a: usize, b: usize| 0.5 * (places[a].0 + places[b].0);
    let last = places.len().saturating_sub(1);
    let ends = |k: usize| match k {
        _ if last == 0 => [places[0].0 - 0.5 * BOX_M, places[0].0 + 0.5 * BOX_M],
        0 => [2.0 * places[0].0 - middle(0, 1), middle(0, 1)],
        _ if k == last => [middle(k - 1, k), 2.0 * places[k].0 - middle(k - 1, k)],
        _ => [middle(k - 1, k), middle(k, k + 1)],
    };
    let pieces = (0..places.len()).map(|k| (ends(k), places[k].1));
    pieces.filter(|([low, high], _)| low < high).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Five points of a base that moves by 1 mm/s for 1 s and back by 3 mm/s for 1 s; one of them bears nothing and runs away. 100 N on each of three
    /// points about x = 0, 0.4 mm apart, are 250 N on a box of 1 mm, 2 mm thick.
    #[test]
    fn a_base_has_its_range_and_its_pressure() {
        let bodies = Bodies {
            reference: (0..5).map(|k| [0.4e-3 * f64::from(k - 1), 0.0]).collect(),
            base: 5,
            ..Bodies::default()
        };
        let mut slip = Accommodation::new(2e-3);
        for speed in [1e-3, -3e-3] {
            let points = [[speed, 0.0]; 4].concat().into_iter();
            let state = GrainState {
                glued_velocity: points.chain([9.0, 0.0]).collect(),
                ..GrainState::default()
            };
            let down = [0.0, -100.0];
            let impulses = [down, down, down, [0.0; 2], [0.0; 2]].concat();
            slip.record(1.0, &state, [0.0; 2], &impulses);
        }
        let [_, amplitude, pressure] = slip.end_cycle(&bodies);
        assert!((amplitude - 1.5e-3).abs() < 1e-15, "from 1 mm to -2 mm");
        assert!((pressure / 125e6 - 1.0).abs() < 1e-12, "{pressure:e}");
        // The next cycle begins at the position of the base.
        assert_eq!(slip.end_cycle(&bodies)[1], 0.0);
    }

    /// A contact of 6 N behind a spring of 2 N/m: with an amplitude of 10 m it slides over 7 m, with 2.5 m it sticks.
    #[test]
    fn a_coulomb_contact_behind_a_spring_slides_over_the_rest_of_its_way() {
        for (amplitude, expected) in [(10.0, 7.0), (2.5, 0.0)] {
            let mut slip = Accommodation::new(1.0);
            let (mut force, mut before, mut slid) = (0.0f64, 0.0, GrossSliding::default());
            for step in 1..=900 {
                let angle = f64::from(step) / 400.0 * std::f64::consts::TAU;
                let mut state = GrainState::default();
                state.wheel.position[0] = amplitude * angle.sin();
                force = (force + 2.0 * (state.wheel.position[0] - before)).clamp(-6.0, 6.0);
                before = state.wheel.position[0];
                slip.record(1.0, &state, [force, 20.0], &[]);
                if step % 200 == 100 {
                    slid = slip.turn();
                }
            }
            let [found, ..] = slip.end_cycle(&Bodies::default());
            assert!((found - expected).abs() < 1e-12, "{found}");
            let GrossSliding { way, slid, work } = slid;
            assert!((way - 2.0 * amplitude).abs() < 1e-12, "{way}");
            assert!((slid - 2.0 * expected).abs() < 0.2, "{slid}");
            let [rubbed, pressed] = work.map(|work| work - 6.0 * slid);
            assert!(rubbed.abs() < 1e-9 && (pressed - 14.0 * slid).abs() < 1e-9);
        }
    }
}
