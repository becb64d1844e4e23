//! The shipped studies: all their tasks are valid, and the one to choose by covers its scene.

use coordinator::run::check::check;
use coordinator::scenario::load::load;
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
        assert!(runs(&tasks).len() > 10);
        studies += 1;
    }
    assert!(studies >= 5, "{studies}");
    let small = Plan::read(&shipped("studies/tradeoff-coupled"), true, &[]).expect("it is a study");
    let tasks = small.tasks().expect("its scenarios can be read");
    assert!(runs(&tasks).len() >= 40);
}

#[test]
fn the_stored_study_has_settings_for_loads_and_seeds_that_it_has_not_seen() {
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
