//! Curves of the tables of a run: loads and motion, friction, sliding nodes, traction, interface, energies, flows.

use super::units::with_unit;
use draw::picture::Picture;
use draw::plot::{BACKGROUND, Curve, Labels, cloud, plot};
use runs::columns::Columns;
use runs::files::RunFiles;

/// Share of the profile's length over which the smooth curve of its pressure is a mean.
const MEAN_SHARE: f64 = 0.05;

/// Columns that the report adds to those of signals.csv: |D| over its amplitude (%), height of the wheel over that at which its motion
/// began (m), |F_T|/F_N.
const SHARE: &str = "share_of_amplitude_pct";
const RISE: &str = "wheel_rise_m";
const FRICTION: &str = "force_ratio";
/// Place of the wheel and its rise over the mean radius of the grains.
const X_OVER_R: &str = "wheel_x_over_r";
const RISE_OVER_R: &str = "wheel_rise_over_r";

/// Signals over another one.
pub(super) struct Chart {
    pub(super) file: String,
    pub(super) caption: String,
    /// Signal along x with its words and factor.
    pub(super) x: Axis,
    /// Words along y, factor, and whether its axis is logarithmic.
    pub(super) y: Axis,
    /// Words of the legend and signal of each line.
    pub(super) lines: Vec<(String, String)>,
}

/// An axis of a chart.
#[derive(Clone)]
pub(super) struct Axis {
    /// Words along it.
    pub(super) words: String,
    /// The signal along x; nothing along y.
    pub(super) signal: String,
    /// Factor from SI to the unit of the words.
    pub(super) factor: f64,
    pub(super) log: bool,
}

impl Axis {
    fn new(words: &str, signal: &str, factor: f64) -> Axis {
        Axis {
            words: words.into(),
            signal: signal.into(),
            factor,
            log: false,
        }
    }

    pub(super) fn time() -> Axis {
        Axis::new("t (ms)", "t_s", 1e3)
    }

    pub(super) fn y(words: &str, factor: f64) -> Axis {
        Axis::new(words, "", factor)
    }

    pub(super) fn log(words: &str) -> Axis {
        Axis {
            log: true,
            ..Axis::y(words, 1.0)
        }
    }
}

/// A chart over time of the named columns.
pub(super) fn over_time(file: &str, caption: &str, y: Axis, lines: &[(&str, &str)]) -> Chart {
    Chart {
        file: file.into(),
        caption: caption.into(),
        x: Axis::time(),
        y,
        lines: owned(lines),
    }
}

fn owned(lines: &[(&str, &str)]) -> Vec<(String, String)> {
    let line = |(words, signal): &(&str, &str)| (words.to_string(), signal.to_string());
    lines.iter().map(line).collect()
}

/// Runs whose curves are laid over each other: the run, and the one that it is compared with.
pub(super) struct Tables<'a> {
    pub(super) own: &'a Columns,
    /// Its columns, and its name.
    pub(super) other: Option<(&'a Columns, String)>,
}

/// The signals of a run with those that the report adds.
pub(super) fn signals(run: &RunFiles) -> Columns {
    let mut signals = run.signals.clone();
    if let Some(x) = moving(&run.signals, "wheel_x_m") {
        let amplitude = x.iter().fold(0.0, |far: f64, x| far.max(x.abs()));
        let share = x.iter().map(|x| 100.0 * x.abs() / amplitude).collect();
        let began = x.iter().position(|x| *x != 0.0).unwrap_or(0);
        let rise = column(&run.signals, "wheel_y_m").map(|y| rise(y, began.saturating_sub(1)));
        let ratio = ["wheel_ft_n", "wheel_fn_n"].map(|name| column(&run.signals, name));
        let ratio = match ratio {
            [Some(tangential), Some(normal)] => Some(ratios(tangential, normal)),
            _ => None,
        };
        let over = |values: &[f64], r: f64| values.iter().map(|value| value / r).collect();
        if let Some((r, rise)) = run.mean_radius_m.zip(rise.as_ref()) {
            let added = [(X_OVER_R, over(x, r)), (RISE_OVER_R, over(rise, r))];
            signals.extend(added.map(|(name, values)| (name.into(), values)));
        }
        signals.insert(SHARE.into(), share);
        signals.extend(rise.map(|rise| (RISE.into(), rise)));
        signals.extend(ratio.map(|ratio| (FRICTION.into(), ratio)));
    }
    signals
}

/// |F_T|/F_N; 0 while the wheel bears less than a hundredth of its largest force.
fn ratios(tangential: &[f64], normal: &[f64]) -> Vec<f64> {
    let least = 0.01 * normal.iter().fold(0.0, |most: f64, n| most.max(n.abs()));
    let ratio = |(t, n): (&f64, &f64)| if n.abs() > least { (t / n).abs() } else { 0.0 };
    tangential.iter().zip(normal).map(ratio).collect()
}

/// Forces on the wheel, its motion, and friction.
pub(super) fn wheel() -> Vec<Chart> {
    let d = Axis::new("D (mm)", "wheel_x_m", 1e3);
    vec![
        over_time(
            "forces.svg",
            "Force on the wheel",
            Axis::y("force (N)", 1.0),
            &[("normal F_N", "wheel_fn_n"), ("tangential F_T", "wheel_ft_n")],
        ),
        over_time(
            "friction-coefficient.svg",
            "Ratio of the forces on the wheel",
            Axis::y("|F_T|/F_N", 1.0),
            &[("|F_T|/F_N", FRICTION)],
        ),
        Chart {
            file: "friction.svg".into(),
            caption: "Tangential force over the wheel's lateral position D: the loop's area is the work of a cycle".into(),
            x: d.clone(),
            y: Axis::y("F_T (N)", 1.0),
            lines: owned(&[("tangential force", "wheel_ft_n")]),
        },
        Chart {
            file: "wheel-path.svg".into(),
            caption: "Height of the wheel over its lateral position, from the start of the motion on".into(),
            x: d,
            y: Axis::y("rise (µm)", 1e6),
            lines: owned(&[("rise since the motion began", RISE)]),
        },
        over_time(
            "wheel-over-r.svg",
            "Place of the wheel over the mean radius r of the grains (Renouf, Saulot and Berthier 2006, figure 8)",
            Axis::y("over r", 1.0),
            &[("x/r", X_OVER_R), ("(y - y at the start)/r", RISE_OVER_R)],
        ),
    ]
}

/// Share of sliding nodes (Renouf, Saulot and Berthier 2006, figure 6).
pub(super) fn sliding() -> Chart {
    over_time(
        "sliding.svg",
        "Share of sliding nodes Sn over time, beside the position of the wheel",
        Axis::y("(%)", 1.0),
        &[("Sn", "sn_pct"), ("|D| over its amplitude", SHARE)],
    )
}

/// Heights (m) over the one at this place; those before it are left where they will begin.
fn rise(heights: &[f64], began: usize) -> Vec<f64> {
    let first = heights.get(began).copied().unwrap_or(0.0);
    let since = |(place, height): (usize, &f64)| {
        if place < began { 0.0 } else { height - first }
    };
    heights.iter().enumerate().map(since).collect()
}

/// The column of this name, or the first participant's or interface's.
pub(super) fn column<'a>(signals: &'a Columns, name: &str) -> Option<&'a [f64]> {
    let ending = format!(".{name}");
    let mut columns = signals.iter();
    let own = signals.get(name).map(Vec::as_slice);
    own.or_else(|| {
        let found = columns.find(|(key, _)| key.ends_with(&ending));
        found.map(|(_, values)| values.as_slice())
    })
}

/// The same, of a signal that is not zero throughout.
fn moving<'a>(signals: &'a Columns, name: &str) -> Option<&'a [f64]> {
    column(signals, name).filter(|values| values.iter().any(|value| *value != 0.0))
}

/// Draws a chart of the lines whose signals are there, that along x not being zero throughout; lines of nothing but zeros are left out.
pub(super) fn drawn(tables: &Tables, chart: &Chart) -> Option<Picture> {
    let mut curves = lines(tables.own, chart, 0);
    if curves.is_empty() {
        return None;
    }
    let alternative = ranges_in_words(&curves, chart);
    if let Some((other, name)) = &tables.other {
        let others = lines(other, chart, OTHERS).into_iter();
        curves.extend(others.map(|curve| Curve {
            label: format!("{}, {name}", curve.label),
            ..curve
        }));
    }
    let words = Labels {
        x: &chart.x.words,
        y: &chart.y.words,
        log_y: chart.y.log,
    };
    Some(Picture {
        file: chart.file.clone(),
        caption: chart.caption.clone(),
        alternative,
        svg: plot(words, &curves),
    })
}

/// First style of the lines of the other run.
const OTHERS: usize = 4;

/// The lines of a chart, in styles from this one on.
fn lines(signals: &Columns, chart: &Chart, styles: usize) -> Vec<Curve> {
    // The first line is what a chart is about; the others stand beside it.
    let first = chart.lines.first();
    let first = first.and_then(|(_, signal)| column(signals, signal));
    let (Some(x), Some(_)) = (moving(signals, &chart.x.signal), first) else {
        return Vec::new();
    };
    let found = chart.lines.iter().enumerate();
    let found = found.filter_map(|(place, (label, signal))| {
        Some(Curve {
            label: label.clone(),
            points: joined(x, column(signals, signal)?, chart),
            style: styles + place,
        })
    });
    let flat = |curve: &Curve| curve.points.iter().all(|(_, y)| *y == 0.0);
    found.filter(|curve| !flat(curve)).collect()
}

/// Points of two columns in the units of the axes.
fn joined(x: &[f64], y: &[f64], chart: &Chart) -> Vec<(f64, f64)> {
    let height = |y: &f64| {
        if chart.y.log {
            // What is 0 has no place on the axis, and is left out.
            (y.abs() * chart.y.factor).log10()
        } else {
            y * chart.y.factor
        }
    };
    let points = x.iter().zip(y);
    points
        .map(|(x, y)| (x * chart.x.factor, height(y)))
        .collect()
}

/// The extent of each line, for one who does not see them.
fn ranges_in_words(curves: &[Curve], chart: &Chart) -> String {
    let each = curves.iter().map(|curve| {
        let heights = curve
            .points
            .iter()
            .map(|(_, y)| *y)
            .filter(|y| y.is_finite());
        let (low, high) = heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), y| {
            (low.min(y), high.max(y))
        });
        let [low, high] = [low, high].map(|y| if chart.y.log { 10f64.powf(y) } else { y });
        format!("{} from {low:.4e} to {high:.4e}", curve.label)
    });
    let each: Vec<String> = each.collect();
    format!(
        "Curves over {}; {}: {}.",
        chart.x.words,
        chart.y.words,
        each.join("; ")
    )
}

/// Pressure and shear on the surface at the sampled moment.
pub(super) fn traction(run: &RunFiles, other: Option<(&RunFiles, String)>) -> Option<Picture> {
    let profile = &run.profile;
    let (Some(x), Some(pressure)) = (profile.get("x_m"), profile.get("pressure_pa")) else {
        return None;
    };
    let low = x.iter().copied().fold(f64::INFINITY, f64::min);
    let high = x.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let width = MEAN_SHARE * (high - low);
    let mean = format!("pressure, mean over {:.2} mm", 1e3 * width);
    let points = |x: &[f64], y: &[f64]| -> Vec<(f64, f64)> {
        x.iter().zip(y).map(|(x, y)| (1e3 * x, 1e-6 * y)).collect()
    };
    let mut curves = vec![
        Curve {
            label: "pressure at the nodes".into(),
            points: points(x, pressure),
            style: BACKGROUND,
        },
        Curve {
            label: mean,
            points: points(x, &moving_mean(x, pressure, width)),
            style: 0,
        },
    ];
    if let Some(shear) = profile.get("shear_pa") {
        let points = points(x, &moving_mean(x, shear, width));
        curves.push(Curve {
            label: "shear, the same".into(),
            points,
            style: 1,
        });
    }
    if let Some((other, name)) = &other
        && let (Some(x), Some(pressure)) =
            (other.profile.get("x_m"), other.profile.get("pressure_pa"))
    {
        let points = points(x, &moving_mean(x, pressure, width));
        curves.push(Curve {
            label: format!("pressure, mean, {name}"),
            points,
            style: OTHERS,
        });
    }
    let labels = Labels {
        x: "x (mm)",
        y: "traction on the surface (MPa)",
        log_y: false,
    };
    let largest = pressure.iter().copied().fold(0.0, f64::max);
    Some(Picture {
        file: "profile.svg".into(),
        caption: "Traction on the surface at the end of the hold".into(),
        alternative: format!(
            "Pressure and shear over x at {} nodes; largest pressure {}.",
            x.len(),
            with_unit(largest, "Pa")
        ),
        svg: plot(labels, &curves),
    })
}

/// Share of sliding nodes over the wheel's lateral velocity, while it moves (Renouf, Saulot and Berthier 2006, figure 7).
pub(super) fn sliding_over_velocity(signals: &Columns) -> Option<Picture> {
    let velocity = moving(signals, "wheel_vx_m_per_s");
    let (Some(velocity), Some(sn)) = (velocity, column(signals, "sn_pct")) else {
        return None;
    };
    let moving = velocity.iter().zip(sn).filter(|(v, _)| **v != 0.0);
    let points: Vec<(f64, f64)> = moving.map(|(v, sn)| (1e3 * v, *sn)).collect();
    let labels = Labels {
        x: "wheel velocity (mm/s)",
        y: "Sn (%)",
        log_y: false,
    };
    Some(Picture {
        file: "sliding-velocity.svg".into(),
        caption: "Share of sliding nodes Sn over the velocity of the wheel, a dot a window".into(),
        alternative: format!("Cloud of {} dots.", points.len()),
        svg: cloud(labels, &points),
    })
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
