//! Curves of the tables of a run: loads and motion, friction, sliding nodes, traction, interface, energies, flows.

use std::borrow::Cow;

use super::cycles;
use super::line_contact::{LineContact, friction};
use draw::axis::range;
use draw::picture::Picture;
use draw::plot::{BACKGROUND, BESIDE, PlotCurve, cloud, plot};
use draw::units::with_unit;
use runs::files::RunFiles;
use runs::table::Table;
use scenario::error::Error;

/// Width of the moving mean of the pressure: this share of the profile's length, and at most [`MEAN_SHARE_PRESSED`] of the part whose
/// pressure exceeds [`PRESSED`] times the largest.
const MEAN_SHARE: f64 = 0.05;
const MEAN_SHARE_PRESSED: f64 = 0.1;
pub(super) const PRESSED: f64 = 0.01;

/// Columns that the report adds to signals.csv: |D| over its amplitude (%), rise of the wheel since its motion began (m), |F_T|/F_N.
const SHARE: &str = "share_of_amplitude_pct";
const RISE: &str = "wheel_rise_m";
const FRICTION: &str = "force_ratio";
/// Position of the wheel and its rise over the mean radius of the grains.
const X_OVER_R: &str = "wheel_x_over_r";
const RISE_OVER_R: &str = "wheel_rise_over_r";

/// Signals drawn over another signal.
pub(super) struct Chart {
    pub(super) file: String,
    pub(super) caption: String,
    pub(super) x: XAxis,
    pub(super) y: YAxis,
    /// Words of the legend and signal of each line.
    pub(super) lines: Vec<(String, String)>,
    /// Styles of the first lines, in a chart that deviates from the usual styles.
    pub(super) styles: &'static [usize],
}

/// Words along x, the signal there, and the factor from SI to the unit of the words.
pub(super) type XAxis = (&'static str, Cow<'static, str>, f64);

const TIME: XAxis = ("t (ms)", Cow::Borrowed("t_s"), 1e3);
const D: XAxis = ("D (mm)", Cow::Borrowed("wheel_x_m"), 1e3);

/// The axis upwards.
#[derive(Clone, Copy)]
pub(super) enum YAxis {
    /// Words along the axis, and the factor from SI to their unit.
    Linear(&'static str, f64),
    /// Words along a logarithmic axis.
    Log(&'static str),
}

impl YAxis {
    fn words(&self) -> &'static str {
        let (YAxis::Linear(words, _) | YAxis::Log(words)) = self;
        words
    }

    /// A number in the unit of the axis.
    fn height(&self, y: f64) -> f64 {
        match self {
            YAxis::Linear(_, factor) => y * factor,
            YAxis::Log(_) => y.abs(),
        }
    }
}

/// A chart over time of the named columns.
pub(super) fn over_time(file: &str, caption: &str, y: YAxis, lines: &[(&str, &str)]) -> Chart {
    let line = |(words, signal): &(&str, &str)| (words.to_string(), signal.to_string());
    of_found(file, caption, y, lines.iter().map(line).collect())
}

/// A chart over time of columns that were found in a run.
pub(super) fn of_found(file: &str, caption: &str, y: YAxis, lines: Vec<(String, String)>) -> Chart {
    Chart {
        file: file.into(),
        caption: caption.into(),
        x: TIME,
        y,
        lines,
        styles: &[],
    }
}

/// The signals of a run, and of the runs that overlay it, with their names in legends.
pub(super) struct Tables {
    pub(super) own: Table,
    pub(super) others: Vec<(Table, String)>,
}

impl Tables {
    /// The signals of a single run.
    pub(super) fn of(own: Table) -> Tables {
        let others = Vec::new();
        Tables { own, others }
    }
}

/// The signals of a run, with the columns that the report adds.
///
/// # Errors
/// The fields of the grains cannot be read.
pub(super) fn signals(run: &RunFiles) -> Result<Table, Error> {
    let mut signals = run.signals.clone();
    let Some(x) = moving(&run.signals, &D.1) else {
        return Ok(signals);
    };
    let over = |values: &[f64], whole: f64| values.iter().map(|x| x / whole).collect::<Vec<f64>>();
    let began = x.iter().position(|x| *x != 0.0).unwrap_or(0);
    let rise = column(&run.signals, "wheel_y_m").map(|y| rise(y, began.saturating_sub(1)));
    if let Some((r, rise)) = run.mean_radius_m()?.zip(rise.as_ref()) {
        signals.add(X_OVER_R, over(x, r));
        signals.add(RISE_OVER_R, over(rise, r));
    }
    let amplitude = x.iter().fold(0.0, |far: f64, x| far.max(x.abs()));
    let share = x.iter().map(|x| 100.0 * x.abs() / amplitude);
    signals.add(SHARE, share.collect());
    if let Some(rise) = rise {
        signals.add(RISE, rise);
    }
    let forces = ["wheel_ft_n", "wheel_fn_n"].map(|name| column(&run.signals, name));
    if let [Some(tangential), Some(normal)] = forces {
        signals.add(FRICTION, ratios(tangential, normal));
    }
    let wheel = ["t_s", "wheel_x_m", "wheel_ft_n"];
    let wheel = wheel.map(|name| column(&signals, name).map(Vec::from));
    if let [Some(t), Some(x), Some(force)] = wheel {
        cycles::add(run, &mut signals, [&t, &x, &force]);
    }
    Ok(signals)
}

/// |F_T|/F_N; 0 while the wheel bears less than a hundredth of its largest force.
fn ratios(tangential: &[f64], normal: &[f64]) -> Vec<f64> {
    let least = 0.01 * normal.iter().fold(0.0, |most: f64, n| most.max(n.abs()));
    let ratio = |(t, n): (&f64, &f64)| if n.abs() > least { (t / n).abs() } else { 0.0 };
    tangential.iter().zip(normal).map(ratio).collect()
}

/// Forces on the wheel, its motion, and friction.
pub(super) fn wheel() -> Vec<Chart> {
    vec![
        over_time(
            "forces.svg",
            "Force on the wheel",
            YAxis::Linear("force (N)", 1.0),
            &[
                ("normal F_N", "wheel_fn_n"),
                ("tangential F_T", "wheel_ft_n"),
            ],
        ),
        over_time(
            "friction-coefficient.svg",
            "Ratio of the forces on the wheel",
            YAxis::Linear("|F_T|/F_N", 1.0),
            &[
                ("|F_T|/F_N", FRICTION),
                ("mean of each full cycle", cycles::MEAN),
            ],
        ),
        Chart {
            x: D,
            styles: &[BACKGROUND, 0],
            ..over_time(
                "friction.svg",
                "Tangential force over the wheel's lateral position D: the area of a loop is the work of its cycle",
                YAxis::Linear("F_T (N)", 1.0),
                &[
                    ("tangential force", cycles::OTHERS),
                    ("in the last full cycle", cycles::LAST),
                ],
            )
        },
        Chart {
            x: D,
            ..over_time(
                "wheel-path.svg",
                "Height of the wheel over its lateral position, since the start of the motion",
                YAxis::Linear("rise (µm)", 1e6),
                &[("rise since the motion began", RISE)],
            )
        },
        over_time(
            "wheel-over-r.svg",
            "Position of the wheel over the mean radius r of the grains (Renouf, Saulot and Berthier 2006, figure 8)",
            YAxis::Linear("over r", 1.0),
            &[("x/r", X_OVER_R), ("(y - y at the start)/r", RISE_OVER_R)],
        ),
    ]
}

/// Share of sliding nodes (Renouf, Saulot and Berthier 2006, figure 6).
pub(super) fn sliding() -> Chart {
    over_time(
        "sliding.svg",
        "Share of sliding nodes Sn over time, and the position of the wheel",
        YAxis::Linear("(%)", 1.0),
        &[("Sn", "sn_pct"), ("|D| over its amplitude", SHARE)],
    )
}

/// Heights above the height in row `began` (m); 0 in the rows before.
fn rise(heights: &[f64], began: usize) -> Vec<f64> {
    let first = heights.get(began).copied().unwrap_or(0.0);
    let since = |(row, height): (usize, &f64)| if row < began { 0.0 } else { height - first };
    heights.iter().enumerate().map(since).collect()
}

/// The flows of third body of each cycle.
pub(super) fn cycle_flows(run: &RunFiles) -> Vec<Picture> {
    let own = cycles::steps(cycles::written(run));
    let chart = over_time(
        "cycle-flows.svg",
        "Flows of third body in each full cycle, real masses",
        YAxis::Linear("mass per cycle (µg)", 1e9),
        &[
            ("Qs, detached", "source_kg"),
            ("ejected", "ejected_kg"),
            ("Qw, worn", "wear_kg"),
        ],
    );
    plots(&Tables::of(own), &[chart])
}

/// The column of this name, or else of the first participant or interface that has it.
pub(super) fn column<'a>(signals: &'a Table, name: &str) -> Option<&'a [f64]> {
    let ending = format!(".{name}");
    let found = || Some(signals.chosen(|key| key.ends_with(&ending)).first()?.1);
    signals.get(name).or_else(found)
}

/// The same column, if it has a finite number other than zero.
fn moving<'a>(signals: &'a Table, name: &str) -> Option<&'a [f64]> {
    column(signals, name).filter(|values| values.iter().any(|x| *x != 0.0 && x.is_finite()))
}

/// The charts whose signals the run has. The signal along x must not be zero throughout; lines that are zero throughout are left out.
pub(super) fn plots(tables: &Tables, charts: &[Chart]) -> Vec<Picture> {
    let charts = charts.iter();
    charts.filter_map(|chart| drawn(tables, chart)).collect()
}

fn drawn(tables: &Tables, chart: &Chart) -> Option<Picture> {
    let mut curves = lines(&tables.own, chart, 0);
    if curves.is_empty() {
        return None;
    }
    let alternative = ranges_in_words(&curves, chart);
    for (other, name) in &tables.others {
        let others = lines(other, chart, BESIDE).into_iter();
        curves.extend(others.map(|curve| PlotCurve {
            label: beside(&curve.label, name),
            ..curve
        }));
    }
    let is_log = matches!(chart.y, YAxis::Log(_));
    Some(Picture {
        file: chart.file.clone(),
        caption: chart.caption.clone(),
        alternative,
        svg: plot([chart.x.0, chart.y.words()], is_log, &curves),
    })
}

/// The legend of a line of another run; empty if another line's legend covers it.
fn beside(label: &str, name: &str) -> String {
    match name {
        "" => String::new(),
        name => format!("{label}, {name}"),
    }
}

/// The lines of a chart that have at least two points, in styles from `styles` on.
fn lines(signals: &Table, chart: &Chart, styles: usize) -> Vec<PlotCurve> {
    // A chart needs its first line; the others are optional.
    let first = chart.lines.first();
    let first = first.and_then(|(_, signal)| column(signals, signal));
    let (Some(x), Some(_)) = (moving(signals, &chart.x.1), first) else {
        return Vec::new();
    };
    let curves = chart.lines.iter().enumerate();
    let curves = curves.filter_map(|(k, (label, signal))| {
        let points = x.iter().zip(moving(signals, signal)?);
        let point = |(x, y): (&f64, &f64)| (x * chart.x.2, chart.y.height(*y));
        Some(PlotCurve {
            label: label.clone(),
            points: points.map(point).collect(),
            style: styles + chart.styles.get(k).unwrap_or(&k),
        })
    });
    let is_line = |of: &PlotCurve| {
        let finite = of.points.iter().filter(|(_, y)| y.is_finite());
        finite.count() > 1
    };
    let mut curves: Vec<PlotCurve> = curves.filter(is_line).collect();
    if let [only] = &mut curves[..] {
        only.style = styles;
    }
    curves
}

/// The extent of each line, for a reader who cannot see the chart.
fn ranges_in_words(curves: &[PlotCurve], chart: &Chart) -> String {
    let is_linear = matches!(chart.y, YAxis::Linear(..));
    let each = curves.iter().map(|curve| {
        let heights = curve.points.iter().map(|(_, y)| *y);
        let drawn = range(heights.filter(|y| is_linear || *y > 0.0));
        let [low, high] = drawn.unwrap_or([f64::INFINITY, f64::NEG_INFINITY]);
        format!("{} from {low:.4e} to {high:.4e}", curve.label)
    });
    let each = Vec::from_iter(each).join("; ");
    format!("Curves over {}; {}: {each}.", chart.x.0, chart.y.words())
}

/// Pressure and shear on the surface at the sampled moment.
pub(super) fn traction(run: &RunFiles, others: &[(&RunFiles, String)]) -> Option<Picture> {
    let of = |run: &RunFiles, name: &str| Some(run.profile.as_ref()?.get(name)?.to_vec());
    let (x, pressure) = (of(run, "x_m")?, of(run, "pressure_pa")?);
    let [low, high] = range(x.iter().copied())?;
    let largest = pressure.iter().copied().fold(0.0, f64::max);
    let nodes = x.iter().zip(&pressure);
    let pressed = nodes.filter(|(_, p)| **p > PRESSED * largest);
    let [left, right] = range(pressed.map(|(x, _)| *x)).unwrap_or([low, high]);
    let width = (MEAN_SHARE * (high - low)).min(MEAN_SHARE_PRESSED * (right - left));
    // The pressed part, and its width on either side.
    let near = 2.0 * left - right..=2.0 * right - left;
    let curve = |label: String, style: usize, x: &[f64], y: &[f64]| PlotCurve {
        label,
        points: (x.iter().zip(y))
            .filter(|(x, _)| x.is_nan() || near.contains(x))
            .map(|(x, y)| (1e3 * x, 1e-6 * y))
            .collect(),
        style,
    };
    let mean = |label: String, style: usize, x: &[f64], y: &[f64]| {
        curve(label, style, x, &moving_mean(x, y, width))
    };
    let smooth = format!("pressure, mean over {:.2} mm", 1e3 * width);
    let mut curves = vec![
        curve("pressure at the nodes".into(), BACKGROUND, &x, &pressure),
        mean(smooth, 0, &x, &pressure),
    ];
    if let Some(shear) = of(run, "shear_pa") {
        curves.push(mean("shear, the same".into(), 1, &x, &shear));
    }
    for (other, name) in others {
        if let (Some(x), Some(pressure)) = (of(other, "x_m"), of(other, "pressure_pa")) {
            let label = beside("pressure, mean", name);
            curves.push(mean(label, BESIDE, &x, &pressure));
        }
    }
    if let Some(contact) = LineContact::of(run) {
        let (x, y) = contact.hertz();
        curves.push(curve(contact.words(), 4, &x, &y));
    }
    if let Some(friction) = friction(run) {
        // Curves of both signs, with a gap between them.
        let smooth = moving_mean(&x, &pressure, width);
        let limit = |sign: f64| smooth.iter().map(move |p| sign * friction * p);
        let y: Vec<f64> = limit(1.0).chain([f64::NAN]).chain(limit(-1.0)).collect();
        let twice = [&x[..], &[f64::NAN], &x].concat();
        let label = format!("limit of friction, {friction} p");
        curves.push(curve(label, 5, &twice, &y));
    }
    let words = ["x (mm)", "traction on the surface (MPa)"];
    let (nodes, most) = (x.len(), with_unit(largest, "Pa"));
    Some(Picture {
        file: "profile.svg".into(),
        caption: "Traction on the surface at the end of the hold".into(),
        alternative: format!(
            "Pressure and shear over x at {nodes} nodes; largest pressure {most}."
        ),
        svg: plot(words, false, &curves),
    })
}

/// Share of sliding nodes over the wheel's lateral velocity, while it moves (Renouf, Saulot and Berthier 2006, figure 7).
pub(super) fn sliding_over_velocity(signals: &Table) -> Option<Picture> {
    let velocity = moving(signals, "wheel_vx_m_per_s")?.iter();
    let moving = velocity.zip(column(signals, "sn_pct")?);
    let moving = moving.filter(|(v, _)| **v != 0.0);
    let points: Vec<(f64, f64)> = moving.map(|(v, sn)| (1e3 * v, *sn)).collect();
    (points.len() > 1).then(|| Picture {
        file: "sliding-velocity.svg".into(),
        caption: "Share of sliding nodes Sn over the velocity of the wheel, one dot per window"
            .into(),
        alternative: format!("Cloud of {} dots.", points.len()),
        svg: cloud(["wheel velocity (mm/s)", "Sn (%)"], &points),
    })
}

/// Mean of the values within half of `width` of each position.
fn moving_mean(x: &[f64], y: &[f64], width: f64) -> Vec<f64> {
    let reach = 0.5 * width * (1.0 + 1e-9);
    let mean = |centre: &f64| {
        let near = x.iter();
        let near = near.zip(y).filter(|(x, _)| (**x - centre).abs() <= reach);
        let (sum, count) = near.fold((0.0, 0.0), |(sum, count), (_, y)| (sum + y, count + 1.0));
        sum / count
    };
    x.iter().map(mean).collect()
}
