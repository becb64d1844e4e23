//! Warnings of a run: the findings of its participants, and the coupler's findings about forces, energies and joints.

use crate::warning::Warning;
use kit::finding::NOT_CONVERGED;
use kit::{Bounds, FindingKind, judge};
use protocol::{Description, Finding, HeldLoad, larger};

use scenario::error::{Error, Result};
use scenario::keys::Scenario;
use scenario::plausible::Plausible;
use scheme::group::{Group, Patch};
use scheme::ledger::ratio;

kit::findings! {
    /// The run ends before a key takes effect, or before its effect is over (a ramp, a hold, cycles, a table, a feed).
    ///
    /// `thirdbody check` predicts it. Results that need that moment, as `p0_pa` needs the end of the hold, are left
    /// out.
    ///
    /// - Why: `run.end_s` is shorter than the history of loads and motions, or one of their times is in the wrong unit.
    /// - Do: lengthen `run.end_s`, or leave it out, since the history has its own end; or change the key that the
    ///   warning names.
    UNREACHED = "unreached";
    /// A modulus, density, strength, speed or size is far outside the range of solids.
    ///
    /// - Why: a number in the wrong unit: GPa for Pa, g/cm3 for kg/m3, mm for m.
    /// - Do: use the unit in the name of the key; if the value is intended, raise `run.plausible.unusual_value_rel`.
    /// - Judged: Factor by which a number is outside the range of solids: 1e6 to 2e12 Pa for a modulus, 10 to 3e4 kg/m3
    ///   for a density, 1e5 to 1e11 Pa for a yield stress, up to 6 km/s for a speed, 1 nm to 10 m for a size; of bonds
    ///   1e9 to 1e22 Pa/m for a stiffness, 1e-4 to 1e6 J/m2 for an energy.
    /// - Valid: 1 (inside).
    /// - Wrong: 1.4e4 (`young_pa = 70`).
    UNUSUAL_VALUE = "unusual_value": unusual_value_rel in run = [1.0, 1e300];
    /// Exchanged points have no mass, although their body has a step of its own.
    ///
    /// - Why: a program of your own does not describe its masses.
    /// - Do: give the lumped masses, or no step for a body that is always in equilibrium.
    WEIGHTLESS = "weightless";
    /// The masses of a body's points and the columns of its compliance do not fit each other.
    ///
    /// - Why: masses in the wrong unit or order, or columns of another window. Masses that are too small show only if
    ///   the body describes its `step_limit_s`.
    /// - Do: give lumped masses in kg, for the thickness of the scenario; `thirdbody conform` tests the columns.
    TOLD_MASS = "told_mass": [1.0, f64::INFINITY];
    /// The dissipated energy that a foreign program reports has decreased; beyond a tenth of its energies the run is
    /// suspect.
    ///
    /// - Why: the program reports a stored energy as dissipated, or its scheme creates energy.
    /// - Do: give the term the role `stored`, or take a shorter step.
    DISSIPATION = "dissipation": [1e-3, 0.1];
    /// A foreign program gave two different answers to the same window (the windows 16, 64, 256, .. are requested
    /// twice); beyond 1e-6 the run is suspect.
    ///
    /// - Why: random numbers, sums whose order depends on threads, or a window that does not start from the committed
    ///   state.
    /// - Do: run `thirdbody conform`, whose rules `repeats`, `rollback` and `same-bits` show the cause.
    REPEAT = "repeat": [0.0, 1e-6];
    /// No force passed through an interface in the whole run.
    ///
    /// - Why: the two sides never touched, or one of them answers with zeros.
    /// - Do: check the geometry of both sides and the signs.
    NO_FORCE = "no_force": [0.0, f64::INFINITY];
    /// A signal is NaN or infinite at times.
    ///
    /// - Why: a mean over no values, or a division by zero in the solver.
    /// - Do: look at the column in signals.csv.
    NOT_A_NUMBER = "not_a_number": [0.0, f64::INFINITY];
    /// The force through the interfaces differs from the load that is held.
    ///
    /// - Why: the system was not at rest, or something else carries the load.
    /// - Do: load more slowly, hold longer, or lower the masses.
    /// - Judged: Largest difference between the force through a participant's interfaces and the load that it holds,
    ///   over the load.
    /// - Valid: 6e-4.
    /// - Wrong: 0.035 (`mass_scale` 3e4).
    FORCE_BALANCE = "force_balance": force_balance_rel in run = [0.02, 0.1];
    /// The energies do not balance: some of the work is neither stored nor dissipated.
    ///
    /// - Why: a long step, or windows that did not converge.
    /// - Do: shorten the step.
    /// - Judged: Relative energy error: work of a participant, or of all together, that is neither stored nor
    ///   dissipated, over the work done.
    /// - Valid: 5e-4.
    /// - Wrong: 0.011.
    ENERGY_BALANCE = "energy_balance": energy_balance_rel in run = [0.01, 0.1];
    /// An interface lost or created energy.
    ///
    /// - Why: a scheme that uses late answers, a gap that remained, or a long window.
    /// - Do: lower `substeps`, or take a scheme that closes the gap.
    /// - Judged: Energy that the interfaces lost or created, over the energy that passed through them.
    /// - Valid: 1e-13; scheme `velocity` 0.011.
    INTERFACE_ENERGY = "interface_energy": interface_energy_rel in run = [0.02, 0.1];
    /// A participant's ledger and the exchange disagree about the work at its interfaces.
    ///
    /// - Why: its answers do not belong to the state that it keeps, or it counts wrongly.
    /// - Do: `thirdbody conform` names the rule that it breaks.
    /// - Judged: Difference between the work at its interfaces that a participant reports and the exchanged work
    ///   (`interface_work_rel` of each in summary.json); beyond the second bound the run ends with `inconsistent`, exit
    ///   code 3.
    /// - Valid: 2e-14.
    /// - Wrong: 4e-3 (repeats that are off by 1 %).
    INTERFACE_WORK = "interface_work": interface_work_rel in run = [1e-6, 1e-3];
    /// The two sides of an interface were apart.
    ///
    /// - Why: `dual-schur-cheap`, a staggered scheme, or windows that were accepted without having converged.
    /// - Do: take `dual-schur`, or shorten the window.
    /// - Judged: Largest gap between the two sides of an interface, over the spacing of its nodes.
    /// - Valid: 2e-16; `dual-schur-cheap` 5e-5.
    GAP = "gap": gap_rel in run = [0.01, 1.0];
    /// The glued points and the surface that carries them differ in shape.
    ///
    /// - Why: one side is tilted, its crown has its top at another x, or it has another curvature: another crown
    ///   radius, for instance.
    /// - Do: give both the same geometry.
    /// - Judged: Difference in shape (tilt and curvature) between the glued points and the surface of the other side,
    ///   over the spacing of the points, without the part that their roughness may explain.
    /// - Valid: 0.
    /// - Wrong: 0.02 (crown of 0.29 on 0.3 m).
    SURFACE_OFFSET = "surface_offset": surface_offset_rel in run = [0.01, 0.3];
    /// The glued points lie far from the surface of the other side.
    ///
    /// - Why: a size in the wrong unit.
    /// - Do: compare the coordinates of both sides.
    /// - Judged: Mean distance of the glued points from the surface of the other side, over the joined length. Each
    ///   side may have its own origin, but both must use metres.
    /// - Valid: 0.33.
    /// - Wrong: 62 (a surface 1 m off).
    SURFACE_DISTANCE = "surface_distance": surface_distance_rel in run = [10.0, 1e3];
    /// The points of one side are much farther apart than the nodes of the body that carries them.
    ///
    /// - Why: grains, or segments of `sample.surface`, are larger than the elements. `mapping = "mortar"` spreads each
    ///   force evenly up to halfway to the next point. With `"linear"` and `"nearest"` it acts on one or two nodes, and
    ///   the approach depends on the mesh.
    /// - Do: lower `sample.surface.spacing_m`, or take elements as large as the spacing.
    /// - Judged: Distance of neighbouring points over the distance of the nodes that carry them, times two with
    ///   `mapping = "linear"`, times four with `"nearest"`.
    /// - Valid: 0.35.
    /// - Wrong: 9.5 (a disk of 1.9 mm radius on elements of 0.4 mm: 4.77 um for 6.65 um).
    POINT_SPACING = "point_spacing": point_spacing_rel in run = [3.0, 1e300];
    /// A row of glued points has a hole.
    ///
    /// - Why: `mapping = "mortar"` gives each point the surface up to halfway to its neighbours, so that forces of the
    ///   points beside a hole press on the surface in the hole as well.
    /// - Do: take `mapping = "linear"`, an interface for each piece of the row, or glue points into the hole.
    /// - Judged: Largest distance of neighbouring points of an interface with `mapping = "mortar"`, over their median.
    /// - Valid: 2.2.
    /// - Wrong: 42 (two pairs of disks 16.8 mm apart: 15.9 um for 17.3 um).
    POINT_HOLE = "point_hole": point_hole_rel in run = [6.0, 1e300];
}

/// Compares the force through a participant's interfaces with the load that it holds. `through_n` is the mean force
/// that leaves the participant downwards over the same time (N).
pub fn force_balance(bounds: &Plausible, load: HeldLoad, through_n: f64) -> Option<Finding> {
    let off = [load.wanted_n, load.mean_n].map(|force| (through_n - force).abs());
    let value = larger(off[0], off[1]) / load.wanted_n.abs();
    let judged = judge!(bounds => FORCE_BALANCE, value;
        "its load is {:.5e} N and exerted {:.5e} N over the last half of the sampled phase, but {through_n:.5e} N passed through its interfaces: the system was not at rest, or something else carries the load; load more slowly, hold longer, or lower the masses",
        load.wanted_n, load.mean_n);
    judged.filter(|_| load.wanted_n != 0.0)
}

/// The energy error of a ledger.
pub fn energy_balance(bounds: &Plausible, value: f64) -> Option<Finding> {
    judge!(bounds => ENERGY_BALANCE, value;
        "{value:.3e} of the work done is neither stored nor dissipated: shorten the step, or look for windows that were accepted without having converged")
}

/// An energy balance that was lost during the run, at this time (s). The second bound decides.
pub fn lost_balance(
    kind: &FindingKind,
    bounds: &Plausible,
    value: f64,
    time_s: f64,
) -> Option<Finding> {
    let hopeless = Bounds::from([bounds.of(kind).suspect; 2]);
    judge!(hopeless, *kind, value;
        "at t = {time_s:.4e} s the energies do not balance: up to {value:.3e} of the work so far is neither stored nor dissipated, or was lost or created at an interface; even if the balance at the end is better, shorten the step or lower substeps, and look for windows that were accepted without having converged")
}

/// A decrease of the dissipated energy, as a fraction of the participant's energies.
pub fn dissipation(value: f64, time_s: f64) -> Option<Finding> {
    judge!(DISSIPATION, value;
        "the dissipated energy in its ledger had decreased by {value:.3e} of its energies at t = {time_s:.4e} s: energy that returns was stored and belongs to a term with the role `stored`, or the scheme creates energy and needs a shorter step")
}

/// The difference of two answers to one request, over the larger. Even rounding is reported, although it changes no
/// result.
pub fn repeat(window: u64, value: f64) -> Option<Finding> {
    judge!(REPEAT, value;
        "window {window} was requested twice with the same numbers, and the answers differ by {value:.3e} of the larger: a window must start from the committed state every time, without random numbers or remains of earlier requests; `thirdbody conform` shows more")
}

/// An interface through which no force passed.
pub fn no_force(windows: u64) -> Option<Finding> {
    judge!(NO_FORCE, windows as f64;
        "no force passed through it in {windows} windows: its sides never touched, or one of them answers with zeros")
}

/// Compares the masses of a body's points with the diagonal of its compliance C (m/N) in windows of H = m steps. With
/// any passive body behind it, a mass M moves at most H^2 (1 + 1/m) / (2 M) under 1 N; this follows from the sum over
/// modes of (1 - cos w t) / w^2 <= t^2 / 2. An explicit step below its limit, k h^2 <= 4 M, leaves at least about H^2 /
/// (2 m^2 M). Built-in bodies have 0.06 to 0.64 of the first and 3.6 to 13 times the second; twice the first and a
/// fifth of the second are the bounds.
pub fn told_mass(group: &Group, side: usize, columns: &[f64], explicit: bool) -> Option<Finding> {
    let side = &group.force_driven[side];
    let window = side.window(&group.clock.window(0, 0, group.clock.substeps));
    let (m, window_s) = (f64::from(window.substeps), group.clock.window_s());
    let free = window_s * window_s * (1.0 + 1.0 / m) / 2.0;
    let mass = &group.nodes.mass_kg[side.range.clone()];
    let own = columns.iter().enumerate();
    let parts = own.map(|(i, column)| column * mass[i / 2] / free);
    let part = parts.fold(0.0, larger);
    let light = if explicit && part > 0.0 {
        0.2 / (part * m * m)
    } else {
        0.0
    };
    judge!(TOLD_MASS, larger(0.5 * part, light);
        "under the forces of its columns its points move {part:.3e} of the way that their masses alone would: the masses in its description are too large or too small, or the columns belong to another window")
}

/// Ends of keys that the hold depends on, and the results of the hold or of means over it.
const HOLDS: [&str; 3] = ["ramp_s", "hold_s", "wheel.load_n"];
const OF_HOLD: &str = "approach_m contact_half_width_m dem_p_max_mean_pa dem_p_max_tr3_pa half_width_98_m interface_force_n p0_1mm_pa p0_pa \
    p_max_centroid_pa p_max_gauss_pa p_max_nodal_pa stress_xx_pa stress_xy_pa stress_yy_pa wheel_contacts wheel_contacts_90 wheel_force_n";

/// True for a result of the hold, of any interface.
pub fn of_hold(name: &str) -> bool {
    let own = name.rsplit('.').next();
    OF_HOLD.split(' ').any(|of_hold| Some(of_hold) == own)
}

/// Warnings about keys that take no effect before the run ends at `end_s`; true if the hold is not over by then.
pub fn unreached<'a>(
    scenario: &Scenario,
    descriptions: impl Iterator<Item = &'a Description> + Clone,
    end_s: f64,
) -> (Vec<Warning>, bool) {
    let last_s = last_s(end_s, descriptions.clone().find_map(|one| one.step_s));
    let fields = scenario.run.output.fields_every_s;
    let fields = fields.map(|every_s| ("run.output.fields_every_s".to_string(), every_s));
    let mut moments = Vec::from_iter(fields);
    for (participant, description) in scenario.participant.iter().zip(descriptions) {
        let own = description.moments.iter();
        let name = &participant.name;
        moments.extend(own.map(|(key, t)| (format!("participant.{name}.config.{key}"), *t)));
    }
    moments.retain(|(_, time_s)| *time_s > last_s);
    let held = |(key, _): &(String, f64)| HOLDS.iter().any(|end| key.ends_with(end));
    let no_hold = moments.iter().any(held);
    let warnings = moments.iter().map(|(key, time_s)| {
        let text = format!("takes effect, or is over, at t = {time_s:.4e} s, but the run ends at {end_s:.4e} s: results that need it are left out; let the run last longer, or change the key");
        Warning::advice(&UNREACHED, key, text)
    });
    (warnings.collect(), no_hold)
}

/// Latest moment (s) of a run that ends with the step around `end_s`: a moment belongs to the step whose end is
/// nearest.
fn last_s(end_s: f64, step_s: Option<f64>) -> f64 {
    let last_s = step_s.map(|step_s| ((end_s / step_s - 1e-6).ceil() + 0.5) * step_s);
    last_s.unwrap_or(end_s) * (1.0 + 1e-9)
}

/// A signal that is NaN or infinite.
pub fn not_a_number(signal: &str, value: f64, time_s: f64) -> Option<Finding> {
    judge!(NOT_A_NUMBER, 1.0;
        "its signal `{signal}` is {value} at t = {time_s:.4e} s, and perhaps later: signals.csv holds its values unchanged")
}

/// The work that went into a participant through its interfaces (J).
#[derive(Clone, Copy, Debug)]
pub struct InterfaceWorks {
    /// As its ledger reports it.
    pub reported_j: f64,
    /// From the exchanged forces and motions.
    pub seen_j: f64,
    /// Sum of the absolute values of the exchanged work.
    pub size_j: f64,
}

impl InterfaceWorks {
    /// Difference between reported and exchanged work, over the sum.
    pub fn apart_rel(&self) -> f64 {
        ratio((self.reported_j - self.seen_j).abs(), self.size_j)
    }
}

/// The work at its interfaces that a participant reports.
pub fn interface_work(bounds: &Plausible, works: InterfaceWorks) -> Option<Finding> {
    let (reported_j, seen_j) = (works.reported_j, works.seen_j);
    judge!(bounds => INTERFACE_WORK, works.apart_rel();
        "its ledger reports {reported_j:.6e} J of work through its interfaces, but the forces and motions that it exchanged give {seen_j:.6e} J: its answers do not belong to the state that it keeps, or its ledger is wrong; a window must start from the committed state every time, increments are of the window alone, and work is force times increment")
}

/// Refuses a run in which a participant contradicts itself: its ledger and its answers cannot both belong to the state
/// that it kept.
pub fn refuse_contradiction(judged: &[Warning]) -> Result<()> {
    let mut all = judged.iter();
    let found = all.find(|warning| warning.suspect && warning.code == INTERFACE_WORK.code);
    found.map_or(Ok(()), |Warning { about, text, .. }| {
        let text = format!("participant `{about}`: {text}");
        Err(Error::Inconsistent(text))
    })
}

/// The energy that an interface lost or created.
pub fn interface_energy(bounds: &Plausible, value: f64) -> Option<Finding> {
    judge!(bounds => INTERFACE_ENERGY, value;
        "it lost or created {value:.3e} of the energy that passed through it: lower substeps, or take a dual-schur scheme")
}

/// The gap that the windows left.
pub fn gap(bounds: &Plausible, value: f64) -> Option<Finding> {
    judge!(bounds => GAP, value;
        "a window was accepted with a gap of {value:.3e} node spacings: lower substeps, or take a scheme that closes the gap")
}

/// The difference in shape of two joined surfaces.
pub fn surface_offset(bounds: &Plausible, value: f64) -> Option<Finding> {
    judge!(bounds => SURFACE_OFFSET, value;
        "the shape of its row of points differs from the surface that carries them by {value:.3} of their spacing: give both sides the same shape (the crown of the body's mesh and sample.crown_radius_m, or sample.lid_crown_radius_m for a lid) and the same middle in x")
}

/// The distance of two joined surfaces.
pub fn surface_distance(bounds: &Plausible, value: f64) -> Option<Finding> {
    judge!(bounds => SURFACE_DISTANCE, value;
        "its row of points lies {value:.3e} times the joined length away from the surface that carries them: each side may have its own origin, but check that both use metres")
}

/// The spacing of an interface's points, compared with the nodes that carry them.
pub fn point_spacing(bounds: &Plausible, value: f64) -> Option<Finding> {
    judge!(bounds => POINT_SPACING, value;
        "its points are far apart for the nodes that carry them ({value:.1} distances of nodes, counted twice with mapping = \"linear\", four times with \"nearest\"): pressure is even between two points, or single nodes take the forces; lower sample.surface.spacing_m, or take larger elements")
}

/// The largest hole in an interface's row of points.
pub fn point_hole(bounds: &Plausible, value: f64) -> Option<Finding> {
    judge!(bounds => POINT_HOLE, value;
        "its row of points has a hole {value:.1} times as wide as their distance, and mapping = \"mortar\" spreads forces over it: take mapping = \"linear\", or an interface for each piece of the row")
}

/// Differences between the two surfaces of an interface.
pub fn surfaces(bounds: &Plausible, patch: &Patch) -> Vec<Warning> {
    let offset = patch.offset;
    let found = [
        surface_offset(bounds, offset.shape_rel),
        surface_distance(bounds, offset.distance_rel),
        point_spacing(bounds, offset.spacing_rel),
        point_hole(bounds, offset.hole_rel),
    ];
    let warnings = found.into_iter().flatten();
    let warnings = warnings.map(|finding| Warning::of(&patch.name, finding));
    warnings.collect()
}

/// The same, with a check of the continuum by its name and description: a body with a step of its own needs masses.
pub fn joined(
    bounds: &Plausible,
    group: &Group,
    patch: &Patch,
    (participant, description): (&str, &Description),
) -> Vec<Warning> {
    let mut found = surfaces(bounds, patch);
    let masses = &group.nodes.mass_kg[patch.nodes.clone()];
    let weightless = masses.iter().filter(|mass| **mass == 0.0).count();
    if weightless > 0 && description.step_s.is_some() {
        let text = format!(
            "{weightless} of its {} exchanged points have no mass, although it has a step of its own: give them their lumped masses, or give no step_s if the body is always in equilibrium",
            masses.len()
        );
        found.push(Warning::advice(&WEIGHTLESS, participant, text));
    }
    found
}

/// Windows that were accepted although they did not converge.
pub fn not_converged(bounds: &Plausible, accepted: u64, windows: u64) -> Option<Finding> {
    let value = accepted as f64 / windows.max(1) as f64;
    judge!(bounds => NOT_CONVERGED, value;
        "{accepted} of {windows} windows were accepted without having converged, because of on_not_converged = \"accept\"")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::warning::ADVICE;

    fn load(wanted_n: f64, mean_n: f64) -> HeldLoad {
        HeldLoad { wanted_n, mean_n }
    }

    #[test]
    fn the_interface_must_carry_the_wanted_and_the_exerted_load() {
        let found = |through| {
            force_balance(&Plausible::default(), load(100.0, 99.0), through).map(|f| f.suspect)
        };
        assert_eq!(found(100.0), None);
        assert_eq!(found(97.0), Some(false));
        assert_eq!(found(101.5), Some(false), "2.5 N above what is exerted");
        assert_eq!(found(89.0), Some(true));
        assert_eq!(found(-100.0), Some(true));
        assert_eq!(found(f64::NAN), Some(true));
        assert_eq!(
            force_balance(&Plausible::default(), load(0.0, 0.0), 1.0),
            None
        );
    }

    /// A run until 10.2 s in steps of 0.5 s continues to 10.5 s; the step that ends there is also the nearest to 10.7
    /// s.
    #[test]
    fn a_moment_belongs_to_the_nearest_end_of_a_step() {
        let reached = |step_s| [10.2, 10.7, 10.8].map(|moment| moment <= last_s(10.2, step_s));
        assert_eq!(reached(Some(0.5)), [true, true, false]);
        assert_eq!(reached(None), [true, false, false]);
    }

    #[test]
    fn results_of_the_hold_may_belong_to_any_interface() {
        let names = [
            "p0_pa",
            "layer-base.interface_force_n",
            "load_n",
            "p0_pascal",
        ];
        assert_eq!(names.map(of_hold), [true, true, false, false]);
    }

    #[test]
    fn a_warning_is_one_line_with_its_numbers() {
        let finding = not_converged(&Plausible::default(), 3, 10).expect("three tenths");
        let line = Warning::of("layer-base", finding).line();
        assert!(
            line.starts_with("warning[not_converged]: layer-base: 3 of 10 windows"),
            "{line}"
        );
        assert!(line.ends_with("(value 3.0000e-1, bound 1e-2)"), "{line}");
        let advice = Warning::advice(&ADVICE, "rail", "take care").line();
        assert_eq!(advice, "warning[advice]: rail: take care");
    }

    /// Expects no finding just inside the first bound, a warning between the bounds and a suspect run beyond the
    /// second.
    fn judges([warn, suspect]: [f64; 2], found: impl Fn(f64) -> Option<Finding>) {
        let [below, above] = [0.999, 1.001];
        let cases = [
            (below * warn, None),
            (above * warn, Some(false)),
            (below * suspect, Some(false)),
            (above * suspect, Some(true)),
        ];
        for (value, expected) in cases {
            let found = found(value);
            assert_eq!(
                found.as_ref().map(|f| f.suspect),
                expected,
                "{value}: {found:?}"
            );
        }
    }

    #[test]
    fn each_check_has_the_bounds_of_the_manual() {
        let bounds = &Plausible::default();
        for side in [1.0, -1.0] {
            judges([0.02, 0.1], |value| {
                let through = 100.0 * (1.0 + side * value);
                force_balance(bounds, load(100.0, 100.0), through)
            });
        }
        judges([0.01, 0.1], |v| energy_balance(bounds, v));
        judges([0.02, 0.1], |v| interface_energy(bounds, v));
        for side in [1.0, -1.0] {
            judges([1e-6, 1e-3], |v| {
                let works = InterfaceWorks {
                    reported_j: -3.0 + side * 5.0 * v,
                    seen_j: -3.0,
                    size_j: 5.0,
                };
                interface_work(bounds, works)
            });
        }
        judges([0.01, 1.0], |v| gap(bounds, v));
        judges([0.01, 0.3], |v| surface_offset(bounds, v));
        judges([10.0, 1e3], |v| surface_distance(bounds, v));
        judges([3.0, 1e300], |v| point_spacing(bounds, v));
        judges([6.0, 1e300], |v| point_hole(bounds, v));
        let accepted = |windows| {
            let found = not_converged(bounds, windows, 10_000);
            found.map(|finding| finding.suspect)
        };
        let found = [0, 1, 100, 101].map(accepted);
        assert_eq!(found, [None, Some(false), Some(false), Some(true)]);
    }

    #[test]
    fn a_balance_lost_during_the_run_uses_the_second_bound() {
        let bounds = Plausible::default();
        let found = |value| lost_balance(&ENERGY_BALANCE, &bounds, value, 1.0).map(|f| f.suspect);
        assert_eq!([0.0999, 0.1001].map(found), [None, Some(true)]);
    }
}
