//! What a run will say, told before its first window.

use protocol::Description;

use super::clock::Clock;
use super::conversation::COUPLER;
use super::course::Course;
use super::group::Side;
use super::handshake::Greeted;
use crate::log::Volume;
use crate::scenario::{CompliancePrior, Dirichlet, Interface, Scenario, Scheme};

/// Runs of each kind of solver in a window that is repeated once, the least of a scheme that repeats.
struct Runs {
    continuum: u64,
    wall: u64,
}

impl Runs {
    fn of(rules: &Interface) -> Runs {
        match rules.scheme {
            Scheme::FixedPointSerial | Scheme::FixedPointParallel
                if rules.dirichlet == Dirichlet::Continuum =>
            {
                Runs {
                    continuum: 2,
                    wall: 2,
                }
            }
            Scheme::StaggeredSerial | Scheme::StaggeredParallel => Runs {
                continuum: 1,
                wall: 1,
            },
            Scheme::DualSchur
            | Scheme::DualSchurSecant
            | Scheme::DualSchurCheap
            | Scheme::FixedPointSerial
            | Scheme::FixedPointParallel
            | Scheme::Velocity => Runs {
                continuum: 2,
                wall: 1,
            },
        }
    }
}

/// Messages of a coupled run if every window is repeated once at most and none is halved: repeats, and the new walls of a
/// compliance that is learnt on the way, come on top.
pub fn coupled(scenario: &Scenario, greeted: &[Greeted], courses: &[Course]) -> Volume {
    let mut volume = Volume::default();
    for (course, members) in courses.iter().zip(scenario.groups()) {
        let rules = &scenario.interface[members[0]];
        let runs = Runs::of(rules);
        let clock = course.coupling.group().clock;
        let windows = course.end.div_ceil(clock.substeps.into());
        volume.add_windows(windows);
        let group = course.coupling.group();
        let told = |side: &Side| (scenario.participant[side.peer].name.as_str(), side.peer);
        for side in &group.continua {
            let (name, peer) = told(side);
            let mut both = Both::of(&mut volume, scenario, name);
            let size = 2 * side.places.len();
            both.turn(windows * runs.continuum, size, size * answers(rules));
            both.turn(windows, 0, report(&greeted[peer].description));
            let capabilities = greeted[peer].description.capabilities;
            both.turn(matrices(rules, capabilities.columns), 0, size * size);
        }
        for side in &group.walls {
            let (name, peer) = told(side);
            let mut both = Both::of(&mut volume, scenario, name);
            let size = 2 * side.places.len();
            // Forces, velocities, and what the wall says of its solve.
            both.turn(windows * runs.wall, size, 2 * size + 3);
            both.turn(windows, size, report(&greeted[peer].description));
            both.turn(1, 1 + size * size, 0);
        }
    }
    volume
}

/// Messages of a solver that runs alone.
pub fn alone(scenario: &Scenario, description: &Description, clock: &Clock, end: u64) -> Volume {
    let mut volume = Volume::default();
    let windows = end.div_ceil(clock.substeps.into());
    volume.add_windows(windows);
    Both::of(&mut volume, scenario, &scenario.participant[0].name).turn(
        windows,
        0,
        report(description),
    );
    volume
}

/// The prediction for a person.
pub fn line(volume: &Volume, bytes: u64) -> String {
    format!(
        "log: about {:.3e} bytes, {} windows and {} messages if none is repeated more than once",
        bytes as f64, volume.windows, volume.messages
    )
}

/// Requests to a participant, and its answers.
struct Both<'a> {
    volume: &'a mut Volume,
    interface: String,
    name: &'a str,
}

impl<'a> Both<'a> {
    fn of(volume: &'a mut Volume, scenario: &Scenario, name: &'a str) -> Both<'a> {
        Both {
            volume,
            interface: scenario.label(name).name,
            name,
        }
    }

    fn turn(&mut self, times: u64, request: usize, answer: usize) {
        let names = [&self.interface, COUPLER, self.name];
        self.volume.add(times, request, names);
        self.volume.add(times, answer, names);
    }
}

fn report(description: &Description) -> usize {
    description.signals.len() + description.ledger.len()
}

/// Square matrices that a continuum is asked for.
fn matrices(rules: &Interface, gives_columns: bool) -> u64 {
    match rules.scheme {
        Scheme::DualSchur | Scheme::DualSchurSecant | Scheme::DualSchurCheap => {
            u64::from(rules.compliance == CompliancePrior::Columns)
        }
        // Its impedance, and the columns for what is foreseen.
        Scheme::Velocity => 1 + u64::from(gives_columns),
        // Its impedance: what it tells of stability, and what can move at all.
        _ if rules.dirichlet == Dirichlet::Continuum => 2,
        _ => 0,
    }
}

/// Numbers that a continuum answers for each component.
fn answers(rules: &Interface) -> usize {
    match (rules.scheme, rules.dirichlet) {
        // Force, increment and work.
        (Scheme::Velocity, _) | (_, Dirichlet::Continuum) => 3,
        _ => 1,
    }
}
