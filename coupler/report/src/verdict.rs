//! The verdict of a run in words: its ending, its balances against their bounds, its warnings.

use super::page::table;
use super::provenance::changed;
use draw::svg::escape;
use draw::units::{four, span, with_unit};
use kit::FindingKind;
use kit::finding::NOT_CONVERGED;
use runs::files::RunFiles;
use runs::plausible::{ENERGY_BALANCE, GAP, INTERFACE_ENERGY};
use scenario::error::Error;

/// The box at the top of the page.
pub(super) fn verdict(run: &RunFiles, damage: Option<&Error>) -> String {
    let status = run.text("status");
    let warnings = run.list("warnings").count();
    let class = match (status, damage) {
        ("completed" | "suspect", Some(_)) | ("suspect", None) => "suspect",
        ("completed", None) => "completed",
        _ => "failed",
    };
    let beyond = beyond(run);
    let ended = match (status, warnings) {
        ("completed" | "suspect", _) if damage.is_some() => "The run reached its end, but a table has changed since: do not use the figures below that are drawn from it.".into(),
        ("completed", 0) if !beyond.is_empty() => format!("The run completed without a warning, but its steps exceed bounds: {beyond}."),
        ("completed", 0) => "The run completed, and no check found anything to warn about.".into(),
        ("completed", 1) => "The run completed, with one warning.".into(),
        ("completed", count) => format!("The run completed, with {count} warnings."),
        ("suspect", _) => "The run reached its end, but some values lie beyond what can be trusted: do not use its results before you understand the warnings.".into(),
        (other, _) => format!("The run did not complete ({}): {} This page covers the run up to that point.", escape(other), escape(&sentence(run.text("message")))),
    };
    let damage = damage.map_or(String::new(), |damage| {
        format!("<p>{}</p>", escape(&sentence(&damage.to_string())))
    });
    let (extent, set) = (extent(run), set(run));
    format!(
        "<div class=\"verdict {class}\" role=\"status\"><p><strong>{ended}</strong></p>{damage}<p>{extent}</p></div>{set}"
    )
}

/// Number of keys that the head shows; it counts the rest.
const MANY: usize = 12;

/// The keys that were set for this run.
fn set(run: &RunFiles) -> String {
    let changed = changed(run);
    if changed.is_empty() {
        return String::new();
    }
    let lines = changed.iter().take(MANY).map(|line| escape(line) + "\n");
    let rest = match changed.len().saturating_sub(MANY) {
        0 => String::new(),
        rest => format!("and {rest} more, in manifest.json"),
    };
    let lines: String = lines.collect();
    format!("<p>Set for this run:</p><pre>{lines}{rest}</pre>")
}

fn sentence(message: &str) -> String {
    match message.trim_end() {
        "" => "no reason is recorded.".into(),
        text if text.ends_with('.') => text.into(),
        text => format!("{text}."),
    }
}

/// Simulated time, windows and wall-clock time.
fn extent(run: &RunFiles) -> String {
    let simulated = run.number("sim_time_s").unwrap_or(0.0);
    let wall = run.number("wall_s").unwrap_or(0.0);
    let windows = run.number("windows").unwrap_or(0.0);
    let repeats = run.number("repeats_mean");
    let repeats = repeats.map_or(String::new(), |mean| {
        let s = if mean == 1.0 { "" } else { "s" };
        format!(", {} repeat{s} each", four(mean))
    });
    let (simulated, windows, wall) = (with_unit(simulated, "s"), four(windows), span(wall));
    format!("{simulated} of simulated time in {windows} windows{repeats}; it took {wall}.")
}

/// A balance with its bound and its meaning.
type Balance = (
    &'static str,
    &'static str,
    Option<&'static FindingKind>,
    &'static str,
);

static BALANCES: [Balance; 8] = [
    (
        "energy",
        "results.energy_balance_rel",
        Some(&ENERGY_BALANCE),
        "Work done on all bodies minus stored and dissipated energy, over the sizes of all terms: each term has its own formula, and no term is the remainder.",
    ),
    (
        "gap",
        "coupling.gap_max_rel",
        Some(&GAP),
        "Largest distance of both sides of an interface at the end of a window, over the spacing of its nodes.",
    ),
    (
        "interface energy",
        "coupling.energy_defect_rel",
        Some(&INTERFACE_ENERGY),
        "Energy that the interfaces lost or made, over the energy that went through them.",
    ),
    (
        "windows not converged",
        NOT_CONVERGED_WINDOWS,
        Some(&NOT_CONVERGED),
        "Windows that were accepted although both sides did not agree.",
    ),
    (
        "action and reaction",
        "coupling.force_residual_rel",
        None,
        "Largest difference of the forces on both sides of an interface, over the largest force.",
    ),
    (
        "contact solve",
        "results.true_residual_max",
        None,
        "Largest residual of the contact laws after the solve of a step.",
    ),
    (
        "momentum",
        "results.momentum_defect_max_n",
        None,
        "Largest difference of a grain step's change of momentum and the forces on the grains (N).",
    ),
    (
        "flows",
        "results.flow_balance_rel",
        None,
        "Third body in the zone against the sum of its flows, over all flows.",
    ),
];

/// The number of windows that did not converge; the bound is on their share of all windows.
const NOT_CONVERGED_WINDOWS: &str = "coupling.not_converged_windows";

/// A balance of a run.
pub(super) struct JudgedBalance {
    pub(super) name: &'static str,
    pub(super) value: f64,
    pub(super) bound: Option<f64>,
    /// True within the bound, if there is one.
    pub(super) holds: Option<bool>,
    meaning: &'static str,
}

/// True for a number of summary.json that is a balance.
pub(super) fn is_balance(object: &str, name: &str) -> bool {
    let path = format!("{object}.{name}");
    BALANCES.iter().any(|(_, known, _, _)| *known == path)
}

/// The balances that the run has.
pub(super) fn balances(run: &RunFiles) -> Vec<JudgedBalance> {
    let plausible = run.scenario().plausible;
    let windows = run.number("windows").unwrap_or(1.0).max(1.0);
    let judged = BALANCES.iter().filter_map(|(name, path, bound, meaning)| {
        let value = run.number(path)?;
        let share = if *path == NOT_CONVERGED_WINDOWS {
            windows
        } else {
            1.0
        };
        let bound = bound.map(|kind| plausible.of(kind).warn);
        Some(JudgedBalance {
            name,
            value,
            bound,
            holds: bound.map(|bound| value / share <= bound),
            meaning,
        })
    });
    judged.collect()
}

/// The warnings, if there are any, and the balances of the run.
pub(super) fn judged(run: &RunFiles) -> String {
    let balances = balances(run).into_iter().map(|balance| {
        [
            balance.name.to_string(),
            four(balance.value),
            balance.bound.map_or(String::new(), four),
            balance.holds.map_or("", holds).into(),
            balance.meaning.to_string(),
        ]
    });
    let warnings = run.list("warnings").map(|warning| {
        let [code, place, text] =
            ["code", "where", "text"].map(|key| escape(warning[key].as_str().unwrap_or_default()));
        let [value, bound] =
            ["value", "bound"].map(|key| warning[key].as_f64().map_or(String::new(), four));
        [format!("<code>{code}</code>"), place, value, bound, text]
    });
    let warnings = table(["code", "where", "value", "bound", ""], &[2, 3], warnings);
    let mut html = String::new();
    if !warnings.is_empty() {
        html += &format!("<h3>Warnings</h3>{warnings}");
    }
    let head = ["balance", "value", "bound", "", "meaning"];
    html + "<h3>Balances</h3>" + &table(head, &[1, 2], balances)
}

fn holds(holds: bool) -> &'static str {
    ["<strong>beyond</strong>", "holds"][usize::from(holds)]
}

/// Margins that have no bound.
const MARGINS: [(&str, &str); 2] = [
    (
        "results.step_over_inertial_time",
        "step of the grains over their inertial time d sqrt(ρ/P)",
    ),
    (
        "results.bond_step_limit_s",
        "step at which bonds grow unstable (s)",
    ),
];

/// The bounds of steps that the run exceeds, and by what factor.
fn beyond(run: &RunFiles) -> String {
    let stability = run.entries("stability");
    let bounds = stability.map(|(_, of)| of["bounds"].as_array());
    let beyond = bounds.flatten().flatten().filter_map(|bound| {
        let margin = bound["margin"].as_f64().filter(|margin| *margin < 1.0)?;
        let (name, times) = (escape(bound["name"].as_str()?), four(1.0 / margin));
        Some(format!("{name} ({times} times too long)"))
    });
    Vec::from_iter(beyond).join(", ")
}

/// Steps and windows against the bounds of stability and accuracy; empty without bounds.
pub(super) fn steps(run: &RunFiles) -> String {
    let bounds = run.entries("stability").flat_map(|(name, predicted)| {
        let bounds = predicted["bounds"].as_array().into_iter().flatten();
        bounds.map(move |bound| {
            let margin = bound["margin"].as_f64().unwrap_or(f64::NAN);
            let is_stability = bound["stability"] == true;
            [
                escape(name),
                escape(bound["name"].as_str().unwrap_or_default()),
                ["accuracy", "stability"][usize::from(is_stability)].into(),
                four(margin),
                holds(margin >= 1.0).into(),
            ]
        })
    });
    let others = MARGINS.iter().filter_map(|(path, words)| {
        let (words, judged) = (words.to_string(), "not judged".into());
        Some(["".into(), words, judged, four(run.number(path)?), "".into()])
    });
    let head = ["interface", "bound", "of", "margin", ""];
    match table(head, &[3], bounds.chain(others)) {
        rows if rows.is_empty() => rows,
        rows => format!(
            "<p>The margin is the factor by which the step or window could be longer.</p>{rows}"
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn page_of(summary: serde_json::Value) -> String {
        let run = RunFiles {
            summary,
            ..RunFiles::default()
        };
        verdict(&run, None) + &judged(&run)
    }

    #[test]
    fn the_verdict_follows_status_warnings_and_bounds() {
        let sound = page_of(
            json!({"status": "completed", "warnings": [], "results": {"energy_balance_rel": 1e-9}}),
        );
        assert!(
            sound.contains("no check found anything") && sound.contains("holds"),
            "{sound}"
        );
        let coarse = page_of(
            json!({"status": "completed", "warnings": [], "stability": {"a": {"bounds": [{"name": "rebounds", "margin": 0.5}]}}}),
        );
        assert!(
            coarse.contains("exceed bounds: rebounds (2 times too long)")
                && !coarse.contains("no check found anything"),
            "{coarse}"
        );
        let off = page_of(
            json!({"status": "completed", "warnings": [{}], "results": {"energy_balance_rel": 0.02}}),
        );
        assert!(
            off.contains("one warning") && off.contains("beyond"),
            "{off}"
        );
        let suspect = page_of(json!({"status": "suspect", "warnings": [{}]}));
        assert!(
            suspect.contains("beyond what can be trusted") && suspect.contains("verdict suspect")
        );
        let lost = page_of(json!({"status": "peer_lost", "message": "participant `<rail>` died"}));
        assert!(
            lost.contains("(peer_lost): participant `&lt;rail&gt;` died. This page"),
            "{lost}"
        );
    }
}
