//! Problem: the same body as text and as binary, in MSH 2.2 and 4.1, in both byte orders; and two files from Gmsh itself.
//! Exact: the same mesh, bit for bit. Changed, removed or missing bytes never cause a panic.
//! Source: Gmsh reference manual, "MSH file format" and "MSH file format version 2 (Legacy)", the binary form. The files
//! `reference/gmsh_*_binary.msh` are from Gmsh 4.15.2 (a rectangle of 4 x 2, 16 elements, its edges as groups).
//! Tolerance: none.

use fem_kernel::mesh::Mesh;
use fem_node::mesh::gmsh::parse;

use crate::fem_msh::{Drawing, fan};

/// The bytes of a file, big-endian or little-endian.
struct Bytes {
    big_endian: bool,
    out: Vec<u8>,
}

impl Bytes {
    fn new(version: &str, big_endian: bool) -> Bytes {
        let mut bytes = Bytes {
            big_endian,
            out: Vec::new(),
        };
        bytes.text(&format!("$MeshFormat\n{version} 1 8\n"));
        bytes.int(1);
        bytes.text("\n$EndMeshFormat\n");
        bytes
    }

    fn text(&mut self, text: &str) {
        self.out.extend(text.as_bytes());
    }

    fn int(&mut self, value: i32) {
        self.out.extend(match self.big_endian {
            true => value.to_be_bytes(),
            false => value.to_le_bytes(),
        });
    }

    fn ints(&mut self, values: &[usize]) {
        values.iter().for_each(|value| self.int(*value as i32));
    }

    fn size(&mut self, value: usize) {
        self.wide(value as u64);
    }

    fn wide(&mut self, bits: u64) {
        self.out.extend(match self.big_endian {
            true => bits.to_be_bytes(),
            false => bits.to_le_bytes(),
        });
    }

    fn doubles(&mut self, values: &[f64]) {
        values.iter().for_each(|value| self.wide(value.to_bits()));
    }

    fn names(&mut self, drawing: &Drawing) {
        self.text(&format!("$PhysicalNames\n{}\n", drawing.lines.len() + 1));
        for (group, (name, _)) in drawing.lines.iter().enumerate() {
            self.text(&format!("1 {} \"{name}\"\n", group + 1));
        }
        self.text("2 1 \"whole body\"\n$EndPhysicalNames\n");
    }
}

/// MSH 2.2: one header for all lines of a group, and one for each quadrilateral, as Gmsh writes them.
fn msh2(drawing: &Drawing, big_endian: bool) -> Vec<u8> {
    let mut bytes = Bytes::new("2.2", big_endian);
    bytes.names(drawing);
    bytes.text(&format!("$Nodes\n{}\n", drawing.points.len()));
    for (k, [x, y]) in drawing.points.iter().enumerate() {
        bytes.ints(&[k + 1]);
        bytes.doubles(&[*x, *y, 0.0]);
    }
    let lines: usize = drawing.lines.iter().map(|(_, lines)| lines.len()).sum();
    let count = lines + drawing.quads.len();
    bytes.text(&format!("\n$EndNodes\n$Elements\n{count}\n"));
    let mut number = 0;
    for (group, (_, lines)) in drawing.lines.iter().enumerate() {
        bytes.ints(&[1, lines.len(), 2]);
        for [a, b] in lines {
            number += 1;
            bytes.ints(&[number, group + 1, group + 1, a + 1, b + 1]);
        }
    }
    for quad in &drawing.quads {
        number += 1;
        bytes.ints(&[3, 1, 2, number, 1, 1]);
        bytes.ints(&quad.map(|node| node + 1));
    }
    bytes.text("\n$EndElements\n");
    bytes.out
}

/// MSH 4.1: one curve per group, nodes with a parameter, and a section that the reader skips.
fn msh4(drawing: &Drawing, big_endian: bool) -> Vec<u8> {
    let mut bytes = Bytes::new("4.1", big_endian);
    bytes.names(drawing);
    entities(&mut bytes, drawing);
    bytes.text("$Periodic\n");
    bytes.ints(&[7, 0x2445_6e64]);
    bytes.text("\n$EndPeriodic\n$Nodes\n");
    let count = drawing.points.len();
    for value in [1, count, 1, count] {
        bytes.size(value);
    }
    bytes.ints(&[1, 1, 1]);
    bytes.size(count);
    (1..=count).for_each(|k| bytes.size(k));
    for [x, y] in &drawing.points {
        bytes.doubles(&[*x, *y, 0.0, 0.5]);
    }
    bytes.text("\n$EndNodes\n$Elements\n");
    let lines: usize = drawing.lines.iter().map(|(_, lines)| lines.len()).sum();
    let total = lines + drawing.quads.len();
    for value in [drawing.lines.len() + 1, total, 1, total] {
        bytes.size(value);
    }
    let mut number = 0;
    let mut element = |bytes: &mut Bytes, nodes: &[usize]| {
        number += 1;
        bytes.size(number);
        nodes.iter().for_each(|node| bytes.size(node + 1));
    };
    for (group, (_, lines)) in drawing.lines.iter().enumerate() {
        bytes.ints(&[1, group + 1, 1]);
        bytes.size(lines.len());
        lines.iter().for_each(|line| element(&mut bytes, line));
    }
    bytes.ints(&[2, 1, 3]);
    bytes.size(drawing.quads.len());
    let quads = drawing.quads.iter();
    quads.for_each(|quad| element(&mut bytes, quad));
    bytes.text("\n$EndElements\n");
    bytes.out
}

fn entities(bytes: &mut Bytes, drawing: &Drawing) {
    bytes.text("$Entities\n");
    for value in [1, drawing.lines.len(), 1, 0] {
        bytes.size(value);
    }
    bytes.int(1);
    bytes.doubles(&[0.0; 3]);
    bytes.size(0);
    for group in 1..=drawing.lines.len() {
        bytes.int(group as i32);
        bytes.doubles(&[0.0; 6]);
        bytes.size(1);
        bytes.ints(&[group]);
        bytes.size(2);
        bytes.int(1);
        bytes.int(-1);
    }
    bytes.int(1);
    bytes.doubles(&[0.0; 6]);
    bytes.size(1);
    bytes.ints(&[1]);
    bytes.size(0);
    bytes.text("\n$EndEntities\n");
}

fn files(drawing: &Drawing) -> [Vec<u8>; 4] {
    let [small, large] = [false, true];
    [
        msh2(drawing, small),
        msh2(drawing, large),
        msh4(drawing, small),
        msh4(drawing, large),
    ]
}

fn body(bytes: &[u8]) -> Mesh {
    parse(bytes, 1e-3).unwrap_or_else(|error| panic!("{error}"))
}

#[test]
fn a_binary_file_is_the_body_of_its_text_bit_for_bit() {
    for drawing in [fan(3), fan(5), fan(4).refined(3)] {
        let text = body(drawing.msh2().as_bytes());
        assert_eq!(body(drawing.msh4().as_bytes()), text);
        for bytes in files(&drawing) {
            assert_eq!(body(&bytes), text);
        }
    }
}

#[test]
fn files_from_gmsh_are_read() {
    let [two, four] = [
        &include_bytes!("reference/gmsh_2.2_binary.msh")[..],
        &include_bytes!("reference/gmsh_4.1_binary.msh")[..],
    ]
    .map(|bytes| parse(bytes, 1.0).unwrap_or_else(|error| panic!("{error}")));
    assert_eq!(two, four);
    assert_eq!((two.elements(), two.points.len()), (16, 25));
    assert_eq!(two.sets(), ["body", "bottom", "left", "right", "top"]);
    let right = two.set("right").expect("a group");
    let points = right.iter().map(|node| two.point(node[0], node[1]));
    assert!(points.clone().all(|[x, _]| x == 4.0) && points.count() == 5);
}

#[test]
fn errors_in_a_binary_file_are_named() {
    let with = |from: &[u8], to: &[u8], bytes: &[u8]| {
        let at = bytes.windows(from.len()).position(|w| w == from);
        let at = at.expect("it is there");
        let changed = [&bytes[..at], to, &bytes[at + from.len()..]].concat();
        parse(changed, 1.0).expect_err("it must be refused")
    };
    for bytes in files(&fan(3)) {
        let says = |from: &[u8], to: &[u8], words: &str| {
            let message = with(from, to, &bytes).to_string();
            assert!(message.contains(words), "{message}");
        };
        says(b" 1 8\n", b" 1 4\n", "of 4 bytes; only 8");
        says(b"$EndNodes", b"$EndMoles", "$Nodes should end");
        says(b"$PhysicalNames", b"$Nodes", "$Nodes");
        let cut = parse(&bytes[..bytes.len() - 40], 1.0).expect_err("it is cut");
        assert!(cut.problem.contains("the file is truncated"), "{cut}");
    }
    // The first header of the 2.2 file becomes a header of triangles.
    let [two, ..] = files(&fan(3));
    let lines: Vec<u8> = [1i32, 6, 2].iter().flat_map(|k| k.to_le_bytes()).collect();
    let triangles: Vec<u8> = [2i32, 6, 2].iter().flat_map(|k| k.to_le_bytes()).collect();
    let error = with(&lines, &triangles, &two);
    assert!(error.to_string().contains("a 3-node triangle"), "{error}");
}

#[test]
fn damaged_bytes_never_cause_a_panic() {
    let (mut random, mut refused) = (0x9e37_79b9_7f4a_7c15_u64, 0);
    let mut next = |below: usize| {
        random ^= random << 13;
        random ^= random >> 7;
        random ^= random << 17;
        (random % below as u64) as usize
    };
    for whole in files(&fan(3)) {
        for _ in 0..2_000 {
            let mut bytes = whole.clone();
            for _ in 0..=next(3) {
                let at = next(bytes.len());
                match next(4) {
                    0 | 1 => bytes[at] = next(256) as u8,
                    2 => drop(bytes.remove(at)),
                    _ => bytes.truncate(at.max(1)),
                }
            }
            refused += usize::from(parse(&bytes, 1.0).is_err());
        }
    }
    assert!((4_000..8_000).contains(&refused), "{refused}");
}
