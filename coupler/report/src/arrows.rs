//! Mean velocities and displacements of the grains in cells, as arrows.

use super::units::with_unit;
use super::view::{Frame, Panel, View, maps, places_mm};
use coordinator::error::Error;
use draw::colour::shade;
use draw::picture::Picture;
use runs::fields::{Arrays, numbers, read_first};
use runs::files::{Moment, RunFiles};

/// Arrows along the longer side of a field.
const ARROWS: f64 = 48.0;
/// Share of the arrows that are to scale: single grains that came off have many times the mean.
const TO_SCALE: f64 = 0.95;
/// Angle of the head of an arrow to its shaft (rad), and its length over that.
const HEAD: (f64, f64) = (0.45, 0.35);

/// A vector that the files of grains hold, and the words of its picture.
struct Vector {
    name: &'static str,
    file: &'static str,
    what: &'static str,
    unit: &'static str,
    /// "Slower", "shorter": of most arrows.
    less: &'static str,
}

const VELOCITY: Vector = Vector {
    name: "velocity_m_per_s",
    file: "velocity.svg",
    what: "Velocities of the grains at the",
    unit: "m/s",
    less: "slower",
};

const MOVED: Vector = Vector {
    name: "displacement_since_start_m",
    file: "moved.svg",
    what: "Displacements of the grains since the start of the run, at the",
    unit: "m",
    less: "shorter",
};

/// The velocities at the last of the moments that has grains (Renouf, Saulot and Berthier 2006, figure 10).
pub fn velocities(run: &RunFiles) -> Result<Option<Picture>, Error> {
    at_last(run, &VELOCITY)
}

/// The displacements since the start of the run, at the same moment.
pub fn moved(run: &RunFiles) -> Result<Option<Picture>, Error> {
    at_last(run, &MOVED)
}

fn at_last(run: &RunFiles, vector: &Vector) -> Result<Option<Picture>, Error> {
    for Moment { name, words } in run.moments.iter().rev() {
        let Some(arrays) = read_first(&run.path, name, "vtp")? else {
            continue;
        };
        let Some(cells) = Cells::of_grains(&arrays) else {
            return Ok(None);
        };
        let field = cells.means(numbers(&arrays, vector.name));
        let Some(longest) = longest(std::slice::from_ref(&field)) else {
            return Ok(None);
        };
        let (size, limit) = (cells.size, with_unit(longest, vector.unit));
        return Ok(Some(Picture {
            file: vector.file.into(),
            caption: format!(
                "{} {words}, means over cells of {size:.2} mm; the longest arrows stand for {limit} and more.",
                vector.what
            ),
            alternative: format!(
                "{} arrows; 95 of 100 are {} than {limit}.",
                field.len(),
                vector.less
            ),
            svg: cells.draw(&[field], longest, |_| String::new()),
        }));
    }
    Ok(None)
}

/// The displacements since the start of the last phase of the load, at its moments where the wheel was last furthest right, in
/// the middle and furthest left (Renouf, Saulot and Berthier 2006, figure 9). None where the wheel is no row of disks, or
/// without fields within the phase.
pub fn displacements(run: &RunFiles) -> Result<Option<Picture>, Error> {
    let [.., before, last] = &run.phases[..] else {
        return Ok(None);
    };
    let Some(start) = read_first(&run.path, before, "vtp")? else {
        return Ok(None);
    };
    let from = numbers(&start, "points");
    let mut moments = Vec::new();
    let names = (1..).map(|k| format!("{last}-{k}"));
    for name in names {
        let Some(arrays) = read_first(&run.path, &name, "vtp")? else {
            break;
        };
        let points = numbers(&arrays, "points").iter().zip(from);
        let moved: Vec<f64> = points.map(|(now, then)| now - then).collect();
        let Some(wheel) = mean_x(&moved, numbers(&start, "wheel")) else {
            return Ok(None);
        };
        moments.push((wheel, moved));
    }
    let by = |order: fn(f64) -> f64| {
        let all = moments.iter();
        all.max_by(|(a, _), (b, _)| order(*a).total_cmp(&order(*b)))
    };
    let chosen = [by(|x| x), by(|x| -x.abs()), by(|x| -x)];
    let ([Some(right), Some(middle), Some(left)], Some(cells)) = (chosen, Cells::of_grains(&start))
    else {
        return Ok(None);
    };
    if std::ptr::eq(right, middle) || std::ptr::eq(middle, left) {
        return Ok(None);
    }
    let chosen = [right, middle, left];
    let fields = chosen.map(|(_, moved)| cells.means(moved));
    let Some(longest) = longest(&fields) else {
        return Ok(None);
    };
    let svg = cells.draw(&fields, longest, |place| {
        format!("the wheel at {:.4} mm", 1e3 * chosen[place].0)
    });
    Ok(Some(Picture {
        file: "displacement.svg".into(),
        caption: format!(
            "Displacements of the grains in `{last}` since the end of `{before}`, means over cells of {:.2} mm; the longest arrows stand for {} and more.",
            cells.size,
            with_unit(longest, "m")
        ),
        alternative: format!(
            "Three maps of arrows; 95 of 100 are shorter than {}.",
            with_unit(longest, "m")
        ),
        svg,
    }))
}

/// Mean x of the vectors of the marked disks.
fn mean_x(vectors: &[f64], marks: &[f64]) -> Option<f64> {
    let all = vectors.chunks_exact(3).zip(marks);
    let marked: Vec<f64> = all
        .filter(|(_, mark)| **mark > 0.0)
        .map(|(v, _)| v[0])
        .collect();
    (!marked.is_empty()).then(|| marked.iter().sum::<f64>() / marked.len() as f64)
}

/// Square cells over the grains of a file that are neither the wheel's nor in store, without a radius.
struct Cells {
    /// Grains by their places in the file, with their centres (mm).
    grains: Vec<(usize, (f64, f64))>,
    view: View,
    /// Side of a cell (mm).
    size: f64,
}

/// Centres of the cells that hold grains (mm), and the means there.
type Means = Vec<((f64, f64), (f64, f64))>;

impl Cells {
    fn of_grains(arrays: &Arrays) -> Option<Cells> {
        let [wheel, radii] = ["wheel", "radius_m"].map(|name| numbers(arrays, name));
        let all = places_mm(arrays).into_iter().enumerate();
        let there = all.filter(|(disk, _)| radii.get(*disk).is_none_or(|radius| *radius > 0.0));
        let grains: Vec<_> = there
            .filter(|(disk, _)| wheel.get(*disk).is_none_or(|wheel| *wheel == 0.0))
            .collect();
        let view = View::around(grains.iter().map(|(_, place)| (*place, 0.0)))?;
        let size = view.width_mm().max(view.height_mm()) / ARROWS;
        Some(Cells { grains, view, size })
    }

    /// Means of vectors of three numbers a disk.
    fn means(&self, vectors: &[f64]) -> Means {
        let (view, size) = (&self.view, self.size);
        let columns = (view.width_mm() / size) as usize + 1;
        let rows = (view.height_mm() / size) as usize + 1;
        let mut sums = vec![(0.0, 0.0, 0.0); columns * rows];
        for (disk, (x, y)) in &self.grains {
            let Some(v) = vectors.get(3 * disk..3 * disk + 3) else {
                continue;
            };
            let column = ((x - view.x_mm[0]) / size) as usize;
            let row = ((y - view.y_mm[0]) / size) as usize;
            let cell = &mut sums[row * columns + column];
            *cell = (cell.0 + v[0], cell.1 + v[1], cell.2 + 1.0);
        }
        let centre = |cell: usize| {
            let (row, column) = (cell / columns, cell % columns);
            let middle = |low: f64, place: usize| low + (place as f64 + 0.5) * size;
            (middle(view.x_mm[0], column), middle(view.y_mm[0], row))
        };
        let filled = sums.into_iter().enumerate().filter(|(_, sum)| sum.2 > 0.0);
        filled
            .map(|(cell, (x, y, count))| (centre(cell), (x / count, y / count)))
            .collect()
    }

    /// Fields one below the other on one scale, each below its heading.
    fn draw(&self, fields: &[Means], longest: f64, heading: impl Fn(usize) -> String) -> String {
        let size = self.size;
        let view = self.view.with_margin(size, size, size).to_scale();
        let frames = (0..fields.len()).map(|place| Frame {
            view,
            heading: heading(place),
        });
        maps(&Vec::from_iter(frames), None, |panel, place| {
            for (at, v) in &fields[place] {
                let scale = longest.max(v.0.hypot(v.1));
                arrow(panel, *at, (v.0 / scale, v.1 / scale), size);
            }
        })
    }
}

/// The length that all but the longest arrows stay below; none where nothing moves.
fn longest(fields: &[Means]) -> Option<f64> {
    let arrows = fields.iter().flatten();
    let lengths = arrows.map(|(_, v)| v.0.hypot(v.1)).filter(|v| *v > 0.0);
    let mut lengths: Vec<f64> = lengths.collect();
    lengths.sort_by(f64::total_cmp);
    let place = (TO_SCALE * lengths.len() as f64) as usize;
    lengths.get(place).copied()
}

/// An arrow of this part of a cell's size around its centre.
fn arrow(panel: &mut Panel, at: (f64, f64), part: (f64, f64), size: f64) {
    let along = (part.0 * size, part.1 * size);
    let from = (at.0 - 0.5 * along.0, at.1 - 0.5 * along.1);
    let tip = (at.0 + 0.5 * along.0, at.1 + 0.5 * along.1);
    let (angle, length) = HEAD;
    let barb = |angle: f64| {
        let (sin, cos) = angle.sin_cos();
        let back = (along.0 * cos - along.1 * sin, along.0 * sin + along.1 * cos);
        (tip.0 - length * back.0, tip.1 - length * back.1)
    };
    let colour = shade(0.45 + 0.55 * part.0.hypot(part.1));
    let style = format!("fill=\"none\" stroke=\"{colour}\" stroke-width=\"1.2\"");
    panel.line(&[from, tip], false, &style);
    panel.line(&[barb(angle), tip, barb(-angle)], false, &style);
}

#[cfg(test)]
mod tests {
    use super::*;
    use kit::scratch::Scratch;

    /// A disk of the wheel over three grains, displaced by so much (m).
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
    fn displacements_are_shown_where_the_wheel_was_last_furthest_and_in_the_middle() {
        let scratch = Scratch::new("arrows", 1);
        let run = scratch.path();
        file(run, "hold", 0.0, 0.0);
        let files = RunFiles {
            path: run.to_path_buf(),
            phases: ["hold", "cycling"].map(String::from).to_vec(),
            ..RunFiles::default()
        };
        let drawn = || displacements(&files).expect("it is drawn");
        assert!(drawn().is_none());
        let way = [0.8e-3, 1e-5, -0.7e-3, 2e-5, 0.9e-3, 0.0, -0.6e-3];
        for (k, wheel) in (1..).zip(way) {
            file(run, &format!("cycling-{k}"), wheel, 1e-2 * wheel);
        }
        let Picture { svg, caption, .. } = drawn().expect("three moments");
        let places = ["0.9000", "0.0000", "-0.7000"].map(|mm| {
            let legend = format!("the wheel at {mm} mm");
            svg.find(&legend).unwrap_or_else(|| panic!("{legend}"))
        });
        assert!(places.is_sorted(), "{places:?}");
        assert!(caption.contains("9 µm and more"), "{caption}");
    }
}
