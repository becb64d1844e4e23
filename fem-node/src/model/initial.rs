//! Initial velocities, given to the nodes of named sets.

use std::collections::BTreeMap;

use fem_kernel::element::body::Body;
use fem_kernel::mesh::Mesh;
use kit::ConfigError;
use kit::keys::refuse_if;

use crate::config::initial::{BODY, InitialConfig};
use crate::mesh::named_set;

/// Velocity of each component with an initial velocity (m/s), by its index in a field. A named set takes precedence over `body`; two sets may share
/// nodes if both give the same velocity.
pub(crate) fn velocities(
    config: &InitialConfig,
    mesh: &Mesh,
    body: &Body,
) -> Result<BTreeMap<usize, f64>, ConfigError> {
    let mut velocities = BTreeMap::new();
    let is_whole = |name: &str| name == BODY && mesh.set(BODY).is_none();
    for (name, set) in &config.0 {
        if is_whole(name) {
            continue;
        }
        let key = format!("initial.{name}");
        let all = format!(", or `{BODY}` for all nodes");
        let nodes = named_set(mesh, name, &key, &all)?;
        let own = movable(body, &nodes, set.velocity_m_per_s);
        let given = set.velocity_m_per_s.iter().any(|v| *v != 0.0);
        refuse_if(
            given && own.iter().all(|(_, velocity)| *velocity == 0.0),
            &key,
            "moves no node: supports or motions hold them all",
            "remove it, or free the set by base, sides or boundary",
        )?;
        for (index, velocity) in own {
            refuse_if(
                *velocities.entry(index).or_insert(velocity) != velocity,
                &key,
                "gives a node another velocity than another set",
                "give both sets the same velocity, or name sets that share no node",
            )?;
        }
    }
    if let Some(set) = config.0.get(BODY).filter(|_| is_whole(BODY)) {
        let nodes: Vec<[usize; 2]> = mesh.nodes().collect();
        for (index, velocity) in movable(body, &nodes, set.velocity_m_per_s) {
            velocities.entry(index).or_insert(velocity);
        }
    }
    Ok(velocities)
}

/// Components of these nodes that the equations of motion move, with the velocity in their direction (m/s).
fn movable(body: &Body, nodes: &[[usize; 2]], velocity: [f64; 2]) -> Vec<(usize, f64)> {
    let layout = body.layout;
    let components = nodes
        .iter()
        .flat_map(|node| [0, 1].map(|k| (layout.tied_to(layout.index(*node, k)), velocity[k])));
    components
        .filter(|(index, _)| body.inverse_mass[*index] > 0.0)
        .collect()
}
