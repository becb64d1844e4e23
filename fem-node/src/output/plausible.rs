//! Plausibility of the body's results: values of a run beyond the bounds of its scenario.

use fem_kernel::element::body::ElementKind;
use fem_kernel::element::shape::GAUSS_POINTS;
use fem_kernel::integrate::state::NodalState;
use fem_kernel::mesh::Edge;
use fem_kernel::pack::largest;
use fem_kernel::wheel::node_contact::ContactStatus;
use kit::finding::{BELOW_ZERO, HEAT_BALANCE, HEAT_STEPS, WHEEL_AT_REST};
use kit::judge;
use protocol::{Finding, larger};

use crate::model::Model;
use crate::model::heat::HeatState;
use crate::output::bending::bending_excess;
use crate::output::probe::largest_strain;
use crate::output::profile::ContactProfile;

kit::findings! {
    /// The wheel touches a body out to near its end.
    ///
    /// - Why: the body is narrow for this load.
    /// - Do: make `mesh.width_m` larger, or lower the load.
    /// - Judged: Distance of the outermost node in contact from the middle of the upper edge, over the distance of the edge's end, where wheel or
    ///   edge is curved.
    /// - Valid: 0.16.
    /// - Wrong: 0.63 (200 kN).
    CONTACT_REACH = "contact_reach": contact_reach_rel in fem = [0.5, 0.9];
    /// Few nodes of a body touch the wheel.
    ///
    /// - Why: a coarse mesh below the wheel.
    /// - Do: make `mesh.size_m` smaller there.
    /// - Judged: One over the number of nodes in a curved contact: three nodes of 0.4 mm are off by
    ///   1 to 10 % in approach and peak pressure, five by 0.6 %.
    /// - Valid: 0.2 (5 nodes, peak pressure 0.6 % off).
    /// - Wrong: 0.33 (3 nodes, 3 to 12 % off).
    CONTACT_RESOLUTION = "contact_resolution": contact_resolution in fem = [0.3, 0.8];
    /// A body is strained beyond the validity of its measure of strain.
    ///
    /// - Why: a high load, or `kinematics = "small"` with rotations.
    /// - Do: lower the load, or write `kinematics = "corotational"`.
    /// - Judged: Largest strain of a centroid, under small-strain kinematics the largest
    ///   displacement gradient, rotation included.
    /// - Valid: 0.04.
    /// - Wrong: 0.14 (200 kN).
    STRAIN = "strain": strain in fem = [0.1, 0.3];
    /// The elements of a body are too stiff, or too soft, in bending.
    ///
    /// - Why: `q4_2x2` locks where `material.poisson` is near 0.5; every element is wrong in a body
    ///   that bends with few elements across, or with elements much longer than wide.
    /// - Do: take `element = "q4_bbar"` where `material.poisson` is above 0.4, and more elements
    ///   across the body.
    /// - Judged: Difference between the strain energy of the elements and of bending, over all strain energy, while the body is elastic:
    ///   displacements under a load are off by about this share.
    /// - Valid: 0.006 (`two-rails`).
    /// - Wrong: 0.092 (`pressurised-cylinder` at Poisson's ratio 0.499 with `q4_2x2`, 9.4 % too
    ///   stiff), 0.13 (two `q4_2x2` across a beam, 13 %).
    LOCKING = "locking": locking_rel in fem = [0.05, 0.3];
    /// The layers of a body do not resolve its temperature.
    ///
    /// - Why: heat has entered less deep than the first layer is thick.
    /// - Do: make `heat.finest_m` smaller; at an edge other than the upper one, the elements.
    /// - Judged: Fall of the temperature over the outermost layer when the contact edge was furthest from its start, or beside an edge of `heat.edges` at the
    ///   end, over the largest rise.
    /// - Valid: 0.04 (`wheel-rail-heat`).
    /// - Wrong: 0.86 (`heat/half-space` without layers, 24 % too cold).
    THERMAL_DEPTH = "thermal_depth": thermal_depth_rel in fem = [0.3, 0.8];
    /// Temperatures of a coupled surface change much from one exchange of heat to the next.
    ///
    /// - Why: the exchanges are few, or each side overshoots, as the other one stands still between two exchanges.
    /// - Do: lower `interface.<name>.heat_every_windows`, or make its windows shorter.
    /// - Judged: Largest change of a temperature from one exchange to the next, over the range of all, or one over the number of exchanges.
    /// - Valid: 0.12 (`wheel-rail-heat`).
    /// - Wrong: 0.78 (`wheel-rail-heat` from grains of 400 K, four exchanges: 16 % more heat).
    HEAT_EXCHANGE = "heat_exchange": heat_exchange_rel in fem = [0.3, 0.8];
    /// A wheel of half-spaces slides off the points of a body that it warms.
    ///
    /// - Why: the body meets a fresh point of the wheel at each node, and a wheel that slides far brings the warm ones again.
    /// - Do: lower the creepage or `wheel.amplitude_m`, or write `heat.wheel_share`.
    /// - Judged: Creepage of a wheel that rolls, otherwise twice `wheel.amplitude_m` over the width of the contact.
    /// - Valid: 0.02 (a wheel that rolls with this creepage, share of the heat 1 % off).
    /// - Wrong: 1 (a locked wheel takes half of the heat; by the root of time it is a quarter after four widths of the contact).
    WHEEL_POINTS = "wheel_points": wheel_points_rel in fem = [0.1, 0.5];
    /// The surface of a body is hotter than solids with these properties are.
    ///
    /// - Why: insulated edges keep the heat, or a property or a speed has another unit.
    /// - Do: give `heat.edges`, or look at the units.
    /// - Judged: Highest temperature of the contact edge (K); steel melts at 1 800 K.
    /// - Valid: 692 (`heat/moving-source`).
    /// - Wrong: 12456 (the same with its capacity in J/(g K)).
    SURFACE_TEMPERATURE = "surface_temperature": surface_temperature_k in fem = [1500.0, 1e4];
    /// A body has yielded with an element that is wrong for plastic flow.
    ///
    /// - Why: `q4_2x2` locks, and `q4_1point` is hardly held against hourglass modes.
    /// - Do: take `element = "q4_bbar"`.
    /// - Judged: Largest equivalent plastic strain over the elastic one Y/(3 mu) at first yield,
    ///   where the element is not `q4_bbar`: in plastic flow, which keeps the volume, `q4_2x2` is
    ///   too stiff and `q4_1point` hardly held against hourglass modes.
    /// - Valid: 0.
    /// - Wrong: 20 (Prandtl punch; `q4_2x2` 14 to 19 % too high, `q4_1point` 1.1 to 1.6 %).
    PLASTIC_ELEMENT = "plastic_element": plastic_element in fem = [0.0, 1e300];
}

/// Share of the moved energy below which the strain energy is a remainder of vibrations.
const QUIET: f64 = 0.01;

/// The wheel must be at rest when its results are taken; `range` holds the least and largest force on it then (N).
pub(crate) fn wheel_at_rest(model: &Model, load: f64, range: [f64; 2]) -> Option<Finding> {
    let [low, high] = range;
    let value = larger(high - load, load - low) / load;
    let judged = judge!(model.plausible => WHEEL_AT_REST, value;
        "the wheel is not at rest before its motion: over the second half of the hold (without a hold, before the motion) the body carried {low:.4e} to {high:.4e} N of its {load:e} N: make wheel.hold_s or wheel.ramp_s longer, lower wheel.mass_kg, or change time.start_mass_damping_per_s");
    judged.filter(|_| load > 0.0)
}

/// A curved contact must cover several nodes.
pub(crate) fn contact_resolution(model: &Model, profile: &ContactProfile) -> Option<Finding> {
    let touching = profile.status.iter();
    let touching = touching.filter(|status| **status != ContactStatus::Open);
    let nodes = touching.count();
    let value = 1.0 / nodes as f64;
    let judged = judge!(model.plausible => CONTACT_RESOLUTION, value;
        "only {nodes} nodes of the body touch the wheel, too few for its pressure and approach: make mesh.size_m smaller under the wheel, or raise wheel.load_n");
    judged.filter(|_| nodes > 0 && is_curved(model))
}

/// Share of the size of a body by which the nodes of a flat edge may differ in height: a file has few digits, and `perturb_seed` moves them.
const FLAT: f64 = 1e-9;

/// True if a flat wheel would not touch all of the upper edge.
fn is_curved(model: &Model) -> bool {
    let nodes = model.mesh.edge(Edge::Top);
    let heights = nodes.iter().map(|n| model.mesh.point(n[0], n[1])[1]);
    let ends = heights.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], y| {
        [low.min(y), high.max(y)]
    });
    model.wheel_radius != 0.0 || ends[1] - ends[0] > FLAT * model.size
}

/// A curved contact must end before the body does; a body that repeats has no ends.
pub(crate) fn contact_reach<'a>(
    model: &Model,
    profiles: impl Iterator<Item = &'a ContactProfile>,
) -> Option<Finding> {
    let nodes = model.mesh.edge(Edge::Top);
    let points = nodes.iter().map(|n| model.mesh.point(n[0], n[1]));
    let points: Vec<[f64; 2]> = points.collect();
    let (first, last) = (points.first()?, points.last()?);
    if !is_curved(model) || model.mesh.period().is_some() {
        return None;
    }
    let (middle, half) = (0.5 * (first[0] + last[0]), 0.5 * (last[0] - first[0]).abs());
    let touching = profiles.flat_map(|profile| profile.x.iter().zip(&profile.status));
    let touching = touching.filter(|(_, status)| **status != ContactStatus::Open);
    let reach = largest(touching.map(|(x, _)| (x - middle).abs()));
    judge!(model.plausible => CONTACT_REACH, reach / half;
        "the wheel touches the body out to {reach:.3e} m from the middle of its upper edge, which ends at {half:.3e} m: the body is too narrow for this load; make mesh.width_m larger, or lower wheel.load_n")
}

/// Heat must be conserved, resolved, and within the range of solids; `lost` are the losses by friction and plastic flow (J).
pub(crate) fn heat(model: &Model, state: &HeatState, lost: [f64; 2]) -> Vec<Finding> {
    let Some(heat) = &model.heat else {
        return Vec::new();
    };
    let balance = heat.balance_rel(state, lost);
    let [rise, x, t] = state.field.peak;
    let ([_, fall], peak) = (state.field.extreme, heat.start + rise);
    let lowest = heat.start + state.field.lowest;
    let (jump, beside) = (heat.jump_rel(state), heat.body.fall_at_edges(&state.field));
    let found = [
        judge!(model.plausible => HEAT_BALANCE, balance;
            "{balance:.1e} of the heat was lost, or made without a loss: an error of the program, please report it"),
        judge!(model.plausible => THERMAL_DEPTH, fall;
            "when the contact edge was furthest from its start, {fall:.2} of its rise lay in the outermost layer: make heat.finest_m smaller"),
        judge!(model.plausible => THERMAL_DEPTH, beside;
            "{beside:.2} of the largest rise lies between an edge of heat.edges and the nodes beside it: make heat.finest_m smaller at the contact edge, or the elements at others"),
        judge!(model.plausible => HEAT_STEPS, heat.coarseness(state);
            "heat passed in few steps, or a factor changed much within one, and each mixes what happens within: lower heat.every_steps"),
        judge!(model.plausible => BELOW_ZERO, larger(0.0, -lowest);
            "a point of the body had {lowest:.0} K: look at the fluxes of heat.edges and at heat.capacity_factor"),
        judge!(model.plausible => HEAT_EXCHANGE, jump;
            "exchanges of heat were few, or a temperature of the coupled surface changed by {jump:.2} of their range from one to the next: lower heat_every_windows of its interface, or make its windows shorter"),
        judge!(model.plausible => SURFACE_TEMPERATURE, peak;
            "the contact edge had {peak:.0} K at t = {t:.3e} s and x = {x:.3e} m, far beyond solids with one capacity and conductivity: give heat.edges, or look at the units of heat"),
    ];
    found.into_iter().flatten().collect()
}

/// Points of a wheel of half-spaces must stay with their nodes while these touch it. `creepage` is of a wheel that rolls, else `amplitude` counts (m).
pub(crate) fn wheel_points(
    model: &Model,
    profile: &ContactProfile,
    (creepage, amplitude): (Option<f64>, f64),
) -> Option<Finding> {
    model.heat.as_ref().filter(|heat| heat.body.has_wheel())?;
    let lengths = model.mesh.surface(Edge::Top).1.into_iter();
    let touching = lengths.zip(&profile.status);
    let touching = touching.filter(|(_, status)| **status != ContactStatus::Open);
    let width: f64 = touching.map(|(length, _)| length).sum();
    let value = creepage.map_or(2.0 * amplitude / width, f64::abs);
    let judged = judge!(model.plausible => WHEEL_POINTS, value;
        "while a node of the body touches the wheel, the wheel slides {value:.2} of the contact past it, and heat.wheel_half_space takes its points for fresh ones: the wheel is too cold, and takes too much heat");
    judged.filter(|_| width > 0.0)
}

/// The larger of a strain and the largest strain of a state; NaN if either is NaN.
pub(crate) fn strain_so_far(before: f64, model: &Model, state: &NodalState) -> f64 {
    larger(before, largest_strain(model, state))
}

/// Strain must stay within the validity of the material model.
pub(crate) fn strain(model: &Model, value: f64) -> Option<Finding> {
    let means = if model.law.is_some() {
        "its law holds for small stretches only"
    } else {
        "small-strain elasticity holds for small displacement gradients only"
    };
    judge!(model.plausible => STRAIN, value;
        "the body is strained by up to {value:.3}, and {means}: lower the load, or check young_pa and the dimensions")
}

/// Plastic flow keeps the volume; only the element with one mean dilatation allows this with all of its modes held.
pub(crate) fn plastic_element(model: &Model, state: &NodalState) -> Option<Finding> {
    let law = model.plastic()?;
    let weakness = match model.element {
        ElementKind::Q4MeanDilatation => return None,
        ElementKind::Q4Full => {
            "q4_2x2 locks when the material keeps its volume: it has no limit load, and loads near collapse are too high"
        }
        ElementKind::Q4OnePoint => {
            "the hourglass modes of q4_1point are hardly held in plastic flow, and loads near collapse are higher by some per cent"
        }
    };
    let strain = largest_plastic_strain(model, state);
    let value = strain * 3.0 * law.mu / law.yield_stress;
    judge!(model.plausible => PLASTIC_ELEMENT, value;
        "the body has yielded, with an equivalent plastic strain of up to {strain:.3e}; {weakness}: take element = \"q4_bbar\", the default of a j2 material")
}

/// Elements that miss the energy of bending are too stiff, or too soft. `moved` is the kinetic energy plus the magnitudes of all energies in and out
/// (J): the strain energy that remains in a vibrating body shows nothing. [`plastic_element`] judges a body that has yielded.
pub(crate) fn locking(model: &Model, state: &NodalState, moved: f64) -> Option<Finding> {
    let [excess, energy] = bending_excess(model, state);
    let flowed = model.plastic().is_some() && largest_plastic_strain(model, state) > 0.0;
    if flowed || energy <= QUIET * moved {
        return None;
    }
    let share = excess / energy;
    let how = if share > 0.0 { "stiff" } else { "soft" };
    judge!(model.plausible => LOCKING, share.abs();
        "the elements are too {how} in bending by {:.3} of the strain energy, and displacements under a load are off by about as much: take more elements across a body in bending, none much longer than wide, and element = \"q4_bbar\" or \"q4_1point\" where material.poisson is above 0.4",
        share.abs())
}

/// Largest equivalent plastic strain.
fn largest_plastic_strain(model: &Model, state: &NodalState) -> f64 {
    let at = |element, point| model.body.plastic_strain(&state.history, element, point)[3];
    let elements = model.mesh.element_indices();
    largest(elements.flat_map(|element| GAUSS_POINTS.map(|point| at(element, point))))
}

#[cfg(test)]
mod tests {
    use super::*;
    use kit::read_config;
    use protocol::Setting;
    use serde_json::{Value, json};

    /// A body 10 mm wide, its upper edge with this crown (m; 0 = flat).
    fn model(crown: f64) -> Model {
        let mut mesh = json!({"width_m": 1e-2, "height_m": 2e-3, "size_m": 1e-3});
        if crown > 0.0 {
            mesh["crown_radius_m"] = Value::from(crown);
        }
        let config = json!({
            "mesh": mesh, "base": "free", "time": {"step_s": "auto", "damping": 0.5},
            "material": {"young_pa": 1e11, "poisson": 0.3, "density_kg_per_m3": 7800.0},
        });
        let setting = Setting {
            participant: "body".into(),
            seed: 0,
            thickness_m: 1e-3,
            threads: 1,
            fields: None,
            cache: None,
        };
        let config = read_config(&config).expect("the keys are valid");
        Model::new(&config, &setting).expect("the body is valid")
    }

    /// The body under a wheel with a face of this radius.
    fn under_wheel(radius: f64) -> Model {
        Model {
            wheel_radius: radius,
            ..model(0.0)
        }
    }

    fn profile(nodes: &[(f64, ContactStatus)]) -> ContactProfile {
        ContactProfile {
            x: nodes.iter().map(|(x, _)| *x).collect(),
            pressure: vec![0.0; nodes.len()],
            shear: vec![0.0; nodes.len()],
            status: nodes.iter().map(|(_, status)| *status).collect(),
        }
    }

    /// Expects nothing just inside the first bound, a warning between both and a suspect run beyond the second.
    fn judges(code: &str, [warn, suspect]: [f64; 2], found: impl Fn(f64) -> Option<Finding>) {
        let [below, above] = [0.999, 1.001];
        let cases = [
            (below * warn, None),
            (above * warn, Some(false)),
            (below * suspect, Some(false)),
            (above * suspect, Some(true)),
            (f64::NAN, Some(true)),
        ];
        for (value, expected) in cases {
            let found = found(value).map(|finding| (finding.code, finding.suspect));
            let expected = expected.map(|suspect| (code.to_string(), suspect));
            assert_eq!(found, expected, "{code} of {value}");
        }
    }

    #[test]
    fn the_wheel_is_judged_above_and_below_its_load() {
        let model = model(0.0);
        judges("wheel_at_rest", [0.05, 0.2], |value| {
            wheel_at_rest(&model, 1000.0, [1000.0, 1000.0 * (1.0 + value)])
        });
        judges("wheel_at_rest", [0.05, 0.2], |value| {
            wheel_at_rest(&model, 1000.0, [1000.0 * (1.0 - value), 1000.0])
        });
        assert_eq!(wheel_at_rest(&model, 0.0, [0.0, 1.0]), None, "no load");
    }

    #[test]
    fn a_curved_contact_needs_four_nodes() {
        let found = |model: &Model, nodes: usize| {
            let mut all = vec![(0.0, ContactStatus::Stick); nodes];
            all.extend([(0.0, ContactStatus::Open); 5]);
            contact_resolution(model, &profile(&all)).map(|finding| finding.suspect)
        };
        for model in [under_wheel(0.1), under_wheel(-0.1), model(0.3)] {
            let expected = [None, Some(true), Some(false), Some(false), None];
            for (nodes, expected) in expected.into_iter().enumerate() {
                assert_eq!(found(&model, nodes), expected, "{nodes} nodes");
            }
        }
        let mut flat = model(0.0);
        assert_eq!(found(&flat, 1), None, "a flat wheel on a flat body");
        flat.mesh.perturb(3);
        assert_eq!(found(&flat, 1), None, "moved by 1e-12 of an element");
    }

    #[test]
    fn a_curved_contact_must_end_before_the_body() {
        let found = |model: &Model, value: f64| {
            let held = [(0.0, ContactStatus::Stick), (4.9e-3, ContactStatus::Open)];
            let last = [(-5e-3 * value, ContactStatus::SlipForward)];
            contact_reach(model, [profile(&held), profile(&last)].iter())
        };
        for model in [under_wheel(0.1), model(0.3)] {
            judges("contact_reach", [0.5, 0.9], |value| found(&model, value));
        }
        assert_eq!(found(&model(0.0), 1.0), None, "a flat wheel on a flat body");
    }

    #[test]
    fn the_largest_strain_of_all_times_is_judged() {
        let model = model(0.0);
        judges("strain", [0.1, 0.3], |value| strain(&model, value));
        let mut state = NodalState::at_rest_under(&model.body, None);
        assert_eq!(strain_so_far(0.7, &model, &state), 0.7);
        for node in model.mesh.edge(Edge::Right) {
            // The last column, 1 mm wide, is made a tenth wider.
            state.u[model.body.layout.index(node, 0)] = 1e-4;
        }
        assert!((strain_so_far(0.05, &model, &state) - 0.1).abs() < 1e-12);
        assert!(strain_so_far(f64::NAN, &model, &state).is_nan());
    }
}
