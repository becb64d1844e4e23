//! The time loop: groups of interfaces advance in time, window by window.

use scheme::keys::connected;
use std::ops::ControlFlow;

use protocol::{Window, larger};

use super::position::{GroupPosition, RunPosition};
use crate::participants::Communicator;
use crate::participants::handshake::Greeted;
use crate::participants::remote::Remote;
use scenario::error::{Code, Refusal, Result};
use scenario::keys::Scenario;
use scheme::clock::Clock;
use scheme::coupling::Coupling;
use scheme::group::Group;
use scheme::participants::Participants;
use scheme::window::{AcceptedWindow, Attempt};

/// A group of interfaces with its progress in time.
pub struct GroupRun {
    /// Its coupling.
    pub coupling: Coupling,
    /// Number of steps of its clock until the end.
    pub end: u64,
    /// Its progress.
    pub at: GroupPosition,
}

/// All groups at their start.
pub fn groups_at_start(
    scenario: &Scenario,
    greeted: &[Greeted],
    groups: Vec<Group>,
) -> Result<Vec<GroupRun>> {
    let end_s = end_s(scenario, greeted)?;
    let rules = connected(&scenario.interface);
    let start = |(group, members): (Group, Vec<usize>)| {
        // Connected interfaces agree on scheme and policy.
        let first = &scenario.interface[members[0]];
        Ok(GroupRun {
            end: group.clock.steps_until(end_s)?,
            coupling: Coupling::new(&first.name, first.scheme(), first.on_not_converged, group),
            at: GroupPosition::default(),
        })
    };
    groups.into_iter().zip(rules).map(start).collect()
}

/// `run.end_s`, or the end of the longest load history.
pub fn end_s(scenario: &Scenario, greeted: &[Greeted]) -> Result<f64> {
    let ends = greeted.iter().filter_map(|one| one.description.end_s);
    let end_s = scenario.run.end_s.or(ends.reduce(larger));
    let text = "no participant has a load history that ends: give run.end_s";
    end_s.ok_or_else(|| Refusal::other(Code::NoEnd, text).into())
}

/// Runs all windows of all groups until their end, in the order in which the windows end; it halves windows if the
/// policy asks for it. `seen` gets each accepted window, and may end the loop.
pub fn each_window<C, F>(
    communicator: &mut C,
    greeted: &[Greeted],
    groups: &mut [GroupRun],
    mut seen: F,
) -> Result<()>
where
    C: Communicator,
    F: FnMut(&mut C, &[GroupRun], &Window, AcceptedWindow) -> Result<ControlFlow<()>>,
{
    while let Some((index, window)) = earliest(groups) {
        let remote = &mut Remote::new(communicator, greeted);
        let (window, accepted) = groups[index].advance(remote, window)?;
        communicator.end_window(window.index)?;
        if seen(communicator, groups, &window, accepted)?.is_break() {
            break;
        }
    }
    Ok(())
}

/// The group whose next window ends first; among equal ones the first group.
fn earliest(groups: &[GroupRun]) -> Option<(usize, Window)> {
    let next = groups.iter().enumerate();
    next.filter_map(|(index, group)| group.next().map(|window| (index, window)))
        .min_by(|(_, a), (_, b)| a.t1_s.total_cmp(&b.t1_s))
}

/// Time that all groups have reached (s).
pub fn reached_s(groups: &[GroupRun]) -> f64 {
    let reached = |run: &GroupRun| run.at.step as f64 * run.coupling.group().clock.step_s;
    groups.iter().map(reached).fold(f64::INFINITY, f64::min)
}

/// The position of all groups together.
pub fn position(groups: &[GroupRun]) -> RunPosition {
    RunPosition {
        windows: groups.iter().map(|group| group.at.window).sum(),
        t_s: reached_s(groups),
        groups: groups.iter().map(|group| group.at).collect(),
        over: groups.iter().all(|group| group.next().is_none()),
    }
}

impl GroupRun {
    /// Windows until its end, if none is halved.
    pub fn windows(&self) -> u64 {
        self.end
            .div_ceil(self.coupling.group().clock.substeps.into())
    }

    /// The next window, unless all are done.
    pub fn next(&self) -> Option<Window> {
        window_from(&self.coupling.group().clock, &self.at, self.end)
    }

    /// Runs its next window, or the part that converges.
    fn advance(
        &mut self,
        participants: &mut dyn Participants,
        mut window: Window,
    ) -> Result<(Window, AcceptedWindow)> {
        self.at.rest = None;
        let clock = self.coupling.group().clock;
        let accepted = loop {
            let (end, rest) = (self.end, self.at.rest);
            let following = |done: &Window| {
                let after = GroupPosition {
                    window: done.index + 1,
                    step: done.step + u64::from(done.substeps),
                    rest,
                };
                window_from(&clock, &after, end)
            };
            match self.coupling.window(participants, window, following)? {
                Attempt::Accepted(accepted) => break accepted,
                Attempt::Halve => {
                    self.at.rest = Some(self.at.rest.unwrap_or(0) + window.substeps / 2);
                    let half = window.substeps.div_ceil(2);
                    window = clock.window(self.at.window, self.at.step, half);
                }
            }
        };
        self.at.window += 1;
        self.at.step += u64::from(window.substeps);
        Ok((window, accepted))
    }
}

/// The window that begins here: the rest of a halved window, or a full one, or the part left before the end.
fn window_from(clock: &Clock, at: &GroupPosition, end: u64) -> Option<Window> {
    let substeps = || clock.substeps_before(at.step, end);
    (at.step < end).then(|| {
        let substeps = at.rest.unwrap_or_else(substeps);
        clock.window(at.window, at.step, substeps)
    })
}

/// A line for the log of a run.
pub fn describe(group: &GroupRun) -> String {
    let joined = group.coupling.group();
    let clock = joined.clock;
    format!(
        "{} windows of {:.4e} s ({} steps of {:.4e} s), {} nodes, {} glued points",
        group.windows(),
        clock.window_s(),
        clock.substeps,
        clock.step_s,
        joined.nodes.len(),
        joined.points.len()
    )
}
