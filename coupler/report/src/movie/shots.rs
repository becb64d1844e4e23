//! The frames of a movie: numbers of the kept elements and grains at each kept moment.

use super::fields::{FieldFiles, FieldMoment, FieldSource};
use super::fit::LINES_MOST;
use super::scene::{GrainBody, MeshBody, Scene};
use runs::fields::{Arrays, numbers, points};

/// Smallest force of a line that is kept, over the largest of its frame: a thinner line would be invisible.
const WEAKEST: f64 = 0.01;

/// The kept nodes and elements of a mesh at a moment.
#[derive(Clone, Debug, Default)]
pub struct MeshShot {
    /// Displacements (m).
    pub u: [Vec<f64>; 2],
    /// Hydrostatic pressures (Pa).
    pub pressure: Vec<f64>,
}

/// Grains at a moment, absent ones with NaN.
#[derive(Clone, Debug, Default)]
pub struct GrainShot {
    /// Centres (m).
    pub centre: [Vec<f64>; 2],
    /// Radii (m).
    pub radius: Vec<f64>,
    /// Pressures (Pa).
    pub pressure: Vec<f64>,
    /// Speeds (m/s).
    pub speed: Option<Vec<f64>>,
    /// Numbers of their bodies.
    pub body: Option<Vec<f64>>,
    /// Mean adhesions of their bonds, 0 without bonds.
    pub adhesion: Option<Vec<f64>>,
    /// Contacts under pressure.
    pub lines: Vec<ContactLine>,
}

/// A contact between two kept grains.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactLine {
    /// The grains.
    pub ends: [u32; 2],
    /// Normal force (N).
    pub force: f64,
}

/// One body over all frames; `None` for frames without its fields.
pub type Over<T> = Vec<Option<T>>;

/// All frames.
#[derive(Debug, Default)]
pub struct Shots {
    /// Frames of each mesh.
    pub meshes: Vec<Over<MeshShot>>,
    /// Frames of each set of grains.
    pub grains: Vec<Over<GrainShot>>,
    /// Files that could not be used.
    pub notes: Vec<String>,
}

impl Shots {
    /// Reads the fields of these moments.
    pub fn of(files: &FieldFiles, scene: &Scene, moments: &[&FieldMoment], colours: bool) -> Shots {
        let mut shots = Shots::default();
        for body in &scene.meshes {
            let nodes = body.kept_nodes();
            let shot = |arrays: &Arrays| body.shot(&nodes, arrays);
            let over = shots.over(files, &body.source, moments, shot);
            shots.meshes.push(over);
        }
        for grains in &scene.grains {
            let shot = |arrays: &Arrays| grains.shot(arrays, colours);
            let over = shots.over(files, &grains.source, moments, shot);
            shots.grains.push(over);
        }
        shots
    }

    fn over<T>(
        &mut self,
        files: &FieldFiles,
        source: &FieldSource,
        moments: &[&FieldMoment],
        shot: impl Fn(&Arrays) -> Option<T>,
    ) -> Over<T> {
        let mut over = Vec::new();
        for moment in moments {
            let (who, when) = (&source.participant, &moment.name);
            let found = files.read(source, moment).unwrap_or_else(|error| {
                self.notes.push(format!("left out: {error}"));
                None
            });
            let made = found.as_ref().and_then(&shot);
            if found.is_some() && made.is_none() {
                let note = format!(
                    "left out: `{who}` at `{when}`, which has other nodes or grains than the first frame"
                );
                self.notes.push(note);
            }
            over.push(made);
        }
        over
    }
}

impl MeshBody {
    /// The nodes that the page needs, in ascending order: nodes of the kept elements, of the outline and of the line that carries.
    pub fn kept_nodes(&self) -> Vec<u32> {
        let quads = self.kept.iter().flat_map(|quad| self.mesh.quads[*quad]);
        let outline = self.mesh.outline().into_iter().flatten();
        let mut nodes: Vec<u32> = quads.chain(outline).chain(self.line()).collect();
        nodes.sort_unstable();
        nodes.dedup();
        nodes
    }

    fn shot(&self, nodes: &[u32], arrays: &Arrays) -> Option<MeshShot> {
        let u = numbers(arrays, "displacement_m");
        let pressures = numbers(arrays, "hydrostatic_pressure_pa");
        let (all, quads) = (self.mesh.nodes.len(), self.mesh.quads.len());
        (u.len() == 3 * all && [0, quads].contains(&pressures.len())).then_some(())?;
        let pressure = |quad: &usize| pressures.get(*quad).copied().unwrap_or(f64::NAN);
        let part = |k: usize| nodes.iter().map(|node| u[3 * *node as usize + k]).collect();
        Some(MeshShot {
            u: [part(0), part(1)],
            pressure: self.kept.iter().map(pressure).collect(),
        })
    }
}

impl GrainBody {
    fn shot(&self, arrays: &Arrays, colours: bool) -> Option<GrainShot> {
        let all = self.centres().len();
        let (centres, radii) = (points(arrays), numbers(arrays, "radius_m"));
        (centres.len() == all && radii.len() == all).then_some(())?;
        let of = |values: &[f64]| -> Vec<f64> {
            let value = |grain: &usize| values.get(*grain).copied().unwrap_or(f64::NAN);
            self.kept.iter().map(value).collect()
        };
        // Grains in store have no radius and no position.
        let coordinate = |k: usize| {
            let at = |grain: &usize| {
                if radii[*grain] > 0.0 {
                    centres[*grain][k]
                } else {
                    f64::NAN
                }
            };
            self.kept.iter().map(at).collect()
        };
        let given = |name: &str| arrays.get(name).filter(|_| colours);
        let speeds = given("velocity_m_per_s").map(|v| {
            let speed = |v: &[f64]| v[0].hypot(v[1]);
            v.chunks_exact(3).map(speed).collect::<Vec<f64>>()
        });
        Some(GrainShot {
            centre: [coordinate(0), coordinate(1)],
            radius: of(radii),
            pressure: of(numbers(arrays, "pressure_pa")),
            speed: speeds.map(|speeds| of(&speeds)),
            body: given("body").map(|bodies| of(bodies)),
            adhesion: given("adhesion").map(|_| of(&mean_adhesions(arrays))),
            lines: self.lines(arrays),
        })
    }

    /// The strongest contacts between kept grains.
    fn lines(&self, arrays: &Arrays) -> Vec<ContactLine> {
        let mut index = vec![u32::MAX; self.centres().len()];
        for (k, grain) in self.kept.iter().enumerate() {
            index[*grain] = k as u32;
        }
        let kept = |grain: f64| index.get(grain as usize).copied().unwrap_or(u32::MAX);
        let ends = numbers(arrays, "connectivity").chunks_exact(2);
        let forces = numbers(arrays, "force_n").chunks_exact(2);
        let all = ends.zip(forces).map(|(ends, force)| ContactLine {
            ends: [kept(ends[0]), kept(ends[1])],
            force: force[0],
        });
        let lines = all.filter(|line| line.force > 0.0 && !line.ends.contains(&u32::MAX));
        let mut lines: Vec<ContactLine> = lines.collect();
        lines.sort_by(|a, b| b.force.total_cmp(&a.force));
        let largest = lines.first().map_or(0.0, |line| line.force);
        let seen = lines.partition_point(|line| line.force >= WEAKEST * largest);
        lines.truncate(seen.min(LINES_MOST));
        lines
    }
}

fn mean_adhesions(arrays: &Arrays) -> Vec<f64> {
    let mut sums = vec![(0.0, 0.0); numbers(arrays, "points").len() / 3];
    let ends = numbers(arrays, "connectivity").chunks_exact(2);
    for (ends, adhesion) in ends.zip(numbers(arrays, "adhesion")) {
        for end in ends.iter().filter(|_| *adhesion > 0.0) {
            if let Some(sum) = sums.get_mut(*end as usize) {
                *sum = (sum.0 + adhesion, sum.1 + 1.0);
            }
        }
    }
    let mean = |(sum, count): (f64, f64)| if count > 0.0 { sum / count } else { 0.0 };
    sums.into_iter().map(mean).collect()
}
