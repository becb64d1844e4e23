//! Lattices under known contact forces: exact stress, to rounding.

use dem_kernel::bodies::faces::{Face, RigidWall};
use dem_kernel::bodies::geometry::Period;
use dem_kernel::contact::detect::Slot;

use super::*;

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
        at_s: None,
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
        close(cell.grains, 16.0, 16.0);
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
    close(number(8), 16.0, 16.0);
}

/// Rows of 8 touching disks in a strip that repeats, each row shifted by a radius. sigma = sum f_k n_k n_k / (sqrt(3) r t) over the
/// contacts at 0, 60 and 120 degrees: a disk has an area of 2 sqrt(3) r^2.
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
    // Five of the nine rows: the outer rows have no neighbours on one side, and their tiles reach into the next rows.
    let config = StressConfig {
        y_m: Some([1.5 * height, 6.5 * height]),
        at_s: None,
        ..cells(7.0 * R)
    };
    let map = StressMap::measure(&config, &bodies, &state, THICKNESS).expect("it is loaded");
    close(map.whole.grains, 40.0, 40.0);
    let unit = 1.0 / (3f64.sqrt() * R * THICKNESS);
    let slanted = forces[1] + forces[2];
    let expected = [
        unit * (forces[0] + 0.25 * slanted),
        unit * 0.75 * slanted,
        unit * 0.25 * 3f64.sqrt() * (forces[1] - forces[2]),
    ];
    let volume = 16.0 * R * 5.0 * height * THICKNESS;
    for (found, expected) in map.whole.stress(volume).into_iter().zip(expected) {
        close(found, expected, unit);
    }
    let [_, xy, yx, _] = map.whole.moment;
    close(xy, yx, unit * volume);
    assert_eq!(map.cells.len(), 2);
    for cell in &map.cells {
        for (found, expected) in cell.stress(map.cell_volume()).into_iter().zip(expected) {
            close(found, expected, unit);
        }
    }
}

/// All disks of a lattice (hexagonal, or square) turned by an angle that lie within 30 R of the origin, their contacts under the forces
/// of a homogeneous strain (xx, yy, xy) by springs of 1 N/m along and across them.
fn strained(hexagonal: bool, angle: f64, [xx, yy, xy]: [f64; 3]) -> (Bodies, GrainState) {
    let second = if hexagonal {
        [R, 3f64.sqrt() * R]
    } else {
        [0.0, 2.0 * R]
    };
    let (sin, cos) = angle.sin_cos();
    let mut centres = Vec::new();
    for i in -60..=60 {
        for j in -30..=30 {
            let [i, j] = [i, j].map(f64::from);
            let [x, y] = [2.0 * R * i + second[0] * j, second[1] * j];
            let centre = [cos * x - sin * y, sin * x + cos * y];
            if centre.iter().all(|x| x.abs() < 30.0 * R) {
                centres.push(centre);
            }
        }
    }
    let (bodies, mut state) = disks(centres, None);
    for (a, from) in state.centres.iter().enumerate() {
        for (b, to) in state.centres.iter().enumerate().skip(a + 1) {
            let [x, y] = [from[0] - to[0], from[1] - to[1]];
            if x.hypot(y) < 2.01 * R {
                let [u, v] = [xx * x + xy * y, xy * x + yy * y];
                let [nx, ny] = [x, y].map(|x| x / (2.0 * R));
                let force = [-(u * nx + v * ny), u * ny - v * nx];
                state.list.slots.push(slot(a, b, force));
            }
        }
    }
    (bodies, state)
}

/// sigma = -(1/A t) sum (strain . L) L over the three branches L per disk, with the area A = 2 sqrt(3) R^2 (in the square two branches, 4 R^2): the
/// springs are alike in both directions and take the whole strain of L, and sum L L is 6 R^2 (4 R^2) times the unit tensor, so that sigma is
/// -sqrt(3)/t (-1/t) times the strain.
#[test]
fn a_lattice_has_its_stress_in_any_region_and_cell_with_cut_edges() {
    let strain = [1e-3, -0.4e-3, 0.3e-3];
    for (hexagonal, modulus) in [(true, 3f64.sqrt()), (false, 1.0)] {
        let expected = strain.map(|strain| -modulus / THICKNESS * strain);
        for degrees in [0.0, 11.0, 30.0, 45.0f64] {
            let (bodies, state) = strained(hexagonal, degrees.to_radians(), strain);
            for part in 0..16 {
                let part = f64::from(part);
                let side = |k: f64| {
                    let low = -14.0 * R + (1.37 + k) * 0.5 * R * part;
                    Some([low, low + (7.0 + (0.83 - 0.4 * k) * part) * R])
                };
                let config = StressConfig {
                    x_m: side(0.0),
                    y_m: side(0.3),
                    at_s: None,
                    ..cells(7.0 * R)
                };
                let map = StressMap::measure(&config, &bodies, &state, THICKNESS);
                let map = map.expect("it is loaded");
                let results = map.results();
                let found = [results[0].1, results[1].1, results[2].1];
                let cells = map.cells.iter().map(|cell| cell.stress(map.cell_volume()));
                for found in cells.chain([found]) {
                    for (found, expected) in found.into_iter().zip(expected) {
                        close(found, expected, modulus * 1e-3 / THICKNESS);
                    }
                }
            }
        }
    }
}

/// A sample in a strip that repeats, seen in regions that cross its seam.
#[test]
fn the_parts_of_the_grains_add_up_to_the_region() {
    let place = |i: usize| {
        let [x, y] = [i % 9, i / 9].map(|k| 2.05 * R * (k as f64 + 0.5));
        let noise = |k: f64| 0.02 * R * (k * i as f64).sin();
        [x + noise(3.0) - 1.5 * R, y + noise(5.0)]
    };
    let strip = Period::between([0.0, 18.45 * R]);
    for period in [None, Some(strip)] {
        let (bodies, mut state) = disks((0..72).map(place).collect(), period);
        for i in 0..71 {
            if i % 9 != 8 {
                let force = [1.0 + (i as f64).sin(), (2.0 * i as f64).cos()];
                state.list.slots.push(slot(i, i + 1, force));
            }
        }
        let all = StressMap::measure(&cells(7.0 * R), &bodies, &state, THICKNESS);
        let all = all.expect("it is loaded").whole;
        let mut sum = [0.0; 4];
        for grain in sums_by_grain(&bodies, &state) {
            add_moment(&mut sum, 1.0, grain.moment);
        }
        for (found, expected) in all.moment.into_iter().zip(sum) {
            close(found, expected, 72.0 * R);
        }
        close(all.grains, 72.0, 72.0);
        let config = StressConfig {
            x_m: Some([1.1 * R, 15.5 * R]),
            y_m: Some([0.9 * R, 15.3 * R]),
            at_s: None,
            ..cells(7.2 * R)
        };
        let map = StressMap::measure(&config, &bodies, &state, THICKNESS);
        let map = map.expect("it is loaded");
        assert_eq!(map.cells.len(), 4);
        let mut sum = StressSums::default();
        map.cells.iter().for_each(|cell| sum.add(1.0, cell));
        for (found, expected) in sum.moment.into_iter().zip(map.whole.moment) {
            close(found, expected, 72.0 * R);
        }
        close(sum.solid, map.whole.solid, map.whole.solid);
        close(sum.grains, map.whole.grains, map.whole.grains);
    }
}

/// Friction makes the tensor of one disk asymmetric: only its symmetric part is reported.
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
fn a_cell_that_is_less_than_half_as_full_as_a_mean_grain_sees_does_not_count() {
    let cell = |solid: f64, pressure: f64| StressSums {
        moment: [pressure, 0.0, 0.0, pressure],
        solid,
        grains: 1.0,
    };
    let map = |part: f64| StressMap {
        cells: vec![cell(0.8, 10.0), cell(part, 50.0), StressSums::default()],
        columns: 3,
        side: 1.0,
        thickness: 1.0,
        ..StressMap::default()
    };
    // Half of (0.8^2 + s^2) / (0.8 + s) is 0.330 at s = 0.34 and at s = 0.32, that is 0.8 (sqrt(2) - 1) = 0.331.
    assert_eq!(map(0.34).largest_trace(), Some(100.0));
    assert_eq!(map(0.32).largest_trace(), Some(20.0));
    let empty = StressMap::default();
    assert_eq!(empty.largest_trace(), None);
}
