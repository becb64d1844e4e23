//! Grains as a continuum: pressure of the cells of their stress, and their velocities.

use std::path::Path;

use plotters::prelude::*;

use super::curves::{Columns, read_csv};
use super::fields::{Arrays, Moment, numbers, read_first};
use super::view::{
    Panel, Picture, View, elements, full_scale, page, picture, places_mm, pressure_colour,
};
use crate::error::Error;

/// Share of the cells whose pressure the colours, and whose velocity the arrows show: single ones have many times the mean.
const SHOWN: f64 = 0.98;
/// Arrows along the longer side of the velocity field.
const ARROWS: f64 = 48.0;
/// Angle of the head of an arrow to its shaft (rad), and its length over that.
const HEAD: (f64, f64) = (0.45, 0.35);

/// Pressure 2D trace / 3 in the cells of the first participant that wrote its stress, and below it the hydrostatic pressure of the
/// first continuum in the same colours, where there is one.
pub fn pressure(run: &Path, moments: &[Moment]) -> Result<Option<Picture>, Error> {
    let Some(cells) = Cells::read(run) else {
        return Ok(None);
    };
    let mut continuum = None;
    for Moment { name, .. } in moments {
        if continuum.is_none() {
            continuum = read_first(run, name, "vtu")?;
        }
    }
    let body = continuum.as_ref().and_then(|arrays| {
        let nodes = places_mm(arrays).into_iter().map(|place| (place, 0.0));
        Some((
            View::around(nodes)?,
            arrays,
            arrays.get("hydrostatic_pressure_pa")?,
        ))
    });
    let own = cells.view();
    let views: Vec<View> = [own]
        .into_iter()
        .chain(body.iter().map(|body| body.0))
        .collect();
    let full = cells.full_pa();
    let legend = format!(
        "x (mm); blue to red: p = trace/3, 0 to {} MPa, grey: tension",
        1e-6 * full
    );
    let svg = page(&views, &legend, |panel, view| match body {
        Some((_, arrays, values)) if *view != own => elements(panel, view, arrays, |cell| {
            pressure_colour(values[cell] / full)
        }),
        _ => cells.draw(panel, full),
    })?;
    Ok(Some(Picture {
        file: "cells.svg",
        caption: "Pressure in the cells of the grains' stress".into(),
        svg,
    }))
}

/// Square cells of the stress.
struct Cells {
    /// Centres (mm) and pressure (Pa).
    all: Vec<((f64, f64), f64)>,
    /// Their size (mm).
    size: f64,
}

impl Cells {
    fn read(run: &Path) -> Option<Cells> {
        let entries = std::fs::read_dir(run.join("fields")).into_iter();
        let paths = entries.flatten().flatten().map(|entry| entry.path());
        let first = paths
            .filter(|path| path.to_string_lossy().ends_with("-stress.csv"))
            .min()?;
        let columns: Columns = read_csv(&first);
        let [x, y, p] = ["x_m", "y_m", "p_tr3_pa"].map(|name| columns.get(name));
        let (x, y, p) = (x?, y?, p?);
        let places = x.iter().zip(y).map(|(x, y)| (1e3 * x, 1e3 * y));
        let steps = y
            .windows(2)
            .chain(x.windows(2))
            .map(|pair| (pair[1] - pair[0]).abs());
        let size = 1e3
            * steps
                .filter(|step| *step > 1e-9)
                .fold(f64::INFINITY, f64::min);
        Some(Cells {
            all: places.zip(p.iter().copied()).collect(),
            size,
        })
        .filter(|cells| cells.size.is_finite())
    }

    fn view(&self) -> View {
        let circles = self.all.iter().map(|(place, _)| (*place, 0.5 * self.size));
        let nothing = View {
            x_mm: [0.0, 1.0],
            y_mm: [0.0, 1.0],
        };
        View::around(circles).unwrap_or(nothing)
    }

    fn full_pa(&self) -> f64 {
        let mut pressures: Vec<f64> = self.all.iter().map(|(_, p)| *p).collect();
        pressures.sort_by(f64::total_cmp);
        let place = (SHOWN * pressures.len() as f64) as usize;
        full_scale(pressures.get(place).copied().unwrap_or(0.0))
    }

    fn draw(&self, panel: &mut Panel, full: f64) -> Result<(), Error> {
        let half = 0.5 * self.size;
        let squares = self.all.iter().map(|((x, y), p)| {
            let corners = [(x - half, y - half), (x + half, y + half)];
            Rectangle::new(corners, pressure_colour(p / full).filled())
        });
        panel.draw_series(squares).map(|_| ()).map_err(picture)
    }
}

/// Mean velocities of the grains in cells, as arrows, at the last of these moments that has grains.
pub fn velocities(run: &Path, moments: &[Moment]) -> Result<Option<Picture>, Error> {
    for Moment { name, words } in moments.iter().rev() {
        let Some(arrays) = read_first(run, name, "vtp")? else {
            continue;
        };
        let all = places_mm(&arrays);
        let wheel = numbers(&arrays, "wheel");
        let places: Vec<(usize, (f64, f64))> = all
            .into_iter()
            .enumerate()
            .filter(|(disk, _)| wheel.get(*disk).is_none_or(|wheel| *wheel == 0.0))
            .collect();
        let Some(view) = View::around(places.iter().map(|(_, place)| (*place, 0.0))) else {
            return Ok(None);
        };
        let size = view.width_mm().max(view.height_mm()) / ARROWS;
        let arrows = means(&arrays, &places, &view, size);
        let fastest = arrows
            .iter()
            .map(|(_, v)| v.0.hypot(v.1))
            .fold(0.0, f64::max);
        if fastest == 0.0 {
            return Ok(None);
        }
        let legend = format!(
            "x (mm); mean velocity over {size:.2} mm, the longest arrows: {:.3} mm/s and more",
            1e3 * fastest
        );
        let svg = page(
            &[view.with_margin(size, size, size)],
            &legend,
            |panel, _| {
                arrows.iter().try_for_each(|(at, v)| {
                    let scale = fastest.max(v.0.hypot(v.1));
                    arrow(panel, *at, (v.0 / scale, v.1 / scale), size)
                })
            },
        )?;
        return Ok(Some(Picture {
            file: "velocity.svg",
            caption: format!("Velocities of the grains at the {words}"),
            svg,
        }));
    }
    Ok(None)
}

/// Centres (mm) of the cells that hold grains, and the mean velocity of these (m/s).
fn means(
    arrays: &Arrays,
    places: &[(usize, (f64, f64))],
    view: &View,
    size: f64,
) -> Vec<((f64, f64), (f64, f64))> {
    let velocities = numbers(arrays, "velocity_m_per_s");
    let columns = (view.width_mm() / size) as usize + 1;
    let rows = (view.height_mm() / size) as usize + 1;
    let mut sums = vec![(0.0, 0.0, 0.0); columns * rows];
    for (disk, (x, y)) in places {
        let Some(v) = velocities.get(3 * disk..3 * disk + 3) else {
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

/// An arrow of this part of a cell's size around its centre.
fn arrow(panel: &mut Panel, at: (f64, f64), part: (f64, f64), size: f64) -> Result<(), Error> {
    let along = (part.0 * size, part.1 * size);
    let from = (at.0 - 0.5 * along.0, at.1 - 0.5 * along.1);
    let tip = (at.0 + 0.5 * along.0, at.1 + 0.5 * along.1);
    let (angle, length) = HEAD;
    let barb = |angle: f64| {
        let (sin, cos) = angle.sin_cos();
        let back = (along.0 * cos - along.1 * sin, along.0 * sin + along.1 * cos);
        (tip.0 - length * back.0, tip.1 - length * back.1)
    };
    let colour = pressure_colour(0.35 + 0.65 * part.0.hypot(part.1));
    let lines = [vec![from, tip], vec![barb(angle), tip, barb(-angle)]];
    let paths = lines.map(|points| PathElement::new(points, colour.stroke_width(1)));
    panel.draw_series(paths).map(|_| ()).map_err(picture)
}
