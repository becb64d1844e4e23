//! Interface traction, friction loop, forces and sliding nodes over time: whatever the run's tables hold.

use std::collections::BTreeMap;
use std::ops::Range;
use std::path::Path;

use plotters::prelude::*;

use super::scene::{Panel, picture};
use crate::error::Error;

/// Columns of numbers by their names.
pub type Columns = BTreeMap<String, Vec<f64>>;

/// One line of a plot.
pub(crate) struct Curve {
    pub(crate) label: &'static str,
    pub(crate) points: Vec<(f64, f64)>,
    pub(crate) colour: RGBColor,
}

const BLUE_LINE: RGBColor = RGBColor(31, 90, 160);
const RED_LINE: RGBColor = RGBColor(190, 50, 40);
/// More dots than this make a file that browsers are slow to draw.
const DOTS_MAX: usize = 8000;

/// Height of a line of the legend over that of the curves.
const LEGEND_LINE: f64 = 0.1;

/// Name of the file, caption, SVG.
type Plot = (&'static str, &'static str, String);

/// Every plot that the run has the columns for.
pub fn all(run: &Path) -> Result<Vec<Plot>, Error> {
    let profile = read_csv(&run.join("profile.csv"));
    let signals = Signals(read_csv(&run.join("signals.csv")));
    let plots = [
        pressure(&profile)?,
        forces(&signals)?,
        friction(&signals)?,
        sliding(&signals)?,
        sliding_over_velocity(&signals)?,
    ];
    Ok(plots.into_iter().flatten().collect())
}

/// Columns of signals.csv.
struct Signals(Columns);

impl Signals {
    /// The first participant's column of this name.
    fn column(&self, name: &str) -> Option<&Vec<f64>> {
        let ending = format!(".{name}");
        let mut columns = self.0.iter();
        columns
            .find(|(key, _)| *key == name || key.ends_with(&ending))
            .map(|(_, values)| values)
    }
}

fn pressure(profile: &Columns) -> Result<Option<Plot>, Error> {
    let (Some(x), Some(pressure)) = (profile.get("x_m"), profile.get("pressure_pa")) else {
        return Ok(None);
    };
    let curves = [
        Curve {
            label: "at the nodes",
            points: join(x, pressure, 1e3, 1e-6),
            colour: RGBColor(170, 190, 210),
        },
        Curve {
            label: "mean over 1 mm",
            points: join(x, &moving_mean(x, pressure, 1e-3), 1e3, 1e-6),
            colour: BLUE_LINE,
        },
    ];
    let svg = plot("x (mm)", "pressure on the rail (MPa)", &curves)?;
    let caption = "Pressure on the rail at the end of the hold";
    Ok(Some(("profile.svg", caption, svg)))
}

fn forces(signals: &Signals) -> Result<Option<Plot>, Error> {
    let (Some(t), Some(normal), Some(tangential)) = (
        signals.column("t_s"),
        signals.column("wheel_fn_n"),
        signals.column("wheel_ft_n"),
    ) else {
        return Ok(None);
    };
    let curves = [
        Curve {
            label: "normal",
            points: join(t, normal, 1e3, 1.0),
            colour: BLUE_LINE,
        },
        Curve {
            label: "tangential",
            points: join(t, tangential, 1e3, 1.0),
            colour: RED_LINE,
        },
    ];
    let svg = plot("t (ms)", "force (N)", &curves)?;
    Ok(Some(("forces.svg", "Force on the wheel", svg)))
}

fn friction(signals: &Signals) -> Result<Option<Plot>, Error> {
    let (Some(x), Some(tangential)) = (signals.column("wheel_x_m"), signals.column("wheel_ft_n"))
    else {
        return Ok(None);
    };
    if x.iter().all(|x| *x == 0.0) {
        return Ok(None);
    }
    let curve = Curve {
        label: "tangential force",
        points: join(x, tangential, 1e3, 1.0),
        colour: RED_LINE,
    };
    let svg = plot("D (mm)", "tangential force (N)", &[curve])?;
    let caption = "Tangential force over the wheel's lateral position";
    Ok(Some(("friction.svg", caption, svg)))
}

/// Share of sliding nodes over time, beside |D| over its amplitude.
fn sliding(signals: &Signals) -> Result<Option<Plot>, Error> {
    let (Some(t), Some(sn), Some(x)) = (
        signals.column("t_s"),
        signals.column("sn_pct"),
        signals.column("wheel_x_m"),
    ) else {
        return Ok(None);
    };
    let amplitude = x.iter().fold(0.0, |far: f64, x| far.max(x.abs()));
    if amplitude == 0.0 {
        return Ok(None);
    }
    let moved: Vec<f64> = x.iter().map(|x| 100.0 * x.abs() / amplitude).collect();
    let curves = [
        Curve {
            label: "Sn",
            points: join(t, sn, 1e3, 1.0),
            colour: BLUE_LINE,
        },
        Curve {
            label: "|D| over its amplitude",
            points: join(t, &moved, 1e3, 1.0),
            colour: RED_LINE,
        },
    ];
    let svg = plot("t (ms)", "(%)", &curves)?;
    let caption = "Share of sliding nodes over time";
    Ok(Some(("sliding.svg", caption, svg)))
}

/// Share of sliding nodes over the wheel's lateral velocity, while it moves.
fn sliding_over_velocity(signals: &Signals) -> Result<Option<Plot>, Error> {
    let (Some(velocity), Some(sn)) = (signals.column("wheel_vx_m_per_s"), signals.column("sn_pct"))
    else {
        return Ok(None);
    };
    if velocity.iter().all(|v| *v == 0.0) {
        return Ok(None);
    }
    let moving = velocity.iter().zip(sn).filter(|(v, _)| **v != 0.0);
    let points: Vec<(f64, f64)> = moving.map(|(v, sn)| (1e3 * v, *sn)).collect();
    let svg = cloud("wheel velocity (mm/s)", "Sn (%)", &points)?;
    let caption = "Share of sliding nodes over the velocity of the wheel";
    Ok(Some(("sliding-velocity.svg", caption, svg)))
}

/// One dot for each point, pale enough that their density shows.
fn cloud(x_desc: &str, y_desc: &str, points: &[(f64, f64)]) -> Result<String, Error> {
    let x = range(points.iter().map(|point| point.0));
    let y = range(points.iter().map(|point| point.1));
    let stride = points.len().div_ceil(DOTS_MAX).max(1);
    let mut svg = String::new();
    {
        let area = SVGBackend::with_string(&mut svg, (900, 380)).into_drawing_area();
        let mut chart = axes(&area, (x_desc, x), (y_desc, y))?;
        let dot = |point: &(f64, f64)| Circle::new(*point, 1, BLUE_LINE.mix(0.35).filled());
        chart
            .draw_series(points.iter().step_by(stride).map(dot))
            .map_err(picture)?;
        area.present().map_err(picture)?;
    }
    Ok(svg)
}

pub(crate) fn plot(x_desc: &str, y_desc: &str, curves: &[Curve]) -> Result<String, Error> {
    let points = || curves.iter().flat_map(|curve| &curve.points);
    let x = range(points().map(|point| point.0));
    let y = range(points().map(|point| point.1));
    // The legend stands above all curves.
    let above = LEGEND_LINE * curves.len() as f64 * (y.end - y.start);
    let y = y.start..y.end + above;
    let mut svg = String::new();
    {
        let area = SVGBackend::with_string(&mut svg, (900, 380)).into_drawing_area();
        let mut chart = axes(&area, (x_desc, x), (y_desc, y))?;
        for curve in curves {
            let colour = curve.colour;
            chart
                .draw_series(LineSeries::new(curve.points.iter().copied(), &colour))
                .map_err(picture)?
                .label(curve.label)
                .legend(move |(x, y)| PathElement::new([(x, y), (x + 18, y)], colour));
        }
        chart
            .configure_series_labels()
            .position(SeriesLabelPosition::UpperRight)
            .background_style(WHITE)
            .border_style(BLACK.mix(0.3))
            .draw()
            .map_err(picture)?;
        area.present().map_err(picture)?;
    }
    Ok(svg)
}

/// A white page with axes, ready to be drawn into: what each axis shows, and from where to where.
fn axes<'a, 'b>(
    area: &'a DrawingArea<SVGBackend<'b>, plotters::coord::Shift>,
    (x_desc, x): (&str, Range<f64>),
    (y_desc, y): (&str, Range<f64>),
) -> Result<Panel<'a, 'b>, Error> {
    area.fill(&WHITE).map_err(picture)?;
    let mut chart = ChartBuilder::on(area)
        .margin(14)
        .x_label_area_size(40)
        .y_label_area_size(70)
        .build_cartesian_2d(x, y)
        .map_err(picture)?;
    chart
        .configure_mesh()
        .light_line_style(WHITE)
        .bold_line_style(BLACK.mix(0.1))
        .x_desc(x_desc)
        .y_desc(y_desc)
        .draw()
        .map_err(picture)?;
    Ok(chart)
}

fn range(values: impl Iterator<Item = f64>) -> Range<f64> {
    let (low, high) = values
        .filter(|value| value.is_finite())
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| {
            (low.min(v), high.max(v))
        });
    if low > high {
        return 0.0..1.0;
    }
    let margin = 0.04 * (high - low).max(1e-12 * high.abs()).max(f64::MIN_POSITIVE);
    low - margin..high + margin
}

/// Points of two columns, scaled, at most about 4 000 of them.
fn join(x: &[f64], y: &[f64], x_scale: f64, y_scale: f64) -> Vec<(f64, f64)> {
    let stride = x.len().div_ceil(4000).max(1);
    x.iter()
        .zip(y)
        .step_by(stride)
        .map(|(x, y)| (x * x_scale, y * y_scale))
        .collect()
}

/// Mean of the values whose places lie within half of `width` of each place.
fn moving_mean(x: &[f64], y: &[f64], width: f64) -> Vec<f64> {
    x.iter()
        .map(|centre| {
            let near = x
                .iter()
                .zip(y)
                .filter(|(x, _)| (**x - centre).abs() <= 0.5 * width * (1.0 + 1e-9));
            let (sum, count) = near.fold((0.0, 0.0), |(sum, count), (_, y)| (sum + y, count + 1.0));
            sum / count
        })
        .collect()
}

/// Columns of numbers by name; an absent file has none, cells that are no numbers are left out.
pub fn read_csv(path: &Path) -> Columns {
    let text = std::fs::read_to_string(path).unwrap_or_default();
    let mut lines = text.lines();
    let names: Vec<&str> = lines.next().unwrap_or_default().split(',').collect();
    let mut columns = Columns::new();
    for line in lines {
        for (name, cell) in names.iter().zip(line.split(',')) {
            if let Ok(value) = cell.parse() {
                columns.entry(name.to_string()).or_default().push(value);
            }
        }
    }
    columns
}
