//! The composition root: only this file names the shipped solvers.

use std::process::ExitCode;

use coordinator::participants::{Registry, ShippedSolver};

fn main() -> ExitCode {
    let registry = Registry {
        solvers: vec![
            ShippedSolver {
                kind: "fem",
                check: fem_node::check,
                nonlinear: Some(fem_node::nonlinear),
                schema: Some(fem_node::schema),
                build: fem_node::build,
            },
            ShippedSolver {
                kind: "dem",
                check: dem_node::check,
                nonlinear: None,
                schema: Some(dem_node::schema),
                build: dem_node::build,
            },
        ],
        ..Registry::default()
    };
    coupler::cli::main(&registry)
}
