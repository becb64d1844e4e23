//! Replay of a run with several interfaces: a participant on two of them is one conversation, recorded under both names.

use std::collections::BTreeSet;

use super::{recording, replay, run_in_process};

/// Bar, chain, bar, and beside them a pair that shares nothing with them.
pub(crate) fn scenario() -> String {
    let bar = |name: &str| {
        format!(
            r#"
[[participant]]
name = "{name}"
kind = "bar"
[participant.config]
elements = 20
spacing_m = 1.0
element_mass_kg = 1.0
element_stiffness_n_per_m = 1.0
step_s = 0.9
damping = 0.5
velocity_m_per_s = 1.0
yield_elongation_m = 0.1
hardening_ratio = 0.05
"#
        )
    };
    let chain = |name: &str| {
        format!(
            r#"
[[participant]]
name = "{name}"
kind = "chain"
[participant.config]
x_m = 20.0
glued_mass_kg = 3.0
far_mass_kg = 2.0
count = 5
mass_kg = 1.0
stiffness_n_per_m = 1.0
theta = 1.0
end_s = 180.0
"#
        )
    };
    let interface = |name: &str, a: &str, b: &str, substeps: u32| {
        format!(
            r#"
[[interface]]
name = "{name}"
between = ["{a}", "{b}"]
scheme = "dual-schur-secant"
substeps = {substeps}
tolerance_rel = 1e-9
repeats_max = 40
"#
        )
    };
    [
        "[run]\nname = \"several\"\nthickness_m = 1.0\n".to_string(),
        bar("left"),
        chain("middle"),
        bar("right"),
        bar("other-bar"),
        chain("other-chain"),
        interface("lower", "left.end", "middle.end", 10),
        interface("apart", "other-bar.end", "other-chain.end", 7),
        interface("upper", "right.start", "middle.far", 10),
    ]
    .concat()
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
    let mut compared = 0;
    for who in ["left", "middle", "right", "other-bar", "other-chain"] {
        let replayed = replay(&recording, who);
        assert_eq!(replayed.departure, None, "{who}");
        compared += replayed.equal;
    }
    let coupler = replay(&recording, "coupler");
    assert_eq!(coupler.departure, None);
    assert_eq!(coupler.equal, compared);
    assert_eq!(2 * compared as usize, recording.messages.len());
}
