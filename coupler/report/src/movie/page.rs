//! The page of a movie: the player with its data.

use serde_json::{Value, json};

use super::encode::{Codes, base64, whole};
use super::range::{MovieRanges, of};
use super::scene::{GrainBody, MeshBody, Scene};
use super::shots::{GrainShot, MeshShot, Over, Shots};
use draw::svg::escape;
use runs::fields::flags;

/// The player, with placeholders for texts and data.
pub const PLAYER: &str = include_str!("player.html");

/// Content of a page.
#[derive(Debug)]
pub struct Movie<'a> {
    /// The bodies.
    pub scene: &'a Scene,
    /// Their frames.
    pub shots: &'a Shots,
    /// Ranges of the numbers.
    pub ranges: &'a MovieRanges,
    /// Texts.
    pub words: &'a Words,
    /// Wheel, signals and the rest that needs no codes, under the player's names.
    pub more: Value,
}

/// Texts of a page.
#[derive(Clone, Debug, Default)]
pub struct Words {
    /// Name of the scenario.
    pub title: String,
    /// Status and message of the run.
    pub status: String,
    /// Description of the picture for readers who cannot see it.
    pub description: String,
    /// Notes on omitted parts, and other remarks.
    pub notes: Vec<String>,
}

/// The whole page.
pub fn page(movie: &Movie) -> String {
    let words = movie.words;
    let notes = words.notes.iter();
    let notes = notes.map(|note| format!("<li>{}</li>", escape(note)));
    let parts = [
        ("TITLE", escape(&words.title)),
        ("STATUS", escape(&words.status)),
        ("DESCRIPTION", escape(&words.description)),
        ("NOTES", notes.collect()),
        // No text can end the script element.
        ("DATA", data(movie).to_string().replace('<', "\\u003c")),
    ];
    let mut html = String::new();
    // A single pass, so that text from a scenario is never taken for a placeholder.
    for (number, part) in PLAYER.split("@@").enumerate() {
        let mut parts = parts.iter();
        let value = parts.find(|(name, _)| number % 2 == 1 && *name == part);
        html.push_str(value.map_or(part, |(_, value)| value));
    }
    html
}

fn data(movie: &Movie) -> Value {
    let (scene, shots) = (movie.scene, movie.shots);
    let meshes = scene.meshes.iter().zip(&shots.meshes);
    let grains = scene.grains.iter().zip(&shots.grains);
    json!({
        "meshes": meshes.map(|(body, over)| mesh(body, over, movie)).collect::<Vec<Value>>(),
        "grains": grains.map(|(body, over)| disks(body, over, movie)).collect::<Vec<Value>>(),
        "pressure_mpa": movie.ranges.pressure().json(1e-6),
        "speed_m_per_s": movie.ranges.speed().json(1.0),
        "force_n": movie.ranges.force().json(1.0),
        "more": movie.more,
    })
}

fn mesh(body: &MeshBody, over: &Over<MeshShot>, movie: &Movie) -> Value {
    let nodes = body.kept_nodes();
    let index = |node: u32| nodes.binary_search(&node).map_or(u32::MAX, |k| k as u32);
    let numbers = |all: &mut dyn Iterator<Item = u32>| whole(all.map(index));
    let at = |k: usize| {
        let up = if k == 1 { body.position.up } else { 0.0 };
        let place = |node: &u32| body.mesh.nodes[*node as usize][k] + up;
        let values = || nodes.iter().map(place);
        let scale = Codes::fine(of(values()));
        json!([scale.json(1e3), scale.encode(values())])
    };
    let u = [0, 1].map(|k| Codes::fine(movie.ranges.displacement[k]));
    let pressure = movie.ranges.pressure();
    let frame = |shot: &MeshShot| {
        let [x, y] = [0, 1].map(|k| u[k].encode(shot.u[k].iter().copied()));
        json!([x, y, pressure.encode(shot.pressure.iter().copied())])
    };
    json!({
        "name": body.source.participant,
        "x": at(0), "y": at(1),
        "u": u.map(|scale| scale.json(1e3)),
        "quads": numbers(&mut body.kept.iter().flat_map(|quad| body.mesh.quads[*quad])),
        "outline": numbers(&mut body.mesh.outline().into_iter().flatten()),
        "line": numbers(&mut body.line().into_iter()),
        "carries": body.partner,
        "frames": over.iter().map(|shot| shot.as_ref().map(frame)).collect::<Vec<_>>(),
    })
}

fn disks(body: &GrainBody, over: &Over<GrainShot>, movie: &Movie) -> Value {
    let ranges = movie.ranges;
    let at = [0, 1].map(|k| Codes::fine(ranges.position[k]));
    let radius = Codes::fine([0.0, ranges.radius_m]);
    let kept = |name: &str| {
        let marks = flags(&body.first, name);
        base64(body.kept.iter().map(|grain| u8::from(marks[*grain])))
    };
    let first = over.iter().flatten().next();
    let still = first.map_or(&[][..], |shot| &shot.radius);
    let frame = |shot: &GrainShot| frame(shot, still, [at[0], at[1], radius], ranges);
    json!({
        "name": body.source.participant,
        "at": at.map(|scale| scale.json(1e3)),
        "radius": [radius.json(1e3), radius.encode(still.iter().copied())],
        "glued": kept("glued"), "wheel": kept("wheel"),
        "frames": over.iter().map(|shot| shot.as_ref().map(frame)).collect::<Vec<_>>(),
    })
}

fn frame(
    shot: &GrainShot,
    still: &[f64],
    [x, y, radius]: [Codes; 3],
    ranges: &MovieRanges,
) -> Value {
    let coded = |scale: Codes, values: &[f64]| scale.encode(values.iter().copied());
    let given = |scale: Codes, values: &Option<Vec<f64>>| {
        values.as_ref().map(|values| coded(scale, values))
    };
    let unit = Codes::coarse([0.0, 254.0]);
    json!({
        "x": coded(x, &shot.centre[0]), "y": coded(y, &shot.centre[1]),
        "p": coded(ranges.pressure(), &shot.pressure),
        "v": given(ranges.speed(), &shot.speed),
        "b": given(unit, &shot.body),
        "a": given(Codes::coarse([0.0, 1.0]), &shot.adhesion),
        // Each frame has the radii of growing grains; constant radii are in `radius`.
        "r": (shot.radius != still).then(|| coded(radius, &shot.radius)),
        "ends": whole(shot.lines.iter().flat_map(|line| line.ends)),
        "f": ranges.force().encode(shot.lines.iter().map(|line| line.force)),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A page without bodies whose texts are all hostile.
    fn hostile() -> String {
        let hostile = "</script><script>alert(1)</script>@@DATA@@\"><img src=x>".to_string();
        let words = Words {
            title: hostile.clone(),
            status: hostile.clone(),
            description: hostile.clone(),
            notes: vec![hostile.clone()],
        };
        page(&Movie {
            scene: &Scene::default(),
            shots: &Shots::default(),
            ranges: &MovieRanges::default(),
            words: &words,
            more: json!({ "frames": [hostile] }),
        })
    }

    #[test]
    fn no_text_of_a_scenario_becomes_a_part_of_the_page() {
        let (page, own) = (hostile(), PLAYER);
        for tag in ["<script", "</script", "<img", "<li"] {
            let extra = usize::from(tag == "<li");
            let [there, expected] = [&page[..], own].map(|text| text.matches(tag).count());
            assert_eq!(there, expected + extra, "{tag}");
        }
        assert!(!page.contains("alert(1)</script"));
        // Placeholders within texts stay unchanged.
        assert_eq!(page.matches("@@DATA@@").count(), 7);
    }

    #[test]
    fn the_player_loads_nothing_from_elsewhere() {
        for word in ["http:", "https:", " src=", "@import", "url(", "fetch("] {
            assert!(!PLAYER.contains(word), "{word}");
        }
        assert_eq!(PLAYER.matches("@@").count() % 2, 0);
    }

    #[test]
    fn the_colours_of_the_player_darken_from_end_to_end() {
        let stops = PLAYER
            .split_once("const STOPS = [")
            .expect("it has colours")
            .1;
        let stops = stops.split_once(']').expect("the list ends").0;
        let colours: Vec<&str> = stops.split('"').skip(1).step_by(2).collect();
        let lightness = |colour: &&str| {
            let part =
                |k: usize| u8::from_str_radix(&colour[k..k + 2], 16).expect("it is a colour");
            let linear = |k: usize| (f64::from(part(k)) / 255.0).powf(2.2);
            0.2126 * linear(1) + 0.7152 * linear(3) + 0.0722 * linear(5)
        };
        let all: Vec<f64> = colours.iter().map(lightness).collect();
        assert!(all.len() >= 6, "{colours:?}");
        assert!(all.windows(2).all(|two| two[0] > two[1]), "{all:?}");
    }
}
