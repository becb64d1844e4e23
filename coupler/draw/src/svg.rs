//! A drawing in progress. Lengths are in pixels, y points downwards; a style is the text of SVG attributes.

/// The part of a text that is at its position.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Anchor {
    /// Its beginning.
    Start,
    /// Its middle.
    Middle,
    /// Its end.
    End,
}

/// Style of frames and ticks.
pub const FRAME: &str = "fill=\"none\" stroke=\"#444\"";

/// A drawing.
#[derive(Clone, Debug, Default)]
pub struct Svg {
    inside: String,
}

impl Svg {
    /// A path with this data.
    pub fn path(&mut self, style: &str, data: &str) {
        self.raw(&format!("<path {style} d=\"{data}\"/>"));
    }

    /// A line through points.
    pub fn line(&mut self, style: &str, points: impl IntoIterator<Item = [f64; 2]>) {
        let points = points.into_iter().map(|[x, y]| format!("{x:.1} {y:.1}"));
        let points = Vec::from_iter(points).join(" ");
        self.raw(&format!(
            "<polyline fill=\"none\" {style} points=\"{points}\"/>"
        ));
    }

    /// A box with this upper left corner and size.
    pub fn rectangle(&mut self, style: &str, [x, y]: [f64; 2], [width, height]: [f64; 2]) {
        let [x, y, width, height] = [x, y, width, height].map(short);
        self.path(style, &format!("M{x} {y}h{width}v{height}h-{width}z"));
    }

    /// An entry of a legend: a small area of this colour with words beside it.
    pub fn swatch(&mut self, colour: &str, [x, y]: [f64; 2], words: &str) {
        let style = format!("fill=\"{colour}\" stroke=\"#444\"");
        self.rectangle(&style, [x, y], [18.0, 12.0]);
        self.text([x + 24.0, y + 11.0], Anchor::Start, words);
    }

    /// A circle.
    pub fn circle(&mut self, style: &str, centre: [f64; 2], radius: f64) {
        self.path(style, &ellipse(centre, [radius; 2]));
    }

    /// Text with its base line at a position.
    pub fn text(&mut self, at: [f64; 2], anchor: Anchor, words: &str) {
        self.styled_text("", at, anchor, words);
    }

    /// Text with a style.
    pub fn styled_text(&mut self, style: &str, at: [f64; 2], anchor: Anchor, words: &str) {
        let [x, y] = at.map(short);
        let anchor = match anchor {
            Anchor::Start => "",
            Anchor::Middle => " text-anchor=\"middle\"",
            Anchor::End => " text-anchor=\"end\"",
        };
        let (space, words) = (if style.is_empty() { "" } else { " " }, escape(words));
        let start = format!("<text x=\"{x}\" y=\"{y}\"{anchor}{space}{style}>");
        self.raw(&format!("{start}{words}</text>"));
    }

    /// Text that reads upwards, with its middle at a position.
    pub fn upright_text(&mut self, [x, y]: [f64; 2], words: &str) {
        let ([x, y], words) = ([x, y].map(short), escape(words));
        self.raw(&format!(
            "<text transform=\"translate({x} {y}) rotate(-90)\" text-anchor=\"middle\">{words}</text>"
        ));
    }

    /// Finished SVG as a part of this drawing.
    pub fn raw(&mut self, svg: &str) {
        self.inside.push_str(svg);
    }

    /// A white page of this size with the drawing.
    pub fn page(&self, [width, height]: [f64; 2]) -> String {
        let inside = &self.inside;
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width:.0}\" height=\"{height:.0}\" viewBox=\"0 0 {width:.0} {height:.0}\" font-family=\"sans-serif\" font-size=\"13\" fill=\"#222\"><rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>{inside}</svg>"
        )
    }
}

/// Data of an ellipse with axes along x and y.
pub(crate) fn ellipse([x, y]: [f64; 2], [rx, ry]: [f64; 2]) -> String {
    let [left, y, rx, ry, d] = [x - rx, y, rx, ry, 2.0 * rx].map(short);
    format!("M{left} {y}a{rx} {ry} 0 1 0 {d} 0a{rx} {ry} 0 1 0-{d} 0")
}

/// A length in tenths of a pixel, as short as possible.
pub(crate) fn short(value: f64) -> String {
    let tenths = (10.0 * value).round() as i64;
    let (sign, size) = (if tenths < 0 { "-" } else { "" }, tenths.abs());
    match (size / 10, size % 10) {
        (whole, 0) => format!("{sign}{whole}"),
        (0, part) => format!("{sign}.{part}"),
        (whole, part) => format!("{sign}{whole}.{part}"),
    }
}

/// Text without markup: names may come from scenarios of other people.
pub fn escape(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_are_short_and_names_are_no_markup() {
        assert_eq!(
            [0.04, -0.26, 12.0, 3.5].map(short),
            ["0", "-.3", "12", "3.5"]
        );
        let mut svg = Svg::default();
        svg.text([1.0, 2.0], Anchor::End, "<b>");
        svg.rectangle(FRAME, [0.0, 0.0], [2.0, 1.5]);
        let page = svg.page([10.0, 20.0]);
        assert!(
            page.contains("text-anchor=\"end\">&lt;b&gt;</text>"),
            "{page}"
        );
        assert!(page.contains("M0 0h2v1.5h-2z") && page.contains("viewBox=\"0 0 10 20\""));
    }
}
