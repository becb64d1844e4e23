//! Snapshots: fields and contact profiles as files.

use std::fs;
use std::path::PathBuf;

use protocol::{Phase, Setting};

use crate::error::FemError;
use crate::integrate::state::State;
use crate::model::Model;
use crate::output::profile::Profile;
use crate::output::vtu;
use crate::output::vtu::Touched;
use crate::wheel::node_contact::NodeContact;

/// Name of the snapshot that fixes the state whose pressures are reported.
pub(crate) const HOLD: &str = "hold";

/// The named parts of a load history with their limits in time (s); those without duration are left out.
pub(crate) fn phases<const N: usize>(parts: [(&str, f64, f64); N]) -> Vec<Phase> {
    let lasting = parts.into_iter().filter(|(_, t0_s, t1_s)| t1_s > t0_s);
    let phase = |(name, t0_s, t1_s): (&str, f64, f64)| Phase {
        name: name.into(),
        t0_s,
        t1_s,
        sampled: name == HOLD,
        picture: name != "ramp",
    };
    lasting.map(phase).collect()
}

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
        let touched = Touched { contacts, profile };
        vtu::write(&folder.join(format!("{stem}.vtu")), model, state, touched)?;
        profile.map_or(Ok(()), |profile| {
            let path = folder.join(format!("{stem}-profile.csv"));
            FemError::written(&path, fs::write(&path, profile.csv()))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_without_duration_are_no_phases() {
        let parts = [
            ("ramp", 0.0, 0.0),
            (HOLD, 0.0, 4e-4),
            ("cycling", 4e-4, 4e-4),
        ];
        let names: Vec<String> = phases(parts).into_iter().map(|p| p.name).collect();
        assert_eq!(names, ["hold"]);
    }
}
