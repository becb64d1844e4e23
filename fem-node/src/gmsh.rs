//! Meshes of quadrilaterals that Gmsh wrote: MSH 2.2 and 4.1, ASCII.
//!
//! Format: Geuzaine and Remacle, Gmsh reference manual, "MSH file format" (4.1) and "MSH file format version 2 (Legacy)".
//!
//! - `text`: words with their lines, sections by their names;
//! - `file`: what both versions say, nodes, elements and named physical groups;
//! - `lines`: groups of lines, as one walks along them;
//! - `body`: the checks that make a body of it.
//!
//! Every physical group with a name becomes a node set: lines are walked along, a surface gives all of its nodes.
//! Clockwise elements are turned, nodes of no element are dropped, points and groups without a name are ignored. What
//! cannot be computed with is refused: other elements, folded or repeated ones, two nodes in one place, a third dimension.

mod body;
mod error;
mod file;
mod lines;
mod text;

use std::path::Path;

use protocol::ConfigError;

use crate::config::GmshConfig;
use crate::mesh::Mesh;

pub use error::GmshError;

/// The key that names the file.
const KEY: &str = "mesh.gmsh";

/// Reads the mesh of a scenario.
pub fn read(config: &GmshConfig) -> Result<Mesh, ConfigError> {
    let text = load(&config.gmsh)?;
    parse(&text, config.length_unit_m).map_err(|error| {
        let problem = format!("{}: {error}", config.gmsh.display());
        ConfigError::new(KEY, problem).help(error.help())
    })
}

/// A mesh from the text of a file, whose unit is this long (m).
pub fn parse(text: &str, length_unit: f64) -> Result<Mesh, GmshError> {
    body::build(&file::File::parse(text)?, length_unit)
}

fn load(path: &Path) -> Result<String, ConfigError> {
    let bytes = std::fs::read(path).map_err(|error| {
        let problem = format!("{} cannot be read: {error}", path.display());
        ConfigError::new(KEY, problem)
            .help("give the path of a .msh file, from the folder of the scenario or from the root")
    })?;
    String::from_utf8(bytes).map_err(|_| {
        let problem = format!("{} is no text: binary files are not read", path.display());
        ConfigError::new(KEY, problem).help(error::SAVE_AS_TEXT)
    })
}
