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
//! | [`coordinator`] | scenario, participants, the loop over windows, checkpoints, output, summary |
//! | `draw` | curves, axes and colours as SVG |
//! | [`runs`] | the one reader of run directories |
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
