//! The built-in solvers, which the binary provides.

use std::path::PathBuf;

use kit::ConfigError;
use kit::keys::proposal;
use protocol::{Node, NodeError, Session, Setting};

use scenario::error::{Code, Refusal, Result};
use scenario::keys::Participant;

/// A shipped solver.
#[derive(Clone, Copy)]
pub struct ShippedSolver {
    /// Its `kind` in the scenario.
    pub kind: &'static str,
    /// Validates its keys; returns advice for the user.
    pub check: fn(&serde_json::Value, &Setting) -> Result<Vec<String>, ConfigError>,
    /// True if the body of these keys is nonlinear, as one that yields; absent for a solver that is always linear.
    pub nonlinear: Option<fn(&serde_json::Value) -> bool>,
    /// Its keys as a JSON Schema; absent for a solver without a description of its keys.
    pub schema: Option<fn() -> serde_json::Value>,
    /// Makes the node.
    pub build: fn(&Session) -> Result<Box<dyn Node>, NodeError>,
}

/// All shipped solvers.
#[derive(Clone, Default)]
pub struct Registry {
    /// One entry for each kind.
    pub solvers: Vec<ShippedSolver>,
    /// Folder in which solvers keep what takes long to prepare; nothing is kept when absent.
    pub cache: Option<PathBuf>,
}

impl Registry {
    /// The solver of this kind.
    pub fn get(&self, kind: &str) -> Option<&ShippedSolver> {
        self.solvers.iter().find(|solver| solver.kind == kind)
    }

    /// The solver of a participant without a command of its own.
    pub fn find(&self, participant: &Participant) -> Result<&ShippedSolver> {
        self.get(&participant.kind).ok_or_else(|| {
            let kinds: Vec<&str> = self.solvers.iter().map(|solver| solver.kind).collect();
            let proposal = proposal(&participant.kind, "kinds", &kinds);
            let text = format!(
                "participant `{}`: no solver of kind `{}` is built in; {proposal} For a program of your own, give its command",
                participant.name, participant.kind
            );
            Refusal::other(Code::UnknownKind, text).into()
        })
    }
}
