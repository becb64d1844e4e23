//! The command `thirdbody`: one file per verb, on top of crates that form layers.
//!
//! # Layers
//!
//! A crate depends only on crates above it in the table; its `Cargo.toml` lists them.
//!
//! | crate | contents |
//! |---|---|
//! | `scheme` | coupling schemes, mapping, compliance, ledgers, prediction of stability: equations, no process, no file |
//! | [`exchange_log`] | the log of all interface messages of a run: written, read, hashed, exported |
//! | [`scenes`] | the scenes and studies built into the program |
//! | [`scenario`] | the scenario file: keys, overrides, checks, and errors that point into it |
//! | [`runs`] | run directories: their files, written and read, and the verdict on a run |
//! | [`coordinator`] | participants, the loop over windows, checkpoints, summary; a listener receives the events |
//! | [`terminal`] | messages and progress on stderr |
//! | `draw` | curves, axes and colours as SVG |
//! | [`report`], [`study`] | pages of a run; many runs |
//! | [`lab`] | replay, conformance, validation, benchmarks |
//! | [`cli`] | the verbs |
//!
//! The library contains no solver: the binary passes in its [`coordinator::participants::Registry`].

pub mod cli;

kit::inventory::submit! {
    runs::identity::Build {
        hash: env!("THIRDBODY_BUILD"),
        git: env!("THIRDBODY_GIT"),
    }
}
