//! The energy that a contact loses in a step: in impacts, in slip, by falling adhesion, by the length of the step, and by detection.

use crate::law::adhesion::Adhesion;
use crate::law::lanes::{Lanes, Real};
use crate::law::{Law, Penetration, Springs};

/// Impulse and motion of a contact in a step, or of contacts side by side.
#[derive(Clone, Copy, Debug, Default)]
pub struct ContactStep<T = f64> {
    /// Step (s).
    pub step: f64,
    /// Weight of the end velocity.
    pub theta: f64,
    /// Gap at detection (m).
    pub gap: T,
    /// Gap along its normal at the end of the last step (m).
    pub last_gap: T,
    /// The same, with the change by the bodies' passing each other in that step.
    pub turned_gap: T,
    /// Elongation of the tangential spring before and after (m).
    pub spring: [T; 2],
    /// Impulse (N s).
    pub impulse: [T; 2],
    /// Relative velocity after the step (m/s).
    pub velocity: [T; 2],
    /// Its change in the step (m/s).
    pub change: [T; 2],
    /// True in a scene with springs or bonds: the scheme's loss of a step then has an account of its own, which includes parts of the impacts of
    /// rigid contacts.
    pub elastic: bool,
}

impl<T: Real> ContactStep<T> {
    /// Energy that a spring k (N/m) has lost since the last step without any work (J), negative for a gain, and the part of it that is not predicted.
    ///
    /// The work of a step goes along its normal, and disks that pass each other by s turn it: the detected gap is then about s^2/(2 (r_1 + r_2))
    /// wider than the gap at the end of the last step. This is a loss of the scheme, of first order over a run: 1.8 % of the energy of a wheel that
    /// falls on a layer at 10 m/s in steps of 2e-7 s. The part that is not predicted is of second order, or an error of the geometry.
    #[inline(always)]
    pub fn turned(&self, k: f64) -> [T; 2] {
        let squared = |gap: T| {
            let overlap = gap.map(|gap| gap.min(0.0));
            overlap * overlap
        };
        let found = squared(self.gap);
        let before = [self.last_gap, self.turned_gap];
        before.map(|gap| T::of(0.5 * k) * (squared(gap) - found))
    }
}

/// Energy that a contact loses in a step (J), or contacts side by side.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Loss<T = f64> {
    /// Loss in impacts of rigid contacts.
    pub impact: T,
    /// Loss in the dampers parallel to the springs.
    pub damping: T,
    /// Loss of the scheme, which vanishes with the step.
    pub numerical: T,
    /// Loss in slip.
    pub friction: T,
    /// Loss by falling adhesion.
    pub cohesion: T,
    /// Shear energy released by healing bonds, and by springs that they replace.
    pub relaxation: T,
    /// Surface energy that healing bonds gained, without any work.
    pub healing: T,
    /// Surface energy that the bond has lost, its viscosity included: the loss by falling adhesion in a short step.
    pub surface: T,
    /// Energy lost between two steps by detection, of either sign.
    pub detection: T,
    /// The part of `detection` that the velocities do not predict.
    pub unforeseen: T,
    /// Energy created by the impulses of a rigid contact; a correct law creates none.
    pub made: T,
}

impl<const N: usize> Loss<Lanes<N>> {
    /// The sum of both.
    #[inline(always)]
    pub fn plus(&self, other: &Loss<Lanes<N>>) -> Loss<Lanes<N>> {
        Loss {
            impact: self.impact + other.impact,
            damping: self.damping + other.damping,
            numerical: self.numerical + other.numerical,
            friction: self.friction + other.friction,
            cohesion: self.cohesion + other.cohesion,
            relaxation: self.relaxation + other.relaxation,
            healing: self.healing + other.healing,
            surface: self.surface + other.surface,
            detection: self.detection + other.detection,
            unforeseen: self.unforeseen + other.unforeseen,
            made: self.made + other.made,
        }
    }
}

impl<T: Copy> Loss<T> {
    /// A function of each loss, for instance the sum over contacts.
    #[inline(always)]
    pub fn each<U>(&self, function: impl Fn(T) -> U) -> Loss<U> {
        Loss {
            impact: function(self.impact),
            damping: function(self.damping),
            numerical: function(self.numerical),
            friction: function(self.friction),
            cohesion: function(self.cohesion),
            relaxation: function(self.relaxation),
            healing: function(self.healing),
            surface: function(self.surface),
            detection: function(self.detection),
            unforeseen: function(self.unforeseen),
            made: function(self.made),
        }
    }
}

/// Energy that a contact without bond loses in a step.
///
/// In a compliant contact the part d' - d of the tangential path h u_t goes into the spring, which loses k (d' - d)^2 / 2 to the scheme, and the rest
/// is slip. With theta < 1 the difference of the weights is r (1 - theta) du.
pub fn contact_loss(law: &Law, contact: &ContactStep) -> Loss {
    let [d_n, _] = contact.change;
    let Some(springs) = &law.springs else {
        let rebounds = law.restitution.is_some() && contact.velocity[0] < d_n;
        let repairs = law.penetration == Penetration::Gap && contact.gap < 0.0;
        let work = |k: usize| contact.impulse[k] * (contact.velocity[k] - 0.5 * contact.change[k]);
        let counts = f64::from(u8::from(rebounds || repairs));
        return Loss {
            made: counts * (work(0).max(0.0) + work(1).max(0.0)),
            ..rigid_loss(contact, contact.impulse)
        };
    };
    compliant_loss(springs, contact)
}

/// Energy that compliant contacts without bond lose in a step.
#[inline(always)]
pub fn compliant_loss<T: Real>(springs: &Springs, contact: &ContactStep<T>) -> Loss<T> {
    let ([r_n, r_t], [d_n, d_t]) = (contact.impulse, contact.change);
    let [k_n, damping] = [springs.normal, springs.damping].map(T::of);
    let [normal, damping] = spring_losses(k_n, damping, contact, r_n, |gap| {
        gap.map(|gap| gap.min(0.0))
    });
    let h = T::of(contact.step);
    let stretch = contact.spring[1] - contact.spring[0];
    let slip = h * contact.velocity[1] - stretch;
    let tangential = T::of(0.5 * springs.tangential) * (stretch * stretch);
    let [detection, unforeseen] = contact.turned(springs.normal);
    let before = T::of(1.0 - contact.theta) * (r_n * d_n + r_t * d_t);
    Loss {
        damping,
        numerical: normal + tangential + before,
        friction: -r_t * slip / h,
        detection,
        unforeseen,
        ..Loss::default()
    }
}

/// Energy that the attractions (N) of the last step and of this step lose in this step: the release of the potential less the work.
pub fn attraction_loss(law: &Adhesion, [before, now]: [f64; 2], contact: &ContactStep) -> Loss {
    let ([u_n, _], h) = (contact.velocity, contact.step);
    let [last, turned] = [contact.last_gap, contact.turned_gap].map(|gap| law.stored(before, gap));
    let found = law.stored(now, contact.gap);
    let given = found - law.stored(now, contact.gap + h * u_n);
    let work = -now * h * (u_n - (1.0 - contact.theta) * contact.change[0]);
    // A pair that was out of range has reached its position without attraction.
    let entered = if before == 0.0 { -found } else { 0.0 };
    Loss {
        numerical: entered + given - work,
        detection: last - found - entered,
        unforeseen: turned - found - entered,
        ..Loss::default()
    }
}

/// Loss of a rigid contact under an impulse (N s): an impact along the normal and slip along the tangent, at the velocity v_theta.
/// The scheme's loss of the whole step, (theta - 1/2) dv.M dv, includes (theta - 1/2) r du of the contact's. Where the scheme's loss has its own
/// account, the contact takes its part back, and its loss is the impulse times the mean of the velocities before and after (Kelvin).
#[inline(always)]
pub fn rigid_loss<T: Real>(contact: &ContactStep<T>, [r_n, r_t]: [T; 2]) -> Loss<T> {
    let ([u_n, u_t], [d_n, d_t]) = (contact.velocity, contact.change);
    let beyond = contact.theta - 0.5;
    let own = if contact.elastic { beyond } else { 0.0 };
    let before = T::of(own + 1.0 - contact.theta);
    Loss {
        impact: -r_n * (u_n - before * d_n),
        friction: -r_t * (u_t - before * d_t),
        numerical: -T::of(own) * (r_n * d_n + r_t * d_t),
        ..Loss::default()
    }
}

/// Way (m) by which two bodies have come apart along their normal in a step h (s), as their centres, at this distance (m), passed each other with
/// this velocity (m/s), by s: s^2/(2 d).
#[inline(always)]
pub fn turned<T: Real>(h: f64, [nx, ny]: [T; 2], distance: T, [x, y]: [T; 2]) -> T {
    let way = T::of(h) * (nx * y - ny * x);
    T::of(0.5) * way * way / distance
}

/// Losses of a normal spring k (N/m) and its parallel damper, which is there where `damping` is above 0, under the impulse r_n: a spring driven
/// implicitly from an elongation e_0 to e loses k (e - e_0)^2 / 2 to the scheme; a spring that closes in the step is also pushed over the open gap,
/// k |e| g. The rest of the work is the damper's. `elongation` takes a gap: its negative part under pressure, its positive part in tension.
#[inline(always)]
pub fn spring_losses<T: Real>(
    k: T,
    damping: T,
    contact: &ContactStep<T>,
    r_n: T,
    elongation: impl Fn(T) -> T,
) -> [T; 2] {
    let (h, half, zero) = (T::of(contact.step), T::of(0.5), T::of(0.0));
    let (u_n, before) = (contact.velocity[0], elongation(contact.gap));
    let open = contact.gap - before;
    let is_damped = |damping: f64| damping > 0.0;
    let alone = k.choose(|k| k > 0.0, -r_n / (h * k), zero);
    let moved = elongation(contact.gap + h * u_n);
    let reached = damping.choose(is_damped, moved, alone);
    let stretch = reached - before;
    let numerical = half * k * (stretch * stretch) - k * reached * open;
    let lost = -r_n * u_n - half * k * (moved * moved - before * before);
    [numerical, damping.choose(is_damped, lost - numerical, zero)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::law::Springs;

    const SPRUNG: Law = Law {
        friction: 0.4,
        rolling: 0.0,
        adhesion: None,
        springs: Some(Springs {
            normal: 8.0,
            tangential: 2.0,
            damping: 0.0,
        }),
        cohesion: None,
        healing: None,
        restitution: None,
        penetration: crate::law::Penetration::Gap,
    };

    /// Pushed from an overlap of 0.3 to 0.5, 2 / (0.5 x 8); the tangential spring takes 0.2 of the way of 0.5.
    fn step(gap: f64) -> ContactStep {
        ContactStep {
            step: 0.5,
            theta: 0.75,
            gap,
            last_gap: -0.5,
            turned_gap: -0.5,
            spring: [0.1, 0.3],
            impulse: [2.0, -0.3],
            velocity: [-0.4, 1.0],
            change: [0.1, 0.2],
            elastic: true,
        }
    }

    fn close(found: Loss, expected: Loss) {
        let numbers = |loss: Loss| {
            [
                loss.impact,
                loss.damping,
                loss.numerical,
                loss.friction,
                loss.detection,
            ]
        };
        for (found, expected) in numbers(found).into_iter().zip(numbers(expected)) {
            assert!((found - expected).abs() < 1e-14, "{found} {expected}");
        }
    }

    #[test]
    fn a_spring_loses_by_its_step_its_slip_and_its_detection() {
        // 8 x 0.2^2 / 2 + 2 x 0.2^2 / 2 + 0.25 (2 x 0.1 - 0.3 x 0.2); 0.3 x 0.3 / 0.5; 8 (0.5^2 - 0.3^2) / 2.
        let expected = Loss {
            numerical: 0.16 + 0.04 + 0.05 - 0.015,
            friction: 0.18,
            detection: 0.64,
            ..Loss::default()
        };
        close(contact_loss(&SPRUNG, &step(-0.3)), expected);
        // Also over an open gap of 0.1: 8 x 0.5^2 / 2 + 8 x 0.5 x 0.1; detection finds no energy in the spring.
        let open = Loss {
            numerical: 1.4 + 0.04 + 0.05 - 0.015,
            detection: 1.0,
            ..expected
        };
        close(contact_loss(&SPRUNG, &step(0.1)), open);
    }

    /// Pressed by 2 / 0.5 = 4 while the spring goes from an overlap of 0.3 to 0.5, 8 x 0.5 = 4 less c u_n = 0.4 c: with c = 0 nothing remains for the
    /// damper.
    #[test]
    fn a_damper_loses_the_work_less_the_spring_s_energy_and_the_step_s_loss() {
        let mut law = SPRUNG;
        law.springs = law.springs.map(|springs| Springs {
            damping: 0.1,
            ..springs
        });
        let mut pressed = step(-0.3);
        close(
            contact_loss(&law, &pressed),
            contact_loss(&SPRUNG, &pressed),
        );
        // 0.7 more force over the way of 0.2.
        pressed.impulse[0] += 0.35;
        let found = contact_loss(&law, &pressed);
        assert!((found.damping - 0.14).abs() < 1e-14, "{}", found.damping);
    }

    #[test]
    fn a_rigid_contact_loses_its_impulse_times_the_mean_velocity() {
        let rigid = Law {
            springs: None,
            ..SPRUNG
        };
        // 2 (0.4 + 0.05); 0.3 (1 - 0.1); the scheme's loss includes 0.25 (2 x 0.1 - 0.3 x 0.2) of them.
        let expected = Loss {
            impact: 0.9,
            friction: 0.27,
            numerical: -0.035,
            ..Loss::default()
        };
        close(contact_loss(&rigid, &step(-0.3)), expected);
        // 2 (0.4 + 0.025); 0.3 (1 - 0.05).
        let alone = ContactStep {
            elastic: false,
            ..step(-0.3)
        };
        let expected = Loss {
            impact: 0.85,
            friction: 0.285,
            ..Loss::default()
        };
        close(contact_loss(&rigid, &alone), expected);
    }

    /// Entered at 0.3, and left from 0.4 by a step of 0.3: 8 x 0.2 of the potential never became motion, and 8 x 0.2 of work were done beyond it.
    #[test]
    fn attraction_loses_where_a_step_crosses_the_edge_of_its_range() {
        let law = Adhesion {
            force: 8.0,
            by_radius: 0.0,
            range: 0.5,
        };
        let step = |gap: f64, u_n: f64| ContactStep {
            step: 1.0,
            theta: 1.0,
            gap,
            last_gap: gap,
            turned_gap: gap,
            velocity: [u_n, 0.0],
            ..ContactStep::default()
        };
        let lost = |numerical: f64| Loss {
            numerical,
            ..Loss::default()
        };
        close(
            attraction_loss(&law, [0.0, 8.0], &step(0.3, -0.1)),
            lost(1.6),
        );
        close(
            attraction_loss(&law, [8.0, 8.0], &step(0.4, 0.3)),
            lost(1.6),
        );
        close(
            attraction_loss(&law, [8.0, 8.0], &step(0.1, 0.3)),
            lost(0.0),
        );
    }
}
