//! The page of causes and cures, entry by entry.

/// The page.
const PAGE: &str = include_str!("../../../ERRORS.md");

/// An entry of the page.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Explanation {
    /// The code that it is about.
    pub code: &'static str,
    /// Everything below the code.
    pub text: &'static str,
}

/// All entries, errors before warnings.
pub fn explanations() -> impl Iterator<Item = Explanation> {
    let sections = PAGE.split("\n## ").skip(1);
    let with_codes = sections.flat_map(|section| section.split("\n### `").skip(1));
    with_codes.filter_map(|explanation| {
        let (code, text) = explanation.split_once("`\n")?;
        let text = text.trim();
        Some(Explanation { code, text })
    })
}

/// The entry of a code.
pub fn explanation(code: &str) -> Option<Explanation> {
    explanations().find(|explanation| explanation.code == code)
}

impl Explanation {
    /// What happened, in a line.
    pub fn line(&self) -> &'static str {
        let first = self.text.lines().next().unwrap_or_default();
        let ending = [" Exit code ", " A warning."];
        let end = ending.iter().filter_map(|words| first.find(words)).min();
        &first[..end.unwrap_or(first.len())]
    }
}
