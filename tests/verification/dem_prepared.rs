//! Samples kept in a folder: they give the same bits as without the folder, and a changed file is never used.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::Duration;

use dem_kernel::bodies::disk::Disk;
use dem_node::Dem;
use dem_node::config::DemConfig;
use dem_node::sample::prepared::{self, Prepared};
use dem_node::sample::types::Sample;
use kit::kept::{Store, WORTH};
use protocol::{Node, Setting};
use serde_json::{Value, json};

use crate::dem_support::{march, scene, setting};

/// A new folder below the system's temporary one, removed when dropped.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Folder {
        let name = format!("thirdbody-samples-{name}-{}", std::process::id());
        Folder(std::env::temp_dir().join(name))
    }

    /// The only file in it.
    fn file(&self) -> PathBuf {
        let entries = fs::read_dir(&self.0).expect("it was made");
        let paths: Vec<PathBuf> = entries.map(|e| e.expect("it is read").path()).collect();
        assert_eq!(paths.len(), 1, "{paths:?}");
        paths[0].clone()
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// A small layer with rigid grains under a wheel.
fn config(changes: Value) -> Value {
    let mut sample = json!({
        "kind": "layer", "thickness_m": 3e-4, "half_width_m": 1.5e-3, "crown_radius_m": 0.3, "radius_min_m": 5e-5,
        "radius_max_m": 1e-4, "law": "surface_uniform",
    });
    for (key, value) in changes.as_object().into_iter().flatten() {
        sample[key] = value.clone();
    }
    scene(
        json!({"kind": "signorini"}),
        1e-7,
        sample,
        json!({"wheel": {"load_n": 1.0, "mass_kg": 1.0, "ramp_s": 0.0, "hold_s": 1.0}}),
    )
}

fn read(config: &Value) -> DemConfig {
    kit::read_config(config).expect("it is valid")
}

/// Prepares with a folder that keeps everything.
fn prepare(folder: &Path, changes: Value, seed: u64) -> Prepared {
    let store = Store {
        folder: Some(folder),
        worth: Duration::ZERO,
    };
    let prepared = prepared::prepare(&store, &read(&config(changes)), seed);
    prepared.expect("the recipe works")
}

fn bits(sample: &Sample) -> (Vec<[u64; 3]>, [usize; 3], [u64; 2]) {
    let numbers = |d: &Disk| [d.centre[0], d.centre[1], d.radius].map(f64::to_bits);
    let all = sample.free.iter().chain(&sample.glued);
    let shrunk = sample.radii_shrunk.unwrap_or(f64::NAN);
    (
        all.map(numbers).collect(),
        [sample.free.len(), sample.glued.len(), sample.lid],
        [sample.solid_fraction.to_bits(), shrunk.to_bits()],
    )
}

fn from_cache(prepared: &Prepared) -> bool {
    prepared
        .origin
        .as_ref()
        .expect("a layer has one")
        .from_cache
}

fn hash(prepared: &Prepared) -> &str {
    &prepared.origin.as_ref().expect("a layer has one").hash
}

#[test]
fn a_kept_sample_equals_the_prepared_one() {
    let rail = json!({
        "kind": "rail", "width_m": 2.1e-3, "height_m": 9e-4, "height_at": "edge", "crown_radius_m": 0.0,
        "thickness_m": null, "half_width_m": null,
    });
    let lid = json!({"lid": true, "crown_radius_m": 0.0});
    for (name, changes) in [("layer", json!({})), ("lid", lid), ("rail", rail)] {
        let mut scene = config(changes);
        let sample = scene["sample"].as_object_mut().expect("a table");
        sample.retain(|_, value| !value.is_null());
        if name == "lid" {
            scene
                .as_object_mut()
                .expect("a table")
                .shift_remove("wheel");
        }
        let folder = Folder::new(name);
        let store = Store {
            folder: Some(&folder.0),
            worth: Duration::ZERO,
        };
        let twice =
            [0, 1].map(|_| prepared::prepare(&store, &read(&scene), 1).expect("the recipe works"));
        assert_eq!(
            [from_cache(&twice[0]), from_cache(&twice[1])],
            [false, true],
            "{name}"
        );
        assert_eq!(bits(&twice[0].sample), bits(&twice[1].sample));
        assert!(twice.iter().all(|prepared| prepared.warnings.is_empty()));
        assert_eq!(hash(&twice[0]), hash(&twice[1]));
    }
}

#[test]
fn a_run_has_the_same_bits_with_and_without_the_folder() {
    let folder = Folder::new("run");
    prepare(&folder.0, json!({}), 1);
    let run = |cache: Option<PathBuf>| {
        let setting = Setting {
            cache,
            ..setting(1)
        };
        let mut dem = Dem::new(&read(&config(json!({}))), &setting).expect("it can be prepared");
        march(&mut dem, 0, 20);
        let origin = dem.describe().prepared_sample.expect("a layer has one");
        (
            origin.from_cache,
            dem.finish().expect("it finishes").state_hash,
        )
    };
    let (without, with) = (run(None), run(Some(folder.0.clone())));
    assert_eq!([without.0, with.0], [false, true]);
    assert_eq!(without.1, with.1);
}

#[test]
fn another_seed_or_recipe_is_another_sample() {
    let folder = Folder::new("others");
    let first = prepare(&folder.0, json!({}), 1);
    assert!(from_cache(&prepare(&folder.0, json!({"seed": 1}), 5)));
    for (changes, seed) in [
        (json!({}), 2),
        (json!({"seed": 2}), 1),
        (json!({"thickness_m": 3.1e-4}), 1),
        (json!({"law": "number_uniform"}), 1),
        (json!({"press_pa": [3e8]}), 1),
    ] {
        let other = prepare(&folder.0, changes.clone(), seed);
        let again = changes == json!({"seed": 2});
        assert_eq!(from_cache(&other), again, "{changes}");
        assert_ne!(hash(&other), hash(&first));
    }
    let mut springs = config(json!({}));
    springs["law"]["contact_stiffness_pa"] = json!(1e11);
    let store = Store {
        folder: Some(&folder.0),
        worth: WORTH,
    };
    let other = prepared::prepare(&store, &read(&springs), 1).expect("the recipe works");
    assert!(!from_cache(&other));
}

#[test]
fn a_damaged_file_is_replaced_and_named() {
    let folder = Folder::new("damaged");
    let made = prepare(&folder.0, json!({}), 1);
    let file = folder.file();
    let whole = fs::read(&file).expect("it was written");
    let flipped = |place: usize| {
        let mut bytes = whole.clone();
        bytes[place] ^= 1;
        bytes
    };
    prepare(&folder.0, json!({}), 2);
    let entries = fs::read_dir(&folder.0).expect("it was made");
    let mut paths = entries.map(|entry| entry.expect("it is read").path());
    let other = paths
        .find(|path| *path != file)
        .expect("the file of seed 2");
    let cases = [
        (flipped(0), "damaged"),
        (flipped(40), "damaged"),
        (flipped(whole.len() - 1), "damaged"),
        (whole[..whole.len() - 1].to_vec(), "damaged"),
        (whole[..10].to_vec(), "damaged"),
        (Vec::new(), "damaged"),
        (fs::read(&other).expect("it was written"), "another recipe"),
    ];
    for (bytes, why) in cases {
        fs::write(&file, bytes).expect("it is ours");
        let anew = prepare(&folder.0, json!({}), 1);
        assert!(!from_cache(&anew));
        let named = file.display().to_string();
        let noted = &anew.warnings[..];
        assert!(
            noted.len() == 1 && noted[0].contains(&named) && noted[0].contains(why),
            "{noted:?}"
        );
        assert_eq!(bits(&anew.sample), bits(&made.sample));
        assert_eq!(fs::read(&file).expect("it was written"), whole, "replaced");
        assert!(from_cache(&prepare(&folder.0, json!({}), 1)));
    }
}

#[test]
fn a_quickly_made_sample_is_not_kept_and_a_missing_folder_only_warns() {
    let folder = Folder::new("fast");
    let store = Store {
        folder: Some(&folder.0),
        worth: Duration::MAX,
    };
    let made = prepared::prepare(&store, &read(&config(json!({}))), 1).expect("the recipe works");
    assert!(made.warnings.is_empty() && !folder.0.exists());
    fs::write(&folder.0, "a file").expect("the temporary folder is writable");
    let anew = prepare(&folder.0, json!({}), 1);
    assert!(
        anew.warnings
            .iter()
            .any(|warning| warning.contains("cannot be kept")),
        "{:?}",
        anew.warnings
    );
    assert_eq!(bits(&anew.sample), bits(&made.sample));
    fs::remove_file(&folder.0).expect("it is ours");
}
