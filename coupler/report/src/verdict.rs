//! The verdict of a run in words: how it ended, its balances against their bounds, its warnings.

use super::page::table;
use super::units::{four, span, with_unit};
use coordinator::scenario::Plausible;
use draw::picture::escape;
use runs::files::RunFiles;

/// The box at the top of the page.
pub(super) fn verdict(run: &RunFiles) -> String {
    let status = run.text("status");
    let warnings = warnings(run).len();
    let class = match status {
        "completed" => "completed",
        "suspect" => "suspect",
        _ => "failed",
    };
    let ended = match (status, warnings) {
        ("completed", 0) => "The run completed, and no check found anything to warn of.".into(),
        ("completed", 1) => "The run completed, with one warning.".into(),
        ("completed", count) => format!("The run completed, with {count} warnings."),
        ("suspect", _) => "The run went to its end, but values lie beyond what can be trusted: do not use its results before the warnings are understood.".into(),
        (other, _) => format!("The run did not complete ({}): {} What follows holds up to where it came.", escape(other), escape(&sentence(run.text("message")))),
    };
    format!(
        "<div class=\"verdict {class}\" role=\"status\"><p><strong>{}</strong></p><p>{}</p></div>",
        ended,
        extent(run)
    )
}

fn sentence(message: &str) -> String {
    match message.trim_end() {
        "" => "no reason is on record.".into(),
        text if text.ends_with('.') => text.into(),
        text => format!("{text}."),
    }
}

/// Simulated time, windows and time that they took.
fn extent(run: &RunFiles) -> String {
    let simulated = run.number("sim_time_s").unwrap_or(0.0);
    let wall = run.number("wall_s").unwrap_or(0.0);
    let windows = run.number("windows").unwrap_or(0.0);
    let repeats = run.number("repeats_mean");
    let repeats = repeats.map_or(String::new(), |mean| {
        format!(
            ", {} repeat{} each",
            four(mean),
            if mean == 1.0 { "" } else { "s" }
        )
    });
    format!(
        "{} of simulated time in {} windows{repeats}; it took {}.",
        with_unit(simulated, "s"),
        four(windows),
        span(wall)
    )
}

/// A balance with what it means.
struct Balance {
    name: &'static str,
    path: &'static str,
    bound: fn(&Plausible) -> f64,
    meaning: &'static str,
}

const BALANCES: [Balance; 4] = [
    Balance {
        name: "energy",
        path: "results.energy_balance_rel",
        bound: |p| p.energy_balance_rel.warn,
        meaning: "Work done on all bodies less what they store and dissipate, over the sizes of all terms: every term has a formula of its own, none is the remainder.",
    },
    Balance {
        name: "gap",
        path: "coupling.gap_max_rel",
        bound: |p| p.gap_rel.warn,
        meaning: "Largest distance of both sides of an interface at the end of a window, over the spacing of its nodes.",
    },
    Balance {
        name: "interface energy",
        path: "coupling.energy_defect_rel",
        bound: |p| p.interface_energy_rel.warn,
        meaning: "Energy that the interfaces lost or made, over the energy that went through them.",
    },
    Balance {
        name: "windows not converged",
        path: "coupling.not_converged_windows",
        bound: |p| p.not_converged_rel.warn,
        meaning: "Windows that were accepted although both sides did not agree.",
    },
];

/// Balances without a bound of their own.
const TOLD: [(&str, &str, &str); 4] = [
    (
        "action and reaction",
        "coupling.force_residual_rel",
        "Largest difference of the forces on both sides of an interface, over the largest force.",
    ),
    (
        "contact solve",
        "results.true_residual_max",
        "Largest residual of the contact laws after the solve of a step.",
    ),
    (
        "momentum",
        "results.momentum_defect_max_n",
        "Largest difference of a grain step's change of momentum and the forces on the grains (N).",
    ),
    (
        "flows",
        "results.flow_balance_rel",
        "Third body in the zone against the books of what came and went, over all that passed.",
    ),
];

/// A table of the balances that the run has.
pub(super) fn balances(run: &RunFiles) -> String {
    let plausible = run.scenario.as_ref().map(|scenario| scenario.run.plausible);
    let plausible = plausible.unwrap_or_default();
    let mut rows = Vec::new();
    for balance in &BALANCES {
        let Some(value) = run.number(balance.path) else {
            continue;
        };
        let windows = run.number("windows").unwrap_or(1.0).max(1.0);
        let share = if balance.path.ends_with("windows") {
            value / windows
        } else {
            value
        };
        let bound = (balance.bound)(&plausible);
        let holds = if share <= bound {
            "holds"
        } else {
            "<strong>beyond</strong>"
        };
        rows.push(vec![
            balance.name.to_string(),
            four(value),
            four(bound),
            holds.to_string(),
            balance.meaning.to_string(),
        ]);
    }
    for (name, path, meaning) in TOLD {
        if let Some(value) = run.number(path) {
            rows.push(vec![
                name.into(),
                four(value),
                String::new(),
                String::new(),
                meaning.into(),
            ]);
        }
    }
    table(
        &["balance", "value", "bound", "", "meaning"],
        &[1, 2],
        &rows,
    )
}

/// Rows of the warnings: code, place, value, bound, text.
fn warnings(run: &RunFiles) -> Vec<Vec<String>> {
    let all = run.summary["warnings"].as_array().into_iter().flatten();
    let row = |warning: &serde_json::Value| {
        let text = |key: &str| escape(warning[key].as_str().unwrap_or_default());
        let number = |key: &str| warning[key].as_f64().map_or(String::new(), four);
        let code = format!("<code>{}</code>", text("code"));
        vec![
            code,
            text("where"),
            number("value"),
            number("bound"),
            text("text"),
        ]
    };
    all.map(row).collect()
}

/// The warnings, if there are any.
pub(super) fn warned(run: &RunFiles) -> Option<String> {
    let rows = warnings(run);
    let head = ["code", "where", "value", "bound", ""];
    (!rows.is_empty()).then(|| table(&head, &[2, 3], &rows))
}

/// Steps and windows against the bounds of their stability and accuracy.
pub(super) fn steps(run: &RunFiles) -> Option<String> {
    let mut rows = Vec::new();
    for (name, predicted) in run.entries("stability") {
        for bound in predicted["bounds"].as_array().into_iter().flatten() {
            let margin = bound["margin"].as_f64().unwrap_or(f64::NAN);
            let kind = if bound["stability"] == true {
                "stability"
            } else {
                "accuracy"
            };
            let holds = if margin >= 1.0 {
                "holds"
            } else {
                "<strong>beyond</strong>"
            };
            rows.push(vec![
                escape(name),
                escape(bound["name"].as_str().unwrap_or_default()),
                kind.into(),
                four(margin),
                holds.into(),
            ]);
        }
    }
    let told = [
        (
            "results.step_over_inertial_time",
            "step of the grains over their inertial time d sqrt(ρ/P)",
        ),
        (
            "results.bond_step_limit_s",
            "step at which bonds grow unstable (s)",
        ),
    ];
    for (path, words) in told {
        if let Some(value) = run.number(path) {
            rows.push(vec![
                String::new(),
                words.into(),
                "told".into(),
                four(value),
                String::new(),
            ]);
        }
    }
    let head = ["interface", "bound", "of", "margin", ""];
    let text = "<p>A margin is the factor by which the step or window could be longer.</p>";
    (!rows.is_empty()).then(|| format!("{text}{}", table(&head, &[3], &rows)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn told(summary: serde_json::Value) -> String {
        let run = RunFiles {
            summary,
            ..RunFiles::default()
        };
        verdict(&run) + &balances(&run)
    }

    #[test]
    fn the_verdict_follows_status_warnings_and_bounds() {
        let sound = told(
            json!({"status": "completed", "warnings": [], "results": {"energy_balance_rel": 1e-9}}),
        );
        assert!(
            sound.contains("no check found anything") && sound.contains("holds"),
            "{sound}"
        );
        let off = told(
            json!({"status": "completed", "warnings": [{}], "results": {"energy_balance_rel": 0.02}}),
        );
        assert!(
            off.contains("one warning") && off.contains("beyond"),
            "{off}"
        );
        let suspect = told(json!({"status": "suspect", "warnings": [{}]}));
        assert!(
            suspect.contains("beyond what can be trusted") && suspect.contains("verdict suspect")
        );
        let lost = told(json!({"status": "peer_lost", "message": "participant `<rail>` died"}));
        assert!(
            lost.contains("(peer_lost): participant `&lt;rail&gt;` died. What follows"),
            "{lost}"
        );
    }
}
