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
use draw::units::{axis_words, unit, with_unit_of, words};
use std::collections::BTreeMap;

/// Size of a panel (pixels), and height of a line of words below it.
const PANEL: [f64; 2] = [640.0, 400.0];
const LINE: f64 = 20.0;
/// Edges of the area between the axes of a panel: left and right, upper and lower (pixels).
const ACROSS: [f64; 2] = [84.0, 626.0];
const DOWN: [f64; 2] = [14.0, 346.0];
/// Number of letters of a line that fit into a panel.
const LINE_LETTERS: usize = 112;
/// Colours of measures, distinguishable in grey.
const COLOURS: [&str; 5] = ["#14468c", "#be5014", "#28823c", "#782882", "#5a5a5a"];
pub(super) const BLACK: &str = "#000";
/// The first colour, as line and as area.
const STROKE: &str = "stroke=\"#14468c\" stroke-width=\"2\"";
const FILL: &str = "fill=\"#14468c\"";
/// An error of 0, which has no logarithm, is drawn at this part of the smallest error.
const BOTTOM: f64 = 0.3;

/// Part of the colour scale that maps use, on which numbers in black or white are readable.
const MAP_SHADE: f64 = 0.9;

/// Ratio of the largest value of a key to the smallest from which its axis is logarithmic.
const MANY: f64 = 20.0;

/// Number of letters that fit below an axis.
const LETTERS: usize = 60;

/// Words for a front that nowhere lies below the chord between its ends.
pub const NO_KNEE: &str = "no knee: the front lies above the chord between its ends";

/// front.svg: one panel per measure.
pub(super) fn fronts(
    panels: &[MeasureFront],
    settings: &[StudySetting],
    results: &Results,
) -> String {
    let cost = match results.reference(0) {
        Some(_) => "processor time relative to the reference",
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
            level(svg, axes, 100.0 * panel.floor, BLACK);
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
        let floor =
            format!("floor of noise (dashed if within the picture): {floor}; crosses: suspect");
        page.words(BLACK, &floor);
    }
    page.svg()
}

/// A dashed line across the panel at this height, if it is within the picture.
fn level(svg: &mut Svg, axes: &AxisPair, height: f64, colour: &str) {
    if axes.y.holds(height) {
        let y = axes.at((1.0, height))[1];
        let style = format!("stroke=\"{colour}\" stroke-dasharray=\"6 4\"");
        svg.line(&style, axes.across.map(|x| [x, y]));
    }
}

/// knobs.svg: one panel per key, with a line on each trend below it.
pub fn knobs(knobs: &[VariedKey], measures: &[String]) -> String {
    let mut page = Page::new(knobs.len(), measures.len() + 2);
    for knob in knobs {
        // The reference has no error, and an axis that included it would hide the others.
        let all = || knob.positions.iter().enumerate();
        let drawn = || all().filter(|(_, p)| !p.reference);
        let errors = || drawn().flat_map(|(_, p)| p.errors.iter().flatten());
        let least = BOTTOM * smallest(errors().copied());
        let height = |error: f64| 100.0 * error.max(least);
        // A number is drawn at its value; words are one decade apart.
        let number = |k: usize| match knob.positions[k].value.parse::<f64>() {
            Ok(number) if knob.numeric => number,
            _ => 10f64.powi(k as i32),
        };
        let heights = errors().map(|error| height(*error));
        let errors = PlotAxis::logarithmic("error (%)", heights);
        let axes = [value_axis(knob, number), errors];
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
                level(svg, axes, 100.0 * noise, colour);
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

/// The axis of the values of a knob. Words that would overlap are numbered as in digest.txt.
fn value_axis(knob: &VariedKey, number: impl Fn(usize) -> f64) -> PlotAxis {
    let values = knob.positions.iter().map(|p| p.value.as_str());
    let (_, mut title) = axis_words(&knob.key, unit(&knob.key), 0.0);
    let labels = labels(values.collect(), knob.numeric, &mut title);
    let numbers = (0..knob.positions.len()).map(&number);
    let mut axis = PlotAxis::logarithmic(&title, numbers.clone());
    let labels = labels.into_iter().zip(&knob.positions);
    let labels =
        labels.map(|(label, position)| label + if position.reference { " (ref.)" } else { "" });
    axis.ticks = numbers.zip(labels).collect();
    axis
}

/// The labels of values along an axis. Words that would overlap are numbered as in digest.txt, and the title says so.
fn labels(values: Vec<&str>, numeric: bool, title: &mut String) -> Vec<String> {
    let letters = values.iter().map(|value| value.chars().count());
    if numeric || letters.sum::<usize>() <= LETTERS {
        return values.into_iter().map(String::from).collect();
    }
    *title += ", numbered as in digest.txt";
    (1..=values.len()).map(|place| place.to_string()).collect()
}

/// means.svg: a panel for each measure and each set of keys that settings choose together. It shows means over the scenes with their 95 %
/// intervals over the key with most values, with a line for each choice of the other keys; the values of single scenes are pale.
pub fn means(means: &[EnsembleMean], keys: &[Vary]) -> String {
    let mut panels: BTreeMap<(usize, Vec<usize>), Vec<&EnsembleMean>> = BTreeMap::new();
    for of in means {
        let chosen = of.chosen.iter().map(|(key, _)| *key).collect();
        panels.entry((of.measure, chosen)).or_default().push(of);
    }
    // The reference has no varied key: it is a line across the other panels.
    let mut references = panels.clone();
    references.retain(|(_, keys), _| keys.is_empty());
    if panels.len() > references.len() {
        panels.retain(|(_, keys), _| !keys.is_empty());
    }
    let longest = panels.values().map(|all| lines_of(all).len()).max();
    let mut page = Page::new(panels.len(), longest.unwrap_or(0) + 1);
    for ((measure, _), all) in &panels {
        let reference = references.get(&(*measure, Vec::new()));
        draw_curves(&mut page, all, reference.map(|all| all[0]), keys);
    }
    page.svg()
}

/// Means with the same values of all keys except the key with most values: these values, and the means.
type MeansLine<'a> = (Vec<&'a (usize, String)>, Vec<&'a EnsembleMean>);

/// Index of the first key with most values among the keys that these settings choose; `None` if they choose none.
fn longest(all: &[&EnsembleMean]) -> Option<usize> {
    let chosen = (0..all[0].chosen.len()).rev();
    chosen.max_by_key(|k| distinct(all, *k).len())
}

fn lines_of<'a>(all: &[&'a EnsembleMean]) -> Vec<MeansLine<'a>> {
    let along = longest(all);
    let mut lines: Vec<MeansLine> = Vec::new();
    for of in all {
        let rest = of.chosen.iter().enumerate();
        let rest = rest.filter(|(k, _)| Some(*k) != along);
        let rest: Vec<_> = rest.map(|(_, chosen)| chosen).collect();
        match lines.iter_mut().find(|(other, _)| *other == rest) {
            Some((_, line)) => line.push(of),
            None => lines.push((rest, vec![of])),
        }
    }
    lines
}

fn draw_curves(
    page: &mut Page,
    all: &[&EnsembleMean],
    reference: Option<&EnsembleMean>,
    keys: &[Vary],
) {
    let along = longest(all);
    let values = along.map_or(vec![""], |k| distinct(all, k));
    let numbers: Option<Vec<f64>> = values.iter().map(|value| value.parse().ok()).collect();
    let numeric = numbers.is_some();
    let numbers = numbers.unwrap_or_else(|| (1..=values.len()).map(|k| k as f64).collect());
    let size = numbers.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
    let key = along.map(|k| &keys[all[0].chosen[k].0]);
    let (factor, mut words) = key.map_or((1.0, String::new()), |key| title(key, size));
    let factor = if numeric { factor } else { 1.0 };
    let places = || numbers.iter().map(|x| factor * x);
    let wide = range(places()).is_some_and(|[low, high]| low > 0.0 && high > MANY * low);
    let labels = labels(values.clone(), numeric, &mut words);
    let mut x = if wide && numeric {
        PlotAxis::logarithmic(&words, places())
    } else {
        PlotAxis::around(&words, places(), 5)
    };
    if !numeric {
        x.ticks = places().zip(labels).collect();
    }
    let reach = all.iter().flat_map(|of| of.reach());
    let reach: Vec<f64> = reach.chain(reference.map(|of| of.mean)).collect();
    let (unit, words) = all[0].title(reach.iter().copied());
    let y = PlotAxis::around(&words, reach.iter().map(|y| unit * y), 5);
    let lines = lines_of(all);
    page.draw(&[x, y], |svg, axes| {
        if let Some(of) = reference {
            level(svg, axes, unit * of.mean, BLACK);
        }
        for (k, (_, line)) in lines.iter().enumerate() {
            let points = line.iter().map(|of| {
                let own = along.and_then(|k| of.chosen.get(k));
                let is_own = |v: &&str| own.is_some_and(|own| own.1 == *v);
                let place = values.iter().position(is_own);
                (factor * numbers[place.unwrap_or_default()], *of)
            });
            draw_means(svg, axes, k, unit, &Vec::from_iter(points), numeric);
        }
    });
    for (k, (rest, _)) in lines.iter().enumerate() {
        if !rest.is_empty() {
            let words = rest
                .iter()
                .map(|(key, value)| value_words(&keys[*key], value));
            page.words_of_line(k, &Vec::from_iter(words).join(", "));
        }
    }
    if reference.is_some() {
        page.words(BLACK, "dashed across the panel: the reference");
    }
}

/// Draws the means of a line with their intervals, and their single values pale; a line joins means over numbers.
pub(super) fn draw_means(
    svg: &mut Svg,
    axes: &AxisPair,
    number: usize,
    factor: f64,
    points: &[(f64, &EnsembleMean)],
    joined: bool,
) {
    let (colour, style) = (COLOURS[number % COLOURS.len()], line_style(number));
    let at = |x: f64, y: f64| axes.at((x, factor * y));
    if joined {
        let mut line: Vec<_> = points.iter().map(|(x, of)| at(*x, of.mean)).collect();
        line.sort_by(|a, b| a[0].total_cmp(&b[0]));
        svg.line(&style, line);
    }
    for (x, of) in points {
        for value in of.values.iter().filter(|_| of.values.len() > 1) {
            let pale = format!("fill=\"{colour}\" fill-opacity=\".25\"");
            svg.circle(&pale, at(*x, *value), 3.0);
        }
        let ends = [of.mean - of.half_width, of.mean + of.half_width];
        svg.line(&style, ends.map(|y| at(*x, y)));
        svg.circle(&format!("fill=\"{colour}\""), at(*x, of.mean), 4.0);
    }
}

/// The style of a line by its number: a colour, and dashes once the colours repeat.
fn line_style(number: usize) -> String {
    let dashes = ["", " stroke-dasharray=\"8 4\"", " stroke-dasharray=\"2 3\""];
    let (colour, turn) = (COLOURS[number % COLOURS.len()], number / COLOURS.len());
    let dashes = dashes[turn % dashes.len()];
    format!("stroke=\"{colour}\" stroke-width=\"2\"{dashes}")
}

/// The distinct values of a key in these settings, in order; `chosen` is its index among the keys that they choose.
fn distinct<'a>(all: &[&'a EnsembleMean], chosen: usize) -> Vec<&'a str> {
    let mut values: Vec<&str> = Vec::new();
    for of in all {
        let value = of.chosen[chosen].1.as_str();
        if !values.contains(&value) {
            values.push(value);
        }
    }
    values
}

/// A key in words with its unit, for numbers of this size, after the factor from SI to the unit.
fn title(vary: &Vary, size: f64) -> (f64, String) {
    let key = short(&vary.key);
    let (factor, words) = axis_words(&words(key), unit(key), size);
    (factor, [words, vary.note.clone()].join(" ").trim().into())
}

/// A value of a key in words: `load 4 kN`, `kind pcg`.
fn value_words(vary: &Vary, value: &str) -> String {
    let key = short(&vary.key);
    let value = value.parse().map_or(value.into(), |x| with_unit_of(key, x));
    format!("{} {value}", words(key))
}

/// maps.svg of a study of two keys: one panel per measure, the first key upwards and the second to the right; each cell has the mean over
/// the scenes and the half-width of its 95 % interval. `None` if the keys form no grid.
pub fn maps(means: &[EnsembleMean], keys: &[Vary]) -> Option<String> {
    let pairs: Vec<&EnsembleMean> = means.iter().filter(|of| !of.chosen.is_empty()).collect();
    if pairs.is_empty() || pairs.iter().any(|of| of.chosen.len() != 2) {
        return None;
    }
    let (rows, columns) = (distinct(&pairs, 0), distinct(&pairs, 1));
    if rows.len() < 2 || columns.len() < 2 {
        return None;
    }
    let axis = |key: usize, values: &[&str]| {
        let mut axis = PlotAxis::linear(&title(&keys[key], 0.0).1, [0.0, values.len() as f64], 2);
        let places = (0..).map(|k| f64::from(k) + 0.5);
        axis.ticks = places.zip(values.iter().map(ToString::to_string)).collect();
        axis
    };
    let [up, right] = [0, 1].map(|side: usize| pairs[0].chosen[side].0);
    let axes = [axis(right, &columns), axis(up, &rows)];
    let place = |values: &[&str], own: &str| {
        let place = values.iter().position(|value| *value == own);
        place.unwrap_or_default() as f64
    };
    let panels: Vec<_> = pairs.chunk_by(|a, b| a.measure == b.measure).collect();
    let mut page = Page::new(panels.len(), 1);
    for panel in panels {
        let [low, high] = range(panel.iter().map(|of| of.mean)).unwrap_or_default();
        let (factor, title) = panel[0].title(panel.iter().map(|of| of.mean));
        page.draw(&axes, |svg, axes| {
            for of in panel {
                let x = place(&columns, &of.chosen[1].1);
                let y = place(&rows, &of.chosen[0].1);
                let ([left, bottom], [end, top]) = (axes.at((x, y)), axes.at((x + 1.0, y + 1.0)));
                let wide = if high > low { high - low } else { 1.0 };
                let share = (of.mean - low) / wide;
                let style = format!("fill=\"{}\" stroke=\"#fff\"", shade(MAP_SHADE * share));
                svg.rectangle(&style, [left, top], [end - left, bottom - top]);
                let ink = if share > 0.7 { "#fff" } else { BLACK };
                let middle = [0.5 * (left + end), 0.5 * (top + bottom)];
                let style = format!("fill=\"{ink}\"");
                let mean = three_digits(factor * of.mean);
                svg.styled_text(&style, middle, Anchor::Middle, &mean);
                let below = [middle[0], middle[1] + 16.0];
                let half = match of.values.len() {
                    1 => String::new(),
                    _ => format!("+- {}", three_digits(factor * of.half_width)),
                };
                let style = format!("font-size=\"10\" {style}");
                svg.styled_text(&style, below, Anchor::Middle, &half);
            }
        });
        page.words(BLACK, &title);
    }
    Some(page.svg())
}

/// A number with three digits, with an exponent only if it needs one.
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
pub(super) struct Page {
    svg: Svg,
    panels: usize,
    /// Height of a panel with its words (pixels).
    height: f64,
    /// Number of panels drawn, and of lines below the last one.
    drawn: usize,
    lines: usize,
}

impl Page {
    pub(super) fn new(panels: usize, lines: usize) -> Page {
        Page {
            svg: Svg::default(),
            panels,
            height: PANEL[1] + LINE * lines as f64,
            drawn: 0,
            lines: 0,
        }
    }

    /// Upper left corner of the panel drawn last.
    fn corner(&self) -> [f64; 2] {
        let last = self.drawn.saturating_sub(1);
        let [row, column] = [last / 2, last % 2].map(|k| k as f64);
        [PANEL[0] * column, self.height * row]
    }

    /// Draws the next panel.
    pub(super) fn draw(&mut self, [x, y]: &[PlotAxis; 2], content: impl Fn(&mut Svg, &AxisPair)) {
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

    /// A legend entry below the panel, with a piece of the line.
    pub(super) fn words_of_line(&mut self, number: usize, words: &str) {
        let [x, y] = self.place_of_words();
        let style = line_style(number);
        self.svg.line(&style, [x, x + 30.0].map(|x| [x, y - 3.5]));
        self.write(COLOURS[number % COLOURS.len()], [x + 38.0, y], words);
    }

    /// A line of words below the panel, cut off at the panel's width.
    pub(super) fn words(&mut self, colour: &str, words: &str) {
        self.write(colour, self.place_of_words(), words);
    }

    /// Start of the next line of words.
    fn place_of_words(&self) -> [f64; 2] {
        let [left, top] = self.corner();
        [left + 20.0, top + PANEL[1] + LINE * self.lines as f64 + 9.0]
    }

    fn write(&mut self, colour: &str, at: [f64; 2], words: &str) {
        let words: String = words.chars().take(LINE_LETTERS).collect();
        let style = format!("font-size=\"9.7\" fill=\"{colour}\"");
        self.svg.styled_text(&style, at, Anchor::Start, &words);
        self.lines += 1;
    }

    pub(super) fn svg(&self) -> String {
        let rows = self.panels.div_ceil(2);
        self.svg.page([2.0 * PANEL[0], self.height * rows as f64])
    }
}

/// The smallest positive number; 1 without any.
fn smallest(numbers: impl Iterator<Item = f64>) -> f64 {
    let least = numbers.filter(|x| *x > 0.0).fold(f64::INFINITY, f64::min);
    if least.is_finite() { least } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn keys() -> Vec<Vary> {
        let key = |text: &str| toml::from_str(text).expect("a key");
        vec![
            key("key = \"p.rail.config.wheel.load_n\"\nvalues = [4000.0, 8000.0]"),
            key("key = \"p.layer.config.law.friction\"\nvalues = [0.1, 0.3, 0.5]"),
        ]
    }

    fn mean(chosen: &[(usize, &str)], mean: f64) -> EnsembleMean {
        let chosen = chosen.iter().map(|(key, value)| (*key, value.to_string()));
        EnsembleMean::single("pressure", "Pa", chosen.collect(), mean)
    }

    fn joined(svg: &str) -> usize {
        // Intervals have two ends, and so have the lines of a legend.
        let lines = svg.split("points=\"").skip(1);
        let points = lines.map(|line| line.split('"').next().unwrap_or_default());
        points
            .filter(|points| points.split(' ').count() > 4)
            .count()
    }

    #[test]
    fn means_of_two_keys_are_lines_over_the_key_with_more_values() {
        let loads = ["4000", "8000"];
        let all = loads.map(|load| {
            ["0.1", "0.3", "0.5"].map(|friction| mean(&[(0, load), (1, friction)], 1e9))
        });
        let svg = means(&all.concat(), &keys());
        assert_eq!(joined(&svg), 2, "{svg}");
        for words in [
            ">friction<",
            ">load 4 kN<",
            ">load 8 kN<",
            ">pressure (GPa)<",
        ] {
            assert!(svg.contains(words), "{words}: {svg}");
        }
        let map = maps(&all.concat(), &keys()).expect("a grid");
        assert!(
            map.contains(">load (N)<") && map.contains(">pressure (GPa)<"),
            "{map}"
        );
    }

    #[test]
    fn keys_varied_one_at_a_time_have_a_panel_each_and_the_reference_is_a_line() {
        let all = [
            mean(&[], 1e6),
            mean(&[(0, "4000")], 2e6),
            mean(&[(0, "8000")], 3e6),
            mean(&[(1, "0.1")], 4e6),
        ];
        let svg = means(&all, &keys());
        assert!(
            svg.contains(">load (kN)<") && svg.contains(">friction<"),
            "{svg}"
        );
        assert_eq!(
            svg.matches("dashed across the panel: the reference")
                .count(),
            2
        );
        assert!(maps(&all, &keys()).is_none());
        // With seeds alone there is one mean, over no key.
        assert_eq!(means(&all[..1], &keys()).matches("<circle").count(), 0);
    }
}
