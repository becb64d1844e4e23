//! Quadrilaterals and named lines in Gmsh's format, and the meshes that several cases share.

use std::fmt::Write;
use std::path::PathBuf;
use std::sync::atomic::{AtomicU64, Ordering};

use fem_kernel::mesh::{Edge, Mesh};

/// A mesh to write.
#[derive(Clone, Debug, Default)]
pub struct Drawing {
    /// Positions of the nodes.
    pub points: Vec<[f64; 2]>,
    /// Corners of the elements, in either sense of rotation.
    pub quads: Vec<[usize; 4]>,
    /// Physical groups of lines.
    pub lines: Vec<(&'static str, Vec<[usize; 2]>)>,
}

impl Drawing {
    /// A block with its four edges as groups. Nodes and elements are in another order than in the block, and every third
    /// element is clockwise.
    pub fn of_block(mesh: &Mesh) -> Drawing {
        let shuffled = shuffle(mesh.points.len());
        let mut drawing = Drawing {
            points: vec![[0.0; 2]; mesh.points.len()],
            ..Drawing::default()
        };
        for (place, point) in shuffled.iter().zip(&mesh.points) {
            drawing.points[*place] = *point;
        }
        let number = |node: [usize; 2]| shuffled[mesh.number(node)];
        let places: Vec<[usize; 2]> = mesh.element_indices().collect();
        for k in shuffle(places.len()) {
            let mut quad = mesh.corners(places[k][0], places[k][1]).map(number);
            if k % 3 == 0 {
                quad.swap(1, 3);
            }
            drawing.quads.push(quad);
        }
        for (name, edge) in Edge::ALL {
            let nodes = mesh.edge(edge);
            let pairs = nodes.windows(2);
            let lines = pairs.map(|pair| [number(pair[0]), number(pair[1])]);
            drawing.lines.push((name, lines.collect()));
        }
        drawing
    }

    /// The mesh as MSH 2.2.
    pub fn msh2(&self) -> String {
        let mut text = String::from("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n");
        self.names(&mut text);
        let add = |text: &mut String, line: String| writeln!(text, "{line}").expect("a string");
        add(&mut text, format!("$Nodes\n{}", self.points.len()));
        for (k, [x, y]) in self.points.iter().enumerate() {
            add(&mut text, format!("{} {x:e} {y:e} 0", k + 1));
        }
        let lines: usize = self.lines.iter().map(|(_, lines)| lines.len()).sum();
        let count = lines + self.quads.len();
        add(&mut text, format!("$EndNodes\n$Elements\n{count}"));
        let mut number = 0;
        for (group, (_, lines)) in self.lines.iter().enumerate() {
            for [a, b] in lines {
                number += 1;
                let group = group + 1;
                add(
                    &mut text,
                    format!("{number} 1 2 {group} {group} {} {}", a + 1, b + 1),
                );
            }
        }
        for [a, b, c, d] in self.quads.iter().map(|quad| quad.map(|node| node + 1)) {
            number += 1;
            add(&mut text, format!("{number} 3 2 1 1 {a} {b} {c} {d}"));
        }
        text + "$EndElements\n"
    }

    /// The mesh as MSH 4.1, with one curve per group.
    pub fn msh4(&self) -> String {
        let mut text = String::from("$MeshFormat\n4.1 0 8\n$EndMeshFormat\n");
        self.names(&mut text);
        let add = |text: &mut String, line: String| writeln!(text, "{line}").expect("a string");
        add(&mut text, format!("$Entities\n1 {} 1 0", self.lines.len()));
        add(&mut text, "1 0 0 0 0".into());
        for group in 1..=self.lines.len() {
            add(&mut text, format!("{group} 0 0 0 1 1 0 1 {group} 2 1 -1"));
        }
        add(&mut text, "1 0 0 0 1 1 0 1 1 0\n$EndEntities".into());
        let count = self.points.len();
        // Two blocks: the first is empty, the second is on a curve and has parameters.
        add(
            &mut text,
            format!("$Nodes\n2 {count} 1 {count}\n2 1 0 0\n1 1 1 {count}"),
        );
        (1..=count).for_each(|k| add(&mut text, k.to_string()));
        for [x, y] in &self.points {
            add(&mut text, format!("{x:e} {y:e} 0 0.5"));
        }
        let lines: usize = self.lines.iter().map(|(_, lines)| lines.len()).sum();
        let (blocks, total) = (self.lines.len() + 1, lines + self.quads.len());
        add(
            &mut text,
            format!("$EndNodes\n$Elements\n{blocks} {total} 1 {total}"),
        );
        let mut number = 0;
        for (group, (_, lines)) in self.lines.iter().enumerate() {
            add(&mut text, format!("1 {} 1 {}", group + 1, lines.len()));
            for [a, b] in lines {
                number += 1;
                add(&mut text, format!("{number} {} {}", a + 1, b + 1));
            }
        }
        add(&mut text, format!("2 1 3 {}", self.quads.len()));
        for [a, b, c, d] in self.quads.iter().map(|quad| quad.map(|node| node + 1)) {
            number += 1;
            add(&mut text, format!("{number} {a} {b} {c} {d}"));
        }
        text + "$EndElements\n"
    }

    fn names(&self, text: &mut String) {
        let count = self.lines.len() + 1;
        writeln!(text, "$PhysicalNames\n{count}").expect("a string");
        for (group, (name, _)) in self.lines.iter().enumerate() {
            writeln!(text, "1 {} \"{name}\"", group + 1).expect("a string");
        }
        text.push_str("2 1 \"whole body\"\n$EndPhysicalNames\n");
    }

    /// Divides each element into `parts` x `parts`, with the new nodes bilinear between the corners, and splits the groups.
    pub fn refined(&self, parts: usize) -> Drawing {
        let mut fine = Drawing::default();
        let add = |points: &mut Vec<[f64; 2]>, p: [f64; 2]| {
            let near = |q: &[f64; 2]| (p[0] - q[0]).hypot(p[1] - q[1]) < 1e-9;
            points.iter().position(near).unwrap_or_else(|| {
                points.push(p);
                points.len() - 1
            })
        };
        let share = |k: usize| k as f64 / parts as f64;
        let between = |a: [f64; 2], b: [f64; 2], s: f64| [0, 1].map(|k| a[k] + s * (b[k] - a[k]));
        for quad in &self.quads {
            let [a, b, c, d] = quad.map(|node| self.points[node]);
            let place = |i: usize, j: usize| {
                between(between(a, b, share(i)), between(d, c, share(i)), share(j))
            };
            for (i, j) in (0..parts).flat_map(|j| (0..parts).map(move |i| (i, j))) {
                let corners = [[i, j], [i + 1, j], [i + 1, j + 1], [i, j + 1]];
                let quad = corners.map(|[i, j]| add(&mut fine.points, place(i, j)));
                fine.quads.push(quad);
            }
        }
        for (name, lines) in &self.lines {
            let mut split = Vec::new();
            for [a, b] in lines.iter().map(|line| line.map(|node| self.points[node])) {
                let ends = (0..parts).map(|k| [k, k + 1].map(|k| between(a, b, share(k))));
                split.extend(ends.map(|ends| ends.map(|p| add(&mut fine.points, p))));
            }
            fine.lines.push((name, split));
        }
        fine
    }
}

/// `n` elements around one node, a lattice only for n = 4, with the group `rim` around all.
pub fn fan(n: usize) -> Drawing {
    let on_circle = |radius: f64, turns: f64| {
        let angle = std::f64::consts::TAU * turns;
        [radius * angle.cos(), radius * angle.sin()]
    };
    let mut drawing = Drawing {
        points: vec![[0.0, 0.0]],
        ..Drawing::default()
    };
    let mut rim = Vec::new();
    for k in 0..n {
        let turns = k as f64 / n as f64;
        drawing.points.push(on_circle(1.0, turns));
        drawing.points.push(on_circle(1.2, turns + 0.5 / n as f64));
        let (spoke, corner, next) = (1 + 2 * k, 2 + 2 * k, 1 + (2 * k + 2) % (2 * n));
        drawing.quads.push([0, spoke, corner, next]);
        rim.extend([[spoke, corner], [corner, next]]);
    }
    drawing.lines.push(("rim", rim));
    drawing
}

/// A permutation that looks random: the multiples of a number that has no common divisor with the count.
fn shuffle(count: usize) -> Vec<usize> {
    let divides =
        |a: usize, b: usize| (2..=a.min(b)).any(|d| a.is_multiple_of(d) && b.is_multiple_of(d));
    let factor = (count / 3 + 1..).find(|factor| !divides(*factor, count));
    let factor = factor.expect("the next prime at the latest");
    (0..count).map(|k| (k * factor + 5) % count).collect()
}

/// A file in the temporary folder, removed when dropped.
pub struct MshFile(pub PathBuf);

impl MshFile {
    /// Writes the file.
    pub fn new(text: &str) -> MshFile {
        static COUNT: AtomicU64 = AtomicU64::new(0);
        let unique = COUNT.fetch_add(1, Ordering::Relaxed);
        let name = format!("thirdbody-mesh-{}-{unique}.msh", std::process::id());
        let path = std::env::temp_dir().join(name);
        std::fs::write(&path, text).expect("the temporary folder is writable");
        MshFile(path)
    }
}

impl Drop for MshFile {
    fn drop(&mut self) {
        let _ = std::fs::remove_file(&self.0);
    }
}
