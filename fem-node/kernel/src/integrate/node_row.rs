//! The end of a step for one row of nodes: accelerations, energies, velocities.

use std::ops::Range;

use super::dissipation::Dissipated;
use crate::element::layout::Layout;
use crate::pack::lanes::{LANES, Pack};
use crate::pack::vectorised;
use crate::scheme::{Damping, NewmarkScheme, Rule};

/// A row of nodes whose displacements are new and whose other fields are still old.
pub(crate) struct NodeRow<'a> {
    pub(super) v: &'a mut [f64],
    pub(super) a: &'a mut [f64],
    pub(super) force: &'a mut [f64],
    pub(super) new_force: &'a [f64],
    /// Buffer for the new accelerations.
    pub(super) new_a: &'a mut [f64],
    pub(super) load: &'a [f64],
    pub(super) mass: &'a [f64],
    pub(super) inverse_mass: &'a [f64],
    /// Force of the stiffness damping in the step before; empty without damping.
    pub(super) damping_force: &'a mut [f64],
    /// Buffer for the load less the stiffness damping.
    pub(super) net: &'a mut [f64],
    pub(super) dissipated: Dissipated<&'a mut [f64]>,
}

impl NodeRow<'_> {
    /// Stiffness damping d' = (beta/h) (F' - F), which is subtracted from the load; adds [(1-b) d + b d'] du to the energies.
    pub(crate) fn damp_stiffness(&mut self, scheme: &NewmarkScheme, spans: &[Range<usize>]) {
        if self.damping_force.is_empty() {
            return;
        }
        let counted = !self.dissipated.stiffness_damping.is_empty();
        let h = Pack::splat(scheme.step);
        let half = Pack::splat(0.5 * scheme.step * scheme.step);
        let rate = Pack::splat(scheme.stiffness_damping / scheme.step);
        let start = Pack::splat(1.0 - scheme.damping);
        let end = Pack::splat(scheme.damping);
        for (k, count) in spans.iter().flat_map(packs) {
            let new = rate * (Pack::load(self.new_force, k) - Pack::load(self.force, k));
            let du = h * Pack::load(self.v, k) + half * Pack::load(self.a, k);
            let energy = (start * Pack::load(self.damping_force, k) + end * new) * du;
            (Pack::load(self.load, k) - new).store(self.net, k);
            new.store_up_to(count, self.damping_force, k);
            if counted {
                add(self.dissipated.stiffness_damping, energy, count, k);
            }
        }
        let net: &mut [f64] = std::mem::take(&mut self.net);
        self.load = net;
    }

    /// Accelerations, energies and velocities in these spans, once the forces are known.
    pub(super) fn finish(&mut self, rule: &Rule, layout: Layout, spans: &[Range<usize>]) {
        for span in spans {
            let whole = span.start..span.end - span.len() % LANES;
            self.part(&whole).finish_packs(rule);
            self.finish_rest(rule, &(whole.end..span.end));
        }
        layout.repeat_period(self.a);
        layout.repeat_period(self.v);
    }

    /// The same for fewer components than a pack has.
    fn finish_rest(&mut self, rule: &Rule, span: &Range<usize>) {
        if span.is_empty() {
            return;
        }
        let row = self.part(span);
        let (mut v, mut a) = (filled(row.v), filled(row.a));
        let (mut force, mut new_a) = (filled(row.force), [0.0; LANES]);
        let mut numerical = filled(row.dissipated.numerical);
        let mut damping = filled(row.dissipated.mass_damping);
        let counted = |energies: &[f64]| if energies.is_empty() { 0 } else { LANES };
        let numericals = counted(row.dissipated.numerical);
        let dampings = counted(row.dissipated.mass_damping);
        let pack = NodeRow {
            v: &mut v,
            a: &mut a,
            force: &mut force,
            new_force: &filled(row.new_force),
            new_a: &mut new_a,
            load: &filled(row.load),
            mass: &filled(row.mass),
            inverse_mass: &filled(row.inverse_mass),
            damping_force: &mut [],
            net: &mut [],
            dissipated: Dissipated {
                numerical: &mut numerical[..numericals],
                mass_damping: &mut damping[..dampings],
                ..Dissipated::default()
            },
        };
        pack.finish_packs(rule);
        let ended = [
            (row.v, v),
            (row.a, a),
            (row.force, force),
            (row.dissipated.numerical, numerical),
            (row.dissipated.mass_damping, damping),
        ];
        for (own, pack) in ended {
            own.copy_from_slice(&pack[..own.len()]);
        }
    }

    /// These components alone.
    fn part(&mut self, span: &Range<usize>) -> NodeRow<'_> {
        let own = || span.clone();
        NodeRow {
            v: &mut self.v[own()],
            a: &mut self.a[own()],
            force: &mut self.force[own()],
            new_force: &self.new_force[own()],
            new_a: &mut self.new_a[own()],
            load: &self.load[own()],
            mass: &self.mass[own()],
            inverse_mass: &self.inverse_mass[own()],
            damping_force: &mut [],
            net: &mut [],
            dissipated: self.dissipated.row(own()),
        }
    }

    /// Whole packs of components.
    fn finish_packs(mut self, rule: &Rule) {
        vectorised!({
            self.accelerate(&rule.scheme, rule.damping.end);
            if !self.dissipated.numerical.is_empty() {
                self.numerical_dissipation(&rule.scheme);
            }
            if !self.dissipated.mass_damping.is_empty() && rule.damping.acts() {
                self.mass_damping(&rule.scheme, rule.damping);
            }
            self.correct(&rule.scheme);
        });
    }

    /// a' = p - c (v + h [(1-b) a + b p]) / (1 + b h c), p = M^-1 (f' - F(u'))
    #[inline(always)]
    pub(crate) fn accelerate(&mut self, scheme: &NewmarkScheme, c: f64) {
        let (h, b) = (scheme.step, scheme.damping);
        let drag = Pack::splat(c / (1.0 + b * h * c));
        let (old, new) = scheme.weights();
        for k in (0..self.new_a.len()).step_by(LANES) {
            let net = Pack::load(self.load, k) - Pack::load(self.new_force, k);
            let p = Pack::load(self.inverse_mass, k) * net;
            let undamped = Pack::load(self.v, k) + (old * Pack::load(self.a, k) + new * p);
            (p - drag * undamped).store(self.new_a, k);
        }
    }

    /// Adds du dF - b h^2/2 da M da.
    #[inline(always)]
    pub(crate) fn numerical_dissipation(&mut self, scheme: &NewmarkScheme) {
        let h = Pack::splat(scheme.step);
        let half = Pack::splat(0.5 * scheme.step * scheme.step);
        let weight = Pack::splat(0.5 * scheme.damping * scheme.step * scheme.step);
        for k in (0..self.new_a.len()).step_by(LANES) {
            let a = Pack::load(self.a, k);
            let du = h * Pack::load(self.v, k) + half * a;
            let d_force = Pack::load(self.new_force, k) - Pack::load(self.force, k);
            let da = Pack::load(self.new_a, k) - a;
            let energy = du * d_force - weight * Pack::load(self.mass, k) * da * da;
            energy.add_to(self.dissipated.numerical, k);
        }
    }

    /// Adds [(1-b) c v + b c' v'] M du.
    #[inline(always)]
    pub(crate) fn mass_damping(&mut self, scheme: &NewmarkScheme, damping: Damping) {
        let h = Pack::splat(scheme.step);
        let half = Pack::splat(0.5 * scheme.step * scheme.step);
        let start = Pack::splat((1.0 - scheme.damping) * damping.start);
        let end = Pack::splat(scheme.damping * damping.end);
        for k in (0..self.new_a.len()).step_by(LANES) {
            let v = Pack::load(self.v, k);
            let drag = start * v + end * self.new_velocity(scheme, k);
            let du = h * v + half * Pack::load(self.a, k);
            let energy = drag * Pack::load(self.mass, k) * du;
            energy.add_to(self.dissipated.mass_damping, k);
        }
    }

    /// v' = v + h [(1-b) a + b a']
    #[inline(always)]
    pub(crate) fn new_velocity(&self, scheme: &NewmarkScheme, k: usize) -> Pack {
        let (old, new) = scheme.weights();
        Pack::load(self.v, k) + (old * Pack::load(self.a, k) + new * Pack::load(self.new_a, k))
    }

    /// The new fields become the old ones.
    #[inline(always)]
    fn correct(&mut self, scheme: &NewmarkScheme) {
        for k in (0..self.new_a.len()).step_by(LANES) {
            self.new_velocity(scheme, k).store(self.v, k);
        }
        self.a.copy_from_slice(self.new_a);
        self.force.copy_from_slice(self.new_force);
    }
}

/// A pack that begins with these numbers.
fn filled(numbers: &[f64]) -> [f64; LANES] {
    let mut pack = [0.0; LANES];
    pack[..numbers.len()].copy_from_slice(numbers);
    pack
}

/// Beginning of each pack of a span, and the count of its numbers within the span.
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
