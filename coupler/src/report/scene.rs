//! Grains and continuum around the contact, coloured by pressure.

use std::path::Path;

use plotters::prelude::*;

use super::fields::{Arrays, Moment, numbers, read_first};
use super::view::{
    Panel, Picture, View, disk, elements, full_scale, page, places_mm, pressure_colour,
};
use crate::error::Error;

/// Fields at a moment: those of the first continuum and of the first layer of grains. A second continuum has a frame of its
/// own, in which it may lie where the first one does.
struct Scene {
    continuum: Option<Arrays>,
    grains: Option<Arrays>,
}

/// The scene at the first of these moments that has fields: the whole contact and, where a layer of grains is much longer
/// than high, its middle below. `None` where no participant wrote fields.
pub fn contact(run: &Path, moments: &[Moment]) -> Result<Option<Picture>, Error> {
    for Moment { name, words } in moments {
        let scene = Scene {
            continuum: read_first(run, name, "vtu")?,
            grains: read_first(run, name, "vtp")?,
        };
        let views = scene.views();
        if !views.is_empty() {
            let what = "Hydrostatic pressure in the continuum and pressure on the grains";
            return Ok(Some(Picture {
                file: "scene.svg",
                caption: format!("{what} at the {words}"),
                svg: scene.draw(&views)?,
            }));
        }
    }
    Ok(None)
}

impl Scene {
    /// The grains and as much of the continuum as their pressure reaches; without grains all of it.
    fn views(&self) -> Vec<View> {
        let nodes = self
            .continuum
            .iter()
            .flat_map(places_mm)
            .map(|place| (place, 0.0));
        let Some(all) = View::around(nodes.chain(self.circles())) else {
            return Vec::new();
        };
        let edge = 0.02 * all.height_mm();
        let all = all.with_margin(0.0, edge, edge);
        let Some(layer) = View::around(self.circles()) else {
            return vec![all];
        };
        let side = 0.02 * layer.width_mm();
        let deep = 0.16 * layer.width_mm();
        let mut views = vec![layer.with_margin(side, deep, deep).within(&all)];
        let half = 4.5 * layer.height_mm();
        if half < 0.4 * layer.width_mm() {
            let centre = 0.5 * (layer.x_mm[0] + layer.x_mm[1]);
            let middle = View {
                x_mm: [centre - half, centre + half],
                ..layer
            };
            let inside = self.circles().filter(|(place, _)| middle.holds(*place));
            let mut near = View::around(inside).unwrap_or(middle);
            near = near.with_margin(0.0, 0.5 * near.height_mm(), 0.5 * near.height_mm());
            near.x_mm = middle.x_mm;
            views.push(near.within(&all));
        }
        views
    }

    /// Centre and radius of each grain that is not in store (mm).
    fn circles(&self) -> impl Iterator<Item = ((f64, f64), f64)> {
        let all = self.grains.iter().flat_map(|arrays| {
            let radii = numbers(arrays, "radius_m").iter().map(|r| 1e3 * r);
            places_mm(arrays).into_iter().zip(radii)
        });
        all.filter(|(_, radius)| *radius > 0.0)
    }

    /// Pressure at which the colours end (Pa): the largest in the continuum; without one, a value that 95 of 100 grains stay
    /// below, as single grains carry many times the mean.
    fn full_pa(&self) -> f64 {
        let of = |set: &Option<Arrays>, name: &str| set.as_ref()?.get(name).cloned();
        if let Some(continuum) = of(&self.continuum, "hydrostatic_pressure_pa") {
            return full_scale(continuum.into_iter().fold(0.0, f64::max));
        }
        let mut grains = of(&self.grains, "pressure_pa").unwrap_or_default();
        grains.sort_by(f64::total_cmp);
        full_scale(grains.get(grains.len() * 95 / 100).copied().unwrap_or(0.0))
    }

    fn draw(&self, views: &[View]) -> Result<String, Error> {
        let full_pa = self.full_pa();
        let mut legend = format!("x (mm); blue to red: pressure 0 to {} MPa", 1e-6 * full_pa);
        if self.grains.is_some() {
            legend.push_str("; outlined dark: glued grains");
        }
        page(views, &legend, |panel, view| {
            if let Some(arrays) = &self.continuum
                && let Some(pressure) = arrays.get("hydrostatic_pressure_pa")
            {
                let colour = |cell: usize| pressure_colour(pressure[cell] / full_pa);
                elements(panel, view, arrays, colour)?;
            }
            let mut grains = self.grains.iter();
            grains.try_for_each(|arrays| disks(panel, view, arrays, full_pa))
        })
    }
}

fn disks(panel: &mut Panel, view: &View, arrays: &Arrays, full_pa: f64) -> Result<(), Error> {
    let (glued, pressure) = (numbers(arrays, "glued"), numbers(arrays, "pressure_pa"));
    let circles = places_mm(arrays)
        .into_iter()
        .zip(numbers(arrays, "radius_m"));
    for (i, (centre, radius)) in circles
        .enumerate()
        .filter(|(_, (at, r))| **r > 0.0 && view.holds(*at))
    {
        let size = (1e3 * radius * view.scale()).round() as i32;
        let edge = if glued.get(i).is_some_and(|glued| *glued > 0.0) {
            BLACK.stroke_width(2)
        } else {
            BLACK.mix(0.6).stroke_width(1)
        };
        let colour = pressure_colour(pressure.get(i).unwrap_or(&0.0) / full_pa);
        disk(panel, centre, size, colour, edge)?;
    }
    Ok(())
}
