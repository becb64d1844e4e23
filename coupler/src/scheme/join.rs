//! From the interfaces of a scenario to groups that are ready for their first window.

mod point_mass;
mod suitability;

use std::ops::Range;

use protocol::{Description, Surface};

use super::clock::Clock;
use super::group::{Group, Patch, Side};
use super::mapping::Mapping;
use super::participants::Participants;
use crate::error::Error;
use crate::scenario::{Dirichlet, Interface, Scenario};
use point_mass::{point_masses, refuse_massless};
use suitability::{refuse_finer_than_solver, refuse_without_prescribed_velocity};

/// Largest relative difference between the windows of connected interfaces that counts as rounding.
const SAME_WINDOW: f64 = 1e-9;

/// Couples the named sets of all interfaces, group by group, and agrees on what is exchanged.
pub fn join(participants: &mut dyn Participants, scenario: &Scenario) -> Result<Vec<Group>, Error> {
    let mut groups = Vec::new();
    for members in scenario.groups() {
        let interfaces = members.iter().map(|index| &scenario.interface[*index]);
        let mut group = join_group(participants, interfaces.collect())?;
        for (patch, index) in group.patches.iter_mut().zip(members) {
            patch.index = index;
        }
        groups.push(group);
    }
    Ok(groups)
}

fn join_group(
    participants: &mut dyn Participants,
    interfaces: Vec<&Interface>,
) -> Result<Group, Error> {
    let mut pairs = Vec::new();
    for interface in &interfaces {
        let pair = roles(participants, interface)?;
        let [wall, continuum] = [pair.motion_driven, pair.force_driven]
            .map(|peer| (participants.name(peer), participants.description(peer)));
        refuse_finer_than_solver(interface, wall.0, wall.1)?;
        refuse_without_prescribed_velocity(interface, continuum.0, continuum.1)?;
        pairs.push(pair);
    }
    refuse_two_roles(participants, &pairs)?;
    let clock = clock(participants, &interfaces, &pairs)?;
    let mut seams = Vec::new();
    for (interface, pair) in interfaces.iter().zip(pairs) {
        seams.push(seam(participants, interface, pair)?);
    }
    for peer in each_once(seams.iter().map(|seam| seam.pair.force_driven)) {
        let own = seams.iter().filter(|seam| seam.pair.force_driven == peer);
        select(
            participants,
            peer,
            own.map(|seam| (seam.offered, &seam.active)),
        )?;
    }
    for peer in each_once(seams.iter().map(|seam| seam.pair.motion_driven)) {
        let own = seams.iter().filter(|seam| seam.pair.motion_driven == peer);
        let all: Vec<(usize, Vec<usize>)> = own
            .map(|seam| (seam.points.len(), (0..seam.points.len()).collect()))
            .collect();
        select(
            participants,
            peer,
            all.iter().map(|(count, points)| (*count, points)),
        )?;
    }
    Ok(assemble(&interfaces, &seams, clock))
}

/// The participants of an interface, and their sets.
struct Pair {
    force_driven: usize,
    force_driven_set: String,
    motion_driven: usize,
    motion_driven_set: String,
}

/// An interface with its sets coupled.
struct Seam {
    pair: Pair,
    /// Points of the continuum's set.
    offered: usize,
    /// Those of them that are exchanged.
    active: Vec<usize>,
    nodes: Surface,
    points: Surface,
    mapping: Mapping,
}

/// The side that takes forces and the one that stands on the wall, told by what they can do, not by their order.
fn roles(participants: &mut dyn Participants, interface: &Interface) -> Result<Pair, Error> {
    let mut continuum = None;
    let mut wall = None;
    for side in &interface.between {
        let (name, set) = side.split_once('.').unwrap_or((side, ""));
        let peer = (0..participants.count())
            .find(|peer| participants.name(*peer) == name)
            .ok_or_else(|| {
                Error::Refused(format!(
                    "interface `{}`: no participant `{name}`",
                    interface.name
                ))
            })?;
        let description = participants.description(peer).clone();
        if !description.sets.iter().any(|known| known == set) {
            return Err(Error::Refused(format!(
                "interface `{}`: participant `{name}` has no set `{set}`; its sets: {}",
                interface.name,
                description.sets.join(", ")
            )));
        }
        let capabilities = description.capabilities;
        if !(capabilities.rollback && (capabilities.advance || capabilities.compliant_boundary)) {
            // It can take no part. Its own refusal says which of its keys is why; ours is for one that has none.
            participants.couple(peer, set)?;
        }
        if !capabilities.rollback {
            return Err(Error::Refused(format!(
                "interface `{}`: participant `{name}` cannot repeat a window (no checkpoint), which every scheme here needs",
                interface.name
            )));
        }
        if capabilities.advance && continuum.is_none() {
            continuum = Some((peer, set.to_string()));
        } else if capabilities.compliant_boundary && wall.is_none() {
            wall = Some((peer, set.to_string()));
        }
    }
    match (continuum, wall) {
        (Some((force_driven, force_driven_set)), Some((motion_driven, motion_driven_set))) => {
            Ok(Pair {
                force_driven,
                force_driven_set,
                motion_driven,
                motion_driven_set,
            })
        }
        _ => Err(Error::Refused(format!(
            "interface `{}` joins {} and {}: it takes one participant that advances under forces and one that stands on a compliant wall",
            interface.name, interface.between[0], interface.between[1]
        ))),
    }
}

/// A participant answers either motion or force in a window, on all of its interfaces.
fn refuse_two_roles(participants: &dyn Participants, pairs: &[Pair]) -> Result<(), Error> {
    let both = pairs.iter().find(|pair| {
        pairs
            .iter()
            .any(|other| other.motion_driven == pair.force_driven)
    });
    match both {
        None => Ok(()),
        Some(pair) => Err(Error::Refused(format!(
            "participant `{}` would take forces on one interface and stand on a wall on another: a participant has one role on all of its interfaces",
            participants.name(pair.force_driven)
        ))),
    }
}

/// The windows of the group, from the steps of its continua and within the bounds of its walls.
fn clock(
    participants: &dyn Participants,
    interfaces: &[&Interface],
    pairs: &[Pair],
) -> Result<Clock, Error> {
    let mut first: Option<(&Interface, f64)> = None;
    let mut common = 0;
    for (interface, pair) in interfaces.iter().zip(pairs) {
        let name = participants.name(pair.force_driven);
        let step_s = participants.description(pair.force_driven).step_s.ok_or_else(|| {
            Error::Refused(format!(
                "participant `{name}` has no step of its own, the window cannot be counted in it"
            ))
        })?;
        let window_s = step_s * f64::from(interface.substeps);
        let wall_name = participants.name(pair.motion_driven);
        let wall = participants.description(pair.motion_driven);
        within_limit(interface, step_s, wall_name, wall)?;
        let (leader, leading) = *first.get_or_insert((interface, step_s));
        let leading_s = leading * f64::from(leader.substeps);
        if (window_s - leading_s).abs() > SAME_WINDOW * leading_s {
            return Err(Error::Refused(format!(
                "interfaces `{}` and `{}` are connected but have windows of {leading_s:.9e} s ({} x {leading:.9e} s) and {window_s:.9e} s ({} x {step_s:.9e} s): give substeps and time.step_s with the same product",
                leader.name, interface.name, leader.substeps, interface.substeps
            )));
        }
        common = greatest_common_divisor(common, interface.substeps);
    }
    let (leader, step_s) = first.expect("a group has an interface");
    Ok(Clock {
        step_s: step_s * f64::from(leader.substeps / common),
        substeps: common,
    })
}

fn within_limit(
    interface: &Interface,
    step_s: f64,
    wall_name: &str,
    wall: &Description,
) -> Result<(), Error> {
    let window_s = step_s * f64::from(interface.substeps);
    match wall.step_limit_s {
        Some(limit) if window_s > limit => Err(Error::Refused(format!(
            "interface `{}`: the window of {} substeps x {step_s:.4e} s = {window_s:.4e} s is above {} = {limit:.4e} s of participant `{wall_name}`; lower interface.{}.substeps to {} or less",
            interface.name,
            interface.substeps,
            wall.step_limit_name,
            interface.name,
            (limit / step_s).floor()
        ))),
        _ => Ok(()),
    }
}

fn greatest_common_divisor(a: u32, b: u32) -> u32 {
    match b {
        0 => a,
        _ => greatest_common_divisor(b, a % b),
    }
}

fn seam(
    participants: &mut dyn Participants,
    interface: &Interface,
    pair: Pair,
) -> Result<Seam, Error> {
    let all_nodes = participants.couple(pair.force_driven, &pair.force_driven_set)?;
    let mut points = participants.couple(pair.motion_driven, &pair.motion_driven_set)?;
    if interface.scheme.dirichlet() == Dirichlet::Continuum {
        let name = participants.name(pair.motion_driven);
        let wall = participants.description(pair.motion_driven);
        points.mass_kg = point_masses(
            interface,
            (name, &pair.motion_driven_set),
            wall,
            points.len(),
        )?;
    }
    let mapping = map(interface, &all_nodes, &points)?;
    let active = mapping.active();
    let mapping = mapping.restricted(&active);
    let nodes = pick(&all_nodes, &active);
    refuse_massless(interface, &mapping, &nodes, &points)?;
    Ok(Seam {
        pair,
        offered: all_nodes.len(),
        mapping,
        nodes,
        points,
        active,
    })
}

fn map(interface: &Interface, nodes: &Surface, points: &Surface) -> Result<Mapping, Error> {
    let positions = |surface: &Surface| -> Vec<[f64; 2]> {
        surface
            .x_m
            .iter()
            .zip(&surface.y_m)
            .map(|(x, y)| [*x, *y])
            .collect()
    };
    let mapping = Mapping::new(interface.mapping, &positions(nodes), &positions(points));
    mapping.map_err(|error| {
        Error::Refused(format!(
            "interface `{}` between {} and {}: {error}",
            interface.name, interface.between[0], interface.between[1]
        ))
    })
}

fn pick(surface: &Surface, indices: &[usize]) -> Surface {
    let take = |values: &[f64]| indices.iter().map(|index| values[*index]).collect();
    Surface {
        x_m: take(&surface.x_m),
        y_m: take(&surface.y_m),
        mass_kg: take(&surface.mass_kg),
        radius_m: take(&surface.radius_m),
        length_m: take(&surface.length_m),
    }
}

/// Selects points of all sets that a participant has coupled: the number of points and the wanted ones, set by set.
fn select<'a>(
    participants: &mut dyn Participants,
    peer: usize,
    sets: impl Iterator<Item = (usize, &'a Vec<usize>)>,
) -> Result<(), Error> {
    let mut points = Vec::new();
    let mut offset = 0;
    for (count, wanted) in sets {
        points.extend(wanted.iter().map(|index| offset + index));
        offset += count;
    }
    participants.select(peer, &points)
}

fn assemble(interfaces: &[&Interface], seams: &[Seam], clock: Clock) -> Group {
    let own_steps = |peer: usize| {
        let mut of_peer = interfaces.iter().zip(seams);
        let (interface, _) = of_peer
            .find(|(_, seam)| seam.pair.force_driven == peer)
            .expect("it is in the group because of an interface");
        interface.substeps / clock.substeps
    };
    let (mut force_driven, surface, node_ranges) = line_up(
        seams
            .iter()
            .map(|seam| (seam.pair.force_driven, &seam.nodes))
            .collect(),
    );
    for side in &mut force_driven {
        side.steps = own_steps(side.peer);
    }
    let (motion_driven, glued, point_ranges) = line_up(
        seams
            .iter()
            .map(|seam| (seam.pair.motion_driven, &seam.points))
            .collect(),
    );
    let mut mapping = Mapping::empty(surface.len(), glued.len());
    let mut patches = Vec::new();
    for (index, (interface, seam)) in interfaces.iter().zip(seams).enumerate() {
        let (nodes, points) = (node_ranges[index].clone(), point_ranges[index].clone());
        mapping.put(points.start, nodes.start, &seam.mapping);
        let index_of = |sides: &[Side], peer| {
            let found = sides.iter().position(|side| side.peer == peer);
            found.expect("all are lined up")
        };
        let boundary = index_of(&motion_driven, seam.pair.motion_driven);
        patches.push(Patch {
            index,
            name: interface.name.clone(),
            force_driven: index_of(&force_driven, seam.pair.force_driven),
            outward_y: outward(&glued, &points, &motion_driven[boundary].range),
            motion_driven: boundary,
            spacing_m: seam.nodes.length_m.iter().sum::<f64>() / nodes.len() as f64,
            tolerance_rel: interface.tolerance_rel,
            energy_defect_max_rel: interface.energy_defect_max_rel,
            nodes,
            points,
        });
    }
    Group {
        patches,
        force_driven,
        motion_driven,
        nodes: surface,
        points: glued,
        mapping,
        clock,
    }
}

/// A row above the other rows of its wall is glued to a continuum that lies on top, whose outward normal points down.
fn outward(glued: &Surface, row: &Range<usize>, wall: &Range<usize>) -> f64 {
    let mean =
        |range: &Range<usize>| glued.y_m[range.clone()].iter().sum::<f64>() / range.len() as f64;
    if mean(row) > mean(wall) { -1.0 } else { 1.0 }
}

/// The surfaces of several participants in one: participant after participant, and the place of each surface in it.
fn line_up(surfaces: Vec<(usize, &Surface)>) -> (Vec<Side>, Surface, Vec<Range<usize>>) {
    let mut sides = Vec::new();
    let mut whole = Surface::default();
    let mut ranges = vec![0..0; surfaces.len()];
    for peer in each_once(surfaces.iter().map(|(peer, _)| *peer)) {
        let start = whole.len();
        for (index, (_, surface)) in surfaces.iter().enumerate() {
            if surfaces[index].0 == peer {
                let from = whole.len();
                append(&mut whole, surface);
                ranges[index] = from..whole.len();
            }
        }
        sides.push(Side {
            peer,
            range: start..whole.len(),
            steps: 1,
        });
    }
    (sides, whole, ranges)
}

fn append(whole: &mut Surface, part: &Surface) {
    whole.x_m.extend(&part.x_m);
    whole.y_m.extend(&part.y_m);
    whole.mass_kg.extend(&part.mass_kg);
    whole.radius_m.extend(&part.radius_m);
    whole.length_m.extend(&part.length_m);
}

/// Each number once, in the order in which it first comes up.
fn each_once(numbers: impl Iterator<Item = usize>) -> Vec<usize> {
    let mut seen = Vec::new();
    for number in numbers {
        if !seen.contains(&number) {
            seen.push(number);
        }
    }
    seen
}
