//! Tables beside the fields: profiles over slices, cycles of the wheel, stress in cells.

use std::path::Path;

use super::dem::Dem;
use crate::error::DemError;
use crate::measure::snapshot;
use crate::measure::stress::StressMap;

impl Dem {
    /// Writes `<participant>-cycles.csv` beside the fields where the wheel has made one, `<participant>-profile.csv` and
    /// `<participant>-stress.csv` where they are asked for.
    pub(super) fn write_maps(&self) -> Result<(), DemError> {
        let Some(folder) = &self.setting.fields else {
            return Ok(());
        };
        if let Some(text) = self.progress.cycles.csv(self.flow.is_some()) {
            self.write_map(folder, "cycles", &text)?;
        }
        if let Some(config) = &self.profile {
            let text = self.progress.profile.csv(config, self.setting.thickness_m);
            self.write_map(folder, "profile", &text)?;
        }
        match self.stress_map() {
            None => Ok(()),
            Some(map) => self.write_map(folder, "stress", &map.csv()),
        }
    }

    fn write_map(&self, folder: &Path, what: &str, text: &str) -> Result<(), DemError> {
        let name = format!("{}-{what}.csv", self.setting.participant);
        snapshot::write_text(&folder.join(name), text)
    }

    /// The stress at the end of the hold, or of the last state where that is not over.
    fn stress_map(&self) -> Option<StressMap> {
        let config = self.stress.as_ref()?;
        let (bodies, state) = (&self.bodies, &self.progress.state);
        let held = self.progress.held_stress.clone();
        held.or_else(|| StressMap::measure(config, bodies, state, self.setting.thickness_m))
    }

    pub(super) fn stress_results(&self) -> impl Iterator<Item = (String, f64)> {
        let results = self.stress_map().map(|map| map.results());
        let results = results.into_iter().flatten();
        results.map(|(name, x)| (name.to_string(), x))
    }

    /// Advice on profiles and stresses that were asked for and are not there.
    pub(super) fn maps_advice(&self) -> Vec<String> {
        let profile = &self.progress.profile;
        let profile = self
            .profile
            .as_ref()
            .and_then(|config| profile.advice(config));
        profile.into_iter().chain(self.stress_advice()).collect()
    }

    fn stress_advice(&self) -> Option<String> {
        let asked = self.stress.is_some();
        let missing = asked
            && !self
                .stress_results()
                .any(|(name, _)| name == "dem_p_max_tr3_pa");
        missing.then(|| {
            "stress: no grain bears a contact force in a whole cell, so that there are no pressures; lower stress.cell_m, or give stress.x_m and stress.y_m".into()
        })
    }
}
