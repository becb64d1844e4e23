//! Participants with one fault each: no run with one of them may end as if it were sound.

use coordinator::run::session::Ended;
use harness::broken::harmed;
use harness::runs::{Scratch, parse_json, program, run_in_process, thirdbody};
use harness::scene::{bar, body, glue, head};
use serde_json::Value;

use crate::scene::folder;

/// A short `quick` whose rail has this fault.
fn with_rail(harm: &str, sets: &[&str]) -> (Ended, Value) {
    let text = std::fs::read_to_string(folder("quick").join("scenario.toml")).expect("it ships");
    let text = harmed(&text, ["rail", harm]);
    let all = ["run.end_s=6e-5"].iter().chain(sets);
    let left = run_in_process(&text, &all.copied().collect::<Vec<_>>()).expect("it is valid");
    let summary = left.ended.summary.value();
    (left.ended, summary)
}

/// A bar with a chain that hits its end.
fn bar_and_body() -> String {
    [
        head("foreign", 1.0, ""),
        bar("bar", 20, 0.5, ""),
        body(20.0, 3.0, -1.0, "end_s = 500.0"),
        glue("dual-schur", 5, "tolerance_rel = 1e-9"),
    ]
    .concat()
}

fn codes(summary: &Value) -> Vec<&str> {
    let warnings = summary["warnings"].as_array().expect("a list");
    let codes = warnings.iter().map(|warning| warning["code"].as_str());
    codes.map(|code| code.expect("a text")).collect()
}

#[test]
fn a_sound_rail_under_another_name_raises_no_alarm() {
    for scheme in ["dual-schur", "dual-schur-cheap", "velocity"] {
        let scheme = format!("interface.layer-base.scheme={scheme}");
        let (ended, summary) = with_rail("nothing", &[&scheme]);
        assert!(ended.error.is_none(), "{scheme}: {summary:#}");
        let found = codes(&summary);
        assert!(!found.contains(&"interface_work"), "{scheme}: {found:?}");
        assert!(!found.contains(&"surface_distance"), "{scheme}: {found:?}");
    }
}

#[test]
fn a_cadence_needs_participants_that_can_be_resumed() {
    let text = std::fs::read_to_string(folder("quick").join("scenario.toml")).expect("it ships");
    let text = harmed(&text, ["rail", "no-rollback"]);
    let sets = [
        "run.end_s=6e-5",
        "run.checkpoint_every_windows=1",
        "interface.layer-base.scheme=staggered-serial",
        "interface.layer-base.unsafe_window=true",
    ];
    let refused = match run_in_process(&text, &sets) {
        Ok(left) => left.ended.error,
        Err(error) => Some(error),
    };
    let message = refused.expect("it cannot write one").to_string();
    for word in [
        "run.checkpoint_every_windows",
        "`rail`",
        "capability `resume`",
    ] {
        assert!(message.contains(word), "no {word} in: {message}");
    }
}

/// Faults in the handshake, each with words of the refusal.
const REFUSED: [(&str, &str); 7] = [
    ("nan-length", "length (m) NaN"),
    ("nan-mass", "mass (kg) NaN"),
    ("negative-mass", "mass (kg) -"),
    ("negative-step", "step_s as -"),
    ("zero-step", "step_s as 0"),
    ("zero-columns", "columns that are all zero"),
    ("asymmetric-columns", "not symmetric"),
];

#[test]
fn impossible_numbers_are_refused_at_the_handshake() {
    for (harm, words) in REFUSED {
        let (ended, summary) = with_rail(harm, &[]);
        let message = summary["message"].as_str().expect("a text");
        assert!(message.contains("`rail`"), "{harm}: {message}");
        assert!(message.contains(words), "{harm}: {message}");
        assert_eq!(ended.summary.exit_code, 4, "{harm}: {message}");
        assert_eq!(summary["windows"], 0, "{harm}");
    }
}

#[test]
fn surfaces_in_other_units_or_places_raise_a_warning() {
    let (_, summary) = with_rail("far-away", &[]);
    assert!(codes(&summary).contains(&"surface_distance"), "{summary:#}");
    let (_, summary) = with_rail("weightless", &[]);
    assert!(codes(&summary).contains(&"weightless"), "{summary:#}");
    // Wherever it lies, a crown a thousand times as large is another shape.
    let (ended, summary) = with_rail("millimetres", &[]);
    assert!(codes(&summary).contains(&"surface_offset"), "{summary:#}");
    assert_eq!(ended.summary.exit_code, 8, "{summary:#}");
}

#[test]
fn masses_that_do_not_fit_the_columns_raise_a_warning() {
    for (harm, said) in [("heavy", true), ("light", true), ("nothing", false)] {
        let (ended, summary) = with_rail(harm, &[]);
        assert_eq!(
            codes(&summary).contains(&"told_mass"),
            said,
            "{harm}: {summary:#}"
        );
        assert_eq!(ended.summary.exit_code, 0, "{harm}: {summary:#}");
    }
}

/// The chain hits the bar, and the bar returns the stored energy.
#[test]
fn dissipated_energy_that_comes_back_raises_a_warning() {
    for (harm, said) in [("tenth-stored", true), ("nothing", false)] {
        let left = run_in_process(&harmed(&bar_and_body(), ["bar", harm]), &[]);
        let summary = left.expect("it is valid").ended.summary.value();
        assert_eq!(
            codes(&summary).contains(&"dissipation"),
            said,
            "{harm}: {summary:#}"
        );
    }
}

#[test]
fn a_layer_whose_forces_contradict_its_state_is_found() {
    let text = std::fs::read_to_string(folder("quick").join("scenario.toml")).expect("it ships");
    for (harm, code) in [
        ("silent", "no_force"),
        ("halves", "interface_work"),
        ("freezes", "interface_work"),
        ("tangential", "interface_work"),
    ] {
        let sets = [
            "run.end_s=6e-5",
            "interface.layer-base.on_not_converged=accept",
        ];
        let left = run_in_process(&harmed(&text, ["third-body", harm]), &sets);
        let ended = left.expect("it is valid").ended;
        let summary = ended.summary.value();
        println!("{harm}: {:?} {}", codes(&summary), summary["message"]);
        assert!(codes(&summary).contains(&code), "{harm}: {summary:#}");
    }
}

/// A run by itself never makes the same request twice.
#[test]
fn answers_with_noise_are_found_by_asking_twice() {
    let node = program("verification-node").display().to_string();
    let mut hashes = Vec::new();
    for (participant, harm) in [("bar", "noise"), ("body", "noise"), ("bar", "nothing")] {
        let work = Scratch::new("twice");
        let mut table: toml::Table = harmed(&bar_and_body(), [participant, harm])
            .parse()
            .expect("it is TOML");
        for one in table["participant"].as_array_mut().expect("a list") {
            let kind = one["kind"].clone();
            let words = vec![toml::Value::from(node.as_str()), kind];
            one.as_table_mut()
                .expect("a table")
                .insert("command".into(), words.into());
        }
        std::fs::write(
            work.path().join("scenario.toml"),
            toml::to_string(&table).expect("it was TOML"),
        )
        .expect("it is writable");
        let accept = "interface.glue.on_not_converged=accept";
        let mut command = thirdbody(work.path());
        let output = command
            .args(["run", ".", "--json", "--out", "out", "--set", accept])
            .output();
        let output = output.expect("it starts");
        let summary = parse_json(&output.stdout);
        let said = codes(&summary).contains(&"repeat");
        assert_eq!(said, harm == "noise", "{participant} {harm}: {summary:#}");
        hashes.push(summary["hashes"]["exchange"].clone());
    }
    // The log does not hold the repeated requests.
    let left = run_in_process(&harmed(&bar_and_body(), ["bar", "nothing"]), &[]);
    let plain = left.expect("it is valid").ended.summary.value();
    assert_eq!(hashes[2], plain["hashes"]["exchange"]);
}

#[test]
fn answers_of_another_state_than_the_kept_one_are_found_by_their_work() {
    let cheap = "interface.layer-base.scheme=dual-schur-cheap";
    for (harm, sets) in [
        ("totals", &[][..]),
        ("short-repeats", &[]),
        ("large-repeats", &[]),
        ("forgets", &[]),
        ("forgets", &[cheap]),
        ("double-ledger", &[]),
        ("no-interface-work", &[]),
    ] {
        let (ended, summary) = with_rail(harm, sets);
        let found = codes(&summary);
        let said = found.contains(&"interface_work") || ended.error.is_some();
        println!(
            "{harm} {sets:?}: {} {found:?} {}",
            summary["status"], summary["message"]
        );
        assert!(said, "{harm} {sets:?}: {summary:#}");
        // A contradiction ends the run with an error; the results are kept.
        assert_eq!(ended.summary.exit_code, 3, "{harm} {sets:?}: {found:?}");
    }
}

#[test]
fn nan_in_a_report_raises_a_warning_or_ends_the_run() {
    let (ended, summary) = with_rail("nan-signal", &[]);
    assert!(codes(&summary).contains(&"not_a_number"), "{summary:#}");
    assert_eq!(ended.summary.exit_code, 0, "{summary:#}");
    let (ended, summary) = with_rail("nan-energy", &[]);
    assert_eq!(ended.summary.exit_code, 3, "{summary:#}");
}
