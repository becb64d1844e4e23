//! Mean velocities and displacements of the grains in cells, as arrows.

use super::mesh::points_mm;
use draw::colour::shade;
use draw::extent::Extent;
use draw::map::{Map, Panel, maps};
use draw::picture::Picture;
use draw::units::with_unit;
use runs::curve::quantile;
use runs::fields::{Arrays, flags, numbers};
use runs::files::RunFiles;
use scenario::error::Error;

/// Arrows along the longer side of a field.
const ARROWS: f64 = 48.0;
/// Share of the arrows that are to scale: single detached grains move many times as fast as the mean.
const TO_SCALE: f64 = 0.95;
/// Head of an arrow: angle to the shaft (rad), and length over the shaft's.
const HEAD: [f64; 2] = [0.45, 0.35];

/// Vectors in the files of grains: name, file of the picture, words, unit, and comparative of the shorter arrows. Velocities (Renouf,
/// Saulot and Berthier 2006, figure 10), and displacements since the start of the run.
const VECTORS: [[&str; 5]; 2] = [
    [
        "velocity_m_per_s",
        "velocity.svg",
        "Velocities of the grains at the",
        "m/s",
        "slower",
    ],
    [
        "displacement_since_start_m",
        "moved.svg",
        "Displacements of the grains since the start of the run, at the",
        "m",
        "shorter",
    ],
];

/// The vectors at the last moment that has grains.
pub fn at_last(run: &RunFiles) -> Result<Vec<Picture>, Error> {
    let Some((moment, arrays)) = run.fields_among(run.moments().into_iter().rev(), ".vtp")? else {
        return Ok(Vec::new());
    };
    let Some(cells) = GrainCells::of(&arrays) else {
        return Ok(Vec::new());
    };
    let picture = |[name, file, what, unit, less]: &[&str; 5]| {
        let field = cells.means(numbers(&arrays, name));
        let longest = longest(std::slice::from_ref(&field))?;
        let (size, limit) = (cells.size, with_unit(longest, unit));
        let (all, at) = (field.len(), &moment.words);
        Some(Picture {
            file: file.to_string(),
            caption: format!(
                "{what} {at}, means over cells of {size:.2} mm; the longest arrows stand for {limit} and more."
            ),
            alternative: format!("{all} arrows; 95 of 100 are {less} than {limit}."),
            svg: cells.draw(&[field], longest, |_| String::new()),
        })
    };
    Ok(VECTORS.iter().filter_map(picture).collect())
}

/// The displacements since the start of the last phase of the load, at the last moments at which the wheel was furthest right, in the
/// middle and furthest left (Renouf, Saulot and Berthier 2006, figure 9). `None` if the wheel is no row of disks, or without fields
/// within the phase.
pub fn displacements(run: &RunFiles) -> Result<Option<Picture>, Error> {
    let [.., before, last] = run.phases()[..] else {
        return Ok(None);
    };
    let Some(start) = run.fields(before, ".vtp")? else {
        return Ok(None);
    };
    let mut moments = Vec::new();
    while let Some(arrays) = run.fields(&format!("{last}-{}", moments.len() + 1), ".vtp")? {
        moments.push(arrays);
    }
    Ok(displaced([before, last], &start, &moments))
}

/// The picture of the displacements since the end of the first of two phases; `None` if the wheel moves to one side only.
fn displaced([before, last]: [&str; 2], start: &Arrays, moments: &[Arrays]) -> Option<Picture> {
    let (from, wheel) = (numbers(start, "points"), flags(start, "wheel"));
    let moved = moments.iter().map(|arrays| {
        let points = numbers(arrays, "points").iter().zip(from);
        let moved: Vec<f64> = points.map(|(now, then)| now - then).collect();
        Some((mean_x(&moved, &wheel)?, moved))
    });
    let moved: Vec<(f64, Vec<f64>)> = moved.collect::<Option<_>>()?;
    let by = |order: fn(f64) -> f64| {
        let all = moved.iter();
        all.max_by(|(a, _), (b, _)| order(*a).total_cmp(&order(*b)))
    };
    let chosen @ [right, middle, left] = [by(|x| x)?, by(|x| -x.abs())?, by(|x| -x)?];
    if std::ptr::eq(right, middle) || std::ptr::eq(middle, left) {
        return None;
    }
    let cells = GrainCells::of(start)?;
    let fields = chosen.map(|(_, moved)| cells.means(moved));
    let longest = longest(&fields)?;
    let (size, limit) = (cells.size, with_unit(longest, "m"));
    Some(Picture {
        file: "displacement.svg".into(),
        caption: format!(
            "Displacements of the grains in `{last}` since the end of `{before}`, means over cells of {size:.2} mm; the longest arrows stand for {limit} and more."
        ),
        alternative: format!("Three maps of arrows; 95 of 100 are shorter than {limit}."),
        svg: cells.draw(&fields, longest, |k| {
            format!("the wheel at {:.4} mm", 1e3 * chosen[k].0)
        }),
    })
}

/// Mean x of the vectors of the marked disks.
fn mean_x(vectors: &[f64], marks: &[bool]) -> Option<f64> {
    let all = vectors.chunks_exact(3).zip(marks);
    let marked: Vec<f64> = all.filter(|(_, mark)| **mark).map(|(v, _)| v[0]).collect();
    (!marked.is_empty()).then(|| marked.iter().sum::<f64>() / marked.len() as f64)
}

/// Square cells over the grains of a file, without the grains of the wheel and those in store, which have no radius.
struct GrainCells {
    /// Indices of the grains in the file, with their centres (mm).
    grains: Vec<(usize, [f64; 2])>,
    extent: Extent,
    /// Side of a cell (mm).
    size: f64,
}

/// Centres of the cells that hold grains (mm), and the means there.
type Means = Vec<([f64; 2], [f64; 2])>;

impl GrainCells {
    fn of(arrays: &Arrays) -> Option<GrainCells> {
        let (wheel, radii) = (flags(arrays, "wheel"), numbers(arrays, "radius_m"));
        let all = points_mm(arrays).into_iter().enumerate();
        let there = all.filter(|(disk, _)| radii.get(*disk).is_none_or(|radius| *radius > 0.0));
        let grains: Vec<_> = there.filter(|(disk, _)| !wheel[*disk]).collect();
        let extent = Extent::around(grains.iter().map(|(_, centre)| (*centre, 0.0)))?;
        Some(GrainCells {
            grains,
            extent,
            size: extent.width().max(extent.height()) / ARROWS,
        })
    }

    /// Means of vectors, which have three numbers per disk.
    fn means(&self, vectors: &[f64]) -> Means {
        let (Extent { x, y }, size) = (self.extent, self.size);
        let columns = (self.extent.width() / size) as usize + 1;
        let rows = (self.extent.height() / size) as usize + 1;
        let mut sums = vec![([0.0; 2], 0.0); columns * rows];
        for (disk, centre) in &self.grains {
            let Some(v) = vectors.get(3 * disk..3 * disk + 3) else {
                continue;
            };
            let column = ((centre[0] - x[0]) / size) as usize;
            let row = ((centre[1] - y[0]) / size) as usize;
            let (sum, count) = &mut sums[row * columns + column];
            *sum = [sum[0] + v[0], sum[1] + v[1]];
            *count += 1.0;
        }
        let filled = sums.into_iter().enumerate();
        let filled = filled.filter(|(_, (_, count))| *count > 0.0);
        let mean = |(cell, (sum, count)): (usize, ([f64; 2], f64))| {
            let middle = |low: f64, k: usize| low + (k as f64 + 0.5) * size;
            let centre = [middle(x[0], cell % columns), middle(y[0], cell / columns)];
            (centre, sum.map(|sum| sum / count))
        };
        filled.map(mean).collect()
    }

    /// Fields one below another on one scale, each below its heading.
    fn draw(&self, fields: &[Means], longest: f64, heading: impl Fn(usize) -> String) -> String {
        let size = self.size;
        let extent = self.extent.with_margin(size, size, size);
        let shown = (0..fields.len()).map(|k| Map::to_scale(extent, &heading(k)));
        maps(&Vec::from_iter(shown), None, |panel, k| {
            for (at, v) in &fields[k] {
                let scale = longest.max(v[0].hypot(v[1]));
                arrow(panel, *at, v.map(|part| part / scale), size);
            }
        })
    }
}

/// The length that all but the longest arrows stay below; `None` if nothing moves.
fn longest(fields: &[Means]) -> Option<f64> {
    let arrows = fields.iter().flatten();
    let lengths = arrows.map(|(_, v)| v[0].hypot(v[1])).filter(|v| *v > 0.0);
    quantile(lengths.collect(), TO_SCALE)
}

/// An arrow centred at a point; `part` is its length in units of a cell's size.
fn arrow(panel: &mut Panel, at: [f64; 2], part: [f64; 2], size: f64) {
    let along = part.map(|part| part * size);
    let from = [0, 1].map(|k| at[k] - 0.5 * along[k]);
    let tip = [0, 1].map(|k| at[k] + 0.5 * along[k]);
    let [angle, length] = HEAD;
    let barb = |angle: f64| {
        let (sin, cos) = angle.sin_cos();
        let [x, y] = along;
        let back = [x * cos - y * sin, x * sin + y * cos];
        [0, 1].map(|k| tip[k] - length * back[k])
    };
    let colour = shade(0.45 + 0.55 * part[0].hypot(part[1]));
    let style = format!("fill=\"none\" stroke=\"{colour}\" stroke-width=\"1.2\"");
    panel.line(&[from, tip], false, &style);
    panel.line(&[barb(angle), tip, barb(-angle)], false, &style);
}

#[cfg(test)]
mod tests {
    use super::*;
    use kit::scratch::Scratch;

    /// A disk of the wheel over three grains, with their displacements (m).
    fn file(run: &std::path::Path, moment: &str, wheel: f64, grain: f64) {
        let (w, a, b) = (wheel, grain, 2e-3 + grain);
        let text = format!(
            "<DataArray Name=\"points\">{a} 0 0 {b} 0 0 {b} 1e-3 0 {w} 2e-3 0</DataArray>\
             <DataArray Name=\"wheel\">0 0 0 1</DataArray>"
        );
        let fields = run.join("fields");
        std::fs::create_dir_all(&fields).expect("a folder");
        std::fs::write(fields.join(format!("rail-{moment}.vtp")), text).expect("a file");
    }

    #[test]
    fn displacements_are_shown_at_the_last_extreme_and_middle_positions_of_the_wheel() {
        let scratch = Scratch::new("arrows", 1);
        let run = scratch.path();
        file(run, "hold", 0.0, 0.0);
        let files = RunFiles {
            path: run.to_path_buf(),
            summary: serde_json::json!({"phases": [{"name": "hold"}, {"name": "cycling"}]}),
            ..RunFiles::default()
        };
        let drawn = || displacements(&files).expect("it is drawn");
        assert!(drawn().is_none());
        let way = [0.8e-3, 1e-5, -0.7e-3, 2e-5, 0.9e-3, 0.0, -0.6e-3];
        for (k, wheel) in (1..).zip(way) {
            file(run, &format!("cycling-{k}"), wheel, 1e-2 * wheel);
        }
        let Picture { svg, caption, .. } = drawn().expect("three moments");
        let headings = ["0.9000", "0.0000", "-0.7000"].map(|mm| {
            let legend = format!("the wheel at {mm} mm");
            svg.find(&legend).unwrap_or_else(|| panic!("{legend}"))
        });
        assert!(headings.is_sorted(), "{headings:?}");
        assert!(caption.contains("9 µm and more"), "{caption}");
    }
}
