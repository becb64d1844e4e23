//! From the interfaces of a scenario to groups that are ready for their first window.

mod geometry;
mod point_mass;
mod suitability;

use std::ops::Range;

use protocol::Surface;

use super::clock::Clock;
use super::group::{Group, Offset, Patch, Side};
use super::mapping::Mapping;
use super::participants::Participants;
use crate::error::{Result, SchemeError, Unfit, WindowOf};
use crate::keys::{Dirichlet, Interface, MappingKind, connected};
use geometry::{common_period, offset, same_side};
use point_mass::{point_masses, refuse_massless};
use suitability::{
    refuse_finer_than_solver, refuse_weightless, refuse_what_is_not_offered,
    refuse_without_prescribed_velocity,
};

/// Largest relative difference between the windows of connected interfaces that counts as rounding.
const SAME_WINDOW: f64 = 1e-9;

/// Couples the named sets of all interfaces, group by group, and agrees on what is exchanged.
pub fn join(participants: &mut dyn Participants, interfaces: &[Interface]) -> Result<Vec<Group>> {
    let mut groups = Vec::new();
    for members in connected(interfaces) {
        let joined = members.iter().map(|index| &interfaces[*index]);
        let mut group = join_group(participants, joined.collect())?;
        for (patch, index) in group.patches.iter_mut().zip(members) {
            patch.index = index;
        }
        groups.push(group);
    }
    Ok(groups)
}

fn join_group(participants: &mut dyn Participants, interfaces: Vec<&Interface>) -> Result<Group> {
    let mut pairs = Vec::new();
    for interface in &interfaces {
        let pair = roles(participants, interface)?;
        let (motion_driven, continuum) = (pair.motion_driven.peer, pair.force_driven.peer);
        let [motion_driven_name, continuum_name] =
            [motion_driven, continuum].map(|peer| participants.name(peer));
        refuse_finer_than_solver(
            interface,
            motion_driven_name,
            participants.description(motion_driven),
        )?;
        let description = participants.description(continuum);
        refuse_without_prescribed_velocity(interface, continuum_name, description)?;
        refuse_what_is_not_offered(
            interface,
            [
                (continuum_name, description),
                (motion_driven_name, participants.description(motion_driven)),
            ],
        )?;
        pairs.push(pair);
    }
    refuse_two_roles(participants, &pairs)?;
    let clock = clock(participants, &interfaces, &pairs)?;
    let mut seams = Vec::new();
    for (interface, pair) in interfaces.iter().zip(pairs) {
        seams.push(seam(participants, interface, pair)?);
    }
    select(participants, &seams)?;
    Ok(assemble(&interfaces, &seams, clock))
}

/// A set of a participant.
struct End {
    peer: usize,
    set: String,
}

/// The two sets of an interface.
struct Pair {
    force_driven: End,
    motion_driven: End,
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
    offset: Offset,
    period_m: Option<f64>,
}

fn refused(interface: &Interface, why: impl std::fmt::Display) -> SchemeError {
    Unfit::interface(&interface.name, why.to_string()).into()
}

/// The side that takes forces and the one that stands on a boundary, told by what they can do, not by their order.
fn roles(participants: &mut dyn Participants, interface: &Interface) -> Result<Pair> {
    let (mut continuum, mut motion_driven) = (None, None);
    for side in &interface.between {
        let (name, set) = side.split_once('.').unwrap_or((side, ""));
        let peer = (0..participants.count())
            .find(|peer| participants.name(*peer) == name)
            .ok_or_else(|| refused(interface, format!("no participant `{name}`")))?;
        let description = participants.description(peer);
        if !description.sets.iter().any(|known| known == set) {
            return Err(SchemeError::from(Unfit::UnknownSet {
                interface: interface.name.clone(),
                participant: name.into(),
                set: set.into(),
                known: description.sets.join(", "),
            }));
        }
        let capabilities = description.capabilities;
        if !(capabilities.advance || capabilities.motion_driven()) {
            // It can take no part. Its own refusal says which of its keys is why; ours is for one that has none.
            participants.couple(peer, set)?;
        }
        let set = set.to_string();
        if capabilities.advance && continuum.is_none() {
            continuum = Some(End { peer, set });
        } else if capabilities.motion_driven() && motion_driven.is_none() {
            motion_driven = Some(End { peer, set });
        }
    }
    let (Some(force_driven), Some(motion_driven)) = (continuum, motion_driven) else {
        return Err(SchemeError::from(Unfit::Roles {
            interface: interface.name.clone(),
            between: interface.between.clone(),
        }));
    };
    Ok(Pair {
        force_driven,
        motion_driven,
    })
}

/// A participant answers either motion or force in a window, on all of its interfaces.
fn refuse_two_roles(participants: &dyn Participants, pairs: &[Pair]) -> Result<()> {
    let motion_driven_sides: Vec<usize> =
        pairs.iter().map(|pair| pair.motion_driven.peer).collect();
    let mut continua = pairs.iter().map(|pair| pair.force_driven.peer);
    match continua.find(|peer| motion_driven_sides.contains(peer)) {
        None => Ok(()),
        Some(peer) => Err(SchemeError::from(Unfit::participant(
            participants.name(peer),
            "would take forces on one interface and stand on a wall on another: a participant has one role on all of its interfaces",
        ))),
    }
}

/// The windows of the group, from the steps of its continua and within the bounds of its layers.
fn clock(
    participants: &dyn Participants,
    interfaces: &[&Interface],
    pairs: &[Pair],
) -> Result<Clock> {
    let mut first: Option<(&Interface, f64)> = None;
    let mut common = 0;
    for (interface, pair) in interfaces.iter().zip(pairs) {
        let continuum = pair.force_driven.peer;
        let own = participants.description(continuum).step_s;
        let step_s = step_of(interface, participants.name(continuum), own)?;
        refuse_above_limit(participants, interface, step_s, pair.motion_driven.peer)?;
        let window_s = step_s * f64::from(interface.substeps);
        let (leader, leading) = *first.get_or_insert((interface, step_s));
        let leading_s = leading * f64::from(leader.substeps);
        if (window_s - leading_s).abs() > SAME_WINDOW * leading_s {
            let window = |interface: &Interface, step_s| WindowOf {
                interface: interface.name.clone(),
                substeps: interface.substeps,
                step_s,
            };
            let windows = Unfit::Windows(window(leader, leading), window(interface, step_s));
            return Err(windows.into());
        }
        common = greatest_common_divisor(common, interface.substeps);
    }
    let (leader, step_s) = first.expect("a group has an interface");
    Ok(Clock {
        step_s: step_s * f64::from(leader.substeps / common),
        substeps: common,
    })
}

/// The step (s) that the windows of an interface are counted in, `own` being that of its continuum.
pub fn step_of(interface: &Interface, continuum: &str, own: Option<f64>) -> Result<f64> {
    let problem = match (own, interface.window_s) {
        (Some(step_s), None) => return Ok(step_s),
        (None, Some(window_s)) => return Ok(window_s / f64::from(interface.substeps)),
        (None, None) => format!(
            "is missing: participant `{continuum}` has no step of its own, so that its window must be given here"
        ),
        (Some(step_s), Some(_)) => format!(
            "is for a continuum without a step of its own, and participant `{continuum}` has one of {step_s:e} s: remove the key and give substeps"
        ),
    };
    Err(Unfit::interface_key(interface, "window_s", problem).into())
}

fn refuse_above_limit(
    participants: &dyn Participants,
    interface: &Interface,
    step_s: f64,
    motion_driven: usize,
) -> Result<()> {
    let (name, motion_driven) = (
        participants.name(motion_driven),
        participants.description(motion_driven),
    );
    let substeps = interface.substeps;
    let window_s = step_s * f64::from(substeps);
    let Some(limit) = motion_driven.step_limit_s.filter(|limit| window_s > *limit) else {
        return Ok(());
    };
    let problem = format!(
        "the window of {substeps} substeps x {step_s:.4e} s = {window_s:.4e} s is above {} = {limit:.4e} s of participant `{name}`; lower interface.{}.substeps to {} or less",
        motion_driven.step_limit_name,
        interface.name,
        (limit / step_s).floor()
    );
    let interface = interface.name.clone();
    Err(SchemeError::from(Unfit::WindowTooLong {
        interface,
        problem,
    }))
}

fn greatest_common_divisor(a: u32, b: u32) -> u32 {
    if b == 0 {
        a
    } else {
        greatest_common_divisor(b, a % b)
    }
}

fn seam(participants: &mut dyn Participants, interface: &Interface, pair: Pair) -> Result<Seam> {
    let [continuum, motion_driven] = [&pair.force_driven, &pair.motion_driven];
    let offered = participants.couple(continuum.peer, &continuum.set)?;
    let mut points = participants.couple(motion_driven.peer, &motion_driven.set)?;
    let swapped = interface.scheme.dirichlet() == Dirichlet::ForceDriven;
    if swapped {
        let name = participants.name(motion_driven.peer);
        let told = participants.description(motion_driven.peer);
        points.mass_kg = point_masses(interface, name, &motion_driven.set, told, points.len())?;
    }
    let refuse = |why: String| {
        SchemeError::from(Unfit::Geometry {
            interface: interface.name.clone(),
            between: interface.between.clone(),
            why,
        })
    };
    let normal = |end: &End| participants.description(end.peer).outward.get(&end.set);
    if let Some(why) = normal(continuum)
        .zip(normal(motion_driven))
        .and_then(same_side)
    {
        return Err(refuse(why));
    }
    let sides = [continuum, motion_driven].map(|end| {
        let told = participants.description(end.peer).period_m.get(&end.set);
        let name = format!("{}.{}", participants.name(end.peer), end.set);
        (name, told.copied())
    });
    let period_m = common_period(sides).map_err(&refuse)?;
    let (nodes, glued) = (positions(&offered), positions(&points));
    let relate = |kind| {
        let mapping = match period_m {
            None => Mapping::new(kind, &nodes, &glued),
            Some(period_m) => Mapping::repeating(kind, &nodes, &glued, period_m),
        };
        mapping.map_err(|error| refuse(error.to_string()))
    };
    let smooth = participants
        .description(motion_driven.peer)
        .smooth_m
        .get(&motion_driven.set);
    let shape = smooth.filter(|positions| positions.len() == glued.len());
    let linear = relate(MappingKind::Linear)?;
    let offset = offset(&linear, &nodes, shape.unwrap_or(&glued), period_m);
    let mapping = relate(interface.mapping)?;
    let active = mapping.active();
    let mapping = mapping.restricted(&active);
    let nodes = pick(&offered, &active);
    refuse_weightless(interface, participants.name(continuum.peer), &nodes.mass_kg)?;
    if swapped {
        refuse_massless(interface, &mapping, &nodes, &points)?;
    }
    Ok(Seam {
        pair,
        offered: offered.len(),
        offset,
        period_m,
        mapping,
        nodes,
        points,
        active,
    })
}

fn positions(surface: &Surface) -> Vec<[f64; 2]> {
    let positions = surface.x_m.iter().zip(&surface.y_m);
    positions.map(|(x, y)| [*x, *y]).collect()
}

fn pick(surface: &Surface, indices: &[usize]) -> Surface {
    let take = |values: &Vec<f64>| indices.iter().map(|index| values[*index]).collect();
    Surface::of_columns(surface.columns().map(take))
}

/// Restricts every participant to the points of its sets that are exchanged; a layer exchanges all.
fn select(participants: &mut dyn Participants, seams: &[Seam]) -> Result<()> {
    let continua = seams.iter().map(|seam| {
        let peer = seam.pair.force_driven.peer;
        (peer, seam.offered, seam.active.clone())
    });
    let motion_driven_sides = seams.iter().map(|seam| {
        let (peer, points) = (seam.pair.motion_driven.peer, seam.points.len());
        (peer, points, (0..points).collect())
    });
    let sets: Vec<(usize, usize, Vec<usize>)> = continua.chain(motion_driven_sides).collect();
    for peer in each_once(sets.iter().map(|(peer, ..)| *peer)) {
        let (mut points, mut offset) = (Vec::new(), 0);
        for (_, offered, wanted) in sets.iter().filter(|(owner, ..)| *owner == peer) {
            points.extend(wanted.iter().map(|index| offset + index));
            offset += offered;
        }
        participants.select(peer, &points)?;
    }
    Ok(())
}

fn assemble(interfaces: &[&Interface], seams: &[Seam], clock: Clock) -> Group {
    let nodes = seams
        .iter()
        .map(|seam| (seam.pair.force_driven.peer, &seam.nodes));
    let points = seams
        .iter()
        .map(|seam| (seam.pair.motion_driven.peer, &seam.points));
    let (mut continua, motion_driven_sides) = (Row::of(nodes.collect()), Row::of(points.collect()));
    let mut mapping = Mapping::empty(continua.surface.len(), motion_driven_sides.surface.len());
    let mut patches = Vec::new();
    for (index, (interface, seam)) in interfaces.iter().zip(seams).enumerate() {
        let (force_driven, nodes) = continua.parts[index].clone();
        let (motion_driven, points) = motion_driven_sides.parts[index].clone();
        mapping.put(points.start, nodes.start, &seam.mapping);
        continua.sides[force_driven].steps = interface.substeps / clock.substeps;
        patches.push(Patch {
            index,
            name: interface.name.clone(),
            force_driven,
            motion_driven,
            outward_y: outward(
                &motion_driven_sides.surface,
                &points,
                &motion_driven_sides.sides[motion_driven].range,
            ),
            offset: seam.offset,
            period_m: seam.period_m,
            spacing_m: seam.nodes.length_m.iter().sum::<f64>() / nodes.len() as f64,
            tolerance_rel: interface.tolerance_rel,
            energy_defect_max_rel: interface.energy_defect_max_rel,
            nodes,
            points,
        });
    }
    Group {
        patches,
        force_driven: continua.sides,
        motion_driven: motion_driven_sides.sides,
        nodes: continua.surface,
        points: motion_driven_sides.surface,
        mapping,
        clock,
    }
}

/// A row above the other rows of its layer is glued to a continuum that lies on top, whose outward normal points down.
fn outward(glued: &Surface, row: &Range<usize>, motion_driven: &Range<usize>) -> f64 {
    let mean =
        |range: &Range<usize>| glued.y_m[range.clone()].iter().sum::<f64>() / range.len() as f64;
    if mean(row) > mean(motion_driven) {
        -1.0
    } else {
        1.0
    }
}

/// Surfaces of several participants in one, participant after participant.
struct Row {
    sides: Vec<Side>,
    surface: Surface,
    /// Side of each surface, and its position in the whole.
    parts: Vec<(usize, Range<usize>)>,
}

impl Row {
    fn of(surfaces: Vec<(usize, &Surface)>) -> Row {
        let mut row = Row {
            sides: Vec::new(),
            surface: Surface::default(),
            parts: vec![(0, 0..0); surfaces.len()],
        };
        for peer in each_once(surfaces.iter().map(|(peer, _)| *peer)) {
            let start = row.surface.len();
            for (index, (owner, surface)) in surfaces.iter().enumerate() {
                if *owner == peer {
                    let from = row.surface.len();
                    append(&mut row.surface, surface);
                    row.parts[index] = (row.sides.len(), from..row.surface.len());
                }
            }
            row.sides.push(Side {
                peer,
                range: start..row.surface.len(),
                steps: 1,
            });
        }
        row
    }
}

/// Adds the points of a surface to those of another.
pub fn append(whole: &mut Surface, part: &Surface) {
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
