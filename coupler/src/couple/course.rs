//! Groups of interfaces on their way through time: which window comes next, and what is left of a halved one.

use protocol::Window;

use super::clock::Clock;
use super::conversation::Conversation;
use super::group::Group;
use super::handshake::Greeted;
use super::join::join;
use super::scheme::{Attempt, Coupling, Standing};
use crate::checkpoint::{Origin, Place, Position};
use crate::error::Error;
use crate::scenario::Scenario;

/// A group of interfaces on its way through time.
pub struct Course {
    /// Its coupling.
    pub coupling: Coupling,
    /// Steps of its clock to do.
    pub end: u64,
    /// Steps done.
    pub step: u64,
    /// Windows done.
    pub index: u64,
    /// What is left of a halved window, to be done before the next full one.
    rest: Option<u32>,
}

impl Position {
    /// Where groups stand that have come so far.
    pub(super) fn of(courses: &[Course]) -> Position {
        Position {
            windows: courses.iter().map(|course| course.index).sum(),
            t_s: reached_s(courses),
            courses: courses.iter().map(Course::place).collect(),
            over: courses.iter().all(|course| course.next().is_none()),
        }
    }
}

impl Course {
    /// Where it goes on.
    fn place(&self) -> Place {
        Place {
            window: self.index,
            step: self.step,
            rest: self.rest,
        }
    }

    /// Puts it where a checkpoint left off.
    pub fn go_to(&mut self, place: &Place) {
        self.index = place.window;
        self.step = place.step;
        self.rest = place.rest;
    }

    /// Time that stands (s).
    pub fn reached_s(&self) -> f64 {
        self.step as f64 * self.coupling.group().clock.step_s
    }

    /// The next window, unless all are done.
    pub(super) fn next(&self) -> Option<Window> {
        let clock = self.coupling.group().clock;
        window_from(&clock, (self.index, self.step), self.end, self.rest)
    }

    /// Does its next window, or as much of it as the scheme lets stand.
    fn advance(
        &mut self,
        conversation: &mut Conversation,
        mut window: Window,
    ) -> Result<(Window, Standing), Error> {
        self.rest = None;
        let clock = self.coupling.group().clock;
        let standing = loop {
            let (end, rest) = (self.end, self.rest);
            let following = |done: &Window| {
                let step = done.step + u64::from(done.substeps);
                window_from(&clock, (done.index + 1, step), end, rest)
            };
            match self.coupling.window(conversation, window, following)? {
                Attempt::Standing(standing) => break standing,
                Attempt::Halve => {
                    self.rest = Some(self.rest.unwrap_or(0) + window.substeps / 2);
                    window = clock.window(self.index, self.step, window.substeps.div_ceil(2));
                }
            }
        };
        self.index += 1;
        self.step += u64::from(window.substeps);
        Ok((window, standing))
    }
}

/// The window that begins here: what is left of a halved one, else a full one or what the end leaves of it.
fn window_from(
    clock: &Clock,
    (index, step): (u64, u64),
    end: u64,
    rest: Option<u32>,
) -> Option<Window> {
    let substeps = || clock.substeps_before(step, end);
    (step < end).then(|| clock.window(index, step, rest.unwrap_or_else(substeps)))
}

/// Time up to which all groups stand (s).
pub(super) fn reached_s(courses: &[Course]) -> f64 {
    courses
        .iter()
        .map(Course::reached_s)
        .fold(f64::INFINITY, f64::min)
}

/// All groups at their start.
pub(super) fn courses(
    scenario: &Scenario,
    greeted: &[Greeted],
    groups: Vec<Group>,
) -> Result<Vec<Course>, Error> {
    let end_s = end_s(scenario, greeted)?;
    let rules = scenario.groups();
    let course = |(group, members): (Group, Vec<usize>)| {
        Ok(Course {
            end: group.clock.steps_until(end_s)?,
            coupling: Coupling::new(&scenario.interface[members[0]], group),
            step: 0,
            index: 0,
            rest: None,
        })
    };
    groups.into_iter().zip(rules).map(course).collect()
}

pub(super) fn describe(course: &Course) -> String {
    let group = course.coupling.group();
    let clock = group.clock;
    format!(
        "{} windows of {:.4e} s ({} steps of {:.4e} s), {} nodes, {} glued points",
        course.end.div_ceil(clock.substeps.into()),
        clock.window_s(),
        clock.substeps,
        clock.step_s,
        group.nodes.len(),
        group.points.len()
    )
}

/// All windows of all groups until their end, in the order in which the windows end; windows are halved where the
/// scheme asks for it. `seen` is told of each window that stands, and once, without one, when a window failed.
pub(super) fn each_window<F>(
    conversation: &mut Conversation,
    courses: &mut [Course],
    mut seen: F,
) -> Result<(), Error>
where
    F: FnMut(&mut Conversation, &[Course], Option<(&Window, &Standing)>) -> Result<(), Error>,
{
    while let Some((index, window)) = earliest(courses) {
        match courses[index].advance(conversation, window) {
            Ok((window, standing)) => seen(conversation, courses, Some((&window, &standing)))?,
            Err(error) => {
                seen(conversation, courses, None)?;
                return Err(error);
            }
        }
    }
    Ok(())
}

/// The group whose next window ends first, of equal ones the first.
fn earliest(courses: &[Course]) -> Option<(usize, Window)> {
    let next = courses.iter().enumerate();
    next.filter_map(|(index, course)| course.next().map(|window| (index, window)))
        .min_by(|(_, a), (_, b)| a.t1_s.total_cmp(&b.t1_s))
}

/// The whole coupled conversation without outputs: what a replay of the coupler runs against tapes.
pub fn windows(
    conversation: &mut Conversation,
    scenario: &Scenario,
    greeted: &[Greeted],
    from: Option<&Origin>,
) -> Result<(), Error> {
    if scenario.interface.is_empty() {
        return Err(Error::Refused(
            "a solver that ran alone has no coupler to replay".into(),
        ));
    }
    let groups = join(conversation, scenario, greeted)?;
    let mut courses = courses(scenario, greeted, groups)?;
    match from {
        Some(origin) => origin.place(&mut courses)?,
        None => {
            for course in &mut courses {
                course.coupling.foresee(conversation, greeted)?;
            }
        }
    }
    each_window(conversation, &mut courses, |_, _, _| Ok(()))
}

/// `run.end_s`, or the end of the longest load history.
pub(super) fn end_s(scenario: &Scenario, greeted: &[Greeted]) -> Result<f64, Error> {
    let longest = greeted
        .iter()
        .filter_map(|greeted| greeted.description.end_s)
        .fold(None, |longest: Option<f64>, end| {
            Some(longest.map_or(end, |l| l.max(end)))
        });
    scenario.run.end_s.or(longest).ok_or_else(|| {
        Error::Refused("no participant has a load history that ends: give run.end_s".into())
    })
}
