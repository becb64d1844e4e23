//! An interface of a scenario: two named sets, the scheme that joins them, and the keys that only the scheme needs.

use std::fmt;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Two named sets, joined by a coupling scheme.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(extend("anyOf" = [{ "required": ["substeps"] }, { "required": ["window_s"] }]))]
pub struct Interface {
    /// Its name.
    pub name: String,
    /// The two sets as `participant.set`, in either order: one of a body that takes forces, one of a solver, such as
    /// grains, for which that body is a moving wall.
    pub between: [String; 2],
    /// Coupling scheme, by which both sides agree on force and motion in a window: `dual-schur` for a linear continuum,
    /// `dual-schur-secant` for a nonlinear one.
    pub scheme: SchemeWord,
    /// The side that takes motion and answers with force, in `fixed-point-` and `staggered-` schemes; `wall` when
    /// absent.
    pub dirichlet: Option<Dirichlet>,
    /// Explicit steps of the continuum in a window, at least 1. With `window_s` it is the number of equal parts that a
    /// window may be cut into, 1 when absent.
    #[schemars(range(min = 1))]
    pub substeps: Option<u32>,
    /// Length of a window (s), required for a continuum without a step of its own and refused for one with a step.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub window_s: Option<f64>,
    /// Mapping of motion from the surface nodes to the glued points, and of force back by its transpose.
    #[serde(default)]
    pub mapping: MappingKind,
    /// Largest gap between the two sides that counts as closed, over the mean spacing of the surface nodes.
    /// `fixed-point-` schemes refuse a value below the tolerance of the solver on the wall.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub tolerance_rel: f64,
    /// Repeats of a window before it counts as not converged; 8 when absent. `staggered-` schemes and
    /// `dual-schur-cheap` do not repeat.
    #[schemars(range(min = 1))]
    pub repeats_max: Option<u32>,
    /// Origin of the continuum's compliance in `dual-schur` schemes; `columns` when absent.
    pub compliance: Option<CompliancePrior>,
    /// Acceleration of the iteration in `fixed-point-` schemes; `iqn-ils` when absent.
    pub acceleration: Option<Acceleration>,
    /// Relaxation of `fixed-point-` schemes, above 0 and at most 1: the constant, or the factor of the first repeat;
    /// 0.5 when absent.
    #[schemars(extend("exclusiveMinimum" = 0), range(max = 1))]
    pub relaxation: Option<f64>,
    /// Largest part of the energy through the interface that may be lost or created there; a window beyond it counts as
    /// not converged. Not judged when absent.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub energy_defect_max_rel: Option<f64>,
    /// Windows from one exchange of heat and temperatures to the next; required where both sides have heat, refused
    /// where one has none. Interfaces that share a participant all exchange heat, or none does.
    #[schemars(range(min = 1))]
    pub heat_every_windows: Option<u32>,
    /// What happens to a window that did not converge.
    #[serde(default)]
    pub on_not_converged: Policy,
    /// Runs windows although they are predicted to be unstable, to show how they fail.
    #[serde(default)]
    pub unsafe_window: bool,
}

impl Interface {
    /// The keys of its scheme.
    pub fn given(&self) -> SchemeKeys {
        SchemeKeys {
            scheme: self.scheme,
            dirichlet: self.dirichlet,
            repeats_max: self.repeats_max,
            compliance: self.compliance,
            acceleration: self.acceleration,
            relaxation: self.relaxation,
        }
    }

    /// The scheme with its own data.
    pub fn scheme(&self) -> CouplingScheme {
        self.given().scheme()
    }

    /// Explicit steps in a window; with `window_s`, the number of equal parts that it may be cut into.
    pub fn substeps(&self) -> u32 {
        self.substeps.unwrap_or(1)
    }

    /// The participants whose sets it joins.
    pub fn participants(&self) -> [&str; 2] {
        [0, 1].map(|side| {
            let whole = self.between[side].as_str();
            whole.split_once('.').map_or(whole, |(name, _)| name)
        })
    }

    /// Prefix of the names of its results and signals: empty for the only interface of a run.
    pub fn prefix_among(&self, interfaces: usize) -> String {
        if interfaces == 1 {
            return String::new();
        }
        format!("{}.", self.name)
    }
}

/// Groups of interfaces that participants connect, by index; each group is solved together.
pub fn connected(interfaces: &[Interface]) -> Vec<Vec<usize>> {
    let mut groups: Vec<Vec<usize>> = Vec::new();
    for (index, interface) in interfaces.iter().enumerate() {
        let touches = |group: &Vec<usize>| {
            let mut names = group.iter().flat_map(|at| interfaces[*at].participants());
            names.any(|name| interface.participants().contains(&name))
        };
        let (touched, apart): (Vec<_>, Vec<_>) = groups.into_iter().partition(touches);
        let mut joined: Vec<usize> = touched.concat();
        joined.push(index);
        joined.sort_unstable();
        groups = apart;
        groups.push(joined);
        groups.sort();
    }
    groups
}

/// A coupling scheme with the data that it needs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum CouplingScheme {
    /// One constant force in a window, equal displacements at its end (the default choice).
    DualSchur {
        /// Treatment of the compliance from window to window.
        update: Update,
        /// Its origin.
        compliance: CompliancePrior,
        /// Repeats of a window before it counts as not converged.
        repeats_max: u32,
    },
    /// Linear velocity in a window, equal velocities at its end: dissipative, for slow and quasi-static motion of a
    /// linear continuum.
    Velocity {
        /// Repeats of a window before it counts as not converged.
        repeats_max: u32,
    },
    /// Motion one way, force the other, repeated until both agree: requires only repeatable windows.
    FixedPoint {
        /// Order in which the sides run.
        order: Order,
        /// The side that takes motion.
        dirichlet: Dirichlet,
        /// Acceleration of the iteration.
        acceleration: Acceleration,
        /// First, or constant, relaxation, above 0 and at most 1.
        relaxation: f64,
        /// Repeats of a window before it counts as not converged.
        repeats_max: u32,
    },
    /// The same once a window, with the answers of the window before: naive, kept to show how it fails.
    Staggered {
        /// Order in which the sides run.
        order: Order,
        /// The side that takes motion.
        dirichlet: Dirichlet,
    },
}

impl CouplingScheme {
    /// The side that takes motion and answers with force; in schemes without that choice, the solver on the boundary.
    pub fn dirichlet(&self) -> Dirichlet {
        match self {
            CouplingScheme::FixedPoint { dirichlet, .. }
            | CouplingScheme::Staggered { dirichlet, .. } => *dirichlet,
            CouplingScheme::DualSchur { .. } | CouplingScheme::Velocity { .. } => {
                Dirichlet::MotionDriven
            }
        }
    }
}

/// Treatment of the compliance that a dual Schur scheme uses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Update {
    /// It stays constant: exact for a linear continuum.
    None,
    /// The answers of the continuum update it: for a nonlinear continuum.
    Secant,
    /// It starts too soft, is updated, and serves one solve a window; the gap that is left is not judged.
    Cheap,
}

/// Order in which the two sides of an interface run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Order {
    /// One after the other.
    Serial,
    /// Both at once, each with the last answer of the other.
    Parallel,
}

/// The word of a scheme in a scenario.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum SchemeWord {
    /// One constant force in a window, equal displacements at its end; exact for a linear continuum.
    #[default]
    DualSchur,
    /// The same with a compliance that follows the answers of the continuum: for a nonlinear continuum, such as a
    /// plastic one.
    DualSchurSecant,
    /// One solve a window; the gap that is left is reported, not judged.
    DualSchurCheap,
    /// Each side once a window, one after the other: naive, kept to show how it fails.
    StaggeredSerial,
    /// Each side once a window, both at once: naive, kept to show how it fails.
    StaggeredParallel,
    /// Motion one way, force the other, repeated until both agree, one side after the other.
    FixedPointSerial,
    /// The same, both sides at once.
    FixedPointParallel,
    /// Equal velocities at the end of a window: dissipative, for slow motion of an elastic continuum with small
    /// strains.
    Velocity,
}

impl fmt::Display for SchemeWord {
    /// As in a scenario.
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        self.serialize(f)
    }
}

/// The keys of an interface that belong to particular schemes, as a scenario gives them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SchemeKeys {
    /// `scheme`
    pub scheme: SchemeWord,
    /// `dirichlet`
    pub dirichlet: Option<Dirichlet>,
    /// `repeats_max`
    pub repeats_max: Option<u32>,
    /// `compliance`
    pub compliance: Option<CompliancePrior>,
    /// `acceleration`
    pub acceleration: Option<Acceleration>,
    /// `relaxation`
    pub relaxation: Option<f64>,
}

impl SchemeKeys {
    /// A scheme without any further key.
    pub fn of(scheme: SchemeWord) -> SchemeKeys {
        SchemeKeys {
            scheme,
            ..SchemeKeys::default()
        }
    }

    /// The scheme with the data that it needs.
    pub fn scheme(&self) -> CouplingScheme {
        let (repeats_max, dirichlet) = (self.repeats_max(), self.dirichlet());
        let dual_schur = |update| CouplingScheme::DualSchur {
            update,
            compliance: self.compliance(),
            repeats_max,
        };
        let fixed_point = |order| CouplingScheme::FixedPoint {
            order,
            dirichlet,
            acceleration: self.acceleration(),
            relaxation: self.relaxation(),
            repeats_max,
        };
        let staggered = |order| CouplingScheme::Staggered { order, dirichlet };
        match self.scheme {
            SchemeWord::DualSchur => dual_schur(Update::None),
            SchemeWord::DualSchurSecant => dual_schur(Update::Secant),
            SchemeWord::DualSchurCheap => dual_schur(Update::Cheap),
            SchemeWord::StaggeredSerial => staggered(Order::Serial),
            SchemeWord::StaggeredParallel => staggered(Order::Parallel),
            SchemeWord::FixedPointSerial => fixed_point(Order::Serial),
            SchemeWord::FixedPointParallel => fixed_point(Order::Parallel),
            SchemeWord::Velocity => CouplingScheme::Velocity { repeats_max },
        }
    }

    /// `dirichlet`, or its default.
    pub fn dirichlet(&self) -> Dirichlet {
        self.dirichlet.unwrap_or_default()
    }

    /// `repeats_max`, or its default.
    pub fn repeats_max(&self) -> u32 {
        self.repeats_max.unwrap_or(8)
    }

    /// `compliance`, or its default.
    pub fn compliance(&self) -> CompliancePrior {
        self.compliance.unwrap_or_default()
    }

    /// `acceleration`, or its default.
    pub fn acceleration(&self) -> Acceleration {
        self.acceleration.unwrap_or_default()
    }

    /// `relaxation`, or its default: with half of the answer the first step neither overshoots much nor moves too
    /// little.
    pub fn relaxation(&self) -> f64 {
        self.relaxation.unwrap_or(0.5)
    }

    /// The given keys that the scheme does not use.
    pub fn unused(&self) -> Vec<&'static str> {
        let scheme = self.scheme();
        let fixed_point = matches!(scheme, CouplingScheme::FixedPoint { .. });
        let staggered = matches!(scheme, CouplingScheme::Staggered { .. });
        let dual_schur = matches!(scheme, CouplingScheme::DualSchur { .. });
        let (swaps, cheap) = (fixed_point || staggered, SchemeWord::DualSchurCheap);
        let repeats = !staggered && self.scheme != cheap;
        let keys = [
            ("dirichlet", self.dirichlet.is_some(), swaps),
            ("repeats_max", self.repeats_max.is_some(), repeats),
            ("compliance", self.compliance.is_some(), dual_schur),
            ("acceleration", self.acceleration.is_some(), fixed_point),
            ("relaxation", self.relaxation.is_some(), fixed_point),
        ];
        let unused = keys.into_iter().filter(|(_, given, used)| *given && !used);
        unused.map(|(key, ..)| key).collect()
    }
}

/// The side that takes motion and answers with force.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum Dirichlet {
    /// The solver on the wall follows the continuum.
    #[default]
    #[serde(rename = "wall")]
    MotionDriven,
    /// The continuum follows the wall, whose points move by the forces on them and by their own masses: for a wall that
    /// is heavy compared with the mass that the continuum moves in a window.
    #[serde(rename = "continuum")]
    ForceDriven,
}

/// Origin of the compliance of a dual Schur scheme.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum CompliancePrior {
    /// The continuum's own columns: exact for a linear one.
    #[default]
    Columns,
    /// Surface masses alone: for a continuum that offers no columns. Contact solves are slow; use it with
    /// `dual-schur-secant`.
    Mass,
}

/// Acceleration of a fixed-point iteration.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Acceleration {
    /// Constant relaxation: a fixed share of the new answer.
    Constant,
    /// Aitken relaxation: a share that follows the last two residuals.
    Aitken,
    /// Interface quasi-Newton (IQN-ILS) by least squares over the window's answers.
    #[default]
    IqnIls,
}

/// Mapping between nodes and glued points: motion by N, force by its transpose.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum MappingKind {
    /// Mean of the node shape functions over each disk's segment, with affine correction.
    #[default]
    Mortar,
    /// Interpolation between the two nodes next to each disk.
    Linear,
    /// The nearest node.
    Nearest,
}

/// What happens to a window that did not converge.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Policy {
    /// The run ends with exit code 3.
    #[default]
    Stop,
    /// The window is accepted and counted.
    Accept,
    /// The window is repeated as two windows of half its length; the run ends when a window cannot be halved further.
    Halve,
}

#[cfg(test)]
mod tests {
    use super::*;

    fn interface(keys: &str) -> Interface {
        let table = format!(
            "name = \"base\"\nbetween = [\"a.x\", \"b.y\"]\nsubsteps = 2\ntolerance_rel = 1e-5\n{keys}"
        );
        toml::from_str(&table).expect("the keys are valid")
    }

    #[test]
    fn a_scheme_takes_its_own_keys_and_lists_the_unused_ones() {
        let dual =
            interface("scheme = \"dual-schur\"\nrelaxation = 0.5\nacceleration = \"aitken\"");
        assert_eq!(
            dual.scheme(),
            CouplingScheme::DualSchur {
                update: Update::None,
                compliance: CompliancePrior::Columns,
                repeats_max: 8
            }
        );
        assert_eq!(dual.given().unused(), ["acceleration", "relaxation"]);
        let fixed =
            interface("scheme = \"fixed-point-parallel\"\nrelaxation = 0.2\ncompliance = \"mass\"");
        assert_eq!(fixed.given().unused(), ["compliance"]);
        assert!(matches!(
            fixed.scheme(),
            CouplingScheme::FixedPoint {
                order: Order::Parallel,
                relaxation: 0.2,
                ..
            }
        ));
        let cheap = interface("scheme = \"dual-schur-cheap\"\nrepeats_max = 3");
        assert_eq!(cheap.given().unused(), ["repeats_max"]);
    }
}
