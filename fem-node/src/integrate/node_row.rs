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

/// The numbers from `k` on of all fields at the end of a step.
pub(crate) struct Ended {
    v: Pack,
    a: Pack,
    new_v: Pack,
    new_a: Pack,
    d_force: Pack,
    mass: Pack,
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
        for (k, count) in packs(span) {
            let ended = self.end(&rule.scheme, rule.damping.end, k);
            if NUMERICAL {
                let energy = numerical_dissipation(&rule.scheme, &ended);
                add(&mut self.dissipated.numerical, energy, count, k);
            }
            if DAMPED {
                let energy = mass_damping(&rule.scheme, rule.damping, &ended);
                add(&mut self.dissipated.mass_damping, energy, count, k);
            }
            ended.new_v.store_up_to(count, self.v, k);
            ended.new_a.store_up_to(count, self.a, k);
            Pack::load(self.new_force, k).store_up_to(count, self.force, k);
        }
    }

    /// a' = p - c (v + h [(1-b) a + b p]) / (1 + b h c), p = M^-1 (f' - F(u')), and v' = v + h [(1-b) a + b a']
    #[inline(always)]
    fn end(&self, scheme: &Scheme, c: f64, k: usize) -> Ended {
        let (h, b) = (scheme.step, scheme.damping);
        let drag = Pack::splat(c / (1.0 + b * h * c));
        let (old, new) = scheme.weights();
        let (v, a) = (Pack::load(self.v, k), Pack::load(self.a, k));
        let new_force = Pack::load(self.new_force, k);
        let net = Pack::load(self.load, k) - new_force;
        let p = Pack::load(self.inverse_mass, k) * net;
        let undamped = v + (old * a + new * p);
        let new_a = p - drag * undamped;
        Ended {
            v,
            a,
            new_v: v + (old * a + new * new_a),
            new_a,
            d_force: new_force - Pack::load(self.force, k),
            mass: Pack::load(self.mass, k),
        }
    }
}

/// du dF - b h^2/2 da M da
#[inline(always)]
pub(crate) fn numerical_dissipation(scheme: &Scheme, ended: &Ended) -> Pack {
    let h = Pack::splat(scheme.step);
    let half = Pack::splat(0.5 * scheme.step * scheme.step);
    let weight = Pack::splat(0.5 * scheme.damping * scheme.step * scheme.step);
    let du = h * ended.v + half * ended.a;
    let da = ended.new_a - ended.a;
    du * ended.d_force - weight * ended.mass * da * da
}

/// [(1-b) c v + b c' v'] M du
#[inline(always)]
fn mass_damping(scheme: &Scheme, damping: Damping, ended: &Ended) -> Pack {
    let h = Pack::splat(scheme.step);
    let half = Pack::splat(0.5 * scheme.step * scheme.step);
    let start = Pack::splat((1.0 - scheme.damping) * damping.start);
    let end = Pack::splat(scheme.damping * damping.end);
    let drag = start * ended.v + end * ended.new_v;
    let du = h * ended.v + half * ended.a;
    drag * ended.mass * du
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
