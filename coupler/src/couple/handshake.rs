//! The handshake: who takes part, what is exchanged, and on which bounds.

use protocol::serve::{Hello, Welcome};
use protocol::{Description, Kind, PROTOCOL_VERSION, Surface, Window};

use super::clock::Clock;
use super::conversation::Conversation;
use super::mapping::Mapping;
use crate::error::Error;
use crate::scenario::{Interface, Loaded};

/// A participant that answered the greeting.
#[derive(Clone, Debug)]
pub struct Greeted {
    /// Its process.
    pub pid: u32,
    /// What it is.
    pub description: Description,
}

/// Greets all participants at once, so that their set-ups run side by side, and checks that everybody
/// speaks of the same run.
pub fn greet(
    conversation: &mut Conversation,
    loaded: &Loaded,
    run_id: u64,
) -> Result<Vec<Greeted>, Error> {
    let count = conversation.peers.len();
    for peer in 0..count {
        let hello = Hello {
            protocol: PROTOCOL_VERSION,
            run_id,
            scenario_hash: loaded.hash.clone(),
            participant: conversation.peers[peer].name().to_string(),
            units: "SI".into(),
        };
        let text = serde_json::to_string(&hello).expect("our own types always serialise");
        conversation.tell_text(peer, Kind::Hello, &text)?;
    }
    (0..count)
        .map(|peer| welcome(conversation, peer, loaded))
        .collect()
}

fn welcome(
    conversation: &mut Conversation,
    peer: usize,
    loaded: &Loaded,
) -> Result<Greeted, Error> {
    let frame = conversation.hear(peer, Kind::Welcome)?;
    let name = conversation.peers[peer].name().to_string();
    let welcome: Welcome = frame
        .text()
        .map_err(|error| error.to_string())
        .and_then(|text| serde_json::from_str(&text).map_err(|error| error.to_string()))
        .map_err(|why| {
            conversation.peers[peer].protocol(format!("sent a greeting that cannot be read: {why}"))
        })?;
    let refuse = |what: &str, theirs: String, ours: String| {
        Err(Error::Refused(format!(
            "participant `{name}` {what} {theirs}, the coordinator {ours}: build both from the same release and launch both for the same run"
        )))
    };
    if welcome.protocol != PROTOCOL_VERSION {
        return refuse(
            "speaks protocol version",
            welcome.protocol.to_string(),
            PROTOCOL_VERSION.to_string(),
        );
    }
    if welcome.scenario_hash != loaded.hash {
        return refuse(
            "was launched with scenario",
            welcome.scenario_hash,
            loaded.hash.clone(),
        );
    }
    if welcome.units != "SI" {
        return refuse("speaks units", welcome.units, "SI".into());
    }
    Ok(Greeted {
        pid: welcome.pid,
        description: welcome.description,
    })
}

/// A pair of sides that is ready for its first window.
#[derive(Clone, Debug)]
pub struct Joined {
    /// Index of the participant that takes forces.
    pub continuum: usize,
    /// Index of the participant on the wall.
    pub wall: usize,
    /// Exchanged surface nodes.
    pub nodes: Surface,
    /// Glued points.
    pub points: Surface,
    /// From exchanged nodes to glued points.
    pub mapping: Mapping,
    /// Windows in integer steps.
    pub clock: Clock,
    /// Mean spacing of the exchanged nodes (m).
    pub spacing_m: f64,
}

/// Couples the two named sets and agrees on what is exchanged.
pub fn join(
    conversation: &mut Conversation,
    interface: &Interface,
    greeted: &[Greeted],
) -> Result<Joined, Error> {
    let sides = roles(conversation, interface, greeted)?;
    let clock = clock(conversation, interface, greeted, &sides)?;
    let all_nodes = surface(conversation, sides.continuum, &sides.continuum_set)?;
    let points = surface(conversation, sides.wall, &sides.wall_set)?;
    let mapping = map(interface, &all_nodes, &points)?;
    let active = mapping.active();
    let mapping = mapping.restricted(&active);
    let nodes = pick(&all_nodes, &active);
    select(conversation, sides.continuum, &active)?;
    select(
        conversation,
        sides.wall,
        &(0..points.len()).collect::<Vec<_>>(),
    )?;
    let spacing_m = nodes.length_m.iter().sum::<f64>() / nodes.len() as f64;
    Ok(Joined {
        continuum: sides.continuum,
        wall: sides.wall,
        nodes,
        points,
        mapping,
        clock,
        spacing_m,
    })
}

struct Sides {
    continuum: usize,
    continuum_set: String,
    wall: usize,
    wall_set: String,
}

/// Which side takes forces and which stands on the wall, told by what they can do, not by their order.
fn roles(
    conversation: &Conversation,
    interface: &Interface,
    greeted: &[Greeted],
) -> Result<Sides, Error> {
    let mut continuum = None;
    let mut wall = None;
    for side in &interface.between {
        let (name, set) = side.split_once('.').unwrap_or((side, ""));
        let peer = conversation
            .peers
            .iter()
            .position(|peer| peer.name() == name)
            .ok_or_else(|| {
                Error::Refused(format!(
                    "interface `{}`: no participant `{name}`",
                    interface.name
                ))
            })?;
        let description = &greeted[peer].description;
        if !description.sets.iter().any(|known| known == set) {
            return Err(Error::Refused(format!(
                "interface `{}`: participant `{name}` has no set `{set}`; its sets: {}",
                interface.name,
                description.sets.join(", ")
            )));
        }
        let capabilities = description.capabilities;
        if !capabilities.checkpoint {
            return Err(Error::Refused(format!(
                "interface `{}`: participant `{name}` cannot repeat a window (no checkpoint), which every scheme here needs",
                interface.name
            )));
        }
        if capabilities.advance && continuum.is_none() {
            continuum = Some((peer, set.to_string()));
        } else if capabilities.compliant_wall && wall.is_none() {
            wall = Some((peer, set.to_string()));
        }
    }
    match (continuum, wall) {
        (Some((continuum, continuum_set)), Some((wall, wall_set))) => Ok(Sides {
            continuum,
            continuum_set,
            wall,
            wall_set,
        }),
        _ => Err(Error::Refused(format!(
            "interface `{}` joins {} and {}: it takes one participant that advances under forces and one that stands on a compliant wall",
            interface.name, interface.between[0], interface.between[1]
        ))),
    }
}

/// The window from the continuum's own step, checked against both sides' bounds.
fn clock(
    conversation: &Conversation,
    interface: &Interface,
    greeted: &[Greeted],
    sides: &Sides,
) -> Result<Clock, Error> {
    let name = conversation.peers[sides.continuum].name();
    let step_s = greeted[sides.continuum].description.step_s.ok_or_else(|| {
        Error::Refused(format!(
            "participant `{name}` has no step of its own, the window cannot be counted in it"
        ))
    })?;
    let clock = Clock {
        step_s,
        substeps: interface.substeps,
    };
    let wall = &greeted[sides.wall].description;
    match wall.step_limit_s {
        Some(limit) if clock.window_s() > limit => Err(Error::Refused(format!(
            "interface `{}`: the window of {} substeps x {step_s:.4e} s = {:.4e} s is above {} = {limit:.4e} s of participant `{}`; lower interface.{}.substeps to {} or less",
            interface.name,
            interface.substeps,
            clock.window_s(),
            wall.step_limit_name,
            conversation.peers[sides.wall].name(),
            interface.name,
            (limit / step_s).floor()
        ))),
        _ => Ok(clock),
    }
}

fn surface(conversation: &mut Conversation, peer: usize, set: &str) -> Result<Surface, Error> {
    conversation.tell_text(peer, Kind::Couple, set)?;
    let frame = conversation.hear(peer, Kind::Surface)?;
    Surface::from_rows(&frame.payload)
        .ok_or_else(|| conversation.peers[peer].protocol("sent an incomplete surface".into()))
}

fn map(interface: &Interface, nodes: &Surface, points: &Surface) -> Result<Mapping, Error> {
    let places = |surface: &Surface| -> Vec<[f64; 2]> {
        surface
            .x_m
            .iter()
            .zip(&surface.y_m)
            .map(|(x, y)| [*x, *y])
            .collect()
    };
    let mapping = Mapping::new(interface.mapping, &places(nodes), &places(points));
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

fn select(conversation: &mut Conversation, peer: usize, indices: &[usize]) -> Result<(), Error> {
    let payload = indices.iter().map(|index| *index as f64).collect();
    conversation
        .ask(peer, Kind::Select, Kind::Ready, &Window::default(), payload)
        .map(|_| ())
}
