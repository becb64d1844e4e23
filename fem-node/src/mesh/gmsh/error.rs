//! Refusals of a mesh file, with advice to the user.

use kit::ConfigError;
use protocol::Cause;

/// The key that names the file.
pub(super) const KEY: &str = "mesh.gmsh";

/// A file without a usable body.
pub(super) fn refused(problem: String, help: &str) -> ConfigError {
    ConfigError::new(KEY, problem)
        .because(Cause::FileUnsuitable)
        .help(help)
}

/// A file whose content contradicts itself.
pub(super) fn damaged(problem: String) -> ConfigError {
    refused(problem, "the file is damaged: save it again")
}

/// A file in an unsupported form.
pub(super) fn other_form(problem: String) -> ConfigError {
    refused(
        problem,
        "save it with `gmsh FILE -2 -format msh41` or msh22",
    )
}

/// A file without usable elements.
pub(super) fn no_quadrilaterals(problem: String) -> ConfigError {
    refused(
        problem,
        "recombine the surfaces (`Recombine Surface {:};`, Mesh.RecombineAll = 1, Mesh.SubdivisionAlgorithm = 1 leaves no triangle) and keep Mesh.ElementOrder = 1; a surface must be in a physical group to be saved",
    )
}

/// A file that ends inside a section.
pub(super) fn truncated(section: &str) -> ConfigError {
    damaged(format!("it ends inside ${section}: the file is truncated"))
}

/// The beginning of a misplaced text.
pub(super) fn beginning(text: &str) -> String {
    text.chars().take(40).collect()
}
