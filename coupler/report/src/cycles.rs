//! The wheel's motion cycle by cycle: friction loops, and the masses detached, ejected and worn in each.

use runs::files::RunFiles;
use runs::table::Table;

/// Columns added to the signals: mean |F_T|/F_N of the current full cycle; F_T in the last full cycle, and at other times of the motion.
pub(super) const MEAN: &str = "force_ratio_of_cycle";
pub(super) const LAST: &str = "wheel_ft_of_last_cycle";
pub(super) const OTHERS: &str = "wheel_ft_of_other_cycles";

/// Part of a period by which the reports may end before a cycle does.
const ROUNDING: f64 = 1e-6;

/// Adds the columns, which are NaN where they do not apply, to signals with these times, positions and forces F_T of the wheel.
pub(super) fn add(run: &RunFiles, signals: &mut Table, [t, x, force]: [&[f64]; 3]) {
    let end = t.len() - 1;
    // The last report before the wheel moves is the start of its first loop.
    let began = x.iter().position(|x| *x != 0.0);
    let began = began.unwrap_or(0).saturating_sub(1);
    let last = last_cycle(run, t);
    let is_last = |row: usize| last.is_some_and(|[from, to]| (from..=to).contains(&row));
    let is_other = |row: usize| match last {
        Some([from, to]) => from > began && row <= from || to < end && row >= to,
        None => true,
    };
    let among = |rows: &dyn Fn(usize) -> bool| {
        let chosen = |row: usize| row >= began && rows(row);
        let values = (0..force.len()).map(|row| number_or_gap(force, row, chosen(row)));
        Vec::from_iter(values)
    };
    signals.add(LAST, among(&is_last));
    signals.add(OTHERS, among(&is_other));
    signals.add(MEAN, means(&written(run), t));
}

/// The number of a row; NaN, a gap of a curve, if the row is not chosen.
pub(super) fn number_or_gap(numbers: &[f64], row: usize, chosen: bool) -> f64 {
    if chosen { numbers[row] } else { f64::NAN }
}

/// The reports with which the last full cycle begins and ends.
fn last_cycle(run: &RunFiles, t: &[f64]) -> Option<[usize; 2]> {
    let mut phases = run.list("phases");
    let cycling = phases.find(|phase| phase["name"] == "cycling")?;
    let (start, hz) = (cycling["t0_s"].as_f64()?, run.scenario().wheel_hz?);
    let full = (hz * (t.last()? - start) + ROUNDING).floor();
    let report = |cycle: f64| t.partition_point(|t| hz * (t - start) < cycle - ROUNDING);
    (full >= 1.0).then(|| [full - 1.0, full].map(|cycle| report(cycle).min(t.len() - 1)))
}

/// The full cycles of a run as its participant wrote them; empty without any.
pub(super) fn written(run: &RunFiles) -> Table {
    let files = run.field_files("-cycles.csv");
    let table = files.first().map(|file| Table::read_whole_rows(file));
    table.unwrap_or_default()
}

/// The mean |F_T|/F_N of the current cycle at these times.
fn means(cycles: &Table, t: &[f64]) -> Vec<f64> {
    let [starts, ends, means] =
        ["t0_s", "t1_s", "traction_ratio"].map(|name| cycles.get(name).unwrap_or_default());
    let mean = |t: &f64| {
        let cycle = ends.partition_point(|end| end < t);
        let found = means.get(cycle).filter(|_| starts[cycle] <= *t);
        found.copied().unwrap_or(f64::NAN)
    };
    t.iter().map(mean).collect()
}

/// The cycles as steps over time: each number at the start and at the end of its cycle. Empty with fewer than two cycles.
pub(super) fn steps(mut cycles: Table) -> Table {
    let [starts, ends] = ["t0_s", "t1_s"].map(|name| cycles.get(name).unwrap_or_default());
    let pairs = starts.iter().zip(ends);
    let times: Vec<f64> = pairs.flat_map(|(start, end)| [*start, *end]).collect();
    if times.len() < 4 {
        return Table::default();
    }
    for (_, numbers) in &mut cycles.columns {
        *numbers = numbers.iter().flat_map(|x| [*x; 2]).collect();
    }
    cycles.add("t_s", times);
    cycles
}

#[cfg(test)]
mod tests {
    use super::super::curves::{Tables, cycle_flows, plots, signals, wheel as wheel_charts};
    use super::*;
    use kit::scratch::Scratch;
    use serde_json::json;

    /// A wheel of 1 Hz that moves from 1 s to `until`, with eight reports per second and these cycles in its table.
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

    const TWO: &str = "cycle,t0_s,t1_s,sink_m,tangential_at_zero_n,traction_ratio,source_kg,ejected_kg,wear_kg\n\
                       1,1,2,3e-6,20,0.25,2e-9,1e-9,0\n2,2,3,1e-6,30,0.5,4e-9,3e-9,0\n";
    const ONE: &str = "cycle,t0_s,t1_s,traction_ratio\n1,1,2,0.25\n";

    /// First and last force (N) of each piece, in both columns of loops; the force is the number of the report.
    fn loops_of(run: &RunFiles) -> [Vec<(f64, f64)>; 2] {
        let signals = signals(run).expect("it is readable");
        [OTHERS, LAST].map(|name| {
            let values = signals.get(name).expect("it is there");
            let pieces = values
                .split(|x| x.is_nan())
                .filter(|piece| !piece.is_empty());
            pieces
                .map(|piece| (piece[0], piece[piece.len() - 1]))
                .collect()
        })
    }

    #[test]
    fn the_last_full_cycle_is_drawn_in_front_of_the_others() {
        let scratch = Scratch::new("loops", 1);
        let found = |until: f64| loops_of(&run(&scratch, until, ""));
        assert_eq!(
            found(4.25),
            [vec![(8.0, 24.0), (32.0, 34.0)], vec![(24.0, 32.0)]]
        );
        assert_eq!(found(3.0), [vec![(8.0, 16.0)], vec![(16.0, 24.0)]]);
        assert_eq!(found(2.0), [vec![], vec![(8.0, 16.0)]]);
        assert_eq!(found(1.5), [vec![(8.0, 12.0)], vec![]]);
        let drawn = |until: f64| {
            let own = signals(&run(&scratch, until, "")).expect("it is readable");
            let pictures = plots(&Tables::of(own), &wheel_charts());
            let found = pictures
                .into_iter()
                .find(|picture| picture.file == "friction.svg");
            found.expect("it is drawn").svg
        };
        let [both, one] = [3.0, 1.5].map(drawn);
        assert!(both.contains(">tangential force<") && both.contains(">in the last full cycle<"));
        assert!(one.contains(">tangential force<") && !one.contains("full cycle"));
        // A foreign program moves the wheel, and its frequency is unknown.
        let run = run(&scratch, 4.25, "");
        std::fs::remove_file(scratch.path().join("scenario.toml")).expect("it is there");
        assert_eq!(loops_of(&run), [vec![(8.0, 34.0)], vec![]]);
    }

    #[test]
    fn numbers_of_cycles_are_steps_over_their_times() {
        let scratch = Scratch::new("cycle-steps", 1);
        let two = run(&scratch, 3.5, TWO);
        let table = steps(written(&two));
        assert_eq!(table.get("t_s"), Some([1.0, 2.0, 2.0, 3.0].as_slice()));
        let sources = [2e-9, 2e-9, 4e-9, 4e-9];
        assert_eq!(table.get("source_kg"), Some(sources.as_slice()));
        let [picture] = &cycle_flows(&two)[..] else {
            panic!("there is one picture");
        };
        assert_eq!(
            picture.alternative,
            "Curves over t (ms); mass per cycle (µg): Qs, detached from 2.0000e0 to 4.0000e0; ejected from 1.0000e0 to 3.0000e0."
        );
        for table in [ONE, ""] {
            assert!(cycle_flows(&run(&scratch, 3.5, table)).is_empty());
        }
    }

    #[test]
    fn the_ratio_of_the_forces_has_the_mean_of_each_cycle() {
        let scratch = Scratch::new("cycle-mean", 1);
        let with = run(&scratch, 3.5, TWO);
        let own = signals(&with).expect("it is readable");
        let means = own.get(MEAN).expect("there are cycles");
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
            let pictures = plots(&Tables::of(own), &wheel_charts());
            let found = pictures
                .into_iter()
                .find(|picture| picture.file == "friction-coefficient.svg");
            found.expect("it is drawn").alternative
        };
        assert!(words(&with).contains("mean of each full cycle from 2.5000e-1 to 5.0000e-1"));
        assert!(!words(&run(&scratch, 3.5, "")).contains("mean of each"));
    }
}
