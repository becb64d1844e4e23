//! Problem: a linear displacement field on a mesh with no parallel sides inside.
//! Exact: the stress is D grad u everywhere; inner nodes carry no force; the forces on the outer nodes do the work
//! 2 x strain energy; a translation and an infinitesimal rotation give no force.
//! Source: Irons' patch test (Irons and Razzaque 1972); Flanagan and Belytschko (1981), section 3, for the
//! orthogonality of the hourglass vectors.
//! Tolerance: 1e-12 of the largest term, rounding of a few dozen operations.

use fem_kernel::element::body::{Body, ElementKind};
use fem_kernel::element::shape::strain;
use fem_kernel::material::Elastic;
use fem_kernel::mesh::Mesh;

const SIZE: usize = 5;

fn distorted() -> Mesh {
    Mesh::structured(SIZE, SIZE, |i, j| {
        let inner = (1..SIZE).contains(&i) && (1..SIZE).contains(&j);
        let wobble = |k: usize| match inner {
            true => 0.5 * (((k * 37) % 11) as f64 / 11.0 - 0.5),
            false => 0.0,
        };
        [
            i as f64 + wobble(7 * i + j),
            -(j as f64) + wobble(i + 5 * j + 3),
        ]
    })
}

fn elastic() -> Elastic {
    Elastic::plane_strain(2.0, 0.3, 1.0)
}

/// Nodal forces under the field u = shift + slope x, row by row.
fn forces(kind: ElementKind, slope: [[f64; 2]; 2], shift: [f64; 2]) -> Vec<([usize; 2], [f64; 2])> {
    let mesh = distorted();
    let body = Body::new(&mesh, kind, &elastic(), 1.0);
    let layout = body.layout;
    let nodes: Vec<[usize; 2]> = (0..=SIZE)
        .flat_map(|j| (0..=SIZE).map(move |i| [i, j]))
        .collect();
    let mut u = vec![0.0; layout.len()];
    for node in &nodes {
        for k in 0..2 {
            u[layout.index(*node, k)] = field(slope, shift, mesh.point(node[0], node[1]))[k];
        }
    }
    let mut force = vec![0.0; layout.len()];
    body.internal_force(&u, &mut force);
    let at = |node: [usize; 2]| [0, 1].map(|k| force[layout.index(node, k)]);
    nodes.into_iter().map(|node| (node, at(node))).collect()
}

fn field(slope: [[f64; 2]; 2], shift: [f64; 2], x: [f64; 2]) -> [f64; 2] {
    [0, 1].map(|k| shift[k] + slope[k][0] * x[0] + slope[k][1] * x[1])
}

const KINDS: [ElementKind; 3] = [
    ElementKind::Q4OnePoint,
    ElementKind::Q4Full,
    ElementKind::Q4MeanDilatation,
];

const SLOPE: [[f64; 2]; 2] = [[0.3, -0.2], [0.7, 0.4]];

#[test]
fn a_linear_field_has_constant_stress_and_no_force_on_inner_nodes() {
    let mesh = distorted();
    let exact = elastic().stress([0.3, 0.4, 0.5]);
    for (i, j) in (0..SIZE).flat_map(|j| (0..SIZE).map(move |i| (i, j))) {
        let points = mesh.corners(i, j).map(|n| mesh.point(n[0], n[1]));
        let u = points.map(|x| field(SLOPE, [0.1, -2.0], x));
        for natural in [[0.0, 0.0], [0.57, -0.57], [-1.0, 1.0]] {
            let stress = elastic().stress(strain(&points, &u, natural));
            let error = (0..3)
                .map(|k| (stress[k] - exact[k]).abs())
                .fold(0.0, f64::max);
            assert!(error <= 1e-12, "{stress:?} {exact:?}");
        }
    }
    let inner = |[i, j]: [usize; 2]| (1..SIZE).contains(&i) && (1..SIZE).contains(&j);
    for kind in KINDS {
        for (node, force) in forces(kind, SLOPE, [0.1, -2.0]) {
            let small = force.iter().all(|f| f.abs() <= 1e-12);
            assert!(small || !inner(node), "{kind:?} {node:?}: {force:?}");
        }
    }
}

#[test]
fn the_outer_forces_do_the_work_of_the_strain_energy() {
    let mesh = distorted();
    let stress = elastic().stress([0.3, 0.4, 0.5]);
    let exact = 25.0 * (0.3 * stress[0] + 0.4 * stress[1] + 0.5 * stress[2]);
    for kind in KINDS {
        let work = |(n, force): &([usize; 2], [f64; 2])| {
            let u = field(SLOPE, [0.0, 0.0], mesh.point(n[0], n[1]));
            force[0] * u[0] + force[1] * u[1]
        };
        let work: f64 = forces(kind, SLOPE, [0.0, 0.0]).iter().map(work).sum();
        let close = (work - exact).abs() <= 1e-12 * exact;
        assert!(close, "{kind:?} {work} {exact}");
    }
}

#[test]
fn rigid_motions_give_no_force() {
    let still = [[0.0, 0.0], [0.0, 0.0]];
    let turning = [[0.0, -1.0], [1.0, 0.0]];
    for (slope, shift) in [(still, [3.0, -1.0]), (turning, [0.0, 0.0])] {
        for kind in KINDS {
            for (node, force) in forces(kind, slope, shift) {
                let none = force.iter().all(|f| f.abs() <= 1e-12);
                assert!(none, "{kind:?} {node:?}: {force:?}");
            }
        }
    }
}
