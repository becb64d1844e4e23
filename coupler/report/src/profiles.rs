//! Profiles across a layer of grains: velocity, solid fraction and stress in slices, means over intervals.

use super::curves::ranges;
use super::units::four;
use draw::picture::Picture;
use draw::plot::{BACKGROUND, Labels, PlotCurve, plot};
use runs::files::RunFiles;
use runs::table::Table;

/// Most earlier intervals that are drawn.
const EARLIER: usize = 5;
/// Styles of their quantities.
const PALE: [usize; 2] = [BACKGROUND, 9];
/// An interval below this part of the longest one was cut by the end of the run.
const WHOLE: f64 = 0.9;

/// A picture: its file, its words, those of its axis with the factor from SI, and its quantities: words and column, in both of which `A` stands
/// for the axis and `B` for the direction across it.
type Profile<'a> = (&'a str, &'a str, &'a str, f64, &'a [[&'a str; 2]]);

const PROFILES: [Profile; 3] = [
    (
        "profile-velocity.svg",
        "Velocity of the grains",
        "velocity (m/s)",
        1.0,
        &[["along B", "vB_m_per_s"], ["along A", "vA_m_per_s"]],
    ),
    (
        "profile-solid-fraction.svg",
        "Solid fraction of the grains",
        "solid fraction",
        1.0,
        &[["solid fraction", "solid_fraction"]],
    ),
    (
        "profile-stress.svg",
        "Stress of the grains (compression positive)",
        "stress (MPa)",
        1e-6,
        &[
            ["normal stress", "stress_AA_pa"],
            ["shear stress", "stress_BA_pa"],
        ],
    ),
];

/// The profiles of the first participant that wrote them: those of the last whole interval before paler ones of earlier intervals.
pub(super) fn profiles(run: &RunFiles) -> Vec<Picture> {
    let files = run.field_files("-profile.csv");
    let tables = files.iter().map(|file| Table::read_whole_rows(file));
    let layer = tables.filter_map(Slices::of).next();
    layer.map_or(Vec::new(), |layer| {
        PROFILES.iter().filter_map(|of| layer.picture(of)).collect()
    })
}

/// The slices of a layer.
struct Slices {
    table: Table,
    /// True for slices along y, which are drawn upwards.
    upward: bool,
    /// First and last row of each interval that is drawn.
    intervals: Vec<[usize; 2]>,
}

impl Slices {
    /// `None` of a table of something else, or without an interval.
    fn of(table: Table) -> Option<Slices> {
        table.get("solid_fraction")?;
        let (starts, ends) = (table.get("t0_s")?, table.get("t1_s")?);
        let rows: Vec<usize> = (0..starts.len()).collect();
        let intervals = rows.chunk_by(|a, b| starts[*a] == starts[*b]);
        let all: Vec<[usize; 2]> = intervals
            .map(|rows| [rows[0], rows[rows.len() - 1]])
            .collect();
        let length = |rows: &[usize; 2]| ends[rows[0]] - starts[rows[0]];
        let longest = all.iter().map(length).fold(0.0, f64::max);
        let whole: Vec<_> = all
            .into_iter()
            .filter(|rows| length(rows) >= WHOLE * longest)
            .collect();
        let (last, earlier) = whole.split_last()?;
        let stride = earlier.len().div_ceil(EARLIER).max(1);
        let mut intervals: Vec<_> = earlier.iter().rev().step_by(stride).copied().collect();
        intervals.insert(0, *last);
        intervals.reverse();
        Some(Slices {
            upward: table.get("y_m").is_some(),
            intervals,
            table,
        })
    }

    fn picture(&self, (file, what, words, factor, quantities): &Profile) -> Option<Picture> {
        let (axis, across) = if self.upward { ("y", "x") } else { ("x", "y") };
        let (position, words_of_position) = (
            self.table.get(&format!("{axis}_m"))?,
            format!("{axis} (mm)"),
        );
        let mut curves = Vec::new();
        for (number, [from, to]) in self.intervals.iter().enumerate() {
            let is_last = number + 1 == self.intervals.len();
            for (k, [quantity, column]) in quantities.iter().enumerate() {
                let [quantity, column] =
                    [quantity, column].map(|name| name.replace('A', axis).replace('B', across));
                let values = self.table.get(&column)?;
                let point = |row: usize| match (1e3 * position[row], factor * values[row]) {
                    (at, value) if self.upward => (value, at),
                    point => point,
                };
                curves.push(PlotCurve {
                    label: match (is_last, number) {
                        (true, _) => quantity,
                        (false, 0) => format!("{quantity}, earlier"),
                        (false, _) => String::new(),
                    },
                    points: (*from..=*to).map(point).collect(),
                    style: if is_last { k } else { PALE[k] },
                });
            }
        }
        let last = &curves[curves.len() - quantities.len()..];
        let ranges = ranges(last, |(x, y)| if self.upward { *x } else { *y });
        let row = self.intervals.last()?[0];
        let [start, end] = ["t0_s", "t1_s"].map(|name| self.table.get(name).map(|t| t[row]));
        let labels = match self.upward {
            true => Labels {
                x: words,
                y: &words_of_position,
                log_y: false,
            },
            false => Labels {
                x: &words_of_position,
                y: words,
                log_y: false,
            },
        };
        Some(Picture {
            file: file.to_string(),
            caption: format!(
                "{what} in slices along {axis}, means from {} to {} ms",
                four(1e3 * start?),
                four(1e3 * end?)
            ),
            alternative: format!("Curves over {axis}; {words}: {ranges}."),
            svg: plot(labels, &curves),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use kit::scratch::Scratch;

    /// Three intervals of two slices each, of which the end of the run cut the last; the velocity is the number of the row.
    fn table(axis: &str) -> String {
        let mut text = format!(
            "t0_s,t1_s,{axis}_m,vx_m_per_s,vy_m_per_s,solid_fraction,stress_xx_pa,stress_xy_pa,stress_yx_pa,stress_yy_pa,shear_rate_per_s\n"
        );
        for row in 0..6 {
            let (start, slice) = (f64::from(row / 2), f64::from(row % 2));
            let end = if row < 4 { start + 1.0 } else { start + 0.3 };
            text += &format!(
                "{start},{end},{},{row},NaN,0.8,1e6,2e6,3e6,4e6,0\n",
                1e-3 * slice
            );
        }
        text
    }

    fn drawn(purpose: &str, files: &[(&str, &str)]) -> Vec<Picture> {
        let scratch = Scratch::new(purpose, 1);
        let fields = scratch.path().join("fields");
        std::fs::create_dir_all(&fields).expect("a folder");
        for (name, text) in files {
            std::fs::write(fields.join(name), text).expect("a file");
        }
        profiles(&RunFiles {
            path: scratch.path().into(),
            ..RunFiles::default()
        })
    }

    #[test]
    fn the_last_whole_interval_stands_before_the_earlier_ones() {
        let traction = "x_m,pressure_pa,shear_pa,status\n0,1,1,open\n";
        let files = [
            ("a-hold-profile.csv", traction),
            ("layer-profile.csv", &table("y")),
        ];
        let [velocity, fraction, stress] = &drawn("profiles", &files)[..] else {
            panic!("there are three pictures");
        };
        assert_eq!(
            velocity.caption,
            "Velocity of the grains in slices along y, means from 1\u{202f}000 to 2\u{202f}000 ms"
        );
        assert_eq!(
            velocity.alternative,
            "Curves over y; velocity (m/s): along x from 2.0000e0 to 3.0000e0."
        );
        assert_eq!(
            fraction.alternative,
            "Curves over y; solid fraction: solid fraction from 8.0000e-1 to 8.0000e-1."
        );
        assert_eq!(
            stress.alternative,
            "Curves over y; stress (MPa): normal stress from 4.0000e0 to 4.0000e0; shear stress from 2.0000e0 to 2.0000e0."
        );
        for words in [
            ">normal stress, earlier<",
            ">shear stress, earlier<",
            ">y (mm)<",
            ">stress (MPa)<",
        ] {
            assert!(stress.svg.contains(words), "{words}");
        }
        let [_, _, stress] = &drawn("profiles-x", &[("layer-profile.csv", &table("x"))])[..] else {
            panic!("there are three pictures");
        };
        assert!(
            stress
                .alternative
                .contains("normal stress from 1.0000e0 to 1.0000e0; shear stress from 3.0000e0")
        );
    }

    #[test]
    fn a_run_without_profiles_has_no_pictures_of_them() {
        let traction = "x_m,pressure_pa,shear_pa,status\n0,1,1,open\n";
        assert!(drawn("profiles-none", &[("rail-hold-profile.csv", traction)]).is_empty());
        let header = table("y")
            .lines()
            .next()
            .map(str::to_string)
            .expect("a header");
        assert!(drawn("profiles-empty", &[("layer-profile.csv", &header)]).is_empty());
    }

    /// Ten whole intervals: the last one and five of those before it, the newest first.
    #[test]
    fn a_few_earlier_intervals_stand_for_many() {
        let rows = (0..11).map(|k| format!("{k},{},0,0.8\n", k + 1));
        let text = format!("t0_s,t1_s,y_m,solid_fraction\n{}", rows.collect::<String>());
        let slices = Slices::of(Table::parse(&text).expect("a table")).expect("there are slices");
        assert_eq!(slices.intervals, [1, 3, 5, 7, 9, 10].map(|row| [row, row]));
    }
}
