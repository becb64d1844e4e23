//! `check --schema`: the schema accepts every shipped scene, and the program refuses every scene that the schema refuses. The schema
//! refuses every unknown key, wrong type and unknown word that the program refuses.

use std::path::{Path, PathBuf};
use std::process::Command;

use coordinator::run::check::check;
use harness::json_schema::faults;
use harness::registry;
use harness::runs::{parse_json, program};
use protocol::Cause;
use scenario::error::{Code, Error};
use scenario::load::{load, parse};
use scenario::source::ScenarioSource;
use serde_json::{Value, json};

/// The schema as the program prints it.
fn schema() -> Value {
    let output = Command::new(program("thirdbody"))
        .args(["check", "--schema"])
        .output()
        .expect("the program starts");
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    parse_json(&output.stdout)
}

/// All shipped scenarios, with their text.
fn scenes() -> Vec<(PathBuf, String)> {
    let mut found = Vec::new();
    let mut folders = vec![Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenarios")];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).expect("it is there").flatten() {
            let path = entry.path();
            if path.is_dir() && !path.ends_with("target") {
                folders.push(path);
            } else if path.ends_with("scenario.toml") {
                let text = std::fs::read_to_string(&path).expect("it is text");
                found.push((path, text));
            }
        }
    }
    found
}

fn as_json(text: &str) -> Value {
    let table: toml::Table = text.parse().expect("it is TOML");
    serde_json::to_value(table).expect("TOML is JSON")
}

/// The verdict of the program on a scenario in the folder of this scene.
fn verdict(path: &Path, scenario: &Value) -> Result<(), Error> {
    let text = toml::to_string(scenario).expect("it came from TOML");
    let source = ScenarioSource {
        name: path.display().to_string(),
        text,
        overrides: Vec::new(),
    };
    check(&parse(source)?, &registry(), 1).map(|_| ())
}

/// Refusals that a schema can make.
fn is_of_form(error: &Error) -> bool {
    [Cause::UnknownKey, Cause::WrongType, Cause::UnknownWord]
        .map(Code::Of)
        .contains(&error.code())
}

/// JSON pointers to all parts of a value.
fn places(value: &Value, place: &str, found: &mut Vec<String>) {
    found.push(place.to_string());
    match value {
        Value::Object(table) => {
            for (key, member) in table {
                places(
                    member,
                    &format!("{place}/{}", key.replace('/', "~1")),
                    found,
                );
            }
        }
        // The first entries stand for a long list.
        Value::Array(list) => {
            for (index, entry) in list.iter().enumerate().take(3) {
                places(entry, &format!("{place}/{index}"), found);
            }
        }
        _ => {}
    }
}

/// Copies of a scenario, each with another value at this place.
fn mutants(scenario: &Value, place: &str) -> Vec<Value> {
    let with = |value: Value| {
        let mut mutant = scenario.clone();
        *mutant.pointer_mut(place).expect("it is there") = value;
        mutant
    };
    let old = scenario.pointer(place).expect("it is there");
    match old {
        Value::Number(_) => [
            json!("four"),
            json!(true),
            json!(-1.0),
            json!(0.0),
            json!(-3),
            json!(1e300),
            json!([1.0]),
        ]
        .map(with)
        .into(),
        Value::String(_) => [json!("zebra"), json!(7.5), json!(false)].map(with).into(),
        Value::Bool(_) => [json!(1), json!("yes")].map(with).into(),
        Value::Array(list) => {
            let mut longer = list.clone();
            longer.extend(list.first().cloned());
            [json!(1.5), json!("list"), json!([]), longer.into()]
                .map(with)
                .into()
        }
        Value::Object(table) => {
            let mut more = table.clone();
            more.insert("zebra".into(), json!(1));
            let one_less = table.keys().map(|key| {
                let mut less = table.clone();
                less.shift_remove(key);
                with(less.into())
            });
            one_less
                .chain([with(more.into()), with(json!(2.5))])
                .collect()
        }
        Value::Null => unreachable!("TOML has no null"),
    }
}

#[test]
fn every_shipped_scene_follows_the_schema() {
    let schema = schema();
    let scenes = scenes();
    assert!(scenes.len() > 30, "{}", scenes.len());
    for (path, text) in scenes {
        assert_eq!(
            faults(&schema, &as_json(&text)),
            Vec::<String>::new(),
            "{}",
            path.display()
        );
    }
}

#[test]
fn schema_and_program_agree_on_changed_scenes() {
    let schema = schema();
    let counts = std::thread::scope(|scope| {
        let halves = [0, 1].map(|half| {
            let scenes = scenes().into_iter().skip(half).step_by(2);
            let (schema, scenes) = (&schema, Vec::from_iter(scenes));
            scope.spawn(move || compared(schema, scenes))
        });
        halves.map(|half| half.join().expect("all scenes agree"))
    });
    let [refused, taken] = [0, 1].map(|k| counts[0][k] + counts[1][k]);
    assert!(
        refused > 1_000 && taken > 100,
        "{refused} refused, {taken} taken"
    );
}

/// Numbers of changed scenes that the schema refuses and takes; the program must agree.
fn compared(schema: &Value, scenes: Vec<(PathBuf, String)>) -> [usize; 2] {
    let (mut refused, mut taken) = (0, 0);
    for (path, text) in scenes {
        let scenario = as_json(&text);
        // Building a mesh of a thousand elements or more for each mutant takes long.
        if text.len() > 4_000 || verdict(&path, &scenario).is_err() {
            continue;
        }
        let mut all = Vec::new();
        places(&scenario, "", &mut all);
        for (place, mutant) in all.iter().skip(1).flat_map(|place| {
            mutants(&scenario, place)
                .into_iter()
                .map(move |mutant| (place, mutant))
        }) {
            let faults = faults(schema, &mutant);
            if faults.is_empty() {
                taken += 1;
                if let Err(error) = verdict(&path, &mutant) {
                    assert!(!is_of_form(&error), "{}: {place}: {error}", path.display());
                }
            } else {
                refused += 1;
                assert!(
                    verdict(&path, &mutant).is_err(),
                    "{}: {place}: {faults:?}",
                    path.display()
                );
            }
        }
    }
    [refused, taken]
}

/// With `dual-schur` the run would stop converging once the body flows; the secant scheme follows the flow.
#[test]
fn a_plastic_body_raises_a_warning_with_a_scheme_of_constant_compliance() {
    let quick = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenarios/quick");
    let quick = quick.display().to_string();
    let warned = |scheme: &str, yields: bool| {
        let scheme = format!("interface.layer-base.scheme={scheme}");
        let mut set = vec![scheme];
        if yields {
            let key = |pair: &str| format!("participant.rail.config.material.{pair}");
            set.extend([key("kind=j2"), key("yield_pa=5e8")]);
        }
        let loaded = load(&quick, &set).expect("it is a scenario");
        let warnings = check(&loaded, &registry(), 1).expect("it is valid");
        let of = |text: &str| text.contains("`rail` yields") && text.contains("dual-schur-secant");
        warnings.iter().filter(|warning| of(&warning.text)).count()
    };
    assert_eq!(warned("dual-schur", true), 1);
    assert_eq!(warned("dual-schur", false), 0);
    assert_eq!(warned("dual-schur-secant", true), 0);
}
