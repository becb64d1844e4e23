//! Grains and continuum around the contact, coloured by pressure.

use super::units::with_unit;
use super::view::{Panel, View, deformed_mm, elements, frames, maps, middle, places_mm};
use coordinator::error::Error;
use draw::colour::{Scale, full_mpa};
use draw::picture::Picture;
use runs::fields::{Arrays, numbers, read_first};
use runs::files::{Moment, RunFiles};

/// Fields at a moment: those of the first continuum and of the first layer of grains. A second continuum has a frame of its
/// own, in which it may lie where the first one does.
struct Scene {
    continuum: Option<Arrays>,
    grains: Option<Arrays>,
}

/// Most disks that are drawn one by one: more make a page of tens of megabytes, of disks of a pixel or two.
const DISKS_MAX: usize = 20_000;

/// The scene at the first of the moments that has fields: the whole contact and, where a layer of grains is much longer
/// than high, its middle below. `None` where no participant wrote fields.
pub fn contact(run: &RunFiles) -> Result<Option<Picture>, Error> {
    for Moment { name, words } in &run.moments {
        let scene = Scene {
            continuum: read_first(&run.path, name, "vtu")?,
            grains: read_first(&run.path, name, "vtp")?,
        };
        let views = scene.views();
        if !views.is_empty() {
            return Ok(Some(scene.picture(&views, words)));
        }
    }
    Ok(None)
}

impl Scene {
    fn picture(&self, views: &[View], moment: &str) -> Picture {
        let disks = self.circles().count();
        let drawn = disks.min(DISKS_MAX);
        let largest = self.largest_pa();
        let mut what = match (&self.continuum, &self.grains) {
            (Some(_), Some(_)) => {
                "Hydrostatic pressure tr(σ)/3 in the continuum and pressure on the grains"
            }
            (Some(_), None) => "Hydrostatic pressure tr(σ)/3 in the continuum",
            _ => "Pressure on the grains",
        }
        .to_string();
        what += &format!(" at the {moment}, to scale.");
        if self.any("glued") {
            what += " Thick outlines: glued grains.";
        }
        if drawn < disks {
            what += &format!(
                " Every {}th of {disks} grains is drawn.",
                disks.div_ceil(DISKS_MAX)
            );
        }
        let scale = Scale {
            quantity: "pressure (MPa)".into(),
            end: self.full_mpa(),
            below: Some("tension"),
        };
        let frames = frames(views);
        let svg = maps(&frames, Some(&scale), |panel, place| {
            self.paint(panel, &frames[place].view, &scale);
        });
        let alternative = format!(
            "Map of {disks} grains and {} elements; largest pressure in the continuum {}.",
            self.continuum
                .as_ref()
                .map_or(0, |a| numbers(a, "connectivity").len() / 4),
            largest.map_or("none".into(), |pa| with_unit(pa, "Pa")),
        );
        Picture {
            file: "scene.svg".into(),
            caption: what,
            alternative,
            svg,
        }
    }

    fn any(&self, flag: &str) -> bool {
        let of = |arrays: &Arrays| numbers(arrays, flag).iter().any(|flag| *flag > 0.0);
        self.grains.as_ref().is_some_and(of)
    }

    fn largest_pa(&self) -> Option<f64> {
        let values = self.continuum.as_ref()?.get("hydrostatic_pressure_pa")?;
        values.iter().copied().reduce(f64::max)
    }

    /// The grains and as much of the continuum as their pressure reaches; without grains all of it.
    fn views(&self) -> Vec<View> {
        let nodes = self
            .continuum
            .iter()
            .flat_map(deformed_mm)
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
        if let Some(middle) = middle(&layer) {
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

    /// Pressure at which the colours end (MPa): the largest in the continuum; without one, a value that 95 of 100 grains stay
    /// below, as single grains carry many times the mean.
    fn full_mpa(&self) -> f64 {
        let of = |set: &Option<Arrays>, name: &str| set.as_ref()?.get(name).cloned();
        if let Some(continuum) = of(&self.continuum, "hydrostatic_pressure_pa") {
            return full_mpa(continuum.into_iter().fold(0.0, f64::max));
        }
        let mut grains = of(&self.grains, "pressure_pa").unwrap_or_default();
        grains.sort_by(f64::total_cmp);
        full_mpa(grains.get(grains.len() * 95 / 100).copied().unwrap_or(0.0))
    }

    fn paint(&self, panel: &mut Panel, view: &View, scale: &Scale) {
        if let Some(arrays) = &self.continuum
            && let Some(pressure) = arrays.get("hydrostatic_pressure_pa")
        {
            elements(panel, arrays, |cell| scale.colour(1e-6 * pressure[cell]));
        }
        panel.layer();
        if let Some(arrays) = &self.grains {
            disks(panel, view, arrays, scale);
        }
    }
}

fn disks(panel: &mut Panel, view: &View, arrays: &Arrays, scale: &Scale) {
    let (glued, pressure) = (numbers(arrays, "glued"), numbers(arrays, "pressure_pa"));
    let radii = numbers(arrays, "radius_m");
    let circles = places_mm(arrays).into_iter().zip(radii).enumerate();
    let there = circles.filter(|(_, (at, r))| **r > 0.0 && view.holds(*at));
    let stride = radii.len().div_ceil(DISKS_MAX).max(1);
    for (i, (centre, radius)) in there.step_by(stride) {
        let is_glued = glued.get(i).is_some_and(|glued| *glued > 0.0);
        // Outlines of small disks would hide their colours.
        let edge = match (is_glued, panel.pixels(1e3 * radius)) {
            (_, ..2.0) => "",
            (true, _) => " stroke=\"#000\" stroke-width=\"2\"",
            (false, _) => " stroke=\"#555\" stroke-width=\".7\"",
        };
        let colour = scale.colour(1e-6 * pressure.get(i).unwrap_or(&0.0));
        panel.disk(centre, 1e3 * radius, &format!("fill=\"{colour}\"{edge}"));
    }
}
