//! A run among the settings that a stored study measured for its scene, and settings with half its error or half its time.

use std::cmp::Reverse;
use std::path::PathBuf;

use super::budget::SceneSettings;
use super::front::{Trade, front};
use super::stored::{StoredSetting, StoredStudy};
use runs::front::{MeasuredFront, MeasuredSetting};
use scenario::error::Error;
use scenario::overrides::{number, parse_value, value_at};

/// The settings of the first study that has errors for a scene, around a run with this scenario. Unreadable studies go to `on_unread` and
/// are skipped.
pub fn first_front(
    studies: impl Iterator<Item = Result<(PathBuf, StoredStudy), Error>>,
    resolved: &str,
    on_unread: impl Fn(&Error),
) -> Option<MeasuredFront> {
    let mut read = studies.filter_map(|study| study.inspect_err(&on_unread).ok());
    read.find_map(|(_, study)| scene_front(&study, resolved))
}

/// `None` if the study does not cover the scene, or has too few scenes for errors.
fn scene_front(study: &StoredStudy, resolved: &str) -> Option<MeasuredFront> {
    let known = SceneSettings::new(study, &study.locate(resolved).ok()?).ok()?;
    let known = known.by_accuracy();
    let scenario: toml::Table = resolved.parse().unwrap_or_default();
    let setting = |of: &StoredSetting, errors: Vec<[f64; 2]>| MeasuredSetting {
        words: of.words.clone(),
        overrides: missing(&scenario, &of.set),
        warned: of.warned.clone(),
        is_reference: of.set == study.reference,
        cost: of.cpu_rel,
        errors,
    };
    let settings = known.iter().map(|of| {
        let errors = of.predictions.iter().map(|p| [p.expected, p.bound]);
        setting(of.setting, errors.collect())
    });
    let settings: Vec<MeasuredSetting> = settings.collect();
    // Of two settings that agree with the run, the one with more overrides is the run's.
    let distance = |of: &&StoredSetting| (missing(&scenario, &of.set).len(), Reverse(of.set.len()));
    let nearest = study.settings.iter().min_by_key(distance)?;
    let own = known.iter().position(|of| of.setting.set == nearest.set);
    let own = own.filter(|own| settings[*own].overrides.is_empty());
    let measures = 0..study.measures.len();
    Some(MeasuredFront {
        study: study.study.clone(),
        build: study.build.clone(),
        measures: study.measures.iter().map(|of| of.name.clone()).collect(),
        fronts: measures.map(|m| front_by(&settings, m)).collect(),
        nearest: setting(nearest, Vec::new()),
        reference_misses: study.reference_misses.clone(),
        own,
        half_error: own.and_then(|own| half_error(&settings, own)),
        half_time: own.and_then(|own| half_time(&settings, own)),
        settings,
    })
}

fn front_by(settings: &[MeasuredSetting], measure: usize) -> Vec<usize> {
    let trade = |(setting, of): (usize, &MeasuredSetting)| {
        Trade::new(setting, of.cost, of.errors[measure][0])
    };
    let trades: Vec<Trade> = settings.iter().enumerate().map(trade).collect();
    front(&trades).iter().map(|trade| trade.setting).collect()
}

fn half_error(settings: &[MeasuredSetting], own: usize) -> Option<usize> {
    let errs_half = |k: &usize| {
        let mut errors = settings[*k].errors.iter().zip(&settings[own].errors);
        *k != own && errors.all(|([one, _], [own, _])| 2.0 * one <= *own)
    };
    let halves = (0..settings.len()).filter(errs_half);
    halves.min_by(|a, b| settings[*a].cost.total_cmp(&settings[*b].cost))
}

fn half_time(settings: &[MeasuredSetting], own: usize) -> Option<usize> {
    let most = 0.5 * settings[own].cost;
    settings.iter().position(|of| of.cost <= most)
}

/// The overrides whose values differ from the scenario's.
fn missing(scenario: &toml::Table, set: &[String]) -> Vec<String> {
    let is_missing = |set: &&String| {
        let (key, value) = set.split_once('=').unwrap_or((set, ""));
        value_at(scenario, key.trim()).is_none_or(|own| !is_same(own, &parse_value(value.trim())))
    };
    set.iter().filter(is_missing).cloned().collect()
}

/// True for equal values, 9 and 9.0 among them.
fn is_same(one: &toml::Value, other: &toml::Value) -> bool {
    one == other || number(one).is_some_and(|one| number(other) == Some(one))
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::{Value, json};

    /// Five scenes that differ only by their seeds; errors in two measures.
    fn study(settings: &[Value]) -> StoredStudy {
        let study = json!({
            "schema": "thirdbody.study/1", "study": "s", "build": "b", "scenario": "[x]\ny = 1\n", "reference": ["a.b=1", "a.c=ref"],
            "scene_keys": [{ "key": "run.seed", "any": true, "values": [1, 2, 3, 4, 5] }],
            "measures": [{ "name": "m", "of": "results.x", "norm": "at" }, { "name": "n", "of": "results.y", "norm": "at" }],
            "floors": [[1e-9, 1e-9, 1e-9, 1e-9, 1e-9], [1e-9, 1e-9, 1e-9, 1e-9, 1e-9]],
            "settings": settings,
        });
        serde_json::from_value(study).expect("a stored study")
    }

    fn setting(words: &str, set: &[&str], [m, n]: [f64; 2], cpu_rel: f64) -> Value {
        let errors = [m, n].map(|error| [error; 5]);
        json!({ "words": words, "set": set, "errors": errors, "cpu_rel": cpu_rel, "wall_s": cpu_rel })
    }

    /// `fine` halves only the error m of `own`; `both` and `dear` halve both errors. `quick` is more accurate than `crude`; `warned` is not to
    /// be trusted.
    fn settings() -> Vec<Value> {
        let mut warned = setting("warned", &["a.b=9", "a.c=w"], [1e-3, 1e-3], 0.1);
        warned["warned"] = json!(["bond_step"]);
        vec![
            setting("reference", &["a.b=1", "a.c=ref"], [1e-9, 1e-9], 1.0),
            setting("own", &["a.b=9", "a.c=o"], [0.02, 0.01], 0.2),
            setting("fine", &["a.b=9", "a.c=f"], [0.009, 0.006], 0.3),
            setting("dear", &["a.b=3", "a.c=d"], [0.001, 0.001], 0.8),
            setting("both", &["a.b=3", "a.c=b"], [0.0099, 0.0049], 0.5),
            setting("crude", &["a.b=36", "a.c=c"], [0.2, 0.01], 0.05),
            setting("quick", &["a.b=18", "a.c=q"], [0.04, 0.05], 0.1),
            warned,
        ]
    }

    fn scene(b: &str, c: &str) -> String {
        format!("[run]\nseed = 77\n[x]\ny = 1\n[a]\nb = {b}\nc = \"{c}\"\n")
    }

    #[test]
    fn half_the_error_holds_in_every_measure_and_half_the_time_is_the_most_accurate() {
        let study = study(&settings());
        let of = |b: &str, c: &str| scene_front(&study, &scene(b, c)).expect("it is covered");
        let words = |front: &MeasuredFront, k: Option<usize>| {
            let words = k.map(|k| front.settings[k].words.clone());
            words.unwrap_or_default()
        };
        let halves = |b: &str, c: &str| {
            let front = of(b, c);
            [front.own, front.half_error, front.half_time].map(|k| words(&front, k))
        };
        assert_eq!(halves("9.0", "o"), ["own", "both", "quick"]);
        assert_eq!(halves("1", "ref"), ["reference", "", "fine"]);
        assert_eq!(halves("36", "c"), ["crude", "both", ""]);
        // Only the reference has half the error of the most accurate setting.
        assert_eq!(halves("3", "d"), ["dear", "reference", "fine"]);

        let front = of("9", "o");
        let overrides = |words: &str| {
            let mut settings = front.settings.iter();
            let found = settings.find(|of| of.words == words);
            found.expect("it is there").overrides.clone()
        };
        assert_eq!(overrides("both"), ["a.b=3", "a.c=b"]);
        assert_eq!(overrides("fine"), ["a.c=f"]);
        let names = |measure: usize| {
            let on_front = front.fronts[measure].iter();
            let names = on_front.map(|k| words(&front, Some(*k)));
            Vec::from_iter(names).join(" ")
        };
        assert_eq!(names(0), "crude quick own fine dear reference");
        assert_eq!(names(1), "crude fine both dear reference");
    }

    #[test]
    fn a_run_is_a_setting_only_if_all_its_keys_agree() {
        let study = study(&settings());
        let of = |b: &str, c: &str| scene_front(&study, &scene(b, c)).expect("it is covered");
        let other = of("18", "f");
        let indices = [other.own, other.half_error, other.half_time];
        assert_eq!((indices, other.nearest.overrides.len()), ([None; 3], 1));
        // A text is not the number that it spells.
        assert_eq!(of("\"9\"", "o").own, None);
        let MeasuredFront { nearest, own, .. } = of("9", "w");
        assert_eq!((nearest.words.as_str(), own), ("warned", None));
        assert!(nearest.overrides.is_empty());
        assert!(scene_front(&study, &scene("9", "o").replace("y = 1", "y = 2")).is_none());
    }

    #[test]
    fn of_two_settings_that_agree_the_one_with_more_overrides_is_the_run() {
        let mut all = settings();
        all.insert(1, setting("less", &["a.b=9"], [0.1, 0.1], 0.3));
        let study = study(&all);
        let of = |c: &str| {
            let front = scene_front(&study, &scene("9", c)).expect("it is covered");
            front.nearest.words
        };
        assert_eq!([of("o"), of("z")], ["own", "less"]);
    }

    #[test]
    fn studies_that_are_damaged_or_too_small_are_skipped() {
        let mut few = study(&settings());
        few.study = "few".into();
        few.scene_keys[0].values.truncate(2);
        few.floors.iter_mut().for_each(|floors| floors.truncate(2));
        let errors = few.settings.iter_mut().flat_map(|s| &mut s.errors);
        errors.for_each(|errors| errors.truncate(2));
        let path = PathBuf::from("nowhere/study.json");
        let damaged = StoredStudy::read(&path).map(|study| (path.clone(), study));
        let good = |study: StoredStudy| Ok((path.clone(), study));
        let unread = std::cell::Cell::new(0);
        let studies = [damaged, good(few), good(study(&settings()))].into_iter();
        let count = |_: &Error| unread.set(unread.get() + 1);
        let found = first_front(studies, &scene("9", "o"), count);
        assert_eq!(
            (found.map(|of| of.study), unread.get()),
            (Some("s".into()), 1)
        );
    }
}
