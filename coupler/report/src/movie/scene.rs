//! The bodies of a movie: meshes in their positions and grains, at the first moment that has them.

use super::fields::{FieldFiles, FieldSource};
use super::fit::{Content, nearest};
use super::mesh::{MeshSide, QuadMesh};
use super::position::{JoinedGrains, MeshPosition, beside};
use runs::fields::{Arrays, numbers, points};
use runs::scene::Setup;

/// A mesh in its position.
#[derive(Debug)]
pub struct MeshBody {
    /// Its fields.
    pub source: FieldSource,
    /// The mesh at rest, in its own frame.
    pub mesh: QuadMesh,
    /// Its position in the picture.
    pub position: MeshPosition,
    /// The participant whose grains it carries.
    pub partner: Option<String>,
    /// Indices of the elements that are kept.
    pub kept: Vec<usize>,
}

/// Grains.
#[derive(Debug)]
pub struct GrainBody {
    /// Their fields.
    pub source: FieldSource,
    /// The first moment that has them.
    pub first: Arrays,
    /// Indices of the grains that are kept.
    pub kept: Vec<usize>,
}

/// All bodies.
#[derive(Debug, Default)]
pub struct Scene {
    /// Meshes whose positions are known.
    pub meshes: Vec<MeshBody>,
    /// Grains.
    pub grains: Vec<GrainBody>,
    /// Remarks for the page.
    pub notes: Vec<String>,
}

impl Scene {
    /// The bodies of a run, whole.
    pub fn of(files: &FieldFiles, setup: &Setup) -> Scene {
        let mut scene = Scene::default();
        for source in files.sources.iter().filter(|source| source.grains) {
            if let Some(first) = scene.first(files, source) {
                scene.grains.push(GrainBody {
                    source: source.clone(),
                    kept: (0..points(&first).len()).collect(),
                    first,
                });
            }
        }
        let meshes: Vec<&FieldSource> = files.sources.iter().filter(|s| !s.grains).collect();
        for source in &meshes {
            scene.add_mesh(files, setup, source, meshes.len() == 1);
        }
        scene
    }

    /// The fields of a participant at the first moment that has them; files that cannot be read become remarks.
    fn first(&mut self, files: &FieldFiles, source: &FieldSource) -> Option<Arrays> {
        for moment in &files.moments {
            match files.read(source, moment) {
                Ok(None) => {}
                Ok(Some(arrays)) => return Some(arrays),
                Err(error) => self.note(error.to_string()),
            }
        }
        None
    }

    /// Adds a remark unless it is there already.
    pub fn note(&mut self, note: String) {
        if !self.notes.contains(&note) {
            self.notes.push(note);
        }
    }

    fn add_mesh(&mut self, files: &FieldFiles, setup: &Setup, source: &FieldSource, only: bool) {
        let name = &source.participant;
        let Some(first) = self.first(files, source) else {
            return;
        };
        let Some(mesh) = QuadMesh::of(&first) else {
            let why = "its cells are no quadrilaterals";
            return self.note(format!("`{name}` is not drawn: {why}"));
        };
        let position = match self.position(&mesh, setup, name, only) {
            Err(why) => return self.note(format!("`{name}` is not drawn: it {why}")),
            Ok(position) => position,
        };
        let note = position.note.as_ref();
        let note = note.map(|note| format!("`{name}` {note}"));
        self.notes.extend(note);
        let partner = setup.partner(name).map(|joint| joint.partner.to_string());
        self.meshes.push(MeshBody {
            kept: (0..mesh.quads.len()).collect(),
            source: source.clone(),
            partner: partner.filter(|_| position.carries.is_some()),
            mesh,
            position,
        });
    }

    fn position(
        &self,
        mesh: &QuadMesh,
        setup: &Setup,
        name: &str,
        only: bool,
    ) -> Result<MeshPosition, String> {
        let joint = setup.partner(name);
        let grains = joint.and_then(|joint| {
            let mut all = self.grains.iter();
            all.find(|grains| grains.source.participant == joint.partner)
        });
        match (joint, grains) {
            (Some(joint), Some(grains)) => {
                beside(mesh, &joint, &JoinedGrains::of_fields(&grains.first))
            }
            _ if only && self.grains.is_empty() => Ok(MeshPosition::default()),
            _ => Err("is joined with no grains that would determine its position".into()),
        }
    }

    /// All parts, in `frames` frames.
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
            let centres = body.centres();
            let count = share(centres.len(), content.elements, whole.elements);
            body.kept = nearest(&centres, focus, count);
        }
        for grains in &mut self.grains {
            let centres = grains.centres();
            let count = share(centres.len(), content.grains, whole.grains);
            grains.kept = nearest(&centres, focus, count);
        }
    }

    /// The mean position at the last readable moment, weighted by squares of pressures; unweighted without pressure.
    pub fn focus(&self, files: &FieldFiles) -> [f64; 2] {
        let read = |source: &FieldSource| {
            let mut moments = files.moments.iter().rev();
            let found = moments.find_map(|moment| files.read(source, moment).ok().flatten());
            found.unwrap_or_default()
        };
        let mut bearing: Vec<([f64; 2], f64)> = Vec::new();
        let mut add = |centres: Vec<[f64; 2]>, pressures: &[f64]| {
            bearing.extend(centres.into_iter().zip(pressures.iter().copied()));
        };
        for body in &self.meshes {
            let pressures = read(&body.source).remove("hydrostatic_pressure_pa");
            add(body.centres(), &pressures.unwrap_or_default());
        }
        for grains in &self.grains {
            let arrays = read(&grains.source);
            add(points(&arrays), numbers(&arrays, "pressure_pa"));
        }
        middle(&bearing)
    }
}

/// Mean of points weighted by squares of their pressures, without tension; unweighted if there is no pressure.
fn middle(bearing: &[([f64; 2], f64)]) -> [f64; 2] {
    let mean = |weight: &dyn Fn(f64) -> f64| {
        let sum: f64 = bearing.iter().map(|(_, pressure)| weight(*pressure)).sum();
        let part = |k: usize| -> f64 {
            let parts = bearing
                .iter()
                .map(|(at, pressure)| weight(*pressure) * at[k]);
            parts.sum()
        };
        (sum > 0.0).then(|| [0, 1].map(|k| part(k) / sum))
    };
    let borne = mean(&|pressure| pressure.max(0.0).powi(2));
    borne.or_else(|| mean(&|_| 1.0)).unwrap_or_default()
}

impl GrainBody {
    /// Centres at the first moment (m).
    pub fn centres(&self) -> Vec<[f64; 2]> {
        points(&self.first)
    }

    /// Bytes of a grain for colours other than pressure.
    fn colours(&self) -> usize {
        let given = ["velocity_m_per_s", "body", "adhesion"];
        let given = given.iter().filter(|name| self.first.contains_key(**name));
        given.count()
    }
}

impl MeshBody {
    /// Centres of the elements in the picture (m).
    fn centres(&self) -> Vec<[f64; 2]> {
        let centres = self.mesh.centres().into_iter();
        centres.map(|[x, y]| [x, y + self.position.up]).collect()
    }

    /// The line of nodes that carries grains, or the wheel on top.
    pub fn line(&self) -> Vec<u32> {
        let side = self.position.carries.unwrap_or(MeshSide::Top);
        self.mesh.side(side)
    }
}
