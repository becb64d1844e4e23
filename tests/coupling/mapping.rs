//! The mapping between surface nodes and glued points, remeasured (case 7 of the coupling page).
//!
//! Problem: a line of 10 to 10 000 nodes, flat or with a crown of 0.3 m, and two thirds as many points at uneven places.
//!
//! Exact answer: N^T is the transpose of N, so the power of the forces is the same on both sides; rows sum to one, so the
//! resultants are equal too; a mapping that reproduces linear fields keeps the moment. Rounding of sums of 10 000 terms is
//! below 1e-12. Ripple of a uniform pressure, by independent prototypes on 121 nodes: mortar 0.05, linear 0.30, nearest 0.76.

use std::ops::Range;

use harness::mapped_line::{LENGTH_M, MappedLine, components};
use nalgebra::DVector;
use scheme::keys::MappingKind;
use scheme::mapping::{Mapping, MappingError};

/// Errors of one kind of mapping on one line.
#[derive(Debug)]
struct MappingRow {
    /// `mortar`, `linear` or `nearest`.
    mapping: MappingKind,
    /// |sum of nodal forces - sum of point forces| / sum of |point forces|.
    force_rel: f64,
    /// Error of the moment of forces across the line about its middle, over the sum of its parts.
    moment_rel: f64,
    /// |F.(N v) - (N^T F).v| / sum of |F.(N v)|: the energy that the mapping creates or loses.
    power_rel: f64,
    /// Spread of the traction on the inner nodes under a uniform pressure, over its mean.
    ripple: f64,
    /// Nodes between the first and the last point that get no force.
    empty_nodes: usize,
}

fn row(kind: MappingKind, shape: &str, count: usize) -> Result<MappingRow, MappingError> {
    let line = MappedLine::new(kind, shape, count)?;
    let (nodes, points, mapping) = (&line.nodes, &line.points, &line.mapping);
    let (force, motion) = (line.force(), line.motion());
    let (nodal, moved) = (mapping.force(&force), mapping.motion(&motion));
    let pressed = mapping.force(&components(points.len(), |i| segment(&line.places, i)));
    let inner = inside(nodes, &line.places);
    let pressed_inside = DVector::from_iterator(inner.len(), inner.map(|i| pressed[2 * i + 1]));
    Ok(MappingRow {
        mapping: kind,
        force_rel: apart(y(&nodal), y(&force)),
        moment_rel: apart(
            y(&nodal).zip(nodes).map(|(f, place)| f * place[0]),
            y(&force).zip(points).map(|(f, place)| f * place[0]),
        ),
        power_rel: apart(
            nodal.iter().zip(&motion).map(|(f, v)| f * v),
            force.iter().zip(&moved).map(|(f, v)| f * v),
        ),
        ripple: pressed_inside.variance().sqrt() / pressed_inside.mean(),
        empty_nodes: pressed_inside.iter().filter(|p| **p == 0.0).count(),
    })
}

/// Length that a point stands for: halfway to its neighbours.
fn segment(places: &[f64], i: usize) -> f64 {
    let left = i.checked_sub(1).map(|i| places[i]);
    let right = places.get(i + 1).copied();
    let ends = [-LENGTH_M - places[0], LENGTH_M - places[i]];
    0.5 * (right.unwrap_or(ends[1]) - left.unwrap_or(ends[0]))
}

fn y(vector: &[f64]) -> impl Iterator<Item = f64> + '_ {
    vector.iter().skip(1).step_by(2).copied()
}

/// |sum a - sum b| / sum |b|.
fn apart(a: impl Iterator<Item = f64>, b: impl Iterator<Item = f64>) -> f64 {
    let b: Vec<f64> = b.collect();
    let size: f64 = b.iter().map(|value| value.abs()).sum();
    (a.sum::<f64>() - b.iter().sum::<f64>()).abs() / size
}

/// Nodes a tenth of the line away from its ends.
fn inside(nodes: &[[f64; 2]], places: &[f64]) -> Range<usize> {
    let margin = 0.1 * LENGTH_M;
    let (low, high) = (places[0] + margin, places[places.len() - 1] - margin);
    let below = |limit: f64| nodes.iter().filter(|node| node[0] < limit).count();
    below(low)..below(high)
}

#[test]
fn forces_moments_and_power_are_kept_from_ten_to_ten_thousand_nodes() {
    for line in ["flat", "curved"] {
        for nodes in [10, 100, 1_000, 10_000] {
            let [mortar, linear, nearest] = [
                MappingKind::Mortar,
                MappingKind::Linear,
                MappingKind::Nearest,
            ]
            .map(|kind| row(kind, line, nodes).expect("regular input"));
            for row in [&mortar, &linear, &nearest] {
                println!("{line}, {nodes} nodes: {row:?}");
                keeps(row);
            }
            assert!(nearest.moment_rel > 1e-6, "{nearest:?}");
            if nodes >= 100 {
                assert!(mortar.ripple < 0.5 * linear.ripple, "{mortar:?} {linear:?}");
                assert!(linear.ripple < nearest.ripple, "{linear:?} {nearest:?}");
                assert_eq!(mortar.empty_nodes, 0);
                assert!(nearest.empty_nodes > 0);
            }
        }
    }
}

fn keeps(row: &MappingRow) {
    assert!(row.force_rel <= 1e-12, "{row:?}");
    assert!(row.power_rel <= 1e-12, "{row:?}");
    if row.mapping != MappingKind::Nearest {
        assert!(row.moment_rel <= 1e-12, "{row:?}");
    }
}

#[test]
fn degenerate_input_is_refused_by_the_name_of_the_point() {
    let line: Vec<[f64; 2]> = (0..10_000).map(|i| [1e-6 * i as f64, 0.0]).collect();
    for kind in [
        MappingKind::Mortar,
        MappingKind::Linear,
        MappingKind::Nearest,
    ] {
        let single = Mapping::new(kind, &line, &[[5e-3, 0.0]], None).expect("one point is enough");
        let field: Vec<f64> = line.iter().flat_map(|node| [node[0], 1.0]).collect();
        assert!((single.motion(&field)[0] - 5e-3).abs() <= 0.5e-6);
        let repeated = Mapping::new(kind, &line, &[[1e-3, 0.0], [2e-3, 0.0], [1e-3, 1e-5]], None);
        let error = repeated.expect_err("points 0 and 2 share a place");
        assert!(error.to_string().contains("points 0 and 2"), "{error}");
        let beyond = Mapping::new(kind, &line, &[[1e-3, 0.0], [2e-2, 0.0]], None);
        let error = beyond.expect_err("point 1 is beyond the end");
        assert!(error.to_string().contains("point 1"), "{error}");
        let mut doubled = line.clone();
        doubled[77] = doubled[76];
        let error =
            Mapping::new(kind, &doubled, &[[1e-3, 0.0]], None).expect_err("nodes share a place");
        assert!(error.to_string().contains("76 and 77"), "{error}");
        assert_eq!(
            Mapping::new(kind, &line, &[], None),
            Err(MappingError::Empty)
        );
        let one =
            Mapping::new(kind, &line[..1], &[[0.0, 0.0]], None).expect("one node carries all");
        assert_eq!(one.motion(&[3.0, 4.0]), vec![3.0, 4.0]);
    }
}
