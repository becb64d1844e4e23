//! Grains and continuum around the contact, coloured by pressure.

use super::mesh::{closer, deformed_mm, draw_elements, points_mm};
use super::movie::mesh::QuadMesh;
use super::movie::position::{JoinedGrains, beside};
use super::movie::track::Track;
use draw::colour::{ColourScale, full_mpa};
use draw::extent::Extent;
use draw::map::{Map, Panel, maps};
use draw::picture::Picture;
use draw::units::with_unit;
use runs::curve::quantile;
use runs::fields::{Arrays, flags, numbers};
use runs::files::{MarkedMoment, RunFiles};
use scenario::error::Error;

/// Fields of the first continuum and of all layers of grains at a moment. A second continuum has its own frame, in which it may have the
/// same position as the first one.
struct Scene {
    continuum: Option<Arrays>,
    /// With the names of their participants.
    grains: Vec<(String, Arrays)>,
    /// Lowest point and radius of the face of the wheel (mm); a flat face has the radius 0.
    wheel: Option<[f64; 3]>,
}

/// Height of the wheel above its lowest point in a map, over the height of the scene.
const WHEEL: f64 = 0.1;
/// Number of pieces of the drawn face.
const PIECES: i32 = 120;

/// Largest number of disks drawn: more disks of a pixel or two make a page of tens of megabytes.
const DISKS_MAX: usize = 20_000;

/// The scene at the first moment that has fields: the whole contact, and below it the middle of a layer of grains that is much longer
/// than high, or one of several layers. `None` if no participant wrote fields.
pub fn contact(run: &RunFiles) -> Result<Option<Picture>, Error> {
    for MarkedMoment { name, words } in run.moments() {
        let mut continua = run.all_fields(&name, ".vtu")?.into_iter();
        let grains = run.all_fields(&name, ".vtp")?;
        let continuum = continua.next();
        let scene = Scene {
            continuum: continuum.map(|(name, arrays)| raised(run, &name, arrays, &grains)),
            grains,
            wheel: wheel_mm(run, &name),
        };
        let shown = scene.shown();
        if !shown.is_empty() {
            return Ok(Some(scene.picture(&shown, &words)));
        }
    }
    Ok(None)
}

/// The face of a smooth wheel at the end of a phase, or of the run: its lowest point and its radius (mm).
fn wheel_mm(run: &RunFiles, moment: &str) -> Option<[f64; 3]> {
    let wheel = run.scenario().wheel?;
    let mut phases = run.list("phases");
    let phase = phases.find(|phase| phase["name"] == moment);
    let time = phase.map_or(run.number("sim_time_s"), |phase| phase["t1_s"].as_f64());
    let at = Track::of(run, Some(&wheel.participant)).at(time?);
    let [x, y] = [0, 1].map(|k| at["wheel"][k].as_f64());
    Some([x?, y?, 1e3 * wheel.radius_m])
}

/// The fields of a continuum. A continuum on top of a layer has its own frame; it is moved to the grains that are glued to it.
fn raised(
    run: &RunFiles,
    name: &str,
    mut continuum: Arrays,
    grains: &[(String, Arrays)],
) -> Arrays {
    let setup = run.scenario();
    let joint = setup.partner(name);
    let on_top = joint.filter(|joint| joint.partner_set == "lid");
    let position = on_top.and_then(|joint| {
        let (_, arrays) = grains.iter().find(|(name, _)| *name == joint.partner)?;
        let mesh = QuadMesh::of(&continuum)?;
        beside(&mesh, &joint, &JoinedGrains::of_fields(arrays)).ok()
    });
    if let (Some(position), Some(points)) = (position, continuum.get_mut("points")) {
        let heights = points.iter_mut().skip(1).step_by(3);
        heights.for_each(|height| *height += position.up);
    }
    continuum
}

impl Scene {
    fn picture(&self, shown: &[Map], moment: &str) -> Picture {
        let disks = self.circles().count();
        let largest = self.largest_pa();
        let what = match (&self.continuum, self.grains.is_empty()) {
            (Some(_), false) => {
                "Hydrostatic pressure -tr(σ)/3 in the continuum and pressure on the grains"
            }
            (Some(_), true) => "Hydrostatic pressure -tr(σ)/3 in the continuum",
            _ => "Pressure on the grains",
        };
        let mut what = format!("{what} at the {moment}, to scale.");
        let glued = |(_, grains): &(String, Arrays)| flags(grains, "glued").contains(&true);
        if self.grains.iter().any(glued) {
            what += " Thick outlines: glued grains.";
        }
        if self.wheel.is_some() {
            what += " Blue: the wheel, down to its face.";
        }
        let stride = disks.div_ceil(DISKS_MAX);
        if stride > 1 {
            what += &format!(" Every {stride}th of {disks} grains is drawn.");
        }
        let scale = ColourScale::new("pressure (MPa)", self.full_mpa(), Some("tension"));
        let svg = maps(shown, Some(&scale), |panel, _| self.draw(panel, &scale));
        let elements = self.continuum.iter();
        let elements: usize = elements.map(|a| numbers(a, "connectivity").len() / 4).sum();
        let largest = largest.map_or("none".into(), |pa| with_unit(pa, "Pa"));
        Picture {
            file: "scene.svg".into(),
            caption: what,
            alternative: format!(
                "Map of {disks} grains and {elements} elements; largest pressure in the continuum {largest}."
            ),
            svg,
        }
    }

    fn largest_pa(&self) -> Option<f64> {
        let values = self.continuum.as_ref()?.get("hydrostatic_pressure_pa")?;
        values.iter().copied().reduce(f64::max)
    }

    /// The grains with the part of the continuum that their pressure reaches; without grains the whole continuum. Below, the middle of a
    /// layer, or one of several layers.
    fn shown(&self) -> Vec<Map> {
        let nodes = self.continuum.iter();
        let nodes = nodes.flat_map(deformed_mm).map(|node| (node, 0.0));
        let Some(all) = Extent::around(nodes.chain(self.circles())) else {
            return Vec::new();
        };
        let edge = 0.02 * all.height();
        let mut all = all.with_margin(0.0, edge, edge);
        if let Some([_, y, _]) = self.wheel {
            all.y[1] = all.y[1].max(y + WHEEL * all.height());
        }
        let Some(layer) = Extent::around(self.circles()) else {
            return vec![Map::to_scale(all, "")];
        };
        let side = 0.02 * layer.width();
        let deep = 0.16 * layer.width();
        // A body above is shown to the same depth as the body below; a rigid wheel needs less.
        let above = self.wheel.map_or(deep, |_| 0.3 * deep);
        let whole = layer.with_margin(side, deep, above).within(&all);
        let mut shown = vec![Map::to_scale(whole, "")];
        let layers = self
            .grains
            .iter()
            .filter_map(|(name, arrays)| Some((name.as_str(), Extent::around(circles(arrays))?)));
        if let Some((part, heading)) = closer(&Vec::from_iter(layers)) {
            let inside = self.circles().filter(|(centre, _)| part.holds(*centre));
            let mut near = Extent::around(inside).unwrap_or(part);
            near = near.with_margin(0.0, 0.5 * near.height(), 0.5 * near.height());
            near.x = part.x;
            shown.push(Map::to_scale(near.within(&all), &heading));
        }
        shown
    }

    fn circles(&self) -> impl Iterator<Item = ([f64; 2], f64)> {
        self.grains.iter().flat_map(|(_, arrays)| circles(arrays))
    }

    /// Pressure at which the colours end (MPa): the largest in the continuum; without a continuum, a value that 95 of 100 grains stay below,
    /// because single grains carry many times the mean.
    fn full_mpa(&self) -> f64 {
        if let Some(largest) = self.largest_pa() {
            return full_mpa(largest.max(0.0));
        }
        let grains = self.grains.iter();
        let grains = grains.flat_map(|(_, arrays)| numbers(arrays, "pressure_pa"));
        full_mpa(quantile(grains.copied().collect(), 0.95).unwrap_or(0.0))
    }

    fn draw(&self, panel: &mut Panel, scale: &ColourScale) {
        if let Some(arrays) = &self.continuum
            && let Some(pressure) = arrays.get("hydrostatic_pressure_pa")
        {
            draw_elements(panel, arrays, |cell| scale.colour(1e-6 * pressure[cell]));
        }
        panel.layer();
        for (_, arrays) in &self.grains {
            let pressure = numbers(arrays, "pressure_pa");
            let colour = |disk: usize| scale.colour(1e-6 * pressure.get(disk).unwrap_or(&0.0));
            disks(panel, arrays, colour);
        }
        if let Some(wheel) = self.wheel {
            panel.layer();
            draw_wheel(panel, wheel);
        }
    }
}

/// Draws the part of the wheel that the map shows, down to its face.
fn draw_wheel(panel: &mut Panel, [x, y, radius]: [f64; 3]) {
    let Extent {
        x: [left, right],
        y: [_, top],
    } = panel.extent();
    let point = |k: i32| {
        let at = left + (right - left) * f64::from(k) / f64::from(PIECES);
        let below = (radius * radius - (at - x).powi(2)).max(0.0).sqrt();
        [at, y + radius - below]
    };
    let mut face: Vec<[f64; 2]> = (0..=PIECES).map(point).collect();
    face.retain(|[at, up]| *up <= top && (radius == 0.0 || (at - x).abs() <= radius));
    let ends = [face.last(), face.first()].map(|end| end.map(|end| [end[0], top]));
    face.extend(ends.into_iter().flatten());
    let style = "fill=\"#cfe3f1\" stroke=\"#0072b2\" stroke-width=\"2\"";
    panel.line(&face, true, style);
}

/// Centre and radius of each grain that is not in store (mm).
pub(super) fn circles(arrays: &Arrays) -> impl Iterator<Item = ([f64; 2], f64)> {
    let radii = numbers(arrays, "radius_m").iter().map(|r| 1e3 * r);
    let all = points_mm(arrays).into_iter().zip(radii);
    all.filter(|(_, radius)| *radius > 0.0)
}

/// Draws the grains that a map shows; `colour` takes the index of a grain.
pub(super) fn disks(panel: &mut Panel, arrays: &Arrays, colour: impl Fn(usize) -> String) {
    let glued = flags(arrays, "glued");
    let radii = numbers(arrays, "radius_m");
    let circles = points_mm(arrays).into_iter().zip(radii).enumerate();
    let there = circles.filter(|(_, (_, radius))| **radius > 0.0);
    let shown: Vec<_> = there.filter(|(_, (at, _))| panel.shows(*at)).collect();
    let stride = radii.len().div_ceil(DISKS_MAX).max(1);
    for (i, (centre, radius)) in shown.into_iter().step_by(stride) {
        // Outlines of small disks would hide their colours.
        let edge = match (glued[i], panel.pixels(1e3 * radius)) {
            (_, ..2.0) => "",
            (true, _) => " stroke=\"#000\" stroke-width=\"2\"",
            (false, _) => " stroke=\"#555\" stroke-width=\".7\"",
        };
        let colour = colour(i);
        panel.disk(centre, 1e3 * radius, &format!("fill=\"{colour}\"{edge}"));
    }
}
