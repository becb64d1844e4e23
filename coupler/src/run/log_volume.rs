//! The length of the exchange log, predicted before the first window.

use protocol::Description;

use super::time_loop::GroupRun;
use crate::log::{COUPLER, Volume};
use crate::participants::handshake::Greeted;
use crate::scenario::{CompliancePrior, Dirichlet, Scenario, Scheme};
use crate::scheme::clock::Clock;
use crate::scheme::group::Side;

/// Runs of each side in a window that is repeated once, the least of a scheme that repeats.
struct Runs {
    force_driven: u64,
    motion_driven: u64,
}

impl Runs {
    fn of(scheme: &Scheme) -> Runs {
        let both_again = matches!(
            scheme,
            Scheme::FixedPoint {
                dirichlet: Dirichlet::Continuum,
                ..
            }
        );
        let once = matches!(scheme, Scheme::Staggered { .. });
        Runs {
            force_driven: if once { 1 } else { 2 },
            motion_driven: if both_again { 2 } else { 1 },
        }
    }
}

/// Messages of a coupled run if every window is repeated once at most and none is halved: repeats, and the new walls of a
/// compliance that is learnt on the way, come on top.
pub fn coupled(scenario: &Scenario, greeted: &[Greeted], groups: &[GroupRun]) -> Volume {
    let mut volume = Volume::default();
    for (run, members) in groups.iter().zip(scenario.groups()) {
        let scheme = &scenario.interface[members[0]].scheme;
        let runs = Runs::of(scheme);
        let clock = run.coupling.group().clock;
        let windows = run.end.div_ceil(clock.substeps.into());
        volume.add_windows(windows);
        let group = run.coupling.group();
        let told = |side: &Side| (scenario.participant[side.peer].name.as_str(), side.peer);
        for side in &group.force_driven {
            let (name, peer) = told(side);
            let mut both = Both::of(&mut volume, scenario, name);
            let size = 2 * side.range.len();
            both.turn(windows * runs.force_driven, size, size * answers(scheme));
            both.turn(windows, 0, report(&greeted[peer].description));
            let capabilities = greeted[peer].description.capabilities;
            both.turn(matrices(scheme, capabilities.columns), 0, size * size);
        }
        for side in &group.motion_driven {
            let (name, peer) = told(side);
            let mut both = Both::of(&mut volume, scenario, name);
            let size = 2 * side.range.len();
            // Forces, velocities, and what the wall says of its solve.
            both.turn(windows * runs.motion_driven, size, 2 * size + 3);
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

/// Square matrices that a force-driven participant is asked for.
fn matrices(scheme: &Scheme, gives_columns: bool) -> u64 {
    match scheme {
        Scheme::DualSchur { compliance, .. } => u64::from(*compliance == CompliancePrior::Columns),
        // Its impedance, and the columns for the prediction.
        Scheme::Velocity { .. } => 1 + u64::from(gives_columns),
        // Its impedance: for the prediction, and for the components that can move at all.
        _ if scheme.dirichlet() == Dirichlet::Continuum => 2,
        _ => 0,
    }
}

/// Numbers that a force-driven participant answers for each component.
fn answers(scheme: &Scheme) -> usize {
    match scheme {
        // Force, increment and work.
        Scheme::Velocity { .. } => 3,
        _ if scheme.dirichlet() == Dirichlet::Continuum => 3,
        _ => 1,
    }
}
