//! Problem: a block of 10 x 4 elements of 1 mm and a second part on or next to it, in one file, and blocks with missing elements.
//! Exact: parts that touch or overlap without a joint are refused, with the place and the numbers of nodes and elements. Small holes
//! and loose parts raise a warning with the place. Joined bodies, and intended holes and slits, raise neither.
//! Source: geometry.
//! Tolerance: none.

use fem_node::mesh::gmsh::parse;
use serde_json::json;

use crate::fem_bodies::setting;
use crate::fem_msh::{Drawing, MshFile};

/// `columns` x `rows` elements of this size (mm) with the lower left corner at `at`.
fn block(at: [f64; 2], [columns, rows]: [usize; 2], [width, height]: [f64; 2]) -> Drawing {
    let mut drawing = Drawing::default();
    for (i, j) in (0..=rows).flat_map(|j| (0..=columns).map(move |i| (i, j))) {
        let point = [at[0] + i as f64 * width, at[1] + j as f64 * height];
        drawing.points.push(point);
    }
    let number = |i: usize, j: usize| j * (columns + 1) + i;
    for (i, j) in (0..rows).flat_map(|j| (0..columns).map(move |i| (i, j))) {
        let corners = [[i, j], [i + 1, j], [i + 1, j + 1], [i, j + 1]];
        drawing.quads.push(corners.map(|[i, j]| number(i, j)));
    }
    drawing
}

fn lower() -> Drawing {
    block([0.0, 0.0], [10, 4], [1.0, 1.0])
}

/// Both in one file; with `joined`, nodes at exactly the same place are one node.
fn beside(mut first: Drawing, second: &Drawing, joined: bool) -> Drawing {
    let mut numbers = Vec::new();
    for point in &second.points {
        let known = first
            .points
            .iter()
            .position(|other| joined && other == point);
        numbers.push(known.unwrap_or(first.points.len()));
        if known.is_none() {
            first.points.push(*point);
        }
    }
    let quads = second.quads.iter();
    first
        .quads
        .extend(quads.map(|quad| quad.map(|node| numbers[node])));
    first
}

fn refused(drawing: &Drawing, words: &[&str]) {
    for text in [drawing.msh2(), drawing.msh4()] {
        let error = parse(text, 1e-3).expect_err("it must be refused");
        let all = words.iter().all(|word| error.problem.contains(word));
        assert!(all, "{words:?}: {error}");
    }
}

fn warnings(drawing: &Drawing) -> Vec<String> {
    let file = MshFile::new(&drawing.msh4());
    let config = json!({
        "base": "free", "mesh": {"gmsh": file.0, "length_unit_m": 1e-3},
        "material": {"young_pa": 1e9, "poisson": 0.3, "density_kg_per_m3": 1000.0},
        "time": {"step_s": "auto", "damping": 0.75},
    });
    fem_node::check(&config, &setting(1)).expect("it is a body")
}

#[test]
fn joined_parts_are_a_body_without_a_warning() {
    let upper = block([0.0, 4.0], [10, 4], [1.0, 0.25]);
    assert_eq!(warnings(&beside(lower(), &upper, true)), [""; 0]);
}

#[test]
fn nodes_on_the_side_of_another_element_are_refused() {
    for parts in [2, 3] {
        let size = 1.0 / parts as f64;
        let finer = block([0.0, 4.0], [10 * parts, 4], [size, size]);
        let words = [
            "lies on or in element ",
            "without being its corner, at (",
            ", 4.0)",
        ];
        refused(&beside(lower(), &finer, true), &words);
        refused(&beside(finer, &lower(), true), &words[..2]);
    }
}

#[test]
fn a_seam_open_by_less_than_a_thousandth_of_its_elements_is_refused() {
    for gap in [0.0, 1e-9, 1e-6, 1e-4] {
        let upper = block([gap, 4.0 + gap], [10, 4], [1.0, 1.0]);
        refused(
            &beside(lower(), &upper, false),
            &["nodes 56 and 45 lie in one place, at ("],
        );
    }
}

#[test]
fn overlapping_elements_are_refused() {
    let over = |at, count, size| beside(lower(), &block(at, count, size), false);
    refused(
        &over([2.3, 1.3], [3, 1], [0.7, 0.7]),
        &["node 5", "lies on or in element"],
    );
    refused(
        &over([-0.5, 3.4], [11, 4], [1.0, 1.0]),
        &["elements overlap: the side of nodes"],
    );
    // No node of one bar lies in the other.
    let bars = |rows| {
        beside(
            block([4.2, -4.0], [1, rows], [1.2, 9.0 / rows as f64]),
            &block([0.0, 0.3], [1, 1], [9.0, 1.1]),
            false,
        )
    };
    for rows in [1, 9] {
        refused(
            &bars(rows),
            &["elements overlap: the side of nodes", "crosses element"],
        );
    }
}

#[test]
fn missing_elements_raise_a_warning_with_the_place() {
    let without = |missing: &[usize]| {
        let mut drawing = lower();
        let mut at = 0..;
        drawing
            .quads
            .retain(|_| !missing.contains(&at.next().expect("endless")));
        warnings(&drawing)
    };
    let one = without(&[15]);
    assert_eq!(one.len(), 1, "{one:?}");
    assert!(
        one[0].contains("a hole of 4 sides around (5.5000e-3, 1.5000e-3) m"),
        "{one:?}"
    );
    assert!(without(&[15, 16])[0].contains("a hole of 6 sides around (6.0000e-3, 1.5000e-3) m"));
    assert!(
        without(&[15, 16, 25, 26])[0].contains("a hole of 8 sides around (6.0000e-3, 2.0000e-3) m")
    );
    assert!(!without(&[15, 26]).is_empty(), "they meet in a node");
    assert_eq!(
        without(&[14, 15, 16, 24, 25, 26]),
        [""; 0],
        "large enough to be intended"
    );
    assert_eq!(without(&[5]), [""; 0], "a notch");
}

#[test]
fn parts_without_a_joint_raise_a_warning() {
    let apart = block([0.0, 4.1], [10, 4], [1.0, 1.0]);
    let corner = block([10.0, 4.0], [2, 2], [1.0, 1.0]);
    for (upper, words) in [
        (apart, "part 2 of the body, around ("),
        (
            corner,
            "meet in the node at (1.0000e-2, 4.0000e-3) m, a hinge",
        ),
    ] {
        let found = warnings(&beside(lower(), &upper, true));
        assert_eq!(found.len(), 1, "{found:?}");
        assert!(found[0].contains(words), "{found:?}");
    }
}

/// A ring of 16 x 3 elements, and a block with a slit from one side to the middle, open by a twentieth of an element.
#[test]
fn an_intended_hole_or_slit_is_no_fault() {
    let mut ring = Drawing::default();
    for (k, layer) in (0..4).flat_map(|layer| (0..16).map(move |k| (k, layer))) {
        let (sin, cos) = (std::f64::consts::TAU * k as f64 / 16.0).sin_cos();
        let radius = 5.0 + layer as f64;
        ring.points.push([radius * cos, radius * sin]);
        if layer < 3 {
            let [a, b] = [16 * layer + k, 16 * layer + (k + 1) % 16];
            ring.quads.push([a, a + 16, b + 16, b]);
        }
    }
    assert_eq!(warnings(&ring), [""; 0]);
    let slit = |opening: f64| {
        let mut drawing = lower();
        for node in 22..27 {
            let [x, y] = drawing.points[node];
            drawing.points.push([x, y + opening]);
        }
        let upper = drawing.quads[20..].iter_mut().flatten();
        upper
            .filter(|node| (22..27).contains(*node))
            .for_each(|node| *node += 33);
        drawing
    };
    assert_eq!(warnings(&slit(0.05)), [""; 0]);
    refused(&slit(0.0), &["lie in one place"]);
}
