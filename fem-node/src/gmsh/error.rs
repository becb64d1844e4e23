//! Errors of a mesh file.

use thiserror::Error;

/// Advice to save a file in a form that can be read.
const SAVE_AGAIN: &str = "save it with `gmsh FILE -2 -format msh41` or msh22";

/// Reason why a file gives no body.
#[derive(Clone, Debug, Error, PartialEq)]
#[allow(missing_docs)]
pub enum GmshError {
    #[error("it begins with {found:?} and not with $MeshFormat")]
    NoFormat { found: String },
    #[error("it is of version {version}, only 2.2 and 4.1 are read")]
    Version { version: String },
    #[error("it is no text and does not say that it is binary")]
    NoText,
    #[error("its file type is {found:?}, neither 0 (ASCII) nor 1 (binary)")]
    FileType { found: String },
    #[error("it is binary with counts or numbers of {size} bytes, only 8 are read")]
    DataSize { size: String },
    #[error("it says that it is binary, but no 1 of 4 bytes follows")]
    NoOne,
    #[error("byte {byte}: ${section} should end or go on in another way there")]
    Misplaced { byte: usize, section: String },
    #[error("it ends inside ${section}: the file is truncated")]
    Truncated { section: String },
    #[error("it has no section ${section}")]
    NoSection { section: &'static str },
    #[error("line {line}: a second section ${section}")]
    SecondSection { line: usize, section: &'static str },
    #[error("line {line}: {what} is expected, {found:?} stands there")]
    Word {
        line: usize,
        what: &'static str,
        found: String,
    },
    #[error("line {line}: {what} is expected, but ${section} ends there")]
    SectionEnds {
        line: usize,
        what: &'static str,
        section: String,
    },
    #[error("line {line}: ${section} goes on where {announced} entries have been read")]
    TooMuch {
        line: usize,
        section: &'static str,
        announced: usize,
    },
    #[error("line {line}: node {node} is defined a second time")]
    NodeTwice { line: usize, node: u64 },
    #[error("line {line}: element {element} names node {node}, which is not in $Nodes")]
    UnknownNode {
        line: usize,
        element: u64,
        node: u64,
    },
    #[error("line {line}: element {element} is {kind}; a body consists of 4-node quadrilaterals")]
    OtherElement {
        line: usize,
        element: u64,
        kind: String,
    },
    #[error("it holds no quadrilaterals")]
    NoElements,
    #[error("its elements do not lie in one plane z = const: z goes from {low:?} to {high:?}")]
    NotPlane { low: f64, high: f64 },
    #[error("element {element} is {how} at node {node}, ({x:?}, {y:?}) in the file's unit")]
    Folded {
        element: u64,
        node: u64,
        how: &'static str,
        x: f64,
        y: f64,
    },
    #[error("nodes {first} and {second} lie in one place, ({x:?}, {y:?}) in the file's unit")]
    SamePlace {
        first: u64,
        second: u64,
        x: f64,
        y: f64,
    },
    #[error("elements {first} and {second} overlap: both lie on one side of nodes {a} and {b}")]
    Overlap {
        first: u64,
        second: u64,
        a: u64,
        b: u64,
    },
    #[error("line element {element} of the group `{group}` is no side of any quadrilateral")]
    LooseLine { element: u64, group: String },
    #[error("the group `{group}` branches at node {node}")]
    Branch { group: String, node: u64 },
    #[error(
        "two physical groups, of lines and of surfaces or with two numbers, are named `{group}`"
    )]
    GroupTwice { group: String },
    #[error("the body would be {size_m:.3e} m large")]
    Size { size_m: f64 },
}

impl GmshError {
    /// Advice to the user.
    pub fn help(&self) -> &'static str {
        match self {
            GmshError::NoFormat { .. }
            | GmshError::Version { .. }
            | GmshError::NoText
            | GmshError::FileType { .. }
            | GmshError::DataSize { .. } => SAVE_AGAIN,
            GmshError::OtherElement { .. } | GmshError::NoElements => {
                "recombine the surfaces (`Recombine Surface {:};`, Mesh.RecombineAll = 1, Mesh.SubdivisionAlgorithm = 1 leaves no triangle) and keep Mesh.ElementOrder = 1; a surface must be in a physical group to be saved"
            }
            GmshError::Size { .. } => {
                "mesh.length_unit_m is the length of the file's unit: 1e-3 for millimetres"
            }
            GmshError::NotPlane { .. } => "draw the body in the plane z = 0",
            GmshError::Folded { .. } => {
                "smooth or refine the mesh there (Mesh.Smoothing, Mesh.RecombinationAlgorithm): every corner must be convex"
            }
            GmshError::SamePlace { .. } => {
                "join the parts (`Coherence;`, `Coherence Mesh;`): nodes in one place would leave a crack"
            }
            GmshError::Overlap { .. } => "mesh every part of the body once",
            GmshError::LooseLine { .. } => {
                "a group of lines must lie on the outline of a meshed surface, or inside it along sides of elements"
            }
            GmshError::Branch { .. } => "give each branch a physical group of its own",
            GmshError::GroupTwice { .. } => "rename one of them",
            GmshError::NoOne
            | GmshError::Misplaced { .. }
            | GmshError::Truncated { .. }
            | GmshError::NoSection { .. }
            | GmshError::SecondSection { .. }
            | GmshError::Word { .. }
            | GmshError::SectionEnds { .. }
            | GmshError::TooMuch { .. }
            | GmshError::NodeTwice { .. }
            | GmshError::UnknownNode { .. } => "the file is damaged: save it again",
        }
    }
}
