//! The outcome of a run, for a terminal: its ending, its balances, and the most important results, or all of them in groups.

use std::path::Path;

use super::provenance::{changed, quoted};
use super::results::groups;
use super::verdict::{balances, is_balance};
use draw::units::{four, span, with_unit, with_unit_of};
use runs::files::RunFiles;
use runs::warning::Warning;
use runs::written::names;
use serde_json::Value;

/// The most important results, in this order; a scene has some of them.
const FIRST: [&str; 22] = [
    "approach_m",
    "p0_1mm_pa",
    "p0_pa",
    "dem_p_max_tr3_pa",
    "interface_force_n",
    "wheel_contacts_90",
    "traction_ratio_mean",
    "cycle_traction_ratio",
    "gross_sliding_friction",
    "loop_area_j",
    "sn_max_velocity_pct",
    "q_source_kg",
    "q_wear_kg",
    "detached_kg",
    "all_cycles_sink_m",
    "bonds_broken",
    "ejected_grains",
    "profile_shear_over_normal",
    "profile_solid_fraction",
    "shear_localisation",
    "coordination",
    "solid_fraction",
];

/// Number of results that are shown by default.
const SHOWN: usize = 6;

/// The table that `run` ends with, from a run directory, its summary and its warnings; with all results, or the six most important ones
/// and their meanings. Names are from summary.json, numbers have four digits.
pub fn table(path: &Path, summary: Value, warnings: &[Warning], all: bool) -> String {
    let run = RunFiles {
        path: path.to_path_buf(),
        summary,
        ..RunFiles::default()
    };
    let number = |key: &str| run.number(key).unwrap_or_default();
    let mut lines = vec![
        format!("status    {}", run.text("status")),
        format!("run       {}", path.display()),
    ];
    let changed = changed(&run);
    lines.extend(changed.iter().map(|line| format!("set       {line}")));
    let time = with_unit(number("sim_time_s"), "s");
    let windows = four(number("windows"));
    lines.push(format!("simulated {time} in {windows} windows"));
    lines.push(format!("wall      {}", span(number("wall_s"))));
    if warnings.is_empty() && run.text("status") == "completed" {
        lines.push("warnings  none".into());
    }
    let warnings = warnings.iter();
    let warnings = warnings.map(|warning| format!("  {}", warning.line()));
    lines.extend(headed("Warnings", warnings));
    lines.extend(judged(&run, all));
    if !all {
        lines.extend(first(&run));
        let path = quoted(&path.display().to_string());
        let verb = if goes_on(&run) { "resume" } else { "report" };
        lines.push(format!("next: thirdbody {verb} {path}"));
        return lines.join("\n");
    }
    let coupling = run.entries("coupling");
    let rest = coupling.filter(|(name, _)| !is_balance("coupling", name));
    let rest = rest.filter_map(|(name, value)| Some(value_row(name, value.as_f64()?)));
    lines.extend(headed("Coupling", rest));
    for group in groups(&run) {
        let rows = group.results.iter();
        let rows = rows.map(|(name, value, _)| value_row(name, *value));
        lines.extend(headed(&group.title, rows));
    }
    lines.join("\n")
}

/// True for a run that was cut off and left a checkpoint to continue from.
fn goes_on(run: &RunFiles) -> bool {
    let cut_off = ["interrupted", "peer_lost", "deadline", "output_failed"];
    let mut checkpoints = names(run.path.join("checkpoints"));
    cut_off.contains(&run.text("status")) && checkpoints.next().is_some()
}

/// Lines below a head; empty without lines.
fn headed(head: &str, lines: impl Iterator<Item = String>) -> Vec<String> {
    let mut lines: Vec<String> = lines.collect();
    if !lines.is_empty() {
        lines.insert(0, head.into());
    }
    lines
}

/// The most important results with their meanings; the first ones if the scene has none of them.
fn first(run: &RunFiles) -> Vec<String> {
    let groups = groups(run);
    let all: Vec<_> = groups.iter().flat_map(|group| &group.results).collect();
    let shown = chosen(&all, |(name, ..)| name);
    let lines = shown.iter().map(|(name, value, sentence)| {
        let row = value_row(name, *value);
        format!("{row}  {sentence}")
    });
    let mut lines = headed("Results", lines);
    let rest = all.len() - shown.len();
    if rest > 0 {
        lines.push(format!("  {rest} more: --all, summary.json, or the report"));
    }
    lines
}

/// The most important ones among these results; the first ones if the scene has none of them.
pub(super) fn chosen<R>(all: &[R], name: impl Fn(&R) -> &str) -> Vec<&R> {
    let known = FIRST.iter();
    let known = known.filter_map(|first| all.iter().find(|result| name(result) == *first));
    match known.take(SHOWN).collect() {
        shown if Vec::is_empty(&shown) => all.iter().take(SHOWN).collect(),
        shown => shown,
    }
}

/// The balances that have a bound, or all balances.
fn judged(run: &RunFiles, all: bool) -> Vec<String> {
    let mut balances = balances(run);
    balances.retain(|balance| all || balance.bound.is_some());
    let rows = balances.into_iter().map(|balance| {
        let bound = balance.bound.zip(balance.holds).map(|(bound, holds)| {
            let word = if holds { "within" } else { "BEYOND" };
            format!("  {word} {}", four(bound))
        });
        row(balance.name, &four(balance.value)) + &bound.unwrap_or_default()
    });
    headed("Balances", rows)
}

fn value_row(name: &str, value: f64) -> String {
    row(name, &with_unit_of(name, value))
}

fn row(name: &str, value: &str) -> String {
    format!("  {name:<30} {value:>12}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn results_are_in_groups_with_units_and_balances_have_their_bounds() {
        let summary = json!({
            "status": "suspect", "sim_time_s": 1.7e-3, "windows": 2833, "wall_s": 2.5,
            "coupling": {"gap_max_rel": 2.1456e-16},
            "results": {"energy_balance_rel": 0.5, "approach_m": 0.000092867740966822},
        });
        let warning = Warning {
            code: "overlap".into(),
            about: "layer".into(),
            text: "much".into(),
            value: Some(0.31),
            bound: Some(0.25),
            suspect: false,
        };
        let short = table(
            Path::new("runs/a"),
            summary.clone(),
            std::slice::from_ref(&warning),
            false,
        );
        let approach = "92.87 µm  Way of the wheel towards the rail";
        assert!(
            short.contains(approach) && short.ends_with("next: thirdbody report runs/a"),
            "{short}"
        );
        assert!(!short.contains("Load and approach"), "{short}");
        let table = table(Path::new("runs/a"), summary, &[warning], true);
        let lines: Vec<String> = table
            .lines()
            .map(|l| l.split_whitespace().collect::<Vec<_>>().join(" "))
            .collect();
        for line in [
            "status suspect",
            "simulated 1.7 ms in 2\u{202f}833 windows",
            "warning[overlap]: layer: much (value 3.1000e-1, bound 2.5e-1)",
            "approach_m 92.87 µm",
            "Load and approach",
        ] {
            let line: String = line.split_whitespace().collect::<Vec<_>>().join(" ");
            assert!(lines.contains(&line), "{line} in\n{table}");
        }
        assert!(
            lines.iter().any(|l| l.starts_with("gap 2.146e-16 within")),
            "{table}"
        );
        assert!(
            lines.iter().any(|l| l.starts_with("energy 0.5 BEYOND")),
            "{table}"
        );
    }
}
