//! Drift of the answers of a solver with another parameter from the logged ones.

use std::collections::BTreeMap;

use protocol::{Kind, larger};

use super::replayed::Drift;
use draw::plot::{PlotCurve, plot};

/// Kinds of answers that are drawn.
const DRAWN: [(Kind, &str); 4] = [
    (Kind::Motion, "motion"),
    (Kind::Reaction, "reaction"),
    (Kind::Force, "force"),
    (Kind::Report, "report"),
];

/// Smallest drawn drift: logarithms have no zero.
const FLOOR: f64 = 1e-17;

/// The largest drift of each window.
pub fn by_window(drift: &[Drift], kind: Kind) -> BTreeMap<u64, f64> {
    let mut windows = BTreeMap::new();
    for drift in drift.iter().filter(|drift| drift.kind == kind as u32) {
        let largest: &mut f64 = windows.entry(drift.window).or_default();
        *largest = larger(*largest, drift.rel);
    }
    windows
}

/// The drift in the last window and the largest drift, by kind.
pub fn table(drift: &[Drift]) -> Vec<(Kind, &'static str, f64, f64)> {
    let rows = DRAWN.iter().filter_map(|(kind, name)| {
        let windows = by_window(drift, *kind);
        let last = *windows.values().last()?;
        let most = windows.values().copied().fold(0.0, larger);
        Some((*kind, *name, last, most))
    });
    rows.collect()
}

/// An SVG of the drift over the windows.
pub fn picture(drift: &[Drift]) -> String {
    let curves = DRAWN.iter().enumerate().map(|(style, (kind, label))| {
        let windows = by_window(drift, *kind).into_iter();
        let finite = windows.filter(|(_, rel)| rel.is_finite());
        let points = finite.map(|(window, rel)| (window as f64, rel.max(FLOOR)));
        PlotCurve {
            label: label.to_string(),
            points: points.collect(),
            style,
        }
    });
    let drawn = curves.filter(|curve| !curve.points.is_empty());
    let curves: Vec<PlotCurve> = drawn.collect();
    let along = "window (open loop: the other side sends the logged messages)";
    plot([along, "largest deviation, relative"], true, &curves)
}
