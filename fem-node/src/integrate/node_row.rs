//! The end of a step for one row of nodes: accelerations, energies, velocities.

use super::scheme::{Damping, Rule, Scheme};
use crate::element::Layout;
use crate::pack::{LANES, Pack, vectorised};

/// Dissipation of a row of nodes since the start of the window (J).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct RowEnergies {
    /// Numerical dissipation over (b-1/2), without its part that telescopes: sum of du dF - b h^2/2 da M da.
    pub(crate) numerical: f64,
    /// Mass damping: sum of [(1-b) c v + b c' v'] M du.
    pub(crate) mass_damping: f64,
    /// Stiffness damping: sum of [(1-b) d + b d'] du.
    pub(crate) stiffness_damping: f64,
    /// Plastic flow in the elements below the row.
    pub(crate) plastic: f64,
}

/// A row of nodes whose displacements are new and whose other fields are still old.
pub(crate) struct NodeRow<'a> {
    pub(super) v: &'a mut [f64],
    pub(super) a: &'a mut [f64],
    pub(super) force: &'a mut [f64],
    pub(super) new_force: &'a [f64],
    pub(super) new_a: &'a mut [f64],
    pub(super) load: &'a [f64],
    pub(super) mass: &'a [f64],
    pub(super) inverse_mass: &'a [f64],
    /// Force of the stiffness damping, that of the step before; empty without.
    pub(super) damping_force: &'a mut [f64],
    /// Buffer for the load less the stiffness damping.
    pub(super) net: &'a mut [f64],
}

impl NodeRow<'_> {
    /// Stiffness damping d' = (beta/h) (F' - F), which is taken off the load; adds [(1-b) d + b d'] du to the energies.
    pub(crate) fn damp_stiffness(&mut self, scheme: &Scheme, energies: &mut RowEnergies) {
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
        let mut sum = Pack::splat(0.0);
        for k in (0..self.net.len()).step_by(LANES) {
            let new = rate * (Pack::load(self.new_force, k) - Pack::load(self.force, k));
            let du = h * Pack::load(self.v, k) + half * Pack::load(self.a, k);
            sum = sum + (start * Pack::load(self.damping_force, k) + end * new) * du;
            (Pack::load(self.load, k) - new).store(self.net, k);
            new.store(self.damping_force, k);
        }
        energies.stiffness_damping += sum.sum();
        let net: &mut [f64] = std::mem::take(&mut self.net);
        self.load = net;
    }

    /// Accelerations, energies and velocities, once the forces are known.
    pub(super) fn finish(&mut self, rule: &Rule, layout: Layout, energies: &mut RowEnergies) {
        vectorised(
            #[inline(always)]
            || self.finish_inlined(rule, layout, energies),
        );
    }

    #[inline(always)]
    fn finish_inlined(&mut self, rule: &Rule, layout: Layout, energies: &mut RowEnergies) {
        let (scheme, damping) = (&rule.scheme, rule.damping);
        self.accelerate(scheme, damping.end);
        layout.repeat_period(self.new_a);
        if scheme.damping > 0.5 {
            energies.numerical += self.numerical_dissipation(scheme);
        }
        if damping.acts() {
            energies.mass_damping += self.mass_damping(scheme, damping);
        }
        self.correct(scheme);
    }

    /// a' = p - c (v + h [(1-b) a + b p]) / (1 + b h c), p = M^-1 (f' - F(u'))
    #[inline(always)]
    pub(crate) fn accelerate(&mut self, scheme: &Scheme, c: f64) {
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

    /// Sum of du dF - b h^2/2 da M da.
    #[inline(always)]
    pub(crate) fn numerical_dissipation(&self, scheme: &Scheme) -> f64 {
        let h = Pack::splat(scheme.step);
        let half = Pack::splat(0.5 * scheme.step * scheme.step);
        let weight = Pack::splat(0.5 * scheme.damping * scheme.step * scheme.step);
        let mut sum = Pack::splat(0.0);
        for k in (0..self.new_a.len()).step_by(LANES) {
            let a = Pack::load(self.a, k);
            let du = h * Pack::load(self.v, k) + half * a;
            let d_force = Pack::load(self.new_force, k) - Pack::load(self.force, k);
            let da = Pack::load(self.new_a, k) - a;
            sum = sum + (du * d_force - weight * Pack::load(self.mass, k) * da * da);
        }
        sum.sum()
    }

    /// Sum of [(1-b) c v + b c' v'] M du.
    #[inline(always)]
    pub(crate) fn mass_damping(&self, scheme: &Scheme, damping: Damping) -> f64 {
        let h = Pack::splat(scheme.step);
        let half = Pack::splat(0.5 * scheme.step * scheme.step);
        let start = Pack::splat((1.0 - scheme.damping) * damping.start);
        let end = Pack::splat(scheme.damping * damping.end);
        let mut sum = Pack::splat(0.0);
        for k in (0..self.new_a.len()).step_by(LANES) {
            let v = Pack::load(self.v, k);
            let drag = start * v + end * self.new_velocity(scheme, k);
            let du = h * v + half * Pack::load(self.a, k);
            sum = sum + drag * Pack::load(self.mass, k) * du;
        }
        sum.sum()
    }

    /// v' = v + h [(1-b) a + b a']
    #[inline(always)]
    pub(crate) fn new_velocity(&self, scheme: &Scheme, k: usize) -> Pack {
        let (old, new) = scheme.weights();
        Pack::load(self.v, k) + (old * Pack::load(self.a, k) + new * Pack::load(self.new_a, k))
    }

    /// The new fields become the old ones.
    #[inline(always)]
    fn correct(&mut self, scheme: &Scheme) {
        for k in (0..self.new_a.len()).step_by(LANES) {
            self.new_velocity(scheme, k).store(self.v, k);
        }
        self.a.copy_from_slice(self.new_a);
        self.force.copy_from_slice(self.new_force);
    }
}
