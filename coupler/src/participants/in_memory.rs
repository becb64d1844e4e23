//! Participants in memory: solvers that are called directly, without frames, threads or deadlines.

use nalgebra::DMatrix;
use protocol::{BoundaryAnswer, Description, Node, NodeError, Reaction, Surface, Window};

use crate::error::Error;
use crate::scheme::participants::Participants;

/// Solvers by their names in the scenario. A request is answered when it is finished.
pub struct InMemory {
    participants: Vec<Participant>,
}

struct Participant {
    name: String,
    description: Description,
    node: Box<dyn Node>,
    /// The numbers of the request begun.
    asked: Vec<f64>,
    report: Vec<f64>,
}

impl InMemory {
    /// These solvers, in the order of the scenario.
    pub fn new(nodes: Vec<(String, Box<dyn Node>)>) -> InMemory {
        let participant = |(name, node): (String, Box<dyn Node>)| Participant {
            name,
            description: node.describe(),
            node,
            asked: Vec::new(),
            report: Vec::new(),
        };
        InMemory {
            participants: nodes.into_iter().map(participant).collect(),
        }
    }

    /// A request to the solver of a participant; its errors name the participant.
    fn ask<T>(
        &mut self,
        peer: usize,
        request: impl FnOnce(&mut dyn Node, &[f64]) -> Result<T, NodeError>,
    ) -> Result<T, Error> {
        let participant = &mut self.participants[peer];
        request(participant.node.as_mut(), &participant.asked)
            .map_err(|error| Error::of_participant(&participant.name, "in memory", error))
    }
}

/// Refuses answers of another length or with a number that is not finite.
fn checked(name: &str, window: &Window, n: usize, numbers: &[f64]) -> Result<(), Error> {
    if numbers.len() != n {
        return Err(Error::Protocol {
            peer: name.into(),
            phase: format!("in window {}, iteration {}", window.index, window.iteration),
            why: format!("answered {} numbers where {n} were due", numbers.len()),
        });
    }
    match numbers.iter().find(|value| !value.is_finite()) {
        None => Ok(()),
        Some(value) => Err(Error::NotFinite(format!(
            "participant `{name}` answered {value} in window {}, iteration {}: it diverged; lower its step or the window",
            window.index, window.iteration
        ))),
    }
}

impl Participants for InMemory {
    fn count(&self) -> usize {
        self.participants.len()
    }

    fn name(&self, peer: usize) -> &str {
        &self.participants[peer].name
    }

    fn description(&self, peer: usize) -> &Description {
        &self.participants[peer].description
    }

    fn couple(&mut self, peer: usize, set: &str) -> Result<Surface, Error> {
        self.ask(peer, |node, _| node.couple(set))
    }

    fn select(&mut self, peer: usize, points: &[usize]) -> Result<(), Error> {
        self.ask(peer, |node, _| node.select(points))
    }

    fn compliance(&mut self, peer: usize, substeps: u32, n: usize) -> Result<DMatrix<f64>, Error> {
        let numbers = self.ask(peer, |node, _| node.columns(substeps))?;
        checked(self.name(peer), &Window::default(), n * n, &numbers)?;
        Ok(DMatrix::from_vec(n, n, numbers))
    }

    fn impedance(&mut self, peer: usize, substeps: u32, n: usize) -> Result<DMatrix<f64>, Error> {
        let numbers = self.ask(peer, |node, _| node.impedance(substeps))?;
        checked(self.name(peer), &Window::default(), n * n, &numbers)?;
        Ok(DMatrix::from_vec(n, n, numbers))
    }

    fn set_boundary(
        &mut self,
        peer: usize,
        _window: &Window,
        window_s: f64,
        compliance: &DMatrix<f64>,
    ) -> Result<(), Error> {
        self.ask(peer, |node, _| {
            node.set_boundary(window_s, compliance.as_slice())
        })
    }

    fn begin_advance(&mut self, peer: usize, _window: &Window, force: &[f64]) -> Result<(), Error> {
        self.participants[peer].asked = force.to_vec();
        Ok(())
    }

    fn finish_advance(
        &mut self,
        peer: usize,
        window: &Window,
        n: usize,
    ) -> Result<Vec<f64>, Error> {
        let increments = self.ask(peer, |node, force| node.advance(window, force))?;
        checked(self.name(peer), window, n, &increments)?;
        Ok(increments)
    }

    fn begin_prescribed_velocity(
        &mut self,
        peer: usize,
        _window: &Window,
        velocity: &[f64],
    ) -> Result<(), Error> {
        self.participants[peer].asked = velocity.to_vec();
        Ok(())
    }

    fn finish_prescribed_velocity(
        &mut self,
        peer: usize,
        window: &Window,
        n: usize,
    ) -> Result<Reaction, Error> {
        let reaction = self.ask(peer, |node, v| node.prescribe_velocity(window, v))?;
        for numbers in [&reaction.force, &reaction.increment, &reaction.work] {
            checked(self.name(peer), window, n, numbers)?;
        }
        Ok(reaction)
    }

    fn begin_solve(
        &mut self,
        peer: usize,
        _window: &Window,
        free_velocity: &[f64],
    ) -> Result<(), Error> {
        self.participants[peer].asked = free_velocity.to_vec();
        Ok(())
    }

    fn finish_solve(
        &mut self,
        peer: usize,
        window: &Window,
        n: usize,
    ) -> Result<BoundaryAnswer, Error> {
        let answer = self.ask(peer, |node, a_g| node.solve(window, a_g))?;
        for numbers in [&answer.force, &answer.velocity] {
            checked(self.name(peer), window, n, numbers)?;
        }
        Ok(answer)
    }

    fn accept(&mut self, peer: usize, window: &Window, displacement: &[f64]) -> Result<(), Error> {
        let report = self.ask(peer, |node, _| node.commit(window, displacement))?;
        self.participants[peer].report = report;
        Ok(())
    }

    fn report(&mut self, peer: usize) -> Result<Vec<f64>, Error> {
        Ok(std::mem::take(&mut self.participants[peer].report))
    }
}
