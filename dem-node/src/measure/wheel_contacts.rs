//! The contacts that carry the wheel.

use std::fmt::Write;

use dem_kernel::bodies::Bodies;
use dem_kernel::step::state::GrainState;

use crate::measure::loads;

/// Part of the wheel's normal force whose contacts are counted: any number of contacts may share the rest and bear next to nothing.
const SHARE: f64 = 0.9;

/// Number of contacts that press on the wheel, and the fewest that carry 0.9 of its normal force; `None` without contacts. On a face of disks the
/// vertical components count: a grain squeezed between two disks carries no more than it lifts.
pub fn count(bodies: &Bodies, state: &GrainState) -> Option<[usize; 2]> {
    let positions = state.positions(bodies);
    let pressing = state.list.pressing();
    let on_wheel = pressing.filter(|slot| bodies.is_wheel(slot.b as usize));
    let lifts = on_wheel.map(|slot| {
        let at = positions.proximity(slot.a as usize, slot.b as usize);
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

/// Width of a cell of the traction below the wheel, in mean radii of the grains: a few grains press on each.
const CELL: f64 = 4.0;

/// The traction of the wheel on the grains, cell by cell from left to right, as CSV: x_m, pressure_pa, shear_pa (positive where the
/// wheel drags them towards +x), status (open, closed). The outer cells lie beyond the grains. `None` without grains.
pub fn traction_csv(bodies: &Bodies, state: &GrainState, thickness_m: f64) -> Option<String> {
    let radii = || loads::grains(bodies, state).map(|disk| bodies.radii[disk]);
    let width = CELL * radii().sum::<f64>() / radii().count() as f64;
    let [left, right] = loads::ends(bodies, state, 0, loads::grains(bodies, state));
    if !(width > 0.0 && left < right) {
        return None;
    }
    let mut forces = vec![[0.0; 2]; ((right - left) / width).ceil() as usize + 2];
    let positions = state.positions(bodies);
    let pressing = state.list.pressing();
    for slot in pressing.filter(|slot| bodies.is_wheel(slot.b as usize)) {
        let (a, [f_n, f_t]) = (slot.a as usize, slot.force);
        let [nx, ny] = positions.proximity(a, slot.b as usize).normal;
        let x = state.centres[a][0] - bodies.radii[a] * nx;
        let cell = ((x - left) / width + 1.0).clamp(0.0, forces.len() as f64 - 1.0);
        let force = &mut forces[cell as usize];
        *force = [
            force[0] - f_n * ny - f_t * nx,
            force[1] + f_n * nx - f_t * ny,
        ];
    }
    let mut text = String::from("x_m,pressure_pa,shear_pa,status\n");
    for (cell, force) in forces.iter().enumerate() {
        let x = left + (cell as f64 - 0.5) * width;
        let [pressure, shear] = force.map(|f| f / (width * thickness_m));
        let status = if *force == [0.0; 2] { "open" } else { "closed" };
        let _ = writeln!(text, "{x:e},{pressure:e},{shear:e},{status}");
    }
    Some(text)
}

#[cfg(test)]
mod tests {
    use super::*;
    use dem_kernel::contact::detect::Slot;

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

    /// Four grains 2 apart from x = 0 on: cells of 4 begin at x = -1, with one more at either end.
    #[test]
    fn the_traction_below_the_wheel_has_its_whole_force() {
        let bodies = Bodies {
            free: 4,
            radii: vec![1.0; 4],
            wheel_mass: Some(1.0),
            ..Bodies::default()
        };
        let mut state = GrainState {
            centres: (0..4).map(|k| [2.0 * f64::from(k), -1.0]).collect(),
            ..GrainState::default()
        };
        let wheel = bodies.wheel().expect("it has a mass");
        state.list.slots = pressing((0..4).map(|grain| (grain, wheel, 1.0 + grain as f64)));
        state.list.slots[0].force[1] = 0.5;
        let text = traction_csv(&bodies, &state, 0.5).expect("there are grains");
        let rows: Vec<&str> = text.lines().skip(1).collect();
        // 1 + 2 N and 3 + 4 N on 4 x 0.5 m2; the tangent of a contact below the wheel points towards +x.
        let expected = [
            "-3e0,0e0,0e0,open",
            "1e0,1.5e0,2.5e-1,closed",
            "5e0,3.5e0,0e0,closed",
            "9e0,0e0,0e0,open",
        ];
        assert_eq!(rows, expected);
    }

    /// A grain between two disks of the face, which press with 10 N each and lift sqrt(5)/3 times 10 N, and a grain right below, which bears 2 N: the
    /// two lift 0.88 of 16.9 N, and are 0.91 of the sum of all forces. Contacts elsewhere do not count.
    #[test]
    fn the_lift_of_a_squeezed_grain_counts_and_not_the_squeeze() {
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
