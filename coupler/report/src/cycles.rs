//! Cycle by cycle of the wheel's motion: friction loops, and what each of them took off, ejected and wore.

use super::curves::{Chart, D, OTHERS, Tables, YAxis, column, moving, over_time, ranges};
use draw::picture::Picture;
use draw::plot::{BACKGROUND, Labels, PlotCurve, plot};
use runs::files::RunFiles;
use runs::table::Table;

/// Part of a period by which the reports may end before a cycle does.
const ROUNDING: f64 = 1e-6;
/// Style of a cycle that the end cut.
const CUT: usize = 9;

/// Tangential force over the position of the wheel while it moves: the last full cycle before the paler ones beside it.
pub(super) fn loops(run: &RunFiles, tables: &Tables, other: Option<&RunFiles>) -> Option<Picture> {
    let mut curves = Motion::of(run, &tables.own)?.curves();
    let alternative = format!(
        "Curves over {}, F_T (N): {}.",
        D.0,
        ranges(&curves, |(_, force)| *force)
    );
    if let (Some(other), Some((signals, name))) = (other, &tables.other)
        && let Some(motion) = Motion::of(other, signals)
    {
        let last = motion.curves().pop();
        curves.extend(last.map(|curve| PlotCurve {
            label: format!("{}, {name}", curve.label),
            style: OTHERS,
            ..curve
        }));
    }
    let labels = Labels {
        x: D.0,
        y: "F_T (N)",
        log_y: false,
    };
    Some(Picture {
        file: "friction.svg".into(),
        caption: "Tangential force over the wheel's lateral position D: the area of a loop is the work of its cycle".into(),
        alternative,
        svg: plot(labels, &curves),
    })
}

/// The moving wheel.
struct Motion {
    /// D (mm) and F_T (N) at each report of the motion.
    points: Vec<(f64, f64)>,
    /// The report with which each full cycle begins, and the one with which the last of them ends.
    starts: Vec<usize>,
}

impl Motion {
    fn of(run: &RunFiles, signals: &Table) -> Option<Motion> {
        let (x, force) = (moving(signals, D.1)?, column(signals, "wheel_ft_n")?);
        let t = signals.get("t_s")?;
        // The last report before the wheel moves is the start of its first loop.
        let began = x.iter().position(|x| *x != 0.0)?.saturating_sub(1);
        let mut phases = run.list("phases").filter(|p| p["name"] == "cycling");
        let start = phases.next().and_then(|phase| phase["t0_s"].as_f64());
        let cycles = start.zip(run.scenario().wheel_hz);
        let starts = cycles.map_or(Vec::new(), |(start, hz)| {
            let done = hz * (t[t.len() - 1] - start);
            let ends = (0..=(done + ROUNDING) as usize).map(|k| {
                let time = start + (k as f64 - ROUNDING) / hz;
                t.partition_point(|t| *t < time).min(t.len() - 1)
            });
            ends.map(|row| row.max(began) - began).collect()
        });
        let points = x.iter().zip(force).skip(began);
        Some(Motion {
            points: points.map(|(x, f)| (D.2 * x, *f)).collect(),
            starts,
        })
    }

    /// The cycles before the last full one, what the end cut, and the last full one; one curve of all without a full cycle.
    fn curves(&self) -> Vec<PlotCurve> {
        let end = self.points.len() - 1;
        let curve = |label: String, style: usize, [from, to]: [usize; 2]| PlotCurve {
            label,
            points: self.points[from..=to].to_vec(),
            style,
        };
        let [.., before, last] = self.starts[..] else {
            return vec![curve("tangential force".into(), 0, [0, end])];
        };
        let full = self.starts.len() - 1;
        let mut curves = Vec::new();
        if full > 1 {
            let label = match full {
                2 => "cycle 1".into(),
                _ => format!("cycles 1 to {}", full - 1),
            };
            curves.push(curve(label, BACKGROUND, [self.starts[0], before]));
        }
        if last < end {
            let label = format!("after cycle {full}, cut by the end");
            curves.push(curve(label, CUT, [last, end]));
        }
        curves.push(curve(format!("cycle {full}"), 0, [before, last]));
        curves
    }
}

/// The full cycles of a run as its participant wrote them; empty without any.
fn written(run: &RunFiles) -> Table {
    let files = run.field_files("-cycles.csv");
    let table = files.first().map(|file| Table::read_whole_rows(file));
    table.unwrap_or_default()
}

/// The mean |F_T|/F_N of the cycle at hand at each report; NaN outside of the full cycles.
pub(super) fn friction(run: &RunFiles) -> Option<Vec<f64>> {
    let cycles = written(run);
    let [starts, ends, means] =
        ["t0_s", "t1_s", "friction_coefficient"].map(|name| cycles.get(name));
    let (starts, ends, means) = (starts?, ends?, means?);
    let mean = |t: &f64| {
        let cycle = ends.partition_point(|end| end < t);
        let found = means.get(cycle).filter(|_| starts[cycle] <= *t);
        found.copied().unwrap_or(f64::NAN)
    };
    Some(run.signals.get("t_s")?.iter().map(mean).collect())
}

/// The cycles as steps over time: each number at the start and at the end of its cycle. Empty without two of them.
pub(super) fn tables(run: &RunFiles, other: Option<(&RunFiles, String)>) -> Tables {
    let steps = |run: &RunFiles| {
        let mut cycles = written(run);
        let [Some(starts), Some(ends)] = ["t0_s", "t1_s"].map(|name| cycles.get(name)) else {
            return Table::default();
        };
        if starts.len() < 2 {
            return Table::default();
        }
        let times = starts
            .iter()
            .zip(ends)
            .flat_map(|(start, end)| [*start, *end])
            .collect();
        for (_, numbers) in &mut cycles.columns {
            *numbers = numbers.iter().flat_map(|x| [*x; 2]).collect();
        }
        cycles.add("t_s", times);
        cycles
    };
    Tables {
        own: steps(run),
        other: other.map(|(other, name)| (steps(other), name)),
    }
}

/// What each cycle did to the wheel.
pub(super) fn wheel() -> [Chart; 2] {
    [
        over_time(
            "cycle-sink.svg",
            "Height that the wheel lost in each full cycle",
            YAxis::Linear("sink (µm)", 1e6),
            &[("sink", "sink_m")],
        ),
        over_time(
            "cycle-tangential.svg",
            "Tangential force where the wheel passes D = 0, mean of the two times in each full cycle",
            YAxis::Linear("|F_T| at D = 0 (N)", 1.0),
            &[("|F_T| at D = 0", "tangential_at_zero_n")],
        ),
    ]
}

/// What each cycle did to the third body.
pub(super) fn flows() -> Chart {
    over_time(
        "cycle-flows.svg",
        "Flows of third body in each full cycle, real masses",
        YAxis::Linear("mass a cycle (µg)", 1e9),
        &[
            ("Qs, detached", "source_kg"),
            ("ejected", "ejected_kg"),
            ("Qw, worn", "wear_kg"),
        ],
    )
}

#[cfg(test)]
mod tests {
    use super::super::curves::{plots, signals, wheel as wheel_charts};
    use super::*;
    use kit::scratch::Scratch;
    use serde_json::json;

    /// A wheel of 1 Hz that moves from 1 s on, eight reports a second, as long as told (s), with these cycles in its table.
    fn run(scratch: &Scratch, until: f64, table: &str) -> RunFiles {
        let fields = scratch.path().join("fields");
        std::fs::create_dir_all(&fields).expect("a folder");
        std::fs::write(fields.join("layer-cycles.csv"), table).expect("a file");
        let scenario = "[[participant]]\nname = \"layer\"\nconfig.wheel = { frequency_hz = 1.0 }\n";
        std::fs::write(scratch.path().join("scenario.toml"), scenario).expect("a file");
        let mut text = "t_s,wheel_x_m,wheel_ft_n,wheel_fn_n\n".to_string();
        for row in 1..=(8.0 * until) as u32 {
            let t = f64::from(row) / 8.0;
            let x = 1e-3 * (std::f64::consts::TAU * (t - 1.0).max(0.0)).sin();
            text += &format!("{t:e},{x:e},{row},10\n");
        }
        RunFiles {
            path: scratch.path().into(),
            summary: json!({"phases": [{"name": "hold", "t0_s": 0.0}, {"name": "cycling", "t0_s": 1.0}]}),
            signals: Table::parse(&text).expect("it is a table"),
            profile: None,
        }
    }

    const TWO: &str = "cycle,t0_s,t1_s,sink_m,tangential_at_zero_n,friction_coefficient,source_kg,ejected_kg,wear_kg\n\
                       1,1,2,3e-6,20,0.25,2e-9,1e-9,0\n2,2,3,1e-6,30,0.5,4e-9,3e-9,0\n";
    const ONE: &str = "cycle,t0_s,t1_s,friction_coefficient\n1,1,2,0.25\n";

    /// Label and first and last force (N) of each curve; the force counts the reports.
    fn loops_of(run: &RunFiles) -> Vec<(String, f64, f64)> {
        let curves = Motion::of(run, &run.signals).expect("it moves").curves();
        let ends = |curve: PlotCurve| {
            let points = curve.points;
            (curve.label, points[0].1, points[points.len() - 1].1)
        };
        curves.into_iter().map(ends).collect()
    }

    #[test]
    fn the_last_full_cycle_stands_before_those_beside_it() {
        let scratch = Scratch::new("loops", 1);
        let expected = |all: &[(&str, f64, f64)]| {
            let all = all
                .iter()
                .map(|(words, from, to)| (words.to_string(), *from, *to));
            Vec::from_iter(all)
        };
        let found = |until: f64| loops_of(&run(&scratch, until, ""));
        let cut = [
            ("cycles 1 to 2", 8.0, 24.0),
            ("after cycle 3, cut by the end", 32.0, 34.0),
            ("cycle 3", 24.0, 32.0),
        ];
        assert_eq!(found(4.25), expected(&cut));
        assert_eq!(
            found(3.0),
            expected(&[("cycle 1", 8.0, 16.0), ("cycle 2", 16.0, 24.0)])
        );
        assert_eq!(found(2.0), expected(&[("cycle 1", 8.0, 16.0)]));
        assert_eq!(found(1.5), expected(&[("tangential force", 8.0, 12.0)]));
        // A program of its own moves the wheel, and nobody knows how.
        let run = run(&scratch, 4.25, "");
        std::fs::remove_file(scratch.path().join("scenario.toml")).expect("it is there");
        assert_eq!(loops_of(&run), expected(&[("tangential force", 8.0, 34.0)]));
    }

    #[test]
    fn numbers_of_cycles_are_steps_over_their_times() {
        let scratch = Scratch::new("cycle-steps", 1);
        let tables_of = |table: &str| tables(&run(&scratch, 3.5, table), None);
        let two = tables_of(TWO);
        assert_eq!(two.own.get("t_s"), Some([1.0, 2.0, 2.0, 3.0].as_slice()));
        assert_eq!(
            two.own.get("sink_m"),
            Some([3e-6, 3e-6, 1e-6, 1e-6].as_slice())
        );
        let [flows] = &plots(&two, &[flows()])[..] else {
            panic!("there is one picture");
        };
        assert_eq!(
            flows.alternative,
            "Curves over t (ms); mass a cycle (µg): Qs, detached from 2.0000e0 to 4.0000e0; ejected from 1.0000e0 to 3.0000e0."
        );
        assert_eq!(plots(&two, &wheel()).len(), 2);
        for table in [ONE, ""] {
            let few = tables_of(table);
            assert!(plots(&few, &wheel()).is_empty() && plots(&few, &[super::flows()]).is_empty());
        }
    }

    #[test]
    fn the_ratio_of_the_forces_has_the_mean_of_each_cycle() {
        let scratch = Scratch::new("cycle-mean", 1);
        let with = run(&scratch, 3.5, TWO);
        let means = friction(&with).expect("there are cycles");
        assert!(
            means[..7]
                .iter()
                .chain(&means[24..])
                .all(|mean| mean.is_nan()),
            "{means:?}"
        );
        assert_eq!(
            [means[8], means[15], means[16], means[23]],
            [0.25, 0.25, 0.5, 0.5]
        );
        let words = |run: &RunFiles| {
            let own = signals(run).expect("it is readable");
            let pictures = plots(&Tables { own, other: None }, &wheel_charts());
            let found = pictures
                .into_iter()
                .find(|picture| picture.file == "friction-coefficient.svg");
            found.expect("it is drawn").alternative
        };
        assert!(words(&with).contains("mean of each full cycle from 2.5000e-1 to 5.0000e-1"));
        assert!(!words(&run(&scratch, 3.5, "")).contains("mean of each"));
    }
}
