//! The vector form of the contact law: [`super::local`] for several contacts side by side, all with W_nt = 0.
//!
//! With a diagonal block D, springs included, the local solution of an unbonded contact is the projection of -b/D on the Coulomb sector, and the
//! natural map is the projection of r - U/D, with b = U - D r. A bond is on one branch of its normal law at a time ([`super::local::in_tension`]),
//! where it has bounds on r_n and a compliance of its own.

use crate::law::lanes::Lanes;

/// r_n = max(0, -b_n / D_n), lane by lane; `inverse` is 1/D_n. Written so that a NaN stays NaN.
#[inline(always)]
pub fn normal_impulse<const N: usize>(b: Lanes<N>, inverse: Lanes<N>) -> Lanes<N> {
    b.zip(-b * inverse, |b, r| if b >= 0.0 { 0.0 } else { r })
}

/// r_t within the threshold s = mu r_n, lane by lane: of -b_t / D_t in a sweep, of r_t - U_t / D_t in the natural map.
#[inline(always)]
pub fn tangential_impulse<const N: usize>(r_t: Lanes<N>, threshold: Lanes<N>) -> Lanes<N> {
    r_t.clamp(-threshold, threshold)
}

/// Normal defect of the natural map: D_n (r_n - max(0, r_n - U_n / D_n)) = min(U_n, D_n r_n).
#[inline(always)]
pub fn normal_defect<const N: usize>(u: Lanes<N>, scaled: Lanes<N>) -> Lanes<N> {
    u.least(scaled)
}

/// The feasible part of a direction of r within bounds: 0 where r is at a bound and the direction points outwards.
///
/// Without branches: no processor predicts which contacts slide, and a wrong guess costs as much as the arithmetic.
#[inline(always)]
pub fn feasible<const N: usize>(
    direction: Lanes<N>,
    r: Lanes<N>,
    [low, high]: [Lanes<N>; 2],
) -> Lanes<N> {
    let infinity = f64::INFINITY;
    let down = r.zip(low, |r, low| if r <= low { 0.0 } else { -infinity });
    let up = r.zip(high, |r, high| if r >= high { 0.0 } else { infinity });
    direction.clamp(down, up)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::law::local::{BondLaw, DelassusBlock, LocalLaw, coulomb_projection, in_tension};
    use crate::random::RandomNumbers;

    const N: usize = 4;
    const STATES: usize = 2_000;

    /// A contact without law: its block and its velocity without impulse.
    #[derive(Clone, Copy, Default)]
    struct GrainState {
        block: DelassusBlock,
        springs: [f64; 2],
        b: [f64; 2],
    }

    impl GrainState {
        fn random(random: &mut RandomNumbers, compliant: bool) -> GrainState {
            let mut spring = || {
                if compliant {
                    random.between(0.1, 3.0)
                } else {
                    0.0
                }
            };
            let springs = [spring(), spring()];
            let nn = random.between(0.2, 5.0);
            let block = DelassusBlock {
                nn,
                nt: 0.0,
                tt: 3.0 * nn,
            };
            let b = [random.between(-2.0, 1.0), random.between(-3.0, 3.0)];
            GrainState { block, springs, b }
        }

        fn softened(&self) -> DelassusBlock {
            DelassusBlock {
                nn: self.block.nn + self.springs[0],
                nt: 0.0,
                tt: self.block.tt + self.springs[1],
            }
        }
    }

    fn lanes(states: &[GrainState; N], of: impl Fn(&GrainState) -> f64) -> Lanes<N> {
        Lanes(std::array::from_fn(|k| of(&states[k])))
    }

    fn near(value: f64, expected: f64, what: &str) {
        let size = expected.abs().max(1.0);
        assert!(
            (value - expected).abs() < 1e-14 * size,
            "{what}: {value} instead of {expected}"
        );
    }

    /// Signorini and Coulomb, rigid and on springs: one sweep in lanes gives the impulses of the reference.
    #[test]
    fn the_vector_form_is_the_reference_law() {
        let mut random = RandomNumbers::new(11);
        let mut seen = [0; 3];
        for _ in 0..STATES {
            for (friction, compliant) in [(0.0, false), (0.0, true), (0.4, false), (0.4, true)] {
                let states: [GrainState; N] =
                    std::array::from_fn(|_| GrainState::random(&mut random, compliant));
                let [b_n, b_t] = [0, 1].map(|axis| lanes(&states, |s| s.b[axis]));
                let r_n = normal_impulse(b_n, lanes(&states, |s| 1.0 / s.softened().nn));
                let trial = -b_t * lanes(&states, |s| 1.0 / s.softened().tt);
                let r_t = tangential_impulse(trial, Lanes::splat(friction) * r_n);
                for (k, state) in states.iter().enumerate() {
                    let law = LocalLaw::new(state.softened(), friction, (0, 1));
                    let expected = law.expect("it is well posed").impulse(state.b);
                    near(r_n.0[k], expected[0], "r_n");
                    near(r_t.0[k], expected[1], "r_t");
                    let opens = expected[0] == 0.0;
                    let slides = expected[1].abs() >= 0.999_999 * friction * expected[0];
                    seen[if opens { 0 } else { 1 + usize::from(slides) }] += 1;
                    let d = state.softened();
                    let projected =
                        coulomb_projection([-state.b[0] / d.nn, -state.b[1] / d.tt], friction);
                    near(projected[0], expected[0], "projected r_n");
                    near(projected[1], expected[1], "projected r_t");
                }
            }
        }
        assert!(seen.iter().all(|count| *count > 100), "{seen:?}");
    }

    /// The natural map at any impulse: the defects in lanes are D (r - P(r - U/D)) of the scalar projection.
    #[test]
    fn the_defects_agree_with_the_natural_map() {
        let mut random = RandomNumbers::new(12);
        for _ in 0..STATES {
            let states: [GrainState; N] =
                std::array::from_fn(|_| GrainState::random(&mut random, true));
            let r: [[f64; 2]; N] =
                std::array::from_fn(|_| [random.between(0.0, 1.0), random.between(-0.5, 0.5)]);
            let axis = |axis: usize| Lanes::<N>(std::array::from_fn(|k| r[k][axis]));
            let u = |axis: usize| lanes(&states, |s| s.b[axis]);
            let d = |s: &GrainState| [s.softened().nn, s.softened().tt];
            let [d_n, d_t] = [0, 1].map(|axis| lanes(&states, |s| d(s)[axis]));
            let inverse = [0, 1].map(|axis| lanes(&states, |s| 1.0 / d(s)[axis]));
            let off_n = normal_defect(u(0), d_n * axis(0));
            let threshold = Lanes::splat(0.4) * (axis(0) - off_n * inverse[0]);
            let held = tangential_impulse(axis(1) - u(1) * inverse[1], threshold);
            let off_t = d_t * (axis(1) - held);
            for (k, state) in states.iter().enumerate() {
                let x = [0, 1].map(|axis| r[k][axis] - state.b[axis] / d(state)[axis]);
                let projected = coulomb_projection(x, 0.4);
                let defect = [0, 1].map(|axis| d(state)[axis] * (r[k][axis] - projected[axis]));
                // Two roundings of numbers of the size of U and D r.
                assert!((off_n.0[k] - defect[0]).abs() < 1e-13);
                assert!((off_t.0[k] - defect[1]).abs() < 1e-13);
            }
        }
    }

    /// A bond with r_n = 0 has U_n on the branch, with this branch's compliance and bounds; its shear has no threshold.
    #[test]
    fn the_branches_of_a_bond_are_the_reference_law() {
        let mut random = RandomNumbers::new(13);
        let mut pulled = 0;
        for _ in 0..STATES {
            let states: [GrainState; N] =
                std::array::from_fn(|_| GrainState::random(&mut random, true));
            let slip = random.between(-1.0, 1.0);
            let mut law = BondLaw::new(slip, 0.0);
            law.set_stiffness([4.0, 2.0], 0.5);
            let tension = states.map(|state| in_tension(0.0, state.b[0]));
            let [c_n, c_t] = law.compliance();
            let inverse: [f64; N] = std::array::from_fn(|k| {
                let spring = if tension[k] {
                    c_n
                } else {
                    states[k].springs[0]
                };
                1.0 / (states[k].block.nn + spring)
            });
            let infinity = |open: bool| if open { f64::INFINITY } else { 0.0 };
            let low = Lanes(tension.map(|tension| -infinity(tension)));
            let high = Lanes(tension.map(|tension| infinity(!tension)));
            let r_n = (-lanes(&states, |s| s.b[0]) * Lanes(inverse)).clamp(low, high);
            let trial = lanes(&states, |s| -(s.b[1] + slip) / (s.block.tt + c_t));
            let r_t = tangential_impulse(trial, Lanes::splat(f64::INFINITY));
            for (k, state) in states.iter().enumerate() {
                let compressed = law.prepare(state.block, state.springs[0], (0, 1));
                let compressed = compressed.expect("it is well posed");
                let expected = law.impulse(&state.block, &compressed, state.b);
                near(r_n.0[k], expected[0], "r_n of a bond");
                near(r_t.0[k], expected[1], "r_t of a bond");
                pulled += usize::from(expected[0] < 0.0);
            }
        }
        assert!(pulled > 100 && pulled < N * STATES - 100, "{pulled}");
    }

    #[test]
    fn only_the_outward_part_is_taken_from_a_direction() {
        let bounds = [Lanes::<N>::splat(0.0), Lanes::splat(2.0)];
        let r = Lanes([0.0, 0.0, 1.0, 2.0]);
        let direction = Lanes([-1.0, 1.0, -1.0, 1.0]);
        assert_eq!(feasible(direction, r, bounds), Lanes([0.0, 1.0, -1.0, 0.0]));
    }
}
