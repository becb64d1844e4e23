//! The composition root: the only place that names the shipped solvers.

use std::process::ExitCode;

use coupler::launch::{Registry, Solver};

fn main() -> ExitCode {
    let registry = Registry {
        solvers: vec![
            Solver {
                kind: "fem",
                check: fem_node::check,
                build: fem_node::build,
            },
            Solver {
                kind: "dem",
                check: dem_node::check,
                build: dem_node::build,
            },
        ],
    };
    coupler::cli::main(&registry)
}
