//! The bodies, which do not change while the grains move: radii, masses, walls, law and scheme.
//!
//! In reading order:
//! - [`geometry`]: normals and gaps of two bodies;
//! - [`faces`], [`surface`]: rigid walls, and surfaces that another solver moves;
//! - [`levers`], [`drive`], [`cluster`]: grains that move together, and their drives;
//! - [`disk`], [`feed`]: a disk at the start, and grains that are fed in;
//! - [`pairs`]: laws by pair;
//! - [`positions`]: the positions of all bodies at a moment.

pub mod cluster;
pub mod disk;
pub mod drive;
pub mod faces;
pub mod feed;
pub mod geometry;
pub mod levers;
pub mod pairs;
pub mod positions;
pub mod surface;

use std::ops::Range;

use crate::bodies::cluster::Clusters;
use crate::bodies::faces::{Face, RigidWall};
use crate::bodies::feed::Injection;
use crate::bodies::geometry::{Period, between_points, height_on, over_disk};
use crate::bodies::pairs::Pairs;
use crate::bodies::surface::BareSurface;
use crate::law::Law;
use crate::law::heat::HeatLaw;

/// Alert distance over the smallest radius.
pub const ALERT: f64 = 0.02;
/// Verlet skin over the smallest radius. A wide skin costs candidates in each step, a narrow skin costs new lists: at 0.2 a pressed layer makes a new
/// list every few hundred steps.
pub const SKIN: f64 = 0.2;

/// The bodies in their numbering: free grains, glued disks, disks of the wheel's face, wheel (if any), walls, segments of the surface.
#[derive(Clone, Debug, Default)]
pub struct Bodies {
    /// Number of free grains.
    pub free: usize,
    /// The feed, whose grains are the last of the free grains, where there is one.
    pub injection: Option<Injection>,
    /// Radii of all disks (m).
    pub radii: Vec<f64>,
    /// Scaled masses of the free grains (kg); the first disk of a cluster has the mass of the cluster, its other disks 0.
    pub masses: Vec<f64>,
    /// Part of these masses that `mass_scale` adds, 1 - 1/scale.
    pub added_mass_rel: f64,
    /// Acceleration that the weight gives to the scaled masses (m/s2).
    pub gravity: [f64; 2],
    /// Positions of the glued disks in the undeformed boundary (m): first the base, then the lid, each by ascending x.
    pub reference: Vec<[f64; 2]>,
    /// Number of glued disks of the base.
    pub base: usize,
    /// Surfaces beside the glued disks, or in their place.
    pub surface: BareSurface,
    /// Undeformed lines of the bodies below and above, by ascending x: numbers of boundary points, and their positions on the line (m).
    pub lines: [Vec<(usize, [f64; 2])>; 2],
    /// Ends beyond which a grain has left the sample (m), where it has any.
    pub ends: Option<[f64; 2]>,
    /// Mass of the wheel (kg), where there is one.
    pub wheel_mass: Option<f64>,
    /// Radius of the wheel's face (m); 0 = flat.
    pub wheel_radius: f64,
    /// Abscissa of the wheel at the start (m).
    pub wheel_start: f64,
    /// True for a wheel that rolls along the grains.
    pub rolls: bool,
    /// I/R^2 (kg) of a wheel that spins freely.
    pub wheel_spin_mass: Option<f64>,
    /// Positions of the disks of a rough face about its lowest point (m); empty for a smooth face.
    pub face: Vec<[f64; 2]>,
    /// True if the disks of the face are bonded to the grains as the grains are to each other.
    pub face_bonded: bool,
    /// Rigid walls, polylines segment by segment.
    pub walls: Vec<RigidWall>,
    /// Walls with names: the name of each, and its faces in `walls`.
    pub named_walls: Vec<(String, Range<usize>)>,
    /// Free grains that move together.
    pub clusters: Clusters,
    /// The strip that repeats along x, where one does.
    pub period: Option<Period>,
    /// Velocity of the only grain when its motion is prescribed (m/s).
    pub prescribed_velocity: Option<[f64; 2]>,
    /// The law of every contact whose pair has no law of its own.
    pub law: Law,
    /// Laws by pair.
    pub pairs: Pairs,
    /// The law of heat; without one grains have no temperature.
    pub heat: Option<HeatLaw>,
    /// Pairs that may come closer than this in a step enter the contact problem (m).
    pub alert: f64,
    /// Distance that the Verlet list holds beyond `alert`, so that it lasts several steps (m).
    pub skin: f64,
}

impl Bodies {
    /// Number of disks, with the rows and the wheel's face.
    pub fn disks(&self) -> usize {
        self.radii.len()
    }

    /// The glued disks of the lid.
    pub fn lid(&self) -> Range<usize> {
        self.free + self.base..self.first_face()
    }

    /// Number of glued disks.
    pub fn glued(&self) -> usize {
        self.reference.len()
    }

    /// Number of points that the boundary moves: glued disks, then points of the surface.
    pub fn boundary_points(&self) -> usize {
        self.glued() + self.surface.points.len()
    }

    /// Position of a glued disk or a point of the surface in the undeformed boundary (m).
    pub fn boundary_point(&self, number: usize) -> [f64; 2] {
        let of_surface = || self.surface.points[number - self.glued()];
        let glued = self.reference.get(number).copied();
        glued.unwrap_or_else(of_surface)
    }

    /// True if temperature changes the laws of contacts.
    pub fn softens(&self) -> bool {
        self.heat
            .as_ref()
            .is_some_and(|heat| heat.softening.is_some())
    }

    /// The law between two bodies, at the temperature of the start.
    #[inline]
    pub fn law_of(&self, a: usize, b: usize) -> &Law {
        self.pairs.of(a, b).map_or(&self.law, |(_, law)| law)
    }

    /// The law at an index of `pairs`; 0 is the law of most contacts.
    #[inline]
    pub fn law_at(&self, index: u32) -> &Law {
        match index {
            0 => &self.law,
            own => self.pairs.law(own).unwrap_or(&self.law),
        }
    }

    /// True if all contacts have one law at any temperature.
    pub fn has_one_law(&self) -> bool {
        self.pairs.laws().is_empty() && !self.softens()
    }

    /// The law of all contacts, if it is one law of springs between single grains, which no temperature changes: such contacts go side by side.
    pub fn alike(&self) -> Option<&Law> {
        let law = &self.law;
        let single = self.clusters.list.is_empty() && self.prescribed_velocity.is_none();
        let simple = law.springs.is_some() && law.adhesion.is_none() && law.healing.is_none();
        (single && self.has_one_law() && simple).then_some(law)
    }

    /// True if contacts or bonds store energy.
    pub fn is_elastic(&self) -> bool {
        self.law.cohesion.is_some() || self.attracts() || self.any_law(|law| law.springs.is_some())
    }

    /// True if some pairs attract each other.
    pub fn attracts(&self) -> bool {
        self.any_law(|law| law.adhesion.is_some())
    }

    /// True if the bonds of some pairs grow.
    pub fn heals(&self) -> bool {
        self.any_law(|law| law.healing.is_some())
    }

    /// r_1 r_2 / (r_1 + r_2) of two bodies, or the radius of the grain on a face (m).
    pub fn reduced_radius(&self, pair: [u32; 2]) -> f64 {
        let curvature = |body: u32| self.radii.get(body as usize).map_or(0.0, |r| 1.0 / r);
        1.0 / (curvature(pair[0]) + curvature(pair[1]))
    }

    /// True if some law is of this kind.
    pub fn any_law(&self, is: impl Fn(&Law) -> bool) -> bool {
        is(&self.law) || self.pairs.laws().iter().any(is)
    }

    /// Number of all bodies.
    pub fn count(&self) -> usize {
        self.first_segment() + self.surface.segments()
    }

    /// Number of the first disk of the wheel's face.
    pub fn first_face(&self) -> usize {
        self.disks() - self.face.len()
    }

    /// The body that the contacts of a disk push: the wheel for disks of its face, the leader for disks of a cluster.
    pub fn pushed(&self, body: usize) -> usize {
        if (self.first_face()..self.disks()).contains(&body) {
            return self.disks();
        }
        self.clusters.leader_of(body)
    }

    /// True for the wheel and the disks of its face.
    pub fn is_wheel(&self, body: usize) -> bool {
        self.wheel() == Some(self.pushed(body))
    }

    /// Number of the wheel.
    pub fn wheel(&self) -> Option<usize> {
        self.wheel_mass.map(|_| self.disks())
    }

    /// The wall with this body number; `None` for disks and the wheel.
    pub fn wall_of(&self, body: usize) -> Option<&RigidWall> {
        let index = body.checked_sub(self.first_wall())?;
        self.walls.get(index)
    }

    /// Index of the named wall to which the wall with this body number belongs.
    pub fn named_wall(&self, body: usize) -> Option<usize> {
        let index = body.checked_sub(self.first_wall())?;
        let mut named = self.named_walls.iter();
        named.position(|(_, faces)| faces.contains(&index))
    }

    /// Number of the first wall.
    pub fn first_wall(&self) -> usize {
        self.disks() + usize::from(self.wheel_mass.is_some())
    }

    /// Number of the first segment of the surface.
    pub fn first_segment(&self) -> usize {
        self.first_wall() + self.walls.len()
    }

    /// Index of a segment of the surface; `None` for other bodies.
    pub fn segment_index(&self, body: usize) -> Option<usize> {
        let index = body.checked_sub(self.first_segment())?;
        (index < self.surface.segments()).then_some(index)
    }

    /// True if a disk may pass from one wall to another without leaving either.
    pub fn has_joints(&self) -> bool {
        let mut faces = self.walls.iter().map(|wall| &wall.face);
        self.surface.segments() > 0 || faces.any(|face| matches!(face, Face::Segment(_)))
    }

    /// Speed of the fastest wall (m/s).
    pub fn wall_speed(&self) -> f64 {
        let speeds = self.walls.iter().map(|wall| wall.velocity);
        speeds.map(|v| v[0].hypot(v[1])).fold(0.0, f64::max)
    }

    /// Index of a glued disk; `None` for other bodies.
    pub fn glued_index(&self, body: usize) -> Option<usize> {
        let glued = self.free..self.first_face();
        glued.contains(&body).then(|| body - self.free)
    }

    /// Way of a wheel that rolls for which a list of pairs lasts (m): it meets few more disks, as its face is nearly flat.
    pub fn rolling_skin(&self) -> f64 {
        20.0 * self.skin
    }

    /// Height of the lowest point of the wheel's face, over its start, that touches this disk from above (m); `None` for a disk that it does not meet.
    pub fn wheel_height_on(&self, centre: [f64; 2], radius: f64) -> Option<f64> {
        if self.face.is_empty() {
            let aside = between_points(centre, [self.wheel_start, 0.0], self.period);
            let centre = if self.wheel_radius > 0.0 {
                aside
            } else {
                centre
            };
            return height_on(self.wheel_radius, centre, radius);
        }
        let disks = self.face.iter().zip(&self.radii[self.first_face()..]);
        let heights = disks.filter_map(|(offset, own)| {
            Some(centre[1] + over_disk(centre[0] - offset[0], radius + own)? - offset[1])
        });
        heights.reduce(f64::max)
    }

    /// Energy (J) below which contacts only bear weights, attractions and a load (N): their work on a millionth of a radius, far above the error that
    /// the tolerance of a solve leaves. Changes of a kinetic energy (J) below its rounding are noise as well.
    pub fn noise(&self, load: f64, kinetic: f64) -> f64 {
        let ([x, y], radius) = (self.gravity, self.mean_radius());
        let weight = self.masses.iter().sum::<f64>() * x.hypot(y);
        let laws = self.pairs.laws().iter().chain([&self.law]);
        let pulls = laws.filter_map(|law| Some(law.adhesion?.attraction(radius, 0.0)));
        let attraction = self.free as f64 * pulls.fold(0.0, f64::max);
        1e-6 * (weight + attraction + load) * radius + 1e-12 * kinetic
    }

    /// Mean radius of the free grains (m).
    pub fn mean_radius(&self) -> f64 {
        self.radii[..self.free].iter().sum::<f64>() / self.free as f64
    }
}
