//! The command `thirdbody`: a verb a file, over crates that are layers.
//!
//! # Layers
//!
//! Each names only those before it; which ones it may name stands in its `Cargo.toml`.
//!
//! | crate | what it is |
//! |---|---|
//! | `scheme` | coupling schemes, mapping, compliance, ledgers, prediction of stability: equations, no process, no file |
//! | [`exchange_log`] | every interface message of a run: written, read, hashed, exported |
//! | [`scenes`] | the shipped scenes and studies, inside the program |
//! | [`scenario`] | the file of a run: its keys, overrides, checks, and the errors that point into it |
//! | [`runs`] | run directories: all files of one, written and read, and the judgement of its end |
//! | [`coordinator`] | participants, the loop over windows, checkpoints, summary; what happens goes to a listener |
//! | [`terminal`] | words and progress on stderr |
//! | `draw` | curves, axes and colours as SVG |
//! | [`report`], [`study`] | pages of one run; many runs |
//! | [`lab`] | replay, conformance, validation, benchmarks |
//! | [`cli`] | the verbs |
//!
//! The library knows no solver: the binary hands its [`coordinator::participants::Registry`] in.

pub mod cli;

kit::inventory::submit! {
    runs::identity::Build {
        hash: env!("THIRDBODY_BUILD"),
        git: env!("THIRDBODY_GIT"),
    }
}
