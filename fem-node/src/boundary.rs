//! Loads and prescribed motions of named sets, turned into nodal forces and components.
//!
//! A prescribed component is moved by whatever it takes: its mass counts as part of that drive, not of the body, so the
//! drive exerts r = F(u) + d - f, F being the internal force, d that of stiffness damping and f the other loads there,
//! and does the work [(1-b) r + b r'] du in a step.

use protocol::ConfigError;

use crate::config::{Base, Config, SetConfig, SetLoad};
use crate::element::{Body, Layout};
use crate::mesh::Mesh;
use crate::model::known_sets;

/// A traction turned into forces on the nodes of its set.
#[derive(Clone, Debug)]
pub struct Traction {
    /// Component and force at full load (N).
    pub forces: Vec<(usize, f64)>,
    ramp: Ramp,
}

/// Components whose motion is prescribed.
#[derive(Clone, Debug, PartialEq)]
pub struct Drive {
    /// Component, and the velocity after the ramp (m/s) or the displacement at its end (m).
    pub components: Vec<(usize, f64)>,
    course: Course,
    ramp: Ramp,
}

/// What is ramped.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Course {
    Velocity,
    Displacement,
}

/// A linear rise from 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Ramp(f64);

impl Ramp {
    fn share(self, t: f64) -> f64 {
        match self.0 > 0.0 {
            true => (t / self.0).clamp(0.0, 1.0),
            false => 1.0,
        }
    }

    /// The integral of [`Ramp::share`] from 0 to t (s).
    fn elapsed(self, t: f64) -> f64 {
        match t < self.0 {
            true => 0.5 * t * t / self.0,
            false => t - 0.5 * self.0,
        }
    }
}

impl Traction {
    /// Share of the full load at time t (s).
    pub fn share(&self, t: f64) -> f64 {
        self.ramp.share(t)
    }

    /// Duration of the ramp (s).
    pub fn ramp(&self) -> f64 {
        self.ramp.0
    }
}

impl Drive {
    /// Displacement at time t over the number of the component (m).
    pub(crate) fn place(&self, t: f64) -> f64 {
        match self.course {
            Course::Velocity => self.ramp.elapsed(t),
            Course::Displacement => self.ramp.share(t),
        }
    }

    /// Velocity at time t over the number of the component (m/s).
    pub(crate) fn speed(&self, t: f64) -> f64 {
        match self.course {
            Course::Velocity => self.ramp.share(t),
            Course::Displacement if t < self.ramp.0 => 1.0 / self.ramp.0,
            Course::Displacement => 0.0,
        }
    }

    /// Duration of the ramp (s).
    pub fn ramp(&self) -> f64 {
        self.ramp.0
    }
}

/// Tractions and drives of the scenario; what a drive moves is taken out of the body's own masses.
pub(crate) fn build(
    config: &Config,
    mesh: &Mesh,
    body: &mut Body,
    thickness: f64,
) -> Result<(Vec<Traction>, Vec<Drive>), ConfigError> {
    let (mut tractions, mut drives) = (Vec::new(), Vec::<Drive>::new());
    for (name, set) in &config.boundary.0 {
        let nodes = nodes(config, mesh, name)?;
        let lines = lines(mesh, name, set)?;
        let ramp = Ramp(set.ramp_s.unwrap_or(0.0));
        match set.load() {
            None => {}
            Some(SetLoad::Traction(traction)) => tractions.push(Traction {
                forces: traction_forces(
                    mesh,
                    body.layout(),
                    &lines,
                    traction.map(|t| t * thickness),
                ),
                ramp,
            }),
            Some(SetLoad::Pressure(pressure)) => tractions.push(Traction {
                forces: pressure_forces(mesh, body.layout(), &lines, pressure * thickness),
                ramp,
            }),
            Some(SetLoad::Velocity(_) | SetLoad::Displacement(_)) => {
                let drive = drive(set, body, &nodes);
                drives.push(without_doubles(name, drive, &drives)?);
            }
        }
    }
    for drive in &drives {
        body.hold(drive.components.iter().map(|(index, _)| *index));
    }
    Ok((tractions, drives))
}

fn nodes(config: &Config, mesh: &Mesh, name: &str) -> Result<Vec<[usize; 2]>, ConfigError> {
    let key = format!("boundary.{name}");
    if name == "bottom" && config.base == Base::Clamped {
        return Err(
            ConfigError::new(&key, "is clamped and follows no load or motion")
                .help("set base = \"free\" or \"roller\", or name another set"),
        );
    }
    mesh.set(name)
        .ok_or_else(|| ConfigError::new(&key, "is no set of the mesh").help(known_sets(mesh)))
}

/// The lines on which tractions act; none under a motion.
fn lines(mesh: &Mesh, name: &str, set: &SetConfig) -> Result<Vec<Vec<[usize; 2]>>, ConfigError> {
    let load = match set.load() {
        Some(SetLoad::Traction(_)) => "traction_pa",
        Some(SetLoad::Pressure(_)) => "pressure_pa",
        _ => return Ok(Vec::new()),
    };
    let refused = |problem: &str, help: &str| {
        let key = format!("boundary.{name}.{load}");
        ConfigError::new(&key, problem).help(help)
    };
    let lines = mesh.lines(name).ok_or_else(|| {
        refused(
            "acts on lines, and the set is a surface",
            "name a physical group of lines; a surface can be given a motion",
        )
    })?;
    let inside = |pair: &[[usize; 2]]| mesh.outline(pair[0], pair[1]).is_none();
    let inside = lines.iter().any(|line| line.windows(2).any(inside));
    match inside && load == "pressure_pa" {
        true => Err(refused(
            "acts against the outward normal, and the set has a line inside the body",
            "give its components as traction_pa, or name a line of the outline",
        )),
        false => Ok(lines),
    }
}

/// Consistent with linear shape functions: each node carries half of the edges beside it.
fn traction_forces(
    mesh: &Mesh,
    layout: Layout,
    lines: &[Vec<[usize; 2]>],
    force_per_length: [f64; 2],
) -> Vec<(usize, f64)> {
    let nodes = lines
        .iter()
        .flat_map(|line| line.iter().zip(mesh.tributary(line)));
    let forces = nodes.flat_map(|(node, length)| {
        [0, 1].map(|k| {
            (
                layout.tied_to(layout.index(*node, k)),
                force_per_length[k] * length,
            )
        })
    });
    forces.filter(|(_, force)| *force != 0.0).collect()
}

/// Each segment pushes inwards on both of its nodes alike.
fn pressure_forces(
    mesh: &Mesh,
    layout: Layout,
    lines: &[Vec<[usize; 2]>],
    force_per_length: f64,
) -> Vec<(usize, f64)> {
    let mut forces = Vec::new();
    let segments = lines.iter().flat_map(|line| line.windows(2));
    for [a, b] in segments.filter_map(|pair| mesh.outline(pair[0], pair[1])) {
        let ([xa, ya], [xb, yb]) = (mesh.point(a[0], a[1]), mesh.point(b[0], b[1]));
        // With the body on the left of a -> b the inward normal times the length is (ya - yb, xb - xa).
        let half = 0.5 * force_per_length;
        for node in [a, b] {
            let components = [0, 1].map(|k| layout.tied_to(layout.index(node, k)));
            forces.push((components[0], half * (ya - yb)));
            forces.push((components[1], half * (xb - xa)));
        }
    }
    forces.retain(|(_, force)| *force != 0.0);
    forces
}

/// What the supports hold already stays theirs.
fn drive(set: &SetConfig, body: &Body, nodes: &[[usize; 2]]) -> Drive {
    let (course, components) = match set.load() {
        Some(SetLoad::Velocity(velocity)) => (Course::Velocity, velocity),
        Some(SetLoad::Displacement(shift)) => (Course::Displacement, shift),
        _ => unreachable!("the caller matched a motion"),
    };
    let given = nodes.iter().flat_map(|node| {
        [0, 1].map(|k| {
            components[k]
                .given()
                .map(|value| (body.layout().index(*node, k), value))
        })
    });
    let own = |index: &usize| body.layout().tied_to(*index);
    let free = |(index, _): &(usize, f64)| body.inverse_mass[own(index)] > 0.0;
    Drive {
        components: given.flatten().filter(free).collect(),
        course,
        ramp: Ramp(set.ramp_s.unwrap_or(0.0)),
    }
}

/// Sets share corners; both may move them, in the same way.
fn without_doubles(name: &str, mut drive: Drive, others: &[Drive]) -> Result<Drive, ConfigError> {
    for other in others {
        let same = (drive.course, drive.ramp) == (other.course, other.ramp);
        for (index, value) in &other.components {
            let Some(at) = drive.components.iter().position(|(own, _)| own == index) else {
                continue;
            };
            if !same || drive.components[at].1 != *value {
                let key = format!("boundary.{name}");
                return Err(
                    ConfigError::new(&key, "moves a node otherwise than another set does").help(
                        "give both sets the same motion, or set one of the components to \"free\"",
                    ),
                );
            }
            drive.components.remove(at);
        }
    }
    Ok(drive)
}
