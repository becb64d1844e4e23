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
pub fn escape(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}

/// A white drawing of so many pixels with text in the fonts of the page.
pub fn drawing(width: f64, height: f64, inside: &str) -> String {
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width:.0}\" height=\"{height:.0}\" viewBox=\"0 0 {width:.0} {height:.0}\" font-family=\"sans-serif\" font-size=\"13\" fill=\"#222\"><rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>{inside}</svg>"
    )
}
