//! The keys of `sample` with kind = "disks", its walls and clusters, and their limits.

use dem_kernel::bodies::geometry::range;
use dem_kernel::bodies::pairs::{GRAINS, ROWS, SURFACE, WHEEL};
use kit::ConfigError;
use kit::keys::refuse_if;
use kit::limits::{ROUNDING, positive};
use schemars::JsonSchema;
use serde::Deserialize;

use super::drive::ClusterDriveConfig;
use super::fill::{FillConfig, RowConfig};
use super::surface::{SPACING, SurfaceConfig};

/// Listed disks and walls, and rectangles and rows that are filled with disks.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DisksConfig {
    /// The disks; glued ones form the sets `base` and `lid`.
    #[serde(default)]
    pub disks: Vec<DiskConfig>,
    /// Rectangles that are filled with loose disks of random radii.
    #[serde(default)]
    pub fill: Vec<FillConfig>,
    /// Rows of disks of random radii, each row a rigid cluster or a part of one: rough walls.
    #[serde(default)]
    pub rows: Vec<RowConfig>,
    /// Rigid walls.
    #[serde(default)]
    pub walls: Vec<WallConfig>,
    /// The surface of a body that another solver moves, set `base`; at rest and rigid where no interface couples it. No surface when absent.
    pub surface: Option<SurfaceConfig>,
    /// Properties of rigid clusters; a cluster that is not listed is free and as heavy as its disks.
    #[serde(default)]
    pub clusters: Vec<ClusterConfig>,
    /// Ends of the strip that repeats along x (m): disks near one end touch disks near the other. Nothing repeats when absent.
    pub periodic_x_m: Option<[f64; 2]>,
}

/// One disk.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DiskConfig {
    /// Centre along x (m).
    pub x_m: f64,
    /// Centre along y (m).
    pub y_m: f64,
    /// Radius (m).
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub radius_m: f64,
    /// Velocity along x at the start (m/s).
    #[serde(default)]
    pub vx_m_per_s: f64,
    /// Velocity along y at the start (m/s).
    #[serde(default)]
    pub vy_m_per_s: f64,
    /// Spin at the start (rad/s), anticlockwise positive.
    #[serde(default)]
    pub spin_rad_per_s: f64,
    /// True for a disk of a glued row: massless, without spin.
    #[serde(default)]
    pub glued: bool,
    /// Name of the rigid cluster that the disk belongs to: disks of the same name move as one body. It moves by itself when absent.
    pub cluster: Option<String>,
    /// True for a glued disk of the row on top, set `lid`; other glued disks form the set `base`.
    #[serde(default)]
    pub lid: bool,
}

/// A rigid wall: a half-plane by a point and a normal, or a polyline by its corners.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WallConfig {
    /// Name for `law.pairs`, and for the signals and results of the force on the wall; a wall without a name has no such results.
    pub name: Option<String>,
    /// Position along x of a point of the face of a half-plane (m).
    pub x_m: Option<f64>,
    /// Position along y of a point of the face of a half-plane (m).
    pub y_m: Option<f64>,
    /// Component along x of the normal of a half-plane, of any length: the grains stay on its side.
    pub nx: Option<f64>,
    /// Component along y of the normal of a half-plane.
    pub ny: Option<f64>,
    /// Corners of a polyline (m), instead of x_m, y_m, nx and ny. The grains stay on the left of its direction. A polyline that ends where it began
    /// is closed; other ends are round.
    #[schemars(length(min = 2))]
    pub points_m: Option<Vec<[f64; 2]>>,
    /// Constant velocity (m/s).
    #[serde(default)]
    pub velocity_m_per_s: [f64; 2],
}

/// Mass, motion and locks of the disks with `cluster = name`.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ClusterConfig {
    /// The name given in `cluster` of its disks.
    pub name: String,
    /// Motions of the cluster that are held at 0: x, y or rotation.
    #[serde(default)]
    pub locked: Vec<MotionConfig>,
    /// Mass (kg), before `mass_scale`; the sum of the disks, overlaps counted twice, when absent.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub mass_kg: Option<f64>,
    /// Moment of inertia about the centre of mass (kg m2), before `mass_scale`. When absent the inertia of the disks, which grows with `mass_kg`.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub inertia_kg_m2: Option<f64>,
    /// Velocity of the centre of mass along x at the start (m/s).
    #[serde(default)]
    pub vx_m_per_s: f64,
    /// Velocity of the centre of mass along y at the start (m/s).
    #[serde(default)]
    pub vy_m_per_s: f64,
    /// Spin at the start (rad/s), anticlockwise positive.
    #[serde(default)]
    pub spin_rad_per_s: f64,
    /// Prescribed motion and loads; a driven cluster does not turn. Not driven when absent.
    pub drive: Option<ClusterDriveConfig>,
}

/// The words for `sample.clusters.locked`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum MotionConfig {
    /// Sideways.
    X,
    /// Up and down.
    Y,
    /// Turning.
    Rotation,
}

impl DiskConfig {
    /// Refuses its velocity if a condition holds.
    pub(super) fn refuse_velocity(
        &self,
        holds: bool,
        key: &str,
        why: &str,
        help: &str,
    ) -> Result<(), ConfigError> {
        kit::named!(self; vx_m_per_s, vy_m_per_s, spin_rad_per_s)
            .into_iter()
            .try_for_each(|(name, v)| {
                refuse_if(holds && v != 0.0, &format!("{key}.{name}"), why, help)
            })
    }
}

impl WallConfig {
    /// Refuses a wall that is neither a half-plane nor a polyline, or both.
    fn validate(&self, key: &str) -> Result<(), ConfigError> {
        let plane = kit::named!(self; x_m, y_m, nx, ny);
        let Some(points) = &self.points_m else {
            return validate_plane(key, plane);
        };
        for (name, value) in plane {
            refuse_if(
                value.is_some(),
                &format!("{key}.{name}"),
                "belongs to a half-plane, and points_m makes the wall a polyline",
                "remove one of them",
            )?;
        }
        validate_corners(&format!("{key}.points_m"), points)
    }
}

fn validate_plane(key: &str, plane: [(&str, Option<f64>); 4]) -> Result<(), ConfigError> {
    for (name, value) in plane {
        if value.is_none() {
            return Err(ConfigError::new(&format!("{key}.{name}"), "is missing")
                .help("a half-plane needs x_m, y_m, nx and ny, a polyline points_m"));
        }
    }
    let [_, _, nx, ny] = plane.map(|(_, value)| value.unwrap_or(0.0));
    positive(&format!("{key}.nx"), nx.hypot(ny), "length of (nx, ny)")
        .map_err(|error| error.help("write a direction, for instance nx = 0 and ny = 1"))
}

fn validate_corners(key: &str, points: &[[f64; 2]]) -> Result<(), ConfigError> {
    for (i, ends) in points.windows(2).enumerate() {
        refuse_if(
            ends[0] == ends[1],
            key,
            format!("points {i} and {} are the same", i + 1),
            "remove one of them",
        )?;
    }
    Ok(())
}

impl ClusterConfig {
    /// True for each of x, y and rotation that is held.
    pub fn holds(&self) -> [bool; 3] {
        let [x, y, turn] = [MotionConfig::X, MotionConfig::Y, MotionConfig::Rotation]
            .map(|motion| self.locked.contains(&motion));
        match &self.drive {
            None => [x, y, turn],
            Some(drive) => {
                let prescribed = drive.velocity().map(|v| v.is_some());
                [prescribed[0], prescribed[1], true]
            }
        }
    }

    /// Mass (kg) that replaces the sum of the disks.
    pub fn mass(&self) -> Option<f64> {
        self.mass_kg.or_else(|| self.drive.as_ref()?.mass_kg)
    }

    fn validate(&self, key: &str) -> Result<(), ConfigError> {
        let velocity = kit::named!(self; vx_m_per_s, vy_m_per_s, spin_rad_per_s);
        for ((name, value), held) in velocity.into_iter().zip(self.holds()) {
            refuse_if(
                held && value != 0.0,
                &format!("{key}.{name}"),
                "belongs to a motion that is locked",
                "remove it, or take the motion out of `locked`",
            )?;
        }
        let [x, y, turn] = self.holds();
        for (name, idle) in [
            ("mass_kg", self.mass_kg.is_some() && x && y),
            ("inertia_kg_m2", self.inertia_kg_m2.is_some() && turn),
        ] {
            refuse_if(
                idle,
                &format!("{key}.{name}"),
                "has no effect: the motion that it resists is locked or driven",
                "remove it, or free the motion in `locked` or drive.velocity_m_per_s",
            )?;
        }
        match &self.drive {
            None => Ok(()),
            Some(drive) => self.validate_drive(drive, key),
        }
    }

    fn validate_drive(&self, drive: &ClusterDriveConfig, key: &str) -> Result<(), ConfigError> {
        refuse_if(
            !self.locked.is_empty(),
            &format!("{key}.locked"),
            "a driven cluster does not turn, and its drive says how it moves along x and y",
            "remove the key; drive.velocity_m_per_s = 0 holds a direction",
        )?;
        refuse_if(
            self.mass_kg.is_some() && drive.mass_kg.is_some(),
            &format!("{key}.mass_kg"),
            "is given in drive.mass_kg as well",
            "remove one of them",
        )?;
        drive.validate(&format!("{key}.drive"))
    }
}

impl DisksConfig {
    pub(super) fn validate(&self) -> Result<(), ConfigError> {
        for (i, fill) in self.fill.iter().enumerate() {
            fill.validate(&format!("sample.fill[{i}]"))?;
        }
        for (i, row) in self.rows.iter().enumerate() {
            row.validate(&format!("sample.rows[{i}]"))?;
        }
        let others = !(self.fill.is_empty() && self.rows.is_empty());
        refuse_if(
            !others && self.disks.is_empty(),
            "sample.disks",
            "is missing, and so are sample.fill and sample.rows",
            "list a disk, or fill a rectangle",
        )?;
        refuse_if(
            !others && self.disks.iter().all(|disk| disk.glued),
            "sample.disks",
            "needs at least one disk that is not glued",
            "list one, or fill a rectangle with sample.fill",
        )?;
        for (i, disk) in self.disks.iter().enumerate() {
            refuse_if(
                disk.lid && !disk.glued,
                &format!("sample.disks[{i}].lid"),
                "only a glued disk belongs to the lid",
                "add glued = true",
            )?;
            disk.refuse_velocity(
                disk.glued,
                &format!("sample.disks[{i}]"),
                "has no effect on a glued disk, which moves with its body",
                "remove it, or give the body the velocity",
            )?;
        }
        for (i, wall) in self.walls.iter().enumerate() {
            wall.validate(&format!("sample.walls[{i}]"))?;
        }
        if let Some(surface) = &self.surface {
            let glued = self.disks.iter().filter(|disk| disk.glued && !disk.lid);
            let within = range(glued.flat_map(|d| [d.x_m - d.radius_m, d.x_m + d.radius_m]));
            let within = within.map(|x| if x.is_finite() { x.abs() } else { 0.0 });
            let spacing = SPACING * self.radii().0;
            surface.validate(within[0].max(within[1]), spacing, false)?;
            refuse_if(
                surface.half_width_m.is_none() && surface.points_m.is_none(),
                "sample.surface.half_width_m",
                "is missing, and so is points_m",
                "write how far the surface reaches",
            )?;
        }
        self.validate_clusters()
    }

    /// True if any disks move together.
    pub fn has_clusters(&self) -> bool {
        self.cluster_names().next().is_some()
    }

    /// Number of grains at the start: disks that move by themselves, and 2 where rectangles are filled with them.
    pub(super) fn grains(&self) -> usize {
        let alone = |disk: &&DiskConfig| !disk.glued && disk.cluster.is_none();
        self.disks.iter().filter(alone).count() + 2 * self.fill.len()
    }

    /// Names of the groups of its bodies, for `law.pairs`.
    pub(super) fn groups(&self) -> Vec<&str> {
        let glued = |lid: bool| self.disks.iter().any(|disk| disk.glued && disk.lid == lid);
        let base = glued(false) || self.surface.is_some();
        let rows = ROWS.into_iter().zip([base, glued(true)]);
        let rows = rows.filter_map(|(name, there)| there.then_some(name));
        let walls = self.walls.iter().filter_map(|wall| wall.name.as_deref());
        let mut names: Vec<&str> = rows.chain(walls).chain(self.cluster_names()).collect();
        names.dedup();
        names
    }

    /// Refuses names of walls and clusters that another group has, or that cannot be part of a signal's name.
    pub(super) fn validate_names(&self) -> Result<(), ConfigError> {
        let walls = self.walls.iter().enumerate();
        let walls = walls.filter_map(|(i, wall)| Some(("walls", i, wall.name.as_deref()?)));
        let clusters = self.clusters.iter().enumerate();
        let clusters = clusters.map(|(i, cluster)| ("clusters", i, cluster.name.as_str()));
        let mut known = vec![GRAINS, WHEEL, SURFACE, ROWS[0], ROWS[1]];
        for (list, i, name) in walls.chain(clusters) {
            let plain = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
            let wrong = name.is_empty() || !name.chars().all(plain);
            refuse_if(
                wrong || known.contains(&name),
                &format!("sample.{list}[{i}].name"),
                format!("{name:?} is taken by another group, or is no valid name"),
                "choose another one of letters, digits, - and _",
            )?;
            known.push(name);
        }
        Ok(())
    }

    /// Names of the clusters of listed disks and of rows.
    fn cluster_names(&self) -> impl Iterator<Item = &str> {
        let listed = self.disks.iter().filter_map(|disk| disk.cluster.as_deref());
        listed.chain(self.rows.iter().map(|row| row.cluster.as_str()))
    }

    /// Refuses clusters without disks and disks that cannot be in one.
    fn validate_clusters(&self) -> Result<(), ConfigError> {
        for (i, disk) in self.disks.iter().enumerate() {
            let velocity = [disk.vx_m_per_s, disk.vy_m_per_s, disk.spin_rad_per_s];
            refuse_if(
                disk.cluster.is_some() && (disk.glued || velocity != [0.0; 3]),
                &format!("sample.disks[{i}].cluster"),
                "a disk of a cluster moves with it: it cannot be glued, nor have a velocity of its own",
                "give the velocity in sample.clusters",
            )?;
        }
        for (i, cluster) in self.clusters.iter().enumerate() {
            let key = format!("sample.clusters[{i}]");
            cluster.validate(&key)?;
            let again = self.clusters[..i].iter().any(|c| c.name == cluster.name);
            let fault = ["has no disks", "is there twice"][usize::from(again)];
            refuse_if(
                again || !self.cluster_names().any(|name| name == cluster.name),
                &format!("{key}.name"),
                format!("{:?} {fault}", cluster.name),
                "write cluster = \"name\" at its disks or in sample.rows, and one entry a name",
            )?;
        }
        Ok(())
    }

    /// Mean and smallest radius of the disks that are not glued (m).
    pub(super) fn radii(&self) -> (f64, f64) {
        let listed = self.disks.iter().filter(|disk| !disk.glued);
        let listed = listed.map(|disk| (1.0, [disk.radius_m; 2], disk.radius_m));
        let fills = self.fill.iter().map(|fill| {
            let [columns, rows] = fill.grid();
            let ends = [fill.radius_min_m, fill.radius_max_m];
            (columns * rows, ends, fill.radii().mean())
        });
        let all: Vec<_> = listed.chain(fills).collect();
        let count: f64 = all.iter().map(|(count, ..)| count).sum();
        let sum = all.iter().map(|(count, _, mean)| count * mean).sum::<f64>();
        let smallest = range(all.iter().map(|(_, ends, _)| ends[0]))[0];
        (sum / count, smallest)
    }

    /// Refuses walls and clusters that cannot repeat. Returns the largest radius (m).
    pub(super) fn validate_strip(&self, ends: [f64; 2]) -> Result<f64, ConfigError> {
        self.refuse_torn_clusters(ends[1] - ends[0])?;
        for (i, wall) in self.walls.iter().enumerate() {
            refuse_if(
                wall.nx != Some(0.0),
                &format!("sample.walls[{i}]"),
                "only a level half-plane repeats along x, and sample.periodic_x_m does",
                "write nx = 0",
            )?;
        }
        let listed = self.disks.iter().map(|disk| disk.radius_m);
        let fills = self.fill.iter().map(|fill| fill.radius_max_m);
        let rows = self.rows.iter().map(|row| row.radius_max_m);
        Ok(range(listed.chain(fills).chain(rows))[1])
    }

    /// True if a cluster cannot turn: it may then be as wide as the strip.
    fn is_upright(&self, cluster: Option<&str>) -> bool {
        let named = |entry: &ClusterConfig| Some(entry.name.as_str()) == cluster;
        let mut entries = self.clusters.iter();
        entries.any(|entry| named(entry) && entry.holds()[2])
    }

    /// A cluster that turns is listed in one piece, also across an end of the strip: its positions are not folded.
    fn refuse_torn_clusters(&self, length: f64) -> Result<(), ConfigError> {
        for (i, row) in self.rows.iter().enumerate() {
            refuse_if(
                row.x_m[1] - row.x_m[0] > length * (1.0 + ROUNDING),
                &format!("sample.rows[{i}].x_m"),
                format!(
                    "is longer than the strip of {length:e} m, and its disks would lie on each other"
                ),
                "shorten it to the strip, or lengthen sample.periodic_x_m",
            )?;
            refuse_if(
                !self.is_upright(Some(&row.cluster)),
                &format!("sample.rows[{i}].cluster"),
                format!(
                    "{:?} may turn, and a row of a strip that repeats cannot",
                    row.cluster
                ),
                "add its entry to sample.clusters with a drive or locked = [\"rotation\"]",
            )?;
        }
        for (i, disk) in self.disks.iter().enumerate() {
            if self.is_upright(disk.cluster.as_deref()) {
                continue;
            }
            let far = |other: &&DiskConfig| (other.x_m - disk.x_m).abs() > 0.5 * length;
            let torn = |other: &DiskConfig| disk.cluster.is_some() && other.cluster == disk.cluster;
            refuse_if(
                self.disks[..i].iter().filter(far).any(torn),
                &format!("sample.disks[{i}].x_m"),
                format!(
                    "lies more than half the strip from another disk of cluster {:?}",
                    disk.cluster.as_deref().unwrap_or_default()
                ),
                "list a cluster in one piece, beyond the end of the strip if need be",
            )?;
        }
        Ok(())
    }
}
