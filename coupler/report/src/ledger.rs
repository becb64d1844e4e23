//! Curves of the balances that a run has: interfaces, energies, bonds and flows of third body.

use super::curves::{Chart, YAxis, of_found, over_time};
use runs::files::RunFiles;
use runs::table::Table;

/// Force, repeats, gap and work of each interface; iterations and residual of the contact solve.
pub(super) fn interfaces(run: &RunFiles) -> Vec<Chart> {
    let names: Vec<&String> = run.entries("interfaces").map(|(name, _)| name).collect();
    let mut charts = Vec::new();
    for name in &names {
        // A single interface needs no prefix.
        let (prefix, suffix) = match names.len() {
            1 => (String::new(), String::new()),
            _ => (format!("{name}."), format!("-{name}")),
        };
        let mut add = |file: &str, caption: String, y: YAxis, lines: &[(&str, &str)]| {
            let mut chart = over_time(&format!("{file}{suffix}.svg"), &caption, y, lines);
            for (_, signal) in &mut chart.lines {
                signal.insert_str(0, &prefix);
            }
            charts.push(chart);
        };
        add(
            "interface-force",
            format!("Force through `{name}`, on the body that follows it"),
            YAxis::Linear("force (N)", 1.0),
            &[("along x", "interface_fx_n"), ("along y", "interface_fy_n")],
        );
        add(
            "interface-gap",
            format!("Distance of both sides of `{name}`, over the spacing of its nodes"),
            YAxis::Log("gap over node spacing"),
            &[("gap", "gap_rel")],
        );
        add(
            "interface-repeats",
            format!("Repeats of each window of `{name}`"),
            YAxis::Linear("repeats", 1.0),
            &[("repeats", "repeats")],
        );
    }
    charts.extend([
        works(&run.signals),
        over_time(
            "contact-residual.svg",
            "Residual of the contact solve of each window, which has a tolerance",
            YAxis::Log("residual"),
            &[("true residual", "true_residual")],
        ),
        over_time(
            "contact-iterations.svg",
            "Iterations of the contact solve of each window",
            YAxis::Linear("iterations", 1.0),
            &[("iterations", "iterations")],
        ),
    ]);
    charts
}

/// The work through the interfaces as each participant reports it.
fn works(signals: &Table) -> Chart {
    let works = ["interface_work_j", "interface_j"];
    let participant = |name: &str| {
        let (participant, signal) = name.split_once('.')?;
        works.contains(&signal).then(|| participant.to_string())
    };
    let columns = signals.chosen(|name| participant(name).is_some());
    let lines = columns.iter();
    let lines = lines.filter_map(|(name, _)| Some((participant(name)?, name.to_string())));
    of_found(
        "interface-work.svg",
        "Work that each participant received through its interfaces: what one gives, the other takes",
        YAxis::Linear("work (mJ)", 1e3),
        lines.collect(),
    )
}

/// Relative to the largest term, a smaller term would look like a line at zero.
const SEEN: f64 = 1e-4;

/// The terms of the energy balance of each participant.
pub(super) fn energies(run: &RunFiles) -> Vec<Chart> {
    let chart = |(name, participant): (&String, &serde_json::Value)| {
        let terms = participant["energy"].as_object().into_iter().flatten();
        let terms = terms.filter_map(|(term, _)| {
            let prefixed = format!("{name}.{term}");
            let signal = [&prefixed, term];
            let found = signal.iter();
            let mut found = found.filter_map(|signal| Some((signal, run.signals.get(signal)?)));
            let (signal, values) = found.next()?;
            let finite = values.iter().filter(|x| x.is_finite());
            let largest = finite.fold(0.0, |most: f64, x| most.max(x.abs()));
            let words = term.strip_suffix("_j").unwrap_or(term).replace('_', " ");
            Some((words, signal.to_string(), largest))
        });
        let terms: Vec<(String, String, f64)> = terms.collect();
        let most = terms.iter();
        let most = most.map(|(.., largest)| *largest).fold(0.0, f64::max);
        let seen = terms.iter().filter(|(.., largest)| *largest > SEEN * most);
        let lines = seen.map(|(words, signal, _)| (words.clone(), signal.clone()));
        let lines: Vec<(String, String)> = lines.collect();
        let rest = match terms.len() - lines.len() {
            0 => String::new(),
            1 => " (a term below 0.01 % of the largest is not drawn)".into(),
            count => format!(" ({count} terms below 0.01 % of the largest are not drawn)"),
        };
        of_found(
            &format!("energy-{name}.svg"),
            &format!("Terms of the energy balance of `{name}`{rest}"),
            YAxis::Linear("energy (mJ)", 1e3),
            lines,
        )
    };
    run.entries("participants").map(chart).collect()
}

/// Bonds and flows over time.
pub(super) fn third_body() -> [Chart; 3] {
    [
        over_time(
            "bonds.svg",
            "Bonds between grains",
            YAxis::Linear("bonds", 1.0),
            &[("bonds", "bonds")],
        ),
        over_time(
            "flows.svg",
            "Flows of third body since the start, real masses",
            YAxis::Linear("mass (µg)", 1e9),
            &[
                ("Qs, detached", "q_source_kg"),
                ("Qw, worn", "q_wear_kg"),
                ("Qr, came back", "q_recirculated_kg"),
                ("Qi, net", "q_internal_net_kg"),
                ("Qe, fed in", "q_external_kg"),
                ("third body in the zone", "third_body_zone_kg"),
            ],
        ),
        over_time(
            "contacts.svg",
            "Closed contacts of grains",
            YAxis::Linear("contacts", 1.0),
            &[("contacts", "contacts")],
        ),
    ]
}

/// Forces of sets that a motion drives.
pub(super) fn reactions(signals: &Table) -> Chart {
    let ends = ["_reaction_x_n", "_reaction_y_n"];
    let columns = signals.chosen(|name| ends.iter().any(|end| name.ends_with(end)));
    let words = |name: &str| name.strip_suffix("_n").unwrap_or(name).replace('_', " ");
    let lines = columns.iter();
    let lines = lines.map(|(name, _)| (words(name), name.to_string()));
    of_found(
        "reactions.svg",
        "Forces that driven sets exert on their bodies",
        YAxis::Linear("force (N)", 1.0),
        lines.collect(),
    )
}

/// The force of each set that is moved over time along x or y, over its displacement.
pub(super) fn loops(signals: &Table) -> Vec<Chart> {
    let of = |direction: &str| {
        let end = format!("_reaction_{direction}_n");
        let forces = signals.chosen(|name| name.ends_with(&end));
        let pairs = forces.into_iter().filter_map(|(force, _)| {
            let set = force.strip_suffix(&end)?;
            let moved = format!("{set}_displacement_{direction}_m");
            signals.get(&moved)?;
            Some(Chart {
                x: ("displacement (µm)", moved.into(), 1e6),
                ..over_time(
                    &format!("loop-{}-{direction}.svg", set.replace('.', "-")),
                    "Force of a driven set on its body over its displacement: the area of a loop is the work of its cycle",
                    YAxis::Linear("force (N)", 1.0),
                    &[(&format!("{set}, along {direction}"), force)],
                )
            })
        });
        Vec::from_iter(pairs)
    };
    ["x", "y"].into_iter().flat_map(of).collect()
}
