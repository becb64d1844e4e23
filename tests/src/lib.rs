//! Tools that the suites share: small solvers with answers on paper for their coupled motion, and functions to run scenarios.
//!
//! - [`bar`]: an elastic bar, explicit, the continuum side of the one-dimensional cases;
//! - [`broken`]: any of the solvers with one spoilt answer;
//! - [`campaign`]: runs of the program that are killed, stopped, starved and damaged, counted;
//! - [`chain`]: masses and springs, implicit, the side on the wall; one mass is a rigid body;
//! - [`json_schema`]: a validator of JSON Schemas;
//! - [`lattice`]: the lattice of bars and chains in one piece;
//! - [`mapped_line`]: nodes and points with a mapping between them;
//! - [`pages`]: the lists in the committed pages, written from the tables beside the code;
//! - [`plate`]: a row of loaded masses on a two-dimensional surface;
//! - [`reference`](mod@reference): tables of keys and of verbs for the book;
//! - [`random_log`]: exchange logs of random messages;
//! - [`scene`]: texts of scenes with these solvers;
//! - [`window_matrix`]: one window of each scheme as a matrix, the reference for the schemes themselves;
//! - [`runs`]: running a scenario text in-process or over shared memory, and reading its output;
//! - [`source`]: the product's code without tests and comments, for tests that judge it: [`filegraph`], the files
//!   that name each other.

pub mod bar;
pub mod broken;
pub mod campaign;
pub mod chain;
pub mod filegraph;
pub mod json_schema;
pub mod lattice;
pub mod mapped_line;
pub mod pages;
pub mod plate;
pub mod random_log;
pub mod reference;
pub mod runs;
pub mod scene;
pub mod source;
pub mod window_matrix;

use coordinator::participants::{Registry, ShippedSolver};
// Linked for the identity of the build.
use coupler as _;

/// The verification solvers with the shipped ones.
pub fn registry() -> Registry {
    let solvers = vec![
        ShippedSolver {
            kind: "bar",
            check: |config, _| kit::read_table::<bar::Config>(config).map(|_| Vec::new()),
            nonlinear: None,
            schema: None,
            build: bar::build,
        },
        ShippedSolver {
            kind: "chain",
            check: |config, _| kit::read_table::<chain::Config>(config).map(|_| Vec::new()),
            nonlinear: None,
            schema: None,
            build: chain::build,
        },
        ShippedSolver {
            kind: "plate",
            check: |config, _| kit::read_table::<plate::Config>(config).map(|_| Vec::new()),
            nonlinear: None,
            schema: None,
            build: plate::build,
        },
        ShippedSolver {
            kind: "broken",
            check: broken::check,
            nonlinear: None,
            schema: None,
            build: broken::build,
        },
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
    ];
    Registry {
        solvers,
        ..Registry::default()
    }
}
