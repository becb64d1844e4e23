//! Profiles across a layer of grains: velocity, solid fraction and stress in slices, averaged over intervals.

use super::curves::{Chart, Tables, YAxis, over_time, plots};
use super::cycles::number_or_gap;
use draw::picture::Picture;
use draw::units::four;
use runs::files::RunFiles;
use runs::table::Table;

/// The end of the run cut an interval that is shorter than this part of the longest.
const WHOLE: f64 = 0.9;

/// The profiles of the first participant that wrote them: the last whole interval in front, earlier intervals paler behind it.
pub(super) fn profiles(run: &RunFiles) -> Vec<Picture> {
    let mut files = run.field_files("-profile.csv").into_iter();
    let found = files.find_map(|file| drawn(&Table::read_whole_rows(&file)));
    found.unwrap_or_default()
}

/// `None` for a table of something else, or without an interval.
fn drawn(slices: &Table) -> Option<Vec<Picture>> {
    let (starts, ends) = (slices.get("t0_s")?, slices.get("t1_s")?);
    let length = |row: &usize| ends[*row] - starts[*row];
    let longest = (0..starts.len()).map(|row| length(&row));
    let longest = longest.fold(0.0, f64::max);
    let whole = (0..starts.len()).filter(|row| length(row) >= WHOLE * longest);
    let rows: Vec<usize> = whole.collect();
    let last = *rows.last()?;
    let [axis, across] = match slices.get("y_m") {
        Some(_) => ["y", "x"],
        None => ["x", "y"],
    };
    let mut own = Table::default();
    for (name, column) in [
        ("position", format!("{axis}_m")),
        ("velocity", format!("v{across}_m_per_s")),
        ("fraction", "solid_fraction".into()),
        ("normal", format!("stress_{axis}{axis}_pa")),
        ("shear", format!("stress_{across}{axis}_pa")),
    ] {
        let numbers = slices.get(&column)?;
        // Each interval ends with a gap.
        let among = |chosen: &dyn Fn(usize) -> bool| {
            let number = |row: &usize| number_or_gap(numbers, *row, chosen(*row));
            let intervals = rows.chunk_by(|a, b| starts[*a] == starts[*b]);
            let all = intervals.flat_map(|rows| rows.iter().map(number).chain([f64::NAN]));
            Vec::from_iter(all)
        };
        let is_last = |row: usize| starts[row] == starts[last];
        own.add(name, among(&|row| name == "position" || is_last(row)));
        own.add(&format!("earlier.{name}"), among(&|row| !is_last(row)));
    }
    let [start, end] = [starts, ends].map(|times| four(1e3 * times[last]));
    let words = if axis == "y" { "y (mm)" } else { "x (mm)" };
    let chart = |file: &str, what: &str, y: YAxis, lines: &[(&str, &str)]| {
        let caption = format!("{what} in slices, means from {start} to {end} ms");
        Chart {
            x: (words, "position".into(), 1e3),
            styles: &[3, 0, 9, 1],
            ..over_time(file, &caption, y, lines)
        }
    };
    let charts = [
        chart(
            "profile-velocity.svg",
            "Velocity of the grains along the layer",
            YAxis::Linear("velocity (m/s)", 1.0),
            &[("earlier", "earlier.velocity"), ("velocity", "velocity")],
        ),
        chart(
            "profile-solid-fraction.svg",
            "Solid fraction of the grains",
            YAxis::Linear("solid fraction", 1.0),
            &[
                ("earlier", "earlier.fraction"),
                ("solid fraction", "fraction"),
            ],
        ),
        chart(
            "profile-stress.svg",
            "Stress of the grains (compression positive)",
            YAxis::Linear("stress (MPa)", 1e-6),
            &[
                ("earlier", "earlier.normal"),
                ("normal stress", "normal"),
                ("earlier", "earlier.shear"),
                ("shear stress", "shear"),
            ],
        ),
    ];
    Some(plots(&Tables::of(own), &charts))
}

#[cfg(test)]
mod tests {
    use super::*;
    use kit::scratch::Scratch;

    /// Three intervals of two slices each; the end of the run cut the last interval. The velocity is the index of the row.
    fn table(axis: &str) -> String {
        let mut text = format!(
            "t0_s,t1_s,{axis}_m,vx_m_per_s,vy_m_per_s,solid_fraction,stress_xx_pa,stress_xy_pa,stress_yx_pa,stress_yy_pa,shear_rate_per_s\n"
        );
        for row in 0..6 {
            let (start, slice) = (f64::from(row / 2), f64::from(row % 2));
            let end = if row < 4 { start + 1.0 } else { start + 0.3 };
            text += &format!(
                "{start},{end},{},{row},0.5,0.8,1e6,2e6,3e6,4e6,0\n",
                1e-3 * slice
            );
        }
        text
    }

    fn drawn_of(purpose: &str, files: &[(&str, &str)]) -> Vec<Picture> {
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
    fn the_last_whole_interval_is_drawn_in_front_of_the_earlier_ones() {
        let traction = "x_m,pressure_pa,shear_pa,status\n0,1,1,open\n";
        let files = [
            ("a-hold-profile.csv", traction),
            ("layer-profile.csv", &table("y")),
        ];
        let [velocity, fraction, stress] = &drawn_of("profiles", &files)[..] else {
            panic!("there are three pictures");
        };
        assert_eq!(
            velocity.caption,
            "Velocity of the grains along the layer in slices, means from 1\u{202f}000 to 2\u{202f}000 ms"
        );
        for (picture, words) in [
            (
                velocity,
                "velocity (m/s): earlier from 0.0000e0 to 1.0000e0; velocity from 2.0000e0 to 3.0000e0",
            ),
            (
                fraction,
                "solid fraction: earlier from 8.0000e-1 to 8.0000e-1; solid fraction from 8.0000e-1 to 8.0000e-1",
            ),
            (
                stress,
                "stress (MPa): earlier from 4.0000e0 to 4.0000e0; normal stress from 4.0000e0 to 4.0000e0; \
                 earlier from 2.0000e0 to 2.0000e0; shear stress from 2.0000e0 to 2.0000e0",
            ),
        ] {
            assert_eq!(picture.alternative, format!("Curves over y (mm); {words}."));
        }
        let [_, _, stress] = &drawn_of("profiles-x", &[("layer-profile.csv", &table("x"))])[..]
        else {
            panic!("there are three pictures");
        };
        for words in ["normal stress from 1.0000e0", "shear stress from 3.0000e0"] {
            assert!(stress.alternative.contains(words), "{words}");
        }
    }

    #[test]
    fn a_run_without_profiles_has_no_pictures_of_them() {
        let traction = "x_m,pressure_pa,shear_pa,status\n0,1,1,open\n";
        assert!(drawn_of("profiles-none", &[("rail-hold-profile.csv", traction)]).is_empty());
        let text = table("y");
        let header = text.lines().next().expect("a header");
        assert!(drawn_of("profiles-empty", &[("layer-profile.csv", header)]).is_empty());
    }

    /// Each whole interval is a separate line, and the legend has two more lines.
    #[test]
    fn no_line_joins_two_intervals() {
        let text = table("y").replace("2.3", "3");
        let pictures = drawn_of("profiles-three", &[("layer-profile.csv", &text)]);
        assert_eq!(pictures[1].svg.matches("<polyline").count(), 3);
    }
}
