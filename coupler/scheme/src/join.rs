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
use crate::error::{Result, SchemeError, Unfit};
use crate::keys::{Dirichlet, Interface, MappingKind, connected};
use geometry::{common_period, offset, same_side};
use point_mass::{point_masses, refuse_massless};
use suitability::{refuse_unsuited, refuse_weightless};

/// Largest relative difference between the windows of connected interfaces that counts as rounding.
const SAME_WINDOW: f64 = 1e-9;

/// Couples the named sets of all interfaces, group by group, and agrees on the exchanged points.
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
        let peers = [pair.force_driven.peer, pair.motion_driven.peer];
        let sides = peers.map(|peer| (participants.name(peer), participants.description(peer)));
        refuse_unsuited(interface, sides)?;
        pairs.push(pair);
    }
    refuse_two_roles(participants, &pairs)?;
    let heat_every = heat_every(participants, &interfaces, &pairs)?;
    let clock = clock(participants, &interfaces, &pairs)?;
    let pairs = interfaces.iter().zip(pairs);
    let seams = pairs.map(|(interface, pair)| seam(participants, interface, pair));
    let seams = seams.collect::<Result<Vec<Seam>>>()?;
    refuse_shared(participants, &interfaces, &seams)?;
    select(participants, &seams)?;
    Ok(Group {
        heat_every,
        ..assemble(&interfaces, &seams, clock)
    })
}

/// Windows from one exchange of heat to the next, the same for all interfaces of the group.
fn heat_every(
    participants: &dyn Participants,
    interfaces: &[&Interface],
    pairs: &[Pair],
) -> Result<Option<u32>> {
    let first = interfaces[0].heat_every_windows;
    for (interface, pair) in interfaces.iter().zip(pairs) {
        let peers = [pair.force_driven.peer, pair.motion_driven.peer];
        let cold = |peer: &usize| !participants.description(*peer).capabilities.heat;
        let problem = match (interface.heat_every_windows, peers.into_iter().find(cold)) {
            (every, _) if every != first => {
                let leader = &interfaces[0].name;
                format!("differs from the one of `{leader}`: interfaces that share a participant all exchange heat, or none does: give both the same number, or remove it and the heat of one side")
            }
            (Some(_), Some(peer)) => {
                let name = participants.name(peer);
                format!("exchanges heat, but participant `{name}` has none there: give it `heat`, or remove the key")
            }
            (None, None) => "is missing: both sides have heat: write heat_every_windows = 20, or remove the heat of one".into(),
            _ => continue,
        };
        return Err(Unfit::interface_key(interface, "heat_every_windows", problem).into());
    }
    Ok(first)
}

/// A set of a participant.
#[derive(PartialEq)]
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
    /// The exchanged points among them.
    active: Vec<usize>,
    nodes: Surface,
    points: Surface,
    mapping: Mapping,
    offset: Offset,
    period_m: Option<f64>,
    /// [`Patch::outward_y`], if the continuum describes its normal.
    outward_y: Option<f64>,
    /// [`Patch::outward`], if the continuum describes its normal.
    outward: Option<[f64; 2]>,
}

/// The side that takes forces and the one that stands on a boundary. Their capabilities decide, not their order.
fn roles(participants: &mut dyn Participants, interface: &Interface) -> Result<Pair> {
    let (mut continuum, mut motion_driven) = (None, None);
    for side in &interface.between {
        let (name, set) = side.split_once('.').unwrap_or((side, ""));
        let peer = (0..participants.count()).find(|peer| participants.name(*peer) == name);
        let unknown = || Unfit::interface(&interface.name, format!("no participant `{name}`"));
        let peer = peer.ok_or_else(unknown)?;
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
            // It cannot take part. Its own refusal names the key to blame; ours is for a participant that names no key.
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

/// A participant answers either motion or force in a window, the same on all of its interfaces.
fn refuse_two_roles(participants: &dyn Participants, pairs: &[Pair]) -> Result<()> {
    let layers: Vec<usize> = pairs.iter().map(|pair| pair.motion_driven.peer).collect();
    let mut continua = pairs.iter().map(|pair| pair.force_driven.peer);
    let Some(peer) = continua.find(|peer| layers.contains(peer)) else {
        return Ok(());
    };
    let problem = "would take forces on one interface and stand on a wall on another: a participant must have the same role on all of its interfaces";
    Err(Unfit::participant(participants.name(peer), problem).into())
}

/// A row of a layer stands on one body. A set of a body may carry several layers, each on its own nodes: a node cannot
/// follow two layers.
fn refuse_shared(
    participants: &dyn Participants,
    interfaces: &[&Interface],
    seams: &[Seam],
) -> Result<()> {
    let pairs = (0..seams.len()).flat_map(|second| (0..second).map(move |first| [first, second]));
    for [first, second] in pairs {
        let [theirs, ours] = [first, second].map(|index| &seams[index]);
        let same_row = ours.pair.motion_driven == theirs.pair.motion_driven;
        let same_set = ours.pair.force_driven == theirs.pair.force_driven;
        let mut nodes = ours.active.iter();
        let shared = nodes.position(|node| same_set && theirs.active.contains(node));
        let (end, why) = match shared {
            _ if same_row => {
                let why = "and stands on one body: name another set".to_string();
                (&ours.pair.motion_driven, why)
            }
            Some(at) => {
                let [x, y] = [&ours.nodes.x_m, &ours.nodes.y_m].map(|of| of[at]);
                let why = format!(
                    "with the node at ({x:.6e}, {y:.6e}) m, which cannot carry two layers: move the layers apart, or use smaller elements"
                );
                (&ours.pair.force_driven, why)
            }
            None => continue,
        };
        let (name, set) = (participants.name(end.peer), &end.set);
        let [before, interface] = [first, second].map(|index| interfaces[index].name.clone());
        let problem =
            format!("`{name}.{set}` is already joined by the interface `{before}`, {why}");
        return Err(Unfit::SetTwice { interface, problem }.into());
    }
    Ok(())
}

/// The windows of the group, from the steps of its continua and within the bounds of its layers.
fn clock(
    participants: &dyn Participants,
    interfaces: &[&Interface],
    pairs: &[Pair],
) -> Result<Clock> {
    let mut first: Option<(&Interface, Clock)> = None;
    let mut common = 0;
    for (interface, pair) in interfaces.iter().zip(pairs) {
        let continuum = pair.force_driven.peer;
        let own = participants.description(continuum).step_s;
        let step_s = step_of(interface, participants.name(continuum), own)?;
        let substeps = interface.substeps();
        let clock = Clock { step_s, substeps };
        refuse_above_limit(participants, interface, clock, pair.motion_driven.peer)?;
        let (leader, leading) = *first.get_or_insert((interface, clock));
        let leading_s = leading.window_s();
        if (clock.window_s() - leading_s).abs() > SAME_WINDOW * leading_s {
            let written = |of: Clock| {
                let (window_s, Clock { step_s, substeps }) = (of.window_s(), of);
                format!("{window_s:.9e} s ({substeps} x {step_s:.9e} s)")
            };
            return Err(SchemeError::from(Unfit::Windows {
                interfaces: [leader, interface].map(|of| of.name.clone()),
                windows: [leading, clock].map(written),
            }));
        }
        common = greatest_common_divisor(common, substeps);
    }
    let (_, leading) = first.expect("a group has an interface");
    Ok(Clock {
        step_s: leading.step_s * f64::from(leading.substeps / common),
        substeps: common,
    })
}

/// The step (s) in which the windows of an interface are counted; `own` is the continuum's own step.
pub fn step_of(interface: &Interface, continuum: &str, own: Option<f64>) -> Result<f64> {
    let problem = match (own, interface.window_s) {
        (Some(step_s), None) => return Ok(step_s),
        (None, Some(window_s)) => return Ok(window_s / f64::from(interface.substeps())),
        (None, None) => format!(
            "is missing: participant `{continuum}` has no step of its own, so this key must give the window"
        ),
        (Some(step_s), Some(_)) => format!(
            "is for a continuum without a step of its own, but participant `{continuum}` has a step of {step_s:e} s: remove the key and give substeps"
        ),
    };
    Err(Unfit::interface_key(interface, "window_s", problem).into())
}

fn refuse_above_limit(
    participants: &dyn Participants,
    interface: &Interface,
    clock: Clock,
    layer: usize,
) -> Result<()> {
    let (name, layer) = (participants.name(layer), participants.description(layer));
    let (window_s, Clock { step_s, substeps }) = (clock.window_s(), clock);
    let Some(limit) = layer.step_limit_s.filter(|limit| window_s > *limit) else {
        return Ok(());
    };
    let problem = format!(
        "the window of {substeps} substeps x {step_s:.4e} s = {window_s:.4e} s is above {} = {limit:.4e} s of participant `{name}`; lower interface.{}.substeps to {} or less",
        layer.step_limit_name,
        interface.name,
        (limit / step_s).floor()
    );
    let interface = interface.name.clone();
    Err(Unfit::WindowTooLong { interface, problem }.into())
}

fn greatest_common_divisor(a: u32, b: u32) -> u32 {
    match b {
        0 => a,
        b => greatest_common_divisor(b, a % b),
    }
}

fn seam(participants: &mut dyn Participants, interface: &Interface, pair: Pair) -> Result<Seam> {
    let [continuum, layer] = [&pair.force_driven, &pair.motion_driven];
    let offered = participants.couple(continuum.peer, &continuum.set)?;
    let mut points = participants.couple(layer.peer, &layer.set)?;
    let description = participants.description(layer.peer);
    let swapped = interface.scheme().dirichlet() == Dirichlet::ForceDriven;
    if swapped {
        let name = participants.name(layer.peer);
        points.mass_kg = point_masses(interface, name, &layer.set, description, points.len())?;
    }
    let refuse = |why: String| {
        SchemeError::from(Unfit::Geometry {
            interface: interface.name.clone(),
            between: interface.between.clone(),
            why,
        })
    };
    let normal = |end: &End| participants.description(end.peer).outward.get(&end.set);
    let normal_y = normal(continuum).map(|[_, y]| *y);
    let outward_y = normal_y.filter(|y| *y != 0.0).map(f64::signum);
    let described = normal(continuum).copied();
    let normals = normal(continuum).zip(normal(layer));
    if let Some(why) = normals.and_then(same_side) {
        return Err(refuse(why));
    }
    let sides = [continuum, layer].map(|end| {
        let period_m = participants.description(end.peer).period_m.get(&end.set);
        let name = format!("{}.{}", participants.name(end.peer), end.set);
        (name, period_m.copied())
    });
    let period_m = common_period(sides).map_err(refuse)?;
    let (nodes, glued) = (positions(&offered), positions(&points));
    let relate = |kind| {
        let mapping = Mapping::new(kind, &nodes, &glued, period_m);
        mapping.map_err(|error| refuse(error.to_string()))
    };
    let smooth = description.smooth_m.get(&layer.set);
    let shape = smooth.filter(|positions| positions.len() == glued.len());
    let linear = relate(MappingKind::Linear)?;
    let mut offset = offset(&linear, &nodes, shape.unwrap_or(&glued), period_m);
    let without_width = match interface.mapping {
        MappingKind::Mortar => None,
        MappingKind::Linear => Some(2.0),
        MappingKind::Nearest => Some(4.0),
    };
    if let Some(times) = without_width {
        (offset.hole_rel, offset.spacing_rel) = (0.0, times * offset.spacing_rel);
    }
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
        outward_y,
        outward: described,
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

/// Restricts every participant to the exchanged points of its sets; a layer exchanges all of its points.
fn select(participants: &mut dyn Participants, seams: &[Seam]) -> Result<()> {
    let continua = seams.iter().map(|seam| {
        let peer = seam.pair.force_driven.peer;
        (peer, seam.offered, seam.active.clone())
    });
    let layers = seams.iter().map(|seam| {
        let (peer, points) = (seam.pair.motion_driven.peer, seam.points.len());
        (peer, points, (0..points).collect())
    });
    let sets: Vec<(usize, usize, Vec<usize>)> = continua.chain(layers).collect();
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
    let nodes = |seam: &Seam| (seam.pair.force_driven.peer, seam.nodes.clone());
    let points = |seam: &Seam| (seam.pair.motion_driven.peer, seam.points.clone());
    let mut continua = SideSurfaces::of(seams.iter().map(nodes).collect());
    let layers = SideSurfaces::of(seams.iter().map(points).collect());
    let mut mapping = Mapping::empty(continua.surface.len(), layers.surface.len());
    let mut patches = Vec::new();
    for (index, (interface, seam)) in interfaces.iter().zip(seams).enumerate() {
        let (force_driven, nodes) = continua.parts[index].clone();
        let (motion_driven, points) = layers.parts[index].clone();
        let all_points = &layers.sides[motion_driven].range;
        mapping.put(points.start, nodes.start, &seam.mapping);
        continua.sides[force_driven].steps = interface.substeps() / clock.substeps;
        let of_rows = || outward(&layers.surface, &points, all_points);
        let outward_y = seam.outward_y.unwrap_or_else(of_rows);
        patches.push(Patch {
            index,
            name: interface.name.clone(),
            force_driven,
            motion_driven,
            outward_y,
            outward: seam.outward.unwrap_or([0.0, outward_y]),
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
        motion_driven: layers.sides,
        nodes: continua.surface,
        points: layers.surface,
        mapping,
        clock,
        heat_every: None,
    }
}

/// [`Patch::outward_y`] from the rows alone. A row above the layer's other rows is glued to a continuum on top, whose
/// outward normal points down. The only row of a layer counts as its lower one.
fn outward(glued: &Surface, row: &Range<usize>, layer: &Range<usize>) -> f64 {
    let sum = |range: &Range<usize>| glued.y_m[range.clone()].iter().sum::<f64>();
    let mean = |range: &Range<usize>| sum(range) / range.len() as f64;
    if mean(row) > mean(layer) { -1.0 } else { 1.0 }
}

/// The surfaces of several participants as one, participant after participant.
struct SideSurfaces {
    sides: Vec<Side>,
    surface: Surface,
    /// Side of each surface, and its range in the whole.
    parts: Vec<(usize, Range<usize>)>,
}

impl SideSurfaces {
    fn of(surfaces: Vec<(usize, Surface)>) -> SideSurfaces {
        let mut all = SideSurfaces {
            sides: Vec::new(),
            surface: Surface::default(),
            parts: vec![(0, 0..0); surfaces.len()],
        };
        for peer in each_once(surfaces.iter().map(|(peer, _)| *peer)) {
            let start = all.surface.len();
            for (index, (owner, surface)) in surfaces.iter().enumerate() {
                if *owner == peer {
                    let from = all.surface.len();
                    append(&mut all.surface, surface);
                    all.parts[index] = (all.sides.len(), from..all.surface.len());
                }
            }
            let range = start..all.surface.len();
            all.sides.push(Side {
                peer,
                range,
                steps: 1,
            });
        }
        all
    }
}

/// Appends the points of one surface to another.
pub fn append(whole: &mut Surface, part: &Surface) {
    whole.x_m.extend(&part.x_m);
    whole.y_m.extend(&part.y_m);
    whole.mass_kg.extend(&part.mass_kg);
    whole.radius_m.extend(&part.radius_m);
    whole.length_m.extend(&part.length_m);
}

/// Each number once, in the order of first appearance.
fn each_once(numbers: impl Iterator<Item = usize>) -> Vec<usize> {
    let mut seen = Vec::new();
    for number in numbers {
        if !seen.contains(&number) {
            seen.push(number);
        }
    }
    seen
}
