//! Prepared samples that are kept for later runs: a folder of files, each named by the hash of its sample's recipe. A folder belongs to one build:
//! another build may prepare other bits.
//!
//! A sample from a file has the bits that its recipe makes. A damaged file is never used: it is made again, with a warning.

use std::fs;
use std::io::{self, ErrorKind};
use std::path::Path;
use std::time::{Duration, Instant};

use protocol::PreparedSample;
use protocol::checkpoint::{pack, unpack};
use serde_json::json;

use crate::config::DemConfig;
use crate::config::sample::SampleConfig;
use crate::error::DemError;
use crate::sample;
use crate::sample::types::Sample;

/// A sample that took less time than this is not kept: making it again costs little more than reading it.
pub const WORTH: Duration = Duration::from_millis(100);
/// Bytes of the checksum in front of a file.
const CHECKSUM: usize = 32;

/// The folder of kept samples, if any. It need not exist; nothing is kept without one.
pub struct SampleStore<'a> {
    /// The folder.
    pub folder: Option<&'a Path>,
    /// Least time of a preparation that makes a sample worth keeping.
    pub worth: Duration,
}

/// A sample, and where it comes from.
pub struct Prepared {
    /// The sample.
    pub sample: Sample,
    /// Its recipe, and whether it comes from a file; absent for listed disks.
    pub origin: Option<PreparedSample>,
    /// Faults of its file, which cost time only.
    pub warnings: Vec<String>,
}

impl SampleStore<'_> {
    /// The sample of a valid configuration, from its file or made by its recipe. `seed` is the run's.
    pub fn prepare(&self, config: &DemConfig, seed: u64) -> Result<Prepared, DemError> {
        let Some(recipe) = recipe(config, seed) else {
            return Ok(Prepared {
                sample: sample::prepare(config, seed)?,
                origin: None,
                warnings: Vec::new(),
            });
        };
        let hash = blake3::hash(recipe.as_bytes()).to_hex().to_string();
        let name = format!("{hash}.sample");
        let file = self.folder.map(|folder| folder.join(name));
        let found = file.as_deref().map_or(Ok(None), |path| read(path, &recipe));
        let (sample, mut warnings) = match found {
            Ok(sample) => (sample, Vec::new()),
            Err(problem) => (None, vec![problem]),
        };
        let from_cache = sample.is_some();
        let sample = match sample {
            Some(sample) => sample,
            None => {
                let start = Instant::now();
                let sample = sample::prepare(config, seed)?;
                let keep = start.elapsed() >= self.worth || !warnings.is_empty();
                warnings.extend(
                    file.filter(|_| keep)
                        .and_then(|path| write(&path, &recipe, &sample).err()),
                );
                sample
            }
        };
        Ok(Prepared {
            sample,
            origin: Some(PreparedSample { hash, from_cache }),
            warnings,
        })
    }
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

/// The sample of a file; `None` without a file. The error states the file's fault.
fn read(path: &Path, recipe: &str) -> Result<Option<Sample>, String> {
    let fault = |why: &str| {
        format!(
            "the prepared sample {} {why}: it is made again",
            path.display()
        )
    };
    let bytes = match fs::read(path) {
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(None),
        read => read.map_err(|error| fault(&format!("cannot be read ({error})")))?,
    };
    let whole = bytes.split_at_checked(CHECKSUM);
    let whole = whole.filter(|(sum, content)| blake3::hash(content).as_bytes() == sum);
    let (_, content) = whole.ok_or_else(|| fault("is damaged (wrong checksum)"))?;
    let (own, sample): (String, Sample) =
        unpack(content).map_err(|_| fault("is damaged (wrong content)"))?;
    if own != recipe {
        return Err(fault("has another recipe"));
    }
    Ok(Some(sample))
}

/// Writes a whole file, or leaves the existing one. The error states the reason.
fn write(path: &Path, recipe: &str, sample: &Sample) -> Result<(), String> {
    let failed = |why: &dyn std::fmt::Display| {
        format!(
            "the prepared sample {} cannot be kept: {why}; --cache DIR chooses another folder, --cache none switches it off",
            path.display()
        )
    };
    let content = pack(&(recipe, sample)).map_err(|error| failed(&error.message))?;
    let mut bytes = blake3::hash(&content).as_bytes().to_vec();
    bytes.extend(content);
    replace(path, &bytes).map_err(|error| failed(&error))
}

/// Writes under another name, then renames, which is atomic: no reader sees half a file, and the last of two writers wins.
fn replace(path: &Path, bytes: &[u8]) -> io::Result<()> {
    if let Some(folder) = path.parent() {
        fs::create_dir_all(folder)?;
    }
    let own = format!(
        "{}-{:?}.new",
        std::process::id(),
        std::thread::current().id()
    );
    let temporary = path.with_extension(own);
    let written = fs::write(&temporary, bytes).and_then(|()| fs::rename(&temporary, path));
    if written.is_err() {
        let _ = fs::remove_file(&temporary);
    }
    written
}

#[cfg(test)]
mod tests {
    use super::*;
    use dem_kernel::bodies::disk::Disk;

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
