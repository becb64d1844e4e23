//! The numerical choices of a scene, and the overrides that refine or coarsen each.

use scenario::keys::Scenario;
use scenario::load::Loaded;
use scenario::overrides::{number as number_of, value_at};

use super::file::shown;

/// A numerical choice; the physics of a scene stays unchanged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Knob {
    /// Size of the elements of graded meshes, with the matching explicit step. Windows keep their length.
    Mesh,
    /// Integration of the elements: one point, or two by two.
    Element,
    /// Length of the windows of all interfaces; one window is one step of the grains.
    Window,
    /// Step, or load increment, of solvers without an interface.
    Step,
    /// Mass scale of the grains.
    MassScale,
    /// Tolerances of contact solvers and of interfaces.
    Tolerance,
    /// Number of modes of continua that have only their lowest ones. All elements of other continua are finer than any number.
    Modes,
}

use Knob::{Element, MassScale, Mesh, Modes, Step, Tolerance, Window};

/// The choices in the order in which settings list their levels.
pub const KNOBS: [Knob; 7] = [Mesh, Element, Window, Step, MassScale, Tolerance, Modes];

/// A level of each choice: 0 is the unchanged scene; each finer level halves a length or a time, or divides by ten.
pub type Levels = [f64; KNOBS.len()];

impl Knob {
    /// Name of the choice.
    pub fn name(self) -> &'static str {
        let names = [
            "mesh",
            "element",
            "window",
            "step",
            "mass scale",
            "tolerance",
            "modes",
        ];
        names[self.index()]
    }

    /// Index among the levels of a setting.
    pub fn index(self) -> usize {
        self as usize
    }

    /// The most informative level besides 0 and 1. Heavier grains and wider tolerances save little time; much lighter grains need shorter
    /// windows, too.
    pub fn second(self) -> Option<f64> {
        match self {
            Mesh | Window | Step | Modes => Some(-1.0),
            Element | Tolerance => None,
            MassScale => Some(0.5),
        }
    }

    /// Levels that a setting may have.
    pub fn levels(self) -> &'static [f64] {
        match self {
            Mesh | Window | Step => &[-1.0, -0.5, 0.0, 0.5, 1.0, 1.5, 2.0],
            Tolerance | Element => &[0.0, 1.0],
            Modes => &[-1.0, 0.0, 1.0],
            // Grains lighter than in the runs may need shorter windows.
            MassScale => &[0.0, 0.5, 1.0],
        }
    }

    /// Levels that a reference may have.
    pub fn reference_levels(self) -> &'static [f64] {
        match self {
            Mesh | Window | Step => &[0.0, 0.5, 1.0, 1.5, 2.0, 2.5, 3.0],
            Modes => &[0.0, 1.0, 2.0],
            _ => self.levels(),
        }
    }

    /// Levels of the scene with this one changed.
    pub fn alone(self, level: f64) -> Levels {
        KNOBS.map(|knob| if knob == self { level } else { 0.0 })
    }
}

/// Smallest number of elements along the fine edge of a mesh.
const LEAST_COLUMNS: f64 = 4.0;

/// Step of elements with two by two points relative to one point: the ratio of their largest frequencies (fem.md).
const STEP_2X2: f64 = 0.8;

/// Modes at level 0 of a body that has all its elements, for the levels below.
const MODES: f64 = 100.0;

/// Words of a body that cannot have modes; keys of one that cannot have them or has them already, and of a set that is moved.
const NO_MODES_WITH: [(&str, &str); 3] = [
    ("analysis", "static"),
    ("base", "free"),
    ("kinematics", "corotational"),
];
const NO_MODES_BESIDE: [&str; 5] = [
    "reduced",
    "wheel",
    "initial",
    "material.yield_pa",
    "time.stiffness_damping_s",
];
const MOVED: [&str; 4] = [
    "velocity_m_per_s",
    "displacement_m",
    "motion",
    "motion_table",
];

/// Keys of a mesh that count elements.
const COUNTS: [&str; 2] = ["side_columns", "depth_rows"];

/// Keys of a mesh, and their values.
type MeshKeys = Vec<(&'static str, toml::Value)>;

/// The numerical choices of a scene.
pub struct Knobs<'a> {
    pub(super) scenario: &'a Scenario,
    table: toml::Table,
}

impl<'a> Knobs<'a> {
    /// The choices of a scene.
    pub fn of(loaded: &'a Loaded) -> Knobs<'a> {
        Knobs {
            scenario: &loaded.scenario,
            table: loaded.resolved.parse().unwrap_or_default(),
        }
    }

    /// Overrides of one level, the others unchanged; `None` if the scene has no such choice, or not at this level.
    pub fn at(&self, knob: Knob, level: f64) -> Option<Vec<String>> {
        let own = self.set(&knob.alone(level))?;
        (Some(&own) != self.set(&[0.0; KNOBS.len()]).as_ref()).then_some(own)
    }

    /// Overrides of these levels: all keys of all choices, so that two settings differ only in values. `None` if a level is impossible.
    pub fn set(&self, levels: &Levels) -> Option<Vec<String>> {
        let [mesh, element, window, step, mass, tolerance, modes] = *levels;
        let mut set = self.modes(modes)?;
        // Steps relative to the scene, by participant.
        let mut steps: Vec<(&str, f64)> = Vec::new();
        for participant in shipped(self.scenario, "fem") {
            let (ratio, keys) = self.mesh(participant, mesh)?;
            let keys = keys.into_iter();
            set.extend(keys.map(|(key, value)| config(participant, &format!("mesh.{key}"), value)));
            let one_point = self.text(participant, "element") == Some("q4_1point");
            if one_point {
                let word = if element > 0.0 { "q4_2x2" } else { "q4_1point" };
                set.push(config(participant, "element", word.into()));
            }
            let is_square = one_point && element > 0.0;
            let part = if is_square { STEP_2X2 } else { 1.0 };
            steps.push((participant, part * ratio));
        }
        for interface in &self.scenario.interface {
            let key = |name: &str| format!("interface.{}.{name}", interface.name);
            let sides = interface.participants();
            let own = steps.iter_mut().filter(|(name, _)| sides.contains(name));
            let mut own: Vec<&mut f64> = own.map(|(_, step)| step).collect();
            let least = own.iter().map(|step| **step).reduce(f64::min);
            let least = least.unwrap_or(1.0);
            // Steps are shortened so that a whole number of them fills the scene's window.
            let substeps = f64::from(interface.substeps());
            let kept = (substeps / least - 1e-9).ceil().max(1.0);
            own.iter_mut().for_each(|step| **step = substeps / kept);
            if let Some(window_s) = interface.window_s {
                let window_s = scaled(window_s, 0.5f64.powf(window));
                set.push(number(&key("window_s"), window_s));
            } else {
                let substeps = (kept * 0.5f64.powf(window)).round();
                if substeps < 1.0 {
                    return None;
                }
                set.push(format!("{}={substeps}", key("substeps")));
            }
            let bound = scaled(interface.tolerance_rel, 0.1f64.powf(tolerance)).min(0.1);
            set.push(number(&key("tolerance_rel"), bound));
        }
        let is_alone = self.scenario.interface.is_empty();
        let alone = if is_alone { 0.5f64.powf(step) } else { 1.0 };
        let mut times = |participant: &str, key: &str, factor: f64| {
            let own = self.number(participant, key).map(|own| scaled(own, factor));
            set.extend(own.map(|own| config(participant, key, own.into())));
        };
        for (participant, step) in steps {
            match self.text(participant, "analysis") {
                Some("static") => times(participant, "statics.increment_n", alone),
                _ => times(participant, "time.step_s", step * alone),
            }
        }
        for participant in shipped(self.scenario, "dem") {
            let heavy = self.number(participant, "mass_scale").unwrap_or(1.0);
            times(participant, "time.step_s", alone);
            let lighter = 0.1f64.powf(mass).max(1.0 / heavy);
            times(participant, "mass_scale", lighter);
            times(participant, "solver.tolerance", 0.1f64.powf(tolerance));
        }
        Some(set)
    }

    /// The choices that the scene has, with their values at these levels.
    pub fn words(&self, levels: &Levels) -> String {
        let known = KNOBS.into_iter().filter(|knob| self.has(*knob));
        let words =
            known.filter_map(|knob| Some(format!("{} {}", knob.name(), self.value(knob, levels)?)));
        Vec::from_iter(words).join(", ")
    }

    /// True if the scene has the choice.
    pub fn has(&self, knob: Knob) -> bool {
        self.at(knob, 1.0).or(self.at(knob, -1.0)).is_some()
    }

    /// The value of a choice at these levels, from the first participant or interface that has it.
    pub fn value(&self, knob: Knob, levels: &Levels) -> Option<String> {
        let set = self.set(levels)?;
        let value = |end: &str| {
            let mut keys = set.iter().filter_map(|set| set.split_once('='));
            Some(keys.find(|(key, _)| key.ends_with(end))?.1)
        };
        let number = |end: &str| value(end)?.parse::<f64>().ok();
        let words = |number: f64, unit: &str| {
            let rounded = format!("{number:.2e}").parse().unwrap_or(number);
            format!("{}{unit}", shown(&toml::Value::Float(rounded)))
        };
        match knob {
            Mesh => Some(words(number(".mesh.size_m")?, " m")),
            Element => Some(value(".element")?.trim_matches('"').into()),
            Window => match (number(".window_s"), number(".time.step_s")) {
                (Some(window_s), _) => Some(words(window_s, " s")),
                (None, Some(step_s)) => Some(words(number(".substeps")? * step_s, " s")),
                (None, None) => Some(format!("{} substeps", value(".substeps")?)),
            },
            Step => match number(".step_s") {
                Some(step_s) => Some(words(step_s, " s")),
                None => Some(words(number(".increment_n")?, " N")),
            },
            MassScale => Some(words(number(".mass_scale")?, "")),
            Tolerance => Some(words(number(".tolerance").or(number("_rel"))?, "")),
            Modes => Some(value(".reduced.modes")?.into()),
        }
    }

    /// Length of the longest surface of the shipped solvers, from their keys (m), if they have one.
    pub fn surface_m(&self) -> Option<f64> {
        let names = self.scenario.participant.iter().map(|p| p.name.as_str());
        let keys = [
            ("mesh.width_m", 1.0),
            ("sample.width_m", 1.0),
            ("sample.half_width_m", 2.0),
        ];
        let lengths =
            names.flat_map(|name| keys.map(|(key, whole)| Some(whole * self.number(name, key)?)));
        lengths.flatten().reduce(f64::max)
    }

    pub(super) fn given(&self, participant: &str, key: &str) -> Option<&toml::Value> {
        let key = format!("participant.{participant}.config.{key}");
        value_at(&self.table, &key)
    }

    pub(super) fn text(&self, participant: &str, key: &str) -> Option<&str> {
        self.given(participant, key)?.as_str()
    }

    pub(super) fn number(&self, participant: &str, key: &str) -> Option<f64> {
        number_of(self.given(participant, key)?)
    }

    /// Overrides of the modes of all bodies at a level. `None` above all elements, or below them if no body can have modes.
    fn modes(&self, level: f64) -> Option<Vec<String>> {
        let number = |participant: &str| self.number(participant, "reduced.modes");
        let all = || shipped(self.scenario, "fem");
        let is_reduced = all().any(|participant| number(participant).is_some());
        let of = |participant: &str| {
            let other =
                (!is_reduced && level < 0.0 && self.is_reducible(participant)).then_some(MODES);
            let modes = number(participant).or(other)?;
            let modes = (modes * level.exp2()).round().max(1.0) as i64;
            Some(config(participant, "reduced.modes", modes.into()))
        };
        let set: Vec<String> = all().filter_map(of).collect();
        (level == 0.0 || !set.is_empty()).then_some(set)
    }

    /// True for a supported linear body in motion, loaded by forces.
    fn is_reducible(&self, participant: &str) -> bool {
        let mut interfaces = self.scenario.interface.iter();
        let is_loaded = interfaces.any(|interface| {
            interface.participants().contains(&participant)
                && interface.scheme.to_string() != "velocity"
        });
        let mut words = NO_MODES_WITH.iter();
        let mut keys = NO_MODES_BESIDE.iter();
        let sets = self.given(participant, "boundary");
        let mut sets = sets.and_then(toml::Value::as_table).into_iter().flatten();
        let is_moved = |set: &toml::Value| MOVED.iter().any(|key| set.get(key).is_some());
        is_loaded
            && !words.any(|(key, word)| self.text(participant, key) == Some(word))
            && !keys.any(|key| self.given(participant, key).is_some())
            && !sets.any(|(_, set)| is_moved(set))
    }

    /// The mesh of a participant at a level: size of the elements relative to the scene, and the keys, without keys for a mesh from a file.
    /// `None` if no whole number of elements is near.
    fn mesh(&self, participant: &str, level: f64) -> Option<(f64, MeshKeys)> {
        let of = |key: &str| self.number(participant, &format!("mesh.{key}"));
        let all = of("size_m").zip(of("width_m")).zip(of("height_m"));
        let Some(((size, width), height)) = all.filter(|_| level != 0.0) else {
            let lengths = ["size_m", "fine_depth_m"].into_iter();
            let lengths = lengths.filter_map(|key| Some((key, of(key)?.into())));
            let counts = COUNTS.into_iter();
            let counts = counts.filter_map(|key| Some((key, (of(key)? as i64).into())));
            return Some((1.0, lengths.chain(counts).collect()));
        };
        let fine = of("fine_width_m").unwrap_or(width);
        let own = (fine / size).round();
        let wanted = (own * level.exp2()).round();
        // Without a fine depth, the whole height is fine.
        let fits = |columns: &f64| {
            let rows = height * columns / fine;
            let whole = (rows - rows.round()).abs() < 1e-9 * rows;
            *columns >= LEAST_COLUMNS && (of("fine_depth_m").is_some() || whole)
        };
        let near =
            (0..=(0.15 * wanted) as usize).flat_map(|k| [wanted + k as f64, wanted - k as f64]);
        let columns = near.into_iter().find(fits)?;
        let ratio = own / columns;
        let size = fine / columns;
        let mut keys = vec![("size_m", size.into())];
        let depth = of("fine_depth_m").map(|depth| (depth / size).round().max(1.0) * size);
        keys.extend(depth.map(|depth| ("fine_depth_m", depth.into())));
        for key in COUNTS {
            let count = of(key).filter(|count| *count > 0.0);
            let count = count.map(|count| ((count / ratio).round() as i64).max(1));
            keys.extend(count.map(|count| (key, count.into())));
        }
        Some((ratio, keys))
    }
}

/// Names of the participants of a scenario that are shipped solvers of this kind.
pub(super) fn shipped<'a>(scenario: &'a Scenario, kind: &str) -> impl Iterator<Item = &'a str> {
    let all = scenario.participant.iter();
    let shipped = all.filter(move |p| p.command.is_none() && p.kind == kind);
    shipped.map(|p| p.name.as_str())
}

/// A number times a factor, in twelve digits; with a factor of 1, the number itself.
fn scaled(own: f64, factor: f64) -> f64 {
    let product = own * factor;
    let rounded = format!("{product:.11e}").parse().unwrap_or(product);
    if factor == 1.0 { own } else { rounded }
}

/// An override of a key of a participant.
fn config(participant: &str, key: &str, value: toml::Value) -> String {
    let key = format!("participant.{participant}.config.{key}");
    match value.as_float() {
        Some(value) => number(&key, value),
        None => format!("{key}={value}"),
    }
}

/// An override by a number, written so that reading gives the same number.
fn number(key: &str, value: f64) -> String {
    format!("{key}={value:e}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use scenario::load::load;

    fn value(set: &[String], end: &str) -> f64 {
        let mut keys = set.iter().filter_map(|set| set.split_once('='));
        let found = keys.find(|(key, _)| key.ends_with(end));
        found.expect("the key").1.parse().expect("a number")
    }

    /// The levels of the scene give the scenario, and thus the run, of the scene.
    #[test]
    fn levels_of_zero_are_the_scene_itself() {
        for name in ["quick", "two-rails", "layer-alone", "wheel-rail-fe-small"] {
            let loaded = load(name, &[]).expect("a shipped scene");
            let set = Knobs::of(&loaded)
                .set(&[0.0; KNOBS.len()])
                .expect("its own");
            let again = load(name, &set).expect("the same scene");
            assert_eq!(again.hash, loaded.hash, "{name}: {set:?}");
        }
    }

    /// 54 elements of 0.4 mm in 21.6 mm, nine steps per window; half a level finer, 76 elements and 13 steps per window.
    #[test]
    fn a_finer_mesh_has_whole_elements_and_the_window_of_the_scene() {
        let loaded = load("quick", &[]).expect("a shipped scene");
        let knobs = Knobs::of(&loaded);
        for (level, columns, substeps) in [(0.5, 76.0, 13.0), (1.0, 108.0, 18.0), (-1.0, 27.0, 5.0)]
        {
            let set = knobs.at(Knob::Mesh, level).expect("a mesh");
            let size = value(&set, "mesh.size_m");
            assert!((21.6e-3 / size - columns).abs() < 1e-9);
            let rows = value(&set, "fine_depth_m") / size;
            assert!((rows - rows.round()).abs() < 1e-9);
            assert_eq!(value(&set, "substeps"), substeps);
            let window = substeps * value(&set, "step_s");
            assert!((window / 6.12e-7 - 1.0).abs() < 1e-10, "{window}");
        }
        let square = knobs.at(Knob::Element, 1.0).expect("two by two points");
        let window = value(&square, "substeps") * value(&square, "step_s");
        assert!((window / 6.12e-7 - 1.0).abs() < 1e-10 && value(&square, "step_s") < 0.81 * 6.8e-8);
    }

    /// All elements are finer than any number of modes.
    #[test]
    fn modes_are_offered_where_a_body_can_have_them() {
        let modes = |scene: &str, set: &[&str], level: f64| {
            let set: Vec<String> = set.iter().map(|set| set.to_string()).collect();
            let loaded = load(scene, &set).expect("a scene");
            let set = Knobs::of(&loaded).at(Knob::Modes, level)?;
            let set: Vec<&String> = set.iter().filter(|set| set.contains("reduced")).collect();
            let [set] = set[..] else { panic!("{set:?}") };
            let (_, body) = set.split_once("participant.").expect("a participant");
            Some(body.replace(".config.reduced.modes", ""))
        };
        let found = |scene, level| modes(scene, &[], level);
        assert_eq!(found("quick", -1.0), Some("rail=50".into()));
        assert_eq!(
            found("two-rails", -1.0),
            Some("lower=50".into()),
            "the upper one is free"
        );
        assert_eq!(found("quick", 1.0), None);
        let own = ["participant.rail.config.reduced.modes=30"];
        let levels = [-1.0, 0.0, 1.0].map(|level| modes("quick", &own, level));
        assert_eq!(
            levels,
            [Some("rail=15".into()), None, Some("rail=60".into())]
        );
        for other in [
            "reduced.omega_max_per_s=1e6",
            "kinematics=corotational",
            "time.stiffness_damping_s=1e-9",
        ] {
            let set = format!("participant.rail.config.{other}");
            assert_eq!(modes("quick", &[&set], -1.0), None, "{other}");
        }
        assert_eq!(found("wheel-rail-fe-small", -1.0), None);
        assert_eq!(found("layer-alone", -1.0), None);
    }

    #[test]
    fn a_scene_offers_only_the_choices_that_it_has() {
        let quick = load("quick", &["interface.layer-base.substeps=1".into()]).expect("a scene");
        let knobs = Knobs::of(&quick);
        // A window of one step cannot be halved, and coupled grains have no step of their own.
        assert_eq!(knobs.at(Knob::Window, 1.0), None);
        assert_eq!(knobs.at(Knob::Step, 1.0), None);
        let alone = load("layer-alone", &[]).expect("a shipped scene");
        let knobs = Knobs::of(&alone);
        assert_eq!(knobs.at(Knob::Mesh, 1.0), None);
        let finer = knobs.at(Knob::Step, 1.0).expect("a step");
        assert_eq!(value(&finer, "step_s"), 3.06e-7);
        let light = load(
            "layer-alone",
            &["participant.third-body.config.mass_scale=1.0".into()],
        );
        assert_eq!(
            Knobs::of(&light.expect("a scene")).at(Knob::MassScale, 1.0),
            None
        );
    }
}
