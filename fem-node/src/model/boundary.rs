//! Loads and prescribed motions of named sets, turned into nodal forces and components.
//!
//! A drive moves a prescribed component with any force it needs. The component's mass counts as part of the drive, not of the body, so the drive
//! exerts r = F(u) + d - f, F being the internal force, d the force of stiffness damping and f the other loads there, and does the work [(1-b) r + b
//! r'] du in a step.

use fem_kernel::element::body::Body;
use fem_kernel::element::layout::Layout;
use fem_kernel::mesh::Mesh;
use kit::ConfigError;
use kit::keys::refuse_if;
use kit::table::{LoadTable, load_at};

use super::motion::{MotionHistory, PrescribedMotion, Ramp};
use crate::config::boundary::{SetConfig, SetLoad};
use crate::config::choice::Base;
use crate::config::keys::FemConfig;
use crate::config::motion::SetMotion;
use crate::mesh::named_set;

/// A load turned into forces on the nodes of its set.
#[derive(Clone, Debug)]
pub struct Traction {
    /// Component and force (N): at full load, or for a table of loads, under 1 N on the set.
    pub forces: Vec<(usize, f64)>,
    /// Factor of these forces over time (s): share of the full load, or force of the set (N).
    pub(crate) factors: LoadTable,
}

impl Traction {
    /// Factor of the forces at time t (s).
    pub(crate) fn factor(&self, t: f64) -> f64 {
        load_at(&self.factors, t)
    }
}

/// Loads, prescribed motions, and warnings about sets that supports hold in part.
type Built = (Vec<Traction>, Vec<PrescribedMotion>, Vec<String>);

/// Tractions and prescribed motions of the scenario, with warnings about nodes that supports hold; components that a motion moves are removed from
/// the body's own masses.
pub(crate) fn build(
    config: &FemConfig,
    mesh: &Mesh,
    body: &mut Body,
    thickness: f64,
) -> Result<Built, ConfigError> {
    let (mut tractions, mut motions) = (Vec::new(), Vec::<PrescribedMotion>::new());
    let mut warnings = Vec::new();
    for (name, set) in &config.boundary.0 {
        let nodes = nodes(config, mesh, name)?;
        let lines = lines(mesh, name, set)?;
        let ramp = Ramp {
            duration: set.ramp_s.unwrap_or(0.0),
        };
        let layout = body.layout;
        if let Some(prescribed) = set.prescribed() {
            warnings.extend(held_motion(body, name, &nodes, prescribed)?);
            let motion = motion(body, name, &nodes, prescribed, ramp);
            motions.push(without_doubles(motion, &motions)?);
        }
        if let Some(load) = set.load() {
            let forces = nodal_forces(mesh, layout, &lines, load, thickness);
            refuse_held_load(body, &format!("boundary.{name}.{}", load.key()), &forces)?;
            tractions.push(Traction {
                forces,
                factors: match load {
                    SetLoad::Table(table, _) => table.clone(),
                    _ if ramp.duration > 0.0 => vec![[0.0, 0.0], [ramp.duration, 1.0]],
                    _ => vec![[0.0, 1.0]],
                },
            });
        }
    }
    for motion in &motions {
        body.fix(motion.components.iter().map(|(index, _)| *index));
    }
    Ok((tractions, motions, warnings))
}

/// Refuses a motion in a direction in which supports hold the whole set; warns where they hold some of its nodes.
fn held_motion(
    body: &Body,
    set: &str,
    nodes: &[[usize; 2]],
    motion: SetMotion,
) -> Result<Vec<String>, ConfigError> {
    let mut warnings = Vec::new();
    for (k, direction) in ["x", "y"].into_iter().enumerate() {
        if !motion.moves(k) {
            continue;
        }
        let held = nodes
            .iter()
            .filter(|node| is_held(body, body.layout.index(**node, k)));
        let (held, all) = (held.count(), nodes.len());
        refuse_if(
            held == all,
            &format!("boundary.{set}.{}", motion.key()),
            format!("moves no node along {direction}: supports hold them all"),
            format!("write \"free\" along {direction}, or free the set by base or sides"),
        )?;
        if held > 0 {
            warnings.push(format!(
                "boundary.{set}.{}: supports hold {held} of the {all} nodes along {direction}, and these do not move; free them by base or sides, or move a set without them",
                motion.key()
            ));
        }
    }
    Ok(warnings)
}

/// Refuses a load that acts along a direction only where supports hold the body.
fn refuse_held_load(body: &Body, key: &str, forces: &[(usize, f64)]) -> Result<(), ConfigError> {
    for (k, direction) in ["x", "y"].into_iter().enumerate() {
        let along = forces.iter().map(|(index, _)| *index);
        let mut along = along.filter(|index| body.layout.direction(*index) == k);
        refuse_if(
            along.clone().next().is_some() && along.all(|index| is_held(body, index)),
            key,
            format!("moves no node along {direction}: supports hold them all"),
            "remove the load along this direction, or free the set by base or sides",
        )?;
    }
    Ok(())
}

/// True for a component without a motion of its own.
fn is_held(body: &Body, index: usize) -> bool {
    body.inverse_mass[body.layout.tied_to(index)] == 0.0
}

fn nodes(config: &FemConfig, mesh: &Mesh, name: &str) -> Result<Vec<[usize; 2]>, ConfigError> {
    let key = format!("boundary.{name}");
    refuse_if(
        name == "bottom" && config.base == Base::Clamped,
        &key,
        "is clamped and follows no load or motion",
        "set base = \"free\" or \"roller\", or name another set",
    )?;
    named_set(mesh, name, &key, "")
}

/// The lines on which tractions act; empty for a motion alone.
fn lines(mesh: &Mesh, name: &str, set: &SetConfig) -> Result<Vec<Vec<[usize; 2]>>, ConfigError> {
    let Some(load) = set.load().map(|load| load.key()) else {
        return Ok(Vec::new());
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
    if inside && load == "pressure_pa" {
        return Err(refused(
            "acts against the outward normal, and the set has a line inside the body",
            "give its components as traction_pa, or name a line of the outline",
        ));
    }
    Ok(lines)
}

/// Forces of a load on the lines: the whole load, or 1 N of a table.
fn nodal_forces(
    mesh: &Mesh,
    layout: Layout,
    lines: &[Vec<[usize; 2]>],
    load: SetLoad,
    thickness: f64,
) -> Vec<(usize, f64)> {
    match load {
        SetLoad::Traction(traction) => {
            let forces = traction.map(|t| t.0.unwrap_or(0.0) * thickness);
            traction_forces(mesh, layout, lines, forces)
        }
        SetLoad::Pressure(pressure) => pressure_forces(mesh, layout, lines, pressure * thickness),
        SetLoad::Table(_, direction) => {
            let length: f64 = lines.iter().flat_map(|line| mesh.tributary(line)).sum();
            traction_forces(mesh, layout, lines, direction.map(|d| d / length))
        }
    }
}

/// Forces of a traction, consistent with linear shape functions: each node carries half of the edges beside it.
fn traction_forces(
    mesh: &Mesh,
    layout: Layout,
    lines: &[Vec<[usize; 2]>],
    force_per_length: [f64; 2],
) -> Vec<(usize, f64)> {
    let nodes = lines
        .iter()
        .flat_map(|line| line.iter().zip(mesh.tributary(line)));
    let component = |node, k| layout.tied_to(layout.index(node, k));
    let forces = nodes.flat_map(|(node, length)| {
        [0, 1].map(|k| (component(*node, k), force_per_length[k] * length))
    });
    forces.filter(|(_, force)| *force != 0.0).collect()
}

/// Forces of a pressure: each segment pushes inwards on both of its nodes alike.
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

/// Components of the nodes that a set moves, except components that the supports hold.
fn motion(
    body: &Body,
    set: &str,
    nodes: &[[usize; 2]],
    prescribed: SetMotion,
    ramp: Ramp,
) -> PrescribedMotion {
    let layout = body.layout;
    let values = prescribed.components();
    let given = |node: &[usize; 2], k: usize| Some((layout.index(*node, k), values[k].0?));
    let free = |(index, _): &(usize, f64)| !is_held(body, *index);
    let all = nodes.iter().flat_map(|node| [0, 1].map(|k| given(node, k)));
    PrescribedMotion {
        set: set.into(),
        components: all.flatten().filter(free).collect(),
        history: MotionHistory::new(prescribed, ramp),
    }
}

/// Sets share corners, and both may move them in the same way. The corners count for the first set, whose reaction includes their force.
fn without_doubles(
    mut motion: PrescribedMotion,
    others: &[PrescribedMotion],
) -> Result<PrescribedMotion, ConfigError> {
    for other in others {
        let same = motion.history == other.history;
        for (index, value) in &other.components {
            let Some(at) = motion.components.iter().position(|(own, _)| own == index) else {
                continue;
            };
            refuse_if(
                !same || motion.components[at].1 != *value,
                &format!("boundary.{}", motion.set),
                "moves a node differently from another set",
                "give both sets the same motion, or set one of the components to \"free\"",
            )?;
            motion.components.remove(at);
        }
    }
    Ok(motion)
}
