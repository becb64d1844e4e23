//! A feed of grains: its constants and its progress, which [`crate::step::injection`] advances.

use serde::{Deserialize, Serialize};

/// Constants of a feed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Injection {
    /// Number of fed grains, which are the last of the free grains.
    pub grains: usize,
    /// Time in which a grain grows (s).
    pub growth: f64,
    /// The source of the grains.
    pub source: Source,
}

/// Sources of fed grains.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Source {
    /// From outside, at a point.
    Point(PointSource),
    /// Off bare surfaces.
    Surface(Detachment),
}

/// A source outside of the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointSource {
    /// The point (m).
    pub point: [f64; 2],
    /// Scaled mass that is fed in per second (kg/s).
    pub rate: f64,
    /// Start of the feed (s).
    pub start: f64,
    /// End of the feed (s).
    pub end: f64,
}

/// Steel that comes off.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Detachment {
    /// Work of friction over length after which a layer comes off (J/m).
    pub energy: f64,
    /// Depth of a layer, and of all layers at most (m).
    pub depth: f64,
    /// See `depth`.
    pub limit: f64,
    /// Scaled mass over area of the plane (kg/m2).
    pub mass: f64,
}

/// A grain that does not have its full radius yet.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Growing {
    grain: u32,
    /// Time at which it began (s).
    start: f64,
    /// Length of its radius that was missing then, and that is missing now (m).
    first: f64,
    missing: f64,
}

/// Progress of a feed.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Feed {
    /// Number of grains in store, which are the last of the free grains.
    pub waiting: u32,
    /// Scaled mass due so far (kg).
    pub due: f64,
    /// Scaled mass fed in so far, in grains (kg).
    pub delivered: f64,
    growing: Vec<Growing>,
}

impl Injection {
    /// The source at a point, if it is one.
    pub fn point(&self) -> Option<&PointSource> {
        match &self.source {
            Source::Point(source) => Some(source),
            Source::Surface(_) => None,
        }
    }
}

impl PointSource {
    /// Mass that should be fed in by a time (kg).
    pub fn due(&self, time: f64) -> f64 {
        self.rate * (time.min(self.end) - self.start).max(0.0)
    }
}

impl Feed {
    /// A feed whose grains are all in store.
    pub fn new(injection: Option<&Injection>) -> Feed {
        Feed {
            waiting: injection.map_or(0, |injection| injection.grains as u32),
            ..Feed::default()
        }
    }

    /// Advances to a time (s). Returns the lengths (m) by which grains grow until then, each in the time `growth` (s).
    pub fn advance(&mut self, growth: f64, time: f64) -> Vec<(u32, f64)> {
        let growing = self.growing.iter_mut();
        let grown = growing.map(|growing| {
            let rest = 1.0 - (time - growing.start) / growth;
            let before = growing.missing;
            growing.missing = growing.first * rest.max(0.0);
            (growing.grain, before - growing.missing)
        });
        let grown = grown.collect();
        self.growing.retain(|growing| growing.missing > 0.0);
        grown
    }

    /// True if a grain of a mass (kg) is in store, and due.
    pub fn is_due(&self, mass: f64) -> bool {
        self.waiting > 0 && self.delivered + mass <= self.due
    }

    /// Takes the next grain, of a mass (kg), out of the store at a time (s); this length of its radius is missing (m).
    pub fn take_out(&mut self, grain: u32, mass: f64, missing: f64, time: f64) {
        self.waiting -= 1;
        self.delivered += mass;
        if missing > 0.0 {
            self.growing.push(Growing {
                grain,
                start: time,
                first: missing,
                missing,
            });
        }
    }

    /// Part of the mass due that found no gap; `next` is the mass of the next grain (kg), which is due as a whole only.
    pub fn missed(&self, next: f64) -> f64 {
        let owed = self.due - self.delivered - next;
        if owed > 0.0 { owed / self.due } else { 0.0 }
    }

    /// Stops the growth of a grain that was taken out.
    pub fn forget(&mut self, grain: u32) {
        self.growing.retain(|growing| growing.grain != grain);
    }

    /// Length that is missing from a disk's radius (m).
    #[inline]
    pub fn missing(&self, disk: u32) -> f64 {
        let found = self.growing.iter().find(|growing| growing.grain == disk);
        found.map_or(0.0, |growing| growing.missing)
    }

    /// True while a grain grows.
    #[inline]
    pub fn grows(&self) -> bool {
        !self.growing.is_empty()
    }

    /// All numbers that can change a later bit.
    pub fn numbers(&self) -> impl Iterator<Item = f64> {
        let first = [f64::from(self.waiting), self.due, self.delivered];
        let growing = self.growing.iter();
        let growing = growing.flat_map(|g| [f64::from(g.grain), g.start, g.first, g.missing]);
        first.into_iter().chain(growing)
    }
}
