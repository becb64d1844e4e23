//! The keys of `sample` with kind = "disks", its walls and clusters, and their limits.

use protocol::ConfigError;
use serde::Deserialize;

use super::limits::{finite, positive, refuse};

/// Disks and walls one by one.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DisksConfig {
    /// The disks; glued ones form the sets `base` and `lid`.
    pub disks: Vec<DiskConfig>,
    /// Rigid walls.
    #[serde(default)]
    pub walls: Vec<WallConfig>,
    /// Properties of rigid clusters; one that is not listed is free and as heavy as its disks.
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
    /// True for a disk of a glued row: massless, without spin.
    #[serde(default)]
    pub glued: bool,
    /// Name of the rigid cluster that it belongs to: disks of the same name move as one body.
    pub cluster: Option<String>,
    /// True if that row is the one on top, set `lid`, instead of `base`; for glued disks.
    #[serde(default)]
    pub lid: bool,
}

/// A rigid wall: a half-plane by a point and a normal, or a polyline by its corners.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WallConfig {
    /// A point of the face of a half-plane (m).
    pub x_m: Option<f64>,
    /// A point of the face of a half-plane (m).
    pub y_m: Option<f64>,
    /// Direction of the normal of a half-plane: the grains stay on its side.
    pub nx: Option<f64>,
    /// Direction of the normal of a half-plane.
    pub ny: Option<f64>,
    /// Corners of a polyline (m), instead of the four above. The grains stay on the left of its direction; one that ends
    /// where it began is closed, the ends of any other are round.
    pub points_m: Option<Vec<[f64; 2]>>,
    /// Constant velocity (m/s).
    #[serde(default)]
    pub velocity_m_per_s: [f64; 2],
}

/// Mass, motion and locks of the disks with `cluster = name`.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ClusterConfig {
    /// The name that its disks give.
    pub name: String,
    /// Motions of the cluster that are held at 0.
    #[serde(default)]
    pub locked: Vec<MotionConfig>,
    /// Mass (kg), before `mass_scale`; the sum of the disks, overlaps counted twice, when absent.
    pub mass_kg: Option<f64>,
    /// StepSpan of inertia about the centre of mass (kg m2); that of the disks when absent.
    pub inertia_kg_m2: Option<f64>,
    /// Velocity of the centre of mass at the start (m/s).
    #[serde(default)]
    pub vx_m_per_s: f64,
    /// Velocity of the centre of mass at the start (m/s).
    #[serde(default)]
    pub vy_m_per_s: f64,
    /// Spin at the start (rad/s), anticlockwise positive.
    #[serde(default)]
    pub spin_rad_per_s: f64,
}

/// The words for `sample.clusters.locked`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum MotionConfig {
    /// Sideways.
    X,
    /// Up and down.
    Y,
    /// Turning.
    Rotation,
}

impl WallConfig {
    /// Refuses a wall that is neither, or both.
    fn validate(&self, key: &str) -> Result<(), ConfigError> {
        for component in self.velocity_m_per_s {
            finite(&format!("{key}.velocity_m_per_s"), component)?;
        }
        let plane = [
            ("x_m", self.x_m),
            ("y_m", self.y_m),
            ("nx", self.nx),
            ("ny", self.ny),
        ];
        let Some(points) = &self.points_m else {
            return validate_plane(key, plane);
        };
        if let Some((name, _)) = plane.into_iter().find(|(_, value)| value.is_some()) {
            return refuse(
                &format!("{key}.{name}"),
                "belongs to a half-plane, and points_m makes the wall a polyline",
                "remove one of them",
            );
        }
        validate_corners(&format!("{key}.points_m"), points)
    }
}

fn validate_plane(key: &str, plane: [(&str, Option<f64>); 4]) -> Result<(), ConfigError> {
    for (name, value) in plane {
        let value = value.ok_or_else(|| {
            ConfigError::new(&format!("{key}.{name}"), "is missing")
                .help("a half-plane needs x_m, y_m, nx and ny, a polyline points_m")
        })?;
        finite(&format!("{key}.{name}"), value)?;
    }
    let [_, _, nx, ny] = plane.map(|(_, value)| value.unwrap_or(0.0));
    positive(&format!("{key}.nx"), nx.hypot(ny), "length of (nx, ny)")
}

fn validate_corners(key: &str, points: &[[f64; 2]]) -> Result<(), ConfigError> {
    for component in points.iter().flatten() {
        finite(key, *component)?;
    }
    if points.len() < 2 {
        return Err(ConfigError::new(key, "needs at least two points"));
    }
    match points.windows(2).position(|ends| ends[0] == ends[1]) {
        None => Ok(()),
        Some(i) => refuse(
            key,
            format!("points {i} and {} are the same", i + 1),
            "remove one of them",
        ),
    }
}

impl ClusterConfig {
    /// True for each of x, y and rotation that is held.
    pub fn holds(&self) -> [bool; 3] {
        [MotionConfig::X, MotionConfig::Y, MotionConfig::Rotation]
            .map(|motion| self.locked.contains(&motion))
    }

    fn validate(&self, key: &str) -> Result<(), ConfigError> {
        if let Some(mass) = self.mass_kg {
            positive(&format!("{key}.mass_kg"), mass, "kg")?;
        }
        if let Some(inertia) = self.inertia_kg_m2 {
            positive(&format!("{key}.inertia_kg_m2"), inertia, "kg m2")?;
        }
        let velocity = [
            ("vx_m_per_s", self.vx_m_per_s),
            ("vy_m_per_s", self.vy_m_per_s),
            ("spin_rad_per_s", self.spin_rad_per_s),
        ];
        for ((name, value), held) in velocity.into_iter().zip(self.holds()) {
            let key = format!("{key}.{name}");
            finite(&key, value)?;
            if held && value != 0.0 {
                return refuse(
                    &key,
                    "belongs to a motion that is locked",
                    "remove it, or take the motion out of `locked`",
                );
            }
        }
        Ok(())
    }
}

impl DisksConfig {
    pub(super) fn validate(&self) -> Result<(), ConfigError> {
        if self.disks.iter().all(|disk| disk.glued) {
            return Err(ConfigError::new(
                "sample.disks",
                "needs at least one disk that is not glued",
            ));
        }
        for (i, disk) in self.disks.iter().enumerate() {
            let key = |name: &str| format!("sample.disks[{i}].{name}");
            positive(&key("radius_m"), disk.radius_m, "m")?;
            finite(&key("x_m"), disk.x_m)?;
            finite(&key("y_m"), disk.y_m)?;
            if disk.lid && !disk.glued {
                return refuse(
                    &key("lid"),
                    "only a glued disk belongs to the lid",
                    "add glued = true",
                );
            }
        }
        for (i, wall) in self.walls.iter().enumerate() {
            wall.validate(&format!("sample.walls[{i}]"))?;
        }
        self.validate_clusters()
    }

    /// True if any disks move together.
    pub fn has_clusters(&self) -> bool {
        self.disks.iter().any(|disk| disk.cluster.is_some())
    }

    /// Refuses clusters without disks and disks that cannot be in one.
    fn validate_clusters(&self) -> Result<(), ConfigError> {
        for (i, disk) in self.disks.iter().enumerate() {
            let moves =
                disk.vx_m_per_s != 0.0 || disk.vy_m_per_s != 0.0 || disk.spin_rad_per_s != 0.0;
            if disk.cluster.is_some() && (disk.glued || moves) {
                return refuse(
                    &format!("sample.disks[{i}].cluster"),
                    "a disk of a cluster moves with it: it cannot be glued, nor have a velocity of its own",
                    "give the velocity in sample.clusters",
                );
            }
        }
        for (i, cluster) in self.clusters.iter().enumerate() {
            let key = format!("sample.clusters[{i}]");
            cluster.validate(&key)?;
            let named = |disk: &DiskConfig| disk.cluster.as_ref() == Some(&cluster.name);
            let again = self.clusters[..i].iter().any(|c| c.name == cluster.name);
            if again || !self.disks.iter().any(named) {
                return refuse(
                    &format!("{key}.name"),
                    format!(
                        "{:?} {}",
                        cluster.name,
                        if again {
                            "is there twice"
                        } else {
                            "has no disks"
                        }
                    ),
                    "write cluster = \"name\" at its disks, and one entry a name",
                );
            }
        }
        Ok(())
    }

    /// Returns the largest radius (m).
    pub(super) fn validate_strip(&self, ends: [f64; 2]) -> Result<f64, ConfigError> {
        self.refuse_torn_clusters(ends[1] - ends[0])?;
        let level = |nx: Option<f64>| nx == Some(0.0);
        if let Some(i) = self.walls.iter().position(|wall| !level(wall.nx)) {
            return refuse(
                &format!("sample.walls[{i}]"),
                "only a level half-plane repeats along x, and sample.periodic_x_m does",
                "write nx = 0",
            );
        }
        Ok(self
            .disks
            .iter()
            .map(|disk| disk.radius_m)
            .fold(0.0, f64::max))
    }

    /// A cluster is listed whole, also where it lies across an end: its places are not folded.
    fn refuse_torn_clusters(&self, length: f64) -> Result<(), ConfigError> {
        for (i, disk) in self.disks.iter().enumerate() {
            let Some(name) = &disk.cluster else {
                continue;
            };
            let mut others = self.disks[..i]
                .iter()
                .filter(|d| d.cluster.as_ref() == Some(name));
            if others.any(|other| (other.x_m - disk.x_m).abs() > 0.5 * length) {
                return refuse(
                    &format!("sample.disks[{i}].x_m"),
                    format!("lies more than half the strip from another disk of cluster {name:?}"),
                    "list a cluster in one piece, beyond the end of the strip if need be",
                );
            }
        }
        Ok(())
    }
}
