//! Grains as a continuum: pressure in the cells of their stress.

use super::mesh::{deformed_extent, draw_elements};
use draw::colour::{ColourScale, full_scale};
use draw::extent::Extent;
use draw::map::{Map, Panel, maps};
use draw::picture::Picture;
use draw::units::with_unit;
use runs::curve::quantile;
use runs::files::RunFiles;
use runs::table::Table;
use scenario::error::Error;

/// Share of the cells whose pressure the colours resolve: single cells have many times the mean.
const SHOWN: f64 = 0.98;

/// Pressure 2D trace / 3 in the cells of the first participant that wrote its stress, and below it, in the same colours, the hydrostatic
/// pressure of the first continuum, if there is one (Renouf, Saulot and Berthier 2006, figure 4).
pub fn pressure(run: &RunFiles) -> Result<Option<Picture>, Error> {
    let Some(cells) = StressCells::read(run) else {
        return Ok(None);
    };
    let continuum = run.fields_among(run.moments(), ".vtu")?;
    let body = continuum.as_ref().and_then(|(_, arrays)| {
        let pressure = arrays.get("hydrostatic_pressure_pa")?;
        Some((deformed_extent(arrays)?, arrays, pressure))
    });
    let mut shown = vec![Map::to_scale(cells.extent, "Cells of the grains' stress")];
    shown.extend(body.iter().map(|body| Map::to_scale(body.0, "Continuum")));
    let pressures = cells.all.iter().map(|(_, p)| *p).collect();
    let full = full_scale(quantile(pressures, SHOWN).unwrap_or(0.0));
    let scale = ColourScale::new("p = trace/3 (MPa)", 1e-6 * full, Some("tension"));
    let svg = maps(&shown, Some(&scale), |panel, number| match body {
        Some((_, arrays, values)) if number > 0 => {
            draw_elements(panel, arrays, |cell| scale.colour(1e-6 * values[cell]));
        }
        _ => cells.draw(panel, &scale),
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
struct StressCells {
    /// Centres (mm) and pressure (Pa).
    all: Vec<([f64; 2], f64)>,
    /// Size of a cell (mm), and extent of all.
    size: f64,
    extent: Extent,
}

impl StressCells {
    fn read(run: &RunFiles) -> Option<StressCells> {
        let files = run.field_files("-stress.csv");
        let table = Table::read_whole_rows(files.first()?);
        let [x, y, p] = ["x_m", "y_m", "p_tr3_pa"].map(|name| table.get(name));
        let (x, y, p) = (x?, y?, p?);
        let centres = x.iter().zip(y).map(|(x, y)| [1e3 * x, 1e3 * y]);
        let steps = y.windows(2).chain(x.windows(2));
        let steps = steps.map(|pair| (pair[1] - pair[0]).abs());
        let size = 1e3 * steps.filter(|step| *step > 1e-9).reduce(f64::min)?;
        Some(StressCells {
            extent: Extent::around(centres.clone().map(|centre| (centre, 0.5 * size)))?,
            all: centres.zip(p.iter().copied()).collect(),
            size,
        })
    }

    fn draw(&self, panel: &mut Panel, scale: &ColourScale) {
        let half = 0.5 * self.size;
        for ([x, y], p) in &self.all {
            let [left, right, low, high] = [x - half, x + half, y - half, y + half];
            let corners = [[left, low], [right, low], [right, high], [left, high]];
            let colour = scale.colour(1e-6 * p);
            panel.line(&corners, true, &format!("fill=\"{colour}\""));
        }
    }
}
