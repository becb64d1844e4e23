//! Parts of the scene on a page: their axes and what is painted in them.

use std::collections::HashMap;
use std::fmt::Write as _;

use draw::axis::labelled;
use draw::colour::Scale;
use draw::picture::{drawing, escape};
use runs::fields::{Arrays, numbers};

/// Width of a page of maps, largest height of one of them, and least width and height (pixels).
const WIDTH: f64 = 1080.0;
const HEIGHT_MAX: f64 = 560.0;
const LEAST: f64 = 90.0;
/// Space around a map (pixels): left, right, above, below.
const SPACE: [f64; 4] = [58.0, 14.0, 8.0, 44.0];
/// Height of the colour bar, and of a heading (pixels).
const BAR: f64 = 44.0;
const HEADING: f64 = 22.0;

/// A part of the scene (mm).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct View {
    pub(super) x_mm: [f64; 2],
    pub(super) y_mm: [f64; 2],
}

impl View {
    /// The smallest that holds all of these circles: centre (mm) and radius (mm). `None` without any.
    pub(super) fn around(circles: impl Iterator<Item = ((f64, f64), f64)>) -> Option<View> {
        let none = [f64::INFINITY, f64::NEG_INFINITY];
        let (x_mm, y_mm) = circles.fold((none, none), |(x, y), ((at_x, at_y), radius)| {
            let with =
                |[low, high]: [f64; 2], at: f64| [low.min(at - radius), high.max(at + radius)];
            (with(x, at_x), with(y, at_y))
        });
        (x_mm[0] <= x_mm[1]).then_some(View { x_mm, y_mm })
    }

    /// Width (mm).
    pub(super) fn width_mm(&self) -> f64 {
        self.x_mm[1] - self.x_mm[0]
    }

    /// Height (mm).
    pub(super) fn height_mm(&self) -> f64 {
        self.y_mm[1] - self.y_mm[0]
    }

    /// The view with margins (mm) at its sides, below and above.
    pub(super) fn with_margin(self, side: f64, below: f64, above: f64) -> View {
        View {
            x_mm: [self.x_mm[0] - side, self.x_mm[1] + side],
            y_mm: [self.y_mm[0] - below, self.y_mm[1] + above],
        }
    }

    /// The part of it that another one holds too.
    pub(super) fn within(self, other: &View) -> View {
        let common = |a: [f64; 2], b: [f64; 2]| [a[0].max(b[0]), a[1].min(b[1])];
        View {
            x_mm: common(self.x_mm, other.x_mm),
            y_mm: common(self.y_mm, other.y_mm),
        }
    }

    /// The view, wider or higher where it would be too narrow or too flat to be seen with the same scale along x and y.
    pub(super) fn to_scale(self) -> View {
        let scale = self.common_scale();
        let missing = |length: f64| 0.5 * (LEAST / scale - length).max(0.0);
        let (side, edge) = (missing(self.width_mm()), missing(self.height_mm()));
        self.with_margin(side, edge, edge)
    }

    /// Pixels a millimetre that both axes may have.
    fn common_scale(&self) -> f64 {
        let width = WIDTH - SPACE[0] - SPACE[1];
        let [w, h] = [self.width_mm(), self.height_mm()].map(|length| length.max(1e-9));
        (width / w).min(HEIGHT_MAX / h)
    }

    /// Pixels a millimetre along x and y, the same but for a body that is very tall or very flat, which keeps a width and a height
    /// that can be seen.
    fn scales(&self) -> [f64; 2] {
        let scale = self.common_scale();
        [self.width_mm(), self.height_mm()].map(|length| scale.max(LEAST / length.max(1e-9)))
    }

    /// True where both scales are the same.
    pub(super) fn is_to_scale(&self) -> bool {
        let [x, y] = self.scales();
        (x / y - 1.0).abs() < 1e-9
    }

    /// True for a place (mm) inside of it.
    pub(super) fn holds(&self, (x, y): (f64, f64)) -> bool {
        (self.x_mm[0]..=self.x_mm[1]).contains(&x) && (self.y_mm[0]..=self.y_mm[1]).contains(&y)
    }
}

/// A map to be painted: a view, and words above it.
pub(super) struct Frame {
    pub(super) view: View,
    pub(super) heading: String,
}

/// Half of the middle of a layer, over its height.
const MIDDLE: f64 = 4.5;

/// The middle of a layer that is much longer than high: too much of it to be seen at once.
pub(super) fn middle(layer: &View) -> Option<View> {
    let half = MIDDLE * layer.height_mm();
    let centre = 0.5 * (layer.x_mm[0] + layer.x_mm[1]);
    let middle = View {
        x_mm: [centre - half, centre + half],
        ..*layer
    };
    (half < 0.4 * layer.width_mm()).then_some(middle)
}

/// Frames of views, to scale; all but the first are of the middle.
pub(super) fn frames(views: &[View]) -> Vec<Frame> {
    let frame = |(place, view): (usize, &View)| Frame {
        view: view.to_scale(),
        heading: ["", "The middle of it"][place.min(1)].into(),
    };
    views.iter().enumerate().map(frame).collect()
}

/// A map while it is painted. Shapes of the same style that follow each other are one path of the file, until the next [`layer`](Panel::layer).
pub(super) struct Panel {
    view: View,
    scales: [f64; 2],
    paths: Vec<(String, String)>,
    known: HashMap<String, usize>,
}

impl Panel {
    fn new(view: View) -> Panel {
        Panel {
            view,
            scales: view.scales(),
            paths: Vec::new(),
            known: HashMap::new(),
        }
    }

    /// Pixels of a length along x (mm).
    pub(super) fn pixels(&self, length_mm: f64) -> f64 {
        self.scales[0] * length_mm
    }

    /// True for a place (mm) inside of the map.
    pub(super) fn shows(&self, place: (f64, f64)) -> bool {
        self.view.holds(place)
    }

    /// Place in pixels, y downwards.
    fn at(&self, (x, y): (f64, f64)) -> (f64, f64) {
        let [sx, sy] = self.scales;
        (sx * (x - self.view.x_mm[0]), sy * (self.view.y_mm[1] - y))
    }

    /// What follows lies over what came before.
    pub(super) fn layer(&mut self) {
        self.known.clear();
    }

    fn path(&mut self, style: &str) -> &mut String {
        let next = self.paths.len();
        let place = *self.known.entry(style.to_string()).or_insert(next);
        if place == next {
            self.paths.push((style.to_string(), String::new()));
        }
        &mut self.paths[place].1
    }

    /// A line through places (mm), with attributes of an SVG path; closed for an area.
    pub(super) fn line(&mut self, points: &[(f64, f64)], closed: bool, style: &str) {
        let mut last = (0.0, 0.0);
        let mut text = String::new();
        for (k, point) in points.iter().enumerate() {
            let (x, y) = self.at(*point);
            let tenths = ((10.0 * x).round(), (10.0 * y).round());
            let word = ["l", "M"][usize::from(k == 0)];
            let from = if k == 0 { (0.0, 0.0) } else { last };
            let step = (0.1 * (tenths.0 - from.0), 0.1 * (tenths.1 - from.1));
            let _ = write!(text, "{word}{} {}", short(step.0), short(step.1));
            last = tenths;
        }
        if closed {
            text.push('z');
        }
        self.path(style).push_str(&text);
    }

    /// A disk of a radius in millimetres.
    pub(super) fn disk(&mut self, centre: (f64, f64), radius_mm: f64, style: &str) {
        let [rx, ry] = self.scales.map(|scale| scale * radius_mm);
        self.ellipse(centre, [rx, ry], style);
    }

    /// A disk of a radius in pixels.
    pub(super) fn dot(&mut self, centre: (f64, f64), radius: f64, style: &str) {
        self.ellipse(centre, [radius; 2], style);
    }

    fn ellipse(&mut self, centre: (f64, f64), [rx, ry]: [f64; 2], style: &str) {
        let (x, y) = self.at(centre);
        let [left, y, rx, ry, d] = [x - rx, y, rx, ry, 2.0 * rx].map(short);
        let text = format!("M{left} {y}a{rx} {ry} 0 1 0 {d} 0a{rx} {ry} 0 1 0-{d} 0");
        self.path(style).push_str(&text);
    }

    /// The map with its frame and axes, its upper left corner there (pixels).
    fn svg(&self, left: f64, top: f64) -> String {
        let [w, h] = [
            self.scales[0] * self.view.width_mm(),
            self.scales[1] * self.view.height_mm(),
        ];
        let mut text = format!(
            "<svg x=\"{left:.1}\" y=\"{top:.1}\" width=\"{w:.1}\" height=\"{h:.1}\"><rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>"
        );
        for (style, data) in &self.paths {
            let _ = write!(text, "<path {style} d=\"{data}\"/>");
        }
        text.push_str("</svg>");
        let bottom = top + h;
        let _ = write!(
            text,
            "<path fill=\"none\" stroke=\"#444\" d=\"M{left:.1} {top:.1}h{w:.1}v{h:.1}h-{w:.1}z\"/>"
        );
        for (x, label) in labelled(self.view.x_mm, (w / 90.0) as usize) {
            let at = left + self.scales[0] * (x - self.view.x_mm[0]);
            let _ = write!(
                text,
                "<path stroke=\"#444\" d=\"M{at:.1} {bottom:.1}v5\"/><text x=\"{at:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{label}</text>",
                bottom + 18.0
            );
        }
        for (y, label) in labelled(self.view.y_mm, (h / 40.0).max(3.0) as usize) {
            let at = bottom - self.scales[1] * (y - self.view.y_mm[0]);
            let _ = write!(
                text,
                "<path stroke=\"#444\" d=\"M{left:.1} {at:.1}h-5\"/><text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">{label}</text>",
                left - 8.0,
                at + 4.5
            );
        }
        let (beside, middle) = (left - 45.0, top + 0.5 * h);
        let _ = write!(
            text,
            "<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\">x (mm)</text><text transform=\"translate({beside:.1} {middle:.1}) rotate(-90)\" text-anchor=\"middle\">y (mm)</text>",
            left + 0.5 * w,
            bottom + 36.0
        );
        text
    }
}

/// A coordinate in tenths of a pixel, as short as it can be.
fn short(value: f64) -> String {
    let tenths = (10.0 * value).round() as i64;
    let (sign, size) = (if tenths < 0 { "-" } else { "" }, tenths.abs());
    match (size / 10, size % 10) {
        (whole, 0) => format!("{sign}{whole}"),
        (0, part) => format!("{sign}.{part}"),
        (whole, part) => format!("{sign}{whole}.{part}"),
    }
}

/// Maps one above the other, each painted by `content`, which is told its place, below the bar of their colours.
pub(super) fn maps(
    frames: &[Frame],
    scale: Option<&Scale>,
    content: impl Fn(&mut Panel, usize),
) -> String {
    let mut top = if scale.is_some() { BAR } else { 0.0 };
    let mut inside = scale.map_or_else(String::new, |scale| scale.bar(WIDTH));
    for (place, frame) in frames.iter().enumerate() {
        if !frame.heading.is_empty() {
            let (x, y) = (SPACE[0], top + 16.0);
            let heading = escape(&frame.heading);
            let _ = write!(inside, "<text x=\"{x}\" y=\"{y:.1}\">{heading}</text>");
            top += HEADING;
        }
        let mut panel = Panel::new(frame.view);
        content(&mut panel, place);
        let width = panel.scales[0] * frame.view.width_mm();
        let left = SPACE[0] + 0.5 * (WIDTH - SPACE[0] - SPACE[1] - width);
        top += SPACE[2];
        inside.push_str(&panel.svg(left, top));
        top += panel.scales[1] * frame.view.height_mm() + SPACE[3];
    }
    drawing(WIDTH, top, &inside)
}

/// The displaced elements that touch the view of a map, each in the colour of its number.
pub(super) fn elements(panel: &mut Panel, arrays: &Arrays, colour: impl Fn(usize) -> String) {
    let (cells, places) = (numbers(arrays, "connectivity"), deformed_mm(arrays));
    for (number, cell) in cells.chunks_exact(4).enumerate() {
        let corners: Vec<(f64, f64)> = cell.iter().map(|node| places[*node as usize]).collect();
        if corners.iter().any(|corner| panel.shows(*corner)) {
            let colour = colour(number);
            // A thin edge of the same colour hides the seams between neighbours.
            let style = format!("fill=\"{colour}\" stroke=\"{colour}\" stroke-width=\".4\"");
            panel.line(&corners, true, &style);
        }
    }
}

/// Current places of the nodes of a mesh (mm), whose points are those before the deformation.
pub(super) fn deformed_mm(arrays: &Arrays) -> Vec<(f64, f64)> {
    let moved = numbers(arrays, "displacement_m");
    let at = |k: usize| 1e3 * moved.get(k).copied().unwrap_or(0.0);
    let points = places_mm(arrays).into_iter().enumerate();
    let points = points.map(|(node, (x, y))| (x + at(3 * node), y + at(3 * node + 1)));
    points.collect()
}

/// The points of a file (mm): the current centres of grains.
pub(super) fn places_mm(arrays: &Arrays) -> Vec<(f64, f64)> {
    let points = numbers(arrays, "points").chunks_exact(3);
    points.map(|p| (1e3 * p[0], 1e3 * p[1])).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_flat_layer_is_drawn_to_scale_with_room_around_it() {
        let layer = View {
            x_mm: [-8.0, 8.0],
            y_mm: [-0.2, 0.2],
        };
        assert!(!layer.is_to_scale());
        let shown = layer.to_scale();
        assert!(shown.is_to_scale());
        assert_eq!(shown.x_mm, layer.x_mm);
        // 1 008 pixels for 16 mm, and 90 for the height.
        assert!((shown.height_mm() - 16.0 * 90.0 / 1008.0).abs() < 1e-12);
        let middle = middle(&layer).expect("it is long");
        assert_eq!((middle.width_mm(), middle.y_mm), (3.6, layer.y_mm));
        assert!(super::middle(&middle).is_none());
    }

    #[test]
    fn meshes_are_drawn_deformed_and_grains_where_they_are() {
        let mut arrays = Arrays::new();
        arrays.insert("points".into(), vec![1e-3, 2e-3, 0.0]);
        arrays.insert("displacement_m".into(), vec![0.5e-3, -1e-3, 0.0]);
        assert_eq!(deformed_mm(&arrays), [(1.5, 1.0)]);
        assert_eq!(places_mm(&arrays), [(1.0, 2.0)]);
    }
}
