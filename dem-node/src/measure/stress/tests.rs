//! Lattices under known contact forces: exact stress, to rounding.

use super::*;
use crate::bodies::faces::{Face, RigidWall};
use crate::bodies::geometry::Period;
use crate::contact::detect::Slot;

const R: f64 = 0.5e-3;
const THICKNESS: f64 = 2e-3;

fn slot(a: usize, b: usize, force: [f64; 2]) -> Slot {
    Slot {
        a: a as u32,
        b: b as u32,
        force,
        ..Slot::default()
    }
}

fn disks(centres: Vec<[f64; 2]>, period: Option<Period>) -> (Bodies, GrainState) {
    let bodies = Bodies {
        free: centres.len(),
        radii: vec![R; centres.len()],
        period,
        ..Bodies::default()
    };
    let state = GrainState {
        centres,
        ..GrainState::default()
    };
    (bodies, state)
}

fn cells(cell_m: f64) -> StressConfig {
    StressConfig {
        cell_m,
        x_m: None,
        y_m: None,
    }
}

#[track_caller]
fn close(found: f64, expected: f64, scale: f64) {
    assert!(
        (found - expected).abs() <= 1e-12 * scale,
        "{found:e} instead of {expected:e}"
    );
}

/// A wall with its face at a distance from the origin.
fn wall(normal: [f64; 2], offset: f64) -> RigidWall {
    RigidWall {
        face: Face::HalfPlane {
            point: normal.map(|n| n * offset),
            normal,
        },
        velocity: [0.0; 2],
    }
}

/// 8 x 8 disks in rows and columns between four walls, all contacts of a direction under the same force.
fn square_lattice(across: f64, up: f64) -> (Bodies, GrainState) {
    let place = |i: usize| [R + 2.0 * R * (i % 8) as f64, R + 2.0 * R * (i / 8) as f64];
    let (mut bodies, mut state) = disks((0..64).map(place).collect(), None);
    let far = -16.0 * R;
    bodies.walls = vec![
        wall([1.0, 0.0], 0.0),
        wall([-1.0, 0.0], far),
        wall([0.0, 1.0], 0.0),
        wall([0.0, -1.0], far),
    ];
    for i in 0..64 {
        let ends = [(i % 8 == 7, i + 1, 1), (i / 8 == 7, i + 8, 3)];
        for ((last, next, face), force) in ends.into_iter().zip([across, up]) {
            let other = if last { 64 + face } else { next };
            state.list.slots.push(slot(i, other, [force, 0.0]));
        }
        if i % 8 == 0 {
            state.list.slots.push(slot(i, 64, [across, 0.0]));
        }
        if i / 8 == 0 {
            state.list.slots.push(slot(i, 66, [up, 0.0]));
        }
    }
    (bodies, state)
}

#[test]
fn a_square_lattice_has_the_force_over_a_diameter_as_stress_in_all_and_in_each_cell() {
    // Pressed up and pulled across: pressures are positive, tensions negative.
    let (across, up) = (-3.0, 7.0);
    let (bodies, state) = square_lattice(across, up);
    let map = StressMap::measure(&cells(8.0 * R), &bodies, &state, THICKNESS);
    let map = map.expect("it is loaded");
    let expected = [across, up].map(|force| force / (2.0 * R * THICKNESS));
    let results = map.results();
    let result = |name: &str| results.iter().find(|r| r.0 == name).expect("it is there").1;
    close(result("stress_xx_pa"), expected[0], expected[1]);
    close(result("stress_yy_pa"), expected[1], expected[1]);
    close(result("stress_xy_pa"), 0.0, expected[1]);
    let trace = expected[0] + expected[1];
    close(result("dem_p_max_tr3_pa"), trace / 3.0, trace);
    close(result("dem_p_max_mean_pa"), trace / 2.0, trace);
    assert_eq!(map.cells.len(), 4);
    let volume = map.cell_volume();
    for cell in &map.cells {
        assert_eq!(cell.grains, 16);
        let [xx, yy, _] = cell.stress(volume);
        close(xx, expected[0], expected[1]);
        close(yy, expected[1], expected[1]);
    }
    let csv = map.csv();
    let last: Vec<&str> = csv.lines().last().expect("four cells").split(',').collect();
    let number = |i: usize| last[i].parse::<f64>().expect("a number");
    for (column, value) in [12.0 * R, 12.0 * R, expected[0], expected[1]]
        .into_iter()
        .enumerate()
    {
        close(number(column), value, value.abs());
    }
    close(number(5), trace / 3.0, trace);
    close(number(6), trace / 2.0, trace);
    close(number(7), std::f64::consts::FRAC_PI_4, 1.0);
    assert_eq!(last[8], "16");
}

/// Rows of 8 touching disks in a strip that repeats, each row shifted by a radius. sigma = sum f_k n_k n_k / (sqrt(3) r t) over the
/// contacts at 0, 60 and 120 degrees: a disk has 2 sqrt(3) r^2 for itself.
#[test]
fn a_triangular_lattice_has_the_stress_of_its_three_forces() {
    let forces = [5.0, 2.0, 3.0];
    let height = 3f64.sqrt() * R;
    let place = |i: usize| {
        let (row, column) = ((i / 8) as f64, (i % 8) as f64);
        [R * (2.0 * column + row % 2.0), height * row]
    };
    let strip = Period::between([0.0, 16.0 * R]);
    let (bodies, mut state) = disks((0..72).map(place).collect(), Some(strip));
    for i in 0..72 {
        let (row, column) = (i / 8, i % 8);
        let beside = 8 * row + (column + 1) % 8;
        let pair = [i.min(beside), i.max(beside)];
        state
            .list
            .slots
            .push(slot(pair[0], pair[1], [forces[0], 0.0]));
        if row == 8 {
            continue;
        }
        let shift = row % 2;
        let right = 8 * (row + 1) + (column + shift) % 8;
        let left = 8 * (row + 1) + (column + 7 + shift) % 8;
        state.list.slots.push(slot(i, right, [forces[1], 0.0]));
        state.list.slots.push(slot(i, left, [forces[2], 0.0]));
    }
    // Seven of the nine rows: the outer ones have no neighbours on one side.
    let config = StressConfig {
        y_m: Some([0.5 * height, 7.5 * height]),
        ..cells(7.0 * R)
    };
    let map = StressMap::measure(&config, &bodies, &state, THICKNESS).expect("it is loaded");
    assert_eq!(map.whole.grains, 56);
    let unit = 1.0 / (3f64.sqrt() * R * THICKNESS);
    let slanted = forces[1] + forces[2];
    let expected = [
        unit * (forces[0] + 0.25 * slanted),
        unit * 0.75 * slanted,
        unit * 0.25 * 3f64.sqrt() * (forces[1] - forces[2]),
    ];
    let volume = 16.0 * R * 7.0 * height * THICKNESS;
    for (found, expected) in map.whole.stress(volume).into_iter().zip(expected) {
        close(found, expected, unit);
    }
    let [_, xy, yx, _] = map.whole.moment;
    close(xy, yx, unit * volume);
    // A cell has the stress of its grains, whatever their number.
    assert_eq!(map.cells.len(), 2);
    for cell in &map.cells {
        let own = f64::from(cell.grains) * 2.0 * R * height * THICKNESS;
        for (found, expected) in cell.stress(own).into_iter().zip(expected) {
            close(found, expected, unit);
        }
    }
}

/// Friction makes the tensor of one disk asymmetric: only its symmetric part is told.
#[test]
fn the_shear_of_a_disk_that_is_turned_is_the_symmetric_part() {
    let centres = vec![[0.0, 0.0], [2.0 * R, 0.0]];
    let (bodies, mut state) = disks(centres, None);
    state.list.slots.push(slot(0, 1, [0.0, 4.0]));
    let sums = sums_by_grain(&bodies, &state);
    // n = (-1, 0), so t = (0, -1): 4 N down on the left disk at its right end.
    assert_eq!(sums[0].moment, [0.0, 0.0, 4.0 * R, 0.0]);
    assert_eq!(sums[0].stress(1.0), [0.0, 0.0, 2.0 * R]);
}

#[test]
fn a_cell_that_is_less_than_half_as_full_as_the_mean_does_not_count() {
    let cell = |solid: f64, pressure: f64| StressSums {
        moment: [pressure, 0.0, 0.0, pressure],
        solid,
        grains: 1,
    };
    let map = |part: f64| StressMap {
        cells: vec![cell(0.8, 10.0), cell(part, 50.0), StressSums::default()],
        columns: 3,
        side: 1.0,
        thickness: 1.0,
        ..StressMap::default()
    };
    // Half of the mean of 0.8 and 0.28 is 0.27, of 0.8 and 0.26 it is 0.265.
    assert_eq!(map(0.28).largest_trace(), Some(100.0));
    assert_eq!(map(0.26).largest_trace(), Some(20.0));
    let empty = StressMap::default();
    assert_eq!(empty.largest_trace(), None);
}
