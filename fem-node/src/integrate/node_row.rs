//! The end of a step for one row of nodes: accelerations, energies, velocities.

use std::ops::Range;

use super::dissipation::Dissipated;
use super::scheme::{Damping, Rule, Scheme};
use crate::element::Layout;
use crate::pack::{LANES, Pack, vectorised};

/// A row of nodes whose displacements are new and whose other fields are still old.
pub(crate) struct NodeRow<'a> {
    pub(super) v: &'a mut [f64],
    pub(super) a: &'a mut [f64],
    pub(super) force: &'a mut [f64],
    pub(super) new_force: &'a [f64],
    pub(super) load: &'a [f64],
    pub(super) mass: &'a [f64],
    pub(super) inverse_mass: &'a [f64],
    /// Force of the stiffness damping, that of the step before; empty without.
    pub(super) damping_force: &'a mut [f64],
    /// Buffer for the load less the stiffness damping.
    pub(super) net: &'a mut [f64],
    pub(super) dissipated: Dissipated<&'a mut [f64]>,
}

/// Neighbouring components before the end of a step.
pub(crate) struct Now {
    v: Pack,
    a: Pack,
    force: Pack,
    new_force: Pack,
    load: Pack,
    mass: Pack,
    inverse_mass: Pack,
}

/// Their rates after it.
pub(crate) struct Ended {
    v: Pack,
    a: Pack,
}

impl NodeRow<'_> {
    /// Stiffness damping d' = (beta/h) (F' - F), which is taken off the load; adds [(1-b) d + b d'] du to the energies.
    pub(crate) fn damp_stiffness(&mut self, scheme: &Scheme, spans: &[Range<usize>]) {
        if self.damping_force.is_empty() {
            return;
        }
        let h = Pack::splat(scheme.step);
        let half = Pack::splat(0.5 * scheme.step * scheme.step);
        let rate = Pack::splat(scheme.stiffness_damping / scheme.step);
        let (start, end) = (
            Pack::splat(1.0 - scheme.damping),
            Pack::splat(scheme.damping),
        );
        for (k, count) in spans.iter().flat_map(packs) {
            let new = rate * (Pack::load(self.new_force, k) - Pack::load(self.force, k));
            let du = h * Pack::load(self.v, k) + half * Pack::load(self.a, k);
            let energy = (start * Pack::load(self.damping_force, k) + end * new) * du;
            (Pack::load(self.load, k) - new).store(self.net, k);
            new.store_up_to(count, self.damping_force, k);
            add(&mut self.dissipated.stiffness_damping, energy, count, k);
        }
        let net: &mut [f64] = std::mem::take(&mut self.net);
        self.load = net;
    }

    /// Accelerations, energies and velocities in these spans, once the forces are known.
    pub(super) fn finish(&mut self, rule: &Rule, layout: Layout, spans: &[Range<usize>]) {
        let numerical = !self.dissipated.numerical.is_empty();
        let damped = !self.dissipated.mass_damping.is_empty() && rule.damping.acts();
        for span in spans {
            vectorised(
                #[inline(always)]
                || match (numerical, damped) {
                    (false, false) => self.finish_span::<false, false>(rule, span),
                    (true, false) => self.finish_span::<true, false>(rule, span),
                    (false, true) => self.finish_span::<false, true>(rule, span),
                    (true, true) => self.finish_span::<true, true>(rule, span),
                },
            );
        }
        layout.repeat_period(self.a);
        layout.repeat_period(self.v);
    }

    /// One pass over the fields, every number of which is read and written once; what a scheme does not dissipate costs nothing.
    #[inline(always)]
    fn finish_span<const NUMERICAL: bool, const DAMPED: bool>(
        &mut self,
        rule: &Rule,
        span: &Range<usize>,
    ) {
        let (v, v_rest) = self.v[span.clone()].as_chunks_mut::<LANES>();
        let (a, a_rest) = self.a[span.clone()].as_chunks_mut::<LANES>();
        let (force, force_rest) = self.force[span.clone()].as_chunks_mut::<LANES>();
        let (new_force, new_force_rest) = packs_of(self.new_force, span);
        let (load, load_rest) = packs_of(self.load, span);
        let (mass, mass_rest) = packs_of(self.mass, span);
        let (inverse_mass, inverse_mass_rest) = packs_of(self.inverse_mass, span);
        let (numerical, numerical_rest) = energies::<NUMERICAL>(self.dissipated.numerical, span);
        let (damping, damping_rest) = energies::<DAMPED>(self.dissipated.mass_damping, span);
        let count = v.len();
        // Said once, so that nothing is asked in the loop.
        assert!(a.len() == count && force.len() == count && new_force.len() == count);
        assert!(load.len() == count && mass.len() == count && inverse_mass.len() == count);
        assert!(!NUMERICAL || numerical.len() == count);
        assert!(!DAMPED || damping.len() == count);
        for i in 0..count {
            let now = Now {
                v: Pack(v[i]),
                a: Pack(a[i]),
                force: Pack(force[i]),
                new_force: Pack(new_force[i]),
                load: Pack(load[i]),
                mass: Pack(mass[i]),
                inverse_mass: Pack(inverse_mass[i]),
            };
            let ended = now.end(&rule.scheme, rule.damping.end);
            if NUMERICAL {
                let energy = numerical_dissipation(&rule.scheme, &now, &ended);
                numerical[i] = (Pack(numerical[i]) + energy).0;
            }
            if DAMPED {
                let energy = mass_damping(&rule.scheme, rule.damping, &now, &ended);
                damping[i] = (Pack(damping[i]) + energy).0;
            }
            (v[i], a[i], force[i]) = (ended.v.0, ended.a.0, new_force[i]);
        }
        if v_rest.is_empty() {
            return;
        }
        let now = Now {
            v: Pack::first(v_rest),
            a: Pack::first(a_rest),
            force: Pack::first(force_rest),
            new_force: Pack::first(new_force_rest),
            load: Pack::first(load_rest),
            mass: Pack::first(mass_rest),
            inverse_mass: Pack::first(inverse_mass_rest),
        };
        let ended = now.end(&rule.scheme, rule.damping.end);
        if NUMERICAL {
            let energy = numerical_dissipation(&rule.scheme, &now, &ended);
            (Pack::first(numerical_rest) + energy).store_first(numerical_rest);
        }
        if DAMPED {
            let energy = mass_damping(&rule.scheme, rule.damping, &now, &ended);
            (Pack::first(damping_rest) + energy).store_first(damping_rest);
        }
        ended.v.store_first(v_rest);
        ended.a.store_first(a_rest);
        now.new_force.store_first(force_rest);
    }
}

impl Now {
    /// a' = p - c (v + h [(1-b) a + b p]) / (1 + b h c), p = M^-1 (f' - F(u')), and v' = v + h [(1-b) a + b a']
    #[inline(always)]
    fn end(&self, scheme: &Scheme, c: f64) -> Ended {
        let (h, b) = (scheme.step, scheme.damping);
        let drag = Pack::splat(c / (1.0 + b * h * c));
        let (old, new) = scheme.weights();
        let p = self.inverse_mass * (self.load - self.new_force);
        let undamped = self.v + (old * self.a + new * p);
        let a = p - drag * undamped;
        Ended {
            v: self.v + (old * self.a + new * a),
            a,
        }
    }
}

/// A span of a field, in packs and the rest.
#[inline(always)]
fn packs_of<'a>(field: &'a [f64], span: &Range<usize>) -> (&'a [[f64; LANES]], &'a [f64]) {
    field[span.clone()].as_chunks()
}

/// Energies of a span, in packs and the rest; none where they are not counted.
#[inline(always)]
fn energies<'a, const COUNTED: bool>(
    energies: &'a mut [f64],
    span: &Range<usize>,
) -> (&'a mut [[f64; LANES]], &'a mut [f64]) {
    let own = if COUNTED { span.clone() } else { 0..0 };
    energies[own].as_chunks_mut()
}

/// du dF - b h^2/2 da M da
#[inline(always)]
pub(crate) fn numerical_dissipation(scheme: &Scheme, now: &Now, ended: &Ended) -> Pack {
    let h = Pack::splat(scheme.step);
    let half = Pack::splat(0.5 * scheme.step * scheme.step);
    let weight = Pack::splat(0.5 * scheme.damping * scheme.step * scheme.step);
    let du = h * now.v + half * now.a;
    let da = ended.a - now.a;
    du * (now.new_force - now.force) - weight * now.mass * da * da
}

/// [(1-b) c v + b c' v'] M du
#[inline(always)]
fn mass_damping(scheme: &Scheme, damping: Damping, now: &Now, ended: &Ended) -> Pack {
    let h = Pack::splat(scheme.step);
    let half = Pack::splat(0.5 * scheme.step * scheme.step);
    let start = Pack::splat((1.0 - scheme.damping) * damping.start);
    let end = Pack::splat(scheme.damping * damping.end);
    let drag = start * now.v + end * ended.v;
    let du = h * now.v + half * now.a;
    drag * now.mass * du
}

/// Beginning of each pack of a span, and the numbers of it that belong to the span.
#[inline(always)]
fn packs(span: &Range<usize>) -> impl Iterator<Item = (usize, usize)> + use<> {
    let end = span.end;
    (span.start..end).step_by(LANES).map(move |k| (k, end - k))
}

/// Adds to the energies of the first `count` components from `k` on.
#[inline(always)]
fn add(energies: &mut [f64], energy: Pack, count: usize, k: usize) {
    (Pack::load(energies, k) + energy).store_up_to(count, energies, k);
}
