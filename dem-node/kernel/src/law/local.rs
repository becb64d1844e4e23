//! The reference contact law: the impulse of one contact in closed form, unbonded and bonded.
//!
//! Sweeps, residuals and conjugate gradients solve or project many contacts side by side with [`super::vector`], which is the same law for W_nt = 0.
//! It is tested against this law, like the sweep over bonds. Contacts of glued disks, of the wheel and of clusters use this law.

use crate::error::KernelError;

/// The symmetric block of W = H^T M^-1 H at one contact, 2 x 2 (1/kg).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DelassusBlock {
    /// Normal.
    pub nn: f64,
    /// Normal to tangent.
    pub nt: f64,
    /// Tangential.
    pub tt: f64,
}

impl DelassusBlock {
    /// W r (m/s).
    #[inline(always)]
    pub fn times(&self, r: [f64; 2]) -> [f64; 2] {
        [
            self.nn * r[0] + self.nt * r[1],
            self.nt * r[0] + self.tt * r[1],
        ]
    }
}

/// Unilateral contact with Coulomb friction, rigid or on springs: the block with everything that does not change during a
/// step, so that a sweep never divides.
#[derive(Clone, Copy, Debug, Default)]
pub struct LocalLaw {
    pub(crate) inverse: DelassusBlock,
    /// 1 / (W_nn + s mu W_nt) for s = +1 and s = -1.
    slide: [f64; 2],
    pub(crate) friction: f64,
}

/// Bodies that can move relative to each other in one direction only have W_nn W_tt = W_nt^2: a rigid contact of two bodies with prescribed sideways
/// motion (glued disk on a fixed boundary under the wheel), where W_tt = 0, or a grain that is guided along an axis, under any angle. No law
/// determines the friction of such a contact at rest, and it is 0 under this small addition to W_tt; friction that slides follows its direction.
pub(crate) const PRESCRIBED: f64 = 1e-9;

impl LocalLaw {
    /// Prepares a contact whose block holds its springs. Sliding needs W_nn - mu |W_nt| > 0, or its impulse is not unique.
    pub fn new(
        block: DelassusBlock,
        friction: f64,
        pair: (u32, u32),
    ) -> Result<LocalLaw, KernelError> {
        if block.nn == 0.0 {
            let (a, b) = pair;
            return Err(KernelError::Prescribed { a, b });
        }
        let denominator = block.nn - friction * block.nt.abs();
        if denominator <= 0.0 || denominator.is_nan() {
            return Err(KernelError::Denominator {
                a: pair.0,
                b: pair.1,
                denominator,
            });
        }
        // Two single disks: with few divisions.
        let single = block.nt == 0.0;
        let held = if single {
            0.0
        } else {
            block.nt * block.nt / block.nn
        };
        let least = PRESCRIBED * block.nn;
        let excess = block.tt - held;
        if excess < -least || excess.is_nan() {
            return Err(KernelError::Indefinite {
                a: pair.0,
                b: pair.1,
                determinant: block.nn * block.tt - block.nt * block.nt,
            });
        }
        let tangential = block.tt.max(held + least);
        let determinant = block.nn * tangential - block.nt * block.nt;
        if single {
            let [nn, tt] = [block.nn, tangential].map(|w| 1.0 / w);
            return Ok(LocalLaw::single(
                DelassusBlock { nn, nt: 0.0, tt },
                friction,
            ));
        }
        let shear = friction * block.nt;
        let one_over = 1.0 / determinant;
        Ok(LocalLaw {
            inverse: DelassusBlock {
                nn: one_over * tangential,
                nt: -one_over * block.nt,
                tt: one_over * block.nn,
            },
            slide: [block.nn + shear, block.nn - shear].map(|slides| 1.0 / slides),
            friction,
        })
    }

    /// The law of two single disks by the inverse of their block, whose W_nt is 0.
    #[inline(always)]
    pub(crate) fn single(inverse: DelassusBlock, friction: f64) -> LocalLaw {
        LocalLaw {
            inverse,
            slide: [inverse.nn; 2],
            friction,
        }
    }

    /// The impulse (r_n, r_t) that solves the local problem U = b + W r under Signorini (0 <= U_n, complementary to
    /// r_n >= 0) and Coulomb (|r_t| <= mu r_n, opposed to U_t), `b` being U without impulse:
    /// b_n >= 0 opens; else stick r = -W^-1 b if |r_t| <= mu r_n; else slide with
    /// r_t = s mu r_n, r_n = -b_n / (W_nn + s mu W_nt), s the sign of the sticking r_t
    /// (Jean 1999, the closed 2D solution of LMGC90's IQS_CLB). Unique since W_nn > mu |W_nt|.
    #[inline(always)]
    pub fn impulse(&self, b: [f64; 2]) -> [f64; 2] {
        if b[0] >= 0.0 {
            return [0.0, 0.0];
        }
        let [stick_n, stick_t] = self.inverse.times(b).map(|x| -x);
        if stick_t.abs() <= self.friction * stick_n {
            return [stick_n, stick_t];
        }
        // Chosen without a branch: no processor predicts to which side the next contact slides.
        let side = usize::from(stick_t <= 0.0);
        let r_n = -b[0] * self.slide[side];
        [r_n, [self.friction, -self.friction][side] * r_n]
    }
}

/// Projection on the Coulomb sector: max(0, x_n), and x_t within mu times this. Its natural map P(r - U/D) has its fixed point at the solution only;
/// with W_nt = 0 and x = -b/D it is the local solution.
#[inline(always)]
pub fn coulomb_projection(x: [f64; 2], friction: f64) -> [f64; 2] {
    let r_n = x[0].max(0.0);
    let limit = friction * r_n;
    [r_n, x[1].clamp(-limit, limit)]
}

/// Branch of the normal law of a bond, at the impulse r_n under U_n: true in tension, where its compliance is 1/kappa. Written without `||` and `&&`,
/// so that no iteration branches.
#[inline(always)]
pub fn in_tension(r_n: f64, u_n: f64) -> bool {
    (r_n < 0.0) | ((r_n == 0.0) & (u_n > 0.0))
}

/// Cohesive contact under the adhesion of a step (Raous, Cangemi and Cocou 1999).
#[derive(Clone, Copy, Debug, Default)]
pub struct BondLaw {
    /// kappa = h^2 l C a^2, normal and tangential (kg).
    kappa: [f64; 2],
    /// delta_t/h (m/s).
    pub slip: f64,
    /// Coefficient of friction on the compressive part of the force.
    friction: f64,
    /// kappa_t / (1 + kappa_t W_tt) (kg).
    pub(crate) shear: f64,
    /// kappa_n / (1 + kappa_n W_nn) under the bond's own shear (kg).
    pub(crate) tension: f64,
}

impl BondLaw {
    /// The law of a bond that holds nothing yet, at the slip delta_t/h (m/s).
    pub fn new(slip: f64, friction: f64) -> BondLaw {
        BondLaw {
            slip,
            friction,
            ..BondLaw::default()
        }
    }

    /// The law without friction for the block of two single disks, prepared with these stiffnesses in shear and in tension.
    #[inline(always)]
    pub(crate) fn prepared(kappa: [f64; 2], slip: f64, [shear, tension]: [f64; 2]) -> BondLaw {
        BondLaw {
            kappa,
            slip,
            friction: 0.0,
            shear,
            tension,
        }
    }

    /// Takes over the stiffness l C a^2, normal and tangential (N/m), in a step h (s).
    pub fn set_stiffness(&mut self, stiffness: [f64; 2], h: f64) {
        self.kappa = stiffness.map(|stiffness| h * h * stiffness);
    }

    /// 1/kappa, normal and tangential (1/kg); infinite where the bond holds nothing.
    pub fn compliance(&self) -> [f64; 2] {
        self.kappa.map(|kappa| 1.0 / kappa)
    }

    /// Prepares the law for a block without springs; `compliance` is the compressed contact's (1/kg). Returns the law in compression.
    pub fn prepare(
        &mut self,
        block: DelassusBlock,
        compliance: f64,
        pair: (u32, u32),
    ) -> Result<LocalLaw, KernelError> {
        let freed = 1.0 / (1.0 + self.kappa[1] * block.tt);
        self.shear = self.kappa[1] * freed;
        let nn = block.nn - self.shear * block.nt * block.nt;
        self.tension = self.kappa[0] / (1.0 + self.kappa[0] * nn);
        let softened = DelassusBlock {
            nn: nn + compliance,
            nt: freed * block.nt,
            tt: freed * block.tt,
        };
        LocalLaw::new(softened, self.friction, pair)
    }

    /// The impulse (r_n, r_t) that the law wants, prepared for this block and with this law in compression; `b` is (u_n + delta/h, u_t)
    /// without impulse (m/s).
    ///
    /// U = u_n + delta/h: U < 0 presses as an unbonded contact does, else r_n = -kappa_n U; r_t = -kappa_t (u_t + delta_t/h)
    /// + r_f with |r_f| <= mu max(r_n, 0).
    #[inline(always)]
    pub fn impulse(&self, block: &DelassusBlock, compressed: &LocalLaw, b: [f64; 2]) -> [f64; 2] {
        let pull = self.shear * (b[1] + self.slip);
        let free = [b[0] - block.nt * pull, b[1] - block.tt * pull];
        let [r_n, r_f] = if free[0] < 0.0 {
            compressed.impulse(free)
        } else {
            [-self.tension * free[0], 0.0]
        };
        [
            r_n,
            r_f - pull - self.shear * (block.nt * r_n + block.tt * r_f),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BLOCK: DelassusBlock = DelassusBlock {
        nn: 2.0,
        nt: 0.6,
        tt: 3.0,
    };

    fn law(friction: f64) -> LocalLaw {
        LocalLaw::new(BLOCK, friction, (0, 1)).expect("it is well posed")
    }

    fn velocity(b: [f64; 2], r: [f64; 2]) -> [f64; 2] {
        [
            b[0] + BLOCK.nn * r[0] + BLOCK.nt * r[1],
            b[1] + BLOCK.nt * r[0] + BLOCK.tt * r[1],
        ]
    }

    #[test]
    fn an_opening_contact_has_no_impulse() {
        assert_eq!(law(0.3).impulse([0.1, -5.0]), [0.0, 0.0]);
    }

    #[test]
    fn sticking_stops_both_components() {
        let b = [-1.0, -0.4];
        let u = velocity(b, law(0.5).impulse(b));
        assert!(u[0].abs() < 1e-15 && u[1].abs() < 1e-15, "{u:?}");
    }

    #[test]
    fn sliding_keeps_contact_and_opposes_the_slip() {
        for b in [[-1.0, 4.0], [-1.0, -4.0]] {
            let r = law(0.3).impulse(b);
            let u = velocity(b, r);
            assert!(u[0].abs() < 1e-15);
            assert!((r[1].abs() - 0.3 * r[0]).abs() < 1e-15);
            assert!(r[1] * u[1] < 0.0, "friction must dissipate: {r:?} {u:?}");
        }
    }

    /// A body of 2 kg that moves along (0.6, 0.8) only, b being such a motion: its normal impulse stops it, without friction.
    #[test]
    fn a_guided_body_is_stopped_along_the_normal_alone() {
        let guided = |angle: f64| {
            let [n, t] = [angle.sin(), angle.cos()];
            [n, t, 0.5 * n * n, 0.5 * n * t, 0.5 * t * t]
        };
        for k in 3..60 {
            let [n, t, nn, nt, tt] = guided(f64::from(k).to_radians() + 0.52);
            for friction in [0.0, 0.3] {
                let law = LocalLaw::new(DelassusBlock { nn, nt, tt }, friction, (0, 1));
                let [r_n, r_t] = law.expect("it does not jam").impulse([-n, -t]);
                assert!((r_n * 0.5 * n - 1.0).abs() < 1e-5, "{k}: {r_n}");
                assert!(r_t.abs() < 1e-5, "{k}: {r_t}");
            }
        }
        let block = |tt: f64| DelassusBlock {
            nn: 1.0,
            nt: 1.0,
            tt,
        };
        let refused = LocalLaw::new(block(0.9), 0.3, (3, 7)).expect_err("it is no mass");
        assert!(
            refused.to_string().contains("W_nn W_tt - W_nt^2"),
            "{refused}"
        );
        assert!(LocalLaw::new(block(f64::NAN), 0.3, (3, 7)).is_err());
    }

    #[test]
    fn a_block_without_unique_slip_is_refused() {
        let block = DelassusBlock {
            nn: 1.0,
            nt: 0.9,
            tt: 1.0,
        };
        let error = LocalLaw::new(block, 1.2, (3, 7)).expect_err("1 - 1.2 x 0.9 < 0");
        assert!(error.to_string().contains("bodies 3 and 7"), "{error}");
    }
}
