//! From the checked keys to everything that does not change during a run.

use protocol::{ConfigError, Setting};

use crate::config::{Analysis, Config, ElementKind, Start, StepChoice, WheelConfig, positive};
use crate::element::{Body, Supports};
use crate::integrate::Scheme;
use crate::material::Elastic;
use crate::mesh::{Edge, Mesh};
use crate::spectrum;
use crate::wheel::Wheel;

/// Share of the stability limit that `step_s = "auto"` takes by default.
const SAFETY: f64 = 0.9;

/// A size that jumps by more than this from one element to the next reflects waves noticeably.
const RATIO_MAX: f64 = 1.5;

/// Mesh, discretised body, scheme and loads.
#[derive(Clone, Debug)]
pub struct Model {
    /// The mesh.
    pub mesh: Mesh,
    /// The law of the material.
    pub elastic: Elastic,
    /// Which element.
    pub element: ElementKind,
    /// Thickness (m).
    pub thickness: f64,
    /// The discretised body.
    pub body: Body,
    /// Step and damping.
    pub scheme: Scheme,
    /// Largest natural frequency (1/s).
    pub omega_max: f64,
    /// Longest stable step (s).
    pub step_limit: f64,
    /// End of the run (s), where the scenario gives one.
    pub end: Option<f64>,
    /// Tractions on the edges.
    pub tractions: Vec<Traction>,
    /// The body's own wheel.
    pub wheel: Option<Wheel>,
    /// What the user should know before a long run.
    pub warnings: Vec<String>,
}

/// A traction turned into forces on the nodes of its edge.
#[derive(Clone, Debug)]
pub struct Traction {
    /// Component and force at full load (N).
    pub forces: Vec<(usize, f64)>,
    ramp: f64,
}

impl Traction {
    /// Share of the full load at time t (s).
    pub fn share(&self, t: f64) -> f64 {
        match self.ramp > 0.0 {
            true => (t / self.ramp).clamp(0.0, 1.0),
            false => 1.0,
        }
    }

    /// Duration of the ramp (s).
    pub fn ramp(&self) -> f64 {
        self.ramp
    }
}

impl Model {
    /// Builds the body and judges the step.
    pub fn new(config: &Config, setting: &Setting) -> Result<Model, ConfigError> {
        config.check()?;
        positive("thickness_m", setting.thickness_m, "m")?;
        let mesh = Mesh::graded(&config.mesh)?;
        let elastic = Elastic::new(&config.material, config.plane);
        let supports = Supports {
            base: config.base,
            sides: config.sides,
        };
        let thickness = setting.thickness_m;
        let body = Body::new(&mesh, config.element, &elastic, supports, thickness);
        let omega_max = spectrum::omega_max(&body);
        let step_limit = spectrum::step_limit(omega_max, config.time.damping);
        let step = choose_step(config, step_limit)?;
        let scheme = Scheme {
            step,
            damping: config.time.damping,
            mass_damping: config.time.mass_damping_per_s.unwrap_or(0.0),
        };
        let tractions = tractions(config, &mesh, &body, thickness);
        let start_damping = config.time.start_mass_damping_per_s.unwrap_or(0.0);
        let history = config.wheel.map(|wheel| history(config.start, wheel));
        let parts = history.as_ref().zip(config.contact.as_ref());
        let wheel =
            parts.map(|parts| Wheel::new(parts, (&mesh, &body), (step, thickness), start_damping));
        let end = wheel.as_ref().map(|wheel| wheel.program.end());
        let warnings = warnings(config, &mesh, &scheme, step_limit);
        Ok(Model {
            mesh,
            elastic,
            element: config.element,
            thickness,
            body,
            scheme,
            omega_max,
            step_limit,
            end: end.or(config.time.end_s),
            tractions,
            wheel,
            warnings,
        })
    }

    /// Mass damping at the end of a step (1/s), that of the start phase included.
    pub(crate) fn damping_at(&self, step: u64) -> f64 {
        let start = self.wheel.as_ref().map(|wheel| wheel.damping_at(step));
        self.scheme.mass_damping + start.unwrap_or(0.0)
    }

    /// The larger of width and height (m).
    pub fn size(&self) -> f64 {
        let [[left, top], [right, bottom]] = [
            self.mesh.point(0, 0),
            self.mesh.point(self.mesh.columns(), self.mesh.rows()),
        ];
        (right - left).max(top - bottom)
    }
}

/// A static start takes the place of the ramp.
fn history(start: Start, wheel: WheelConfig) -> WheelConfig {
    match start {
        Start::Ramp => wheel,
        Start::Static => WheelConfig {
            ramp_s: 0.0,
            ..wheel
        },
    }
}

fn choose_step(config: &Config, limit: f64) -> Result<f64, ConfigError> {
    let time = &config.time;
    match time.step_s {
        // A static analysis takes no steps in time.
        _ if config.analysis == Analysis::Static => Ok(SAFETY * limit),
        StepChoice::Auto => Ok(time.safety.unwrap_or(SAFETY) * limit),
        StepChoice::Seconds(step) if step < limit || time.unsafe_step => Ok(step),
        StepChoice::Seconds(step) => {
            let problem = format!(
                "{step:.4e} s is not below the stability limit sqrt(2/damping)/omega_max = {limit:.4e} s of this mesh"
            );
            Err(ConfigError::new("time.step_s", problem).help(format!(
                "take {:.2e} or \"auto\"; `unsafe_step = true` runs it all the same, to show how it diverges",
                SAFETY * limit
            )))
        }
    }
}

/// Consistent with linear shape functions: each node carries half of the edges beside it.
fn tractions(config: &Config, mesh: &Mesh, body: &Body, thickness: f64) -> Vec<Traction> {
    let of_edge = |(name, traction): (&'static str, &crate::config::TractionConfig)| {
        let nodes = mesh.edge(Edge::named(name).expect("the keys are names of edges"));
        let lengths = mesh.tributary(&nodes);
        let forces = nodes.iter().zip(lengths).flat_map(|(node, length)| {
            [0, 1].map(|k| {
                let force = traction.traction_pa[k] * length * thickness;
                (body.layout().index(*node, k), force)
            })
        });
        Traction {
            forces: forces.filter(|(_, force)| *force != 0.0).collect(),
            ramp: traction.ramp_s.unwrap_or(0.0),
        }
    };
    config.boundary.edges().map(of_edge).collect()
}

fn warnings(config: &Config, mesh: &Mesh, scheme: &Scheme, limit: f64) -> Vec<String> {
    let mut warnings = Vec::new();
    if scheme.step >= limit {
        warnings.push(format!(
            "time.step_s: {:.4e} s is above the stability limit {limit:.4e} s, the run will diverge; `unsafe_step` accepts it",
            scheme.step
        ));
    }
    if config.time.safety.is_some() && config.time.step_s != StepChoice::Auto {
        warnings.push("time.safety: has no effect beside a step in seconds".into());
    }
    for (key, ratio) in [
        ("mesh.side_columns", mesh.ratio_columns),
        ("mesh.depth_rows", mesh.ratio_rows),
    ] {
        if ratio > RATIO_MAX {
            warnings.push(format!(
                "{key}: sizes grow {ratio:.2}-fold from one element to the next and will reflect waves; take more of them"
            ));
        }
    }
    warnings
}
