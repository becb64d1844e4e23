//! Periodic lines: nothing depends on the position of the seam.

use super::*;

const PERIOD: f64 = 0.012;
const KINDS: [MappingKind; 3] = [
    MappingKind::Mortar,
    MappingKind::Linear,
    MappingKind::Nearest,
];

/// Nodes at uneven distances, with no node at the seam.
fn nodes() -> Vec<[f64; 2]> {
    let position = |i: usize| 1e-3 * (i as f64 + 0.2 * (i as f64 * 1.7).sin());
    (0..12).map(|i| [position(i) - 0.004, 1e-4]).collect()
}

/// Points around the whole period, some of them in other periods.
fn points(count: usize) -> Vec<[f64; 2]> {
    let points = uneven_points(count, -0.004, -0.004 + PERIOD);
    let turns = |i: usize| PERIOD * ((i * 5 % 7) as f64 - 3.0);
    points
        .iter()
        .enumerate()
        .map(|(i, [x, y])| [x + turns(i), *y])
        .collect()
}

fn repeating(kind: MappingKind, nodes: &[[f64; 2]], points: &[[f64; 2]]) -> Mapping {
    Mapping::new(kind, nodes, points, Some(PERIOD)).expect("it is regular")
}

/// N, points x nodes.
fn dense(mapping: &Mapping) -> DMatrix<f64> {
    let mut matrix = DMatrix::zeros(mapping.rows.len(), mapping.nodes);
    for (i, row) in mapping.rows.iter().enumerate() {
        for (node, weight) in row {
            assert_eq!(matrix[(i, *node)], 0.0, "a row lists a node twice");
            matrix[(i, *node)] = *weight;
        }
    }
    matrix
}

fn moved(positions: &[[f64; 2]], by: impl Fn(usize) -> f64) -> Vec<[f64; 2]> {
    let positions = positions.iter().enumerate();
    positions.map(|(i, [x, y])| [x + by(i), *y]).collect()
}

#[test]
fn constant_fields_and_forces_are_exact() {
    for (kind, count) in KINDS.into_iter().flat_map(|kind| [(kind, 5), (kind, 31)]) {
        let (nodes, points) = (nodes(), points(count));
        let mapping = repeating(kind, &nodes, &points);
        for one in mapping.motion(&vec![3.0; 2 * nodes.len()]) {
            assert!((one - 3.0).abs() < 4e-15, "{kind:?}: {one}");
        }
        let force = both(|i| 1.0 + (i as f64).sin(), count);
        let sum = |f: &[f64]| f.iter().step_by(2).sum::<f64>();
        let carried = sum(&mapping.force(&force));
        assert!((carried / sum(&force) - 1.0).abs() < 1e-14, "{kind:?}");
        assert_eq!(
            mapping.active().len() == nodes.len(),
            count == 31 || kind == MappingKind::Mortar
        );
    }
}

/// The middle of three copies of the line is far from its ends.
#[test]
fn rows_equal_the_middle_of_three_copies() {
    for (kind, count) in KINDS.into_iter().flat_map(|kind| [(kind, 5), (kind, 31)]) {
        let nodes = nodes();
        let points = uneven_points(count, -0.004, -0.004 + PERIOD);
        let copies = |positions: &[[f64; 2]]| -> Vec<[f64; 2]> {
            let turns = [-PERIOD, 0.0, PERIOD].into_iter();
            turns.flat_map(|by| moved(positions, |_| by)).collect()
        };
        let plain = Mapping::new(kind, &with_ends(copies(&nodes)), &copies(&points), None);
        let plain = dense(&plain.expect("it is regular"));
        let folded = DMatrix::from_fn(count, nodes.len(), |i, node| {
            (0..3)
                .map(|copy| plain[(count + i, copy * nodes.len() + node)])
                .sum::<f64>()
        });
        let apart = (dense(&repeating(kind, &nodes, &points)) - folded).amax();
        assert!(apart < 1e-11, "{kind:?}, {count} points: {apart:e}");
    }
}

/// The same line with one more node on either side, so that all points lie between its ends. The new nodes come last.
fn with_ends(mut nodes: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
    let (first, last) = (nodes[0], nodes[nodes.len() - 1]);
    nodes.push([first[0] - PERIOD, first[1]]);
    nodes.push([last[0] + PERIOD, last[1]]);
    nodes
}

#[test]
fn rows_do_not_depend_on_periods_numbers_and_origins() {
    for kind in KINDS {
        let (nodes, points) = (nodes(), points(31));
        let reference = dense(&repeating(kind, &nodes, &points));
        let same = |nodes: &[[f64; 2]], points: &[[f64; 2]], what: &str| {
            let apart = (dense(&repeating(kind, nodes, points)) - &reference).amax();
            assert!(apart < 1e-11, "{kind:?}, {what}: {apart:e}");
        };
        let turned = moved(&points, |i| PERIOD * (i as f64 - 11.0));
        same(&nodes, &turned, "points in other periods");
        for shift in [0.3e-3, -7.7e-3, 50.0 * PERIOD] {
            let (nodes, points) = (moved(&nodes, |_| shift), moved(&points, |_| shift));
            same(&nodes, &points, "another origin");
        }
        // Another node is the first of the period: by its position, then by its number.
        let wrapped = moved(&nodes, |i| if i < 5 { PERIOD } else { 0.0 });
        same(&wrapped, &points, "another seam");
        let mut rolled = nodes.clone();
        rolled.rotate_left(5);
        let rolled = dense(&repeating(kind, &rolled, &points));
        let back = DMatrix::from_fn(31, 12, |i, node| rolled[(i, (node + 7) % 12)]);
        assert!(
            (back - &reference).amax() < 1e-11,
            "{kind:?}, other numbers"
        );
    }
}

/// With equal distances on both sides all nodes are alike, for any distance between the first node and the first point.
#[test]
fn a_uniform_pressure_on_regular_rows_stays_uniform() {
    let nodes: Vec<[f64; 2]> = (0..10).map(|i| [4e-4 * f64::from(i), 0.0]).collect();
    for (per_node, shift) in [(1, 0.0), (1, 1.3e-4), (1, 3.9e-3), (3, 1.3e-4)] {
        let count = 10 * per_node;
        let position = |i: i32| 4e-3 * f64::from(i) / f64::from(count) + shift;
        let points: Vec<[f64; 2]> = (0..count).map(|i| [position(i), 0.0]).collect();
        let mapping = Mapping::new(MappingKind::Mortar, &nodes, &points, Some(4e-3));
        let nodal = mapping
            .expect("regular")
            .force(&vec![1.0; 2 * points.len()]);
        for force in nodal {
            assert!(
                (force / f64::from(per_node) - 1.0).abs() < 1e-12,
                "{per_node}, {shift}: {force}"
            );
        }
    }
}

/// The point's images are its neighbours, so that its segment is the whole period: each node gets its own share.
#[test]
fn a_single_point_hangs_on_the_whole_line() {
    let nodes = [[0.0, 0.0], [1.0, 0.0], [3.0, 0.0]];
    for x in [0.0, 0.7, 4.9, -6.1] {
        let mapping = Mapping::new(MappingKind::Mortar, &nodes, &[[x, 0.0]], Some(5.0));
        let row = dense(&mapping.expect("regular"));
        let exact = DMatrix::from_row_slice(1, 3, &[0.3, 0.3, 0.4]);
        assert!((row - exact).amax() < 1e-14, "{x}");
    }
}

#[test]
fn a_line_longer_than_its_period_or_with_a_repeated_position_is_refused() {
    let relate = |nodes: &[[f64; 2]], points: &[[f64; 2]]| {
        Mapping::new(MappingKind::Mortar, nodes, points, Some(2.0)).expect_err("it is refused")
    };
    let (line, seam) = (
        [[0.0, 0.0], [1.0, 0.0]],
        [[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]],
    );
    let twice = |what, first, second| {
        move |error: MappingError| match error {
            MappingError::Repeated {
                what: found,
                first: a,
                second: b,
                ..
            } => {
                assert_eq!((found, a, b), (what, first, second));
            }
            other => panic!("{other}"),
        }
    };
    twice("surface nodes", 0, 2)(relate(&seam, &[[0.5, 0.0]]));
    twice("glued points", 0, 2)(relate(&line, &[[0.5, 0.0], [0.7, 0.0], [-3.5, 0.1]]));
    twice("glued points", 0, 1)(relate(&line, &[[1e-13, 0.0], [2.0 - 1e-13, 0.0]]));
    let longer = relate(&[[0.0, 0.0], [1.0, 0.0], [2.5, 0.0]], &[[0.5, 0.0]]);
    assert!(matches!(longer, MappingError::Longer { .. }), "{longer}");
    assert!(longer.to_string().contains("2.5"), "{longer}");
    let nowhere = relate(&line, &[[f64::NAN, 0.0]]);
    assert!(
        matches!(nowhere, MappingError::Beyond { point: 0, .. }),
        "{nowhere}"
    );
}
