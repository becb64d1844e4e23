//! Pictures of a study: errors over costs with the front, and errors along each knob.

use std::ops::Range;

use plotters::coord::Shift;
use plotters::coord::combinators::WithKeyPoints;
use plotters::prelude::*;

use super::collect::Results;
use super::front::Trade;
use super::settings::StudySetting;
use super::varied_keys::{VariedKey, percent};
use draw::page::{picture, svg};

/// Size of a panel (pixels), and height of a line of words below it.
const PANEL: (u32, u32) = (640, 400);
const LINE: u32 = 20;
/// Colours of measures, dark enough to be told apart in grey.
const COLOURS: [RGBColor; 5] = [
    RGBColor(20, 70, 140),
    RGBColor(190, 80, 20),
    RGBColor(40, 130, 60),
    RGBColor(120, 40, 130),
    RGBColor(90, 90, 90),
];
/// Part of the smallest error that is drawn for one of 0, which has no logarithm.
const BOTTOM: f64 = 0.3;

/// Letters that fit below an axis.
const LETTERS: usize = 60;

/// Words for a front that nowhere lies below the chord of its ends.
pub const NO_KNEE: &str = "no knee: the front lies above the chord between its ends";

type Area<'b> = DrawingArea<SVGBackend<'b>, Shift>;

/// Settings and the front of one measure.
pub struct FrontPanel<'a> {
    /// Name of the measure.
    pub measure: &'a str,
    /// All settings that stand.
    pub trades: &'a [Trade],
    /// Settings that do not, of which cost and error are known.
    pub fallen: &'a [Trade],
    /// The front.
    pub front: &'a [Trade],
    /// Place of the knee in it.
    pub knee: Option<usize>,
    /// The floor of noise.
    pub floor: f64,
}

/// front.svg: a panel a measure.
///
/// # Errors
/// The picture cannot be drawn.
pub fn fronts(
    panels: &[FrontPanel],
    settings: &[StudySetting],
    results: &Results,
) -> Result<String, String> {
    let relative = results.reference(0).is_some();
    let cost = if relative {
        "processor time over that of the reference"
    } else {
        "processor time (s)"
    };
    let rows = panels.len().div_ceil(2);
    let size = (2 * PANEL.0, rows as u32 * (PANEL.1 + 2 * LINE));
    svg(size, |page| {
        for (area, panel) in page.split_evenly((rows, 2)).iter().zip(panels) {
            draw_front(area, panel, cost)?;
            let words = |place: usize| {
                let trade = &panel.front[place];
                let told = settings[trade.setting].words(results);
                format!(
                    "{told}: cost {:.3}, error {} %",
                    trade.cost,
                    percent(trade.error)
                )
            };
            let knee = panel
                .knee
                .map(|knee| format!("knee (ring): {}", words(knee)));
            let floor = format!(
                "floor of noise (dashed where it is in the picture): {} %; crosses: suspect",
                percent(panel.floor)
            );
            write_lines(area, &[knee.unwrap_or(NO_KNEE.into()), floor])?;
        }
        Ok(())
    })
}

fn draw_front(area: &Area, panel: &FrontPanel, cost: &str) -> Result<(), String> {
    let (upper, _) = area.split_vertically(PANEL.1);
    let all = || panel.trades.iter().chain(panel.fallen);
    let smallest = smallest(all().map(|t| t.error));
    let point = |trade: &Trade| (trade.cost, 100.0 * trade.error.max(BOTTOM * smallest));
    let (x, y) = (span(all().map(|t| t.cost)), span(all().map(|t| point(t).1)));
    let floor = Some(panel.floor).filter(|floor| y.contains(&(100.0 * floor)));
    let mut chart = axes(
        &upper,
        Axis {
            ticks: ticks(&x),
            range: x.clone(),
            title: cost.into(),
            label: &|x| number(*x),
        },
        Axis {
            ticks: ticks(&y),
            range: y,
            title: format!("error_{} (%)", panel.measure),
            label: &|y| number(*y),
        },
    )?;
    if let Some(floor) = floor {
        let ends = [(x.start, 100.0 * floor), (x.end, 100.0 * floor)];
        let line = DashedLineSeries::new(ends, 6, 4, BLACK.mix(0.6).stroke_width(1));
        chart.draw_series(line).map_err(picture)?;
    }
    let dots = panel
        .trades
        .iter()
        .map(|t| Circle::new(point(t), 3, BLACK.mix(0.35).filled()));
    chart.draw_series(dots).map_err(picture)?;
    let crosses = panel
        .fallen
        .iter()
        .map(|t| Cross::new(point(t), 4, COLOURS[1]));
    chart.draw_series(crosses).map_err(picture)?;
    let line = panel.front.iter().map(point);
    chart
        .draw_series(LineSeries::new(line, COLOURS[0].stroke_width(2)))
        .map_err(picture)?;
    let dots = panel
        .front
        .iter()
        .map(|t| Circle::new(point(t), 4, COLOURS[0].filled()));
    chart.draw_series(dots).map_err(picture)?;
    let knee = panel
        .knee
        .map(|knee| Circle::new(point(&panel.front[knee]), 9, COLOURS[0].stroke_width(2)));
    chart.draw_series(knee).map(|_| ()).map_err(picture)
}

/// knobs.svg: a panel a key, with a word on each trend below it.
///
/// # Errors
/// The picture cannot be drawn.
pub fn knobs(knobs: &[VariedKey], measures: &[String]) -> Result<String, String> {
    let rows = knobs.len().div_ceil(2);
    let lines = measures.len() as u32 + 1;
    let size = (2 * PANEL.0, rows as u32 * (PANEL.1 + (lines + 1) * LINE));
    svg(size, |page| {
        for (area, knob) in page.split_evenly((rows, 2)).iter().zip(knobs) {
            draw_knob(area, knob)?;
            let mut lines = knob.trends(measures);
            if lines.is_empty() {
                lines = measures
                    .iter()
                    .map(|name| format!("error_{name}"))
                    .collect();
            }
            lines.push(knob.note.clone());
            write_coloured(area, &lines, measures.len())?;
        }
        Ok(())
    })
}

fn draw_knob(area: &Area, knob: &VariedKey) -> Result<(), String> {
    let (upper, _) = area.split_vertically(PANEL.1);
    let place = |k: usize| match knob.positions[k].value.parse::<f64>() {
        Ok(number) if knob.numeric => number,
        _ => 10f64.powi(k as i32),
    };
    // A run that is the reference has no error, and an axis that reached for it would hide the others.
    let drawn = |k: &usize| !knob.positions[*k].reference;
    let of = |k: usize| knob.positions[k].errors.iter().flatten().copied();
    let errors = || (0..knob.positions.len()).filter(drawn).flat_map(of);
    let smallest = smallest(errors());
    let height = |error: f64| 100.0 * error.max(BOTTOM * smallest);
    let x = span((0..knob.positions.len()).map(place));
    let y = span(errors().map(height));
    let places: Vec<f64> = (0..knob.positions.len()).map(place).collect();
    // Words that would overlap are numbered as digest.txt lists them.
    let letters: usize = knob.positions.iter().map(|p| p.value.chars().count()).sum();
    let numbered = !knob.numeric && letters > LETTERS;
    let label = |x: &f64| {
        let near = (0..knob.positions.len()).find(|k| (place(*k) / x).ln().abs() < 1e-6);
        near.map_or(String::new(), |k| {
            let position = &knob.positions[k];
            let value = if numbered {
                format!("{}", k + 1)
            } else {
                position.value.clone()
            };
            if position.reference {
                format!("{value} (ref.)")
            } else {
                value
            }
        })
    };
    let title = if numbered {
        format!("{}, by its place in digest.txt", knob.key)
    } else {
        knob.key.clone()
    };
    let mut chart = axes(
        &upper,
        Axis {
            ticks: places,
            range: x.clone(),
            title,
            label: &label,
        },
        Axis {
            ticks: ticks(&y),
            range: y.clone(),
            title: "error (%)".into(),
            label: &|y| number(*y),
        },
    )?;
    for (measure, floor) in knob.floors.iter().enumerate() {
        let colour = COLOURS[measure % COLOURS.len()];
        let points = (0..knob.positions.len())
            .filter(drawn)
            .filter_map(|k| Some((place(k), height(knob.positions[k].errors[measure]?))));
        let mut points: Vec<(f64, f64)> = points.collect();
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        if knob.numeric {
            let line = LineSeries::new(points.iter().copied(), colour.stroke_width(2));
            chart.draw_series(line).map_err(picture)?;
        }
        let dots = points.iter().map(|p| Circle::new(*p, 4, colour.filled()));
        chart.draw_series(dots).map_err(picture)?;
        if y.contains(&(100.0 * floor)) {
            let ends = [(x.start, 100.0 * floor), (x.end, 100.0 * floor)];
            let line = DashedLineSeries::new(ends, 6, 4, colour.stroke_width(1));
            chart.draw_series(line).map_err(picture)?;
        }
    }
    Ok(())
}

/// A logarithmic axis.
struct Axis<'a> {
    range: Range<f64>,
    ticks: Vec<f64>,
    title: String,
    label: &'a dyn Fn(&f64) -> String,
}

type Logarithmic = WithKeyPoints<LogCoord<f64>>;
type Chart<'a> = ChartContext<'a, SVGBackend<'a>, Cartesian2d<Logarithmic, Logarithmic>>;

/// A chart with its axes drawn.
fn axes<'a>(area: &Area<'a>, x: Axis, y: Axis) -> Result<Chart<'a>, String> {
    let mut chart = ChartBuilder::on(area)
        .margin(14)
        .x_label_area_size(40)
        .y_label_area_size(70)
        .build_cartesian_2d(
            x.range.log_scale().with_key_points(x.ticks),
            y.range.log_scale().with_key_points(y.ticks),
        )
        .map_err(picture)?;
    chart
        .configure_mesh()
        .light_line_style(WHITE)
        .bold_line_style(BLACK.mix(0.1))
        .x_label_formatter(x.label)
        .y_label_formatter(y.label)
        .x_desc(x.title)
        .y_desc(y.title)
        .draw()
        .map_err(picture)?;
    Ok(chart)
}

/// Lines of words below the panel of an area.
fn write_lines(area: &Area, lines: &[String]) -> Result<(), String> {
    write_coloured(area, lines, 0)
}

/// The same, the first ones in the colours of measures.
fn write_coloured(area: &Area, lines: &[String], coloured: usize) -> Result<(), String> {
    for (k, line) in lines.iter().enumerate() {
        let colour = if k < coloured {
            COLOURS[k % COLOURS.len()]
        } else {
            BLACK
        };
        let style = ("sans-serif", 12).into_font().color(&colour);
        // What is longer would leave the panel.
        let line: String = line.chars().take(112).collect();
        let at = (20, (PANEL.1 + LINE * k as u32) as i32);
        area.draw_text(&line, &style, at).map_err(picture)?;
    }
    Ok(())
}

/// The smallest positive number; 1 of none.
fn smallest(numbers: impl Iterator<Item = f64>) -> f64 {
    let least = numbers.filter(|x| *x > 0.0).fold(f64::INFINITY, f64::min);
    if least.is_finite() { least } else { 1.0 }
}

/// Extent of a logarithmic axis.
fn span(numbers: impl Iterator<Item = f64>) -> Range<f64> {
    let none = (f64::INFINITY, f64::NEG_INFINITY);
    let finite = numbers.filter(|x| x.is_finite() && *x > 0.0);
    let (low, high) = finite.fold(none, |(low, high), x| (low.min(x), high.max(x)));
    if low > high {
        return 0.1..10.0;
    }
    let margin = (high / low).powf(0.06).max(1.2);
    low / margin..high * margin
}

/// Places of labels: 1, 2 and 5 of each decade of a short axis, decades of a long one, its ends of a very short one.
fn ticks(range: &Range<f64>) -> Vec<f64> {
    let [low, high] = [range.start, range.end].map(f64::log10);
    let decades = low.floor() as i32..=high.ceil() as i32;
    let short = high - low < 2.5;
    let parts: &[f64] = if short { &[1.0, 2.0, 5.0] } else { &[1.0] };
    let all = decades.flat_map(|k| parts.iter().map(move |part| part * 10f64.powi(k)));
    let inside: Vec<f64> = all.filter(|x| range.contains(x)).collect();
    if inside.len() > 1 {
        inside
    } else {
        vec![1.02 * range.start, 0.98 * range.end]
    }
}

/// A number at an axis, as short as it can be.
fn number(x: f64) -> String {
    let rounded: f64 = format!("{x:.2e}").parse().unwrap_or(x);
    if (1e-3..1e5).contains(&rounded.abs()) {
        format!("{rounded}")
    } else {
        format!("{rounded:e}")
    }
}
