//! A viscous bond and a brittle one, sheared or pulled obliquely.
//!
//! ```text
//!   (O)  (O)  -> V cos    both turn with the same spin: opening V cos t, slip V sin t
//! ```
//!
//! Reference: the law of Raous, Cangémi and Cocou (1999), a' = -[(a D - w h'(a))^+ / b]^(1/p), D = Cn delta_n^2 + Ct delta_t^2,
//! along the prescribed path ([`dem_shear`] has its geometry). Runge and Kutta's fourth-order method solves it from D = w on, in
//! 40 000 steps. At p = 2 the rate has an infinite slope where the bond begins to fail; with half the steps the
//! reference changes by less than 1e-5. The force is l a^2 (Cn delta_n, Ct delta_t), the work its integral over the path.
//! In pure shear with h' = a and p = 1 the solution is a = exp(-(w/b) ((s^3 - s_0^3)/(3 s_0^2) - (s - s_0))/V).
//! Tolerance: the scheme is of first order. In steps of s_0/500 its error is up to 1.7e-3 of the strength sqrt(w Ct) and of
//! w, with viscosities that raise the peak 1.7-fold and the work 3.9-fold. A test measures the order itself.
//!
//! [`dem_shear`]: crate::dem_shear

use serde_json::{Value, json};

use crate::dem_shear::{AREA, CN, CT, Direction, SHEAR, W, critical, flywheels, opened};
use crate::dem_support::{close, march};

/// Steps of the reference, and steps of the bond per s_0.
const REFERENCE: u32 = 40_000;
const STEPS: u32 = 500;
const OBLIQUE: Direction = [0.6, 0.8];

/// A bond pulled along a path.
#[derive(Clone, Copy, Debug)]
struct Case {
    direction: Direction,
    /// V (m/s).
    speed: f64,
    /// b (Pa m s^p).
    viscosity: f64,
    power: f64,
    h_prime: &'static str,
}

/// Adhesion, stress (Pa) and work (J/m2) along the path.
#[derive(Clone, Copy, Debug)]
struct Moment {
    path: f64,
    adhesion: f64,
    stress: [f64; 2],
    work: f64,
}

impl Case {
    fn law(&self) -> Value {
        json!({"b_pa_m_s": self.viscosity, "p": self.power, "h_prime": self.h_prime})
    }

    fn drive(&self, path: f64) -> f64 {
        let [opening, slip] = opened(self.direction, path);
        CN * opening * opening + CT * slip * slip
    }

    /// da/ds = a'/V.
    fn rate(&self, path: f64, adhesion: f64) -> f64 {
        let weight = if self.h_prime == "one" { 1.0 } else { adhesion };
        let excess = (adhesion * self.drive(path) - W * weight).max(0.0);
        -(excess / self.viscosity).powf(1.0 / self.power) / self.speed
    }

    fn stress(&self, path: f64, adhesion: f64) -> [f64; 2] {
        let [opening, slip] = opened(self.direction, path);
        [CN * opening, CT * slip].map(|s| s * adhesion * adhesion)
    }

    /// Work of the stress per length of the path (Pa), from the growth of opening and slip.
    fn pull(&self, path: f64, adhesion: f64) -> f64 {
        let d = 1e-3 * path;
        let [before, after] = [path - d, path + d].map(|s| opened(self.direction, s));
        let stress = self.stress(path, adhesion);
        (0..2)
            .map(|k| stress[k] * (after[k] - before[k]) / (2.0 * d))
            .sum()
    }

    /// Opening at which D = w.
    fn onset(&self) -> f64 {
        let (mut low, mut high) = (0.0, 2.0 * critical(self.direction));
        for _ in 0..100 {
            let middle = 0.5 * (low + high);
            if self.drive(middle) < W {
                low = middle;
            } else {
                high = middle;
            }
        }
        low
    }

    /// The reference from the onset to `end` in n steps; work up to the onset is w/2.
    fn reference(&self, end: f64, n: u32) -> Vec<Moment> {
        let onset = self.onset();
        let h = (end - onset) / f64::from(n);
        let (mut a, mut work) = (1.0, 0.5 * W);
        let mut moments = Vec::new();
        for i in 0..n {
            let s = onset + f64::from(i) * h;
            let k1 = self.rate(s, a);
            let k2 = self.rate(s + 0.5 * h, a + 0.5 * h * k1);
            let k3 = self.rate(s + 0.5 * h, a + 0.5 * h * k2);
            let k4 = self.rate(s + h, a + h * k3);
            let next = a + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
            let middle = 0.5 * (a + next);
            let [start, half, stop] =
                [(s, a), (s + 0.5 * h, middle), (s + h, next)].map(|(s, a)| self.pull(s, a));
            work += h / 6.0 * (start + 4.0 * half + stop);
            a = next;
            let path = s + h;
            moments.push(Moment {
                path,
                adhesion: a,
                stress: self.stress(path, a),
                work,
            });
        }
        moments
    }

    /// The bond after each tenth of s_0, in steps of s_0/n.
    fn pulled(&self, end: f64, n: u32) -> Vec<Moment> {
        let s_0 = critical(self.direction);
        let step = s_0 / f64::from(n);
        let mut dem = flywheels(self.direction, self.speed, step, self.law());
        let every = n / 10;
        let last = (end / s_0 * 10.0).round() as u32;
        (0..last)
            .map(|k| {
                let report = march(&mut dem, u64::from(k * every), every);
                let path = step * f64::from((k + 1) * every);
                let force = dem.state().list.slots[0].force;
                let adhesion = dem.state().bonds.first().map_or(0.0, |bond| bond.adhesion);
                let stress = [-force[0], force[1].abs()].map(|f| f / AREA);
                // The force at the end of a step counts for the whole step. As the first force is 0, half of the last one is in excess.
                let excess = 0.5 * step * self.pull(path, adhesion);
                let work = -report.energy("kinetic") / AREA - excess;
                Moment {
                    path,
                    adhesion,
                    stress,
                    work,
                }
            })
            .collect()
    }
}

/// Adhesion, stress and work at a path, interpolated in the reference.
fn at(moments: &[Moment], path: f64) -> Moment {
    let after = moments
        .partition_point(|m| m.path < path)
        .clamp(1, moments.len() - 1);
    let (a, b) = (moments[after - 1], moments[after]);
    let part = (path - a.path) / (b.path - a.path);
    let mix = |a: f64, b: f64| a + part * (b - a);
    Moment {
        path,
        adhesion: mix(a.adhesion, b.adhesion),
        stress: [0, 1].map(|k| mix(a.stress[k], b.stress[k])),
        work: mix(a.work, b.work),
    }
}

/// Largest deviation from the reference, from the onset to 10 s_0: stress over the strength, work over w.
fn distance(case: &Case, n: u32) -> f64 {
    let end = 10.0 * critical(case.direction);
    let reference = case.reference(end, REFERENCE);
    let strength = (W * CT).sqrt();
    let pulled = case.pulled(end, n);
    let past = pulled
        .iter()
        .filter(|moment| moment.path > 1.001 * case.onset());
    past.map(|moment| {
        let exact = at(&reference, moment.path);
        let stress = [0, 1].map(|k| (moment.stress[k] - exact.stress[k]).abs() / strength);
        let work = (moment.work - exact.work).abs() / W;
        stress[0].max(stress[1]).max(work)
    })
    .fold(0.0, f64::max)
}

/// Viscosities at which the bond fails over a few s_0 at 0.1 m/s; each at three speeds, and at five times the viscosity.
fn cases(direction: Direction) -> Vec<Case> {
    let list = [(0.5, 0.15), (1.0, 4e-4), (2.0, 2e-9)];
    let all = list.into_iter().flat_map(|(power, b)| {
        let rates = [(0.02, b), (0.1, b), (0.5, b), (0.1, 5.0 * b)];
        rates.map(|(speed, viscosity)| Case {
            direction,
            speed,
            viscosity,
            power,
            h_prime: "one",
        })
    });
    all.collect()
}

#[track_caller]
fn follow_the_reference(direction: Direction) {
    for case in cases(direction) {
        let apart = distance(&case, STEPS);
        assert!(apart < 2e-3, "{case:?}: {apart:e}");
    }
}

#[test]
fn viscous_shear_follows_its_differential_equation() {
    follow_the_reference(SHEAR);
}

#[test]
fn a_viscous_oblique_pull_follows_its_differential_equation() {
    follow_the_reference(OBLIQUE);
}

#[test]
fn viscous_shear_converges_at_first_order() {
    for case in cases(SHEAR).into_iter().step_by(2) {
        let error = [200, 400, 800].map(|n| distance(&case, n));
        for pair in error.windows(2) {
            let order = (pair[0] / pair[1]).log2();
            assert!((order - 1.0).abs() < 0.05, "{case:?}: {order}, {error:?}");
        }
    }
}

#[test]
fn the_reference_itself_has_converged() {
    for case in cases(SHEAR).into_iter().chain(cases(OBLIQUE)) {
        let end = 10.0 * critical(case.direction);
        let [coarse, fine] = [REFERENCE / 2, REFERENCE].map(|n| case.reference(end, n));
        let path = 2.0 * critical(case.direction);
        let [coarse, fine] = [at(&coarse, path), at(&fine, path)];
        close("adhesion", coarse.adhesion, fine.adhesion, 1e-5);
        close("work", coarse.work, fine.work, 1e-5 * W);
    }
}

#[test]
fn a_viscous_bond_of_the_brittle_kind_follows_its_solution() {
    for (speed, viscosity) in [(0.02, 2e-3), (0.1, 4e-4), (0.1, 2e-3)] {
        let case = Case {
            direction: SHEAR,
            speed,
            viscosity,
            power: 1.0,
            h_prime: "adhesion",
        };
        let s_0 = critical(SHEAR);
        for moment in case.pulled(10.0 * s_0, STEPS) {
            let s = moment.path.max(s_0);
            let done = (s.powi(3) - s_0.powi(3)) / (3.0 * s_0 * s_0) - (s - s_0);
            let exact = (-W / viscosity * done / speed).exp();
            close("adhesion", moment.adhesion, exact, 2e-3);
            let stress = CT * moment.path * exact * exact;
            close("stress", moment.stress[1], stress, 2e-3 * (W * CT).sqrt());
        }
    }
}

#[test]
fn a_brittle_bond_takes_half_of_w_in_shear_and_obliquely() {
    for direction in [SHEAR, OBLIQUE] {
        let s_0 = critical(direction);
        let changes = json!({"h_prime": "adhesion"});
        let mut dem = flywheels(direction, 1.0, s_0 / 2000.0, changes);
        let mut peak = 0.0f64;
        for step in 0..2200 {
            march(&mut dem, step, 1);
            let [n, t] = dem.state().list.slots.first().map_or([0.0; 2], |s| s.force);
            peak = peak.max(n.hypot(t));
        }
        let [opening, slip] = opened(direction, s_0);
        let strength = AREA * (CN * opening).hypot(CT * slip);
        close("strength", peak, strength, 1e-3 * strength);
        assert!(dem.state().bonds.is_empty(), "it is broken");
        // The error is the last step before the break: s_0/2000.
        let work = -march(&mut dem, 2200, 1).energy("kinetic") / AREA;
        close("work", work, 0.5 * W, 2e-3 * W);
    }
}
