//! Heat of a step: losses of contacts warm grains, and heat passes through contacts, implicitly in time,
//! ```text
//! m c (T' - T) = h sum H (T_j' - T')
//! ```
//! m is the true mass, which `mass_scale` does not touch.

use super::{StepInput, Stepper};
use crate::bodies::Bodies;
use crate::law::heat::HeatLaw;
use crate::step::state::GrainState;
use crate::step::temperature::PairHeat;

impl Stepper {
    /// Warms the grains by the losses of the contacts of a step, and lets heat pass through these contacts.
    pub(super) fn warm(&mut self, state: &mut GrainState, input: &StepInput, warmed: &[PairHeat]) {
        let bodies = input.bodies;
        let Some(law) = &bodies.heat else {
            return;
        };
        for one in warmed {
            let places = [&state.centres[..], &state.surface];
            state.heat.warm(bodies, law, one, places);
        }
        let (steps, time) = state.heat.waited;
        state.heat.waited = (steps + 1, time + input.step);
        if steps + 1 >= law.every {
            self.conduct(state, bodies, law);
        }
    }

    /// Lets the heat of the last steps pass, fewer than from one conduction to the next.
    pub fn end_heat(&mut self, state: &mut GrainState, bodies: &Bodies) {
        if let Some(law) = bodies.heat.as_ref().filter(|_| state.heat.waited.0 > 0) {
            self.conduct(state, bodies, law);
            state.heat.see_peak(&state.centres, state.heat.seen);
        }
    }

    fn conduct(&mut self, state: &mut GrainState, bodies: &Bodies, law: &HeatLaw) {
        let (_, time) = std::mem::take(&mut state.heat.waited);
        state.heat.conductions += 1;
        let links = &mut self.links;
        links.inner.clear();
        links.outer.clear();
        for slot in state.list.pressing() {
            let pair = [slot.a, slot.b];
            let groups = pair.map(|body| law.group(body as usize));
            let radius = |k: usize| groups[k].is_none().then(|| bodies.radii[pair[k] as usize]);
            let radii = [radius(0), radius(1)];
            let (force, reduced) = (slot.pressure()[0], bodies.reduced_radius(pair));
            let h = time * law.conduction.conductance(force, reduced, radii);
            let [a, b] = pair.map(|body| body as usize);
            let (grain, body) = match groups {
                [None, None] => {
                    links.inner.push(([a, b], h));
                    continue;
                }
                [None, Some(_)] => (a, b),
                [Some(_), None] => (b, a),
                [Some(_), Some(_)] => continue,
            };
            let place = (state.centres[grain], &state.surface[..]);
            let body = state.heat.taker(bodies, body, place);
            if let Some(beside) = state.heat.beside(law, body) {
                links.outer.push((grain, body, beside, h));
            }
        }
        let heat = &mut state.heat;
        // A disk of a cluster has no heat of its own, and no links.
        let capacity = |disk: usize| match law.group(disk) {
            None => bodies.heat_capacity(law, disk),
            Some(_) => 1.0,
        };
        let capacities: Vec<f64> = (0..heat.rises.len()).map(capacity).collect();
        let ends = links.conducted(&capacities, &heat.rises);
        // The temperatures follow from the heat that passes at the ends found, so that none is lost.
        let received = links.received(&ends, 1.0);
        for (grain, body, beside, h) in &links.outer {
            heat.give(bodies, law, *body, h * (ends[*grain] - beside));
        }
        let grains = heat.rises.iter_mut().zip(&received);
        for ((t, joules), capacity) in grains.zip(&capacities) {
            *t += joules / capacity;
        }
    }
}
