//! A study that is written for a scene: its numerical choices, its measures, and a shorter load history.

use super::knobs::{KNOBS, Knob, Knobs, Levels};
use super::measure::{Measure, TRACTION};

/// Values of a name that stand for overrides: the shown value, and the overrides.
pub type Cases = Vec<(String, Vec<String>)>;

/// A study to be written.
#[derive(Clone, Debug, Default)]
pub struct Draft {
    /// Comment at its head, one sentence per line.
    pub head: String,
    /// Its name.
    pub name: String,
    /// The scenario, in the form that `run` accepts.
    pub scenario: String,
    /// Overrides of all runs.
    pub set: Vec<String>,
    /// Overrides of `--small`.
    pub small: Vec<String>,
    /// Overrides of the reference.
    pub reference: Vec<String>,
    /// Number of perturbed references.
    pub perturb: u64,
    /// Seeds that are scenes.
    pub seeds: Vec<u64>,
    /// Names and cases that are varied one at a time.
    pub vary: Vec<(String, Cases)>,
    /// The measures.
    pub measures: Vec<Measure>,
}

impl Draft {
    /// The text of study.toml.
    pub fn toml(&self) -> String {
        let string = |text: &String| toml::Value::from(text.as_str()).to_string();
        let list = |set: &[String]| match set {
            [] => "[]".to_string(),
            set => {
                let lines = set.iter().map(|set| format!("    {},\n", string(set)));
                format!("[\n{}]", lines.collect::<String>())
            }
        };
        let mut text = format!(
            "# {}\n\n[study]\nname = {}\nscenario = {}\nset = {}\nmode = \"one-at-a-time\"\n",
            self.head.replace('\n', "\n# "),
            string(&self.name),
            string(&self.scenario),
            list(&self.set)
        );
        if !self.small.is_empty() {
            let small = list(&self.small);
            text += &format!("\n# With --small: a shorter load history.\n[small]\nset = {small}\n");
        }
        let (reference, perturb) = (list(&self.reference), self.perturb);
        text += &format!("\n[reference]\nset = {reference}\nperturb = {perturb}\n");
        if !self.seeds.is_empty() {
            let seeds = &self.seeds;
            text += &format!("\n[[vary]]\nkey = \"run.seed\"\nscene = true\nvalues = {seeds:?}\n");
        }
        for (name, cases) in &self.vary {
            let lines = cases.iter().map(|(value, set)| {
                let sets: Vec<String> = set.iter().map(string).collect();
                let (value, sets) = (string(value), sets.join(", "));
                format!("    {{ value = {value}, set = [{sets}] }},\n")
            });
            let (name, lines) = (string(name), lines.collect::<String>());
            text += &format!("\n[[vary]]\nkey = {name}\ncase = [\n{lines}]\n");
        }
        for measure in &self.measures {
            let measure = toml::to_string(measure).unwrap_or_default();
            text += &format!("\n[[measure]]\n{measure}");
        }
        text
    }
}

/// The cases of a choice at these levels, with the scene's values of the other choices; levels that the choice lacks are left out.
pub fn cases(knobs: &Knobs, knob: Knob, levels: &[f64]) -> Cases {
    let case = |level: &f64| {
        let value = knobs.value(knob, &knob.alone(*level))?;
        Some((value, knobs.at(knob, *level)?))
    };
    levels.iter().filter_map(case).collect()
}

/// The numerical choices of a scene against a reference that is finer by a level in all of them: one at a time, then several together, if
/// `stands` accepts them. `None` if the scene has no such choice.
pub fn of_choices(knobs: &Knobs, stands: impl Fn(&[String]) -> bool) -> Option<Draft> {
    let finer: Levels = KNOBS.map(|knob| match knobs.at(knob, 1.0) {
        Some(set) if stands(&set) => 1.0,
        _ => 0.0,
    });
    let reference = knobs.set(&finer)?;
    let overrides = |levels: &Levels| {
        let mut set = knobs.set(levels).filter(|set| stands(set))?;
        set.retain(|set| !reference.contains(set));
        Some(set)
    };
    let known: Vec<Knob> = KNOBS.into_iter().filter(|knob| knobs.has(*knob)).collect();
    let mut vary = Vec::new();
    for knob in &known {
        let index = knob.index();
        let levels = knob.levels().iter().filter(|level| **level < finer[index]);
        let alone = levels.filter_map(|level| {
            let mut levels = finer;
            levels[index] = *level;
            let set = overrides(&levels)?;
            Some((knobs.value(*knob, &levels)?, set))
        });
        vary.push((knob.name().to_string(), alone.collect()));
    }
    let together = [-1.0f64, -0.5, 0.0, 0.5].iter().filter_map(|level| {
        let levels = KNOBS.map(|knob| match knob {
            Knob::Mesh | Knob::Window | Knob::Step => *level,
            Knob::MassScale => level.max(0.0),
            Knob::Tolerance | Knob::Modes => level.trunc(),
            Knob::Element => 0.0,
        });
        Some((knobs.words(&levels), overrides(&levels)?))
    });
    vary.push(("together".into(), together.collect::<Cases>()));
    for (_, cases) in &mut vary {
        // Half a level may round to a value that is there already, or have the same digits.
        cases.dedup_by(|a, b| a.0 == b.0 || a.1 == b.1);
    }
    vary.retain(|(_, cases)| !cases.is_empty());
    (!known.is_empty()).then(|| Draft {
        reference: reference.clone(),
        vary,
        ..Draft::default()
    })
}

/// The participant with a wheel.
fn under_wheel<'a>(knobs: &Knobs<'a>) -> Option<&'a str> {
    let mut names = knobs.scenario.participant.iter().map(|p| p.name.as_str());
    names.find(|name| knobs.number(name, "wheel.load_n").is_some())
}

/// Measures of the surface below a wheel that [`measures`] leaves out: the shear, and the vector of pressure and shear.
pub fn further_measures(knobs: &Knobs) -> Vec<Measure> {
    let further = [("shear", "shear_pa"), ("traction", TRACTION)];
    let of = |name| further.map(|(word, of)| of_profile(knobs, name, word, of));
    under_wheel(knobs).map_or(Vec::new(), |name| of(name).into())
}

/// The L2 norm of a column of the profile, in bins of a few grains or elements.
fn of_profile(knobs: &Knobs, participant: &str, name: &str, column: &str) -> Measure {
    let part = |key: &str, part: f64| knobs.number(participant, key).map(|length| part * length);
    let grains = part("sample.half_width_m", 0.125).or(part("sample.width_m", 0.0625));
    Measure {
        bin_m: grains.or(part("mesh.size_m", 2.0)),
        ..Measure::new(name, format!("profile.{column}"))
    }
}

/// The measures of a scene: pressure, height and friction of its wheel; without a wheel, the forces on its interfaces, or on the last of
/// its driven clusters.
pub fn measures(knobs: &Knobs) -> Vec<Measure> {
    let scenario = knobs.scenario;
    if let Some(name) = under_wheel(knobs) {
        let pressure = of_profile(knobs, name, "pressure", "pressure_pa");
        let is_static = knobs.text(name, "analysis") == Some("static");
        let height = if is_static { "approach_m" } else { "wheel_y_m" };
        let height = Measure::new("height", format!("signals.{height}"));
        let mut all = vec![pressure, height];
        if knobs.number(name, "wheel.cycles").unwrap_or(0.0) > 0.0 {
            all.push(Measure::new("friction", "signals.wheel_ft_n".into()));
        }
        return all;
    }
    let interfaces = &scenario.interface;
    let several = interfaces.len() > 1;
    let of_interface = interfaces.iter().flat_map(|interface| {
        let name = several.then_some(&interface.name);
        let prefix = |end: &str| name.map_or(String::new(), |name| format!("{name}{end}"));
        [("load", "y"), ("shear", "x")].map(|(what, axis)| {
            let signal = format!("signals.{}interface_f{axis}_n", prefix("."));
            Measure::new(&format!("{}{what}", prefix("-")), signal)
        })
    });
    let mut all: Vec<Measure> = of_interface.collect();
    if let ([participant], true) = (&scenario.participant[..], all.is_empty()) {
        let driven = |cluster: &&toml::Value| cluster.get("drive").is_some();
        let clusters = knobs.given(&participant.name, "sample.clusters");
        let clusters = clusters.and_then(toml::Value::as_array);
        let last = clusters.into_iter().flatten().rfind(driven);
        if let Some(name) = last.and_then(|cluster| cluster.get("name")?.as_str()) {
            let force = |axis: &str| format!("signals.{name}_force_{axis}_n");
            all.push(Measure::new("load", force("y")));
            all.push(Measure::new("shear", force("x")));
        }
    }
    all
}

/// Overrides that end the load history of each wheel after a quarter of a cycle, if it is longer.
pub fn shortened(knobs: &Knobs) -> Vec<String> {
    let names = knobs.scenario.participant.iter().map(|p| &p.name);
    let long = names.filter(|name| knobs.number(name, "wheel.cycles") > Some(0.25));
    let shorter = long.map(|name| format!("participant.{name}.config.wheel.cycles=0.25"));
    shorter.collect()
}
