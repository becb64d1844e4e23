//! Problem: a linear displacement field on irregular meshes from a file: three and five elements around one node, each
//! divided into nine, with displaced inner nodes.
//! Exact: inner nodes carry no force; the forces on the rim do the work 2 x strain energy; rigid motions give no force.
//! Source: Irons' patch test (Irons and Razzaque 1972), as in `fem_patch` for structured meshes.
//! Tolerance: 1e-12 of the largest term, rounding of a few dozen operations.

use fem_kernel::element::body::{Body, ElementKind};
use fem_kernel::material::Elastic;
use fem_kernel::mesh::Mesh;
use fem_node::mesh::gmsh;

use crate::fem_msh::fan;

const KINDS: [ElementKind; 3] = [
    ElementKind::Q4OnePoint,
    ElementKind::Q4Full,
    ElementKind::Q4MeanDilatation,
];

/// `n` times 3 x 3 elements around one node, with no two inner sides parallel.
fn mesh(n: usize) -> Mesh {
    let mut drawing = fan(n).refined(3);
    let rim: Vec<usize> = drawing.lines[0].1.iter().flatten().copied().collect();
    for (k, point) in drawing.points.iter_mut().enumerate() {
        if !rim.contains(&k) {
            let wobble = |k: usize| 0.08 * (((k * 37) % 11) as f64 / 11.0 - 0.5);
            *point = [point[0] + wobble(7 * k), point[1] + wobble(5 * k + 3)];
        }
    }
    gmsh::parse(drawing.msh4(), 1.0).expect("a valid file")
}

fn elastic() -> Elastic {
    Elastic::plane_strain(2.0, 0.3, 1.0)
}

fn field(slope: [[f64; 2]; 2], x: [f64; 2]) -> [f64; 2] {
    [0, 1].map(|k| 0.1 + slope[k][0] * x[0] + slope[k][1] * x[1])
}

/// Displacement and force of every node.
fn forces(mesh: &Mesh, kind: ElementKind, slope: [[f64; 2]; 2]) -> Vec<[[f64; 2]; 2]> {
    let body = Body::new(mesh, kind, &elastic(), 1.0);
    let layout = body.layout;
    let (mut u, mut force) = (vec![0.0; layout.len()], vec![0.0; layout.len()]);
    for node in mesh.nodes() {
        let moved = field(slope, mesh.point(node[0], node[1]));
        (0..2).for_each(|k| u[layout.index(node, k)] = moved[k]);
    }
    body.internal_force(&u, &mut force);
    let of = |field: &[f64], node| [0, 1].map(|k| field[layout.index(node, k)]);
    mesh.nodes()
        .map(|node| [of(&u, node), of(&force, node)])
        .collect()
}

/// Elements around the node nearest to the origin.
fn valence(mesh: &Mesh) -> usize {
    let far = |node: &[usize; 2]| {
        let [x, y] = mesh.point(node[0], node[1]);
        x.hypot(y)
    };
    let hub = mesh.nodes().min_by(|a, b| far(a).total_cmp(&far(b)));
    let hub = hub.expect("there are nodes");
    let corners = mesh.element_indices().flat_map(|[i, j]| mesh.corners(i, j));
    corners.filter(|corner| *corner == hub).count()
}

#[test]
fn a_linear_field_loads_only_the_rim_and_has_the_energy_of_its_work() {
    let slope = [[0.3, -0.2], [0.7, 0.4]];
    let stress = elastic().stress([0.3, 0.4, 0.5]);
    for n in [3, 5] {
        let mesh = mesh(n);
        assert_eq!(valence(&mesh), n);
        // n kites with diagonals 1.2 and 2 sin(pi/n).
        let area = n as f64 * 1.2 * (std::f64::consts::PI / n as f64).sin();
        let exact = area * (0.3 * stress[0] + 0.4 * stress[1] + 0.5 * stress[2]);
        let rim = mesh.set("rim").expect("the group has a name");
        assert_eq!(rim.len(), 6 * n);
        for kind in KINDS {
            let all = forces(&mesh, kind, slope);
            for (node, [_, force]) in mesh.nodes().zip(&all) {
                let small = force.iter().all(|f| f.abs() <= 1e-12);
                assert!(small || rim.contains(&node), "{kind:?} {node:?}: {force:?}");
            }
            let work: f64 = all
                .iter()
                .flat_map(|[u, f]| [u[0] * f[0], u[1] * f[1]])
                .sum();
            assert!(
                (work - exact).abs() <= 1e-11 * exact,
                "{kind:?} {n}: {work} {exact}"
            );
        }
    }
}

#[test]
fn rigid_motions_give_no_force() {
    for slope in [[[0.0, 0.0], [0.0, 0.0]], [[0.0, -1.0], [1.0, 0.0]]] {
        for (n, kind) in [3, 5].into_iter().flat_map(|n| KINDS.map(|kind| (n, kind))) {
            for [_, force] in forces(&mesh(n), kind, slope) {
                assert!(
                    force.iter().all(|f| f.abs() <= 1e-12),
                    "{kind:?}: {force:?}"
                );
            }
        }
    }
}
