//! Force chains: contacts and bonds of the grains as lines whose widths are their forces, and the adhesion of bonds.

use super::mesh::{closer, points_mm};
use draw::colour::ColourScale;
use draw::extent::Extent;
use draw::map::{Map, Panel, maps};
use draw::picture::Picture;
use draw::units::with_unit;
use runs::fields::{Arrays, numbers};
use runs::files::{MarkedMoment, RunFiles};
use scenario::error::Error;

/// Largest number of contacts drawn; beyond it only the strongest are.
const LINES_MAX: usize = 20_000;
/// Width of the widest lines (pixels).
const WIDEST: f64 = 5.0;
/// Share of the lines that are narrower.
const SHOWN: f64 = 0.99;
/// Number of classes of width: the lines of a class are one path of the file.
const CLASSES: f64 = 16.0;

/// A contact or bond.
struct Link {
    ends: [[f64; 2]; 2],
    /// Normal force, compression positive (N).
    force: f64,
    adhesion: Option<f64>,
}

impl Link {
    fn draw(&self, panel: &mut Panel, style: &str) {
        if self.ends.iter().any(|end| panel.shows(*end)) {
            panel.line(&self.ends, false, style);
        }
    }
}

/// Forces, and adhesion where there are bonds, at the first moment that has grains in contact.
pub fn chains(run: &RunFiles) -> Result<Vec<Picture>, Error> {
    for MarkedMoment { name, words } in run.moments() {
        let layers = run.all_fields(&name, "-contacts.vtp")?;
        let layers = layers.iter().map(|(name, of)| (name.as_str(), links(of)));
        let layers: Vec<(&str, Vec<Link>)> = layers.collect();
        let extents = layers.iter();
        let extents = extents.filter_map(|(name, links)| Some((*name, around(links)?)));
        let extents: Vec<(&str, Extent)> = extents.collect();
        let links: Vec<Link> = layers.into_iter().flat_map(|(_, links)| links).collect();
        let Some(extent) = around(&links) else {
            continue;
        };
        let mut shown = vec![Map::to_scale(extent, "")];
        let closer = closer(&extents);
        shown.extend(closer.map(|(part, heading)| Map::to_scale(part, &heading)));
        let mut pictures = Vec::from_iter(forces(&links, &shown, &words));
        pictures.extend(adhesion(&links, &shown, &words));
        return Ok(pictures);
    }
    Ok(Vec::new())
}

/// The lines of a file of contacts.
fn links(arrays: &Arrays) -> Vec<Link> {
    let (ends, points) = (numbers(arrays, "connectivity"), points_mm(arrays));
    let (forces, adhesion) = (numbers(arrays, "force_n"), numbers(arrays, "adhesion"));
    let link = |(k, pair): (usize, &[f64])| {
        let [a, b] = [pair[0], pair[1]].map(|point| points.get(point as usize).copied());
        Some(Link {
            ends: [a?, b?],
            force: *forces.get(2 * k)?,
            adhesion: adhesion.get(k).copied(),
        })
    };
    let all = ends.chunks_exact(2).enumerate();
    all.filter_map(link).collect()
}

fn around(links: &[Link]) -> Option<Extent> {
    let links = links.iter();
    let ends = links.flat_map(|link| link.ends).map(|end| (end, 0.0));
    let extent = Extent::around(ends)?;
    let margin = 0.01 * extent.width().max(extent.height());
    (margin > 0.0).then(|| extent.with_margin(margin, margin, margin))
}

/// Compression as dark lines, tension as light and dashed lines.
fn forces(links: &[Link], shown: &[Map], words: &str) -> Option<Picture> {
    let sizes = links.iter().map(|link| link.force.abs());
    let mut sizes: Vec<f64> = sizes.filter(|f| *f > 0.0).collect();
    sizes.sort_by(f64::total_cmp);
    let full = *sizes.get((SHOWN * (sizes.len().max(1) - 1) as f64) as usize)?;
    let least = sizes[sizes.len().saturating_sub(LINES_MAX)];
    let drawn = links.iter();
    let drawn: Vec<&Link> = drawn.filter(|link| link.force.abs() >= least).collect();
    let svg = maps(shown, None, |panel, _| {
        for tension in [true, false] {
            panel.layer();
            for link in drawn.iter().filter(|link| (link.force < 0.0) == tension) {
                stroke(panel, link, full);
            }
        }
    });
    let tension = links.iter().filter(|link| link.force < 0.0).count();
    let mut caption = format!(
        "Force chains at the {words}: lines between the centres of grains, with the normal force as width; the widest stand for {} and more.",
        with_unit(full, "N")
    );
    if tension > 0 {
        caption += " Orange and dashed: tension in bonds.";
    }
    let (drawn, all) = (drawn.len(), links.len());
    if drawn < all {
        caption += &format!(" The strongest {drawn} of {all} are drawn.");
    }
    Some(Picture {
        file: "chains.svg".into(),
        caption,
        alternative: format!("{all} contacts and bonds, {tension} in tension."),
        svg,
    })
}

fn stroke(panel: &mut Panel, link: &Link, full: f64) {
    let share = (link.force.abs() / full).min(1.0);
    let width = WIDEST * ((share * CLASSES).ceil() / CLASSES);
    let line = if link.force < 0.0 {
        "stroke=\"#e27d1e\" stroke-dasharray=\"3 2\""
    } else {
        "stroke=\"#12355b\" stroke-linecap=\"round\""
    };
    let style = format!("fill=\"none\" {line} stroke-width=\"{width:.2}\"");
    link.draw(panel, &style);
}

/// Intensity of adhesion of the bonds.
fn adhesion(links: &[Link], shown: &[Map], words: &str) -> Option<Picture> {
    let bonds = links.iter().filter_map(|link| Some((link, link.adhesion?)));
    let bonds: Vec<(&Link, f64)> = bonds.collect();
    let whole = bonds.iter().filter(|(_, adhesion)| *adhesion > 0.0).count();
    if whole == 0 {
        return None;
    }
    let scale = ColourScale::new("intensity of adhesion", 1.0, None);
    let stride = bonds.len().div_ceil(LINES_MAX).max(1);
    let svg = maps(shown, Some(&scale), |panel, _| {
        let held = bonds.iter().filter(|(_, adhesion)| *adhesion > 0.0);
        for (link, adhesion) in held.step_by(stride) {
            let colour = scale.colour(*adhesion);
            let style = format!("fill=\"none\" stroke=\"{colour}\" stroke-width=\"1.6\"");
            link.draw(panel, &style);
        }
    });
    let all = bonds.len();
    let mean = bonds.iter().map(|(_, adhesion)| adhesion).sum::<f64>() / all as f64;
    let every = match stride {
        1 => String::new(),
        _ => format!(" Every {stride}th is drawn."),
    };
    Some(Picture {
        file: "adhesion.svg".into(),
        caption: format!(
            "Bonds at the {words} by their intensity of adhesion: 1 is whole, 0 is broken.{every}"
        ),
        alternative: format!("{whole} bonds with adhesion, mean over {all} links {mean:.3}."),
        svg,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_have_their_forces_and_adhesion() {
        let mut arrays = Arrays::new();
        let points = vec![0.0, 0.0, 0.0, 1e-3, 0.0, 0.0, 2e-3, 1e-3, 0.0];
        arrays.insert("points".into(), points);
        arrays.insert("connectivity".into(), vec![0.0, 1.0, 1.0, 2.0]);
        arrays.insert("force_n".into(), vec![5.0, 1.0, -2.0, 0.5]);
        arrays.insert("adhesion".into(), vec![0.0, 0.75]);
        let links = links(&arrays);
        let read: Vec<(f64, Option<f64>)> = links
            .iter()
            .map(|link| (link.force, link.adhesion))
            .collect();
        assert_eq!(read, [(5.0, Some(0.0)), (-2.0, Some(0.75))]);
        assert_eq!(links[1].ends, [[1.0, 0.0], [2.0, 1.0]]);
        let extent = around(&links).expect("it has an extent");
        let shown = [Map::to_scale(extent, "")];
        let picture = forces(&links, &shown, "end of the hold").expect("there are forces");
        assert!(
            picture
                .alternative
                .contains("2 contacts and bonds, 1 in tension")
        );
        assert!(picture.svg.contains("#e27d1e") && picture.svg.contains("#12355b"));
    }
}
