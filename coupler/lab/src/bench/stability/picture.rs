//! The map as a picture: one panel per scheme and theta, mass ratio to the right, substeps upwards.

use draw::svg::{Anchor, Svg};

use super::map::{Axes, Cell};
use super::setup::word;
use scheme::keys::{Dirichlet, SchemeKeys};
use scheme::predict::prediction::NEUTRAL;

const BOX: f64 = 26.0;
const GAP: f64 = 34.0;
const LEFT: f64 = 230.0;
const TOP: f64 = 66.0;

/// Draws the largest growth over all CFL numbers and stiffness ratios.
pub fn svg(axes: &Axes, cells: &[Cell]) -> String {
    let counts = [axes.mass_ratios.len(), axes.substeps.len()];
    let panel = counts.map(|count| BOX * count as f64);
    let width = LEFT + axes.thetas.len() as f64 * (panel[0] + GAP) + 10.0;
    let height = TOP + axes.schemes.len() as f64 * (panel[1] + GAP) + 46.0;
    let mut svg = Svg::default();
    let title =
        "Largest growth of a disturbance per window, over CFL 0.1 to 0.99 and all stiffness ratios";
    svg.text([LEFT, 18.0], Anchor::Start, title);
    let axes_named =
        "right: mass ratio 1e-3 to 1e3; up: substeps 1 to 10 000; swapped: the bar follows";
    svg.text([LEFT, 36.0], Anchor::Start, axes_named);
    for (row, keys) in axes.schemes.iter().enumerate() {
        let top = TOP + row as f64 * (panel[1] + GAP);
        let beside = [LEFT - 16.0, top + 0.5 * panel[1]];
        svg.text(beside, Anchor::End, &name(keys));
        for (column, theta) in axes.thetas.iter().enumerate() {
            let left = LEFT + column as f64 * (panel[0] + GAP);
            let above = format!("theta = {theta}");
            svg.text([left, top - 6.0], Anchor::Start, &above);
            for (i, mass_ratio) in axes.mass_ratios.iter().enumerate() {
                for (j, substeps) in axes.substeps.iter().enumerate() {
                    let here = |cell: &&Cell| {
                        cell.setup.keys == *keys
                            && cell.setup.boundary_inertia.theta == *theta
                            && cell.mass_ratio == *mass_ratio
                            && cell.setup.substeps == *substeps
                    };
                    let found = cells.iter().filter(here).map(|cell| cell.growth);
                    let worst = found.fold(0.0, f64::max);
                    let place = [left + BOX * i as f64, top + panel[1] - BOX * (j + 1) as f64];
                    square(&mut svg, place, colour(worst));
                }
            }
        }
    }
    for (i, (_, colour, text)) in SCALE.iter().enumerate() {
        let at = [LEFT + 130.0 * i as f64, height - 40.0];
        square(&mut svg, at, colour);
        svg.text([at[0] + BOX + 6.0, at[1] + 18.0], Anchor::Start, text);
    }
    svg.page([width, height])
}

fn name(keys: &SchemeKeys) -> String {
    let word = word(keys.scheme);
    match keys.dirichlet() {
        Dirichlet::MotionDriven => word,
        Dirichlet::ForceDriven => format!("{word}, swapped"),
    }
}

/// Green: no growth. The other colours are ranges of growth per window.
const SCALE: [(f64, &str, &str); 6] = [
    (1.0 + NEUTRAL, "#3f9b58", "none"),
    (1.0001, "#d9e7a8", "< 0.01 %"),
    (1.01, "#f7dd72", "< 1 %"),
    (2.0, "#f2a541", "< 2-fold"),
    (100.0, "#d7553a", "< 100-fold"),
    (f64::INFINITY, "#7d1f2f", "more"),
];

fn colour(growth: f64) -> &'static str {
    let found = SCALE.iter().find(|(limit, _, _)| growth <= *limit);
    found.map_or("#000000", |(_, colour, _)| colour)
}

fn square(svg: &mut Svg, corner: [f64; 2], colour: &str) {
    let style = format!("fill=\"{colour}\" stroke=\"#fff\"");
    svg.rectangle(&style, corner, [BOX; 2]);
}
