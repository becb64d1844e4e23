//! Pictures of the report, and text in them.

/// A picture of the report.
#[derive(Clone, Debug)]
pub struct Picture {
    /// Name of its file.
    pub file: String,
    /// Text below it.
    pub caption: String,
    /// The same for one who does not see it, with the numbers that it shows.
    pub alternative: String,
    /// The picture itself.
    pub svg: String,
}

/// Names come from scenarios that may not be ours.
pub(crate) fn escape(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}
