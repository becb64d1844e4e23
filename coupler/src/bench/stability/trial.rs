//! The real coupler on the bar and the masses, both in memory.

use protocol::BoundaryInertia;

use super::nodes::{Bar, BarNode, BodyNode};
use crate::error::Error;
use crate::participants::in_memory::InMemory;
use crate::scenario::load::parse;
use crate::scenario::source::Source;
use crate::scenario::{Acceleration, Dirichlet, Policy, Scenario, Scheme, SchemeKeys, SchemeWord};
use crate::scheme::coupling::Coupling;
use crate::scheme::join::join;

/// One set-up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trial {
    /// The continuum.
    pub bar: Bar,
    /// Steps in a window.
    pub substeps: u32,
    /// The scheme; a fixed point has the constant relaxation [`RELAXATION`].
    pub scheme: Scheme,
    /// The masses on the wall.
    pub boundary_inertia: BoundaryInertia,
}

/// Constant relaxation of the fixed-point schemes.
pub const RELAXATION: f64 = 0.5;
/// Mass of the point itself over the mass behind it, which it tells where it is pushed by forces.
const POINT: f64 = 0.01;

/// A scheme of the bench, in which this side takes the motion.
pub fn scheme(word: SchemeWord, dirichlet: Dirichlet) -> Scheme {
    SchemeKeys {
        dirichlet: Some(dirichlet),
        acceleration: Some(Acceleration::Constant),
        relaxation: Some(RELAXATION),
        repeats_max: Some(4000),
        ..SchemeKeys::of(word)
    }
    .scheme()
}

/// Outcome of a trial.
#[derive(Debug)]
pub struct Run {
    /// Interface force (N) in each accepted window.
    pub forces: Vec<f64>,
    /// Reason of an early end.
    pub error: Option<Error>,
}

impl Trial {
    /// Mass of the point (kg), where it has any.
    pub fn point_mass_kg(&self) -> f64 {
        match self.scheme.dirichlet() {
            Dirichlet::Wall => 0.0,
            Dirichlet::Continuum => POINT * self.boundary_inertia.mass_kg,
        }
    }

    /// Runs windows of the real coupler from masses that start with 1 m/s, to a gap (m).
    pub fn run(&self, windows: u64, gap_m: f64) -> Result<Run, Error> {
        let body = BodyNode::new(self.boundary_inertia, self.point_mass_kg());
        let mut participants = InMemory::new(vec![
            ("bar".into(), Box::new(BarNode::new(self.bar))),
            ("body".into(), Box::new(body)),
        ]);
        let group = join(&mut participants, &self.scenario(gap_m)?)?.remove(0);
        let clock = group.clock;
        let mut coupling = Coupling::new("glue", self.scheme, Policy::Stop, group);
        let mut run = Run {
            forces: Vec::new(),
            error: None,
        };
        for index in 0..windows {
            let step = index * u64::from(self.substeps);
            let window = clock.window(index, step, self.substeps);
            match coupling.window(&mut participants, window, |_| None) {
                Ok(_) => run.forces.push(coupling.state.lambda[0]),
                Err(error) => {
                    run.error = Some(error);
                    break;
                }
            }
        }
        Ok(run)
    }

    fn scenario(&self, gap_m: f64) -> Result<Scenario, Error> {
        let (scheme, dirichlet) = (word(self.scheme.word()), word(self.scheme.dirichlet()));
        let substeps = self.substeps;
        let text = format!(
            r#"
run = {{ name = "stability", thickness_m = 1.0 }}
participant = [{{ name = "bar", kind = "bar" }}, {{ name = "body", kind = "body" }}]
[[interface]]
name = "glue"
between = ["bar.end", "body.end"]
scheme = "{scheme}"
dirichlet = "{dirichlet}"
substeps = {substeps}
tolerance_rel = {gap_m:e}
"#
        );
        let source = Source {
            name: "bench stability".into(),
            text,
            overrides: Vec::new(),
        };
        Ok(parse(source)?.scenario)
    }
}

/// The word of a choice in a scenario.
pub fn word(choice: impl serde::Serialize) -> String {
    let word = serde_json::to_value(choice).expect("choices are words");
    word.as_str().expect("choices are words").to_string()
}
