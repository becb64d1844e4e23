//! The bodies of a movie: meshes in their places and grains, as they are at the first moment that has them.

use super::fit::{Content, nearest};
use super::mesh::{Mesh, Side};
use super::place::{Place, Row, beside};
use super::record::{Record, Source};
use runs::fields::{Arrays, numbers};
use runs::setup::Setup;

/// A mesh in its place.
#[derive(Debug)]
pub struct MeshBody {
    /// Its fields.
    pub source: Source,
    /// The mesh at rest, in a frame of its own.
    pub mesh: Mesh,
    /// Its place in the picture.
    pub place: Place,
    /// The participant whose grains it carries.
    pub partner: Option<String>,
    /// Places of the elements that are kept.
    pub kept: Vec<usize>,
}

/// Grains.
#[derive(Debug)]
pub struct GrainBody {
    /// Their fields.
    pub source: Source,
    /// The first moment that has them.
    pub first: Arrays,
    /// Places of the grains that are kept.
    pub kept: Vec<usize>,
}

/// All bodies.
#[derive(Debug, Default)]
pub struct Scene {
    /// Meshes whose places are known.
    pub meshes: Vec<MeshBody>,
    /// Grains.
    pub grains: Vec<GrainBody>,
    /// Remarks for the page.
    pub notes: Vec<String>,
}

/// A point of the picture that bears so much.
struct Bearing {
    place: [f64; 2],
    pressure: f64,
}

impl Scene {
    /// The bodies of a run, whole.
    pub fn of(record: &Record, setup: &Setup) -> Scene {
        let mut scene = Scene::default();
        for source in record.sources.iter().filter(|source| source.grains) {
            if let Some(first) = scene.first(record, source) {
                let kept = (0..numbers(&first, "points").len() / 3).collect();
                let source = source.clone();
                scene.grains.push(GrainBody {
                    source,
                    first,
                    kept,
                });
            }
        }
        let meshes: Vec<&Source> = record.sources.iter().filter(|s| !s.grains).collect();
        for source in &meshes {
            scene.add_mesh(record, setup, source, meshes.len() == 1);
        }
        scene
    }

    /// The fields of a participant at the first moment that has them; files that cannot be read are told.
    fn first(&mut self, record: &Record, source: &Source) -> Option<Arrays> {
        for moment in &record.moments {
            match record.read(source, moment) {
                Ok(None) => {}
                Ok(Some(arrays)) => return Some(arrays),
                Err(error) => self.note(error.to_string()),
            }
        }
        None
    }

    /// Adds a remark once.
    pub fn note(&mut self, note: String) {
        if !self.notes.contains(&note) {
            self.notes.push(note);
        }
    }

    fn add_mesh(&mut self, record: &Record, setup: &Setup, source: &Source, only: bool) {
        let name = &source.participant;
        let Some(first) = self.first(record, source) else {
            return;
        };
        let Some(mesh) = Mesh::of(&first) else {
            self.note(format!(
                "`{name}` is not drawn: its cells are no quadrilaterals"
            ));
            return;
        };
        match self.place(&mesh, setup, name, only) {
            Err(why) => self.note(format!("`{name}` is not drawn: it {why}")),
            Ok(place) => {
                let told = place.note.iter().map(|note| format!("`{name}` {note}"));
                self.notes.extend(told);
                let partner = setup.partner(name).map(|joint| joint.partner.to_string());
                self.meshes.push(MeshBody {
                    kept: (0..mesh.quads.len()).collect(),
                    source: source.clone(),
                    partner: partner.filter(|_| place.carries.is_some()),
                    mesh,
                    place,
                });
            }
        }
    }

    fn place(&self, mesh: &Mesh, setup: &Setup, name: &str, only: bool) -> Result<Place, String> {
        let alone = Place {
            up: 0.0,
            carries: None,
            note: None,
        };
        let joint = setup.partner(name);
        let grains = joint.and_then(|joint| {
            let mut all = self.grains.iter();
            all.find(|grains| grains.source.participant == joint.partner)
        });
        match (joint, grains) {
            (Some(joint), Some(grains)) => beside(mesh, &joint, &grains.row()),
            _ if only && self.grains.is_empty() => Ok(alone),
            _ => Err("is joined with no grains that would tell its place".into()),
        }
    }

    /// All there is, in so many frames.
    pub fn content(&self, frames: usize) -> Content {
        let colours = self.grains.iter().map(|grains| grains.colours());
        Content {
            frames,
            elements: self.meshes.iter().map(|body| body.kept.len()).sum(),
            grains: self.grains.iter().map(|grains| grains.kept.len()).sum(),
            colours: colours.max().unwrap_or(0),
        }
    }

    /// Nodes of the outlines of all meshes.
    pub fn outline(&self) -> usize {
        let outlines = self.meshes.iter().map(|body| body.mesh.outline().len());
        outlines.sum()
    }

    /// Keeps the elements and grains nearest to the contact.
    pub fn keep(&mut self, content: &Content, focus: [f64; 2]) {
        let whole = self.content(content.frames);
        let share =
            |part: usize, kept: usize, all: usize| (part * kept).checked_div(all).unwrap_or(0);
        for body in &mut self.meshes {
            let mut centres = body.mesh.centres();
            centres
                .iter_mut()
                .for_each(|centre| centre[1] += body.place.up);
            let count = share(centres.len(), content.elements, whole.elements);
            body.kept = nearest(&centres, focus, count);
        }
        for grains in &mut self.grains {
            let centres = grains.centres();
            let count = share(centres.len(), content.grains, whole.grains);
            grains.kept = nearest(&centres, focus, count);
        }
    }

    /// The middle of what bears at the last moment that can be read, by squares of pressures; the middle of everything where
    /// nothing does.
    pub fn focus(&self, record: &Record) -> [f64; 2] {
        let read = |source: &Source| {
            let mut moments = record.moments.iter().rev();
            moments.find_map(|moment| record.read(source, moment).ok().flatten())
        };
        let mut all = Vec::new();
        for body in &self.meshes {
            let arrays = read(&body.source).unwrap_or_default();
            let pressures = numbers(&arrays, "hydrostatic_pressure_pa");
            for (centre, pressure) in body.mesh.centres().into_iter().zip(pressures) {
                let place = [centre[0], centre[1] + body.place.up];
                all.push(Bearing {
                    place,
                    pressure: *pressure,
                });
            }
        }
        for grains in &self.grains {
            let arrays = read(&grains.source).unwrap_or_default();
            let pressures = numbers(&arrays, "pressure_pa");
            for (place, pressure) in centres(&arrays).into_iter().zip(pressures) {
                all.push(Bearing {
                    place,
                    pressure: *pressure,
                });
            }
        }
        middle(&all)
    }
}

/// Mean place by squares of what is borne, pulls left out.
fn middle(all: &[Bearing]) -> [f64; 2] {
    let mean = |weight: &dyn Fn(&Bearing) -> f64| {
        let sum: f64 = all.iter().map(weight).sum();
        let part = |k: usize| {
            all.iter()
                .map(|one| weight(one) * one.place[k])
                .sum::<f64>()
        };
        (sum > 0.0).then(|| [part(0) / sum, part(1) / sum])
    };
    let borne = mean(&|one| one.pressure.max(0.0).powi(2));
    borne.or_else(|| mean(&|_| 1.0)).unwrap_or_default()
}

/// Places of the points of a file (m).
pub fn centres(arrays: &Arrays) -> Vec<[f64; 2]> {
    let points = numbers(arrays, "points").chunks_exact(3);
    points.map(|p| [p[0], p[1]]).collect()
}

impl GrainBody {
    /// Centres at the first moment (m).
    pub fn centres(&self) -> Vec<[f64; 2]> {
        centres(&self.first)
    }

    /// Marks of the grains under this name; none are set where the file has none.
    pub fn marks(&self, name: &str) -> impl Iterator<Item = bool> {
        let marks = numbers(&self.first, name);
        (0..numbers(&self.first, "points").len() / 3)
            .map(|grain| marks.get(grain).is_some_and(|mark| *mark > 0.0))
    }

    /// Bytes of a grain for colours other than pressure.
    fn colours(&self) -> usize {
        let given = ["velocity_m_per_s", "body", "adhesion"];
        let given = given.iter().filter(|name| self.first.contains_key(**name));
        given.count()
    }

    fn row(&self) -> Row {
        let radii = numbers(&self.first, "radius_m");
        let there = |grain: &usize| radii.get(*grain).is_none_or(|radius| *radius > 0.0);
        let glued: Vec<bool> = self.marks("glued").collect();
        let wheel: Vec<bool> = self.marks("wheel").collect();
        let centres = self.centres();
        let chosen = |wanted: bool| {
            let grains = (0..centres.len()).filter(there);
            let of = grains.filter(|grain| glued[*grain] == wanted && !wheel[*grain]);
            of.map(|grain| centres[grain]).collect()
        };
        Row {
            glued: chosen(true),
            free: chosen(false),
            radius: radii.iter().copied().fold(0.0, f64::max),
        }
    }
}

impl MeshBody {
    /// The line of nodes that carries what lies along it: grains, or the wheel on top.
    pub fn line(&self) -> Vec<u32> {
        self.mesh.side(self.place.carries.unwrap_or(Side::Top))
    }
}
