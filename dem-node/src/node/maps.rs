//! Tables in the folder of the fields: profiles over slices, cycles of the wheel, stress in cells.

use std::path::Path;

use super::dem::Dem;
use crate::error::DemError;
use crate::measure::snapshot;
use crate::measure::stress::StressMap;

impl Dem {
    /// Writes `<participant>-cycles.csv` where the wheel has made a cycle, `<participant>-passages.csv` where it has rolled, `<participant>-profile.csv` and `<participant>-stress.csv` where the
    /// scenario has their tables.
    pub(super) fn write_maps(&self) -> Result<(), DemError> {
        let Some(folder) = &self.setting.fields else {
            return Ok(());
        };
        if let Some(text) = self.progress.cycles.csv(self.measures.flow.is_some()) {
            self.write_map(folder, "cycles", &text)?;
        }
        let program = self.program.as_ref();
        if let Some(rolling) = program.and_then(|program| program.rolling.as_ref()) {
            let radius = self.bodies.wheel_radius;
            let text = self.progress.rolled.record.csv(rolling, radius);
            if !text.is_empty() {
                self.write_map(folder, "passages", &text)?;
            }
        }
        if let Some(config) = &self.measures.profile {
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

    /// The stress at its moment, or of the last state where a wheel's hold is not over, or where there is no moment.
    fn stress_map(&self) -> Option<StressMap> {
        let config = self.measures.stress.as_ref()?;
        let (bodies, state) = (&self.bodies, &self.progress.state);
        match &self.progress.held_stress {
            Some(held) => held.clone(),
            None if config.at_s.is_some() => None,
            None => StressMap::measure(config, bodies, state, self.setting.thickness_m),
        }
    }

    pub(super) fn stress_results(&self) -> Vec<(&'static str, f64)> {
        self.stress_map().map_or_else(Vec::new, |map| map.results())
    }

    /// Advice on profiles and stresses that the scenario asks for and that are missing.
    pub(super) fn maps_advice(&self) -> Vec<String> {
        let config = self.measures.profile.as_ref();
        let profile = config.and_then(|config| self.progress.profile.advice(config));
        profile.into_iter().chain(self.stress_advice()).collect()
    }

    fn stress_advice(&self) -> Option<String> {
        let asked = self.measures.stress?.at_s.is_none() || self.progress.held_stress.is_some();
        let mut results = self.stress_results().into_iter();
        let missing = asked && !results.any(|(name, _)| name == "dem_p_max_tr3_pa");
        missing.then(|| {
            "stress: no grain bears a contact force in a whole cell, so that there are no pressures; lower stress.cell_m, or give stress.x_m and stress.y_m".into()
        })
    }
}
