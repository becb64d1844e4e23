//! Explicit time integration, and the energies that it moves.
//!
//! The scheme is Newmark's with beta = 0 and gamma = b (the paper's eq 12, regrouped so that a force that begins
//! at t_n acts from t_n on), C_d = c M the mass damping, f the sum of all applied forces:
//!
//! ```text
//! a  = M^-1 (f - F(u) - C_d v)                        at the start of a window
//! u' = u + h v + h^2/2 a                              then m times
//! a' = M^-1 (f' - F(u') - C_d v')
//! v' = v + h [(1-b) a + b a']
//! ```
//!
//! C_d is diagonal like M, so v' in a' costs nothing: with p = M^-1 (f' - F(u')),
//! a' = p - c (v + h [(1-b) a + b p]) / (1 + b h c). The limit h < sqrt(2/b)/omega_max then holds for any c: for one
//! mode 1 + trace + det = (4 - 2 b (omega h)^2 + 2 (2b-1) c h) / (1 + b c h). Taking v instead of v' in a' was tried:
//! the damping lags by a step and feeds the modes above omega h = sqrt(2) when b = 1/2.
//!
//! Stiffness damping, C = c M + beta K (Rayleigh 1877, section 102), takes the mean velocity of the step that ends,
//!
//! ```text
//! d' = beta K (u'-u)/h = (beta/h) (F(u') - F(u)),     a' = M^-1 (f' - F(u') - d' - C_d v')
//! ```
//!
//! which needs no second look at the elements. For one mode z (z-1)^2 = -(omega h)^2 [(1/2-b) + (b+1/2) z] [(1+r) z - r],
//! r = beta/h. Its root -1 gives 2 b (omega h)^2 (1 + 2 r) = 4: with xi = beta omega/2 at the largest omega
//! h < (sqrt(2/b + 4 xi^2) - 2 xi)/omega_max, for b = 1/2 the (2/omega_max) (sqrt(1 + xi^2) - xi) of Belytschko, Liu and
//! Moran (2000), section 6.2.
//!
//! # Energy of one step
//! Write du = u'-u, da = a'-a, dF = F(u')-F(u). From the scheme h v = du - h^2/2 a, and the kinetic energy
//! K = v M v / 2 changes by
//!
//! ```text
//! dK = (v'-v) M (v + (v'-v)/2)
//!    = [(1-b) a + b a'] M du + (b h^2/2) [(1-b) a + b a'] M da
//! ```
//!
//! In the first term M a = f - F - C_d v, so it is W - [(1-b) F + b F'] du - D with
//!
//! ```text
//! W = [(1-b) f + b f'] du                             work of the applied forces
//! D = [(1-b) v + b v'] C_d du                         mass damping
//! ```
//!
//! (stiffness damping takes [(1-b) d + b d'] du in the same way)
//!
//! and (1-b) F + b F' = (F + F')/2 + (b-1/2) dF, where (F + F') du / 2 is the change of the strain energy.
//! In the second term (1-b) a + b a' = (a + a')/2 + (b-1/2) da. What is left is the numerical loss
//!
//! ```text
//! W - dU - dK - D = (b-1/2) (du dF - b h^2/2 da M da) - (b h^2/4) (a'Ma' - aMa)
//! ```
//!
//! The last bracket telescopes inside a window, not across windows: a is computed anew under the new force.

mod block;
mod load;
mod row;
mod scattered;
mod scheme;
mod scratch;
mod state;

use rayon::prelude::*;

use crate::element::Body;
use crate::material::point::PointLaw;
use crate::wheel::{Wheel, WheelRun};

pub(crate) use block::UpperRow;
pub(crate) use load::Load;
pub(crate) use row::RowSums;
pub(crate) use scheme::Damping;
pub(crate) use scheme::Rule;
pub use scheme::Scheme;
pub use state::State;

use block::split;
use scattered::Scattered;
use scratch::{Memory, Scratch};

/// Below this number of elements for each thread, waking the threads costs more than they save: with 2 820 each,
/// two threads are 1.7 times faster than one, with 705 each not at all.
const ELEMENTS_PER_THREAD: usize = 2_500;

/// Steps a body, on one thread or several, with the same bits: whoever computes a row computes it alike.
#[derive(Clone, Debug)]
pub(crate) struct Integrator {
    pub(crate) scheme: Scheme,
    /// Mass damping of the step to come.
    pub(crate) damping: Damping,
    law: Option<PointLaw>,
    scratch: Vec<Scratch>,
    /// In place of `scratch` for a mesh that is no block.
    scattered: Option<Scattered>,
}

impl Integrator {
    /// An integrator for a body of `elements`, which may use up to `threads` threads.
    pub(crate) fn new(body: &Body, scheme: Scheme, elements: usize, threads: usize) -> Integrator {
        let worthwhile = threads.min(elements / ELEMENTS_PER_THREAD);
        Integrator::with_blocks(body, scheme, worthwhile.max(1))
    }

    fn with_blocks(body: &Body, scheme: Scheme, blocks: usize) -> Integrator {
        Integrator {
            scheme,
            damping: Damping::constant(scheme.mass_damping),
            law: None,
            scratch: vec![Scratch::new(body); blocks],
            scattered: body.cells().map(|_| Scattered::new(body, blocks)),
        }
    }

    /// Steps under a law that is more than linear.
    pub(crate) fn under(mut self, body: &Body, law: Option<PointLaw>) -> Integrator {
        if let Some(law) = &law {
            for scratch in &mut self.scratch {
                scratch.memory = Memory::new(body, law);
            }
            self.scattered = self.scattered.map(|scattered| scattered.under(body, law));
        }
        self.law = law;
        self
    }

    /// How the step to come is done.
    pub(crate) fn rule(&self) -> Rule {
        Rule {
            scheme: self.scheme,
            damping: self.damping,
        }
    }

    /// Blocks of rows that are stepped at the same time.
    pub(crate) fn blocks(&self) -> usize {
        self.scratch.len()
    }

    /// One step under `load`, the applied forces at its end, and under the forces of the wheel.
    pub(crate) fn step(
        &mut self,
        body: &Body,
        state: &mut State,
        load: &Load,
        sums: &mut [RowSums],
        wheel: Option<(&Wheel, &mut WheelRun)>,
    ) {
        let rows = body.layout().node_rows();
        self.step_blocks(body, state, load, sums, [0, rows], wheel);
    }

    /// One step of the rows `first .. end` only, all others being at rest and staying there; of a mesh that is no block
    /// always the whole.
    pub(crate) fn step_rows(
        &mut self,
        body: &Body,
        state: &mut State,
        load: &Load,
        sums: &mut [RowSums],
        rows: [usize; 2],
    ) {
        self.step_blocks(body, state, load, sums, rows, None);
    }

    fn step_blocks(
        &mut self,
        body: &Body,
        state: &mut State,
        load: &Load,
        sums: &mut [RowSums],
        rows: [usize; 2],
        wheel: Option<(&Wheel, &mut WheelRun)>,
    ) {
        if self.scheme.stiffness_damping > 0.0 {
            state.resistance.resize(body.layout().len(), 0.0);
        }
        let rule = self.rule();
        if let Some(scattered) = &mut self.scattered {
            return scattered.step(body, &rule, (state, load, &mut sums[0]), wheel);
        }
        let mut blocks = split(body, &rule.scheme, state, sums, &mut self.scratch, rows);
        blocks.iter_mut().for_each(|block| block.law = self.law);
        if let Some(block) = blocks.first_mut() {
            block.wheel = wheel;
        }
        match blocks.as_mut_slice() {
            [one] => one.step(body, &rule, load),
            many => many
                .par_iter_mut()
                .for_each(|block| block.step(body, &rule, load)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::{ElementKind, MaterialConfig, Plane};
    use crate::element::Supports;
    use crate::material::Elastic;
    use crate::mesh::Mesh;

    /// A skewed body of 9 x 7 elements with E = density = 1, stepped under two forces.
    fn stepped(blocks: usize, rows: [usize; 2], steps: usize) -> (State, Vec<RowSums>) {
        let mesh = Mesh::structured(9, 7, |i, j| [i as f64 + 0.2 * j as f64, -(j as f64)]);
        let material = MaterialConfig::elastic(1.0, 0.3, 1.0);
        let elastic = Elastic::new(&material, Plane::Strain);
        let supports = Supports::default();
        let body = Body::new(&mesh, ElementKind::Q4OnePoint, &elastic, supports, 1.0);
        let scheme = Scheme {
            step: 0.3,
            damping: 0.75,
            mass_damping: 0.1,
            stiffness_damping: 0.05,
        };
        let mut integrator = Integrator::with_blocks(&body, scheme, blocks);
        let mut load = Load::none(&body);
        load.add(body.layout().index([3, 0], 1), -1.0);
        load.add(body.layout().index([7, 0], 0), 0.5);
        let mut state = State::at_rest(&body);
        state.accelerate(&body, scheme.mass_damping, &load);
        let mut sums = vec![RowSums::default(); body.layout().node_rows()];
        for _ in 0..steps {
            integrator.step_rows(&body, &mut state, &load, &mut sums, rows);
        }
        (state, sums)
    }

    #[test]
    fn blocks_do_not_change_a_bit() {
        let one = stepped(1, [0, 8], 50);
        for blocks in [2, 3, 5, 8, 20] {
            assert_eq!(stepped(blocks, [0, 8], 50), one, "{blocks} blocks");
        }
    }

    #[test]
    fn rows_that_nothing_has_reached_can_be_left_out() {
        let (all, _) = stepped(1, [0, 8], 3);
        let (reached, _) = stepped(2, [0, 4], 3);
        assert_eq!(all.u, reached.u);
    }
}
