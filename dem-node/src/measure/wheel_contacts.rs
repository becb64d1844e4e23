//! The contacts that carry the wheel.

use crate::bodies::Bodies;
use crate::bodies::positions::proximity;
use crate::step::state::GrainState;

/// Part of the wheel's normal force whose contacts are counted: the rest may be spread over ever so many that bear next to nothing.
const SHARE: f64 = 0.9;

/// Number of contacts that press on the wheel, and the fewest that carry 0.9 of its normal force; `None` where none does. Of a
/// face of disks the vertical parts count: a grain that two of them squeeze carries no more than it lifts.
pub fn count(bodies: &Bodies, state: &GrainState) -> Option<[usize; 2]> {
    let positions = state.positions(bodies);
    let pressing = state.list.pressing();
    let on_wheel = pressing.filter(|slot| bodies.is_wheel(slot.b as usize));
    let lifts = on_wheel.map(|slot| {
        let at = proximity(bodies, &positions, slot.a as usize, slot.b as usize);
        -at.normal[1] * slot.force[0]
    });
    let mut lifts: Vec<f64> = lifts.collect();
    lifts.sort_by(|a, b| b.total_cmp(a));
    let wanted = SHARE * lifts.iter().sum::<f64>();
    let mut carried = 0.0;
    let needed = lifts.iter().position(|lift| {
        carried += lift;
        carried >= wanted
    });
    needed.map(|last| [lifts.len(), last + 1])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::detect::Slot;

    fn pressing(pairs: impl Iterator<Item = (usize, usize, f64)>) -> Vec<Slot> {
        let slots = pairs.map(|(a, b, force)| Slot {
            a: a as u32,
            b: b as u32,
            force: [force, 0.0],
            ..Slot::default()
        });
        slots.collect()
    }

    /// Grains with their tops at y = 0, on each of which a flat wheel presses with one of these forces.
    fn counted(forces: &[f64]) -> Option<[usize; 2]> {
        let bodies = Bodies {
            free: forces.len(),
            radii: vec![1.0; forces.len()],
            wheel_mass: Some(1.0),
            ..Bodies::default()
        };
        let mut state = GrainState {
            centres: vec![[0.0, -1.0]; forces.len()],
            ..GrainState::default()
        };
        let wheel = bodies.wheel().expect("it has a mass");
        let forces = forces.iter().enumerate();
        state.list.slots = pressing(forces.map(|(grain, force)| (grain, wheel, *force)));
        count(&bodies, &state)
    }

    #[test]
    fn the_strongest_contacts_are_counted_until_they_carry_nine_tenths() {
        assert_eq!(counted(&[1.0; 20]), Some([20, 18]));
        assert_eq!(counted(&[1.0, 89.0, 2.0, 8.0]), Some([4, 2]));
        assert_eq!(counted(&[1.0, 91.0, 0.0, 8.0, -3.0]), Some([3, 1]));
        assert_eq!(counted(&[0.0, 0.0]), None);
    }

    /// A grain between two disks of the face, which press with 10 N each and lift sqrt(5)/3 of it, and one right below, which bears
    /// 2 N: of 16.9 N the two lift 0.88, of the sum of all forces they are 0.91. What presses elsewhere is no matter.
    #[test]
    fn what_a_squeezed_grain_lifts_counts_and_not_what_squeezes_it() {
        let bodies = Bodies {
            free: 2,
            radii: vec![1.0, 1.0, 2.0, 2.0],
            wheel_mass: Some(1.0),
            face: vec![[-2.0, 2.0], [2.0, 2.0]],
            ..Bodies::default()
        };
        let mut state = GrainState {
            centres: vec![
                [0.0, 2.0 - 5f64.sqrt()],
                [2.0, -1.0],
                [-2.0, 2.0],
                [2.0, 2.0],
            ],
            ..GrainState::default()
        };
        let pairs = [(0, 1, 1e3), (0, 2, 10.0), (0, 3, 10.0), (1, 3, 2.0)];
        state.list.slots = pressing(pairs.into_iter());
        assert_eq!(count(&bodies, &state), Some([3, 3]));
        state.list.slots[3].force[0] = 1.6;
        assert_eq!(count(&bodies, &state), Some([3, 2]));
    }
}
