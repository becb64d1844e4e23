//! Work, momentum and gap of the interface, and the energies that both sides report.

use protocol::{Role, Term, larger};
use serde::{Deserialize, Serialize};

/// Sums and extremes of an interface since the start of the run.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct InterfaceLedger {
    /// Sum over windows of |W - F_g . H v_g| (J), W being the work of the force that the continuum bore. It equals |F_g
    /// . (N du - H v_g)| if that force is N^T F_g.
    pub energy_defect_j: f64,
    /// Sum over windows of |W| (J).
    pub energy_j: f64,
    /// Sum over windows of W (J): the energy that the interface has given to the continuum.
    pub work_j: f64,
    /// Sum over windows of F_g . H v_g (J): the energy that the solver on the boundary has given to the interface.
    pub boundary_work_j: f64,
    /// Largest gap at the end of a window, over the mean node spacing.
    pub gap_max_rel: f64,
    /// Largest |sum of the forces that the continuum bore - sum F_g| (N).
    pub force_residual_n: f64,
    /// Largest |sum F_g| (N).
    pub force_max_n: f64,
    /// Windows that were accepted although they did not converge.
    pub not_converged: u64,
    /// Windows that were repeated as two halves.
    pub halved: u64,
    /// Sum of the repeats of all windows.
    pub repeats: u64,
    /// Windows so far.
    pub windows: u64,
    /// Iterations of the contact solver, repeats included.
    pub contact_iterations: u64,
    /// Largest true residual of an accepted contact solve.
    pub contact_residual_max: f64,
    /// Kinetic energy of the points (J), if they have masses that belong to no solver.
    pub point_kinetic_j: f64,
    /// Energy of these masses that implicit Euler has lost (J).
    pub point_loss_j: f64,
}

/// Points that move by their own masses in a window of length H (s), by component.
pub struct PointMotion<'a> {
    /// Masses of the points (kg), one for two components.
    pub mass_kg: &'a [f64],
    /// Velocity at the end (m/s).
    pub velocity: &'a [f64],
    /// Inertia m (v - v_0) / H (N).
    pub inertia: &'a [f64],
    /// H (s).
    pub window_s: f64,
}

/// One window as the ledger sees it; vectors run over the glued points.
pub struct WindowEntry<'a> {
    /// Force of the grains on the boundary (N).
    pub point_force: &'a [f64],
    /// Force that the surface nodes bore (N).
    pub nodal_force: &'a [f64],
    /// Motion of the points with the nodes, N du (m).
    pub point_motion: &'a [f64],
    /// Work on the nodes beyond the work of the grains' force in this window, W - N^T F_g.du (J). A scheme makes or
    /// loses it if it uses a force one window late, or a force that is not constant in the window.
    pub late_work_j: f64,
    /// Motion of the points in the contact solve, H v_g (m).
    pub boundary_motion: &'a [f64],
    /// Mean spacing of the surface nodes (m).
    pub spacing_m: f64,
}

impl InterfaceLedger {
    /// Adds an accepted window.
    pub fn add(&mut self, entry: &WindowEntry) {
        let dot = |motion: &dyn Fn(usize) -> f64| -> f64 {
            let forces = entry.point_force.iter().enumerate();
            forces.map(|(i, force)| force * motion(i)).sum()
        };
        let defect = dot(&|i| entry.point_motion[i] - entry.boundary_motion[i]) + entry.late_work_j;
        let work = dot(&|i| entry.point_motion[i]) + entry.late_work_j;
        self.energy_defect_j += defect.abs();
        self.energy_j += work.abs();
        self.work_j += work;
        self.boundary_work_j += dot(&|i| entry.boundary_motion[i]);
        self.gap_max_rel = larger(self.gap_max_rel, entry.gap());
        let (point, nodal) = (total(entry.point_force), total(entry.nodal_force));
        let residual = (point[0] - nodal[0]).hypot(point[1] - nodal[1]);
        self.force_residual_n = larger(self.force_residual_n, residual);
        self.force_max_n = larger(self.force_max_n, point[0].hypot(point[1]));
        self.windows += 1;
    }

    /// Enters the points' own energy: m v (v - v_0) = m (v^2 - v_0^2) / 2 + m (v - v_0)^2 / 2.
    pub fn carry(&mut self, points: &PointMotion) {
        let kinetic = points.velocity.iter().enumerate();
        let kinetic = kinetic.map(|(i, v)| 0.5 * points.mass_kg[i / 2] * v * v);
        self.point_kinetic_j = kinetic.sum();
        let impulse = points.inertia.iter().map(|force| force * points.window_s);
        let lost = impulse.enumerate();
        let lost = lost.map(|(i, impulse)| 0.5 * impulse * impulse / points.mass_kg[i / 2]);
        self.point_loss_j += lost.sum::<f64>();
    }

    /// Energies that the points have stored and lost, in the form of a participant's report; `None` if they have no
    /// masses.
    pub fn points(&self) -> Option<ParticipantLedger> {
        let values = [self.point_kinetic_j, self.point_loss_j];
        let term = |name: &str, role| Term {
            name: name.into(),
            role,
        };
        let reports = values.iter().any(|value| *value != 0.0);
        reports.then(|| ParticipantLedger {
            terms: vec![
                term("kinetic", Role::Stored),
                term("numerical_loss", Role::Dissipated),
            ],
            values: values.to_vec(),
        })
    }

    /// Energy that the points have kept (J).
    pub fn points_kept_j(&self) -> f64 {
        self.point_kinetic_j + self.point_loss_j
    }

    /// Adds the sums of another interface. Connected interfaces share their windows, which count once.
    pub fn merge(&mut self, other: &InterfaceLedger, same_windows: bool) {
        self.energy_defect_j += other.energy_defect_j;
        self.energy_j += other.energy_j;
        self.work_j += other.work_j;
        self.boundary_work_j += other.boundary_work_j;
        self.gap_max_rel = larger(self.gap_max_rel, other.gap_max_rel);
        self.force_residual_n = larger(self.force_residual_n, other.force_residual_n);
        self.force_max_n = larger(self.force_max_n, other.force_max_n);
        self.not_converged += other.not_converged;
        self.contact_iterations += other.contact_iterations;
        self.contact_residual_max = larger(self.contact_residual_max, other.contact_residual_max);
        self.point_kinetic_j += other.point_kinetic_j;
        self.point_loss_j += other.point_loss_j;
        if !same_windows {
            self.halved += other.halved;
            self.repeats += other.repeats;
            self.windows += other.windows;
        }
    }

    /// Energy defect over energy, as in summary.json.
    pub fn energy_defect_rel(&self) -> f64 {
        ratio(self.energy_defect_j, self.energy_j)
    }

    /// Force residual over force, as in summary.json.
    pub fn force_residual_rel(&self) -> f64 {
        ratio(self.force_residual_n, self.force_max_n)
    }

    /// Mean repeats of a window beyond its first run.
    pub fn repeats_mean(&self) -> f64 {
        ratio(self.repeats as f64, self.windows as f64)
    }
}

impl WindowEntry<'_> {
    /// Largest |N du - H v_g| over the mean spacing.
    pub fn gap(&self) -> f64 {
        largest_difference(self.point_motion, self.boundary_motion) / self.spacing_m
    }
}

/// The largest |a_i - b_i|; NaN if any difference is NaN.
pub fn largest_difference(a: &[f64], b: &[f64]) -> f64 {
    let differences = a.iter().zip(b).map(|(a, b)| (a - b).abs());
    differences.fold(0.0, larger)
}

/// Sum of a force vector, by component.
pub fn total(force: &[f64]) -> [f64; 2] {
    let mut sum = [0.0; 2];
    for pair in force.chunks_exact(2) {
        sum[0] += pair[0];
        sum[1] += pair[1];
    }
    sum
}

/// Work below this fraction of the stored and dissipated energy is rounding: a disk that slides on a floor has 2e-16.
const ROUNDING: f64 = 1e-9;

/// a / b, and zero for a = 0.
pub fn ratio(a: f64, b: f64) -> f64 {
    if a == 0.0 { 0.0 } else { a / b }
}

/// Energies of one participant: its terms and their latest values (J).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ParticipantLedger {
    /// Names and roles of the terms.
    pub terms: Vec<Term>,
    /// Cumulative values (J), one for each term.
    pub values: Vec<f64>,
}

impl ParticipantLedger {
    /// Its sums.
    pub fn sums(&self) -> EnergySums {
        EnergySums::of(&self.terms, &self.values)
    }
}

/// Sums of a ledger by the roles of its terms (J): signed, and of absolute values.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct EnergySums {
    /// Work of the participant's own loads and drives.
    pub work_j: f64,
    /// Sum of absolute values of these terms.
    pub work_size_j: f64,
    /// Work at interfaces.
    pub through_j: f64,
    /// Sum of absolute values of these terms.
    pub through_size_j: f64,
    /// Stored and dissipated energy.
    pub kept_j: f64,
    /// Sum of absolute values of these terms.
    pub kept_size_j: f64,
    /// The dissipated part.
    pub dissipated_j: f64,
}

impl EnergySums {
    /// Sums these values of these terms; all sums are 0 while the terms are rounding.
    pub fn of(terms: &[Term], values: &[f64]) -> EnergySums {
        let (mut sums, mut largest, mut noise) = (EnergySums::default(), 0.0, 0.0);
        for (term, value) in terms.iter().zip(values) {
            let (sum, size) = match term.role {
                Role::Work => (&mut sums.work_j, &mut sums.work_size_j),
                Role::InterfaceWork => (&mut sums.through_j, &mut sums.through_size_j),
                Role::Stored | Role::Dissipated => (&mut sums.kept_j, &mut sums.kept_size_j),
                Role::Rounding => {
                    noise = *value;
                    continue;
                }
            };
            *sum += value;
            *size += value.abs();
            largest = larger(largest, value.abs());
            if term.role == Role::Dissipated {
                sums.dissipated_j += value;
            }
        }
        if largest < noise {
            return EnergySums::default();
        }
        sums
    }

    /// Several participants together: the work of their own loads and drives minus the energy that all of them store
    /// and dissipate. Work at the common interface is left out on purpose: the two sides should cancel, and an energy
    /// that only one side reports shows as a defect. Without loads of their own (with an initial velocity, say) the
    /// defect is compared with the work at the interface, which both sides report.
    pub fn together(all: impl IntoIterator<Item = EnergySums>) -> EnergySums {
        let mut sums = EnergySums::default();
        for one in all {
            sums.work_j += one.work_j;
            sums.work_size_j += one.work_size_j;
            sums.through_size_j += 0.5 * one.through_size_j;
            sums.kept_j += one.kept_j;
            sums.kept_size_j += one.kept_size_j;
        }
        if sums.work_size_j > 0.0 {
            sums.through_size_j = 0.0;
        }
        sums
    }

    /// W - dE - D (J).
    pub fn defect_j(&self) -> f64 {
        self.work_j + self.through_j - self.kept_j
    }

    /// Sum of |W| over the work terms (J).
    pub fn worked_j(&self) -> f64 {
        self.work_size_j + self.through_size_j
    }

    /// |W - dE - D| over the sum of |W| of all terms, or over the sum of |dE| and |D| if no work is done beyond
    /// rounding.
    pub fn balance_rel(&self) -> f64 {
        let worked = self.worked_j();
        let scale = if worked > ROUNDING * self.kept_size_j {
            worked
        } else {
            self.kept_size_j
        };
        ratio(self.defect_j().abs(), scale)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn term(name: &str, role: Role) -> Term {
        Term {
            name: name.into(),
            role,
        }
    }

    /// Terms of 1e-15 J and 2e-15 J balance to nothing, but are below the rounding of 1e-14 J.
    #[test]
    fn terms_below_their_rounding_are_not_judged() {
        let terms = [
            term("weight", Role::Work),
            term("kinetic", Role::Stored),
            term("rounding", Role::Rounding),
        ];
        let balance = |scale: f64| {
            let values = [scale * 1e-15, scale * -2e-15, 1e-14];
            EnergySums::of(&terms, &values).balance_rel()
        };
        assert_eq!(balance(1.0), 0.0);
        assert!((balance(10.0) - 3.0).abs() < 1e-12);
    }

    /// Two points push down with 3 N and 1 N, but their node gets 3 N down and 0.5 N to the right: of 4 N, 1 N and 0.5
    /// N are wrong.
    #[test]
    fn a_force_that_is_not_passed_on_stays_in_the_maximum() {
        let mut ledger = InterfaceLedger::default();
        let mut add = |nodal_force: &[f64], boundary_motion: &[f64]| {
            ledger.add(&WindowEntry {
                point_force: &[0.0, -3.0, 0.0, -1.0],
                nodal_force,
                point_motion: &[0.0, -2e-6, 0.0, -2e-6],
                late_work_j: 0.0,
                boundary_motion,
                spacing_m: 1e-3,
            });
        };
        add(&[0.5, -3.0], &[0.0, -2e-6, 0.0, -1e-6]);
        add(&[0.0, -4.0], &[0.0, -2e-6, 0.0, -2e-6]);
        assert_eq!(ledger.force_residual_n, 1.25f64.sqrt());
        assert_eq!(ledger.force_residual_rel(), 1.25f64.sqrt() / 4.0);
        assert!((ledger.gap_max_rel - 1e-3).abs() < 1e-18);
        // 1 N over 1e-6 m in the first of two windows of 8e-6 J.
        assert!((ledger.energy_defect_rel() - 1.0 / 16.0).abs() < 1e-12);
    }

    /// A point with 3 N moves 2 m; its node bears 1 N more over these 2 m, then 1 N less.
    #[test]
    fn work_of_the_nodes_beyond_the_grains_force_is_energy_of_the_interface() {
        let mut ledger = InterfaceLedger::default();
        for late_work_j in [2.0, -2.0] {
            ledger.add(&WindowEntry {
                point_force: &[3.0, 0.0],
                nodal_force: &[3.0 + 0.5 * late_work_j, 0.0],
                point_motion: &[2.0, 0.0],
                late_work_j,
                boundary_motion: &[2.0, 0.0],
                spacing_m: 1.0,
            });
        }
        assert_eq!([ledger.energy_defect_j, ledger.energy_j], [4.0, 8.0 + 4.0]);
        assert_eq!(ledger.force_residual_rel(), 1.0 / 3.0);
    }

    #[test]
    fn nan_stays_in_the_ledger() {
        let mut ledger = InterfaceLedger::default();
        let mut add = |force: f64, motion: f64| {
            ledger.add(&WindowEntry {
                point_force: &[force, 0.0],
                nodal_force: &[1.0, 0.0],
                point_motion: &[motion, 0.0],
                late_work_j: 0.0,
                boundary_motion: &[1.0, 0.0],
                spacing_m: 1.0,
            });
        };
        add(f64::NAN, f64::NAN);
        add(1.0, 1.0);
        let mut all = InterfaceLedger::default();
        all.merge(&ledger, false);
        all.merge(&InterfaceLedger::default(), false);
        for ledger in [&ledger, &all] {
            assert!(ledger.gap_max_rel.is_nan() && ledger.force_max_n.is_nan());
            assert!(ledger.force_residual_rel().is_nan() && ledger.energy_defect_rel().is_nan());
        }
    }

    /// 2 kg from 1 m/s to 3 m/s: 9 J, of which 8 J are new, out of a work of 12 J.
    #[test]
    fn points_store_and_lose_the_work_of_their_inertia() {
        let mut ledger = InterfaceLedger::default();
        assert_eq!(ledger.points(), None);
        ledger.carry(&PointMotion {
            mass_kg: &[2.0],
            velocity: &[3.0, 0.0],
            inertia: &[8.0, 0.0],
            window_s: 0.5,
        });
        let points = ledger.points().expect("they have mass");
        assert_eq!(points.values, [9.0, 4.0]);
        assert_eq!(points.sums().defect_j(), -13.0);
        assert_eq!(ledger.points_kept_j(), 13.0);
    }

    #[test]
    fn a_leak_at_the_interface_shows_in_the_total() {
        let side = |interface: f64, own: f64, stored: f64| ParticipantLedger {
            terms: vec![
                term("interface", Role::InterfaceWork),
                term("load", Role::Work),
                term("strain", Role::Stored),
            ],
            values: vec![interface, own, stored],
        };
        let sound = [side(3.0, 0.0, 3.0), side(-3.0, 10.0, 7.0)];
        let total = |sides: &[ParticipantLedger]| {
            let all = sides.iter().map(ParticipantLedger::sums);
            EnergySums::together(all).balance_rel()
        };
        assert_eq!(total(&sound), 0.0);
        let leaky = [side(3.0, 0.0, 3.0), side(-4.0, 10.0, 6.0)];
        assert_eq!(total(&leaky), 0.1);
        // Without loads the scale is half of the 7 J that both sides report; without any work it is the energy they
        // keep.
        let thrown = [side(3.0, 0.0, 3.0), side(-4.0, 0.0, -2.0)];
        assert_eq!(total(&thrown), 1.0 / 3.5);
        assert_eq!(thrown[1].sums().balance_rel(), 0.5);
        assert_eq!(thrown[1].sums().defect_j(), -2.0);
        let idle = [side(0.0, 0.0, 3.0), side(0.0, 0.0, -2.0)];
        assert_eq!(total(&idle), 0.2);
        let braked = [side(0.0, -8.0, -6.0)];
        assert_eq!(total(&braked), 0.25);
    }

    /// A disk that slides on a floor: 7e-24 J of work are rounding, 4e-8 J of kinetic energy go into friction.
    #[test]
    fn work_within_rounding_is_not_the_scale() {
        let slides = |work: f64, lost: f64| {
            let ledger = ParticipantLedger {
                terms: vec![
                    term("weight", Role::Work),
                    term("kinetic", Role::Stored),
                    term("friction", Role::Dissipated),
                ],
                values: vec![work, -4e-8, lost],
            };
            ledger.sums().balance_rel()
        };
        assert!(slides(-7e-24, 4e-8 + 1e-23) < 1e-15);
        // A defect of the kinetic energy still shows, and real work is the scale.
        assert!((slides(-7e-24, 3e-8) - 1.0 / 7.0).abs() < 1e-12);
        assert!((slides(1e-9, 4e-8) - 1.0).abs() < 1e-12);
    }
}
