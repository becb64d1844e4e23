mod repeating;

use super::*;

fn uneven_points(count: usize, low: f64, high: f64) -> Vec<[f64; 2]> {
    (0..count)
        .map(|i| {
            let t = (i as f64 + 0.3 + 0.4 * ((i * 7 % 5) as f64 / 5.0)) / count as f64;
            [low + (high - low) * t, 0.01]
        })
        .collect()
}

fn crown(x: f64) -> [f64; 2] {
    [x, (0.09 - x * x).sqrt() - 0.3]
}

fn both(values: impl Fn(usize) -> f64, count: usize) -> Vec<f64> {
    (0..count)
        .flat_map(|i| [values(i), -2.0 * values(i)])
        .collect()
}

#[test]
fn linear_fields_are_reproduced_on_flat_and_curved_lines() {
    let flat: Vec<[f64; 2]> = (0..41).map(|i| [-0.01 + 5e-4 * i as f64, 0.0]).collect();
    let curved: Vec<[f64; 2]> = (0..41).map(|i| crown(-0.01 + 5e-4 * i as f64)).collect();
    let points = uneven_points(97, -0.008, 0.008);
    for nodes in [flat, curved] {
        let mapping =
            Mapping::new(MappingKind::Mortar, &nodes, &points, None).expect("regular input");
        let field = both(|i| 3.0 + 700.0 * nodes[i][0], nodes.len());
        let mapped = mapping.motion(&field);
        for (i, point) in points.iter().enumerate() {
            let exact = 3.0 + 700.0 * point[0];
            assert!(
                (mapped[2 * i] - exact).abs() < 2e-13 * 10.0,
                "{} {exact}",
                mapped[2 * i]
            );
            assert!((mapped[2 * i + 1] + 2.0 * exact).abs() < 4e-13 * 10.0);
        }
    }
}

/// From points of temperature T through h (J/K): each node takes N h (T - T_i), and the points lose no more than the nodes get.
#[test]
fn each_node_takes_heat_by_its_own_temperature() {
    let nodes: Vec<[f64; 2]> = (0..41).map(|i| [-0.01 + 5e-4 * i as f64, 0.0]).collect();
    let points = uneven_points(97, -0.008, 0.008);
    let mapping = Mapping::new(MappingKind::Mortar, &nodes, &points, None).expect("regular input");
    let nodal: Vec<f64> = (0..41).map(|i| 300.0 + 50.0 * (i as f64).sin()).collect();
    let h: Vec<f64> = (0..97).map(|i| 1.0 + (i as f64).cos()).collect();
    let hot: Vec<f64> = (0..97).map(|i| 350.0 + 9.0 * (i as f64).sin()).collect();
    let of = |from: &[f64], body: &[f64]| -> Vec<f64> {
        let each = h.iter().zip(from).zip(body);
        each.map(|((h, from), body)| h * (from - body)).collect()
    };
    let given = of(&hot, &mapping.means(&nodal));
    let taken = mapping.spread(&given, &h, &nodal);
    for (node, taken) in taken.iter().enumerate() {
        let mut unit = vec![0.0; 41];
        unit[node] = 1.0;
        let parts = mapping.means(&unit).into_iter();
        let parts = parts.zip(of(&hot, &[nodal[node]; 97])).map(|(n, q)| n * q);
        assert!((parts.sum::<f64>() - taken).abs() < 1e-10, "{node}");
    }
    let sums = [&given, &taken].map(|all| all.iter().sum::<f64>());
    assert!((sums[0] / sums[1] - 1.0).abs() < 1e-12, "{sums:?}");
}

#[test]
fn force_moment_and_power_are_conserved() {
    let nodes: Vec<[f64; 2]> = (0..41).map(|i| [-0.01 + 5e-4 * i as f64, 0.0]).collect();
    let points = uneven_points(97, -0.008, 0.008);
    let mapping = Mapping::new(MappingKind::Mortar, &nodes, &points, None).expect("regular input");
    let force = both(|i| 1.0 + (i as f64).sin(), points.len());
    let nodal = mapping.force(&force);
    let sum = |f: &[f64], c: usize| f.iter().skip(c).step_by(2).sum::<f64>();
    let total = sum(&force, 1);
    assert!((sum(&nodal, 1) - total).abs() < 1e-12 * total.abs());
    let moment = |f: &[f64], x: &[[f64; 2]]| {
        x.iter()
            .enumerate()
            .map(|(i, p)| p[0] * f[2 * i + 1])
            .sum::<f64>()
    };
    assert!((moment(&nodal, &nodes) - moment(&force, &points)).abs() < 1e-14 * total.abs());
    let motion = both(|i| (0.3 * i as f64).cos(), nodes.len());
    let power: f64 = mapping
        .motion(&motion)
        .iter()
        .zip(&force)
        .map(|(v, f)| v * f)
        .sum();
    let nodal_power: f64 = motion.iter().zip(&nodal).map(|(v, f)| v * f).sum();
    assert!((power - nodal_power).abs() < 1e-12 * power.abs());
}

#[test]
fn every_kind_conserves_force_and_power() {
    let nodes: Vec<[f64; 2]> = (0..41).map(|i| [-0.01 + 5e-4 * i as f64, 0.0]).collect();
    let points = uneven_points(97, -0.008, 0.008);
    for kind in [
        MappingKind::Mortar,
        MappingKind::Linear,
        MappingKind::Nearest,
    ] {
        let mapping = Mapping::new(kind, &nodes, &points, None).expect("regular input");
        let force = both(|i| 1.0 + (i as f64).sin(), points.len());
        let sum = |f: &[f64]| f.iter().step_by(2).sum::<f64>();
        assert!(
            (sum(&mapping.force(&force)) / sum(&force) - 1.0).abs() < 1e-13,
            "{kind:?}"
        );
    }
}

/// Ripple of a uniform pressure, |t - mean| / mean over the nodes well inside: the quantity in which the kinds differ.
#[test]
fn mortar_keeps_a_uniform_pressure_more_even_than_the_others() {
    let nodes: Vec<[f64; 2]> = (0..121).map(|i| [1e-4 * i as f64, 0.0]).collect();
    let points = uneven_points(80, 0.0, 0.012);
    let ripple = |kind| {
        let mapping = Mapping::new(kind, &nodes, &points, None).expect("regular input");
        let mut positions: Vec<f64> = points.iter().map(|p| p[0]).collect();
        positions.sort_by(f64::total_cmp);
        let force: Vec<f64> = points
            .iter()
            .flat_map(|p| {
                let k = positions
                    .iter()
                    .position(|x| *x == p[0])
                    .expect("it is one of them");
                let left = if k > 0 {
                    positions[k - 1]
                } else {
                    -positions[k]
                };
                let right = if k + 1 < positions.len() {
                    positions[k + 1]
                } else {
                    0.024 - positions[k]
                };
                [0.5 * (right - left), 0.0]
            })
            .collect();
        let nodal = mapping.force(&force);
        let inside: Vec<f64> = (10..110).map(|i| nodal[2 * i] / 1e-4).collect();
        let mean = inside.iter().sum::<f64>() / inside.len() as f64;
        (inside.iter().map(|t| (t - mean).powi(2)).sum::<f64>() / inside.len() as f64).sqrt() / mean
    };
    let [mortar, linear, nearest] = [
        MappingKind::Mortar,
        MappingKind::Linear,
        MappingKind::Nearest,
    ]
    .map(ripple);
    println!("ripple: mortar {mortar:.3}, linear {linear:.3}, nearest {nearest:.3}");
    assert!(mortar < 0.5 * linear && linear < nearest);
}

#[test]
fn condensing_is_n_c_nt() {
    let nodes = [[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]];
    let points = [[0.4, 0.0], [1.5, 0.0]];
    let mapping = Mapping::new(MappingKind::Mortar, &nodes, &points, None).expect("regular input");
    let c = DMatrix::from_fn(6, 6, |i, j| 1.0 / (1.0 + i as f64 + j as f64));
    let mut n = DMatrix::zeros(4, 6);
    for column in 0..6 {
        let mut unit = vec![0.0; 6];
        unit[column] = 1.0;
        n.column_mut(column).copy_from_slice(&mapping.motion(&unit));
    }
    assert!((mapping.condense(&c) - &n * &c * n.transpose()).amax() < 1e-15);
}

#[test]
fn only_nodes_under_the_points_are_active() {
    let nodes: Vec<[f64; 2]> = (0..11).map(|i| [i as f64, 0.0]).collect();
    let mapping = Mapping::new(MappingKind::Mortar, &nodes, &[[3.4, 0.0], [4.4, 0.0]], None)
        .expect("regular input");
    assert_eq!(mapping.active(), vec![2, 3, 4, 5]);
}

#[test]
fn degenerate_input_is_refused() {
    let nodes = [[0.0, 0.0], [1.0, 0.0]];
    assert_eq!(
        Mapping::new(MappingKind::Mortar, &nodes, &[], None),
        Err(MappingError::Empty)
    );
    let beyond = Mapping::new(MappingKind::Mortar, &nodes, &[[0.5, 0.0], [1.5, 0.0]], None);
    assert!(matches!(beyond, Err(MappingError::Beyond { point: 1, .. })));
    for (left, cure) in [(0.5, "off-centre"), (-0.5, "too short")] {
        let points = [[left, 0.0], [1.5, 0.0]];
        let beyond = Mapping::new(MappingKind::Mortar, &nodes, &points, None);
        let why = beyond.expect_err("it reaches beyond the line").to_string();
        assert!(why.contains(cure), "no {cure} in {why}");
    }
    let twice = Mapping::new(MappingKind::Mortar, &nodes, &[[0.5, 0.0], [0.5, 0.1]], None);
    assert!(matches!(
        twice,
        Err(MappingError::Repeated {
            what: "glued points",
            first: 0,
            second: 1,
            ..
        })
    ));
    let same = Mapping::new(
        MappingKind::Mortar,
        &[[0.0, 0.0], [0.0, 0.0]],
        &[[0.0, 0.0]],
        None,
    );
    assert!(matches!(
        same,
        Err(MappingError::Repeated {
            what: "surface nodes",
            ..
        })
    ));
    let single = Mapping::new(MappingKind::Mortar, &nodes, &[[0.25, 0.0]], None)
        .expect("one point interpolates");
    assert_eq!(single.motion(&[0.0, 0.0, 4.0, 8.0]), vec![1.0, 2.0]);
}
