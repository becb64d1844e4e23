//! The map as a picture: a panel a scheme and theta, mass ratio to the right, substeps upwards.

use std::fmt::Write;

use super::map::{Axes, Cell};
use super::setup::word;
use scheme::keys::{CouplingScheme, Dirichlet};
use scheme::predict::prediction::NEUTRAL;

const BOX: f64 = 26.0;
const GAP: f64 = 34.0;
const LEFT: f64 = 230.0;
const TOP: f64 = 66.0;

/// Draws the worst growth over all CFL numbers and stiffness ratios.
pub fn svg(axes: &Axes, cells: &[Cell]) -> String {
    let panel = [
        BOX * axes.mass_ratios.len() as f64,
        BOX * axes.substeps.len() as f64,
    ];
    let width = LEFT + axes.thetas.len() as f64 * (panel[0] + GAP) + 10.0;
    let height = TOP + axes.schemes.len() as f64 * (panel[1] + GAP) + 46.0;
    let mut svg = format!(
        r##"<svg xmlns="http://www.w3.org/2000/svg" width="{width:.0}" height="{height:.0}" font-family="sans-serif" font-size="13"><rect width="100%" height="100%" fill="#ffffff"/>"##
    );
    let title =
        "Largest growth of a disturbance a window, over CFL 0.1 to 0.99 and all stiffness ratios";
    label(&mut svg, [LEFT, 18.0], title, "start");
    let axes_named =
        "right: mass ratio 1e-3 to 1e3; up: substeps 1 to 10 000; swapped: the bar follows";
    label(&mut svg, [LEFT, 36.0], axes_named, "start");
    for (row, scheme) in axes.schemes.iter().enumerate() {
        let top = TOP + row as f64 * (panel[1] + GAP);
        let place = [LEFT - 16.0, top + 0.5 * panel[1]];
        label(&mut svg, place, &name(scheme), "end");
        for (column, theta) in axes.thetas.iter().enumerate() {
            let left = LEFT + column as f64 * (panel[0] + GAP);
            let above = format!("theta = {theta}");
            label(&mut svg, [left, top - 6.0], &above, "start");
            for (i, mass_ratio) in axes.mass_ratios.iter().enumerate() {
                for (j, substeps) in axes.substeps.iter().enumerate() {
                    let here = |cell: &&Cell| {
                        cell.setup.scheme == *scheme
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
    legend(&mut svg, height - 40.0);
    svg.push_str("</svg>\n");
    svg
}

fn name(scheme: &CouplingScheme) -> String {
    let word = word(scheme.word());
    match scheme.dirichlet() {
        Dirichlet::MotionDriven => word,
        Dirichlet::ForceDriven => format!("{word}, swapped"),
    }
}

/// Green: no growth. Then by decades of what a window adds.
const SCALE: [(f64, &str, &str); 6] = [
    (1.0 + NEUTRAL, "#3f9b58", "none"),
    (1.0001, "#d9e7a8", "&lt; 0.01 %"),
    (1.01, "#f7dd72", "&lt; 1 %"),
    (2.0, "#f2a541", "&lt; 2-fold"),
    (100.0, "#d7553a", "&lt; 100-fold"),
    (f64::INFINITY, "#7d1f2f", "more"),
];

fn colour(growth: f64) -> &'static str {
    let found = SCALE.iter().find(|(limit, _, _)| growth <= *limit);
    found.map_or("#000000", |(_, colour, _)| colour)
}

fn square(svg: &mut String, [x, y]: [f64; 2], colour: &str) {
    // Writing to a string cannot fail.
    let _ = write!(
        svg,
        r##"<rect x="{x:.1}" y="{y:.1}" width="{BOX}" height="{BOX}" fill="{colour}" stroke="#ffffff"/>"##
    );
}

fn label(svg: &mut String, [x, y]: [f64; 2], text: &str, anchor: &str) {
    let _ = write!(
        svg,
        r#"<text x="{x:.1}" y="{y:.1}" text-anchor="{anchor}">{text}</text>"#
    );
}

fn legend(svg: &mut String, y: f64) {
    for (i, (_, colour, text)) in SCALE.iter().enumerate() {
        let x = LEFT + 130.0 * i as f64;
        square(svg, [x, y], colour);
        label(svg, [x + BOX + 6.0, y + 18.0], text, "start");
    }
}
