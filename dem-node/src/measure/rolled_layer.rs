//! The layer below a wheel that rolls: the sites where the creepage is taken up (Berthier, Godet and Brendle 1989), and its loose grains.
//!
//! ```text
//!  face of the wheel        v_w  ------.
//!  grains that touch it     v_t  ----.   slip at the wheel           velocities along the rolling, over V; their jumps add
//!  heights 4/5, 3/5,        v_4  ---.    shear of five fifths        up to v_w, the creepage
//!          2/5, 1/5         ..
//!  grains on the base       v_b  --.     slip at the base
//!  the base                 v_s  -.      motion of the body below
//! ```
//!
//! Velocities at contacts are means weighted by their normal forces. Velocities at a height are means over the chords of the grains there, spin
//! included, weighted as the pressure of Hertz between the ends of the contact.

use dem_kernel::bodies::Bodies;
use dem_kernel::contact::bond::holding;
use dem_kernel::contact::detect::Slot;
use dem_kernel::step::state::GrainState;
use kit::rolled::{LAYER, SITES};
use kit::rolling::Rolling;

use crate::measure::loads::grains;

kit::results! {
    /// # Rolling
    /// - `rolling_speed_rel`: Speed of a rolling wheel over the speed of shear waves in the layer below, whose
    ///   mass is scaled. A bound from below: uniform strain is assumed.
}

/// Mean over contacts of velocity and height.
#[derive(Clone, Copy, Debug, Default)]
struct Touch {
    force: f64,
    /// Of the grain and of the other body (m/s), and the height of the point of contact (m).
    sums: [f64; 3],
}

impl Touch {
    fn add(&mut self, force: f64, values: [f64; 3]) {
        self.force += force;
        self.sums = std::array::from_fn(|k| self.sums[k] + force * values[k]);
    }

    fn means(self) -> Option<[f64; 3]> {
        (self.force > 0.0).then(|| self.sums.map(|sum| sum / self.force))
    }
}

/// Jumps of velocity over V at the sites from the wheel to the base, then masses (kg): grains in the contact, and loose grains in it, ahead of it and
/// behind it, up to its own width. `None` without contacts on both faces, or without grains between them. `ends` are the front and rear end of the
/// contact (m), `real` is the share of real mass in the masses.
pub fn measure(
    rolling: &Rolling,
    (bodies, state): (&Bodies, &GrainState),
    ends: [f64; 2],
    real: f64,
) -> Option<[f64; LAYER.len()]> {
    let along = rolling.direction();
    let [mut wheel, mut base] = [Touch::default(); 2];
    for slot in state.list.pressing() {
        let (a, b) = (slot.a as usize, slot.b as usize);
        if a >= bodies.free || b < bodies.free {
            continue;
        }
        let (force, values) = at_contact(bodies, state, slot);
        let on_wheel = bodies.is_wheel(b);
        let side = if on_wheel { &mut wheel } else { &mut base };
        side.add(force, values);
    }
    let ([top, face, high], [bottom, below, low]) = (wheel.means()?, base.means()?);
    let before = |x: f64| along * rolling.apart(x, state.wheel.position[0]);
    let levels = [4.0, 3.0, 2.0, 1.0].map(|fifth| {
        let height = low + 0.2 * fifth * (high - low);
        level(bodies, state, &before, height, ends)
    });
    let [Some(four), Some(three), Some(two), Some(one)] = levels else {
        return None;
    };
    let from_top = [face, top, four, three, two, one, bottom, below, 0.0];
    let scale = along / rolling.speed.abs();
    let masses = masses(bodies, state, &before, ends, real);
    Some(std::array::from_fn(|k| {
        if k < SITES {
            scale * (from_top[k] - from_top[k + 1])
        } else {
            masses[k - SITES]
        }
    }))
}

/// Normal force, velocities along x of the grain and the other body where they touch, and the height of that point.
fn at_contact(bodies: &Bodies, state: &GrainState, slot: &Slot) -> (f64, [f64; 3]) {
    let (a, b) = (slot.a as usize, slot.b as usize);
    let [_, ny] = state.positions(bodies).proximity(a, b).normal;
    let radius = bodies.radii[a];
    let [own, _, spin] = state.velocity_of(bodies, a);
    let [other, ..] = state.velocity_of(bodies, b);
    let turn = if bodies.is_wheel(b) {
        state.wheel.turn
    } else {
        0.0
    };
    let height = state.centres[a][1] - radius * ny;
    let values = [own + spin * radius * ny, other - turn * ny, height];
    (slot.pressure()[0], values)
}

/// Mean velocity along x of the grains at a height in the contact; `None` without any.
fn level(
    bodies: &Bodies,
    state: &GrainState,
    before: &dyn Fn(f64) -> f64,
    height: f64,
    [front, rear]: [f64; 2],
) -> Option<f64> {
    let (middle, half) = (0.5 * (front + rear), 0.5 * (front - rear));
    let [mut sum, mut weights] = [0.0; 2];
    for grain in grains(bodies, state) {
        let [x, y] = state.centres[grain];
        let (radius, up) = (bodies.radii[grain], height - y);
        let place = (before(x) - middle) / half;
        if up.abs() < radius && place.abs() < 1.0 {
            let [velocity, _, spin] = state.velocity_of(bodies, grain);
            let chord = (radius * radius - up * up).sqrt();
            let weight = chord * (1.0 - place * place).sqrt();
            sum += weight * (velocity - spin * up);
            weights += weight;
        }
    }
    (weights > 0.0).then(|| sum / weights)
}

/// Masses of the grains in the contact, and of the loose ones in it, ahead and behind (kg).
fn masses(
    bodies: &Bodies,
    state: &GrainState,
    before: &dyn Fn(f64) -> f64,
    [front, rear]: [f64; 2],
    real: f64,
) -> [f64; 4] {
    let mut held = vec![false; bodies.free];
    for body in holding(&state.bonds).flat_map(|(a, b)| [a, b]) {
        if let Some(held) = held.get_mut(body as usize) {
            *held = true;
        }
    }
    let width = front - rear;
    let mut masses = [0.0; 4];
    for grain in grains(bodies, state) {
        let place = before(state.centres[grain][0]);
        let mass = real * bodies.masses[grain];
        let inside = (rear..=front).contains(&place);
        if inside {
            masses[0] += mass;
        }
        if held[grain] {
            continue;
        }
        if inside {
            masses[1] += mass;
        } else if (front..=front + width).contains(&place) {
            masses[2] += mass;
        } else if (rear - width..=rear).contains(&place) {
            masses[3] += mass;
        }
    }
    masses
}

/// Speed of shear waves in the grains, of scaled mass (m/s), from above: all contacts take part in the mean strain, G = N l^2 (kn + kt)/8 for N
/// contacts an area of the length l (Bathurst and Rothenburg 1988). `None` for rigid contacts and without grains.
pub fn wave_speed(bodies: &Bodies, state: &GrainState) -> Option<f64> {
    let springs = bodies.law.springs;
    let springs = springs.map(|springs| springs.normal + springs.tangential);
    let bonded = bodies.law.cohesion.map(|law| {
        let areas = state.bonds.iter().map(|bond| bond.area);
        areas.sum::<f64>() / state.bonds.len().max(1) as f64 * (law.normal + law.tangential)
    });
    let stiffness = springs.unwrap_or(0.0) + bonded.unwrap_or(0.0);
    let count = grains(bodies, state).count() as f64;
    let sum = |of: &[f64]| grains(bodies, state).map(|grain| of[grain]).sum::<f64>();
    let mass = sum(&bodies.masses);
    let contacts = state.list.pressing().count().max(state.bonds.len()) as f64;
    let length = 2.0 * sum(&bodies.radii) / count;
    let speed = (contacts * length * length * stiffness / (8.0 * mass)).sqrt();
    (speed > 0.0).then_some(speed)
}
