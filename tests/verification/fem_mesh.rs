//! Problem: the graded meshes of the rail, 65 mm x 20 mm.
//! Exact: 216 columns of 0.1 mm + 2 x 87 graded to 0.501 mm with ratio 1.0189, 30 rows of 0.1 mm + 42 graded to
//! 1.037 mm with ratio 1.0587, together 390 x 72 = 28 080; 188 x 30 = 5 640 at 0.2 mm; 94 x 15 = 1 410 at 0.4 mm.
//! Source: Renouf, Saulot and Berthier (2006), section 6, with the sizes that give the paper's number of elements.
//! Tolerance: the printed digits.

use fem_kernel::mesh::{Edge, Mesh};
use fem_node::FemConfig;
use fem_node::config::mesh::{MeshConfig, MeshSource};
use fem_node::mesh::graded;
use kit::read_config;
use serde_json::Value;

use crate::fem_bodies::{paper, quick, rail, small};

fn mesh(sizes: Value) -> (Mesh, MeshConfig) {
    let config: FemConfig = read_config(rail(sizes)).expect("valid");
    let MeshSource::Graded(numbers) = config.mesh else {
        panic!("it names no file");
    };
    (graded::build(&numbers).expect("valid"), numbers)
}

#[test]
fn the_rails_have_the_stated_numbers_of_elements() {
    for (sizes, columns, rows) in [(paper(), 390, 72), (small(), 188, 30), (quick(), 94, 15)] {
        let (mesh, _) = mesh(sizes);
        assert_eq!((mesh.columns, mesh.rows), (columns, rows));
    }
}

#[test]
fn the_paper_mesh_grows_as_stated() {
    let (mesh, config) = mesh(paper());
    assert!(
        (mesh.ratio_columns - 1.0189).abs() < 5e-5,
        "{}",
        mesh.ratio_columns
    );
    assert!(
        (mesh.ratio_rows - 1.0587).abs() < 5e-5,
        "{}",
        mesh.ratio_rows
    );
    let widest = mesh.point(1, 0)[0] - mesh.point(0, 0)[0];
    assert!((widest - 0.501e-3).abs() < 5e-7, "{widest}");
    let middle = mesh.columns / 2;
    let deepest = mesh.point(middle, 71)[1] - mesh.point(middle, 72)[1];
    assert!((deepest - 1.037e-3).abs() < 5e-7, "{deepest}");
    assert_eq!(config.size_m, 1e-4);
}

#[test]
fn the_crown_is_the_origin_and_the_base_is_flat() {
    for sizes in [paper(), small(), quick()] {
        let (mesh, _) = mesh(sizes);
        let middle = mesh.columns / 2;
        assert!(mesh.point(middle, 0).iter().all(|c| c.abs() < 1e-17));
        let base = mesh.edge(Edge::Bottom);
        assert!(
            base.iter()
                .all(|n| (mesh.point(n[0], n[1])[1] + 20e-3).abs() < 1e-15)
        );
        let [x, y] = mesh.point(0, 0);
        assert!((x + 32.5e-3).abs() < 1e-15);
        let drop = 0.3 - (0.3f64.powi(2) - 32.5e-3f64.powi(2)).sqrt();
        assert!((y + drop).abs() < 1e-15, "18.23 mm are left at the edges");
    }
}
