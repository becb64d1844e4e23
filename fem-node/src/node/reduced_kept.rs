//! Modes, surfaces and windows of a reduced body, kept for later runs ([`kit::kept`]).

use std::io::Write;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use fem_kernel::error::KernelError;
use fem_kernel::reduced::modes::ModeChoice;
use kit::kept::{Store, WORTH};
use protocol::Setting;
use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::model::Model;

/// The kept values of a body with its modes.
pub(super) struct KeptParts {
    folder: Option<PathBuf>,
    /// Everything that decides the bits of the modes.
    recipe: String,
    /// Least time of a computation that makes its result worth keeping: none once the modes are kept.
    worth: Duration,
    /// Faults of files.
    pub(super) warnings: Vec<String>,
}

impl KeptParts {
    pub(super) fn new(model: &Model, choice: ModeChoice, setting: &Setting) -> KeptParts {
        // Stiffness and masses follow from these numbers, whichever keys gave them.
        let (body, numbers) = (&model.body, (model.element, model.elastic, model.thickness));
        let masses = [&*body.mass, &*body.inverse_mass];
        let mut hasher = blake3::Hasher::new();
        let numbers = (&model.mesh, body.layout, masses, numbers);
        write!(hasher, "{numbers:?}").expect("a hash takes everything");
        let (version, body) = (env!("CARGO_PKG_VERSION"), hasher.finalize().to_hex());
        KeptParts {
            folder: setting.cache.clone(),
            recipe: format!("fem-node {version}: {choice:?} of the body {body}"),
            worth: WORTH,
            warnings: Vec::new(),
        }
    }

    /// A value that the body, its modes and `more` decide, from its file or made.
    pub(super) fn value<T: Serialize + DeserializeOwned>(
        &mut self,
        ending: &str,
        more: &str,
        make: impl FnOnce() -> Result<T, KernelError>,
    ) -> Result<T, KernelError> {
        let store = Store {
            folder: self.folder.as_deref(),
            worth: self.worth,
        };
        let start = Instant::now();
        let recipe = format!("{}{more}", self.recipe);
        let kept = store.value(["file of a reduced body", ending], &recipe, make)?;
        self.warnings.extend(kept.warnings);
        if kept.from_cache || start.elapsed() >= WORTH {
            self.worth = Duration::ZERO;
        }
        Ok(kept.value)
    }
}
