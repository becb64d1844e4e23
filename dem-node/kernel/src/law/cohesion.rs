//! Cohesion of Raous, Cangémi and Cocou (1999), signs corrected; LMGC90's IQS_MAC_CZM.
//!
//! A bond of area l = r_1 r_2 / (r_1 + r_2) x thickness (m2) has an adhesion a in \[0, 1\] and carries the force (N)
//! r_n = -l Cn a^2 delta_n in tension and -l Ct a^2 delta_t along the contact. Adhesion only falls:
//! a' = -\[(1/b) (w h'(a) - a D)^-\]^(1/p), D = Cn delta_n^2 + Ct delta_t^2 (J/m2), (x)^- = max(0, -x).
//! With b = 0 and h' = 1 the opening delta_0 = sqrt(w/Cn) starts the decohesion at the strength sqrt(w Cn), then
//! a = w/D; complete separation dissipates w per area. With h' = a the bond is brittle and dissipates w/2.

use super::lanes::Real;

/// The parameters of the law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cohesion {
    /// Cn (Pa/m).
    pub normal: f64,
    /// Ct (Pa/m).
    pub tangential: f64,
    /// w (J/m2).
    pub energy: f64,
    /// b (Pa m s^p).
    pub viscosity: f64,
    /// p.
    pub power: f64,
    /// h'.
    pub h_prime: HPrime,
    /// Thickness of the scene (m).
    pub thickness: f64,
    /// Gap below which two grains are bonded at the start (m).
    pub alert: f64,
    /// Least number of bonds of a grain at the start, across any gap.
    pub bonds_min: usize,
    /// Damping ratio zeta of the dampers parallel to the springs of a bond.
    pub damping: f64,
}

/// Weight of the surface energy at a falling adhesion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HPrime {
    /// h' = 1: adhesion falls gradually, separation takes w.
    One,
    /// h' = a: brittle, separation takes w/2.
    Adhesion,
}

impl Cohesion {
    /// The opening at which a bond at rest begins to fail (m).
    pub fn critical_opening(&self) -> f64 {
        (self.energy / self.normal).sqrt()
    }

    /// l of two disks (m2).
    pub fn area(&self, radii: [f64; 2]) -> f64 {
        radii[0] * radii[1] / (radii[0] + radii[1]) * self.thickness
    }

    /// D = Cn dn^2 + Ct dt^2 (J/m2); a negative opening does not count.
    #[inline(always)]
    pub fn drive<T: Real>(&self, opening: T, slip: T) -> T {
        let stretched = opening.map(|opening| opening.max(0.0));
        T::of(self.normal) * (stretched * stretched) + T::of(self.tangential) * slip * slip
    }

    /// Elastic energy of a bond (J): l a^2 D / 2.
    #[inline(always)]
    pub fn stored<T: Real>(&self, area: T, adhesion: T, opening: T, slip: T) -> T {
        T::of(0.5) * area * adhesion * adhesion * self.drive(opening, slip)
    }

    /// Energy over the area of the bond that decohesion dissipates as adhesion falls from a_0 to a_1 in a step h (s), viscosity included (J/m2): the
    /// integral of w h' da, and b ((a_0 - a_1)/h)^p times the fall.
    pub fn surface(&self, [before, after]: [f64; 2], h: f64) -> f64 {
        let fall = before - after;
        if fall == 0.0 {
            return 0.0;
        }
        let weight = match self.h_prime {
            HPrime::One => 1.0,
            HPrime::Adhesion => 0.5 * (before + after),
        };
        fall * (weight * self.energy + self.viscosity * (fall / h).powf(self.power))
    }

    /// l Cn a^2 and l Ct a^2 (N/m).
    #[inline(always)]
    pub fn stiffness<T: Real>(&self, area: T, adhesion: T) -> [T; 2] {
        [self.normal, self.tangential].map(|c| area * T::of(c) * adhesion * adhesion)
    }

    /// True for a bond whose adhesion does not fall at D.
    #[inline(always)]
    pub fn holds(&self, adhesion: f64, drive: f64) -> bool {
        match self.h_prime {
            HPrime::One => self.energy > adhesion * drive,
            HPrime::Adhesion => (self.energy >= drive) | (adhesion == 0.0),
        }
    }

    /// Adhesion after a step h (s) that ends at D, implicit in a: b ((a_0 - a)/h)^p = a D - w h'(a) (equation 10 of Renouf,
    /// Saulot and Berthier 2006 with its signs corrected; Raous, Cangemi and Cocou 1999).
    ///
    /// p = 1 has closed forms, a = (h w + b a_0)/(b + h D) for h' = 1 and a = a_0 b / (b + h (D - w)) for h' = a.
    #[inline(always)]
    pub fn adhesion_after(&self, adhesion: f64, drive: f64, h: f64) -> f64 {
        if self.holds(adhesion, drive) {
            return adhesion;
        }
        self.fallen(adhesion, drive, h)
    }

    #[cold]
    #[inline(never)]
    fn fallen(&self, a: f64, drive: f64, h: f64) -> f64 {
        let (w, b) = (self.energy, self.viscosity);
        match self.h_prime {
            HPrime::One if self.power == 1.0 || b == 0.0 => {
                a.min((h * w + b * a) / (b + h * drive))
            }
            HPrime::Adhesion if self.power == 1.0 || b == 0.0 => a * b / (b + h * (drive - w)),
            HPrime::One => self.implicit_root(a, drive, w, h),
            HPrime::Adhesion => self.implicit_root(a, drive - w, 0.0, h),
        }
    }

    /// Root of f(a) = b ((a_0 - a)/h)^p - (a slope - offset) in \[0, a_0\] by Newton within a bracket.
    ///
    /// f falls from f(0) > 0 to f(a_0) <= 0, so there is one root; a Newton step that leaves the bracket (p < 1 has an
    /// infinite slope at a_0) is replaced by its middle.
    fn implicit_root(&self, start: f64, slope: f64, offset: f64, h: f64) -> f64 {
        let (b, p) = (self.viscosity, self.power);
        let (mut low, mut high) = (0.0, start);
        let mut a = 0.5 * start;
        while high - low > 4.0 * f64::EPSILON * start {
            let rate = (start - a) / h;
            let f = b * rate.powf(p) - (a * slope - offset);
            if f > 0.0 {
                low = a;
            } else {
                high = a;
            }
            let next = a + f / (b * p * rate.powf(p - 1.0) / h + slope);
            let inside = next > low && next < high;
            // Close to the root Newton moves only one end of the bracket: the size of its step ends the loop.
            if inside && (next - a).abs() <= 2.0 * f64::EPSILON * start {
                return next;
            }
            a = if inside { next } else { 0.5 * (low + high) };
        }
        a
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn law(h_prime: HPrime, viscosity: f64, power: f64) -> Cohesion {
        Cohesion {
            normal: 4.0,
            tangential: 1.0,
            energy: 1.0,
            viscosity,
            power,
            h_prime,
            thickness: 1.0,
            alert: 0.1,
            bonds_min: 0,
            damping: 0.0,
        }
    }

    #[test]
    fn nothing_falls_below_the_critical_opening_nor_in_compression() {
        for h_prime in [HPrime::One, HPrime::Adhesion] {
            let law = law(h_prime, 0.0, 1.0);
            assert_eq!(law.critical_opening(), 0.5);
            assert_eq!(law.adhesion_after(1.0, law.drive(0.499, 0.0), 0.1), 1.0);
            assert_eq!(law.adhesion_after(1.0, law.drive(-9.0, 0.0), 0.1), 1.0);
        }
    }

    #[test]
    fn without_viscosity_adhesion_is_w_over_d_or_nothing() {
        let opening = 2.0;
        let one = law(HPrime::One, 0.0, 1.0);
        assert_eq!(
            one.adhesion_after(1.0, one.drive(opening, 0.0), 0.1),
            1.0 / 16.0
        );
        let brittle = law(HPrime::Adhesion, 0.0, 1.0);
        assert_eq!(
            brittle.adhesion_after(1.0, brittle.drive(opening, 0.0), 0.1),
            0.0
        );
    }

    #[test]
    fn closed_forms_and_roots_solve_the_implicit_equation() {
        let h = 0.05;
        for h_prime in [HPrime::One, HPrime::Adhesion] {
            for power in [0.5, 1.0, 1.3, 2.0, 3.0] {
                for (start, drive) in [(1.0, 1.5), (0.6, 9.0), (0.9, 400.0)] {
                    let law = law(h_prime, 0.7, power);
                    let a = law.adhesion_after(start, drive, h);
                    assert!((0.0..=start).contains(&a), "{a}");
                    let weight = if h_prime == HPrime::One { 1.0 } else { a };
                    let (left, right) = (0.7 * ((start - a) / h).powf(power), a * drive - weight);
                    let scale = left.abs().max(drive * a).max(1.0);
                    assert!(
                        (left - right).abs() < 1e-7 * scale,
                        "{h_prime:?} {power}: {left} {right}"
                    );
                }
            }
        }
    }
}
