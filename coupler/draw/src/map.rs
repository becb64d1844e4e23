//! Parts of a scene drawn to scale, with axes, one above another.

use std::collections::HashMap;
use std::fmt::Write as _;

use crate::axis::{AxisPair, Grid, LETTER, PlotAxis};
use crate::colour::ColourScale;
use crate::extent::Extent;
use crate::svg::{Anchor, Svg, ellipse, short};

/// Width of a page of maps, largest height of a map, and its smallest width and height (pixels).
const WIDTH: f64 = 1080.0;
const HEIGHT_MAX: f64 = 560.0;
const LEAST: f64 = 90.0;
/// Space around a map (pixels): left, right, above, below.
const SPACE: [f64; 4] = [58.0, 14.0, 8.0, 44.0];
/// Height of the colour bar, and of a heading (pixels).
const BAR: f64 = 44.0;
const HEADING: f64 = 22.0;

/// A map: its extent (mm), and the words above it.
#[derive(Clone, Debug)]
pub struct Map {
    /// Shown part of the scene.
    pub extent: Extent,
    /// Words above it; may be empty.
    pub heading: String,
}

impl Map {
    /// A map of exactly this extent.
    pub fn of(extent: Extent, heading: &str) -> Map {
        Map {
            extent,
            heading: heading.into(),
        }
    }

    /// A map with the same scale along x and y; an extent that is too narrow or too flat for that is widened.
    pub fn to_scale(extent: Extent, heading: &str) -> Map {
        let scale = common_scale(&extent);
        let missing = |length: f64| 0.5 * (LEAST / scale - length).max(0.0);
        let (side, edge) = (missing(extent.width()), missing(extent.height()));
        Map::of(extent.with_margin(side, edge, edge), heading)
    }
}

/// The middle of a layer that is much longer than high.
pub fn middle(layer: &Extent) -> Option<Extent> {
    let middle = layer.middle();
    (middle.width() < 0.8 * layer.width()).then_some(middle)
}

/// Pixels per millimetre that fit both axes.
fn common_scale(extent: &Extent) -> f64 {
    let width = WIDTH - SPACE[0] - SPACE[1];
    let [w, h] = [extent.width(), extent.height()].map(|length| length.max(1e-9));
    (width / w).min(HEIGHT_MAX / h)
}

/// Pixels per millimetre along x and y: equal, except for a very tall or very flat extent, which keeps a visible width and height.
fn scales(extent: &Extent) -> [f64; 2] {
    let scale = common_scale(extent);
    [extent.width(), extent.height()].map(|length| scale.max(LEAST / length.max(1e-9)))
}

/// True if a map of this extent has the same scale along x and y.
pub fn is_to_scale(extent: &Extent) -> bool {
    let [x, y] = scales(extent);
    (x / y - 1.0).abs() < 1e-9
}

/// A map in progress. Shapes of the same style are one path of the file, until the next [`layer`](Panel::layer).
#[derive(Debug)]
pub struct Panel {
    extent: Extent,
    scales: [f64; 2],
    paths: Vec<(String, String)>,
    known: HashMap<String, usize>,
}

impl Panel {
    fn new(extent: Extent) -> Panel {
        Panel {
            extent,
            scales: scales(&extent),
            paths: Vec::new(),
            known: HashMap::new(),
        }
    }

    /// Pixels of a length along x (mm).
    pub fn pixels(&self, length_mm: f64) -> f64 {
        self.scales[0] * length_mm
    }

    /// Extent of the scene on the map (mm).
    pub fn extent(&self) -> Extent {
        self.extent
    }

    /// True for a position (mm) inside the map.
    pub fn shows(&self, position: [f64; 2]) -> bool {
        self.extent.holds(position)
    }

    /// Position in pixels, y downwards.
    fn at(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let [sx, sy] = self.scales;
        [sx * (x - self.extent.x[0]), sy * (self.extent.y[1] - y)]
    }

    /// Starts a layer: shapes that follow lie above earlier shapes.
    pub fn layer(&mut self) {
        self.known.clear();
    }

    fn path(&mut self, style: &str, data: &str) {
        let next = self.paths.len();
        let path = *self.known.entry(style.to_string()).or_insert(next);
        if path == next {
            self.paths.push((style.to_string(), String::new()));
        }
        self.paths[path].1.push_str(data);
    }

    /// A line through positions (mm), closed for an area.
    pub fn line(&mut self, points: &[[f64; 2]], closed: bool, style: &str) {
        let mut last = [0.0; 2];
        let mut text = String::new();
        for (k, point) in points.iter().enumerate() {
            let tenths = self.at(*point).map(|pixels| (10.0 * pixels).round());
            let word = ["l", "M"][usize::from(k == 0)];
            let step = [0, 1].map(|k| short(0.1 * (tenths[k] - last[k])));
            let _ = write!(text, "{word}{} {}", step[0], step[1]);
            last = tenths;
        }
        if closed {
            text.push('z');
        }
        self.path(style, &text);
    }

    /// A disk with a radius in millimetres.
    pub fn disk(&mut self, centre: [f64; 2], radius_mm: f64, style: &str) {
        let radii = self.scales.map(|scale| scale * radius_mm);
        self.path(style, &ellipse(self.at(centre), radii));
    }

    /// A disk with a radius in pixels.
    pub fn dot(&mut self, centre: [f64; 2], radius: f64, style: &str) {
        self.path(style, &ellipse(self.at(centre), [radius; 2]));
    }

    /// Draws the map with its frame and axes, with its upper left corner at this position (pixels).
    fn draw(&self, svg: &mut Svg, [left, top]: [f64; 2]) {
        let [w, h] = self.size();
        let paths = self.paths.iter();
        let paths = paths.map(|(style, data)| format!("<path {style} d=\"{data}\"/>"));
        svg.raw(&format!(
            "<svg x=\"{left:.1}\" y=\"{top:.1}\" width=\"{w:.1}\" height=\"{h:.1}\"><rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>{}</svg>",
            paths.collect::<String>()
        ));
        let axes = AxisPair {
            x: PlotAxis::linear("x (mm)", self.extent.x, (w / 90.0) as usize),
            y: PlotAxis::linear("y (mm)", self.extent.y, (h / 40.0).max(3.0) as usize),
            across: [left, left + w],
            down: [top, top + h],
        };
        axes.draw(svg, Grid::Ticks);
    }

    fn size(&self) -> [f64; 2] {
        let [sx, sy] = self.scales;
        [sx * self.extent.width(), sy * self.extent.height()]
    }
}

/// Maps one above another, below the bar of their colours; `content` draws the map with a given index.
pub fn maps(
    maps: &[Map],
    scale: Option<&ColourScale>,
    content: impl Fn(&mut Panel, usize),
) -> String {
    let (mut svg, mut top) = (Svg::default(), 0.0);
    if let Some(scale) = scale {
        scale.bar(&mut svg, WIDTH);
        top = BAR;
    }
    draw_below(svg, top, maps, content)
}

/// The same below a legend with a colour and words for each kind of object.
pub fn maps_of_kinds(
    maps: &[Map],
    kinds: &[[&str; 2]],
    content: impl Fn(&mut Panel, usize),
) -> String {
    let mut svg = Svg::default();
    let mut x = SPACE[0];
    for [colour, words] in kinds {
        svg.swatch(colour, [x, 8.0], words);
        x += 60.0 + LETTER * words.chars().count() as f64;
    }
    draw_below(svg, BAR, maps, content)
}

fn draw_below(
    mut svg: Svg,
    mut top: f64,
    maps: &[Map],
    content: impl Fn(&mut Panel, usize),
) -> String {
    for (number, map) in maps.iter().enumerate() {
        if !map.heading.is_empty() {
            svg.text([SPACE[0], top + 16.0], Anchor::Start, &map.heading);
            top += HEADING;
        }
        let mut panel = Panel::new(map.extent);
        content(&mut panel, number);
        let [width, height] = panel.size();
        let left = SPACE[0] + 0.5 * (WIDTH - SPACE[0] - SPACE[1] - width);
        panel.draw(&mut svg, [left, top + SPACE[2]]);
        top += SPACE[2] + height + SPACE[3];
    }
    svg.page([WIDTH, top])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_flat_layer_is_drawn_to_scale_with_room_around_it() {
        let layer = Extent {
            x: [-8.0, 8.0],
            y: [-0.2, 0.2],
        };
        assert!(!is_to_scale(&layer));
        let shown = Map::to_scale(layer, "").extent;
        assert!(is_to_scale(&shown));
        assert_eq!(shown.x, layer.x);
        // 1 008 pixels for 16 mm, and 90 for the height.
        assert!((shown.height() - 16.0 * 90.0 / 1008.0).abs() < 1e-12);
        let near = middle(&layer).expect("it is long");
        assert_eq!((near.width(), near.y), (3.6, layer.y));
        assert!(middle(&near).is_none());
    }
}
