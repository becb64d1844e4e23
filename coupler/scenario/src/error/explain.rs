//! Causes and remedies of errors and warnings, from the documentation in the code.

use kit::finding::{finding_kinds, paragraphs};

use super::code::Code;

/// The meaning of a code, its cause and its remedy.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Explanation {
    /// The code.
    pub code: &'static str,
    /// The exit code of an error; `None` for a warning.
    pub exit_code: Option<i32>,
    /// Its documentation, one paragraph or point in each entry; the first says what happened.
    pub paragraphs: Vec<String>,
}

/// All entries, errors before warnings, each in the order of their codes.
pub fn explanations() -> Vec<Explanation> {
    let error = |code: Code| Explanation {
        code: code.word(),
        exit_code: Some(code.exit_code()),
        paragraphs: paragraphs(code.doc()),
    };
    let mut all: Vec<Explanation> = Code::all().map(error).collect();
    all.sort_by_key(|explanation| explanation.code);
    all.extend(finding_kinds().into_iter().map(|kind| {
        let mut paragraphs = paragraphs(kind.doc);
        if !kind.key.is_empty() {
            let [warn, suspect] = kind.bounds_in_words();
            let tables = kind.tables.join(", ");
            let (key, of) = (kind.key, format!("`plausible` ({tables})"));
            paragraphs.push(format!(
                "- Bounds: {warn} and {suspect}; key `{key}` of {of}."
            ));
        }
        Explanation {
            code: kind.code,
            exit_code: None,
            paragraphs,
        }
    }));
    all
}

/// The entry of a code.
pub fn explanation(code: &str) -> Option<Explanation> {
    let mut all = explanations().into_iter();
    all.find(|explanation| explanation.code == code)
}

impl Explanation {
    /// What happened, in one line.
    pub fn line(&self) -> &str {
        &self.paragraphs[0]
    }

    /// Everything below the code, as Markdown.
    pub fn text(&self) -> String {
        let ending = match self.exit_code {
            Some(exit_code) => format!("Exit code {exit_code}."),
            None => "A warning.".into(),
        };
        let mut text = format!("{} {ending}\n", self.line());
        for pair in self.paragraphs.windows(2) {
            let in_list = pair.iter().all(|line| line.starts_with("- "));
            text += if in_list { "" } else { "\n" };
            text += &pair[1];
            text += "\n";
        }
        text
    }
}
