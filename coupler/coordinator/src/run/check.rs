//! Checks of a scenario that start nothing.

use kit::keys::refuse_if;
use protocol::Cause;

use super::unusual::unusual;
use crate::participants::launch::{config_value, setting};
use crate::participants::process::require_program;
use crate::participants::{Registry, network};
use runs::warning::{ADVICE, Warning};
use scenario::error::Result;
use scenario::keys::{FieldsFormat, Participant, TransportKind};
use scenario::load::Loaded;
use scenario::overrides::value_at;
use scheme::keys::{Interface, SchemeWord};

kit::findings! {
    /// A key has no effect in this scenario.
    ///
    /// - Why: it belongs to another coupling scheme or kind of run, belongs to fields that are not written, or names a
    ///   scene that is not shipped.
    /// - Do: remove it, or set the key that it belongs to.
    UNUSED_KEY = "unused_key";
}

/// Checks a scenario without starting anything; returns warnings for the user.
pub fn check(loaded: &Loaded, registry: &Registry, threads: usize) -> Result<Vec<Warning>> {
    let mut warnings = Vec::new();
    for participant in &loaded.scenario.participant {
        let name = &participant.name;
        if let Some(words) = &participant.launch {
            require_program(name, &words[0], &loaded.folder)?;
        }
        if let Some(command) = &participant.command {
            // A launcher looks for the command on the other host.
            if participant.launch.is_none() {
                require_program(name, &command[0], &loaded.folder)?;
            }
            continue;
        }
        let solver = registry.find(participant)?;
        let setting = setting(loaded, participant, threads);
        let found = (solver.check)(&config_value(participant), &setting).map_err(|error| {
            let key = format!("participant.{name}.config.{}", error.key);
            loaded.source.error(&key, error)
        })?;
        let found = found.iter();
        warnings.extend(found.map(|text| Warning::advice(&ADVICE, name, text)));
    }
    warnings.extend(unused(loaded));
    if let Some((name, meant)) = loaded.unknown_origin() {
        let meant = meant.map_or(String::new(), |meant| format!("; did you mean `{meant}`?"));
        let text = format!(
            "no shipped scene is named `{name}`, so the keys in which this scenario differs from it stay unknown{meant}"
        );
        warnings.push(Warning::advice(&UNUSED_KEY, "run.derived_from", text));
    }
    let key = "run.output.fields_format";
    refuse_if(
        loaded.scenario.run.output.fields_format == FieldsFormat::Vtkhdf && !cfg!(feature = "vtkhdf"),
        key,
        "`vtkhdf` needs the feature `vtkhdf`, which this program was built without",
        "build it with cargo install --locked --path coupler --features vtkhdf; or take \"vtk-xml\"",
    )
    .map_err(|error| loaded.source.error(key, error.because(Cause::InvalidValue)))?;
    network::check(loaded)?;
    for interface in &loaded.scenario.interface {
        let scheme = toml::Value::try_from(interface.scheme).expect("it is a word");
        let name = &interface.name;
        let unused = interface.given().unused().into_iter();
        warnings.extend(unused.map(|key| {
            let key = format!("interface.{name}.{key}");
            let text = format!("has no effect for scheme = {scheme} and is not used");
            Warning::advice(&UNUSED_KEY, &key, text)
        }));
    }
    warnings.extend(yielding(loaded, registry));
    warnings.extend(unusual(loaded));
    Ok(warnings)
}

/// Bounds of `run.plausible` on interfaces.
const OF_INTERFACES: [&str; 8] = [
    "gap_rel",
    "interface_energy_rel",
    "interface_work_rel",
    "force_balance_rel",
    "surface_offset_rel",
    "surface_distance_rel",
    "point_spacing_rel",
    "point_hole_rel",
];

/// Keys that belong to another kind of run.
fn unused(loaded: &Loaded) -> Vec<Warning> {
    let (scenario, output) = (&loaded.scenario, &loaded.scenario.run.output);
    let coupled = !scenario.interface.is_empty();
    let zenoh = |of: &Participant| scenario.transport(of) == TransportKind::Zenoh;
    let mut keys = vec![
        (
            "run.output.fields_every_s".to_string(),
            !output.fields,
            "with run.output.fields = false",
        ),
        (
            "run.output.flush_every_windows".into(),
            !output.exchange,
            "with run.output.exchange = false",
        ),
        ("run.output.alone_steps".into(), coupled, "in a coupled run"),
        (
            "run.checkpoints_kept".into(),
            !output.exchange || scenario.run.checkpoint_every_windows == Some(0),
            "without checkpoints",
        ),
    ];
    let elsewhere = scenario.participant.iter().any(zenoh);
    keys.extend(["run.remote", "run.deadlines.link_s"].map(|key| {
        let when = "without a participant over `zenoh`";
        (key.to_string(), !elsewhere, when)
    }));
    keys.extend(OF_INTERFACES.map(|bound| {
        let key = format!("run.plausible.{bound}");
        (key, !coupled, "without an interface")
    }));
    let all = scenario.participant.iter();
    for of in all.filter(|of| of.command.is_none()) {
        let mut joined = scenario.interface.iter().flat_map(Interface::participants);
        let alone = joined.all(|name| name != of.name);
        let [decides, without] = [
            "in a coupled run (the interface's key decides)",
            "on a body without an interface",
        ];
        let own = [
            ("solver.on_not_converged", coupled, decides),
            ("reduced.near_m", alone, without),
            ("plausible.far_field_rel", alone, without),
        ];
        let named = |key| format!("participant.{}.config.{key}", of.name);
        keys.extend(own.map(|(key, idle, when)| (named(key), idle, when)));
    }
    let table: toml::Table = loaded.resolved.parse().unwrap_or_default();
    keys.retain(|(key, idle, _)| *idle && value_at(&table, key).is_some());
    let warned = keys.into_iter().map(|(key, _, when)| {
        let text = format!("has no effect {when} and is not used");
        Warning::advice(&UNUSED_KEY, &key, text)
    });
    warned.collect()
}

/// Warnings about interfaces whose scheme assumes a constant compliance for a body that yields by its keys.
fn yielding(loaded: &Loaded, registry: &Registry) -> Vec<Warning> {
    let scenario = &loaded.scenario;
    let built_in = scenario
        .participant
        .iter()
        .filter(|of| of.command.is_none());
    let nonlinear = built_in.filter(|of| {
        let judge = registry.get(&of.kind).and_then(|solver| solver.nonlinear);
        judge.is_some_and(|judge| judge(&config_value(of)))
    });
    let nonlinear: Vec<&str> = nonlinear.map(|of| of.name.as_str()).collect();
    let linear = [SchemeWord::DualSchur, SchemeWord::DualSchurCheap];
    let interfaces = scenario.interface.iter();
    let interfaces = interfaces.filter(|interface| linear.contains(&interface.scheme));
    let joined = interfaces.filter_map(|interface| {
        let sides = interface.between.iter();
        let names = sides.filter_map(|side| side.split_once('.').map(|(name, _)| name));
        let body = nonlinear.iter().find(|body| names.clone().any(|name| name == **body))?;
        let text = format!(
            "`{body}` yields, but scheme = \"{}\" assumes a constant compliance: the run ends with not-converged when it flows; take scheme = \"dual-schur-secant\"",
            interface.scheme
        );
        Some(Warning::advice(&ADVICE, &interface.name, text))
    });
    joined.collect()
}
