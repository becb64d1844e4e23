use super::*;
use runs::warning::ADVICE;

/// A run with an interface between a continuum without ledger and a layer that holds 100 N.
fn held(ledger: &InterfaceLedger) -> Summary {
    let load = HeldLoad {
        wanted_n: 100.0,
        mean_n: 100.0,
    };
    let named = |name: &str| (name.to_string(), ParticipantSummary::default());
    Summary {
        participants: vec![named("rail"), named("layer")],
        interfaces: vec![("base".into(), InterfaceSummary::of(ledger))],
        joins: vec![Join {
            index: 0,
            entry: 0,
            continuum: 0,
            motion_driven: 1,
        }],
        held: vec![None, Some(load)],
        ..Summary::new("test", "")
    }
}

/// Codes of the warnings about an interface of ten windows between a continuum without a ledger and a layer with the
/// energy error `unaccounted`, and the status of the run.
fn judged(ledger: InterfaceLedger, unaccounted: f64) -> (Vec<String>, &'static str) {
    let mut summary = held(&ledger);
    summary.windows = 10;
    summary.participants[1].1.energy_balance_rel = Some(unaccounted);
    summary.warnings = summary.judged(&Plausible::default(), &[Some(100.0)]);
    summary.end(0.0, None, false);
    let codes = summary.warnings.iter().map(|warning| warning.code.clone());
    (codes.collect(), summary.status)
}

#[test]
fn each_number_of_an_interface_and_a_ledger_is_judged() {
    let sound = InterfaceLedger {
        energy_j: 1.0,
        ..InterfaceLedger::default()
    };
    let with = |change: fn(&mut InterfaceLedger)| {
        let mut ledger = sound.clone();
        change(&mut ledger);
        judged(ledger, 0.0)
    };
    let one = |code: &str, status| (vec![code.to_string()], status);
    assert_eq!(judged(sound.clone(), 0.0), (vec![], "completed"));
    assert_eq!(
        judged(sound.clone(), 0.05),
        one("energy_balance", "completed")
    );
    assert_eq!(
        judged(sound.clone(), f64::NAN),
        one("energy_balance", "suspect")
    );
    assert_eq!(with(|l| l.gap_max_rel = 0.5), one("gap", "completed"));
    assert_eq!(with(|l| l.gap_max_rel = 1.5), one("gap", "suspect"));
    assert_eq!(
        with(|l| l.energy_defect_j = 0.05),
        one("interface_energy", "completed")
    );
    assert_eq!(
        with(|l| l.energy_defect_j = 0.2),
        one("interface_energy", "suspect")
    );
    assert_eq!(
        with(|l| l.not_converged = 1),
        one("not_converged", "suspect")
    );
}

#[test]
fn forces_and_the_energies_of_all_are_judged() {
    let mut summary = held(&InterfaceLedger::default());
    let judged = |summary: &Summary, through| {
        let found = summary.judged(&Plausible::default(), &[Some(through)]);
        let pairs = found.into_iter().map(|found| (found.code, found.about));
        pairs.collect::<Vec<_>>()
    };
    let one = |code: &str, about: &str| vec![(code.to_string(), about.to_string())];
    assert_eq!(judged(&summary, 50.0), one("force_balance", "layer"));
    summary.results.insert("energy_balance_rel".into(), 0.05);
    assert_eq!(judged(&summary, 100.0), one("energy_balance", "run"));
    // Without others, a participant's own balance is the balance of all.
    summary.participants.pop();
    summary.interfaces.clear();
    assert_eq!(judged(&summary, 100.0), vec![]);
}

#[test]
fn a_layer_gives_its_load_to_the_continuum_and_not_the_other_way_round() {
    let join = Join {
        index: 1,
        entry: 0,
        continuum: 0,
        motion_driven: 2,
    };
    let through = [None, Some(7.0)];
    assert_eq!(join.force_of(2, &through), Some(7.0));
    assert_eq!(join.force_of(0, &through), Some(-7.0));
    assert_eq!(join.force_of(1, &through), None);
}

#[test]
fn an_error_outranks_suspect_and_strict_makes_any_warning_suspect() {
    let mut summary = Summary::new("test", "");
    summary.warnings = vec![Warning::advice(&ADVICE, "rail", "take care")];
    summary.end(0.0, None, false);
    assert_eq!((summary.status, summary.exit_code), ("completed", 0));
    summary.end(0.0, None, true);
    assert_eq!((summary.status, summary.exit_code), ("suspect", 8));
    let error = Error::Interrupted { signal: 2 };
    summary.end(0.0, Some(&error), true);
    assert_eq!((summary.status, summary.exit_code), ("interrupted", 130));
}

#[test]
fn a_result_of_several_participants_has_their_names_in_front() {
    let mut summary = held(&InterfaceLedger::default());
    let farewell_with = |results: &[(&str, f64)]| {
        let mut farewell = Farewell::default();
        let results = results
            .iter()
            .map(|(name, value)| (name.to_string(), *value));
        farewell.outcome.results = results.collect();
        farewell
    };
    summary.farewell(vec![
        farewell_with(&[("disks", 3.0), ("p_max_nodal_pa", 1.0)]),
        farewell_with(&[("disks", 4.0)]),
    ]);
    let found = summary
        .results
        .iter()
        .map(|(name, value)| (name.as_str(), *value));
    let expected = [
        ("layer.disks", 4.0),
        ("p_max_nodal_pa", 1.0),
        ("rail.disks", 3.0),
    ];
    assert_eq!(Vec::from_iter(found), expected);
}
