//! The composition root: the only place that names the shipped solvers.

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
                bench: Some(|| {
                    let rows = fem_node::bench::bench().map_err(|error| error.to_string())?;
                    Ok(serde_json::json!(rows))
                }),
            },
            ShippedSolver {
                kind: "dem",
                check: dem_node::check,
                nonlinear: None,
                schema: Some(dem_node::schema),
                build: dem_node::build,
                bench: Some(|| {
                    let rows = dem_kernel::bench::bench().map_err(|error| error.to_string())?;
                    Ok(serde_json::json!(rows))
                }),
            },
        ],
        ..Registry::default()
    };
    coupler::cli::main(&registry)
}
