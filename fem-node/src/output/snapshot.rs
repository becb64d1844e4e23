//! Snapshots: fields and contact profiles as files.

use std::fs;
use std::path::PathBuf;

use fem_kernel::integrate::state::NodalState;
use protocol::Setting;

use crate::error::FemError;
use crate::model::Model;
use crate::output::vtu::{self, SurfaceFields};

/// Folder of the snapshots, where there is one.
#[derive(Clone, Debug)]
pub(crate) struct Snapshots {
    participant: String,
    folder: Option<PathBuf>,
}

impl Snapshots {
    pub(crate) fn new(setting: &Setting) -> Snapshots {
        Snapshots {
            participant: setting.participant.clone(),
            folder: setting.fields.clone(),
        }
    }

    /// True where snapshots are written.
    pub(crate) fn wanted(&self) -> bool {
        self.folder.is_some()
    }

    /// Writes the table `<participant>-NAME.csv`, unless it is empty.
    pub(crate) fn table(&self, name: &str, text: &str) -> Result<(), FemError> {
        let Some(folder) = self.folder.as_ref().filter(|_| !text.is_empty()) else {
            return Ok(());
        };
        let path = folder.join(format!("{}-{name}.csv", self.participant));
        FemError::written(&path, fs::write(&path, text))
    }

    /// Writes `<participant>-NAME.vtu`, and `<participant>-NAME-profile.csv` where there is a profile.
    pub(crate) fn write(
        &self,
        name: &str,
        model: &Model,
        state: &NodalState,
        surface: SurfaceFields,
    ) -> Result<(), FemError> {
        let Some(folder) = &self.folder else {
            return Ok(());
        };
        let stem = format!("{}-{name}", self.participant);
        let path = folder.join(format!("{stem}.vtu"));
        vtu::write(&path, model, state, surface)?;
        surface.1.map_or(Ok(()), |profile| {
            let path = folder.join(format!("{stem}-profile.csv"));
            FemError::written(&path, fs::write(&path, profile.csv()))
        })
    }
}
