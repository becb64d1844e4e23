//! Curves of the balances of a run: interfaces, energies, bonds and flows of third body, as many as it has.

use super::curves::{Axis, Chart, over_time};
use runs::columns::Columns;
use runs::files::RunFiles;

/// Force, repeats, gap and work of each interface, iterations and residual of the contact solve.
pub(super) fn interfaces(run: &RunFiles) -> Vec<Chart> {
    let names: Vec<&String> = run.entries("interfaces").map(|(name, _)| name).collect();
    let mut charts = Vec::new();
    for name in &names {
        // One interface needs no prefix.
        let (prefix, suffix) = match names.len() {
            1 => (String::new(), String::new()),
            _ => (format!("{name}."), format!("-{name}")),
        };
        let lines = |all: &[(&str, &str)]| -> Vec<(String, String)> {
            let own = all.iter();
            own.map(|(word, signal)| (word.to_string(), format!("{prefix}{signal}")))
                .collect()
        };
        let chart = |file: &str, caption: String, y: Axis, all: &[(&str, &str)]| Chart {
            lines: lines(all),
            ..over_time(&format!("{file}{suffix}.svg"), &caption, y, &[])
        };
        charts.push(chart(
            "interface-force",
            format!("Force through `{name}`, on the body that follows it"),
            Axis::y("force (N)", 1.0),
            &[("along x", "interface_fx_n"), ("along y", "interface_fy_n")],
        ));
        charts.push(chart(
            "interface-gap",
            format!("Distance of both sides of `{name}`, over the spacing of its nodes"),
            Axis::log("gap over node spacing"),
            &[("gap", "gap_rel")],
        ));
        charts.push(chart(
            "interface-repeats",
            format!("Repeats of each window of `{name}`"),
            Axis::y("repeats", 1.0),
            &[("repeats", "repeats")],
        ));
    }
    charts.extend(works(&run.signals));
    charts.push(over_time(
        "contact-residual.svg",
        "Residual of the contact solve of each window, which is held against its tolerance",
        Axis::log("residual"),
        &[("true residual", "true_residual")],
    ));
    charts.push(over_time(
        "contact-iterations.svg",
        "Iterations of the contact solve of each window",
        Axis::y("iterations", 1.0),
        &[("iterations", "iterations")],
    ));
    charts
}

/// The work through the interfaces as each participant tells it; what one gives the other takes.
fn works(signals: &Columns) -> Option<Chart> {
    let told = ["interface_work_j", "interface_j"];
    let names = signals.keys().filter(|name| {
        name.split_once('.')
            .is_some_and(|(_, signal)| told.contains(&signal))
    });
    let lines: Vec<(String, String)> = names
        .map(|name| {
            (
                name.split('.').next().unwrap_or_default().to_string(),
                name.clone(),
            )
        })
        .collect();
    (!lines.is_empty()).then(|| Chart {
        lines,
        ..over_time(
            "interface-work.svg",
            "Work that each participant received through its interfaces: what one gives, the other takes",
            Axis::y("work (mJ)", 1e3),
            &[],
        )
    })
}

/// The terms of the energy balance of each participant.
pub(super) fn energies(run: &RunFiles) -> Vec<Chart> {
    let mut charts = Vec::new();
    for (name, participant) in run.entries("participants") {
        let terms = participant["energy"].as_object().into_iter().flatten();
        let terms = terms.filter_map(|(term, _)| {
            let prefixed = format!("{name}.{term}");
            let signal = [&prefixed, term]
                .into_iter()
                .find(|s| run.signals.contains_key(*s))?;
            let words = term.strip_suffix("_j").unwrap_or(term).replace('_', " ");
            Some((words, signal.clone()))
        });
        let lines: Vec<(String, String)> = terms.collect();
        let largest = |signal: &str| -> f64 {
            let values = run.signals[signal].iter().copied();
            values
                .filter(|x| x.is_finite())
                .fold(0.0, |most, x| most.max(x.abs()))
        };
        let most = lines
            .iter()
            .map(|(_, signal)| largest(signal))
            .fold(0.0, f64::max);
        // What is less than a hundredth of a per cent would be one line at zero with the others.
        let seen: Vec<(String, String)> = lines
            .iter()
            .filter(|(_, signal)| largest(signal) > 1e-4 * most)
            .cloned()
            .collect();
        let hidden = lines.len() - seen.len();
        let rest = match hidden {
            0 => String::new(),
            count => format!(" ({count} terms below 0.01 % of the largest are not drawn)"),
        };
        charts.push(Chart {
            lines: seen,
            ..over_time(
                &format!("energy-{name}.svg"),
                &format!("Terms of the energy balance of `{name}`{rest}"),
                Axis::y("energy (mJ)", 1e3),
                &[],
            )
        });
    }
    charts
}

/// Bonds and flows over time.
pub(super) fn third_body() -> Vec<Chart> {
    vec![
        over_time(
            "bonds.svg",
            "Bonds between grains",
            Axis::y("bonds", 1.0),
            &[("bonds", "bonds")],
        ),
        over_time(
            "flows.svg",
            "Flows of third body since the start, real masses",
            Axis::y("mass (µg)", 1e9),
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
            Axis::y("contacts", 1.0),
            &[("contacts", "contacts")],
        ),
    ]
}

/// Forces of sets that a motion drives.
pub(super) fn reactions(signals: &Columns) -> Vec<Chart> {
    let ends = ["_reaction_x_n", "_reaction_y_n"];
    let names = signals
        .keys()
        .filter(|name| ends.iter().any(|end| name.ends_with(end)));
    let lines: Vec<(String, String)> = names
        .map(|name| {
            (
                name.strip_suffix("_n").unwrap_or(name).replace('_', " "),
                name.clone(),
            )
        })
        .collect();
    if lines.is_empty() {
        return Vec::new();
    }
    vec![Chart {
        lines,
        ..over_time(
            "reactions.svg",
            "Forces that driven sets exert on their bodies",
            Axis::y("force (N)", 1.0),
            &[],
        )
    }]
}
