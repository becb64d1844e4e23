//! The warnings of a run.

use kit::FindingKind;
use protocol::Finding;
use serde::Serialize;

kit::findings! {
    /// A participant advises something, without a number.
    ///
    /// - Why: keys without effect, steps near their bounds, results that were left out.
    /// - Do: as its text says.
    ADVICE = "advice";
    /// The run took longer than its budget.
    ///
    /// - Why: the first second foretold less, or the machine was busy.
    /// - Do: ask for less time, or run it on an idle machine.
    BUDGET = "budget";
}

/// A line of `warnings` in summary.json.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Warning {
    /// Word for scripts: that of a check, `advice` for a text that has no number, `unused_key`.
    pub code: String,
    /// Participant, interface or key that it is about, as the scenario names it.
    #[serde(rename = "where")]
    pub about: String,
    /// The fault in words, and what to do about it.
    pub text: String,
    /// The value, where the check has one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub value: Option<f64>,
    /// The bound that it passed.
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

    /// A run that took longer (s) than the time by which its setting was chosen.
    pub fn over_budget(wall_s: f64, limit_s: f64) -> Warning {
        let text = "the run took longer than its budget: the first second foretold less, or the machine was busy with something else";
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

    /// One line for a person.
    pub fn line(&self) -> String {
        let numbers = self.value.zip(self.bound);
        let numbers = numbers.map_or_else(String::new, |(value, bound)| {
            format!(" (value {value:.4e}, bound {bound:e})")
        });
        let (code, about, text) = (&self.code, &self.about, &self.text);
        format!("warning[{code}]: {about}: {text}{numbers}")
    }
}
