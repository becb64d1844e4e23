//! Grains as a continuum: pressure of the cells of their stress.

use std::path::Path;

use plotters::prelude::*;

use super::curves::{Columns, read_csv};
use super::fields::{Moment, read_first};
use super::view::{
    Panel, Picture, View, elements, full_scale, page, picture, places_mm, pressure_colour,
};
use crate::error::Error;

/// Share of the cells whose pressure the colours show: single ones have many times the mean.
const SHOWN: f64 = 0.98;

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
