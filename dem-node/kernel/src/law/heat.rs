//! Heat in grains: sources and conductance of a contact.
//!
//! The losses of a contact warm its two bodies, half each. Heat passes through contacts that press, with the conductance
//! ```text
//! H = pi k t / (ln(4 r_i/a) + ln(4 r_j/a))
//! ```
//! of two disks between a source and a sink on their rims, strips of the half-width a at one temperature (Carslaw and Jaeger 1959, conduction in the
//! plane); a is Hertz's for parallel cylinders under the force of the contact. Bodies that are no grains have one temperature, held or of the
//! surface of a half-space ([`kit::heat`]), those that a coupler gives, or let no heat through. Heat that spreads in them over a width s adds
//! -ln(sin(pi a/s)) in place of a grain's ln(4 r/a): the constriction of a row of strips of one temperature, s apart, on a half-space (Carslaw and
//! Jaeger 1959, section 16.6, by a conformal map). A factor over temperature multiplies H, at the mean temperature of the two bodies.

use std::f64::consts::PI;

use kit::heat::{CapacityTable, factor_at};
use kit::table::LoadTable;

use crate::law::Law;

/// Gas constant (J/(mol K)).
const GAS: f64 = 8.314_462_618;

/// The law of heat.
#[derive(Clone, Debug)]
pub struct HeatLaw {
    /// c (J/(kg K)).
    pub capacity: f64,
    /// Factor on c over temperature.
    pub capacity_factor: CapacityTable,
    /// Factors on conductances over temperature (K), 1 without entries.
    pub conductivity_factor: LoadTable,
    /// Heat through contacts.
    pub conduction: Conduction,
    /// Temperature of the grains at the start (K).
    pub start: f64,
    /// Shares of the losses that become heat: friction, dampers, impacts, broken bonds.
    pub sources: [f64; 4],
    /// Groups of bodies that are no grains, by name, with their temperatures (K), of half-spaces at the start; without one they let no heat through.
    pub groups: Vec<(String, Option<f64>)>,
    /// Groups that are half-spaces.
    pub half_spaces: Vec<HalfSpace>,
    /// Index of the group of each body; `None` for grains.
    pub group_of: Vec<Option<u32>>,
    /// Steps from one conduction to the next.
    pub every: u32,
    /// Dependence of the laws of contacts on temperature.
    pub softening: Option<Softening>,
}

/// A group of bodies that is one half-space for heat.
#[derive(Clone, Copy, Debug)]
pub struct HalfSpace {
    /// Its group.
    pub group: usize,
    /// b = sqrt(k rho c) (W s^0.5/(m2 K)).
    pub effusivity: f64,
    /// Area through which heat enters it (m2).
    pub area: f64,
    /// Its temperature at the start (K).
    pub start: f64,
}

/// Dependence of the laws of contacts on temperature: factors on their constants over temperature (K), 1 without entries.
#[derive(Clone, Debug, Default)]
pub struct Softening {
    /// On the coefficients of friction.
    pub friction: LoadTable,
    /// On w, the energy of bonds.
    pub bonds: LoadTable,
    /// Activation energy E of healing (J/mol): its time is the constant times exp(E/R (1/T - 1/T_0)) (Arrhenius 1889), T_0 being `start`.
    pub activation: f64,
}

impl Softening {
    /// A law at a temperature (K), its constants being the law's at the `start` (K).
    pub(crate) fn at(&self, law: &Law, [temperature, start]: [f64; 2]) -> Law {
        let mut law = *law;
        law.friction *= factor_at(&self.friction, temperature);
        if let Some(cohesion) = &mut law.cohesion {
            cohesion.energy *= factor_at(&self.bonds, temperature);
        }
        if let Some(healing) = &mut law.healing {
            healing.time *= (self.activation / GAS * (1.0 / temperature - 1.0 / start)).exp();
        }
        law
    }
}

impl HeatLaw {
    /// Temperature (K) of a grain with this heat over m c since the start (K).
    pub fn kelvins(&self, heat: f64) -> f64 {
        self.start + self.capacity_factor.rise(heat)
    }

    /// Factor on the conductance of a contact at this mean rise of its two bodies (K).
    pub(crate) fn conductivity_at(&self, rise: f64) -> f64 {
        factor_at(&self.conductivity_factor, self.start + rise)
    }

    /// Index of the half-space that a group is.
    pub(crate) fn half_space(&self, group: usize) -> Option<usize> {
        self.half_spaces.iter().position(|of| of.group == group)
    }

    /// The group of a body that is no grain.
    pub fn group(&self, body: usize) -> Option<usize> {
        self.group_of[body].map(|group| group as usize)
    }

    /// Temperature of the group of this name (K), if it has one.
    pub fn held_by_name(&self, name: &str) -> Option<f64> {
        let group = self.groups.iter().find(|(known, _)| known == name);
        group.and_then(|(_, held)| *held)
    }

    /// Temperature of a group less the grains' (K), both at the start, if heat passes into it.
    pub fn held(&self, group: usize) -> Option<f64> {
        self.groups[group].1.map(|held| held - self.start)
    }
}

/// Conductance of a contact.
#[derive(Clone, Copy, Debug)]
pub enum Conduction {
    /// The same for every contact that presses (W/K).
    Constant(f64),
    /// By the width of the contact.
    Hertz {
        /// k t, conductivity times thickness (W/K).
        conductivity: f64,
        /// E* t, t being the thickness (N/m): 1/E* = 2 (1 - nu^2)/E for two grains.
        modulus: f64,
        /// s, over which heat spreads in a body that is no grain (m), where that resists.
        spread: Option<f64>,
    },
}

impl Conduction {
    /// H (W/K) of a contact under a force (N); `radii` (m) belong to its grains.
    pub fn conductance(&self, force: f64, reduced: f64, radii: [Option<f64>; 2]) -> f64 {
        match *self {
            Conduction::Constant(conductance) => conductance,
            Conduction::Hertz {
                conductivity,
                modulus,
                spread,
            } => {
                let width = (4.0 * force * reduced / (PI * modulus)).sqrt();
                let grain = |radius: f64| (4.0 * radius / width.min(radius)).ln();
                let narrow = |spread: f64| -(PI * (width / spread).min(0.5)).sin().ln();
                let body = spread.map_or(0.0, narrow);
                let sides = radii.map(|radius| radius.map_or(body, grain));
                PI * conductivity / (sides[0] + sides[1])
            }
        }
    }
}
