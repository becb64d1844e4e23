//! What a strip that repeats along x goes with.

use protocol::ConfigError;

use super::limits::finite;
use super::{Config, DisksConfig, LayerConfig, SampleConfig};

const KEY: &str = "sample.periodic_x_m";
/// Diameters of the widest disk that a strip must hold: a grain and its neighbours must not meet around it.
const DIAMETERS: f64 = 4.0;

impl Config {
    /// Refuses what has no period.
    pub(super) fn validate_periodic(&self) -> Result<(), ConfigError> {
        let ends = match &self.sample {
            SampleConfig::Layer(layer) => layer.periodic_x_m,
            SampleConfig::Disks(disks) => disks.periodic_x_m,
        };
        let Some(ends) = ends else {
            return Ok(());
        };
        ends.iter().try_for_each(|end| finite(KEY, *end))?;
        let widest = match &self.sample {
            SampleConfig::Layer(layer) => layer.validate_strip(ends)?,
            SampleConfig::Disks(disks) => disks.validate_strip(ends)?,
        };
        let narrowest = 2.0 * DIAMETERS * widest;
        if ends[1] - ends[0] < narrowest {
            return Err(ConfigError::new(
                KEY,
                format!(
                    "a strip of {:e} m is narrower than {DIAMETERS} of the widest diameter, {narrowest:e} m",
                    ends[1] - ends[0]
                ),
            )
            .help("write [left, right] with right further away"));
        }
        if self.wheel.is_some_and(|wheel| wheel.radius_m > 0.0) {
            return Err(ConfigError::new(
                "wheel.radius_m",
                "a curved wheel does not repeat along x, and sample.periodic_x_m does",
            )
            .help("write radius_m = 0"));
        }
        if self.drive.is_some() {
            return Err(ConfigError::new(
                KEY,
                "a driven pair does not repeat along x",
            ));
        }
        Ok(())
    }
}

impl LayerConfig {
    /// Returns the largest radius (m).
    fn validate_strip(&self, ends: [f64; 2]) -> Result<f64, ConfigError> {
        let width = self.half_width_m;
        if ends != [-width, width] {
            return Err(ConfigError::new(
                KEY,
                format!("a layer covers its strip, |x| up to sample.half_width_m = {width:e}"),
            )
            .help(format!("write periodic_x_m = [{:e}, {width:e}]", -width)));
        }
        if self.crown_radius_m > 0.0 {
            return Err(ConfigError::new(
                "sample.crown_radius_m",
                "a crown does not repeat along x, and sample.periodic_x_m does",
            )
            .help("write crown_radius_m = 0"));
        }
        Ok(self.radius_max_m)
    }
}

impl DisksConfig {
    /// Returns the largest radius (m).
    fn validate_strip(&self, ends: [f64; 2]) -> Result<f64, ConfigError> {
        self.refuse_torn_clusters(ends[1] - ends[0])?;
        let level = |nx: Option<f64>| nx == Some(0.0);
        if let Some(i) = self.walls.iter().position(|wall| !level(wall.nx)) {
            return Err(ConfigError::new(
                &format!("sample.walls[{i}]"),
                "only a level half-plane repeats along x, and sample.periodic_x_m does",
            )
            .help("write nx = 0"));
        }
        Ok(self
            .disks
            .iter()
            .map(|disk| disk.radius_m)
            .fold(0.0, f64::max))
    }

    /// A cluster is listed whole, also where it lies across an end: its places are not folded.
    fn refuse_torn_clusters(&self, length: f64) -> Result<(), ConfigError> {
        for (i, disk) in self.disks.iter().enumerate() {
            let Some(name) = &disk.cluster else {
                continue;
            };
            let mut others = self.disks[..i]
                .iter()
                .filter(|d| d.cluster.as_ref() == Some(name));
            if others.any(|other| (other.x_m - disk.x_m).abs() > 0.5 * length) {
                return Err(ConfigError::new(
                    &format!("sample.disks[{i}].x_m"),
                    format!("lies more than half the strip from another disk of cluster {name:?}"),
                )
                .help("list a cluster in one piece, beyond the end of the strip if need be"));
            }
        }
        Ok(())
    }
}
