//! The shipped studies: all their tasks are valid, and the stored study covers its scene.

use coordinator::run::check::check;
use scenario::load::load;
use study::budget::SceneSettings;
use study::plan::{Plan, runs};
use study::stored::StoredStudy;

use crate::rows::shipped;

#[test]
fn every_task_of_every_shipped_study_is_valid() {
    let registry = harness::registry();
    let mut studies = 0;
    for entry in std::fs::read_dir(shipped("studies"))
        .expect("they ship")
        .flatten()
    {
        let plan = Plan::read(&entry.path(), false, &[]).expect("it is a study");
        let tasks = plan.tasks().expect("its scenarios can be read");
        for task in &tasks {
            let checked = check(&task.loaded, &registry, 1);
            let at = (entry.path(), task.index);
            assert!(
                checked.is_ok(),
                "{at:?}: {}",
                checked.expect_err("it is refused")
            );
        }
        // A study of `tune` may have only one setting and its reference, and no random scenes.
        let is_tuned = entry.file_name().to_string_lossy().starts_with("tuned-");
        assert!(runs(&tasks).len() > if is_tuned { 1 } else { 10 });
        studies += 1;
    }
    assert!(studies >= 5, "{studies}");
    let small = Plan::read(&shipped("studies/tradeoff-coupled"), true, &[]).expect("it is a study");
    let tasks = small.tasks().expect("its scenarios can be read");
    assert!(runs(&tasks).len() >= 40);
}

/// `run SCENE --budget` covers these scenes for any seed, with the errors that their files state.
#[test]
fn tuned_scenes_have_a_setting_for_any_seed() {
    let folders = std::fs::read_dir(shipped("studies")).expect("they ship");
    let names = folders
        .flatten()
        .map(|entry| entry.file_name().to_string_lossy().into_owned());
    let tuned: Vec<String> = names.filter(|name| name.starts_with("tuned-")).collect();
    for name in &tuned {
        let study = StoredStudy::read(&shipped(&format!("studies/{name}"))).expect("it ships");
        let scene = shipped(name.trim_start_matches("tuned-"));
        let loaded = load(&scene.display().to_string(), &["run.seed=77".into()]);
        let at = study.locate(&loaded.expect("a scene").resolved);
        let at = at.unwrap_or_else(|why| panic!("{name}: {why}"));
        let choice = SceneSettings::new(&study, &at).expect("there are seeds enough");
        let chosen = choice
            .within_error(None, 0.25)
            .expect("it was tuned to less");
        assert_ne!(chosen.setting.set, study.reference, "{name}");
        assert_eq!(study.reference_misses.len(), study.measures.len(), "{name}");
        // The study file has the settings of the stored study.
        let plan = Plan::read(&shipped(&format!("studies/{name}")), false, &[]).expect("a study");
        let tasks = plan.tasks().expect("its scene can be read");
        let seeds = study.scene_keys[0].values.len();
        assert_eq!(tasks.len(), seeds * study.settings.len(), "{name}");
    }
    assert!(tuned.len() >= 6, "{tuned:?}");
}

#[test]
fn the_stored_study_has_settings_for_new_loads_and_seeds() {
    let study = StoredStudy::read(&shipped("studies/quick-bonded")).expect("it ships");
    let scene = |load_n: f64| {
        let sets = [
            "run.seed=77".into(),
            format!("participant.third-body.config.wheel.load_n={load_n:?}"),
        ];
        let scenario = shipped("quick-bonded").display().to_string();
        load(&scenario, &sets).expect("it is valid").resolved
    };
    let at = study.locate(&scene(5000.0)).expect("it is covered");
    let choice = SceneSettings::new(&study, &at).expect("there are scenes enough");
    let costs = [0.05, 0.01].map(|error| {
        let chosen = choice
            .within_error(None, error)
            .expect("the study goes as far");
        assert!(
            chosen
                .predictions
                .iter()
                .all(|p| p.bound <= error && p.expected <= p.bound)
        );
        chosen.setting.cpu_rel
    });
    assert!(costs[0] < costs[1], "{costs:?}");
    assert!(
        choice.within_error(None, 1e-14).is_err(),
        "it is below the floor of noise"
    );
    let outside = study
        .locate(&scene(9000.0))
        .expect_err("the study ends at 8 000 N");
    assert!(outside.contains("load_n from 4000 to 8000"), "{outside}");
}
