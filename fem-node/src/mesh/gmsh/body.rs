//! From the content of a file to a mesh for a body.

use std::collections::{BTreeMap, HashMap, HashSet};

use fem_kernel::mesh::connectivity::{Connectivity, NodeSet};
use fem_kernel::mesh::{Mesh, area};
use kit::ConfigError;

use super::error::{no_quadrilaterals, refused};
use super::file::{File, FileElement};
use super::joints::check_joints;
use super::lines::{join, sort_from_left};

/// Share of the size of the body below which a height counts as 0, and of the product of a corner's sides below which its area counts as 0.
const NOTHING: f64 = 1e-9;

/// Checks the elements of a file, turns them anticlockwise, and numbers the nodes, the group `top` first.
pub(super) fn build(file: &File, length_unit: f64) -> Result<Mesh, ConfigError> {
    let mut quads = without_repeats(&file.quads);
    if quads.is_empty() {
        return Err(no_quadrilaterals("it holds no quadrilaterals".into()));
    }
    let used = used_nodes(file, &quads);
    check_size(file, &used, length_unit)?;
    check_plane(file, &used)?;
    for quad in &mut quads {
        turn(file, quad)?;
    }
    let sides = sides(file, &quads)?;
    check_joints(file, &quads, &sides)?;
    let sets = named_sets(file, &quads, &sides)?;
    Ok(numbered(file, length_unit, &used, &quads, sets))
}

/// MSH 2.2 repeats an element for each of its groups.
fn without_repeats(quads: &[FileElement<4>]) -> Vec<FileElement<4>> {
    let mut known: HashMap<[u32; 4], usize> = HashMap::new();
    let mut kept: Vec<FileElement<4>> = Vec::new();
    for quad in quads {
        let mut key = quad.corners;
        key.sort_unstable();
        match known.get(&key) {
            Some(first) => kept[*first].groups.extend(&quad.groups),
            None => {
                known.insert(key, kept.len());
                kept.push(quad.clone());
            }
        }
    }
    kept
}

/// Positions of the nodes that belong to an element, ascending.
fn used_nodes(file: &File, quads: &[FileElement<4>]) -> Vec<u32> {
    let mut used = vec![false; file.nodes.len()];
    for node in quads.iter().flat_map(|quad| &quad.corners) {
        used[*node as usize] = true;
    }
    let nodes = used.iter().enumerate().filter(|(_, used)| **used);
    nodes.map(|(node, _)| node as u32).collect()
}

/// Beyond these lengths areas and stiffnesses lose their precision long before they overflow.
fn check_size(file: &File, used: &[u32], length_unit: f64) -> Result<(), ConfigError> {
    let far = |node: &u32| file.point(*node).map(f64::abs);
    let size = length_unit * used.iter().flat_map(far).fold(0.0, f64::max);
    if !(1e-9..=1e6).contains(&size) {
        return Err(refused(
            format!("the body would be {size:.3e} m large"),
            "mesh.length_unit_m is the length of the file's unit: 1e-3 for millimetres",
        ));
    }
    Ok(())
}

fn check_plane(file: &File, used: &[u32]) -> Result<(), ConfigError> {
    let range = |k: usize| {
        let ends = |[low, high]: [f64; 2], node: &u32| {
            let value = file.nodes[*node as usize].1[k];
            [low.min(value), high.max(value)]
        };
        used.iter().fold([f64::INFINITY, f64::NEG_INFINITY], ends)
    };
    let [x, y, [low, high]] = [0, 1, 2].map(range);
    // The comparison is false for NaN too.
    if high - low <= NOTHING * (x[1] - x[0]).max(y[1] - y[0]) {
        return Ok(());
    }
    let problem =
        format!("its elements do not lie in one plane z = const: z goes from {low:?} to {high:?}");
    Err(refused(problem, "draw the body in the plane z = 0"))
}

/// Turns an element anticlockwise; each of its corners must then be convex.
fn turn(file: &File, quad: &mut FileElement<4>) -> Result<(), ConfigError> {
    let at = |corner: u32| file.point(corner);
    if area(&quad.corners.map(at)) < 0.0 {
        quad.corners.swap(1, 3);
    }
    let points = quad.corners.map(at);
    for corner in 0..4 {
        let to = |other: usize| {
            let [p, q] = [points[corner], points[other % 4]];
            [q[0] - p[0], q[1] - p[1]]
        };
        let (next, last) = (to(corner + 1), to(corner + 3));
        let area = next[0] * last[1] - next[1] * last[0];
        let square = next[0].hypot(next[1]) * last[0].hypot(last[1]);
        // The comparison is false for NaN too.
        if area > NOTHING * square {
            continue;
        }
        let [x, y] = points[corner];
        let how = if area < -NOTHING * square {
            "folded, or not convex,"
        } else {
            "degenerate, without area or with a straight angle,"
        };
        let (element, node) = (quad.number, file.number(quad.corners[corner]));
        return Err(refused(
            format!("element {element} is {how} at node {node}, ({x:?}, {y:?}) in the file's unit"),
            "smooth or refine the mesh there (Mesh.Smoothing, Mesh.RecombinationAlgorithm): every corner must be convex",
        ));
    }
    Ok(())
}

/// The sides of all elements, each in the direction of its element; two elements on one side of the same two nodes overlap.
fn sides(file: &File, quads: &[FileElement<4>]) -> Result<HashMap<[u32; 2], u64>, ConfigError> {
    let mut directed: HashMap<[u32; 2], u64> = HashMap::new();
    for quad in quads {
        for side in quad.sides() {
            if let Some(first) = directed.insert(side, quad.number) {
                let ([a, b], second) = (side.map(|node| file.number(node)), quad.number);
                return Err(refused(
                    format!(
                        "elements {first} and {second} overlap: both lie on one side of nodes {a} and {b}"
                    ),
                    "mesh every part of the body once",
                ));
            }
        }
    }
    Ok(directed)
}

/// The named groups that hold elements, by positions of nodes in the file.
fn named_sets(
    file: &File,
    quads: &[FileElement<4>],
    sides: &HashMap<[u32; 2], u64>,
) -> Result<BTreeMap<String, NodeSet>, ConfigError> {
    let mut sets = BTreeMap::new();
    for ((dimension, group), name) in &file.names {
        let set = match dimension {
            1 => line_set(file, *group, name, sides)?,
            2 => region_set(quads, *group),
            _ => None,
        };
        let Some(set) = set else { continue };
        if sets.insert(name.clone(), set).is_some() {
            return Err(refused(
                format!(
                    "two physical groups, of lines and of surfaces or with two numbers, are named `{name}`"
                ),
                "rename one of them",
            ));
        }
    }
    Ok(sets)
}

fn line_set(
    file: &File,
    group: i64,
    name: &str,
    sides: &HashMap<[u32; 2], u64>,
) -> Result<Option<NodeSet>, ConfigError> {
    let mut seen = HashSet::new();
    let mut segments = Vec::new();
    let lines = file.lines.iter();
    for line in lines.filter(|line| line.groups.contains(&group)) {
        let [a, b] = line.corners;
        if ![[a, b], [b, a]].iter().any(|side| sides.contains_key(side)) {
            let element = line.number;
            return Err(refused(
                format!(
                    "line element {element} of the group `{name}` is not a side of any quadrilateral"
                ),
                "a group of lines must lie on the outline of a meshed surface, or inside it along sides of elements",
            ));
        }
        if seen.insert([a.min(b), a.max(b)]) {
            segments.push(line.corners);
        }
    }
    let mut lines = join(&segments).map_err(|node| {
        let node = file.number(node);
        let problem = format!("the group `{name}` branches at node {node}");
        refused(problem, "give each branch a physical group of its own")
    })?;
    sort_from_left(&mut lines, |node| file.point(node));
    Ok((!lines.is_empty()).then_some(NodeSet::Lines(lines)))
}

fn region_set(quads: &[FileElement<4>], group: i64) -> Option<NodeSet> {
    let inside = quads.iter().filter(|quad| quad.groups.contains(&group));
    let mut nodes: Vec<u32> = inside.flat_map(|quad| quad.corners).collect();
    nodes.sort_unstable();
    nodes.dedup();
    (!nodes.is_empty()).then_some(NodeSet::Region(nodes))
}

fn numbered(
    file: &File,
    length_unit: f64,
    used: &[u32],
    quads: &[FileElement<4>],
    mut sets: BTreeMap<String, NodeSet>,
) -> Mesh {
    let mut order = sets.get("top").map_or(Vec::new(), NodeSet::nodes);
    let first: HashSet<u32> = order.iter().copied().collect();
    order.extend(used.iter().filter(|node| !first.contains(node)));
    let mut new = vec![u32::MAX; file.nodes.len()];
    for (number, node) in order.iter().enumerate() {
        new[*node as usize] = number as u32;
    }
    let number = |node: &u32| new[*node as usize];
    for set in sets.values_mut() {
        match set {
            NodeSet::Lines(lines) => lines.iter_mut().flatten().for_each(|n| *n = number(n)),
            NodeSet::Region(nodes) => nodes.iter_mut().for_each(|n| *n = number(n)),
        }
    }
    let points = order
        .iter()
        .map(|node| file.point(*node).map(|x| length_unit * x));
    let corners = quads
        .iter()
        .map(|quad| quad.corners.map(|node| number(&node)));
    let connectivity = Connectivity::new(order.len(), corners.collect(), sets);
    Mesh::unstructured(points.collect(), connectivity)
}
