//! Predicts the length of the exchange log before the first window.

use scheme::keys::connected;
use std::path::Path;

use protocol::Description;

use super::time_loop::GroupRun;
use crate::participants::handshake::Greeted;
use exchange_log::{COUPLER, Volume};
use scenario::error::{Error, Result};
use scenario::keys::Scenario;
use scheme::clock::Clock;
use scheme::keys::{CompliancePrior, CouplingScheme, Dirichlet, Update};

/// Assumed number of repeats of a window.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Repeats {
    /// One, the least of a scheme that repeats.
    Least,
    /// The most that `repeats_max` allows, for schemes that iterate to a fixed point or learn a compliance.
    Most,
}

impl Repeats {
    fn of(self, scheme: &CouplingScheme) -> u64 {
        match scheme {
            CouplingScheme::Staggered { .. } => 0,
            CouplingScheme::FixedPoint { repeats_max, .. }
            | CouplingScheme::DualSchur {
                update: Update::Secant,
                repeats_max,
                ..
            } if self == Repeats::Most => u64::from(*repeats_max).max(1),
            _ => 1,
        }
    }
}

/// Messages of a coupled run if every window takes these repeats and none is halved. New boundaries of a learnt
/// compliance come in addition.
pub fn coupled(
    scenario: &Scenario,
    greeted: &[Greeted],
    groups: &[GroupRun],
    repeats: Repeats,
) -> Volume {
    let mut volume = Volume::default();
    for (run, members) in groups.iter().zip(connected(&scenario.interface)) {
        let scheme = &scenario.interface[members[0]].scheme();
        // Runs of each side in a window.
        let again = repeats.of(scheme);
        let both_again = matches!(scheme, CouplingScheme::FixedPoint { .. })
            && scheme.dirichlet() == Dirichlet::ForceDriven;
        let force_runs = 1 + again;
        let motion_runs = if both_again { 1 + again } else { again.max(1) };
        let group = run.coupling.group();
        let windows = run.windows();
        volume.add_windows(windows);
        // One before the first window, one after the last.
        let exchanges = |every| 1 + windows.div_ceil(u64::from(every));
        let heat = group.heat_every.map_or(0, exchanges);
        for side in &group.force_driven {
            let description = &greeted[side.peer].description;
            let mut turn = turns(&mut volume, scenario, side.peer);
            let size = 2 * side.range.len();
            turn(windows * force_runs, size, size * answers(scheme));
            turn(windows, 0, report(description));
            let matrices = matrices(scheme, description.capabilities.columns);
            turn(matrices, 0, size * size);
            turn(heat, side.range.len(), side.range.len());
        }
        for side in &group.motion_driven {
            let mut turn = turns(&mut volume, scenario, side.peer);
            let size = 2 * side.range.len();
            // Forces, velocities, and the layer's numbers about its solve.
            turn(windows * motion_runs, size, 2 * size + 3);
            turn(windows, size, report(&greeted[side.peer].description));
            turn(1, 1 + size * size, 0);
            turn(heat, side.range.len(), size);
        }
    }
    volume
}

/// Messages of a solver that runs alone.
pub fn alone(scenario: &Scenario, description: &Description, clock: &Clock, end: u64) -> Volume {
    let mut volume = Volume::default();
    let windows = end.div_ceil(clock.substeps.into());
    volume.add_windows(windows);
    turns(&mut volume, scenario, 0)(windows, 0, report(description));
    volume
}

/// Adds requests to a participant and its answers: their number, and the doubles in each request and answer.
fn turns<'a>(
    volume: &'a mut Volume,
    scenario: &'a Scenario,
    peer: usize,
) -> impl FnMut(u64, usize, usize) + 'a {
    let name = scenario.participant[peer].name.as_str();
    let interface = scenario.label(name).name;
    move |times, request, answer| {
        let names = [&interface, COUPLER, name];
        volume.add(times, request, names);
        volume.add(times, answer, names);
    }
}

/// The prediction as text: the bytes of these messages, and of a run with the most repeats of each window.
pub fn line(volume: &Volume, bytes: u64, most: u64) -> String {
    let (windows, messages, bytes) = (volume.windows, volume.messages, bytes as f64);
    let most = Some(most as f64).filter(|most| *most > bytes);
    let more = |most| format!(", up to {most:.3e} bytes if each takes repeats_max");
    let more = most.map_or(String::new(), more);
    format!(
        "log: about {bytes:.3e} bytes, {windows} windows and {messages} messages if none is repeated more than once{more}"
    )
}

/// Refuses a log that does not fit on the disk.
pub fn require_space(bytes: u64, free: Option<u64>, log: &Path) -> Result<()> {
    let Some(free) = free.filter(|free| *free < bytes) else {
        return Ok(());
    };
    let why = format!(
        "the log needs about {:.3e} bytes, but the disk has {:.3e} left: make room, choose another --out, or set run.output.exchange = false",
        bytes as f64, free as f64
    );
    Err(Error::output(log.display())(std::io::Error::other(why)))
}

fn report(description: &Description) -> usize {
    description.signals.len() + description.ledger.len()
}

/// Number of square matrices that a force-driven participant sends.
fn matrices(scheme: &CouplingScheme, gives_columns: bool) -> u64 {
    match scheme {
        CouplingScheme::DualSchur { compliance, .. } => {
            u64::from(*compliance == CompliancePrior::Columns)
        }
        // Its impedance, and the columns for the prediction of stability.
        CouplingScheme::Velocity { .. } => 1 + u64::from(gives_columns),
        // Its impedance twice: for the prediction, and to find the components that can move.
        _ if scheme.dirichlet() == Dirichlet::ForceDriven => 2,
        _ => 0,
    }
}

/// Numbers in a force-driven participant's answer for each component.
fn answers(scheme: &CouplingScheme) -> usize {
    match scheme {
        // Force, increment and work.
        CouplingScheme::Velocity { .. } => 3,
        _ if scheme.dirichlet() == Dirichlet::ForceDriven => 3,
        _ => 1,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use scheme::keys::{SchemeKeys, SchemeWord};

    /// Fewest and most repeats of a scheme with this `repeats_max`.
    fn repeats(scheme: SchemeWord, repeats_max: Option<u32>) -> [u64; 2] {
        let keys = SchemeKeys {
            repeats_max,
            ..SchemeKeys::of(scheme)
        };
        [Repeats::Least, Repeats::Most].map(|repeats| repeats.of(&keys.scheme()))
    }

    #[test]
    fn schemes_that_iterate_or_learn_may_repeat_up_to_repeats_max() {
        for scheme in [
            SchemeWord::FixedPointSerial,
            SchemeWord::FixedPointParallel,
            SchemeWord::DualSchurSecant,
        ] {
            assert_eq!(repeats(scheme, Some(7)), [1, 7]);
            assert_eq!(repeats(scheme, Some(0)), [1, 1], "one repeat at least");
        }
        for scheme in [SchemeWord::DualSchur, SchemeWord::Velocity] {
            assert_eq!(repeats(scheme, Some(7)), [1, 1]);
        }
        assert_eq!(repeats(SchemeWord::StaggeredSerial, None), [0, 0]);
    }

    #[test]
    fn a_log_that_just_fits_is_written() {
        let room = |free| require_space(1000, free, Path::new("out/exchange.mcap"));
        assert!(room(Some(1000)).is_ok());
        assert!(room(None).is_ok(), "the free space is unknown");
        let refused = room(Some(999)).expect_err("a byte is missing").to_string();
        for part in ["out/exchange.mcap", "1.000e3", "9.990e2", "--out"] {
            assert!(refused.contains(part), "{part}: {refused}");
        }
    }
}
