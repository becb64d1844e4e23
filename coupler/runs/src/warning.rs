//! The warnings of a run.

use kit::FindingKind;
use protocol::Finding;
use serde::Serialize;

kit::findings! {
    /// Advice from a participant, without a number.
    ///
    /// - Why: keys without effect, steps near their bounds, or results that were left out.
    /// - Do: follow its text.
    ADVICE = "advice";
    /// The run took longer than its budget.
    ///
    /// - Why: the prediction from the first second was too low, or the machine was busy.
    /// - Do: ask for less time, or run it on an idle machine.
    BUDGET = "budget";
}

/// An entry of `warnings` in summary.json.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Warning {
    /// Word for scripts: the code of a check, `advice` for a text without a number, or `unused_key`.
    pub code: String,
    /// The participant, interface or key that it is about, as named in the scenario.
    #[serde(rename = "where")]
    pub about: String,
    /// The problem in words, and the remedy.
    pub text: String,
    /// The value, if the check has one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub value: Option<f64>,
    /// The bound that the value exceeds.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bound: Option<f64>,
    /// True beyond the second bound.
    #[serde(skip)]
    pub suspect: bool,
}

impl Warning {
    /// A text without a number.
    pub fn advice(kind: &FindingKind, about: &str, text: impl Into<String>) -> Warning {
        Warning {
            code: kind.code.into(),
            about: about.into(),
            text: text.into(),
            value: None,
            bound: None,
            suspect: false,
        }
    }

    /// A run that took longer (s) than its time budget.
    pub fn over_budget(wall_s: f64, limit_s: f64) -> Warning {
        let text = "the run took longer than its budget: the prediction from the first second was too low, or the machine was busy with something else";
        Warning {
            value: Some(wall_s),
            bound: Some(limit_s),
            ..Warning::advice(&BUDGET, "--budget wall", text)
        }
    }

    /// A value beyond its bound.
    pub fn of(about: &str, finding: Finding) -> Warning {
        Warning {
            code: finding.code,
            about: about.into(),
            text: finding.text,
            value: Some(finding.value),
            bound: Some(finding.bound),
            suspect: finding.suspect,
        }
    }

    /// The warning as one line.
    pub fn line(&self) -> String {
        let numbers = self.value.zip(self.bound);
        let numbers = numbers.map_or_else(String::new, |(value, bound)| {
            format!(" (value {value:.4e}, bound {bound:e})")
        });
        let (code, about, text) = (&self.code, &self.about, &self.text);
        format!("warning[{code}]: {about}: {text}{numbers}")
    }
}
