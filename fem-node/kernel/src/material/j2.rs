//! Von Mises plasticity with linear isotropic and kinematic hardening, plane strain.
//!
//! J. C. Simo and T. J. R. Hughes, Computational Inelasticity (Springer 1998), section 3.3, radial return; with linear
//! hardening the return is exact in one step. With s the deviator of the stress, p the plastic strain (traceless), a its
//! equivalent value and mu the shear modulus:
//!
//! ```text
//! s  = 2 mu (dev e - p)                    stress
//! x  = s - 2/3 K p                         relative stress: the stress less the back stress of Prager
//! |x| <= sqrt(2/3) (Y + H a)               yield surface; Y + H a in uniaxial tension
//! dp = g n,  n = x/|x|,  da = sqrt(2/3) g  flow
//! g  = (|x_trial| - sqrt(2/3) (Y + H a)) / (2 mu + 2/3 (H + K)),  at least 0
//! ```
//!
//! Yielding does not change the pressure. The back stress is a function of p, so p and a are the whole history.
//!
//! # Energy
//! The internal work of a step is (s + s') de / 2 in each point. With de = d(e - p) + dp it is the change of the elastic
//! energy, of the energy of the back stress K p p / 3, and of the dissipation (x + x') dp / 2: exactly, for steps of
//! any length. With x = x_trial - 2 mu de and x' = (1 - c g/|x|) x_trial, c = 2 mu + 2/3 K:
//!
//! ```text
//! D = f [(1 - c f / 2) x_trial x_trial - mu de x_trial],  f = g/|x_trial|
//! ```

use crate::pack::lanes::Pack;

/// History variables of a point: pxx, pyy, 2 pxy and a.
pub(crate) const HISTORY: usize = 4;

/// Moduli of the law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct J2 {
    /// Shear modulus mu (Pa).
    pub mu: f64,
    /// Yield stress Y in uniaxial tension (Pa).
    pub yield_stress: f64,
    /// Isotropic hardening H (Pa).
    pub isotropic: f64,
    /// Kinematic hardening K (Pa).
    pub kinematic: f64,
    /// True where each element has a factor on Y, behind the history of its row.
    pub softens: bool,
}

/// Strain (exx, eyy, 2 exy) or stress (sxx, syy, sxy) of a pack of points.
pub(crate) type Plane3 = [Pack; 3];

/// History variables of a pack of points.
pub(crate) type History = [Pack; HISTORY];

/// The histories of one point of all elements of a row: [`HISTORY`] arrays of `stride`.
pub(crate) struct PointHistory<'a> {
    pub(crate) values: &'a mut [f64],
    pub(crate) stride: usize,
}

impl PointHistory<'_> {
    #[inline(always)]
    pub(crate) fn load(&self, at: usize) -> History {
        history_pack(self.values, self.stride, at)
    }

    #[inline(always)]
    pub(crate) fn store(&mut self, at: usize, [pxx, pyy, pxy, a]: History) {
        pxx.store(self.values, at);
        pyy.store(self.values, self.stride + at);
        pxy.store(self.values, 2 * self.stride + at);
        a.store(self.values, 3 * self.stride + at);
    }
}

/// History variables of the pack of points from `at` on.
#[inline(always)]
pub(crate) fn history_pack(values: &[f64], stride: usize, at: usize) -> History {
    [
        Pack::load(values, at),
        Pack::load(values, stride + at),
        Pack::load(values, 2 * stride + at),
        Pack::load(values, 3 * stride + at),
    ]
}

impl J2 {
    /// Radial return of the pack of points from `at` on (Simo and Hughes 1998, section 3.3):
    ///
    /// ```text
    /// g = (|x_trial| - sqrt(2/3) (Y + H a)) / (2 mu + 2/3 (H + K)),  at least 0
    /// p' = p + g n,  a' = a + sqrt(2/3) g,  n = x_trial/|x_trial|
    /// ```
    ///
    /// Returns 2 mu p', the reduction of the stress of Hooke's law (Pa), and the dissipation (J/m3); `increment` gives the strain since the last
    /// step, `factor` acts on Y.
    #[inline(always)]
    pub(crate) fn return_map(
        &self,
        strain: Plane3,
        increment: impl FnOnce() -> Plane3,
        history: &mut PointHistory,
        (at, factor): (usize, Pack),
    ) -> (Plane3, Pack) {
        let [pxx, pyy, pxy, a] = history.load(at);
        let x = self.trial(strain, [pxx, pyy, pxy]);
        let square = norm_squared(x);
        let radius = self.radius(a, factor);
        let two_mu = Pack::splat(2.0 * self.mu);
        let mu = Pack::splat(self.mu);
        if !square.any_above(radius * radius) {
            return ([two_mu * pxx, two_mu * pyy, mu * pxy], Pack::splat(0.0));
        }
        // The lanes that stay elastic get g = 0; their |x| may be 0. In the other lanes |x| is above the radius.
        let norm = square.sqrt().max(radius);
        let plastic_modulus = 2.0 * self.mu + 2.0 / 3.0 * (self.isotropic + self.kinematic);
        let g = (norm - radius) * Pack::splat(1.0 / plastic_modulus);
        let f = g / norm;
        let new = [
            pxx + f * x[0],
            pyy + f * x[1],
            pxy + Pack::splat(2.0) * f * x[2],
            a + Pack::splat((2.0f64 / 3.0).sqrt()) * g,
        ];
        history.store(at, new);
        let half = Pack::splat(1.0) - Pack::splat(self.mu + self.kinematic / 3.0) * f;
        let de = increment();
        let work = de[0] * x[0] + de[1] * x[1] + de[2] * x[2];
        let dissipated = f * (half * square - mu * work);
        ([two_mu * new[0], two_mu * new[1], mu * new[2]], dissipated)
    }

    /// True where the first flow begins in any lane: |x_trial| > sqrt(2/3) Y, with a history of zero. It rounds like [`return_map`](J2::return_map).
    #[inline(always)]
    pub(crate) fn begins_to_flow(&self, strain: Plane3, factor: Pack) -> bool {
        let zero = Pack::splat(0.0);
        let radius = self.radius(zero, factor);
        norm_squared(self.trial(strain, [zero; 3])).any_above(radius * radius)
    }

    /// Y^2 / (3 mu^2), the largest 2 dev e : dev e (1) of a point that has never flowed and does not flow: with x_trial = 2 mu dev e the surface is 4
    /// mu^2 dev e : dev e = 2/3 Y^2.
    pub(crate) fn shear_limit(&self) -> f64 {
        let ratio = self.yield_stress / self.mu;
        ratio * ratio / 3.0
    }

    /// sqrt(2/3) (Y + H a) (Pa), with a factor on Y
    #[inline(always)]
    fn radius(&self, a: Pack, factor: Pack) -> Pack {
        Pack::splat((2.0f64 / 3.0).sqrt())
            * (Pack::splat(self.yield_stress) * factor + Pack::splat(self.isotropic) * a)
    }

    /// Elastic energy plus the energy of the back stress less s e / 2 (J/m3): K p p / 3 - s p / 2.
    #[inline(always)]
    pub(crate) fn energy_correction(&self, strain: Plane3, [pxx, pyy, pxy, _]: History) -> Pack {
        let half = Pack::splat(0.5);
        let pzz = pxx + pyy;
        let pp = pxx * pxx + pyy * pyy + pzz * pzz + half * pxy * pxy;
        let ep = strain[0] * pxx + strain[1] * pyy + half * strain[2] * pxy;
        Pack::splat(self.mu + self.kinematic / 3.0) * pp - Pack::splat(self.mu) * ep
    }

    /// x with the plastic strain unchanged.
    #[inline(always)]
    fn trial(&self, [exx, eyy, exy]: Plane3, [pxx, pyy, pxy]: Plane3) -> Plane3 {
        let c = 2.0 * self.mu + 2.0 / 3.0 * self.kinematic;
        let (two_mu, c) = (Pack::splat(2.0 * self.mu), Pack::splat(c));
        let (mu, half_c) = (Pack::splat(self.mu), Pack::splat(0.5) * c);
        let mean = Pack::splat(1.0 / 3.0) * (exx + eyy);
        [
            two_mu * (exx - mean) - c * pxx,
            two_mu * (eyy - mean) - c * pyy,
            mu * exy - half_c * pxy,
        ]
    }
}

/// x x of a traceless tensor whose zz component follows from the others.
#[inline(always)]
fn norm_squared([xx, yy, xy]: Plane3) -> Pack {
    let zz = xx + yy;
    xx * xx + yy * yy + zz * zz + Pack::splat(2.0) * xy * xy
}

/// Plastic strain (pxx, pyy, 2 pxy, a) of point `at`.
pub(crate) fn history_at(values: &[f64], stride: usize, at: usize) -> [f64; HISTORY] {
    [0, 1, 2, 3].map(|k| values[k * stride + at])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pack::lanes::LANES;

    const LAW: J2 = J2 {
        mu: 80.0,
        yield_stress: 3.0,
        isotropic: 6.0,
        kinematic: 9.0,
        softens: false,
    };

    /// Shears one point to each strain in turn; the stress after each, and the dissipation.
    fn sheared(law: &J2, strains: &[f64]) -> (Vec<f64>, f64) {
        let mut values = vec![0.0; HISTORY * LANES];
        let (mut before, mut dissipated) = (0.0, 0.0);
        let stresses = strains.iter().map(|strain| {
            let mut history = PointHistory {
                values: &mut values,
                stride: LANES,
            };
            let zero = Pack::splat(0.0);
            let shear = |value: f64| [zero, zero, Pack::splat(value)];
            let increment = || shear(strain - before);
            let point = (0, Pack::splat(1.0));
            let (plastic, dissipation) =
                law.return_map(shear(*strain), increment, &mut history, point);
            dissipated += dissipation.0[0];
            before = *strain;
            law.mu * strain - plastic[2].0[0]
        });
        let stresses = stresses.collect();
        (stresses, dissipated)
    }

    /// In simple shear the yield stress is Y/sqrt(3), and |dp| = sqrt(2) dpxy gives the slope
    /// dt/d(2 exy) = mu (H + K)/(3 mu + H + K).
    #[test]
    fn simple_shear_yields_and_hardens_as_on_paper() {
        let first = 3.0 / 3f64.sqrt();
        let slope = 80.0 * 15.0 / (240.0 + 15.0);
        let (stress, _) = sheared(&LAW, &[0.01, 0.1]);
        assert_eq!(stress[0], 0.8);
        let exact = first + slope * (0.1 - first / 80.0);
        assert!((stress[1] - exact).abs() < 1e-12, "{} {exact}", stress[1]);
    }

    /// With isotropic hardening the span of the reversal is twice the grown yield stress, with kinematic hardening it stays 2 Y/sqrt(3).
    #[test]
    fn the_back_stress_moves_the_surface_and_does_not_widen_it() {
        for (isotropic, kinematic) in [(15.0, 0.0), (0.0, 15.0)] {
            let law = J2 {
                isotropic,
                kinematic,
                ..LAW
            };
            let (top, _) = sheared(&law, &[0.1]);
            let span = 2.0
                * if kinematic > 0.0 {
                    3.0 / 3f64.sqrt()
                } else {
                    top[0]
                };
            let back = 0.1 - span / 80.0;
            let (stress, _) = sheared(&law, &[0.1, back + 1e-9, back - 1e-3]);
            assert!((top[0] - stress[1] - span).abs() < 1e-6, "{stress:?}");
            let slope = 80.0 * 15.0 / 255.0;
            assert!(
                (stress[1] - stress[2] - 1e-3 * slope).abs() < 1e-6,
                "{stress:?}"
            );
        }
    }

    /// (s + s') de / 2 over a path against elastic energy, energy of the back stress and dissipation.
    #[test]
    fn no_work_is_lost_in_steps_of_any_length() {
        let strains = [0.02, 0.1, 0.04, -0.2, 0.01];
        let (stress, dissipated) = sheared(&LAW, &strains);
        let mut work = 0.0;
        let mut last = (0.0, 0.0);
        for (strain, stress) in strains.into_iter().zip(&stress) {
            work += 0.5 * (last.1 + stress) * (strain - last.0);
            last = (strain, *stress);
        }
        let pxy = 0.5 * (last.0 - last.1 / 80.0);
        let stored = last.1 * last.1 / 160.0 + LAW.kinematic / 3.0 * 2.0 * pxy * pxy;
        assert!(
            (work - stored - dissipated).abs() < 1e-14,
            "{work} {stored} {dissipated}"
        );
    }
}
