//! The real coupler on the bar and the masses, over channels.

use std::thread;

use protocol::link::channel;
use protocol::{
    BoundaryInertia, Node, NodeError, PROTOCOL_VERSION, Session, Setting, Transport, serve,
};

use super::nodes::{Bar, BarNode, BodyNode};
use crate::couple::conversation::Conversation;
use crate::couple::handshake;
use crate::couple::join::join;
use crate::couple::scheme::{Attempt, Coupling};
use crate::error::Error;
use crate::launch::{Life, Peer, Watch};
use crate::scenario::load::Loaded;
use crate::scenario::load::parse;
use crate::scenario::source::Source;
use crate::scenario::{Dirichlet, Scheme};

/// One set-up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trial {
    /// The continuum.
    pub bar: Bar,
    /// Steps in a window.
    pub substeps: u32,
    /// The scheme; a fixed point has the constant relaxation [`Trial::RELAXATION`].
    pub way: Way,
    /// The masses on the wall.
    pub boundary_inertia: BoundaryInertia,
}

/// A scheme with its roles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Way {
    /// The scheme.
    pub scheme: Scheme,
    /// Which side takes the motion.
    pub dirichlet: Dirichlet,
}

impl Way {
    /// A scheme in which the continuum follows.
    pub fn swapped(scheme: Scheme) -> Way {
        Way {
            scheme,
            dirichlet: Dirichlet::Continuum,
        }
    }
}

/// A scheme in which the wall follows, if any side does.
impl From<Scheme> for Way {
    fn from(scheme: Scheme) -> Way {
        Way {
            scheme,
            dirichlet: Dirichlet::Wall,
        }
    }
}

/// What a trial came to.
#[derive(Debug)]
pub struct Run {
    /// Interface force (N) in each window that stands.
    pub forces: Vec<f64>,
    /// Why it ended early, if it did.
    pub error: Option<Error>,
}

impl Trial {
    /// Constant relaxation of the fixed-point schemes.
    pub const RELAXATION: f64 = 0.5;
    /// Mass of the point itself over the mass behind it, which it tells where it is pushed by forces.
    pub const POINT: f64 = 0.01;

    /// Mass of the point (kg), where it has any.
    pub fn point_mass_kg(&self) -> f64 {
        match self.way.dirichlet {
            Dirichlet::Wall => 0.0,
            Dirichlet::Continuum => Trial::POINT * self.boundary_inertia.mass_kg,
        }
    }

    /// The masses on the wall with that of the point.
    pub fn whole(&self) -> BoundaryInertia {
        BoundaryInertia {
            glued_mass_kg: self.boundary_inertia.glued_mass_kg + self.point_mass_kg(),
            ..self.boundary_inertia
        }
    }

    /// Runs windows of the real coupler from masses that start with 1 m/s, to a gap (m).
    pub fn run(&self, windows: u64, gap_m: f64) -> Result<Run, Error> {
        let loaded = self.loaded(gap_m)?;
        let bar = self.bar;
        let (boundary_inertia, point_mass_kg) = (self.boundary_inertia, self.point_mass_kg());
        let peers = vec![
            participant("bar", &loaded.hash, move || Box::new(BarNode::new(bar)))?,
            participant("body", &loaded.hash, move || {
                Box::new(BodyNode::new(boundary_inertia, point_mass_kg))
            })?,
        ];
        let deadlines = &loaded.scenario.run.deadlines;
        let labels = loaded.scenario.labels();
        let mut conversation =
            Conversation::new(peers, RUN_ID, labels, deadlines, Watch::default(), None);
        let greeted = handshake::greet(&mut conversation, &loaded, RUN_ID)?;
        let mut groups = join(&mut conversation, &loaded.scenario, &greeted)?;
        let group = groups.remove(0);
        let clock = group.clock;
        let mut coupling = Coupling::new(&loaded.scenario.interface[0], group);
        let mut run = Run {
            forces: Vec::new(),
            error: None,
        };
        for index in 0..windows {
            let step = index * u64::from(self.substeps);
            let window = clock.window(index, step, self.substeps);
            match coupling.window(&mut conversation, window, |_| None) {
                Ok(Attempt::Standing(_)) => run.forces.push(coupling.lambda[0]),
                Ok(Attempt::Halve) => unreachable!("the scenario stops where it does not converge"),
                Err(error) => {
                    run.error = Some(error);
                    break;
                }
            }
        }
        Ok(run)
    }

    fn loaded(&self, gap_m: f64) -> Result<Loaded, Error> {
        let (scheme, dirichlet) = (word(self.way.scheme), word(self.way.dirichlet));
        let (substeps, relaxation) = (self.substeps, Trial::RELAXATION);
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
repeats_max = 4000
acceleration = "constant"
relaxation = {relaxation}
unsafe_window = true
"#
        );
        parse(Source {
            name: "bench stability".into(),
            text,
            overrides: Vec::new(),
        })
    }
}

/// The word of a choice in a scenario.
pub fn word(choice: impl serde::Serialize) -> String {
    let word = serde_json::to_value(choice).expect("choices are words");
    word.as_str().expect("choices are words").to_string()
}

const RUN_ID: u64 = 1;

fn participant<F>(name: &str, scenario_hash: &str, node: F) -> Result<Peer, Error>
where
    F: FnOnce() -> Box<dyn Node> + Send + 'static,
{
    let session = Session {
        protocol: PROTOCOL_VERSION,
        run_id: RUN_ID,
        scenario_hash: scenario_hash.to_string(),
        coordinator_pid: std::process::id(),
        setting: Setting {
            participant: name.into(),
            seed: 0,
            thickness_m: 1.0,
            threads: 1,
            fields: None,
        },
        transport: Transport::Channel,
        idle_deadline_s: 60.0,
        config: serde_json::Value::Null,
    };
    let (ours, mut theirs) = channel::pair();
    let build = move |_: &Session| -> Result<Box<dyn Node>, NodeError> { Ok(node()) };
    let thread = thread::Builder::new()
        .name(name.to_string())
        .spawn(move || serve(&session, &mut theirs, build).map_err(|error| error.to_string()))
        .map_err(Error::input(format!("starting participant `{name}`")))?;
    Ok(Peer::new(name, Box::new(ours), Life::Thread(thread)))
}
