//! Interface traction, friction loop, forces and sliding nodes over time: whatever the run's tables hold.

use std::collections::BTreeMap;
use std::path::Path;

use plotters::prelude::*;

use super::plot::{BLUE_LINE, Curve, Labels, cloud, plot};
use super::view::Picture;
use crate::error::Error;

/// Columns of numbers by their names.
pub type Columns = BTreeMap<String, Vec<f64>>;

const RED_LINE: RGBColor = RGBColor(190, 50, 40);
const PALE_LINE: RGBColor = RGBColor(170, 190, 210);

/// Share of the profile's length over which the smooth curve of its pressure is a mean.
const MEAN_SHARE: f64 = 0.05;

/// Signals over another one, in plain lines.
struct Chart<'a> {
    file: &'static str,
    caption: &'a str,
    labels: [&'a str; 2],
    /// Signal along x, which is drawn a thousandfold (s to ms, m to mm).
    x: &'a str,
    /// Word of the legend, signal and colour of each line.
    y: &'a [(&'a str, &'a str, RGBColor)],
}

/// |D| over its amplitude (%): a column that the report adds to those of signals.csv, where the wheel moves.
const SHARE: &str = "share_of_amplitude_pct";

/// Height of the wheel over that at which its motion began (um): another such column.
const RISE: &str = "wheel_rise_um";

const CHARTS: [Chart; 4] = [
    Chart {
        file: "forces.svg",
        caption: "Force on the wheel",
        labels: ["t (ms)", "force (N)"],
        x: "t_s",
        y: &[
            ("normal", "wheel_fn_n", BLUE_LINE),
            ("tangential", "wheel_ft_n", RED_LINE),
        ],
    },
    Chart {
        file: "friction.svg",
        caption: "Tangential force over the wheel's lateral position",
        labels: ["D (mm)", "tangential force (N)"],
        x: "wheel_x_m",
        y: &[("tangential force", "wheel_ft_n", RED_LINE)],
    },
    Chart {
        file: "wheel-path.svg",
        caption: "Height of the wheel over its lateral position",
        labels: ["D (mm)", "rise (um)"],
        x: "wheel_x_m",
        y: &[("rise since the motion began", RISE, BLUE_LINE)],
    },
    Chart {
        file: "sliding.svg",
        caption: "Share of sliding nodes over time",
        labels: ["t (ms)", "(%)"],
        x: "t_s",
        y: &[
            ("Sn", "sn_pct", BLUE_LINE),
            ("|D| over its amplitude", SHARE, RED_LINE),
        ],
    },
];

/// Every plot that the run has the columns for.
pub fn all(run: &Path) -> Result<Vec<Picture>, Error> {
    let mut signals = read_csv(&run.join("signals.csv"));
    if let Some(x) = moving(&signals, "wheel_x_m") {
        let amplitude = x.iter().fold(0.0, |far: f64, x| far.max(x.abs()));
        let share = x.iter().map(|x| 100.0 * x.abs() / amplitude).collect();
        let began = x.iter().position(|x| *x != 0.0).unwrap_or(0);
        let rise = column(&signals, "wheel_y_m").map(|y| rise(y, began.saturating_sub(1)));
        signals.insert(SHARE.into(), share);
        signals.extend(rise.map(|rise| (RISE.into(), rise)));
    }
    let mut pictures = Vec::new();
    pictures.extend(pressure(&read_csv(&run.join("profile.csv")))?);
    for chart in &CHARTS {
        pictures.extend(lines(&signals, chart)?);
    }
    pictures.extend(sliding_over_velocity(&signals)?);
    Ok(pictures)
}

/// Heights (m) over the one at this place (um); those before it are left where they will begin.
fn rise(heights: &[f64], began: usize) -> Vec<f64> {
    let first = heights.get(began).copied().unwrap_or(0.0);
    let since = |(place, height): (usize, &f64)| {
        if place < began {
            0.0
        } else {
            1e6 * (height - first)
        }
    };
    heights.iter().enumerate().map(since).collect()
}

/// The first participant's column of this name.
fn column<'a>(signals: &'a Columns, name: &str) -> Option<&'a [f64]> {
    let ending = format!(".{name}");
    let mut columns = signals.iter();
    let found = columns.find(|(key, _)| *key == name || key.ends_with(&ending));
    found.map(|(_, values)| values.as_slice())
}

/// The same, of a signal that is not zero throughout.
fn moving<'a>(signals: &'a Columns, name: &str) -> Option<&'a [f64]> {
    column(signals, name).filter(|values| values.iter().any(|value| *value != 0.0))
}

fn pressure(profile: &Columns) -> Result<Option<Picture>, Error> {
    let (Some(x), Some(pressure)) = (profile.get("x_m"), profile.get("pressure_pa")) else {
        return Ok(None);
    };
    let low = x.iter().copied().fold(f64::INFINITY, f64::min);
    let high = x.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let width = MEAN_SHARE * (high - low);
    let mean = format!("mean over {:.2} mm", 1e3 * width);
    let curve = |label, pressure, colour| Curve {
        label,
        points: join(x, pressure, 1e-6),
        colour,
    };
    let curves = [
        curve("at the nodes", pressure, PALE_LINE),
        curve(&mean, &moving_mean(x, pressure, width), BLUE_LINE),
    ];
    let labels = Labels {
        x: "x (mm)",
        y: "pressure on the surface (MPa)",
    };
    Ok(Some(Picture {
        file: "profile.svg",
        caption: "Pressure on the surface".into(),
        svg: plot(labels, &curves)?,
    }))
}

/// Draws a chart where all its signals are there, and that along x is not zero throughout.
fn lines(signals: &Columns, chart: &Chart<'static>) -> Result<Option<Picture>, Error> {
    let curve = |(label, signal, colour): &(&'static str, &str, RGBColor)| {
        let (x, y) = (moving(signals, chart.x)?, column(signals, signal)?);
        Some(Curve {
            label,
            points: join(x, y, 1.0),
            colour: *colour,
        })
    };
    let Some(curves) = chart.y.iter().map(curve).collect::<Option<Vec<Curve>>>() else {
        return Ok(None);
    };
    let [x, y] = chart.labels;
    Ok(Some(Picture {
        file: chart.file,
        caption: chart.caption.into(),
        svg: plot(Labels { x, y }, &curves)?,
    }))
}

/// Share of sliding nodes over the wheel's lateral velocity, while it moves.
fn sliding_over_velocity(signals: &Columns) -> Result<Option<Picture>, Error> {
    let velocity = moving(signals, "wheel_vx_m_per_s");
    let (Some(velocity), Some(sn)) = (velocity, column(signals, "sn_pct")) else {
        return Ok(None);
    };
    let moving = velocity.iter().zip(sn).filter(|(v, _)| **v != 0.0);
    let points: Vec<(f64, f64)> = moving.map(|(v, sn)| (1e3 * v, *sn)).collect();
    let labels = Labels {
        x: "wheel velocity (mm/s)",
        y: "Sn (%)",
    };
    Ok(Some(Picture {
        file: "sliding-velocity.svg",
        caption: "Share of sliding nodes over the velocity of the wheel".into(),
        svg: cloud(labels, &points)?,
    }))
}

/// Points of two columns, at most about 4 000 of them: the first is scaled by 1000, the second by `y_scale`.
fn join(x: &[f64], y: &[f64], y_scale: f64) -> Vec<(f64, f64)> {
    let stride = x.len().div_ceil(4000).max(1);
    let points = x.iter().zip(y).step_by(stride);
    points.map(|(x, y)| (x * 1e3, y * y_scale)).collect()
}

/// Mean of the values whose places lie within half of `width` of each place.
fn moving_mean(x: &[f64], y: &[f64], width: f64) -> Vec<f64> {
    let reach = 0.5 * width * (1.0 + 1e-9);
    let mean = |centre: &f64| {
        let near = x
            .iter()
            .zip(y)
            .filter(|(x, _)| (**x - centre).abs() <= reach);
        let (sum, count) = near.fold((0.0, 0.0), |(sum, count), (_, y)| (sum + y, count + 1.0));
        sum / count
    };
    x.iter().map(mean).collect()
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
