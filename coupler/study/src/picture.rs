//! Pictures of a study: errors over costs with the front, and errors along each knob.

use super::collect::Results;
use super::ensemble::EnsembleMean;
use super::file::Vary;
use super::front::{MeasureFront, Trade};
use super::measure::percent;
use super::settings::{StudySetting, short};
use super::varied_keys::VariedKey;
use draw::axis::{AxisPair, Grid, PlotAxis, range};
use draw::colour::shade;
use draw::svg::{Anchor, Svg};

/// Size of a panel (pixels), and height of a line of words below it.
const PANEL: [f64; 2] = [640.0, 400.0];
const LINE: f64 = 20.0;
/// Edges of the area between the axes of a panel: left and right, upper and lower (pixels).
const ACROSS: [f64; 2] = [84.0, 626.0];
const DOWN: [f64; 2] = [14.0, 346.0];
/// Letters of a line that fit into a panel.
const LINE_LETTERS: usize = 112;
/// Colours of measures, dark enough to be told apart in grey.
const COLOURS: [&str; 5] = ["#14468c", "#be5014", "#28823c", "#782882", "#5a5a5a"];
const BLACK: &str = "#000";
/// The first of them, as line and as area.
const STROKE: &str = "stroke=\"#14468c\" stroke-width=\"2\"";
const FILL: &str = "fill=\"#14468c\"";
/// Part of the smallest error that is drawn for one of 0, which has no logarithm.
const BOTTOM: f64 = 0.3;

/// Part of the colour scale that maps use, so that numbers in black or white can be read on it.
const MAP_SHADE: f64 = 0.9;

/// Ratio of the largest value of a key to the smallest from which its axis is logarithmic.
const MANY: f64 = 20.0;

/// Letters that fit below an axis.
const LETTERS: usize = 60;

/// Words for a front that nowhere lies below the chord of its ends.
pub const NO_KNEE: &str = "no knee: the front lies above the chord between its ends";

/// front.svg: a panel a measure.
pub(super) fn fronts(
    panels: &[MeasureFront],
    settings: &[StudySetting],
    results: &Results,
) -> String {
    let cost = match results.reference(0) {
        Some(_) => "processor time over that of the reference",
        None => "processor time (s)",
    };
    let mut page = Page::new(panels.len(), 2);
    for panel in panels {
        let all = || panel.trades.iter().chain(&panel.fallen);
        let least = BOTTOM * smallest(all().map(|t| t.error));
        let point = |trade: &Trade| (trade.cost, 100.0 * trade.error.max(least));
        let error = format!("error_{} (%)", panel.measure);
        let axes = [
            PlotAxis::logarithmic(cost, all().map(|t| t.cost)),
            PlotAxis::logarithmic(&error, all().map(|t| point(t).1)),
        ];
        page.draw(&axes, |svg, axes| {
            let at = |trade: &Trade| axes.at(point(trade));
            floor(svg, axes, panel.floor, BLACK);
            for trade in &panel.trades {
                svg.circle("fill=\"#000\" fill-opacity=\".35\"", at(trade), 3.0);
            }
            for [x, y] in panel.fallen.iter().map(at) {
                let cross = format!("M{:.1} {:.1}l8 8m0-8l-8 8", x - 4.0, y - 4.0);
                svg.path(&format!("stroke=\"{}\"", COLOURS[1]), &cross);
            }
            svg.line(STROKE, panel.front.iter().map(at));
            for trade in &panel.front {
                svg.circle(FILL, at(trade), 4.0);
            }
            if let Some(knee) = panel.knee {
                let ring = format!("fill=\"none\" {STROKE}");
                svg.circle(&ring, at(&panel.front[knee]), 9.0);
            }
        });
        let words = |knee: usize| {
            let trade = &panel.front[knee];
            let setting = settings[trade.setting].words(results);
            let (cost, error) = (trade.cost, percent(trade.error));
            format!("knee (ring): {setting}: cost {cost:.3}, error {error} %")
        };
        page.words(BLACK, &panel.knee.map_or(NO_KNEE.into(), words));
        let floor = results.file.reference.floor_words(panel.floor);
        let floor = format!(
            "floor of noise (dashed where it is in the picture): {floor}; crosses: suspect"
        );
        page.words(BLACK, &floor);
    }
    page.svg()
}

/// The floor of noise, where it is in the picture.
fn floor(svg: &mut Svg, axes: &AxisPair, floor: f64, colour: &str) {
    let height = 100.0 * floor;
    if axes.y.holds(height) {
        let y = axes.at((1.0, height))[1];
        let style = format!("stroke=\"{colour}\" stroke-dasharray=\"6 4\"");
        svg.line(&style, axes.across.map(|x| [x, y]));
    }
}

/// knobs.svg: a panel a key, with a word on each trend below it.
pub fn knobs(knobs: &[VariedKey], measures: &[String]) -> String {
    let mut page = Page::new(knobs.len(), measures.len() + 2);
    for knob in knobs {
        // A run that is the reference has no error, and an axis that reached for it would hide the others.
        let drawn = || {
            knob.positions
                .iter()
                .enumerate()
                .filter(|(_, p)| !p.reference)
        };
        let errors = || drawn().flat_map(|(_, p)| p.errors.iter().flatten());
        let least = BOTTOM * smallest(errors().copied());
        let height = |error: f64| 100.0 * error.max(least);
        // A value lies at its own number, or one a decade where values are words.
        let number = |k: usize| match knob.positions[k].value.parse::<f64>() {
            Ok(number) if knob.numeric => number,
            _ => 10f64.powi(k as i32),
        };
        let heights = errors().map(|error| height(*error));
        let axes = [
            value_axis(knob, number),
            PlotAxis::logarithmic("error (%)", heights),
        ];
        page.draw(&axes, |svg, axes| {
            for (measure, noise) in knob.floors.iter().enumerate() {
                let colour = COLOURS[measure % COLOURS.len()];
                let points = drawn().filter_map(|(k, p)| {
                    let error = p.errors[measure]?;
                    Some(axes.at((number(k), height(error))))
                });
                let mut points: Vec<[f64; 2]> = points.collect();
                points.sort_by(|a, b| a[0].total_cmp(&b[0]));
                if knob.numeric {
                    let style = format!("stroke=\"{colour}\" stroke-width=\"2\"");
                    svg.line(&style, points.iter().copied());
                }
                for point in points {
                    svg.circle(&format!("fill=\"{colour}\""), point, 4.0);
                }
                floor(svg, axes, *noise, colour);
            }
        });
        let trends = knob.trends(measures);
        for (k, name) in measures.iter().enumerate() {
            let line = trends.get(k).cloned();
            let line = line.unwrap_or_else(|| format!("error_{name}"));
            page.words(COLOURS[k % COLOURS.len()], &line);
        }
        page.words(BLACK, &knob.note);
    }
    page.svg()
}

/// The axis of the values of a knob, each at its number. Words that would overlap are numbered as digest.txt lists them.
fn value_axis(knob: &VariedKey, number: impl Fn(usize) -> f64) -> PlotAxis {
    let letters = knob.positions.iter().map(|p| p.value.chars().count());
    let numbered = !knob.numeric && letters.sum::<usize>() > LETTERS;
    let title = match numbered {
        true => format!("{}, by its place in digest.txt", knob.key),
        false => knob.key.clone(),
    };
    let numbers = (0..knob.positions.len()).map(&number);
    let mut axis = PlotAxis::logarithmic(&title, numbers.clone());
    let labels = knob.positions.iter().enumerate().map(|(k, position)| {
        let value = match numbered {
            true => format!("{}", k + 1),
            false => position.value.clone(),
        };
        value + if position.reference { " (ref.)" } else { "" }
    });
    axis.ticks = numbers.zip(labels).collect();
    axis
}

/// means.svg: a panel a measure; means over the scenes with their 95 % intervals, the values of single scenes pale.
pub fn means(means: &[EnsembleMean]) -> String {
    let panels: Vec<_> = means.chunk_by(|a, b| a.measure == b.measure).collect();
    let longest = panels.iter().map(|panel| panel.len()).max().unwrap_or(0);
    let mut page = Page::new(panels.len(), longest);
    for panel in panels {
        let ends = [0.5, panel.len() as f64 + 0.5];
        let mut x = PlotAxis::linear("setting, as numbered below", ends, 2);
        let numbers = 1..=panel.len();
        x.ticks = numbers.clone().map(|k| (k as f64, k.to_string())).collect();
        let means: Vec<_> = numbers.map(|k| k as f64).zip(panel).collect();
        draw_means(&mut page, x, &means, false);
        for (k, of) in panel.iter().enumerate() {
            page.words(BLACK, &format!("{}: {}", k + 1, of.words()));
        }
    }
    page.svg()
}

/// values.svg of a study of one key: a panel a measure, means over the scenes with their intervals along the values of the key, joined where
/// these are numbers, the values of single scenes pale. `None` where settings differ by more or less than one key.
pub fn values(means: &[EnsembleMean], keys: &[Vary]) -> Option<String> {
    let points = points(means)?;
    let (_, [(key, _)]) = points.first()?;
    if points.iter().any(|(_, [(other, _)])| other != key) {
        return None;
    }
    let title = title(&keys[*key]);
    let panels: Vec<_> = points.chunk_by(|a, b| a.0.measure == b.0.measure).collect();
    let mut page = Page::new(panels.len(), 1);
    for panel in panels {
        let value = |(_, [(_, value)]): &Point<1>| value.clone();
        let numbers = panel.iter().map(|point| value(point).parse().ok());
        let numbers: Option<Vec<f64>> = numbers.collect();
        let numeric = numbers.is_some();
        let places = numbers.unwrap_or_else(|| (1..=panel.len()).map(|k| k as f64).collect());
        let all = || places.iter().copied();
        let wide = range(all()).is_some_and(|[low, high]| low > 0.0 && high > MANY * low);
        let mut x = if wide && numeric {
            PlotAxis::logarithmic(&title, all())
        } else {
            PlotAxis::around(&title, all(), 5)
        };
        if !numeric {
            x.ticks = all().zip(panel.iter().map(value)).collect();
        }
        let means: Vec<_> = all().zip(panel.iter().map(|point| point.0)).collect();
        draw_means(&mut page, x, &means, numeric);
        page.words(BLACK, &panel[0].0.name);
    }
    Some(page.svg())
}

/// Draws means of a measure at their places with their intervals, the values that each is of pale; a line joins them if asked for.
fn draw_means(page: &mut Page, x: PlotAxis, means: &[(f64, &EnsembleMean)], joined: bool) {
    let ends = means.iter().flat_map(|(_, of)| of.reach());
    let y = PlotAxis::around(&means[0].1.name, ends, 5);
    page.draw(&[x, y], |svg, axes| {
        if joined {
            let mut line: Vec<_> = means.iter().map(|(x, of)| (*x, of.mean)).collect();
            line.sort_by(|a, b| a.0.total_cmp(&b.0));
            svg.line(STROKE, line.iter().map(|point| axes.at(*point)));
        }
        for (x, of) in means {
            let at = |y: f64| axes.at((*x, y));
            for value in &of.values {
                svg.circle("fill=\"#000\" fill-opacity=\".25\"", at(*value), 3.0);
            }
            svg.line(
                STROKE,
                [of.mean - of.half_width, of.mean + of.half_width].map(at),
            );
            svg.circle(FILL, at(of.mean), 5.0);
        }
    });
}

/// A mean with the keys that its setting chooses values of, and the values.
type Point<'a, const N: usize> = (&'a EnsembleMean, &'a [(usize, String); N]);

/// The means of settings that choose values of so many keys, with these and their values; the reference aside. `None` where a setting
/// chooses more or fewer.
fn points<const N: usize>(means: &[EnsembleMean]) -> Option<Vec<Point<'_, N>>> {
    let points = means.iter().filter(|of| !of.chosen.is_empty());
    let points = points.map(|of| Some((of, of.chosen[..].try_into().ok()?)));
    points.collect()
}

/// Words along the axis of a key.
fn title(vary: &Vary) -> String {
    let words = [short(&vary.key), &vary.note].join(" ");
    words.trim().into()
}

/// maps.svg of a study of two keys: a panel a measure, the first key upwards and the second to the right; in each cell the mean over the scenes
/// and half of its 95 % interval. `None` where the keys make no grid.
pub fn maps(means: &[EnsembleMean], keys: &[Vary]) -> Option<String> {
    let pairs = points(means)?;
    let (_, [up, right]) = pairs.first()?;
    let values = |side: usize| {
        let mut values: Vec<&str> = Vec::new();
        for (_, chosen) in &pairs {
            let value = chosen[side].1.as_str();
            if !values.contains(&value) {
                values.push(value);
            }
        }
        values
    };
    let (rows, columns) = (values(0), values(1));
    if rows.len() < 2 || columns.len() < 2 {
        return None;
    }
    let axis = |key: usize, values: &[&str]| {
        let mut axis = PlotAxis::linear(&title(&keys[key]), [0.0, values.len() as f64], 2);
        let ticks = values.iter().enumerate();
        axis.ticks = ticks
            .map(|(k, value)| (k as f64 + 0.5, value.to_string()))
            .collect();
        axis
    };
    let axes = [axis(right.0, &columns), axis(up.0, &rows)];
    let place = |values: &[&str], own: &str| {
        let place = values.iter().position(|value| *value == own);
        place.unwrap_or_default() as f64
    };
    let panels: Vec<_> = pairs.chunk_by(|a, b| a.0.measure == b.0.measure).collect();
    let mut page = Page::new(panels.len(), 1);
    for panel in panels {
        let [low, high] = range(panel.iter().map(|(of, _)| of.mean)).unwrap_or_default();
        page.draw(&axes, |svg, axes| {
            for (of, [(_, up), (_, right)]) in panel {
                let (x, y) = (place(&columns, right), place(&rows, up));
                let ([left, bottom], [end, top]) = (axes.at((x, y)), axes.at((x + 1.0, y + 1.0)));
                let wide = if high > low { high - low } else { 1.0 };
                let share = (of.mean - low) / wide;
                let style = format!("fill=\"{}\" stroke=\"#fff\"", shade(MAP_SHADE * share));
                svg.rectangle(&style, [left, top], [end - left, bottom - top]);
                let ink = if share > 0.7 { "#fff" } else { BLACK };
                let middle = [0.5 * (left + end), 0.5 * (top + bottom)];
                let style = format!("fill=\"{ink}\"");
                svg.styled_text(&style, middle, Anchor::Middle, &three_digits(of.mean));
                let below = [middle[0], middle[1] + 16.0];
                let half = match of.values.len() {
                    1 => String::new(),
                    _ => format!("+- {}", three_digits(of.half_width)),
                };
                let style = format!("font-size=\"10\" {style}");
                svg.styled_text(&style, below, Anchor::Middle, &half);
            }
        });
        page.words(BLACK, &panel[0].0.name);
    }
    Some(page.svg())
}

/// A number with three digits, without an exponent where it needs none.
fn three_digits(x: f64) -> String {
    match x.abs() {
        size if size >= 1e5 || (size < 1e-3 && size > 0.0) => format!("{x:.2e}"),
        size if size >= 99.95 => format!("{x:.0}"),
        size if size >= 9.995 => format!("{x:.1}"),
        size if size >= 0.9995 => format!("{x:.2}"),
        _ => format!("{x:.3}"),
    }
}

/// Panels, two side by side, each with lines of words below it.
struct Page {
    svg: Svg,
    panels: usize,
    /// Height of a panel with its words (pixels).
    height: f64,
    /// Number of panels that are drawn, and of lines below the last one.
    drawn: usize,
    lines: usize,
}

impl Page {
    fn new(panels: usize, lines: usize) -> Page {
        Page {
            svg: Svg::default(),
            panels,
            height: PANEL[1] + LINE * lines as f64,
            drawn: 0,
            lines: 0,
        }
    }

    /// Upper left corner of the panel that is drawn last.
    fn corner(&self) -> [f64; 2] {
        let last = self.drawn.saturating_sub(1);
        [
            PANEL[0] * (last % 2) as f64,
            self.height * (last / 2) as f64,
        ]
    }

    /// Draws the next panel.
    fn draw(&mut self, [x, y]: &[PlotAxis; 2], content: impl Fn(&mut Svg, &AxisPair)) {
        self.drawn += 1;
        self.lines = 0;
        let [left, top] = self.corner();
        let axes = AxisPair {
            x: x.clone(),
            y: y.clone(),
            across: ACROSS.map(|x| left + x),
            down: DOWN.map(|y| top + y),
        };
        axes.draw(&mut self.svg, Grid::Lines);
        content(&mut self.svg, &axes);
    }

    /// A line of words below it; what is longer than the panel is cut off.
    fn words(&mut self, colour: &str, words: &str) {
        let [left, top] = self.corner();
        let at = [left + 20.0, top + PANEL[1] + LINE * self.lines as f64 + 9.0];
        let words: String = words.chars().take(LINE_LETTERS).collect();
        let style = format!("font-size=\"9.7\" fill=\"{colour}\"");
        self.svg.styled_text(&style, at, Anchor::Start, &words);
        self.lines += 1;
    }

    fn svg(&self) -> String {
        let rows = self.panels.div_ceil(2);
        self.svg.page([2.0 * PANEL[0], self.height * rows as f64])
    }
}

/// The smallest positive number; 1 of none.
fn smallest(numbers: impl Iterator<Item = f64>) -> f64 {
    let least = numbers.filter(|x| *x > 0.0).fold(f64::INFINITY, f64::min);
    if least.is_finite() { least } else { 1.0 }
}
