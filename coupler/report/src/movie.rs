//! `movie.html`: a player of grains on the deforming mesh, for all moments at which a run wrote fields.
//!
//! - `fields`: the files and moments of a run;
//! - `mesh`: outline and sides of a mesh; `position`: its position relative to grains; `scene`: all bodies at the first moment;
//! - `fit`: the parts that fit into the page; `shots`: their frames; `range`: ranges of all numbers; `view`: parts of the scene;
//! - `track`: signals; `encode`: numbers as text; `page`: the player with the data in it.

use std::path::Path;

use serde_json::{Value, json};

use fields::{FieldFiles, FieldMoment};
use fit::{Content, FRAMES_MOST, LINES_MOST};
use page::{Movie, PLAYER, Words, page};
use range::{MovieRanges, round_up};
use runs::curve::evenly;
use runs::files::RunFiles;
use runs::scene::Setup;
use scenario::error::{Error, Refusal};
use scene::Scene;
use shots::Shots;
use track::Track;
use view::views;

mod encode;
mod fields;
mod fit;
pub(crate) mod mesh;
mod page;
pub(crate) mod position;
mod range;
mod scene;
mod shots;
pub(crate) mod track;
mod view;

/// Name of the page in a run directory.
const FILE: &str = "movie.html";
/// Largest size of the page (bytes).
const BYTES_MOST: usize = 5_000_000;
/// Room for texts and signals (bytes).
const TEXTS: usize = 150_000;
/// With fewer moments, the page explains how to get more.
const FEW: usize = 12;

/// Writes `movie.html` into a run directory; returns its name, a note on how to get more frames, and an error if a field differs from what the run
/// wrote.
///
/// # Errors
/// The run wrote no fields that can be shown.
pub fn write(run: &Path) -> Result<(String, Option<String>, Option<Error>), Error> {
    let run_files = RunFiles::read_what_is_there(run);
    let html = make(&run_files, BYTES_MOST)?;
    let note = few(&FieldFiles::of(run, &run_files.scenario())?);
    let path = run.join(FILE);
    std::fs::write(&path, html).map_err(Error::output(path.display()))?;
    Ok((FILE.into(), note, run_files.field_damage()))
}

/// The page, of at most `bytes` bytes. The estimate of its size is an upper bound; a second attempt uses the room that is left.
fn make(run: &RunFiles, bytes: usize) -> Result<String, Error> {
    let attempt = |room: usize| Material::of(run)?.page(run, room);
    let mut room = bytes.saturating_sub(PLAYER.len() + TEXTS);
    let mut made = attempt(room)?;
    while made.0.len() > bytes && room > 0 {
        room = if room > 10_000 { room / 10 * 9 } else { 0 };
        made = attempt(room)?;
    }
    let (html, whole) = made;
    let used = html.len() as f64 / bytes as f64;
    if whole || used > 0.9 {
        return Ok(html);
    }
    let (more, _) = attempt((0.97 * room as f64 / used) as usize)?;
    Ok(if more.len() <= bytes { more } else { html })
}

/// Instructions for more frames, if the run wrote few.
fn few(files: &FieldFiles) -> Option<String> {
    let moments = &files.moments;
    let times = moments.iter().filter_map(|moment| moment.time_s);
    let end = times.fold(0.0, f64::max);
    let every = if end > 0.0 { 0.01 * end } else { 5e-5 };
    (moments.len() < FEW).then(|| format!("Moments at which the run wrote fields: {}. For more, run it with --set run.output.fields_every_s={every:.0e}, or another interval.", moments.len()))
}

/// All parts of a run for a movie.
struct Material {
    setup: Setup,
    files: FieldFiles,
    scene: Scene,
    focus: [f64; 2],
}

impl Material {
    fn of(run: &RunFiles) -> Result<Material, Error> {
        let setup = run.scenario();
        let files = FieldFiles::of(&run.path, &setup)?;
        let scene = Scene::of(&files, &setup);
        if scene.meshes.is_empty() && scene.grains.is_empty() {
            let problem = format!("no fields can be shown: {}", scene.notes.join("; "));
            return Err(Refusal::file(&run.path, problem).into());
        }
        let focus = scene.focus(&files);
        Ok(Material {
            setup,
            files,
            scene,
            focus,
        })
    }

    /// The page with as much as fits into `room` bytes of data, and whether it contains everything.
    fn page(mut self, run: &RunFiles, room: usize) -> Result<(String, bool), Error> {
        let whole = self.scene.content(self.files.moments.len());
        let kept = whole.within(room, self.scene.outline());
        let views = views(&self.scene, self.focus, &self.setup);
        self.scene.keep(&kept, self.focus);
        let chosen = evenly(kept.frames, whole.frames);
        let moments: Vec<&FieldMoment> = chosen.iter().map(|k| &self.files.moments[*k]).collect();
        let colours = kept.colours == whole.colours;
        let shots = Shots::of(&self.files, &self.scene, &moments, colours);
        let ranges = MovieRanges::of(&shots);
        let track = Track::of(run, self.setup.wheel_of.as_ref());
        let words = self.words(run, &[whole, kept], &shots, &ranges);
        let more = json!({
            "frames": moments.iter().map(|moment| frame(moment, &track)).collect::<Vec<Value>>(),
            "strip": track.strip(),
            "wheel": self.setup.wheel.as_ref().map(|wheel| json!([wheel.participant, 1e3 * wheel.radius_m])),
            "views": views.iter().map(|view| view.json()).collect::<Vec<Value>>(),
        });
        let html = page(&Movie {
            scene: &self.scene,
            shots: &shots,
            ranges: &ranges,
            words: &words,
            more,
        });
        Ok((html, kept == whole))
    }

    fn words(
        &self,
        run: &RunFiles,
        content: &[Content; 2],
        shots: &Shots,
        ranges: &MovieRanges,
    ) -> Words {
        let [whole, kept] = content;
        let mut notes = self.scene.notes.clone();
        notes.extend(shots.notes.iter().cloned());
        notes.extend(dropped(whole, kept));
        notes.extend(few(&self.files));
        let mut moments = self.files.moments.iter();
        if moments.any(|moment| moment.time_s.is_none()) {
            notes.push("The run did not record the times of its fields: frames are in the order in which their files were written.".into());
        }
        notes.push(accuracy(&self.scene, ranges));
        let title = match self.setup.name.as_str() {
            "" => run.path.display().to_string(),
            name => name.into(),
        };
        Words {
            title,
            status: status(run),
            description: self.description(kept, ranges),
            notes,
        }
    }

    /// The picture in words.
    fn description(&self, kept: &Content, ranges: &MovieRanges) -> String {
        let meshes = self.scene.meshes.iter().map(|body| {
            let (name, elements) = (&body.source.participant, body.mesh.quads.len());
            format!("`{name}`, a mesh of {elements} elements")
        });
        let grains = self.scene.grains.iter().map(|grains| {
            let (name, count) = (&grains.source.participant, grains.centres().len());
            format!("`{name}`, {count} grains")
        });
        let bodies: Vec<String> = meshes.chain(grains).collect();
        let ends = [self.files.moments.first(), self.files.moments.last()];
        let ends = ends.map(|moment| moment.and_then(|moment| moment.time_s));
        let span = match ends {
            [Some(from), Some(to)] => {
                format!(" from t = {:.4} ms to {:.4} ms", 1e3 * from, 1e3 * to)
            }
            _ => String::new(),
        };
        let [low, high] = ranges.pressure_pa.map(|pressure| 1e-6 * pressure);
        let (frames, bodies) = (kept.frames, bodies.join("; "));
        format!(
            "Animation of {frames} frames{span}: {bodies}, coloured by pressure from {low} to {high} MPa, with displacements to scale until the slider enlarges them."
        )
    }
}

/// A frame for the page, without bodies.
fn frame(moment: &FieldMoment, track: &Track) -> Value {
    let inside = moment.name.rsplit_once('-');
    let inside = inside.filter(|(_, number)| number.bytes().all(|digit| digit.is_ascii_digit()));
    json!({
        "name": moment.name,
        "phase": inside.map_or(moment.name.as_str(), |(phase, _)| phase),
        "t_ms": moment.time_s.map(|time_s| 1e3 * time_s),
        "signals": moment.time_s.map(|time_s| track.at(time_s)),
    })
}

/// Notes on the parts that the page leaves out because of its size.
fn dropped(whole: &Content, kept: &Content) -> Vec<String> {
    let size = BYTES_MOST / 1_000_000;
    let because = format!("so that the page stays below {size} MB");
    let mut notes = Vec::new();
    let mut note = |kept: usize, whole: usize, what: &str, more: &str| {
        if kept < whole {
            notes.push(format!("{kept} of {whole} {what}, {because}{more}."));
        }
    };
    let minute = if whole.frames > FRAMES_MOST {
        " and plays in a minute"
    } else {
        ""
    };
    let elements = "elements are drawn, those nearest to the contact, and the outline";
    let grains = "grains are drawn, those nearest to the contact";
    let moments = "moments are shown, evenly chosen";
    note(kept.frames, whole.frames, moments, minute);
    note(kept.elements, whole.elements, elements, "");
    note(kept.grains, whole.grains, grains, "");
    if kept.colours < whole.colours {
        let at = usize::from(kept.frames < whole.frames);
        let note = format!("Grains have no colours but pressure, {because}.");
        notes.insert(at, note);
    }
    notes
}

/// Accuracy of the numbers on the page.
fn accuracy(scene: &Scene, ranges: &MovieRanges) -> String {
    let half = |range: [f64; 2], codes: f64| 0.5 * (range[1] - range[0]) / codes;
    let nm = |ranges: [[f64; 2]; 2]| {
        let of = ranges.map(|range| half(range, 65_534.0));
        1e9 * of[0].max(of[1])
    };
    let mut parts = Vec::new();
    if !scene.meshes.is_empty() {
        let nm = round_up(nm(ranges.displacement));
        parts.push(format!("displacements of nodes by up to {nm} nm"));
    }
    if !scene.grains.is_empty() {
        let nm = round_up(nm(ranges.position));
        parts.push(format!("centres of grains by up to {nm} nm"));
    }
    let mpa = round_up(1e-6 * half(ranges.pressure_pa, 254.0));
    parts.push(format!("pressures by up to {mpa} MPa"));
    let mut text = format!(
        "Numbers are rounded for the page: {}. Pressures beyond the scale have the colours of its ends.",
        parts.join(", ")
    );
    if !scene.grains.is_empty() {
        text += &format!(
            " Contact forces are the strongest {LINES_MOST} between grains of a frame, those below 1 % of its largest left out."
        );
    }
    text + " Nothing is interpolated between moments."
}

/// The end of the run in words.
fn status(run: &RunFiles) -> String {
    match run.text("status") {
        "" => "The run has no readable summary.json: it was killed, or still runs.".into(),
        status => format!("Status of the run: {status}. {}", run.text("message")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use kit::scratch::Scratch;

    /// Fields of `count` grains on a lattice at two moments, each pressed on its neighbour.
    fn run(purpose: &str, count: usize) -> Scratch {
        let scratch = Scratch::new(purpose, 1);
        let fields = scratch.path().join("fields");
        std::fs::create_dir_all(&fields).expect("a folder");
        let all = |of: &dyn Fn(usize) -> String| (0..count).map(of).collect::<String>();
        let array = |name: &str, values: String| {
            format!(
                "<DataArray type=\"Float64\" Name=\"{name}\" format=\"ascii\">{values}</DataArray>"
            )
        };
        let lines = |of: &dyn Fn(usize) -> String| (0..count - 1).map(of).collect::<String>();
        let text = [
            array(
                "points",
                all(&|k| format!("{}e-4 {}e-4 0 ", k % 300, k / 300)),
            ),
            array("radius_m", all(&|_| "5e-5 ".into())),
            array("velocity_m_per_s", all(&|_| "0 1 0 ".into())),
            array("pressure_pa", all(&|k| format!("{k} "))),
            "</VTKFile>".into(),
        ];
        let contacts = [
            array("connectivity", lines(&|k| format!("{k} {} ", k + 1))),
            array("force_n", lines(&|k| format!("{k} 0 "))),
            "</VTKFile>".into(),
        ];
        let mut collection = String::new();
        for (moment, time_s) in [("hold", 1), ("end", 2)] {
            let file = format!("rail-{moment}.vtp");
            std::fs::write(fields.join(&file), text.concat()).expect("a file");
            let file_of_contacts = format!("rail-{moment}-contacts.vtp");
            std::fs::write(fields.join(file_of_contacts), contacts.concat()).expect("a file");
            collection += &format!("<DataSet timestep=\"{time_s}\" file=\"{file}\"/>");
        }
        std::fs::write(fields.join("rail.pvd"), collection).expect("a file");
        scratch
    }

    #[test]
    fn as_many_grains_as_the_largest_scene_has_fit() {
        let run = run("movie-many", 73_823);
        let html =
            make(&RunFiles::read_what_is_there(run.path()), BYTES_MOST).expect("it has fields");
        assert!(html.len() <= BYTES_MOST);
        assert!(html.contains("73823 grains") && !html.contains("grains are drawn"));
    }

    #[test]
    fn a_page_is_never_larger_and_names_what_it_leaves_out() {
        let run = run("movie-bound", 20_000);
        let html = make(&RunFiles::read_what_is_there(run.path()), 300_000).expect("it has fields");
        assert!((200_000..=300_000).contains(&html.len()), "{}", html.len());
        assert!(html.contains("of 20000 grains are drawn, those nearest to the contact"));
        assert!(html.contains("no colours but pressure"));
    }
}
