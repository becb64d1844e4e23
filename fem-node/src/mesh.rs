//! The mesh of a scenario, and its sets that keys name.
//!
//! - [`graded`]: structured meshes from a few numbers;
//! - [`gmsh`]: meshes written by Gmsh.

pub mod gmsh;
pub mod graded;

use fem_kernel::mesh::Mesh;
use kit::ConfigError;
use protocol::Cause;

/// The nodes of the set that a key names; the help lists the sets and other valid names.
pub(crate) fn named_set(
    mesh: &Mesh,
    name: &str,
    key: &str,
    besides: &str,
) -> Result<Vec<[usize; 2]>, ConfigError> {
    mesh.set(name).ok_or_else(|| {
        ConfigError::new(key, "is not a set of the mesh")
            .because(Cause::UnknownName)
            .help(listed_sets(mesh) + besides)
    })
}

/// The sets as messages list them.
pub(crate) fn listed_sets(mesh: &Mesh) -> String {
    match mesh.sets().as_slice() {
        [] => "the mesh has no named physical group of lines or surfaces".into(),
        sets => format!("its sets are {}", sets.join(", ")),
    }
}
