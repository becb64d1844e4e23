//! Problem: a round wheel on the flat top of a body, smooth and static. The elements are divided by three, three times, towards
//! the top, so nodes have three and six elements around them. The mesh is not a block.
//!
//! ```text
//!   D__F__E__C      each coarse element below a finer row becomes four:
//!   | \   /  |      A-B-H-G, B-C-E-H, H-E-F-G, G-F-D-A
//!   |  G-H   |
//!   A--------B
//! ```
//!
//! Exact: Hertz, p = p0 sqrt(1 - x^2/a^2), p0 = 2 F/(pi a t), a = sqrt(4 F R (1 - nu^2)/(pi E t)).
//! Source: K. L. Johnson, Contact Mechanics (1985), section 4.2.
//! Tolerance: the body is 20 times as wide and 15 times as high as the contact's half-width, so the pressure is within 1 % of
//! p0. Beyond 0.9 a, where the contact ends within an element, nothing is compared.

use fem_kernel::mesh::Edge;
use fem_node::FemConfig;
use fem_node::StaticNode;
use kit::read_config;
use protocol::Node;
use serde_json::json;

use crate::fem_bodies::{setting, window};
use crate::fem_msh::{Drawing, MshFile};

const WIDTH: f64 = 12e-3;
const COARSE: usize = 9;
const RADIUS: f64 = 0.05;
const HALF_WIDTH: f64 = 0.6e-3;

/// Rows of squares over the whole width, divided by three after `rows` of each size.
fn divided(rows: [usize; 4]) -> Drawing {
    let mut drawing = Drawing::default();
    let mut size = WIDTH / COARSE as f64;
    let mut columns = COARSE;
    let mut depth = 0.0;
    let row = |points: &mut Vec<[f64; 2]>, columns: usize, y: f64| -> Vec<usize> {
        let x = |i: usize| WIDTH * (i as f64 / columns as f64 - 0.5);
        points.extend((0..=columns).map(|i| [x(i), y]));
        (points.len() - columns - 1..points.len()).collect()
    };
    let mut below = row(&mut drawing.points, columns, depth);
    drawing
        .lines
        .push(("bottom", below.windows(2).map(|n| [n[0], n[1]]).collect()));
    for (level, count) in rows.into_iter().enumerate() {
        if level > 0 {
            let above = row(&mut drawing.points, 3 * columns, depth + size);
            for i in 0..columns {
                let [a, b] = [below[i], below[i + 1]];
                let [d, f, e, c] = [0, 1, 2, 3].map(|k| above[3 * i + k]);
                let [g, h] = [f, e].map(|node| {
                    let x = drawing.points[node][0];
                    drawing.points.push([x, depth + 0.5 * size]);
                    drawing.points.len() - 1
                });
                drawing
                    .quads
                    .extend([[a, b, h, g], [b, c, e, h], [h, e, f, g], [g, f, d, a]]);
            }
            depth += size;
            (below, columns, size) = (above, 3 * columns, size / 3.0);
        }
        for _ in 0..count {
            let above = row(&mut drawing.points, columns, depth + size);
            for i in 0..columns {
                drawing
                    .quads
                    .push([below[i], below[i + 1], above[i + 1], above[i]]);
            }
            depth += size;
            below = above;
        }
    }
    drawing
        .lines
        .push(("top", below.windows(2).map(|n| [n[1], n[0]]).collect()));
    drawing
}

#[test]
fn a_round_wheel_on_a_divided_mesh_gives_the_pressure_of_hertz() {
    let drawing = divided([4, 1, 2, 9]);
    let file = MshFile::new(&drawing.msh4());
    let (young, nu, thickness) = (102.5e9, 0.3, 1e-3);
    let modulus: f64 = young / (1.0 - nu * nu);
    let pi = std::f64::consts::PI;
    let load = HALF_WIDTH * HALF_WIDTH * pi * thickness * modulus / (4.0 * RADIUS);
    let config = json!({
        "analysis": "static", "element": "q4_2x2", "mesh": {"gmsh": file.0},
        "material": {"young_pa": young, "poisson": nu, "density_kg_per_m3": 7800.0},
        "time": {"step_s": "auto", "damping": 0.75},
        "wheel": {"load_n": load, "radius_m": RADIUS, "mass_kg": 0.01, "ramp_s": 0.0, "hold_s": 0.0},
        "contact": {"friction": 0.0},
    });
    let config: FemConfig = read_config(&config).expect("valid");
    let mut node = StaticNode::new(&config, &setting(1)).expect("it is held");
    assert!(node.model.mesh.size() > 19.0 * HALF_WIDTH);
    let increments = node.describe().end_s.expect("it ends") as u32;
    node.advance_alone(&window(0, increments))
        .expect("it converges");
    let p0 = 2.0 * load / (pi * HALF_WIDTH * thickness);
    let contact = node.held.as_ref().expect("loaded").contact.clone();
    let contact = contact.expect("there is a wheel");
    let mesh = &node.model.mesh;
    let nodes = mesh.edge(Edge::Top);
    assert_eq!(nodes.len(), 27 * COARSE + 1);
    let lengths = mesh.tributary(&nodes);
    let mut compared = 0;
    for (node, (force, length)) in nodes.iter().zip(contact.normal.iter().zip(lengths)) {
        let x = mesh.point(node[0], node[1])[0] / HALF_WIDTH;
        let pressure = force / (length * thickness) / p0;
        if x.abs() < 0.9 {
            let exact = (1.0 - x * x).sqrt();
            compared += 1;
            assert!(
                (pressure - exact).abs() < 0.01,
                "x = {x} a: {pressure} {exact}"
            );
        }
    }
    assert!(compared >= 21, "{compared}");
}
