//! Bars of parts, one below another.

use crate::svg::{Anchor, Svg};

/// Space for names at the left, length of a bar, and distance between bars (pixels).
const LEFT: f64 = 150.0;
const LENGTH: f64 = 800.0;
const ROW: f64 = 34.0;
/// Distance between entries of the legend, and smallest length of a part with a label (pixels).
const ENTRY: f64 = 200.0;
const LABELLED: f64 = 60.0;

/// A kind of part: its words, its colour, and the colour of labels on it.
pub type PartKind = [&'static str; 3];

/// Bars of parts in the order of their kinds. The full length stands for `whole`, or for the sum of a bar's parts if it is larger.
pub fn bars<const N: usize>(
    kinds: &[PartKind; N],
    bars: &[(String, [f64; N])],
    whole: f64,
    label: impl Fn(f64) -> String,
) -> String {
    let mut svg = Svg::default();
    for (k, [words, colour, _]) in kinds.iter().enumerate() {
        svg.swatch(colour, [LEFT + ENTRY * k as f64, 6.0], words);
    }
    for (row, (name, parts)) in bars.iter().enumerate() {
        let y = 30.0 + ROW * row as f64;
        svg.text([LEFT - 10.0, y + 17.0], Anchor::End, name);
        let total = parts.iter().sum::<f64>().max(whole);
        let mut x = LEFT;
        for ([_, colour, ink], part) in kinds.iter().zip(parts) {
            let width = LENGTH * part / total;
            let style = format!("fill=\"{colour}\" stroke=\"#444\" stroke-width=\".6\"");
            svg.rectangle(&style, [x, y], [width, 24.0]);
            if width > LABELLED {
                let (style, at) = (format!("fill=\"{ink}\""), [x + 0.5 * width, y + 17.0]);
                svg.styled_text(&style, at, Anchor::Middle, &label(*part));
            }
            x += width;
        }
    }
    svg.page([LEFT + LENGTH + 20.0, 36.0 + ROW * bars.len() as f64])
}
