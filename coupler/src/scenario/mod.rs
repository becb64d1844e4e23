//! The scenario: who takes part, who talks to whom, and how.

use serde::{Deserialize, Serialize};

mod check;
pub mod load;
mod overrides;
mod paths;
pub mod source;

/// A whole scenario, as resolved from the file and `--set`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scenario {
    /// What is common to all participants.
    pub run: Run,
    /// The solvers.
    pub participant: Vec<Participant>,
    /// Where they are joined; without any, the one participant runs alone.
    #[serde(default)]
    pub interface: Vec<Interface>,
}

impl Scenario {
    /// Interfaces that are connected through a participant, by their index; they are solved together.
    pub fn groups(&self) -> Vec<Vec<usize>> {
        let mut groups: Vec<Vec<usize>> = Vec::new();
        for (index, interface) in self.interface.iter().enumerate() {
            let touches = |group: &Vec<usize>| {
                let mut members = group.iter().map(|member| &self.interface[*member]);
                members.any(|member| member.shared_with(interface).is_some())
            };
            let (connected, apart): (Vec<_>, Vec<_>) = groups.into_iter().partition(touches);
            let mut joined: Vec<usize> = connected.concat();
            joined.push(index);
            joined.sort_unstable();
            groups = apart;
            groups.push(joined);
            groups.sort();
        }
        groups
    }

    /// What the exchange with each participant is recorded under.
    pub fn labels(&self) -> Vec<Label> {
        let participants = self.participant.iter();
        participants.map(|p| self.label(&p.name)).collect()
    }

    /// What the exchange with one participant is recorded under.
    pub fn label(&self, participant: &str) -> Label {
        let mut own = self.interface.iter().enumerate().filter(|(_, interface)| {
            let [a, b] = interface.participants();
            a == participant || b == participant
        });
        let Some((index, first)) = own.next() else {
            return Label {
                interface: 0,
                name: "alone".into(),
            };
        };
        let mut name = first.name.clone();
        for (_, interface) in own {
            name = format!("{name}+{}", interface.name);
        }
        Label {
            interface: index as u32,
            name,
        }
    }
}

/// What the exchange with a participant is recorded under. A participant on several interfaces exchanges all of them in
/// one frame: the frame carries the index of the first, and the names of all.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Label {
    /// Index of the participant's first interface.
    pub interface: u32,
    /// Names of its interfaces, joined by `+`; `alone` for a participant without any.
    pub name: String,
}

/// What is common to all participants.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Run {
    /// Name of the run, a plain file name.
    pub name: String,
    /// Seed of everything random.
    #[serde(default)]
    pub seed: u64,
    /// Out-of-plane thickness (m), positive.
    pub thickness_m: f64,
    /// How frames travel.
    #[serde(default)]
    pub transport: TransportKind,
    /// End of the run (s); by default the longest load history of a participant.
    pub end_s: Option<f64>,
    /// What is written, and how often.
    #[serde(default)]
    pub output: Output,
    /// Windows between two checkpoints, 0 for none; by default 1000 where all participants can be resumed.
    pub checkpoint_every_windows: Option<u64>,
    /// Checkpoints that are kept, at least 1; the oldest goes.
    #[serde(default = "default_checkpoints")]
    pub checkpoints_kept: u64,
    /// How long to wait for whom.
    #[serde(default)]
    pub deadlines: Deadlines,
}

/// One more than the latest: a disk may lose that.
fn default_checkpoints() -> u64 {
    2
}

/// How frames travel between the coordinator and its participants.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum TransportKind {
    /// One process a participant, iceoryx2 shared memory.
    #[default]
    Shm,
    /// One thread a participant, inside the coordinator's process.
    Channel,
}

/// What is written, and how often.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Output {
    /// Windows between two rows of `signals.csv`.
    pub signals_every_windows: u64,
    /// Windows between two flushes of `exchange.mcap`: a killed writer loses at most so many.
    pub flush_every_windows: u64,
    /// Whether `exchange.mcap` is written.
    pub exchange: bool,
    /// Own steps in a report of a solver that runs alone.
    pub alone_steps: u32,
}

impl Default for Output {
    fn default() -> Output {
        Output {
            signals_every_windows: 1,
            flush_every_windows: 100,
            exchange: true,
            alone_steps: 100,
        }
    }
}

/// How long to wait for whom (s). Waits are far longer than any answer that we have measured, so that only
/// a participant that has really stopped runs into them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Deadlines {
    /// From launch to the participant's greeting, sample preparation included.
    pub setup_s: f64,
    /// For one answer during the run.
    pub answer_s: f64,
    /// How long a participant waits for its next request before it ends itself.
    pub idle_s: f64,
}

impl Default for Deadlines {
    fn default() -> Deadlines {
        Deadlines {
            setup_s: 300.0,
            answer_s: 60.0,
            idle_s: 600.0,
        }
    }
}

/// One solver of the scenario.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Participant {
    /// Its name, a plain file name; messages and logs use it.
    pub name: String,
    /// `fem`, `dem`, or the kind of a foreign program.
    pub kind: String,
    /// Program and arguments of a foreign participant; by default `thirdbody node <kind>`.
    pub command: Option<Vec<String>>,
    /// The solver's own keys.
    #[serde(default)]
    pub config: toml::Table,
}

/// Two named sets that are joined.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Interface {
    /// Its name.
    pub name: String,
    /// The two sets, `participant.set`: one of a continuum that takes forces, one of a solver on a wall.
    pub between: [String; 2],
    /// How the two sides are joined.
    pub scheme: Scheme,
    /// Which side takes motion and answers force (the other takes force and answers motion), in a scheme that sends one each
    /// way.
    #[serde(default)]
    pub dirichlet: Dirichlet,
    /// Explicit steps in a window, at least 1.
    pub substeps: u32,
    /// How nodes and glued disks are related.
    #[serde(default)]
    pub mapping: MappingKind,
    /// Largest gap that counts as closed, over the mean spacing of the surface nodes.
    pub tolerance_rel: f64,
    /// Repeats of a window before it counts as not converged, at least 1.
    #[serde(default = "default_repeats")]
    pub repeats_max: u32,
    /// Where the compliance of a dual Schur scheme comes from.
    #[serde(default)]
    pub compliance: CompliancePrior,
    /// How a fixed-point scheme is accelerated.
    #[serde(default)]
    pub acceleration: Acceleration,
    /// First, or constant, relaxation of a fixed-point scheme, above 0 and at most 1.
    #[serde(default = "default_relaxation")]
    pub relaxation: f64,
    /// Largest part of the energy through the interface that may be lost or made there, summed up to and with each window;
    /// not judged when absent.
    pub energy_defect_max_rel: Option<f64>,
    /// What a window leads to that did not converge, whose contact solve was starved, or whose energy defect is above
    /// its bound. A window with a number that is not finite may be halved, but never accepted.
    #[serde(default)]
    pub on_not_converged: Policy,
    /// Runs windows that are predicted to be unstable, to show how they fail.
    #[serde(default)]
    pub unsafe_window: bool,
}

impl Interface {
    /// The participants whose sets it joins.
    pub fn participants(&self) -> [&str; 2] {
        [0, 1].map(|side| {
            let whole = self.between[side].as_str();
            whole.split_once('.').map_or(whole, |(name, _)| name)
        })
    }

    /// What precedes the names of its results and signals: nothing for the only interface of a run.
    pub fn prefix_among(&self, interfaces: usize) -> String {
        if interfaces == 1 {
            return String::new();
        }
        format!("{}.", self.name)
    }

    /// A participant that another interface joins too.
    pub fn shared_with<'a>(&'a self, other: &Interface) -> Option<&'a str> {
        let theirs = other.participants();
        self.participants()
            .into_iter()
            .find(|name| theirs.contains(name))
    }
}

fn default_repeats() -> u32 {
    8
}

/// Half of the answer is where a first relaxed step neither overshoots much nor hardly moves.
fn default_relaxation() -> f64 {
    0.5
}

/// How the two sides of an interface are joined.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Scheme {
    /// One constant force a window, equal displacements at its end, exact compliance (the default choice).
    DualSchur,
    /// The same with a compliance that is updated by what the continuum does: for one that is not linear.
    DualSchurSecant,
    /// The same with one solve a window, whatever gap it leaves, on a compliance that errs to the soft side.
    DualSchurCheap,
    /// Motion to the wall, force back, one window late: naive, shown to fail.
    StaggeredSerial,
    /// Both at once, each with what the other did one window before: naive, shown to fail.
    StaggeredParallel,
    /// Motion to the wall, force back, repeated until both agree: needs nothing but repeatable windows.
    FixedPointSerial,
    /// The same with both sides at once, each with the other's last answer.
    FixedPointParallel,
    /// One straight line of velocities a window, equal velocities at its end: dissipative, for slow and quasi-static
    /// motion of a linear continuum.
    Velocity,
}

impl Scheme {
    /// Whether it sends motion one way and force the other.
    pub fn has_roles(self) -> bool {
        match self {
            Scheme::StaggeredSerial
            | Scheme::StaggeredParallel
            | Scheme::FixedPointSerial
            | Scheme::FixedPointParallel => true,
            Scheme::DualSchur
            | Scheme::DualSchurSecant
            | Scheme::DualSchurCheap
            | Scheme::Velocity => false,
        }
    }
}

/// The side that takes motion and answers force.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Dirichlet {
    /// The solver on the wall follows the continuum.
    #[default]
    Wall,
    /// The continuum follows the wall, whose points move by the forces on them and by masses of their own: for a wall that is
    /// heavy beside what the continuum moves in a window.
    Continuum,
}

/// Where the compliance of a dual Schur scheme comes from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum CompliancePrior {
    /// The continuum's own columns: exact for a linear one.
    #[default]
    Columns,
    /// Surface masses alone: for a continuum that gives no columns. Slow contact solves; use with `dual-schur-secant`.
    Mass,
}

/// What a fixed-point iteration makes of its last answers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Acceleration {
    /// A constant share of the new answer.
    Constant,
    /// A share that follows the last two residuals.
    Aitken,
    /// Interface quasi-Newton by least squares over the window's answers.
    #[default]
    IqnIls,
}

/// How nodes and glued disks are related. Motion goes by N and force by its transpose in each.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum MappingKind {
    /// Mean of the node shape functions over each disk's segment, with affine correction.
    #[default]
    Mortar,
    /// Interpolation between the two nodes beside each disk.
    Linear,
    /// The nearest node.
    Nearest,
}

/// What a window that did not converge leads to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Policy {
    /// The run ends with exit code 3.
    #[default]
    Stop,
    /// The window stands and is counted.
    Accept,
    /// The window is done again as two of half its length; the run ends when there is nothing left to halve.
    Halve,
}
