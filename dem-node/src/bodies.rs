//! What does not change while the grains move: radii, masses, walls, law and scheme.

use crate::law::Law;

/// A fixed half-plane; the grains stay on the side of the normal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HalfPlane {
    /// A point of the face (m).
    pub point: [f64; 2],
    /// Unit normal.
    pub normal: [f64; 2],
}

/// The bodies in their numbering: free grains, glued disks, wheel (if any), walls.
#[derive(Clone, Debug)]
pub struct Bodies {
    /// Number of free grains.
    pub free: usize,
    /// Radii of free grains and glued disks (m).
    pub radii: Vec<f64>,
    /// Scaled masses of the free grains (kg).
    pub masses: Vec<f64>,
    /// Acceleration that the weight gives to the scaled masses (m/s2).
    pub gravity: [f64; 2],
    /// Places of the glued disks in the undeformed wall, by ascending x (m).
    pub reference: Vec<[f64; 2]>,
    /// Mass of the wheel (kg), where there is one.
    pub wheel_mass: Option<f64>,
    /// Radius of the wheel's face (m); 0 = flat.
    pub wheel_radius: f64,
    /// Fixed walls.
    pub walls: Vec<HalfPlane>,
    /// Velocity of the only grain when its motion is prescribed (m/s).
    pub pulled: Option<[f64; 2]>,
    /// What happens at a contact.
    pub law: Law,
    /// Pairs that may come closer than this in a step enter the contact problem (m).
    pub alert: f64,
    /// What the Verlet list holds beyond that, so that it lasts several steps (m).
    pub skin: f64,
}

impl Bodies {
    /// Number of disks, glued ones included.
    pub fn disks(&self) -> usize {
        self.radii.len()
    }

    /// Number of glued disks.
    pub fn glued(&self) -> usize {
        self.reference.len()
    }

    /// Number of all bodies.
    pub fn count(&self) -> usize {
        self.disks() + usize::from(self.wheel_mass.is_some()) + self.walls.len()
    }

    /// Number of the wheel.
    pub fn wheel(&self) -> Option<usize> {
        self.wheel_mass.map(|_| self.disks())
    }

    /// The wall with this body number; `None` for disks and the wheel.
    pub fn wall_of(&self, body: usize) -> Option<&HalfPlane> {
        let first = self.disks() + usize::from(self.wheel_mass.is_some());
        body.checked_sub(first).and_then(|i| self.walls.get(i))
    }

    /// Whether the body is a glued disk, and which one.
    pub fn glued_index(&self, body: usize) -> Option<usize> {
        (self.free..self.disks())
            .contains(&body)
            .then(|| body - self.free)
    }

    /// Mean radius of the free grains (m).
    pub fn mean_radius(&self) -> f64 {
        self.radii[..self.free].iter().sum::<f64>() / self.free as f64
    }
}
