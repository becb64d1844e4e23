//! The colour scale of maps, which darkens from 0 to its end so that it is readable in grey, and its bar.

use crate::axis::labelled;
use crate::svg::{Anchor, FRAME, Svg};

/// Colours at equal distances along the scale.
const STOPS: [[f64; 3]; 6] = [
    [250.0, 246.0, 233.0],
    [253.0, 221.0, 158.0],
    [249.0, 170.0, 91.0],
    [226.0, 101.0, 66.0],
    [164.0, 38.0, 69.0],
    [72.0, 11.0, 58.0],
];
/// Fill for values below zero: hatched, as light as zero.
const BELOW: &str = "url(#below)";
const HATCH: &str = "<pattern id=\"below\" width=\"6\" height=\"6\" patternUnits=\"userSpaceOnUse\" patternTransform=\"rotate(45)\"><path fill=\"#edf3fa\" d=\"M0 0h6v6h-6z\"/><path fill=\"#a9bfd8\" d=\"M0 0h1v6h-1z\"/></pattern>";
/// Number of shades: shapes of one shade are one path of the file.
const SHADES: f64 = 40.0;

/// A scale from 0 to `end`.
#[derive(Clone, Debug)]
pub struct ColourScale {
    /// Quantity and unit, `hydrostatic pressure (MPa)`.
    pub quantity: String,
    /// Value at the end of the scale, in that unit.
    pub end: f64,
    /// Word for values below zero, if there may be any.
    pub below: Option<&'static str>,
}

impl ColourScale {
    /// A scale of this quantity up to `end`, with a word for values below zero.
    pub fn new(quantity: &str, end: f64, below: Option<&'static str>) -> ColourScale {
        ColourScale {
            quantity: quantity.into(),
            end,
            below,
        }
    }

    /// Colour of a value.
    pub fn colour(&self, value: f64) -> String {
        let share = value / self.end;
        if share < 0.0 && self.below.is_some() {
            return BELOW.into();
        }
        shade(share)
    }

    /// Draws the bar with its labels at the top right of a picture of this width (pixels).
    pub fn bar(&self, svg: &mut Svg, width: f64) {
        const LENGTH: f64 = 260.0;
        let left = width - LENGTH - 60.0;
        for k in 0..SHADES as usize {
            let style = format!("fill=\"{}\"", shade((k as f64 + 0.5) / SHADES));
            let x = left + LENGTH * k as f64 / SHADES;
            svg.rectangle(&style, [x, 8.0], [LENGTH / SHADES + 0.5, 12.0]);
        }
        svg.rectangle(FRAME, [left, 8.0], [LENGTH, 12.0]);
        svg.text([left - 10.0, 19.0], Anchor::End, &self.quantity);
        for (value, label) in labelled([0.0, self.end], 5) {
            let x = left + LENGTH * value / self.end;
            svg.text([x, 35.0], Anchor::Middle, &label);
        }
        if let Some(word) = self.below {
            svg.raw(HATCH);
            svg.swatch(BELOW, [60.0, 8.0], word);
        }
    }
}

/// A drawing whose hatch has a unique name on a page with several drawings.
pub fn owned(svg: &str, file: &str) -> String {
    let name = file.trim_end_matches(".svg");
    svg.replace(BELOW, &format!("url(#below-{name})"))
        .replace("id=\"below\"", &format!("id=\"below-{name}\""))
}

/// Colour of a share of the scale.
pub fn shade(share: f64) -> String {
    let share = ((share * SHADES).floor() + 0.5) / SHADES;
    let stops = share.clamp(0.0, 1.0) * (STOPS.len() - 1) as f64;
    let below = (stops as usize).min(STOPS.len() - 2);
    let t = stops - below as f64;
    let channel = |k: usize| {
        let (from, to) = (STOPS[below][k], STOPS[below + 1][k]);
        (from + t * (to - from)).round() as u8
    };
    format!("#{:02x}{:02x}{:02x}", channel(0), channel(1), channel(2))
}

/// The smallest number with one or two significant digits, the second a 5, that is not below `value`; 1 if `value` is not positive.
pub fn full_scale(value: f64) -> f64 {
    if !(value > 0.0 && value.is_finite()) {
        return 1.0;
    }
    let exponent = value.log10().floor();
    let halves = (2.0 * value / 10f64.powf(exponent) * (1.0 - 1e-12)).ceil();
    // Parsed from text, the number is the nearest to the decimal one.
    let rounded = format!("{}e{exponent}", 0.5 * halves);
    rounded.parse().unwrap_or(value)
}

/// End of a scale (MPa) for pressures up to this largest one (Pa); 1 MPa without pressure.
pub fn full_mpa(largest_pa: f64) -> f64 {
    if largest_pa > 0.0 {
        return 1e-6 * full_scale(largest_pa);
    }
    1.0
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Relative luminance of an sRGB colour without gamma, which is enough for an order.
    fn lightness(colour: &str) -> f64 {
        let channel = |at: usize| {
            let value = u8::from_str_radix(&colour[at..at + 2], 16).expect("hexadecimal");
            f64::from(value)
        };
        0.2126 * channel(1) + 0.7152 * channel(3) + 0.0722 * channel(5)
    }

    #[test]
    fn the_scale_darkens_from_end_to_end() {
        let all: Vec<f64> = (0..=40)
            .map(|k| lightness(&shade(f64::from(k) / 40.0)))
            .collect();
        let darker = all.windows(2).take(39).all(|pair| pair[0] > pair[1]);
        assert!(darker, "{all:?}");
        let scale = ColourScale::new("p (MPa)", 10.0, Some("tension"));
        assert_eq!(scale.colour(-1.0), BELOW);
        assert_eq!(scale.colour(1e9), shade(1.0));
        let mut svg = Svg::default();
        scale.bar(&mut svg, 600.0);
        assert!(svg.page([600.0, 44.0]).contains("id=\"below\""));
    }

    #[test]
    fn scales_end_at_round_numbers() {
        let ends = [0.0, 3.1, 671.4, 1000.0, 0.052].map(full_scale);
        assert_eq!(ends, [1.0, 3.5, 700.0, 1000.0, 0.055]);
    }
}
