//! Snapshots: fields and contact profiles as files.

use std::path::PathBuf;

use protocol::Setting;

use crate::error::FemError;
use crate::integrate::State;
use crate::model::Model;
use crate::profile::Profile;
use crate::vtu;
use crate::wheel::NodeContact;

/// Name of the snapshot that fixes the state whose pressures are reported.
pub(crate) const HOLD: &str = "hold";

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

    /// Writes `<participant>-NAME.vtu`, and `<participant>-NAME-profile.csv` where there is a profile.
    pub(crate) fn write(
        &self,
        name: &str,
        model: &Model,
        state: &State,
        contacts: &[NodeContact],
        profile: Option<&Profile>,
    ) -> Result<(), FemError> {
        let Some(folder) = &self.folder else {
            return Ok(());
        };
        let stem = format!("{}-{name}", self.participant);
        vtu::write(&folder.join(format!("{stem}.vtu")), model, state, contacts)?;
        profile.map_or(Ok(()), |profile| {
            profile.write(folder.join(format!("{stem}-profile.csv")))
        })
    }
}
