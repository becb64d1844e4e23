//! Content of a file of either version: nodes, lines, quadrilaterals, names of physical groups.

use std::collections::{BTreeMap, HashMap};

use super::GmshError;
use super::text::{Section, Words, sections};

/// Dimension and number of a physical group, or of a part of the geometry.
pub(super) type Entity = (u8, i64);

/// Content of a file.
#[derive(Clone, Debug, Default)]
pub(super) struct File {
    /// Numbers that the file gives its nodes, and their coordinates.
    pub(super) nodes: Vec<(u64, [f64; 3])>,
    /// Positions in `nodes` by number.
    positions: HashMap<u64, u32>,
    pub(super) lines: Vec<Element<2>>,
    pub(super) quads: Vec<Element<4>>,
    /// Names of physical groups.
    pub(super) names: BTreeMap<Entity, String>,
}

/// An element with N corners.
#[derive(Clone, Debug)]
pub(super) struct Element<const N: usize> {
    pub(super) number: u64,
    /// Positions in [`File::nodes`].
    pub(super) corners: [u32; N],
    /// Physical groups that it belongs to.
    pub(super) groups: Vec<i64>,
}

/// The versions that are read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Version {
    Two,
    Four,
}

impl File {
    pub(super) fn parse(text: &str) -> Result<File, GmshError> {
        let lines: Vec<&str> = text.lines().collect();
        let version = version(&lines)?;
        let sections = sections(&lines)?;
        let mut file = File::default();
        if let Some(names) = only(&sections, "PhysicalNames")? {
            file.read_names(names)?;
        }
        let groups = match only(&sections, "Entities")? {
            Some(entities) if version == Version::Four => groups_of_entities(entities)?,
            _ => HashMap::new(),
        };
        let required = |section| only(&sections, section)?.ok_or(GmshError::NoSection { section });
        file.read_nodes(version, required("Nodes")?)?;
        file.read_elements(version, required("Elements")?, &groups)?;
        Ok(file)
    }

    /// Coordinates of a node in the plane, by its position in [`File::nodes`].
    pub(super) fn point(&self, node: u32) -> [f64; 2] {
        let [x, y, _] = self.nodes[node as usize].1;
        [x, y]
    }

    fn read_names(&mut self, section: &Section) -> Result<(), GmshError> {
        let mut words = section.words();
        let count: usize = words.integer("the number of names")?;
        for _ in 0..count {
            let dimension = words.integer("the dimension of a group")?;
            let number = words.integer("the number of a group")?;
            let name = words.word("the name of a group")?;
            self.names.insert((dimension, number), name.into());
        }
        words.end("PhysicalNames", count)
    }

    fn read_nodes(&mut self, version: Version, section: &Section) -> Result<(), GmshError> {
        let mut words = section.words();
        let mut announced: usize = words.integer("the number of nodes or blocks")?;
        match version {
            Version::Two => {
                for _ in 0..announced {
                    let number = words.integer("the number of a node")?;
                    let point = [words.number()?, words.number()?, words.number()?];
                    self.add_node(words.line, number, point)?;
                }
            }
            Version::Four => {
                let blocks = announced;
                announced = words.integer("the number of nodes")?;
                words.skip(2, "the range of numbers")?;
                for _ in 0..blocks {
                    self.read_node_block(&mut words)?;
                }
            }
        }
        words.end("Nodes", announced)
    }

    fn read_node_block(&mut self, words: &mut Words) -> Result<(), GmshError> {
        let dimension: usize = words.integer("the dimension of a block")?;
        words.skip(1, "the number of a block")?;
        let parametric: u8 = words.integer("0 or 1, whether nodes have parameters")?;
        let count: usize = words.integer("the number of nodes of a block")?;
        // The numbers come first. Nothing is reserved for what the file only promises.
        let mut numbers: Vec<u64> = Vec::new();
        for _ in 0..count {
            numbers.push(words.integer("the number of a node")?);
        }
        for number in numbers {
            let point = [words.number()?, words.number()?, words.number()?];
            if parametric != 0 {
                words.skip(dimension, "a parameter of the node")?;
            }
            self.add_node(words.line, number, point)?;
        }
        Ok(())
    }

    fn add_node(&mut self, line: usize, number: u64, point: [f64; 3]) -> Result<(), GmshError> {
        let position = self.nodes.len() as u32;
        self.nodes.push((number, point));
        match self.positions.insert(number, position) {
            None => Ok(()),
            Some(_) => Err(GmshError::NodeTwice { line, node: number }),
        }
    }

    fn read_elements(
        &mut self,
        version: Version,
        section: &Section,
        groups: &HashMap<Entity, Vec<i64>>,
    ) -> Result<(), GmshError> {
        let mut words = section.words();
        let mut announced: usize = words.integer("the number of elements or blocks")?;
        match version {
            Version::Two => {
                for _ in 0..announced {
                    let number = words.integer("the number of an element")?;
                    let kind = words.integer("the type of an element")?;
                    let tags: usize = words.integer("the number of tags")?;
                    let group: i64 = match tags {
                        0 => 0,
                        _ => words.integer("a physical group")?,
                    };
                    words.skip(tags.saturating_sub(1), "a tag")?;
                    // A group with its sign turned is the same group walked along backwards.
                    self.read_element(&mut words, number, kind, &[group.saturating_abs()])?;
                }
            }
            Version::Four => {
                let blocks = announced;
                announced = words.integer("the number of elements")?;
                words.skip(2, "the range of numbers")?;
                for _ in 0..blocks {
                    self.read_element_block(&mut words, groups)?;
                }
            }
        }
        words.end("Elements", announced)
    }

    fn read_element_block(
        &mut self,
        words: &mut Words,
        groups: &HashMap<Entity, Vec<i64>>,
    ) -> Result<(), GmshError> {
        let dimension = words.integer("the dimension of a block")?;
        let part = words.integer("the number of a block")?;
        let kind = words.integer("the type of the elements of a block")?;
        let count: usize = words.integer("the number of elements of a block")?;
        let groups = groups.get(&(dimension, part));
        let groups = groups.map_or(&[][..], Vec::as_slice);
        for _ in 0..count {
            let number = words.integer("the number of an element")?;
            self.read_element(words, number, kind, groups)?;
        }
        Ok(())
    }

    fn read_element(
        &mut self,
        words: &mut Words,
        number: u64,
        kind: u32,
        groups: &[i64],
    ) -> Result<(), GmshError> {
        match kind {
            1 => {
                let element = self.element(words, number, groups)?;
                self.lines.push(element);
            }
            3 => {
                let element = self.element(words, number, groups)?;
                self.quads.push(element);
            }
            // Points carry nothing that a body needs.
            15 => words.skip(1, "a node")?,
            other => {
                return Err(GmshError::OtherElement {
                    line: words.line,
                    element: number,
                    kind: name_of(other),
                });
            }
        }
        Ok(())
    }

    fn element<const N: usize>(
        &self,
        words: &mut Words,
        element: u64,
        groups: &[i64],
    ) -> Result<Element<N>, GmshError> {
        let mut corners = [0; N];
        for corner in &mut corners {
            let node = words.integer("the number of a node")?;
            let unknown = GmshError::UnknownNode {
                line: words.line,
                element,
                node,
            };
            *corner = *self.positions.get(&node).ok_or(unknown)?;
        }
        Ok(Element {
            number: element,
            corners,
            groups: groups.iter().copied().filter(|group| *group != 0).collect(),
        })
    }
}

/// The version, which the first section states.
fn version(lines: &[&str]) -> Result<Version, GmshError> {
    let mut lines = lines
        .iter()
        .map(|line| line.trim())
        .filter(|line| !line.is_empty());
    let first = lines.next().unwrap_or_default();
    if first != "$MeshFormat" {
        return Err(GmshError::NoFormat {
            found: first.chars().take(40).collect(),
        });
    }
    let mut words = lines.next().unwrap_or_default().split_whitespace();
    let version = words.next().unwrap_or_default();
    let known = match version {
        "2.2" | "2" => Version::Two,
        "4.1" => Version::Four,
        other => {
            return Err(GmshError::Version {
                version: other.chars().take(40).collect(),
            });
        }
    };
    match words.next() {
        Some("0") => Ok(known),
        other => Err(GmshError::FileType {
            found: other.unwrap_or_default().chars().take(40).collect(),
        }),
    }
}

/// The section of this name, of which there may be one.
fn only<'a, 's>(
    sections: &'s [Section<'a>],
    name: &'static str,
) -> Result<Option<&'s Section<'a>>, GmshError> {
    let mut found = sections.iter().filter(|section| section.name == name);
    let first = found.next();
    match found.next() {
        None => Ok(first),
        Some(second) => Err(GmshError::SecondSection {
            line: second.line,
            section: name,
        }),
    }
}

/// Physical groups of the parts of the geometry (4.1): points have three coordinates, all others a box of six, and
/// those that have a boundary list it.
fn groups_of_entities(section: &Section) -> Result<HashMap<Entity, Vec<i64>>, GmshError> {
    let mut words = section.words();
    let mut counts = [0usize; 4];
    for count in &mut counts {
        *count = words.integer("the number of parts of the geometry")?;
    }
    let mut groups = HashMap::new();
    for (dimension, count) in (0u8..).zip(counts) {
        for _ in 0..count {
            let part: i64 = words.integer("the number of a part of the geometry")?;
            words.skip(if dimension == 0 { 3 } else { 6 }, "a coordinate")?;
            let tags: usize = words.integer("the number of physical groups")?;
            let mut own: Vec<i64> = Vec::new();
            for _ in 0..tags {
                let group: i64 = words.integer("a physical group")?;
                own.push(group.saturating_abs());
            }
            groups.insert((dimension, part), own);
            if dimension > 0 {
                let boundary = words.integer("the number of bounding parts")?;
                words.skip(boundary, "a bounding part")?;
            }
        }
    }
    words.end("Entities", counts.iter().sum())?;
    Ok(groups)
}

/// Elements that other settings give, by their type number.
fn name_of(kind: u32) -> String {
    let name = match kind {
        2 => "a 3-node triangle",
        4 => "a tetrahedron",
        5 => "a hexahedron",
        6 => "a prism",
        7 => "a pyramid",
        8 => "a 3-node line of second order",
        9 => "a 6-node triangle of second order",
        10 | 16 => "a quadrilateral of second order",
        _ => return format!("of type {kind}"),
    };
    name.into()
}
