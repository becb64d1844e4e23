//! Rigid clusters of disks.
//!
//! A cluster moves as one body about its centre of mass. Its first disk represents it in the contact problem and has its velocity and mass; its other
//! disks have none and follow it. Spins are stored times the radius sqrt(2 I/m), as a disk's spin is stored times its own radius: both turn with 2/m,
//! and a cluster of one disk is that disk.

use serde::{Deserialize, Serialize};

use crate::bodies::drive::{Drive, StepTime};

/// All clusters of a scene.
#[derive(Clone, Debug, Default)]
pub struct Clusters {
    /// All of them, in the order of their poses.
    pub list: Vec<Cluster>,
    /// Cluster of each disk, [`SINGLE`] for a disk without cluster; empty without clusters.
    of_disk: Vec<u32>,
}

/// Stands for no cluster.
const SINGLE: u32 = u32::MAX;

/// Disks that move together.
#[derive(Clone, Debug)]
pub struct Cluster {
    /// Numbers of its disks.
    pub disks: Vec<usize>,
    /// Their positions about the centre of mass at the start (m).
    offsets: Vec<[f64; 2]>,
    /// Scaled mass (kg).
    pub mass: f64,
    /// sqrt(2 I/m) (m).
    pub radius: f64,
    /// 1 where it can move, 0 where it keeps its velocity from the start: x, y, rotation.
    pub free: [f64; 3],
    /// Loads, where it is driven.
    pub drive: Option<Drive>,
    /// Its pose at the start.
    pub start: Pose,
    /// Velocity at the start: v_x, v_y, spin times radius (m/s).
    pub start_velocity: [f64; 3],
}

/// The description of a cluster in a sample.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ClusterMembers {
    /// Name given in its disks.
    pub name: String,
    /// Numbers of its disks among the free grains.
    pub disks: Vec<usize>,
    /// True for each of x, y and rotation that is locked.
    pub locked: [bool; 3],
    /// Mass (kg) and moment of inertia (kg m2) that replace the disks' values.
    pub mass: Option<f64>,
    /// See `mass`.
    pub inertia: Option<f64>,
    /// Velocity of the centre of mass and spin at the start (m/s, m/s, rad/s).
    pub velocity: [f64; 3],
    /// Loads, where it is driven.
    pub drive: Option<Drive>,
}

/// Position and angle of a cluster.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Pose {
    /// Centre of mass (m).
    pub centre: [f64; 2],
    /// Angle since the start (rad).
    pub angle: f64,
}

impl Cluster {
    /// The cluster of these members. `disk` gives centre, radius (m) and mass (kg) of each; `scale` multiplies the masses.
    /// The sum goes over disks: overlaps count twice.
    pub fn new(
        members: &ClusterMembers,
        disk: impl Fn(usize) -> ([f64; 2], f64, f64),
        scale: f64,
    ) -> Cluster {
        let parts: Vec<_> = members.disks.iter().map(|i| disk(*i)).collect();
        let sum: f64 = parts.iter().map(|(_, _, m)| m).sum();
        let moment = |k: usize| parts.iter().map(|(c, _, m)| m * c[k]).sum::<f64>() / sum;
        let centre = match &parts[..] {
            [(centre, _, _)] => *centre,
            _ => [moment(0), moment(1)],
        };
        let offset = |c: [f64; 2]| [c[0] - centre[0], c[1] - centre[1]];
        let inertia = parts.iter().map(|(c, r, m)| {
            let [x, y] = offset(*c);
            m * (0.5 * r * r + x * x + y * y)
        });
        let mass = members.mass.unwrap_or(sum);
        // A mass of its own changes the density, not the shape.
        let of_disks = inertia.sum::<f64>() * (mass / sum);
        let inertia = members.inertia.unwrap_or(of_disks);
        let radius = (2.0 * inertia / mass).sqrt();
        let [x, y, spin] = members.velocity;
        Cluster {
            disks: members.disks.clone(),
            offsets: parts.iter().map(|(c, _, _)| offset(*c)).collect(),
            mass: mass * scale,
            radius,
            free: members.locked.map(|locked| f64::from(u8::from(!locked))),
            drive: members.drive.clone(),
            start: Pose { centre, angle: 0.0 },
            start_velocity: [x, y, spin * radius],
        }
    }

    /// The disk that stands for the cluster.
    pub fn leader(&self) -> usize {
        self.disks[0]
    }

    /// Change by a unit impulse of (v_x, v_y, spin times radius) (1/kg). Damping is implicit: it acts on this change too.
    pub fn inverse_mass(&self, at: &StepTime) -> [f64; 3] {
        let [x, y, turn] = self.free;
        let damped = self.mass + at.theta * self.drag(at);
        [x / damped, y / damped, 2.0 * turn / self.mass]
    }

    /// 1/m of a contact whose disk is centred here (1/kg): n.M^-1 n + a^2/I, a being the lever of the normal about the centre of mass. It is 1/M only
    /// for a contact in line with that centre, and 0 where all motion along the normal is held.
    pub fn mobility(&self, pose: &Pose, normal: [f64; 2], centre: [f64; 2]) -> f64 {
        let ([nx, ny], [x, y, turn]) = (normal, self.free);
        let [lever, _] = self.lever(pose, normal, centre, 0.0);
        (x * nx * nx + y * ny * ny + 2.0 * turn * lever * lever) / self.mass
    }

    /// Least mass with which the outermost disk meets another body (kg): M/(1 + M l^2/I).
    pub fn lightest(&self) -> f64 {
        self.mass / (1.0 + 2.0 * self.free[2] * (self.reach() / self.radius).powi(2))
    }

    /// Distance of the furthest centre of a disk from the centre of mass (m).
    fn reach(&self) -> f64 {
        let reach = self.offsets.iter().map(|o| o[0].hypot(o[1]));
        reach.fold(0.0, f64::max)
    }

    fn drag(&self, at: &StepTime) -> f64 {
        self.drive.as_ref().map_or(0.0, |drive| drive.drag(at))
    }

    /// Velocity at the end of a step without contacts: v with weight and loads, the weight giving `gravity` (m/s2).
    pub fn free_velocity(&self, v: [f64; 3], gravity: [f64; 2], at: &StepTime) -> [f64; 3] {
        let Some(drive) = &self.drive else {
            let kick = |k: usize| v[k] + self.free[k] * at.step * gravity[k];
            return [kick(0), kick(1), v[2]];
        };
        let (push, drag) = (drive.push(at), drive.drag(at));
        let kick = |k: usize| {
            let gained = self.mass * at.step * gravity[k] + push[k] - drag * v[k];
            v[k] + self.free[k] * gained / (self.mass + at.theta * drag)
        };
        [kick(0), kick(1), v[2]]
    }

    /// Impulse of loads and damping in a step in the free directions (N s), for the velocities at its start and its end.
    pub fn driving_impulse(&self, start: [f64; 3], end: [f64; 3], at: &StepTime) -> [f64; 2] {
        let Some(drive) = &self.drive else {
            return [0.0; 2];
        };
        let (push, drag) = (drive.push(at), drive.drag(at));
        let meanwhile = |k: usize| at.theta * end[k] + (1.0 - at.theta) * start[k];
        [0, 1].map(|k| self.free[k] * (push[k] - drag * meanwhile(k)))
    }

    /// Moves the pose with a velocity (v_x, v_y, spin times radius) for a time (s) and the disks with it.
    pub fn drift(&self, pose: &mut Pose, v: [f64; 3], time: f64, centres: &mut [[f64; 2]]) {
        pose.centre[0] += time * v[0];
        pose.centre[1] += time * v[1];
        pose.angle += time * v[2] / self.radius;
        let (sin, cos) = pose.angle.sin_cos();
        for (disk, [x, y]) in self.disks.iter().zip(&self.offsets) {
            centres[*disk] = [
                pose.centre[0] + cos * x - sin * y,
                pose.centre[1] + sin * x + cos * y,
            ];
        }
    }

    /// Speed that no centre of its disks exceeds (m/s).
    pub fn top_speed(&self, v: [f64; 3]) -> f64 {
        v[0].hypot(v[1]) + v[2].abs() / self.radius * self.reach()
    }

    /// Velocity of a point (m/s, m/s) and spin (rad/s) of the cluster.
    pub fn velocity_at(&self, pose: &Pose, v: [f64; 3], point: [f64; 2]) -> [f64; 3] {
        let spin = v[2] / self.radius;
        [
            v[0] - spin * (point[1] - pose.centre[1]),
            v[1] + spin * (point[0] - pose.centre[0]),
            spin,
        ]
    }

    /// Lever of a contact point about the centre of mass over the radius: along the normal, along the tangent.
    ///
    /// The point lies `arm` n from the centre of the disk (m). With l from the centre of mass to it, spin moves it by
    /// w (l x n) along the normal and by w (l x t) = w l.n along the tangent t = (-n_y, n_x).
    pub fn lever(&self, pose: &Pose, normal: [f64; 2], centre: [f64; 2], arm: f64) -> [f64; 2] {
        let [nx, ny] = normal;
        let x = centre[0] - pose.centre[0];
        let y = centre[1] - pose.centre[1];
        [
            (x * ny - y * nx) / self.radius,
            (x * nx + y * ny + arm) / self.radius,
        ]
    }
}

impl Clusters {
    /// These clusters of a sample with this number of disks.
    pub fn new(list: Vec<Cluster>, disks: usize) -> Clusters {
        let mut of_disk = vec![SINGLE; if list.is_empty() { 0 } else { disks }];
        for (index, cluster) in list.iter().enumerate() {
            for disk in &cluster.disks {
                of_disk[*disk] = index as u32;
            }
        }
        Clusters { list, of_disk }
    }

    /// The cluster of a body that is a disk, with its number.
    pub fn of(&self, body: usize) -> Option<(usize, &Cluster)> {
        let index = *self.of_disk.get(body)? as usize;
        self.list.get(index).map(|cluster| (index, cluster))
    }

    /// The body that moves in place of this one: the first disk of its cluster, or itself.
    pub fn leader_of(&self, body: usize) -> usize {
        self.of(body).map_or(body, |(_, cluster)| cluster.leader())
    }

    /// The clusters that are driven, with their numbers and drives.
    pub fn driven(&self) -> impl Iterator<Item = (usize, &Cluster, &Drive)> {
        let all = self.list.iter().enumerate();
        all.filter_map(|(i, cluster)| Some((i, cluster, cluster.drive.as_ref()?)))
    }

    /// Pairs of disks that clusters hold together; the disks of driven clusters are paired with `anchor`, a body beyond the grains.
    pub fn held(&self, anchor: u32) -> impl Iterator<Item = (u32, u32)> {
        self.list.iter().flat_map(move |cluster| {
            let first = match cluster.drive {
                Some(_) => anchor,
                None => cluster.leader() as u32,
            };
            cluster.disks.iter().map(move |disk| (*disk as u32, first))
        })
    }

    /// True if two disks belong to the same cluster.
    pub fn share(&self, a: usize, b: usize) -> bool {
        match (self.of(a), self.of(b)) {
            (Some((a, _)), Some((b, _))) => a == b,
            _ => false,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn dumbbell() -> Cluster {
        let members = ClusterMembers {
            disks: vec![3, 5],
            velocity: [1.0, 2.0, 4.0],
            ..ClusterMembers::default()
        };
        // Masses 1 and 3 at x = 0 and 4: centre at 3, I = (1 x 9 + 3 x 1) + (1 + 3) 2^2 / 2 = 20.
        let disk = |i: usize| match i {
            3 => ([0.0, 0.0], 2.0, 1.0),
            _ => ([4.0, 0.0], 2.0, 3.0),
        };
        Cluster::new(&members, disk, 10.0)
    }

    #[test]
    fn mass_centre_and_inertia_follow_from_the_disks() {
        let cluster = dumbbell();
        assert_eq!(cluster.start.centre, [3.0, 0.0]);
        assert_eq!(cluster.mass, 40.0);
        assert!((cluster.radius.powi(2) - 10.0).abs() < 1e-14);
    }

    #[test]
    fn a_quarter_turn_takes_the_disks_along() {
        let (cluster, mut centres) = (dumbbell(), vec![[0.0; 2]; 6]);
        let mut pose = cluster.start;
        let velocity = cluster.start_velocity;
        cluster.drift(
            &mut pose,
            velocity,
            std::f64::consts::FRAC_PI_8,
            &mut centres,
        );
        let turned = std::f64::consts::FRAC_PI_8;
        let expected = [3.0 + turned, 2.0 * turned - 3.0];
        for (k, x) in expected.into_iter().enumerate() {
            assert!((centres[3][k] - x).abs() < 1e-14, "{:?}", centres[3]);
        }
        let [vx, vy, spin] = cluster.velocity_at(&pose, velocity, centres[3]);
        // 3 below the centre at 4 rad/s.
        assert!(
            (vx - 13.0).abs() < 1e-13 && (vy - 2.0).abs() < 1e-13 && (spin - 4.0).abs() < 1e-14
        );
    }

    #[test]
    fn only_disks_of_one_cluster_share_it() {
        let clusters = Clusters::new(vec![dumbbell()], 6);
        assert!(clusters.share(3, 5) && !clusters.share(3, 4) && !clusters.share(0, 1));
        assert_eq!([3, 4, 5, 9].map(|i| clusters.leader_of(i)), [3, 4, 3, 9]);
    }
}
