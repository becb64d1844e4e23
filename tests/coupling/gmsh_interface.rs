//! Problem: the main job at its start, with the rail once as the block of the scene and once as a mesh file beside its own scenario,
//! joined by the physical group `crown`.
//! Exact: the same interface force and the same motion of the surface; only the order of sums differs. A replay from
//! another folder finds the file and gives the same bits.
//! Tolerance: 1e-6 of the largest value: the contact solver stops at 1e-4 of its forces, so differences of rounding stay small but do
//! not vanish.

use std::fmt::Write;
use std::path::Path;
use std::process::Output;

use fem_kernel::mesh::Edge;
use fem_node::FemConfig;
use fem_node::config::mesh::MeshSource;
use fem_node::mesh::graded;
use harness::runs::read_csv;
use harness::runs::{Scratch, thirdbody};

/// The rail of the scene as MSH 2.2, its upper edge named `crown` and its lower one `bottom`.
fn rail(scene: &toml::Table) -> String {
    let config = scene["participant"][0]["config"].clone();
    let config = serde_json::to_value(config).expect("text keys");
    let config: FemConfig = kit::read_config(&config).expect("the scene is valid");
    let MeshSource::Graded(numbers) = config.mesh else {
        panic!("the scene's rail is a block");
    };
    let mesh = graded::build(&numbers).expect("the scene is valid");
    let mut text = String::from("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n");
    text += "$PhysicalNames\n2\n1 1 \"crown\"\n1 2 \"bottom\"\n$EndPhysicalNames\n";
    writeln!(text, "$Nodes\n{}", mesh.points.len()).expect("a string");
    for (k, [x, y]) in mesh.points.iter().enumerate() {
        writeln!(text, "{} {x:e} {y:e} 0", k + 1).expect("a string");
    }
    let number = |node: [usize; 2]| mesh.number(node) + 1;
    let mut elements = Vec::new();
    for (group, edge) in [(1, Edge::Top), (2, Edge::Bottom)] {
        for pair in mesh.edge(edge).windows(2) {
            let [a, b] = [pair[0], pair[1]].map(number);
            elements.push(format!("1 2 {group} {group} {a} {b}"));
        }
    }
    for [i, j] in mesh.element_indices() {
        let [a, b, c, d] = mesh.corners(i, j).map(number);
        elements.push(format!("3 2 0 1 {a} {b} {c} {d}"));
    }
    writeln!(text, "$EndNodes\n$Elements\n{}", elements.len()).expect("a string");
    for (k, element) in elements.iter().enumerate() {
        writeln!(text, "{} {element}", k + 1).expect("a string");
    }
    text + "$EndElements\n"
}

fn succeeded(output: &Output) {
    let message = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{message}");
}

#[test]
fn a_physical_group_can_be_an_interface() {
    let quick = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenarios/quick/scenario.toml");
    let mut scene: toml::Table = std::fs::read_to_string(quick)
        .expect("the scene is there")
        .parse()
        .expect("it is TOML");
    let mesh = rail(&scene);
    scene["run"]
        .as_table_mut()
        .expect("a table")
        .insert("end_s".into(), 1e-4.into());
    let (block, file, elsewhere) = (
        Scratch::new("block"),
        Scratch::new("file"),
        Scratch::new("cwd"),
    );
    let write = |folder: &Scratch, name: &str, text: &str| {
        std::fs::write(folder.path().join(name), text).expect("the folder is writable");
    };
    write(&block, "scenario.toml", &scene.to_string());
    let config = scene["participant"][0]["config"]
        .as_table_mut()
        .expect("a table");
    let source: toml::Table = "gmsh = \"rail.msh\"".parse().expect("it is TOML");
    config.insert("mesh".into(), source.into());
    scene["interface"][0]["between"][0] = "rail.crown".into();
    write(&file, "scenario.toml", &scene.to_string());
    write(&file, "rail.msh", &mesh);

    let columns = [&block, &file].map(|folder| {
        let out = folder.path().join("out");
        let mut run = thirdbody(elsewhere.path());
        run.arg("run").arg(folder.path()).arg("--out").arg(&out);
        succeeded(&run.output().expect("the program starts"));
        read_csv(&out.join("signals.csv"))
    });
    for name in ["rail.interface_force_y_n", "rail.interface_force_x_n"] {
        let [exact, ours] = [0, 1].map(|k| &columns[k][name]);
        let scale = exact.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
        assert!(scale > 0.0 && exact.len() > 100, "{name}");
        for (window, (a, b)) in exact.iter().zip(ours).enumerate() {
            let error = (a - b).abs() / scale;
            assert!(error < 1e-6, "{name}, window {window}: {error:e}");
        }
    }
    let mut replay = thirdbody(block.path());
    replay.arg("replay").arg(file.path().join("out"));
    succeeded(&replay.output().expect("the program starts"));
}
