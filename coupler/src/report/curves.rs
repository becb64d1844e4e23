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

/// Every plot that the run has the columns for.
pub fn all(run: &Path) -> Result<Vec<Picture>, Error> {
    let profile = read_csv(&run.join("profile.csv"));
    let signals = Signals(read_csv(&run.join("signals.csv")));
    let plots = [
        pressure(&profile),
        lines(&signals, &FORCES),
        lines(&signals, &FRICTION),
        sliding(&signals),
        sliding_over_velocity(&signals),
    ];
    plots.into_iter().filter_map(Result::transpose).collect()
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

    /// The first participant's columns of these names, if all of them are there.
    fn columns<const N: usize>(&self, names: [&str; N]) -> Option<[&Vec<f64>; N]> {
        let found: Vec<&Vec<f64>> = names.iter().filter_map(|name| self.column(name)).collect();
        found.try_into().ok()
    }
}

/// A plot of these curves, as the picture `file`.
fn drawn(
    file: &'static str,
    caption: &str,
    labels: Labels,
    curves: &[Curve],
) -> Result<Option<Picture>, Error> {
    Ok(Some(Picture {
        file,
        caption: caption.into(),
        svg: plot(labels, curves)?,
    }))
}

fn pressure(profile: &Columns) -> Result<Option<Picture>, Error> {
    let (Some(x), Some(pressure)) = (profile.get("x_m"), profile.get("pressure_pa")) else {
        return Ok(None);
    };
    let low = x.iter().copied().fold(f64::INFINITY, f64::min);
    let high = x.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let width = MEAN_SHARE * (high - low);
    let mean = format!("mean over {:.2} mm", 1e3 * width);
    let curves = [
        Curve {
            label: "at the nodes",
            points: join(x, pressure, 1e3, 1e-6),
            colour: PALE_LINE,
        },
        Curve {
            label: &mean,
            points: join(x, &moving_mean(x, pressure, width), 1e3, 1e-6),
            colour: BLUE_LINE,
        },
    ];
    let labels = Labels {
        x: "x (mm)",
        y: "pressure on the surface (MPa)",
    };
    drawn("profile.svg", "Pressure on the surface", labels, &curves)
}

/// Signals over another one, in plain lines.
struct Lines<'a> {
    file: &'static str,
    caption: &'a str,
    labels: Labels<'a>,
    /// Signal along x, which is drawn a thousandfold (s to ms, m to mm).
    x: &'a str,
    /// Word of the legend, signal and colour of each line.
    y: &'a [(&'a str, &'a str, RGBColor)],
}

const FORCES: Lines = Lines {
    file: "forces.svg",
    caption: "Force on the wheel",
    labels: Labels {
        x: "t (ms)",
        y: "force (N)",
    },
    x: "t_s",
    y: &[
        ("normal", "wheel_fn_n", BLUE_LINE),
        ("tangential", "wheel_ft_n", RED_LINE),
    ],
};

const FRICTION: Lines = Lines {
    file: "friction.svg",
    caption: "Tangential force over the wheel's lateral position",
    labels: Labels {
        x: "D (mm)",
        y: "tangential force (N)",
    },
    x: "wheel_x_m",
    y: &[("tangential force", "wheel_ft_n", RED_LINE)],
};

/// Draws lines where all their signals are there, and that along x is not zero throughout.
fn lines(signals: &Signals, lines: &Lines<'static>) -> Result<Option<Picture>, Error> {
    let Some(x) = signals.column(lines.x).filter(|x| moves(x)) else {
        return Ok(None);
    };
    let curve = |(label, signal, colour): &(&'static str, &'static str, RGBColor)| {
        let points = join(x, signals.column(signal)?, 1e3, 1.0);
        Some(Curve {
            label,
            points,
            colour: *colour,
        })
    };
    let curves: Option<Vec<Curve>> = lines.y.iter().map(curve).collect();
    curves.map_or(Ok(None), |curves| {
        drawn(lines.file, lines.caption, lines.labels, &curves)
    })
}

/// Share of sliding nodes over time, beside |D| over its amplitude.
fn sliding(signals: &Signals) -> Result<Option<Picture>, Error> {
    let Some([t, sn, x]) = signals
        .columns(["t_s", "sn_pct", "wheel_x_m"])
        .filter(|[_, _, x]| moves(x))
    else {
        return Ok(None);
    };
    let amplitude = x.iter().fold(0.0, |far: f64, x| far.max(x.abs()));
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
    let labels = Labels {
        x: "t (ms)",
        y: "(%)",
    };
    let caption = "Share of sliding nodes over time";
    drawn("sliding.svg", caption, labels, &curves)
}

/// Share of sliding nodes over the wheel's lateral velocity, while it moves.
fn sliding_over_velocity(signals: &Signals) -> Result<Option<Picture>, Error> {
    let Some([velocity, sn]) = signals
        .columns(["wheel_vx_m_per_s", "sn_pct"])
        .filter(|[velocity, _]| moves(velocity))
    else {
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

fn moves(values: &[f64]) -> bool {
    values.iter().any(|value| *value != 0.0)
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
