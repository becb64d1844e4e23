//! Grains as a continuum: pressure of the cells of their stress.

use std::path::Path;

use super::units::with_unit;
use super::view::{Frame, Panel, View, deformed_mm, elements, maps};
use coordinator::error::Error;
use draw::colour::{Scale, full_scale};
use draw::picture::Picture;
use runs::columns::{Columns, read_csv};
use runs::fields::read_first;
use runs::files::RunFiles;

/// Share of the cells whose pressure the colours show: single ones have many times the mean.
const SHOWN: f64 = 0.98;

/// Pressure 2D trace / 3 in the cells of the first participant that wrote its stress, and below it the hydrostatic pressure of the
/// first continuum in the same colours, where there is one (Renouf, Saulot and Berthier 2006, figure 4).
pub fn pressure(run: &RunFiles) -> Result<Option<Picture>, Error> {
    let Some(cells) = Cells::read(&run.path) else {
        return Ok(None);
    };
    let mut continuum = None;
    for moment in &run.moments {
        if continuum.is_none() {
            continuum = read_first(&run.path, &moment.name, "vtu")?;
        }
    }
    let body = continuum.as_ref().and_then(|arrays| {
        let nodes = deformed_mm(arrays).into_iter().map(|place| (place, 0.0));
        Some((
            View::around(nodes)?,
            arrays,
            arrays.get("hydrostatic_pressure_pa")?,
        ))
    });
    let frame = |view: View, heading: &str| Frame {
        view: view.to_scale(),
        heading: heading.into(),
    };
    let mut frames = vec![frame(cells.view(), "Cells of the grains' stress")];
    frames.extend(body.iter().map(|body| frame(body.0, "Continuum")));
    let full = cells.full_pa();
    let scale = Scale {
        quantity: "p = trace/3 (MPa)".into(),
        end: 1e-6 * full,
        below: Some("tension"),
    };
    let svg = maps(&frames, Some(&scale), |panel, place| match body {
        Some((_, arrays, values)) if place > 0 => {
            elements(panel, arrays, |cell| scale.colour(1e-6 * values[cell]));
        }
        _ => cells.paint(panel, &scale),
    });
    Ok(Some(Picture {
        file: "cells.svg".into(),
        caption: format!(
            "Pressure in the cells of the grains' stress at the end of the hold, a third of the in-plane trace; the darkest colour stands for {} and more.",
            with_unit(full, "Pa")
        ),
        alternative: format!("Map of {} cells.", cells.all.len()),
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

    fn paint(&self, panel: &mut Panel, scale: &Scale) {
        let half = 0.5 * self.size;
        for ((x, y), p) in &self.all {
            let [left, right, low, high] = [x - half, x + half, y - half, y + half];
            let corners = [(left, low), (right, low), (right, high), (left, high)];
            let colour = scale.colour(1e-6 * p);
            panel.line(&corners, true, &format!("fill=\"{colour}\""));
        }
    }
}
