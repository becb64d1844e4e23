//! Heat of a step: losses of contacts warm grains, and heat passes through contacts, implicitly in time,
//! ```text
//! m c (T' - T) = h sum H (T_j' - T')
//! ```
//! m is the true mass, which `mass_scale` does not touch, and c and H have their values at the start. The surface of a half-space of effusivity b is one
//! more body: its temperature T_w = T_0 + (history + slope q)/b under the flux q = Q/(A h) makes it a capacity A b h/slope, which starts at
//! T_0 + history/b ([`kit::heat`]). The heat Q since the last conduction enters with the heat of this one.

use protocol::larger;

use super::{StepInput, Stepper};
use crate::bodies::Bodies;
use crate::error::KernelError;
use crate::law::heat::HeatLaw;
use crate::step::state::GrainState;
use crate::step::temperature::PairHeat;

/// Most times of its heat that a grain may pass on in a step of heat, where rounding takes a part of 1e-5.
const PASSED_MAX: f64 = 1e11;

impl Stepper {
    /// Warms the grains by the losses of the contacts of a step, and lets heat pass through these contacts.
    pub(super) fn warm(
        &mut self,
        state: &mut GrainState,
        input: &StepInput,
        warmed: &[PairHeat],
    ) -> Result<(), KernelError> {
        let bodies = input.bodies;
        let Some(law) = &bodies.heat else {
            return Ok(());
        };
        let places = [&state.centres[..], &state.surface];
        state.heat.warm(bodies, law, warmed, places);
        let (steps, time) = state.heat.waited;
        state.heat.waited = (steps + 1, time + input.step);
        if steps + 1 >= law.every {
            self.conduct(state, bodies, law)?;
        }
        Ok(())
    }

    /// Lets the heat of the last steps pass, fewer than from one conduction to the next.
    pub fn end_heat(&mut self, state: &mut GrainState, bodies: &Bodies) -> Result<(), KernelError> {
        if let Some(law) = bodies.heat.as_ref().filter(|_| state.heat.waited.0 > 0) {
            self.conduct(state, bodies, law)?;
            state.heat.see_peak(&state.centres, state.heat.seen);
        }
        Ok(())
    }

    fn conduct(
        &mut self,
        state: &mut GrainState,
        bodies: &Bodies,
        law: &HeatLaw,
    ) -> Result<(), KernelError> {
        let (_, time) = std::mem::take(&mut state.heat.waited);
        state.heat.conductions += 1;
        let contents = state.heat.contents.iter();
        let mut starts: Vec<f64> = contents.map(|x| law.capacity_factor.rise(*x)).collect();
        let grains = starts.len();
        self.link(state, bodies, law, time, &starts);
        let heat = &mut state.heat;
        // A disk of a cluster has no heat of its own, and no links.
        let capacity = |disk: usize| match law.group(disk) {
            None => bodies.heat_capacity(law, disk),
            Some(_) => 1.0,
        };
        let base: Vec<f64> = (0..grains).map(capacity).collect();
        let factors = starts.iter().map(|rise| law.capacity_factor.factor(*rise));
        let mut capacities: Vec<f64> = base.iter().zip(factors).map(|(c, f)| c * f).collect();
        for (of, (waiting, memory)) in law.half_spaces.iter().zip(&heat.half_spaces) {
            let [history, slope] = memory.ahead(time);
            let capacity = of.area * of.effusivity * time / slope;
            let start = of.start - law.start + history / of.effusivity;
            starts.push(start + *waiting / capacity);
            capacities.push(capacity);
        }
        let links = &self.links;
        let diagonal = links.diagonal(&capacities);
        let both = diagonal.iter().zip(&capacities).enumerate();
        let mut swift = both.map(|(body, (all, own))| (body, all / own));
        if let Some((body, passed)) =
            swift.find(|(_, passed)| passed.is_nan() || *passed > PASSED_MAX)
        {
            return Err(KernelError::Heat { body, passed });
        }
        let ends = links.conducted(&capacities, &diagonal, &starts);
        // The temperatures follow from the heat that passes at the ends found, so that none is lost.
        let received = links.received(&ends, 1.0);
        for (grain, body, beside, h) in &links.outer {
            heat.pass((bodies, law), *body, (*h, ends[*grain], *beside));
        }
        let all = heat.contents.iter_mut().zip(&received);
        for (grain, ((content, joules), capacity)) in all.zip(&base).enumerate() {
            *content += joules / capacity;
            let rise = law.capacity_factor.rise(*content);
            let linear = starts[grain] + joules / capacities[grain];
            heat.bent = larger(heat.bent, (rise - linear).abs());
            heat.lowest = -larger(-heat.lowest, -rise);
        }
        for (k, of) in law.half_spaces.iter().enumerate() {
            let (joules, at) = (received[grains + k], grains + k);
            heat.conducted[of.group] += joules;
            heat.held[of.group] = Some(starts[at] + joules / capacities[at]);
            let (waiting, memory) = &mut heat.half_spaces[k];
            let flux = (std::mem::take(waiting) + joules) / (of.area * time);
            memory.take(flux, time);
        }
        Ok(())
    }

    /// Finds the contacts through which heat passes in a time (s), grains having these rises (K); half-spaces have the numbers after theirs.
    fn link(
        &mut self,
        state: &GrainState,
        bodies: &Bodies,
        law: &HeatLaw,
        time: f64,
        rises: &[f64],
    ) {
        let links = &mut self.links;
        links.inner.clear();
        links.outer.clear();
        for slot in state.list.pressing() {
            let pair = [slot.a, slot.b];
            let groups = pair.map(|body| law.group(body as usize));
            let radius = |k: usize| groups[k].is_none().then(|| bodies.radii[pair[k] as usize]);
            let radii = [radius(0), radius(1)];
            let (force, reduced) = (slot.pressure()[0], bodies.reduced_radius(pair));
            let conductance = law.conduction.conductance(force, reduced, radii);
            let h = |a: f64, b: f64| time * conductance * law.conductivity_at(0.5 * (a + b));
            let [a, b] = pair.map(|body| body as usize);
            let (grain, body) = match groups {
                [None, None] => {
                    links.inner.push(([a, b], h(rises[a], rises[b])));
                    continue;
                }
                [None, Some(_)] => (a, b),
                [Some(_), None] => (b, a),
                [Some(_), Some(_)] => continue,
            };
            let group = groups[0].or(groups[1]);
            let place = (state.centres[grain], &state.surface[..]);
            let body = state.heat.taker(bodies, body, place);
            let Some(beside) = state.heat.beside(law, body) else {
                continue;
            };
            let h = h(rises[grain], beside);
            match group.and_then(|group| law.half_space(group)) {
                Some(k) => links.inner.push(([grain, rises.len() + k], h)),
                None => links.outer.push((grain, body, beside, h)),
            }
        }
    }
}
