//! Lumped masses, the kernels against the matrices, and forces under large rotations.

pub(in crate::element) mod plastic;

use super::*;

#[test]
fn lumped_masses_add_up_to_the_body() {
    let mesh = Mesh::structured(3, 2, |i, j| [i as f64 + 0.1 * j as f64, -2.0 * j as f64]);
    let total: f64 = lump(&mesh, 5.0).iter().sum();
    assert!((total - 5.0 * 12.0).abs() < 1e-12);
}

fn distorted() -> Mesh {
    Mesh::structured(6, 4, |i, j| {
        let wobble = |k: usize| 0.2 * ((k * 7919 + 13) % 101) as f64 / 101.0;
        let k = j * 7 + i;
        [i as f64 + wobble(k), -1.3 * j as f64 + wobble(k + 50)]
    })
}

fn law() -> Elastic {
    Elastic::plane_strain(3.0, 0.3, 1.0)
}

/// The row kernels regroup the formulas of the matrices, which follow the textbooks.
#[test]
fn the_forces_of_a_body_are_its_stiffness_times_the_displacements() {
    let mesh = distorted();
    for kind in [
        ElementKind::Q4OnePoint,
        ElementKind::Q4Full,
        ElementKind::Q4MeanDilatation,
    ] {
        for law in [law(), Elastic::plane_stress(3.0, 0.3, 1.0)] {
            let t = 0.7;
            let body = Body::new(&mesh, kind, &law, t);
            let layout = body.layout;
            let motion = |n: [usize; 2], k: usize| ((31 * n[0] + 17 * n[1] + 5 * k) as f64).sin();
            let (mut u, mut exact) = (vec![0.0; layout.len()], vec![0.0; layout.len()]);
            for (i, j) in (0..4).flat_map(|j| (0..6).map(move |i| (i, j))) {
                let corners = mesh.corners(i, j);
                let points = corners.map(|n| mesh.point(n[0], n[1]));
                let stiffness = stiffness(kind, &points, &law, t);
                let indices: [usize; 8] =
                    std::array::from_fn(|r| layout.index(corners[r / 2], r % 2));
                let moved: [f64; 8] = std::array::from_fn(|r| motion(corners[r / 2], r % 2));
                for (row, index) in stiffness.0.iter().zip(indices) {
                    exact[index] += row.iter().zip(moved).map(|(k, u)| k * u).sum::<f64>();
                }
                indices.iter().zip(moved).for_each(|(p, m)| u[*p] = m);
            }
            let mut force = vec![0.0; layout.len()];
            body.internal_force(&u, &mut force);
            let scale = exact.iter().fold(0.0, |m: f64, f| m.max(f.abs()));
            for (computed, exact) in force.iter().zip(&exact) {
                let error = (computed - exact).abs();
                assert!(error <= 1e-12 * scale, "{kind:?} {computed} {exact}");
            }
        }
    }
}

const COROTATIONAL: NonlinearLaw = NonlinearLaw::Corotational;
const ROTATING: [ElementKind; 2] = [ElementKind::Q4OnePoint, ElementKind::Q4Full];

/// The field x -> motion(x) - x of a body and the forces of the corotational law under it.
fn moved(body: &Body, mesh: &Mesh, motion: impl Fn([f64; 2]) -> [f64; 2]) -> [Vec<f64>; 2] {
    let mut u = vec![0.0; body.layout.len()];
    for (i, j) in (0..=mesh.rows).flat_map(|j| (0..=mesh.columns).map(move |i| (i, j))) {
        let (x, y) = (mesh.point(i, j), motion(mesh.point(i, j)));
        (0..2).for_each(|k| u[body.layout.index([i, j], k)] = y[k] - x[k]);
    }
    let force = forces(body, &u);
    [u, force]
}

fn forces(body: &Body, u: &[f64]) -> Vec<f64> {
    let layout = body.layout;
    let mut rows = RowForces::new(layout);
    let mut force = vec![0.0; layout.len()];
    for row in 0..layout.node_rows {
        if row + 1 < layout.node_rows {
            let path = StrainPath {
                u: CornerRows::between([&u[layout.row(row)], &u[layout.row(row + 1)]]),
                du: CornerRows::between([&[], &[]]),
                history: &mut [],
                dissipated: &mut [],
            };
            let all = 0..layout.padded_columns();
            body.nonlinear_row(&COROTATIONAL, row, path, all, &mut rows);
        } else {
            rows.clear_upper();
        }
        let all = layout.spans([0, layout.stride]);
        rows.assemble(&mut force[layout.row(row)], &all);
        rows.advance();
    }
    force
}

fn rotated([x, y]: [f64; 2], angle: f64) -> [f64; 2] {
    let (sin, cos) = angle.sin_cos();
    [cos * x - sin * y, sin * x + cos * y]
}

/// Not affine, so that the hourglass modes take part; strains of some 1e-2.
fn bent([x, y]: [f64; 2]) -> [f64; 2] {
    [x + 0.01 * x * y, y - 0.02 * y + 0.005 * x * x]
}

#[test]
fn a_rotation_gives_no_force_and_turns_the_forces_of_a_stretch() {
    let (mesh, law) = (distorted(), law());
    for kind in ROTATING {
        let body = Body::new(&mesh, kind, &law, 0.7);
        let [_, still] = moved(&body, &mesh, bent);
        let scale = still.iter().fold(0.0, |m: f64, f| m.max(f.abs()));
        for angle in [0.3, 1.6, -2.9] {
            let [_, none] = moved(&body, &mesh, |x| rotated(x, angle));
            assert!(
                none.iter().all(|f| f.abs() < 1e-12 * scale / 0.01),
                "{kind:?} {angle}"
            );
            let [_, turned] = moved(&body, &mesh, |x| rotated(bent(x), angle));
            for (i, j) in (0..=4).flat_map(|j| (0..=6).map(move |i| (i, j))) {
                let of = |f: &[f64]| [0, 1].map(|k| f[body.layout.index([i, j], k)]);
                let (exact, computed) = (rotated(of(&still), angle), of(&turned));
                let error = (exact[0] - computed[0]).hypot(exact[1] - computed[1]);
                assert!(error < 1e-11 * scale / 0.01, "{kind:?} {angle}: {error:e}");
            }
        }
    }
}

/// Central differences of U = u F / 2 + [`Body::energy_correction`], in rough directions.
#[test]
fn the_forces_of_a_rotated_body_are_the_slope_of_its_energy() {
    let (mesh, law) = (distorted(), law());
    for kind in ROTATING {
        let body = Body::new(&mesh, kind, &law, 0.7);
        let [u, force] = moved(&body, &mesh, |x| rotated(bent(x), 0.8));
        let energy = |u: &[f64]| {
            let work: f64 = u.iter().zip(forces(&body, u)).map(|(u, f)| u * f).sum();
            0.5 * work + body.energy_correction(&COROTATIONAL, u, &[])
        };
        for seed in 0..5 {
            let mut along = vec![0.0; u.len()];
            for (i, j) in (0..=4).flat_map(|j| (0..=6).map(move |i| (i, j))) {
                let rough = |k: usize| ((seed * 91 + 31 * i + 17 * j + 5 * k) as f64).sin();
                (0..2).for_each(|k| along[body.layout.index([i, j], k)] = rough(k));
            }
            let at = |share: f64| -> Vec<f64> {
                u.iter().zip(&along).map(|(u, d)| u + share * d).collect()
            };
            let slope = (energy(&at(1e-5)) - energy(&at(-1e-5))) / 2e-5;
            let exact: f64 = force.iter().zip(&along).map(|(f, d)| f * d).sum();
            let scale: f64 = force.iter().zip(&along).map(|(f, d)| (f * d).abs()).sum();
            assert!(
                (slope - exact).abs() < 1e-6 * scale,
                "{kind:?}: {slope} {exact}"
            );
        }
    }
}
