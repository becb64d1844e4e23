//! Replay of a run with several interfaces: a participant on two of them is one conversation, recorded under both names.

use std::collections::BTreeSet;

use harness::scene;

use super::resume::shipped;
use super::{recording, repeats_every_bit, run_in_process};

/// Bar, chain, bar, and a separate pair.
pub(crate) fn scenario() -> String {
    let soft = "velocity_m_per_s = 1.0\nyield_elongation_m = 0.1\nhardening_ratio = 0.05";
    let bar = |name: &str| scene::bar(name, 20, 0.9, soft);
    let ends = "glued_mass_kg = 3.0\nfar_mass_kg = 2.0\ntheta = 1.0\nend_s = 180.0";
    let chain = |name: &str| scene::chain(name, 20.0, 5, ends);
    let interface = |name: &str, between: [&str; 2], substeps: u32| {
        let keys = "tolerance_rel = 1e-9\nrepeats_max = 40";
        scene::interface(name, between, "dual-schur-secant", substeps, keys)
    };
    [
        scene::head("several", 1.0, ""),
        bar("left"),
        chain("middle"),
        bar("right"),
        bar("other-bar"),
        chain("other-chain"),
        interface("lower", ["left.end", "middle.end"], 10),
        interface("apart", ["other-bar.end", "other-chain.end"], 7),
        interface("upper", ["right.start", "middle.far"], 10),
    ]
    .concat()
}

#[test]
fn a_periodic_layer_its_rails_and_the_coupler_repeat_every_bit() {
    let scene = shipped("verification/layer-that-repeats").join("scenario.toml");
    let text = std::fs::read_to_string(scene).expect("it is shipped");
    let left = run_in_process(&text, &["run.end_s=1.5e-5", "run.output.exchange=true"]);
    let left = left.expect("it is valid").completed();
    let log = left.scratch.path().join("exchange.mcap");
    let recording = recording(&log, &[]).expect("it was closed");
    repeats_every_bit(&recording, &["lower", "third-body", "upper"]);
}

/// Two layers on the modes of one strip, in windows that are halved.
pub(crate) fn halved_modes() -> String {
    let policy = "tolerance_rel = 1e-10\nrepeats_max = 2\non_not_converged = \"halve\"\nmapping = \"linear\"";
    scene::layers_between("reduced = { modes = 12 }", policy, 1e-5)
}

#[test]
fn modes_below_two_layers_and_the_coupler_repeat_every_bit() {
    let left = run_in_process(&halved_modes(), &["run.output.exchange=true"])
        .expect("it is valid")
        .completed();
    assert!(left.number("coupling.halved_windows") > 0.0);
    let recording =
        recording(&left.scratch.path().join("exchange.mcap"), &[]).expect("it was closed");
    repeats_every_bit(&recording, &["lower", "upper", "layer-0", "layer-1"]);
}

#[test]
fn every_participant_of_every_group_and_the_coupler_repeat_every_bit() {
    let left = run_in_process(&scenario(), &[])
        .expect("it is valid")
        .completed();
    let recording =
        recording(&left.scratch.path().join("exchange.mcap"), &[]).expect("it was closed");
    let streams: BTreeSet<(&str, u32)> = recording
        .messages
        .iter()
        .map(|message| {
            let interface = message.frame.header.interface;
            (message.interface.as_str(), interface)
        })
        .collect();
    let expected = [("apart", 1), ("lower", 0), ("lower+upper", 0), ("upper", 2)];
    assert_eq!(streams, BTreeSet::from(expected));
    let participants = ["left", "middle", "right", "other-bar", "other-chain"];
    repeats_every_bit(&recording, &participants);
}
