//! Warnings of a run: what its participants found about themselves, and what the coupler finds about forces, energies and joins.

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
    /// The run ends before a key comes into play, or before what it asks for is over (a ramp, a
    /// hold, cycles, a table, a feed).
    ///
    /// `thirdbody check` foretells it. Results that wait for that moment, as `p0_pa` does for the
    /// end of the hold, are left out.
    ///
    /// - Why: `run.end_s` is shorter than the history of the loads and motions, or a time of theirs
    ///   is in another unit.
    /// - Do: lengthen `run.end_s`, or leave it out: the history has an end of its own; or change
    ///   the key that is named.
    UNREACHED = "unreached";
    /// A modulus, density, strength, speed or size lies far outside of what solids have.
    ///
    /// - Why: a number in another unit: GPa for Pa, g/cm3 for kg/m3, mm for m.
    /// - Do: give the unit that the key is named by; where it is meant so, open
    ///   `run.plausible.unusual_value_rel`.
    /// - Judged: Factor by which a number lies outside of the range that solids have: 1e6 to 2e12 Pa
    ///   of a modulus, 10 to 3e4 kg/m3, 1e5 to 1e11 Pa of a yield stress, 6 km/s, 1 nm to 10 m.
    /// - Valid: 1 (inside).
    /// - Wrong: 1.4e4 (`young_pa = 70`).
    UNUSUAL_VALUE = "unusual_value": unusual_value_rel in run = [1.0, 1e300];
    /// Points that are exchanged have no mass, although their body has a step of its own.
    ///
    /// - Why: a program of your own that tells no masses.
    /// - Do: give the lumped masses, or no step for a body that is always in equilibrium.
    WEIGHTLESS = "weightless";
    /// The masses of a body's points and the columns of its compliance do not fit each other.
    ///
    /// - Why: masses in another unit or of another layout, or columns of another window. Masses
    ///   that are too small are seen only of a body that tells its `step_limit_s`.
    /// - Do: give lumped masses in kg, for the thickness of the scenario; `thirdbody conform` tries
    ///   the columns.
    TOLD_MASS = "told_mass": [1.0, f64::INFINITY];
    /// What a program of somebody else says it dissipated fell again; beyond a tenth of its
    /// energies the run is suspect.
    ///
    /// - Why: an energy that is stored is told as one that is lost, or the scheme makes energy.
    /// - Do: give the term the role `stored`, or take a shorter step.
    DISSIPATION = "dissipation": [1e-3, 0.1];
    /// A program of somebody else was asked for a window twice (the windows 16, 64, 256, ..) and
    /// gave two answers; beyond 1e-6 the run is suspect.
    ///
    /// - Why: random numbers, sums whose order depends on threads, or a window that does not begin
    ///   at the committed state.
    /// - Do: `thirdbody conform`; the rules `repeats`, `rollback` and `same-bits` tell more.
    REPEAT = "repeat": [0.0, 1e-6];
    /// No force went through an interface in the whole run.
    ///
    /// - Why: the two sides never touched, or one answers zeros.
    /// - Do: look at the geometry of both sides and at the signs.
    NO_FORCE = "no_force": [0.0, f64::INFINITY];
    /// A signal is no number at times.
    ///
    /// - Why: a mean over nothing, or a solver that divides by zero.
    /// - Do: look at the column in signals.csv.
    NOT_A_NUMBER = "not_a_number": [0.0, f64::INFINITY];
    /// The force through the interfaces is not the load that is held.
    ///
    /// - Why: nothing was at rest, or something else bears the load.
    /// - Do: load more slowly, hold longer, or lower the masses.
    /// - Judged: Largest distance of the force through a participant's interfaces from the load
    ///   that it says it holds, over the load.
    /// - Valid: 6e-4.
    /// - Wrong: 0.035 (`mass_scale` 3e4).
    FORCE_BALANCE = "force_balance": force_balance_rel in run = [0.02, 0.1];
    /// Energy is neither stored nor dissipated by any account.
    ///
    /// - Why: a long step, or windows that did not converge.
    /// - Do: shorten the step.
    /// - Judged: Energy that a participant, or all of them, cannot account for, over the work done.
    /// - Valid: 5e-4.
    /// - Wrong: 0.011.
    ENERGY_BALANCE = "energy_balance": energy_balance_rel in run = [0.01, 0.1];
    /// An interface lost or made energy.
    ///
    /// - Why: a scheme that lags, a gap that was left, or a long window.
    /// - Do: lower `substeps`, or take a scheme that closes the gap.
    /// - Judged: Energy that the interfaces lost or made, over the energy that went through them.
    /// - Valid: 1e-13; scheme `velocity` 0.011.
    INTERFACE_ENERGY = "interface_energy": interface_energy_rel in run = [0.02, 0.1];
    /// A participant's ledger and the exchange disagree about the work at its interfaces.
    ///
    /// - Why: it does not answer for the state that it keeps, or counts wrongly.
    /// - Do: `thirdbody conform` tells which rule it breaks.
    /// - Judged: Work at its interfaces that a participant tells against the one that was exchanged
    ///   (`interface_work_rel` of each in summary.json); beyond the second the run ends with
    ///   `inconsistent`, exit code 3.
    /// - Valid: 2e-14.
    /// - Wrong: 4e-3 (repeats that are off by 1 %).
    INTERFACE_WORK = "interface_work": interface_work_rel in run = [1e-6, 1e-3];
    /// Both sides of an interface lay apart.
    ///
    /// - Why: `dual-schur-cheap`, a staggered scheme, or windows that were accepted.
    /// - Do: take `dual-schur`, or shorten the window.
    /// - Judged: Largest gap between both sides of an interface, over the spacing of its nodes.
    /// - Valid: 2e-16; `dual-schur-cheap` 5e-5.
    GAP = "gap": gap_rel in run = [0.01, 1.0];
    /// The glued points and the surface that they hang on differ in shape.
    ///
    /// - Why: tilt or curvature of one side: another crown radius, for instance.
    /// - Do: give both the same geometry.
    /// - Judged: Difference in shape (tilt and curvature) between the glued points and the surface
    ///   of the other side, over the spacing of the points, less what their roughness may explain.
    /// - Valid: 0.
    /// - Wrong: 0.02 (crown of 0.29 on 0.3 m).
    SURFACE_OFFSET = "surface_offset": surface_offset_rel in run = [0.01, 0.3];
    /// The glued points lie far from the surface of the other side.
    ///
    /// - Why: a size in another unit.
    /// - Do: compare the coordinates of both sides.
    /// - Judged: Mean distance of the glued points from the surface of the other side, over the
    ///   length that is joined: each side may have an origin of its own, but not one in other
    ///   units.
    /// - Valid: 0.33.
    /// - Wrong: 62 (a surface 1 m off).
    SURFACE_DISTANCE = "surface_distance": surface_distance_rel in run = [10.0, 1e3];
    /// The points of one side lie much wider apart than the nodes of the body that carries them.
    ///
    /// - Why: grains, or segments of `sample.surface`, are larger than elements: the body feels
    ///   each force at one or two points, and the approach depends on the mesh.
    /// - Do: lower `sample.surface.spacing_m`, or take elements of the size of the spacing.
    /// - Judged: Distance of neighbouring points over the distance of the nodes that carry them.
    /// - Valid: 0.35.
    /// - Wrong: 9.5 (a disk of 1.9 mm radius on elements of 0.4 mm: 4.77 um for 6.65 um).
    POINT_SPACING = "point_spacing": point_spacing_rel in run = [3.0, 1e300];
}

/// The force through the interfaces of a participant against the load that it holds. `through_n` is what leaves the
/// participant downwards, the mean over the same time (N).
pub fn force_balance(bounds: &Plausible, load: HeldLoad, through_n: f64) -> Option<Finding> {
    let off = [load.wanted_n, load.mean_n].map(|force| (through_n - force).abs());
    let value = larger(off[0], off[1]) / load.wanted_n.abs();
    let judged = judge!(bounds => FORCE_BALANCE, value;
        "its load is {:.5e} N and exerted {:.5e} N over the last half of the sampled phase, and {through_n:.5e} N went through its interfaces: nothing was at rest there, or something else bears the load; load more slowly, hold longer, or lower the masses",
        load.wanted_n, load.mean_n);
    judged.filter(|_| load.wanted_n != 0.0)
}

/// The energy that a ledger cannot account for.
pub fn energy_balance(bounds: &Plausible, value: f64) -> Option<Finding> {
    judge!(bounds => ENERGY_BALANCE, value;
        "{value:.3e} of the work done is neither stored nor dissipated by any account: shorten the step, or look for windows that were accepted without having converged")
}

/// An energy balance that was lost on the way, at this time (s). It is the second bound that decides.
pub fn lost_balance(
    kind: &FindingKind,
    bounds: &Plausible,
    value: f64,
    time_s: f64,
) -> Option<Finding> {
    let suspect = bounds.of(kind).suspect;
    let hopeless = Bounds {
        warn: suspect,
        suspect,
    };
    judge!(hopeless, *kind, value;
        "at t = {time_s:.4e} s the energies do not balance: up to {value:.3e} of the work so far is neither stored nor dissipated, or was lost or made at an interface; whatever the end looks like, shorten the step or lower substeps, and look for windows that were accepted without having converged")
}

/// Dissipated energy that came back by this part of a participant's energies.
pub fn dissipation(value: f64, time_s: f64) -> Option<Finding> {
    judge!(DISSIPATION, value;
        "what its ledger says it dissipated fell again by {value:.3e} of its energies until t = {time_s:.4e} s: what comes back was stored, and belongs to a term of that role, or its scheme makes energy and needs a shorter step")
}

/// The difference of two answers to one request, over the larger; rounding is no excuse, but changes no result.
pub fn repeat(window: u64, value: f64) -> Option<Finding> {
    judge!(REPEAT, value;
        "window {window} was asked for twice with the same numbers, and the answers differ by {value:.3e} of the larger: a window must begin at the committed state every time, and nothing random or left from before may enter; `thirdbody conform` tells more")
}

/// An interface that no force went through.
pub fn no_force(windows: u64) -> Option<Finding> {
    judge!(NO_FORCE, windows as f64;
        "no force went through it in {windows} windows: its sides never touched, or one of them answers nothing")
}

/// The masses of a body's points against the diagonal of its compliance C (m/N) in windows of H = m steps: with any passive body behind it, a mass M goes
/// at most H^2 (1 + 1/m) / (2 M) far under 1 N, which a sum over modes of (1 - cos w t) / w^2 <= t^2 / 2 says. An explicit step below
/// its limit, k h^2 <= 4 M, leaves some H^2 / (2 m^2 M) at least. Shipped bodies: 0.06 to 0.64 of the first, 3.6 to 13 times the
/// second; twice the first and a fifth of the second are the bounds.
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
        "under the forces of its columns its points go {part:.3e} of the way that their masses alone would: the masses that it tells are too large or too small, or the columns are not of this window")
}

/// Ends of keys that the state of the hold waits for, and the results that are of it or means over it.
const HOLDS: [&str; 3] = ["ramp_s", "hold_s", "wheel.load_n"];
const OF_HOLD: &str = "approach_m contact_half_width_m dem_p_max_mean_pa dem_p_max_tr3_pa half_width_98_m interface_force_n p0_1mm_pa p0_pa \
    p_max_centroid_pa p_max_gauss_pa p_max_nodal_pa stress_xx_pa stress_xy_pa stress_yy_pa wheel_contacts wheel_contacts_90 wheel_force_n";

/// True for a result of the hold, of whichever interface.
pub fn of_hold(name: &str) -> bool {
    let own = name.rsplit('.').next();
    OF_HOLD.split(' ').any(|of_hold| Some(of_hold) == own)
}

/// Keys that do not come into play before a run ends at `end_s`; true if the hold is not over by then.
pub fn unreached<'a>(
    scenario: &Scenario,
    told: impl Iterator<Item = &'a Description> + Clone,
    end_s: f64,
) -> (Vec<Warning>, bool) {
    let last_s = last_s(end_s, told.clone().find_map(|one| one.step_s));
    let fields = scenario.run.output.fields_every_s;
    let fields = fields.map(|every_s| ("run.output.fields_every_s".to_string(), every_s));
    let mut moments = Vec::from_iter(fields);
    for (participant, told) in scenario.participant.iter().zip(told) {
        let own = told.moments.iter();
        let name = &participant.name;
        moments.extend(own.map(|(key, t)| (format!("participant.{name}.config.{key}"), *t)));
    }
    moments.retain(|(_, time_s)| *time_s > last_s);
    let held = |(key, _): &(String, f64)| HOLDS.iter().any(|end| key.ends_with(end));
    let no_hold = moments.iter().any(held);
    let warnings = moments.iter().map(|(key, time_s)| {
        let text = format!("comes into play, or is over, at t = {time_s:.4e} s, and the run ends at {end_s:.4e} s: results that wait for it are left out; let the run last longer, or change the key");
        Warning::advice(&UNREACHED, key, text)
    });
    (warnings.collect(), no_hold)
}

/// Latest moment of a run that ends in the step (s) in which `end_s` lies: a moment is that of the step whose end is nearest.
fn last_s(end_s: f64, step_s: Option<f64>) -> f64 {
    let last_s = step_s.map(|step_s| ((end_s / step_s - 1e-6).ceil() + 0.5) * step_s);
    last_s.unwrap_or(end_s) * (1.0 + 1e-9)
}

/// A signal that is no number.
pub fn not_a_number(signal: &str, value: f64, time_s: f64) -> Option<Finding> {
    judge!(NOT_A_NUMBER, 1.0;
        "its signal `{signal}` is {value} from t = {time_s:.4e} s on, or at times: signals.csv holds it as it came")
}

/// The work that went into a participant through its interfaces (J).
#[derive(Clone, Copy, Debug)]
pub struct InterfaceWorks {
    /// As its ledger tells it.
    pub told_j: f64,
    /// By the forces and motions that were exchanged.
    pub seen_j: f64,
    /// Sum of the sizes of the latter.
    pub size_j: f64,
}

impl InterfaceWorks {
    /// Difference between the two, over the size.
    pub fn apart_rel(&self) -> f64 {
        ratio((self.told_j - self.seen_j).abs(), self.size_j)
    }
}

/// The work at its interfaces that a participant tells.
pub fn interface_work(bounds: &Plausible, works: InterfaceWorks) -> Option<Finding> {
    let InterfaceWorks { told_j, seen_j, .. } = works;
    judge!(bounds => INTERFACE_WORK, works.apart_rel();
        "its ledger says that {told_j:.6e} J went into it through its interfaces, by the forces and motions that it exchanged it was {seen_j:.6e} J: it does not answer for the state that it keeps, or its ledger is wrong; a window must begin at the committed state every time, increments are those of the window alone, and the work is force times increment")
}

/// Refuses a run in which a participant contradicts itself: its ledger, and what it answered, cannot both be of the state it kept.
pub fn refuse_contradiction(judged: &[Warning]) -> Result<()> {
    let mut all = judged.iter();
    match all.find(|warning| warning.suspect && warning.code == INTERFACE_WORK.code) {
        None => Ok(()),
        Some(Warning { about, text, .. }) => Err(Error::Inconsistent(format!(
            "participant `{about}`: {text}"
        ))),
    }
}

/// The energy that an interface lost or made.
pub fn interface_energy(bounds: &Plausible, value: f64) -> Option<Finding> {
    judge!(bounds => INTERFACE_ENERGY, value;
        "it lost or made {value:.3e} of the energy that went through it: lower substeps, or take a dual-schur scheme")
}

/// The gap that the windows left.
pub fn gap(bounds: &Plausible, value: f64) -> Option<Finding> {
    judge!(bounds => GAP, value;
        "a window was accepted with a gap of {value:.3e} node spacings: lower substeps, or take a scheme that closes it")
}

/// The shape of two surfaces that are joined.
pub fn surface_offset(bounds: &Plausible, value: f64) -> Option<Finding> {
    judge!(bounds => SURFACE_OFFSET, value;
        "the shape of the row of its points is off that of the surface which carries them by {value:.3} of their spacing: give both sides the same shape (mesh.crown_radius_m and sample.crown_radius_m, of a lid sample.lid_crown_radius_m)")
}

/// The place of two surfaces that are joined.
pub fn surface_distance(bounds: &Plausible, value: f64) -> Option<Finding> {
    judge!(bounds => SURFACE_DISTANCE, value;
        "the row of its points lies {value:.3e} times the length that is joined away from the surface which carries them: each side may have an origin of its own, but check that both give metres")
}

/// The distance of the points of an interface beside the nodes that carry them.
pub fn point_spacing(bounds: &Plausible, value: f64) -> Option<Finding> {
    judge!(bounds => POINT_SPACING, value;
        "its points lie {value:.1} times as far apart as the nodes that carry them, so that single nodes take the forces and the approach depends on the mesh: lower sample.surface.spacing_m, or take larger elements")
}

/// Differences between the two surfaces of an interface.
pub fn surfaces(bounds: &Plausible, patch: &Patch) -> Vec<Warning> {
    let offset = patch.offset;
    let found = [
        surface_offset(bounds, offset.shape_rel),
        surface_distance(bounds, offset.distance_rel),
        point_spacing(bounds, offset.spacing_rel),
    ];
    let warnings = found.into_iter().flatten();
    let warnings = warnings.map(|finding| Warning::of(&patch.name, finding));
    warnings.collect()
}

/// The same with the points of the continuum, its name and what it says of itself beside it: what has a step of its own and moves
/// through time weighs something.
pub fn joined(
    bounds: &Plausible,
    group: &Group,
    patch: &Patch,
    (participant, told): (&str, &Description),
) -> Vec<Warning> {
    let mut found = surfaces(bounds, patch);
    let masses = &group.nodes.mass_kg[patch.nodes.clone()];
    let weightless = masses.iter().filter(|mass| **mass == 0.0).count();
    if weightless > 0 && told.step_s.is_some() {
        let text = format!(
            "{weightless} of its {} exchanged points have no mass, although it has a step of its own: give them their lumped masses, or no step_s if it is always in equilibrium",
            masses.len()
        );
        found.push(Warning::advice(&WEIGHTLESS, participant, text));
    }
    found
}

/// Windows that were accepted all the same.
pub fn not_converged(bounds: &Plausible, accepted: u64, windows: u64) -> Option<Finding> {
    let value = accepted as f64 / windows.max(1) as f64;
    judge!(bounds => NOT_CONVERGED, value;
        "{accepted} of {windows} windows were accepted without having converged, as on_not_converged = \"accept\" asks")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::warning::ADVICE;

    fn load(wanted_n: f64, mean_n: f64) -> HeldLoad {
        HeldLoad { wanted_n, mean_n }
    }

    #[test]
    fn the_interface_must_bear_the_load_that_is_wanted_and_the_one_that_is_exerted() {
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

    /// A run until 10.2 s in steps of 0.5 s goes on until 10.5 s, and the step that ends there is the nearest to 10.7 s too.
    #[test]
    fn a_moment_is_that_of_the_nearest_end_of_a_step() {
        let reached = |step_s| [10.2, 10.7, 10.8].map(|moment| moment <= last_s(10.2, step_s));
        assert_eq!(reached(Some(0.5)), [true, true, false]);
        assert_eq!(reached(None), [true, false, false]);
    }

    #[test]
    fn results_of_the_hold_are_those_of_any_interface() {
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

    /// Expects nothing just inside the first bound, a warning between both and a suspect run beyond the second.
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
                    told_j: -3.0 + side * 5.0 * v,
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
        let accepted = |windows| {
            let found = not_converged(bounds, windows, 10_000);
            found.map(|finding| finding.suspect)
        };
        let found = [0, 1, 100, 101].map(accepted);
        assert_eq!(found, [None, Some(false), Some(false), Some(true)]);
    }

    #[test]
    fn a_balance_that_is_lost_on_the_way_goes_by_the_second_bound() {
        let bounds = Plausible::default();
        let found = |value| lost_balance(&ENERGY_BALANCE, &bounds, value, 1.0).map(|f| f.suspect);
        assert_eq!([0.0999, 0.1001].map(found), [None, Some(true)]);
    }
}
