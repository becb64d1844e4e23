//! The keys of `[participant.config]` and their limits.

mod limits;
mod periodic;
mod sample;

use serde::{Deserialize, Deserializer};

use crate::geometry::Period;

pub use sample::{ClusterConfig, MotionConfig, WallConfig};

/// Everything that a scenario says about the third body. SI units, the unit in each key.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Config {
    /// What happens at a contact; the same for every contact, wheel, walls and glued disks included.
    pub law: LawConfig,
    /// How the contact problem of a step is solved.
    pub solver: SolverConfig,
    /// Step and scheme.
    pub time: TimeConfig,
    /// Density of the grains (kg/m3).
    pub density_kg_per_m3: f64,
    /// Factor on the inertia of the grains; loads, weights and the wheel's mass are never scaled.
    #[serde(default = "one")]
    pub mass_scale: f64,
    /// Acceleration of gravity (m/s2). The weight is that of the real mass.
    #[serde(default)]
    pub gravity_m_per_s2: [f64; 2],
    /// Where the grains come from.
    pub sample: SampleConfig,
    /// The rigid wheel above the grains.
    #[serde(default)]
    pub wheel: Option<WheelConfig>,
    /// Opens or closes the only contact of a pair of disks.
    #[serde(default)]
    pub drive: Option<DriveConfig>,
}

fn one() -> f64 {
    1.0
}

/// `law`: unilateral contact with optional friction and compliance.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LawConfig {
    /// Signorini, Coulomb or cohesion, or LMGC90's name of one with the options that it means.
    pub kind: LawKind,
    /// Coefficient of friction, at least 0; with `coulomb` and `cohesion`.
    pub friction: Option<f64>,
    /// Stiffness of each contact per thickness (Pa): kn = value x thickness. Rigid contacts when absent.
    pub contact_stiffness_pa: Option<f64>,
    /// kt / kn of compliant contacts with friction, above 0.
    pub tangential_stiffness_ratio: Option<f64>,
    /// Newton's coefficient of restitution of rigid contacts, 0 to 1; inelastic when absent.
    pub restitution: Option<f64>,
    /// What happens to overlaps of rigid contacts; `gap` when absent, `iqs` with restitution.
    pub penetration: Option<PenetrationKind>,
    /// Cn (Pa/m), normal stiffness of a bond over its area r1 r2/(r1 + r2) x thickness; this and all below with `cohesion`.
    pub cn_pa_per_m: Option<f64>,
    /// Ct (Pa/m), tangential stiffness, at least 0.
    pub ct_pa_per_m: Option<f64>,
    /// w (J/m2), decohesion energy.
    pub w_j_per_m2: Option<f64>,
    /// b (Pa m s^p), viscosity of decohesion, at least 0.
    pub b_pa_m_s: Option<f64>,
    /// p, power of the rate.
    pub p: Option<f64>,
    /// h'.
    pub h_prime: Option<HPrimeConfig>,
    /// Pairs of grains with a smaller gap are bonded at the start (m).
    pub alert_m: Option<f64>,
    /// Grains with fewer bonds, 0 to 6, are bonded to their nearest neighbours as well. With 2 no grain can turn about a
    /// single bond.
    #[serde(default)]
    pub bonds_min: u32,
}

/// The words for `law.h_prime`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum HPrimeConfig {
    /// h' = 1: adhesion falls gradually, separation takes w.
    One,
    /// h' = a: brittle, separation takes w/2.
    Adhesion,
}

/// The words for `law.kind`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum LawKind {
    /// Unilateral contact without friction.
    Signorini,
    /// Unilateral contact with Coulomb friction.
    Coulomb,
    /// Bonds of Raous, Cangémi and Cocou between grains, Coulomb friction elsewhere.
    Cohesion,
    /// `coulomb` with `penetration = "iqs"`.
    #[serde(rename = "IQS_CLB")]
    IqsClb,
    /// `coulomb` with `restitution`, which it needs.
    #[serde(rename = "RST_CLB")]
    RstClb,
    /// `cohesion` with `penetration = "iqs"`.
    #[serde(rename = "IQS_MAC_CZM")]
    IqsMacCzm,
}

impl LawKind {
    /// The kind without LMGC90's name.
    pub fn plain(self) -> LawKind {
        match self {
            LawKind::IqsClb | LawKind::RstClb => LawKind::Coulomb,
            LawKind::IqsMacCzm => LawKind::Cohesion,
            plain => plain,
        }
    }

    /// The word in the scenario.
    pub fn word(self) -> &'static str {
        match self {
            LawKind::Signorini => "signorini",
            LawKind::Coulomb => "coulomb",
            LawKind::Cohesion => "cohesion",
            LawKind::IqsClb => "IQS_CLB",
            LawKind::RstClb => "RST_CLB",
            LawKind::IqsMacCzm => "IQS_MAC_CZM",
        }
    }
}

/// The words for `law.penetration`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum PenetrationKind {
    /// Overlaps stay.
    Iqs,
    /// Overlaps are repaired by the velocities, which keep what that takes.
    Gap,
    /// Overlaps are repaired by a second impulse that moves bodies and leaves no velocity.
    Split,
    /// Positions are projected until no pair overlaps.
    Projection,
}

/// `solver`: how the contact problem is solved.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SolverConfig {
    /// The algorithm.
    pub kind: SolverKind,
    /// Bound on the true natural-map residual, relative.
    pub tolerance: f64,
    /// Iterations after which a window counts as not converged.
    pub max_iterations: usize,
    /// Iterations that are always done.
    pub min_iterations: usize,
}

/// The words for `solver.kind`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SolverKind {
    /// Block non-linear Gauss-Seidel.
    Nsgs,
    /// Projected conjugate gradient: fewer iterations where there is no friction and many grains.
    Pcg,
}

/// `time`: step and scheme.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TimeConfig {
    /// Step of a run alone (s); a coupled node steps by windows.
    pub step_s: Option<f64>,
    /// Weight of the end velocity, 0.5 to 1. A coupled node needs 1.
    #[serde(default = "one")]
    pub theta: f64,
    /// Mean stress that the scene expects (Pa); it sets the bound t_i = d sqrt(rho/P) on the step.
    pub pressure_pa: f64,
    /// Accepts a step above t_i.
    #[serde(default)]
    pub unsafe_step: bool,
    /// End of a run alone without wheel (s).
    pub end_s: Option<f64>,
}

/// `sample`: where the grains come from.
#[derive(Clone, Debug)]
pub enum SampleConfig {
    /// A pressed layer that follows the crown, glued to its base.
    Layer(LayerConfig),
    /// Disks and walls one by one.
    Disks(DisksConfig),
}

/// The words for `sample.kind`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
enum SampleKind {
    Layer,
    Disks,
}

#[derive(Deserialize)]
struct SampleTag {
    kind: SampleKind,
}

/// A pressed layer of constant thickness on a crowned line.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LayerConfig {
    /// Distance from the base line to the wheel's face (m).
    pub thickness_m: f64,
    /// The layer covers |x| up to this (m).
    pub half_width_m: f64,
    /// Radius of the crown of the base line (m); 0 = straight.
    pub crown_radius_m: f64,
    /// Smallest radius of the grains (m).
    pub radius_min_m: f64,
    /// Largest radius of the grains (m).
    pub radius_max_m: f64,
    /// Distribution of the radii.
    pub law: RadiusLaw,
    /// Seed of the packing; the run's seed when absent.
    pub seed: Option<u64>,
    /// Whether the layer is cut from above too and glued to a body on top, set `lid`; it then has no wheel and no crown.
    #[serde(default)]
    pub lid: bool,
    /// What the bed has below the cut, and with a lid above the upper one (m). Five mean diameters keep the floor's ordering out of the layer.
    #[serde(default = "bed_extra")]
    pub bed_extra_m: f64,
    /// Pressures under the flat plate, one after the other (Pa). The second, lower one leaves little
    /// elastic overlap to relax when the side walls go.
    #[serde(default = "press")]
    pub press_pa: Vec<f64>,
    /// Ends of the strip that repeats along x (m), [-half_width_m, half_width_m], instead of side walls; the base is
    /// straight then.
    pub periodic_x_m: Option<[f64; 2]>,
}

/// By hand: an error of a derived enum with `tag = "kind"` names the table, not the key in it.
impl<'de> Deserialize<'de> for SampleConfig {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<SampleConfig, D::Error> {
        let mut keys = serde_json::Map::deserialize(deserializer)?;
        // A kind that is missing or no word of the list is refused like any other key.
        let kind = keys.shift_remove_entry("kind");
        let SampleTag { kind } = protocol::read_part(kind.into_iter().collect())?;
        match kind {
            SampleKind::Layer => protocol::read_part(keys.into()).map(SampleConfig::Layer),
            SampleKind::Disks => protocol::read_part(keys.into()).map(SampleConfig::Disks),
        }
    }
}

impl SampleConfig {
    /// The strip that repeats along x, where one does.
    pub fn period(&self) -> Option<Period> {
        let ends = match self {
            SampleConfig::Layer(layer) => layer.periodic_x_m,
            SampleConfig::Disks(disks) => disks.periodic_x_m,
        };
        ends.map(Period::between)
    }

    /// Where a layer that does not repeat ends on both sides (m).
    pub fn ends(&self) -> Option<f64> {
        match self {
            SampleConfig::Layer(layer) => match layer.periodic_x_m {
                None => Some(layer.half_width_m),
                Some(_) => None,
            },
            SampleConfig::Disks(_) => None,
        }
    }
}

fn bed_extra() -> f64 {
    0.7e-3
}

fn press() -> Vec<f64> {
    vec![300e6, 50e6]
}

/// Distribution of radii between two limits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum RadiusLaw {
    /// Equal surface in each class of radius, p ~ r^-2: LMGC90's `granulo_Uniform`, the paper's law.
    SurfaceUniform,
    /// Equal number in each class of radius.
    NumberUniform,
    /// Equal number in each class of the radius' logarithm.
    LogUniform,
}

/// Disks and walls one by one.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DisksConfig {
    /// The disks; glued ones form the sets `base` and `lid`.
    pub disks: Vec<DiskConfig>,
    /// Rigid walls.
    #[serde(default)]
    pub walls: Vec<WallConfig>,
    /// What is special about rigid clusters; one that is not listed is free and as heavy as its disks.
    #[serde(default)]
    pub clusters: Vec<ClusterConfig>,
    /// Ends of the strip that repeats along x (m): disks near one end touch those near the other.
    pub periodic_x_m: Option<[f64; 2]>,
}

/// One disk.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DiskConfig {
    /// Centre (m).
    pub x_m: f64,
    /// Centre (m).
    pub y_m: f64,
    /// Radius (m).
    pub radius_m: f64,
    /// Velocity at the start (m/s).
    #[serde(default)]
    pub vx_m_per_s: f64,
    /// Velocity at the start (m/s).
    #[serde(default)]
    pub vy_m_per_s: f64,
    /// Spin at the start (rad/s), anticlockwise positive.
    #[serde(default)]
    pub spin_rad_per_s: f64,
    /// Whether it belongs to a glued row: massless, without spin.
    #[serde(default)]
    pub glued: bool,
    /// Name of the rigid cluster that it belongs to: disks of the same name move as one body.
    pub cluster: Option<String>,
    /// Whether the row is the one on top, set `lid`, instead of `base`; for glued disks.
    #[serde(default)]
    pub lid: bool,
}

/// A rigid wheel that is pressed on the grains and moved sideways. It does not turn.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WheelConfig {
    /// Vertical load (N).
    pub load_n: f64,
    /// Mass (kg), never scaled.
    pub mass_kg: f64,
    /// Radius of the face (m), its lowest point over x = 0 at the start; 0 = flat.
    #[serde(default)]
    pub radius_m: f64,
    /// Vertical velocity at the start, where it touches the grains (m/s): negative for a wheel that is dropped on them.
    #[serde(default)]
    pub vy_m_per_s: f64,
    /// Amplitude A of the sideways motion D(t) = A sin(2 pi f (t - t_s)) (m).
    #[serde(default)]
    pub amplitude_m: f64,
    /// Frequency f of the sideways motion (1/s).
    #[serde(default)]
    pub frequency_hz: f64,
    /// Time in which the load grows linearly from 0 (s).
    pub ramp_s: f64,
    /// Time under the full load before the motion starts at t_s = ramp + hold (s).
    pub hold_s: f64,
    /// Periods of the sideways motion, not necessarily whole.
    #[serde(default)]
    pub cycles: f64,
}

/// Prescribed motion of the only grain along the line from the only glued disk, over 30 openings sqrt(w/Cn) in
/// 100 000 steps; the step follows.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DriveConfig {
    /// Opening velocity (m/s); a negative one closes the contact.
    pub velocity_m_per_s: f64,
}
