//! Prepared samples, which are kept for later runs ([`kit::kept`]).

use kit::kept::Store;
use protocol::PreparedSample;
use serde_json::json;

use crate::config::DemConfig;
use crate::config::sample::SampleConfig;
use crate::error::DemError;
use crate::sample;
use crate::sample::types::Sample;

/// A sample, and where it comes from.
pub struct Prepared {
    /// The sample.
    pub sample: Sample,
    /// Its recipe, and whether it comes from a file; absent for listed disks.
    pub origin: Option<PreparedSample>,
    /// Faults of its file, which cost time only.
    pub warnings: Vec<String>,
}

/// The sample of a valid configuration, from its file or made by its recipe. `seed` is the run's.
pub fn prepare(store: &Store, config: &DemConfig, seed: u64) -> Result<Prepared, DemError> {
    let Some(recipe) = recipe(config, seed) else {
        return Ok(Prepared {
            sample: sample::prepare(config, seed)?,
            origin: None,
            warnings: Vec::new(),
        });
    };
    let kept = store.value(["prepared sample", "sample"], &recipe, || {
        sample::prepare(config, seed)
    })?;
    Ok(Prepared {
        sample: kept.value,
        origin: Some(PreparedSample {
            hash: kept.hash,
            from_cache: kept.from_cache,
        }),
        warnings: kept.warnings,
    })
}

/// Everything that decides the bits of a prepared sample, as JSON; `None` for listed disks.
fn recipe(config: &DemConfig, seed: u64) -> Option<String> {
    let (kind, keys, own) = match config.sample.clone() {
        SampleConfig::Disks(_) => return None,
        SampleConfig::Layer(mut layer) => {
            let own = layer.seed.take();
            let stiffness = config.law.contact_stiffness_pa;
            let as_cut = sample::stays_as_cut(config);
            ("layer", json!([layer, stiffness, as_cut]), own)
        }
        SampleConfig::Rail(mut rail) => {
            let own = rail.seed.take();
            ("rail", json!(rail), own)
        }
    };
    let recipe = json!({
        "software": concat!("dem-node ", env!("CARGO_PKG_VERSION")),
        "kind": kind,
        "keys": keys,
        "seed": own.unwrap_or(seed),
    });
    Some(recipe.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;
    use dem_kernel::bodies::disk::Disk;
    use protocol::checkpoint::pack;

    /// A file holds recipe, (x, y, radius) of the free and the glued disks, the number of disks of the lid, and two numbers.
    #[test]
    fn a_file_holds_no_more_than_its_recipe_makes() {
        let disk = |x: f64| Disk {
            centre: [x, -2.0],
            radius: 0.5,
            velocity: [7.0; 3],
        };
        let sample = Sample {
            free: vec![disk(1.0), disk(300.0)],
            glued: vec![disk(-4.0)],
            lid: 300,
            face: vec![disk(9.0)],
            wall_names: vec!["wall".into()],
            solid_fraction: 0.8,
            radii_shrunk: Some(1e-3),
            ..Sample::default()
        };
        let numbers = |x: f64| [x, -2.0, 0.5];
        let free = vec![numbers(1.0), numbers(300.0)];
        let plain = ("recipe", free, vec![numbers(-4.0)], 300u64, 0.8, Some(1e-3));
        let packed = pack(&("recipe".to_string(), &sample)).expect("it can be packed");
        assert_eq!(packed, pack(&plain).expect("it can be packed"));
    }
}
