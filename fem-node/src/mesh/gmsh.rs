//! Meshes of quadrilaterals from Gmsh: MSH 2.2 and 4.1, ASCII or binary.
//!
//! Format: Geuzaine and Remacle, Gmsh reference manual, "MSH file format" (4.1) and "MSH file format version 2 (Legacy)".
//!
//! - `binary`: binary files converted to text;
//! - `text`: words with their lines, sections by their names;
//! - `file`: the content in either version, nodes, elements and named physical groups;
//! - `joints`: parts that touch without being joined;
//! - `lines`: groups of lines, joined to polylines;
//! - `body`: the checks, and the body.
//!
//! Every physical group with a name becomes a node set: lines give polylines, a surface gives all of its nodes. Clockwise elements are reversed,
//! nodes of no element are dropped, points and groups without a name are ignored. The reader refuses what a body cannot use: other elements, folded,
//! repeated or overlapping ones, nodes in one place or on a side of another element, a third dimension.

mod binary;
mod body;
mod error;
mod file;
mod joints;
mod lines;
mod text;

use fem_kernel::mesh::Mesh;
use kit::ConfigError;
use kit::input_file::content;
use protocol::Cause;

use crate::config::mesh::GmshConfig;
use error::{KEY, other_form};

/// Reads the mesh of a scenario.
pub fn read(config: &GmshConfig) -> Result<Mesh, ConfigError> {
    let bytes = content(&config.gmsh, LONGEST_FILE).map_err(|error| {
        let problem = format!("{} cannot be read: {error}", config.gmsh.display());
        ConfigError::new(KEY, problem)
            .because(Cause::FileUnreadable)
            .help("give the path of a .msh file, from the folder of the scenario or from the root")
    })?;
    parse(&bytes, config.length_unit_m).map_err(|error| {
        let form = if binary::is_binary(&bytes) {
            " (binary; line numbers refer to its ASCII form)"
        } else {
            ""
        };
        let problem = format!("{}{form}: {}", config.gmsh.display(), error.problem);
        ConfigError { problem, ..error }
    })
}

/// Longest mesh file (bytes): some ten million elements.
const LONGEST_FILE: u64 = 2 << 30;

/// A mesh from the content of a file, whose unit is this long (m).
pub fn parse(content: impl AsRef<[u8]>, length_unit: f64) -> Result<Mesh, ConfigError> {
    let bytes = content.as_ref();
    let file = if binary::is_binary(bytes) {
        file::File::parse(&binary::to_text(bytes)?)?
    } else {
        let no_text = |_| other_form("it is not text and is not declared binary".into());
        file::File::parse(str::from_utf8(bytes).map_err(no_text)?)?
    };
    body::build(&file, length_unit)
}
