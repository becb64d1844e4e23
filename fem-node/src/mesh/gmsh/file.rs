//! Content of a file of either version: nodes, lines, quadrilaterals, names of physical groups.

use std::collections::{BTreeMap, HashMap};

use kit::ConfigError;

use super::error::{beginning, damaged, no_quadrilaterals, other_form};
use super::text::{Words, sections};

/// Dimension and number of a physical group, or of a part of the geometry.
pub(super) type Entity = (u8, i64);

/// Content of a file.
#[derive(Clone, Debug, Default)]
pub(super) struct File {
    /// The file's numbers of the nodes, and their coordinates.
    pub(super) nodes: Vec<(u64, [f64; 3])>,
    /// Positions in `nodes` by number.
    positions: HashMap<u64, u32>,
    pub(super) lines: Vec<FileElement<2>>,
    pub(super) quads: Vec<FileElement<4>>,
    /// Names of physical groups.
    pub(super) names: BTreeMap<Entity, String>,
}

/// An element with N corners.
#[derive(Clone, Debug)]
pub(super) struct FileElement<const N: usize> {
    pub(super) number: u64,
    /// Positions in [`File::nodes`].
    pub(super) corners: [u32; N],
    /// Physical groups of the element.
    pub(super) groups: Vec<i64>,
}

impl FileElement<4> {
    /// Its sides, in the order of its corners.
    pub(super) fn sides(&self) -> [[u32; 2]; 4] {
        [0, 1, 2, 3].map(|k| [self.corners[k], self.corners[(k + 1) % 4]])
    }
}

/// The supported versions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Version {
    Two,
    Four,
}

impl File {
    pub(super) fn parse(text: &str) -> Result<File, ConfigError> {
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
        let required = |section| {
            let missing = || damaged(format!("it has no section ${section}"));
            only(&sections, section)?.ok_or_else(missing)
        };
        file.read_nodes(version, required("Nodes")?)?;
        file.read_elements(version, required("Elements")?, &groups)?;
        Ok(file)
    }

    /// The file's number of a node, by its position in [`File::nodes`].
    pub(super) fn number(&self, node: u32) -> u64 {
        self.nodes[node as usize].0
    }

    /// Coordinates of a node in the plane, by its position in [`File::nodes`].
    pub(super) fn point(&self, node: u32) -> [f64; 2] {
        let [x, y, _] = self.nodes[node as usize].1;
        [x, y]
    }

    fn read_names(&mut self, mut words: Words) -> Result<(), ConfigError> {
        let count: usize = words.integer("the number of names")?;
        for _ in 0..count {
            let dimension = words.integer("the dimension of a group")?;
            let number = words.integer("the number of a group")?;
            let name = words.word("the name of a group")?;
            self.names.insert((dimension, number), name.into());
        }
        words.end(count)
    }

    fn read_nodes(&mut self, version: Version, mut words: Words) -> Result<(), ConfigError> {
        let names = ["the number of nodes or blocks", "the number of nodes"];
        let [parts, announced] = parts(&mut words, version, names)?;
        for _ in 0..parts {
            if version == Version::Four {
                self.read_node_block(&mut words)?;
            } else {
                let number = words.integer("the number of a node")?;
                self.read_node(&mut words, number, 0)?;
            }
        }
        words.end(announced)
    }

    fn read_node_block(&mut self, words: &mut Words) -> Result<(), ConfigError> {
        let dimension: usize = words.integer("the dimension of a block")?;
        words.skip(1, "the number of a block")?;
        let parametric: u8 = words.integer("0 or 1, whether nodes have parameters")?;
        let count: usize = words.integer("the number of nodes of a block")?;
        let parameters = if parametric == 0 { 0 } else { dimension };
        // The numbers come first.
        let mut numbers = words.integers(count, "the number of a node")?.into_iter();
        numbers.try_for_each(|number| self.read_node(words, number, parameters))
    }

    fn read_node(
        &mut self,
        words: &mut Words,
        number: u64,
        parameters: usize,
    ) -> Result<(), ConfigError> {
        let point = [words.number()?, words.number()?, words.number()?];
        words.skip(parameters, "a parameter of the node")?;
        let position = self.nodes.len() as u32;
        self.nodes.push((number, point));
        match self.positions.insert(number, position) {
            None => Ok(()),
            Some(_) => Err(damaged(format!(
                "line {}: node {number} is defined a second time",
                words.line
            ))),
        }
    }

    fn read_elements(
        &mut self,
        version: Version,
        mut words: Words,
        groups: &HashMap<Entity, Vec<i64>>,
    ) -> Result<(), ConfigError> {
        let names = ["the number of elements or blocks", "the number of elements"];
        let [parts, announced] = parts(&mut words, version, names)?;
        for _ in 0..parts {
            if version == Version::Four {
                self.read_element_block(&mut words, groups)?;
            } else {
                self.read_tagged_element(&mut words)?;
            }
        }
        words.end(announced)
    }

    fn read_tagged_element(&mut self, words: &mut Words) -> Result<(), ConfigError> {
        let number = words.integer("the number of an element")?;
        let kind = words.integer("the type of an element")?;
        let tags: usize = words.integer("the number of tags")?;
        let group: i64 = match tags {
            0 => 0,
            _ => words.integer("a physical group")?,
        };
        words.skip(tags.saturating_sub(1), "a tag")?;
        // A group with its sign turned is the same group walked along backwards.
        self.read_element(words, number, kind, &[group.saturating_abs()])
    }

    fn read_element_block(
        &mut self,
        words: &mut Words,
        groups: &HashMap<Entity, Vec<i64>>,
    ) -> Result<(), ConfigError> {
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
    ) -> Result<(), ConfigError> {
        match kind {
            1 => self.lines.push(self.element(words, number, groups)?),
            3 => self.quads.push(self.element(words, number, groups)?),
            // Points carry nothing that a body needs.
            15 => words.skip(1, "a node")?,
            other => {
                let (line, kind) = (words.line, name_of(other));
                return Err(no_quadrilaterals(format!(
                    "line {line}: element {number} is {kind}; a body consists of 4-node quadrilaterals"
                )));
            }
        }
        Ok(())
    }

    fn element<const N: usize>(
        &self,
        words: &mut Words,
        element: u64,
        groups: &[i64],
    ) -> Result<FileElement<N>, ConfigError> {
        let mut corners = [0; N];
        for corner in &mut corners {
            let node = words.integer("the number of a node")?;
            let known = self.positions.get(&node);
            *corner = *known.ok_or_else(|| {
                let line = words.line;
                damaged(format!(
                    "line {line}: element {element} names node {node}, which is not in $Nodes"
                ))
            })?;
        }
        Ok(FileElement {
            number: element,
            corners,
            groups: groups.iter().copied().filter(|group| *group != 0).collect(),
        })
    }
}

/// The version, which the first section states.
fn version(lines: &[&str]) -> Result<Version, ConfigError> {
    let mut lines = lines
        .iter()
        .map(|line| line.trim())
        .filter(|line| !line.is_empty());
    let first = lines.next().unwrap_or_default();
    if first != "$MeshFormat" {
        let found = beginning(first);
        return Err(other_form(format!(
            "it begins with {found:?} and not with $MeshFormat"
        )));
    }
    let mut words = lines.next().unwrap_or_default().split_whitespace();
    let version = words.next().unwrap_or_default();
    let known = match version {
        "2.2" | "2" => Version::Two,
        "4.1" => Version::Four,
        other => {
            return Err(other_form(format!(
                "it is of version {}; only 2.2 and 4.1 are supported",
                beginning(other)
            )));
        }
    };
    match words.next() {
        Some("0") => Ok(known),
        other => Err(other_form(format!(
            "its file type is {:?}, neither 0 (ASCII) nor 1 (binary)",
            beginning(other.unwrap_or_default())
        ))),
    }
}

/// The section of this name; a second one is refused.
fn only<'a>(sections: &[Words<'a>], name: &str) -> Result<Option<Words<'a>>, ConfigError> {
    let mut found = sections.iter().filter(|words| words.section == name);
    let first = found.next().cloned();
    match found.next() {
        None => Ok(first),
        Some(second) => Err(damaged(format!(
            "line {}: a second section ${name}",
            second.line
        ))),
    }
}

/// Number of parts of a section (blocks in 4.1) and of the entries that it announces; `names` describe the two numbers.
fn parts(
    words: &mut Words,
    version: Version,
    names: [&'static str; 2],
) -> Result<[usize; 2], ConfigError> {
    let parts = words.integer(names[0])?;
    if version == Version::Two {
        return Ok([parts, parts]);
    }
    let announced = words.integer(names[1])?;
    words.skip(2, "the range of numbers")?;
    Ok([parts, announced])
}

/// Physical groups of the parts of the geometry (4.1): points have three coordinates, all other parts a box of six and a list of their boundary.
fn groups_of_entities(mut words: Words) -> Result<HashMap<Entity, Vec<i64>>, ConfigError> {
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
            let mut own: Vec<i64> = words.integers(tags, "a physical group")?;
            own.iter_mut()
                .for_each(|group| *group = group.saturating_abs());
            groups.insert((dimension, part), own);
            if dimension > 0 {
                let boundary = words.integer("the number of bounding parts")?;
                words.skip(boundary, "a bounding part")?;
            }
        }
    }
    words.end(counts.iter().sum())?;
    Ok(groups)
}

/// Elements from other settings of Gmsh, by type number.
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
