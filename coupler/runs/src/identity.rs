//! The build of a run. The binary provides it, so that a change to a solver recompiles none of the crates that write or
//! read runs.

use kit::inventory;

/// A build of the program.
#[derive(Clone, Copy, Debug)]
pub struct Build {
    /// Hash of its sources, locked dependencies and compiler, in hexadecimal.
    pub hash: &'static str,
    /// The version that git names.
    pub git: &'static str,
}

inventory::collect!(Build);

/// The build of this program. A test of a single crate has an unnamed build.
pub fn build() -> Build {
    let unnamed = Build {
        hash: "unnamed",
        git: "unknown",
    };
    *inventory::iter::<Build>().next().unwrap_or(&unnamed)
}
