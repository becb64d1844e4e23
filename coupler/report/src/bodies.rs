//! First and third body: the grains in the colours of their bodies, at the first marked moment and at the end, and the surface that
//! carries debris.

use super::mesh::points_mm;
use super::scene::{circles, disks};
use draw::extent::Extent;
use draw::map::{Map, maps_of_kinds};
use draw::picture::Picture;
use runs::fields::{Arrays, numbers};
use runs::files::RunFiles;
use scenario::error::Error;

/// Colour and words of each body by its number in the fields: attached grains are light, detached ones dark.
const BODIES: [[&str; 2]; 4] = [
    ["#f0ead8", "first body"],
    ["#12355b", "third body, detached"],
    ["#e27d1e", "third body from the start"],
    ["#aabed2", "third body, fed in"],
];

/// The grains in the colours of their bodies at the first moment that has them and, if they have moved since, at the last. `None` if the
/// run does not follow flows.
pub(super) fn first_and_third(run: &RunFiles) -> Result<Option<Picture>, Error> {
    // Words, grains, and ends of the segments of surfaces (mm).
    let mut shown: Vec<(String, Arrays, Vec<[f64; 2]>)> = Vec::new();
    for moment in run.moments() {
        let arrays = run.fields(&moment.name, ".vtp")?;
        if let Some(arrays) = arrays.filter(|arrays| arrays.contains_key("body")) {
            let surface = run.fields(&moment.name, "-surface.vtp")?;
            let surface = surface.as_ref().map_or(Vec::new(), points_mm);
            shown.truncate(1);
            shown.push((moment.words, arrays, surface));
        }
    }
    shown.dedup_by(|last, first| last.1["points"] == first.1["points"]);
    let layer = shown.first();
    let layer = layer.map(|(_, arrays, _)| Extent::around(circles(arrays)));
    let Some(layer) = layer.flatten() else {
        return Ok(None);
    };
    // Grains thrown far away would make the others too small to see.
    let height = layer.height();
    let mut extent = layer.with_margin(height, 0.1 * height, 0.4 * height);
    // Grains on the surface beside the layer widen the map.
    if let Some((_, last, surface)) = shown.last()
        && let Some(surface) = Extent::around(surface.iter().map(|point| (*point, 0.0)))
    {
        let over_it = surface.with_margin(0.0, 0.0, height);
        let lying = circles(last).filter(|(centre, _)| over_it.holds(*centre));
        let corners = [0, 1].map(|end| ([extent.x[end], extent.y[end]], 0.0));
        extent = Extent::around(lying.chain(corners)).unwrap_or(extent);
    }
    let maps = shown.iter();
    let maps = maps.map(|(words, ..)| Map::to_scale(extent, &format!("At the {words}")));
    let svg = maps_of_kinds(&Vec::from_iter(maps), &BODIES, |panel, number| {
        let (_, arrays, surface) = &shown[number];
        for segment in surface.chunks_exact(2) {
            panel.line(segment, false, "stroke=\"#000\" fill=\"none\"");
        }
        disks(panel, arrays, |disk| BODIES[body(arrays, disk)][0].into());
    });
    let each = shown.iter().map(|(words, arrays, _)| {
        let radii = numbers(arrays, "radius_m").iter().enumerate();
        let there = radii.filter(|(_, radius)| **radius > 0.0);
        let bodies: Vec<usize> = there.map(|(disk, _)| body(arrays, disk)).collect();
        let third = bodies.iter().filter(|body| **body > 0).count();
        let all = bodies.len();
        format!("At the {words} {third} of {all} grains are third body.")
    });
    let moments = shown.iter().map(|(words, ..)| format!("at the {words}"));
    Ok(Some(Picture {
        file: "bodies.svg".into(),
        caption: format!(
            "First and third body {}, to scale. Thick outlines: glued grains. Lines: bare surfaces. Grains beyond the layer's ends by more than its height are drawn only if they lie on a surface.",
            Vec::from_iter(moments).join(" and ")
        ),
        alternative: Vec::from_iter(each).join(" "),
        svg,
    }))
}

/// The body of a grain.
fn body(arrays: &Arrays, disk: usize) -> usize {
    let body = numbers(arrays, "body").get(disk);
    body.map_or(0, |body| (*body as usize).min(BODIES.len() - 1))
}

#[cfg(test)]
mod tests {
    use super::*;
    use kit::scratch::Scratch;
    use serde_json::json;

    /// Three grains, of which the last is in store, in a file of a moment.
    fn write(run: &RunFiles, moment: &str, x: f64, bodies: Option<&str>) {
        let bodies = bodies.map_or(String::new(), |words| {
            format!(
                "<DataArray type=\"Float64\" Name=\"body\" format=\"ascii\">{words}</DataArray>"
            )
        });
        let text = format!(
            "<VTKFile type=\"PolyData\"><PolyData><Piece><Points><DataArray type=\"Float64\" Name=\"points\" NumberOfComponents=\"3\" format=\"ascii\">{x} 0 0 1e-3 0 0 0 0 0</DataArray></Points><PointData><DataArray type=\"Float64\" Name=\"radius_m\" format=\"ascii\">1e-4 1e-4 0</DataArray>{bodies}</PointData></Piece></PolyData></VTKFile>"
        );
        let folder = run.path.join("fields");
        std::fs::create_dir_all(&folder).expect("a folder");
        std::fs::write(folder.join(format!("layer-{moment}.vtp")), text).expect("a file");
    }

    fn run(scratch: &Scratch) -> RunFiles {
        RunFiles {
            path: scratch.path().into(),
            summary: json!({"phases": [{"name": "hold", "picture": true}]}),
            ..RunFiles::default()
        }
    }

    #[test]
    fn grains_have_the_colours_of_their_bodies_at_the_hold_and_at_the_end() {
        let scratch = Scratch::new("bodies", 1);
        let run = run(&scratch);
        write(&run, "hold", 0.0, Some("0 0 3"));
        write(&run, "end", 0.1, Some("1 2 3"));
        let picture = first_and_third(&run).expect("it is readable");
        let picture = picture.expect("there are bodies");
        assert_eq!(
            picture.alternative,
            "At the end of the hold 0 of 2 grains are third body. At the end of the run 2 of 2 grains are third body."
        );
        for words in ["At the end of the hold<", "At the end of the run<"] {
            assert!(picture.svg.contains(words), "{words}");
        }
        // In the legend and as a grain, except the one far away; the one in store is only in the legend.
        for ([colour, words], times) in BODIES.iter().zip([2, 1, 2, 1]) {
            let style = format!("fill=\"{colour}\"");
            assert_eq!(picture.svg.matches(&style).count(), times, "{words}");
        }
    }

    #[test]
    fn grains_on_the_surface_beside_the_layer_are_drawn_with_it() {
        let scratch = Scratch::new("bodies-surface", 1);
        let run = run(&scratch);
        write(&run, "hold", 0.0, Some("0 0 3"));
        write(&run, "end", 0.1, Some("1 2 3"));
        let surface = "<VTKFile type=\"PolyData\"><PolyData><Piece><Points><DataArray type=\"Float64\" Name=\"points\" NumberOfComponents=\"3\" format=\"ascii\">0 -1e-4 0 0.2 -1e-4 0</DataArray></Points></Piece></PolyData></VTKFile>";
        for moment in ["hold", "end"] {
            let path = run.path.join(format!("fields/layer-{moment}-surface.vtp"));
            std::fs::write(path, surface).expect("a file");
        }
        let picture = first_and_third(&run).expect("it is readable");
        let svg = picture.expect("there are bodies").svg;
        for ([colour, words], times) in BODIES.iter().zip([2, 2, 2, 1]) {
            let style = format!("fill=\"{colour}\"");
            assert_eq!(svg.matches(&style).count(), times, "{words}");
        }
        assert_eq!(svg.matches("stroke=\"#000\" fill=\"none\"").count(), 2);
    }

    #[test]
    fn a_run_that_ends_with_the_hold_has_one_map_and_one_without_flows_none() {
        let scratch = Scratch::new("bodies-once", 1);
        let run = run(&scratch);
        write(&run, "hold", 0.0, None);
        write(&run, "end", 0.0, None);
        assert!(first_and_third(&run).expect("it is readable").is_none());
        write(&run, "hold", 0.0, Some("0 1 0"));
        write(&run, "end", 0.0, Some("0 1 0"));
        let picture = first_and_third(&run).expect("it is readable");
        let picture = picture.expect("there are bodies");
        assert_eq!(picture.svg.matches("At the end of").count(), 1);
    }
}
