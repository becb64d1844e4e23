//! The temperatures of the grains, and the heat since the start.

use kit::heat::FluxMemory;
use protocol::larger;
use serde::{Deserialize, Serialize};

use crate::bodies::Bodies;
use crate::contact::loss::Loss;
use crate::law::Law;
use crate::law::heat::HeatLaw;
use crate::step::ledger::GrainLedger;

kit::results! {
    /// # Signals
    /// - `temperature_mean_k`: Mean temperature of the grains, by mass.
    /// - `temperature_max_k`: Highest temperature of a grain.
    /// # Heat
    /// - `temperature_end_k`: Mean temperature of the grains at the end, by mass.
    /// - `temperature_peak_k`: Highest temperature that a grain had at the end of a step.
    /// - `temperature_peak_s`: When it had it.
    /// - `temperature_peak_x_m`: Where it had it.
    /// - `temperature_peak_y_m`: Where it had it.
    /// - `heat_friction_j`: Heat by slip of contacts.
    /// - `heat_damping_j`: Heat by dampers of contacts.
    /// - `heat_impact_j`: Heat by impacts of rigid contacts.
    /// - `heat_bonds_j`: Heat by bonds that fail.
    /// - `heat_stored_j`: Heat that the grains, or a body, have gained since the start.
    /// - `heat_to_<group>_j`: Heat that went into the base, the lid, the wheel, a wall or a cluster of this name.
    /// - `half_space_<group>_k`: Temperature at the end of the surface of this body, which is a half-space for heat.
    /// - `heat_balance_rel`: Heat produced, less stored and conducted away, and less its share of the losses in the ledger, over the sum of their sizes.
}

/// Losses of a contact that may become heat (J).
#[derive(Clone, Copy, Debug)]
pub struct PairHeat {
    pair: [u32; 2],
    /// By friction, dampers, impacts and broken bonds.
    losses: [f64; 4],
}

impl PairHeat {
    /// Of this loss of a pair.
    pub fn of(pair: [u32; 2], loss: &Loss) -> PairHeat {
        PairHeat {
            pair,
            losses: [loss.friction, loss.damping, loss.impact, loss.cohesion],
        }
    }

    /// Heat by each (J).
    fn parts(&self, law: &HeatLaw) -> [f64; 4] {
        std::array::from_fn(|k| law.sources[k] * self.losses[k])
    }
}

/// The part of the heat that steps change.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Heat {
    /// Heat of the free grains since the start over m c (K): the rises of their temperatures where c is constant; empty without heat.
    pub contents: Vec<f64>,
    /// Heat since the start by friction, dampers, impacts and broken bonds (J).
    pub produced: [f64; 4],
    /// Heat that has left to each group of bodies that are no grains (J).
    pub conducted: Vec<f64>,
    /// Energy that contacts gained which were not solved to the end, and for which others have not made up yet (J).
    pub owed: f64,
    /// Loss in the dampers of driven clusters (J), which are no contacts: it warms nothing.
    pub drives: f64,
    /// Rises of the groups of bodies that are no grains (K), of those into which heat passes.
    pub held: Vec<Option<f64>>,
    /// Heat that each half-space has taken since the last conduction (J), and its flux memory up to then.
    pub half_spaces: Vec<(f64, FluxMemory)>,
    /// The highest content so far (K).
    pub peak: f64,
    /// Place and time of the highest content: x, y (m), t (s).
    pub peak_at: [f64; 3],
    /// Lowest rise of a grain after a conduction (K).
    pub lowest: f64,
    /// Largest difference that a capacity which changed in a conduction made to a rise (K).
    pub bent: f64,
    /// Steps and time (s) since the last conduction.
    pub waited: (u32, f64),
    /// Conductions so far.
    pub conductions: u64,
    /// Time of the last look at the highest temperature (s).
    pub seen: f64,
    /// Rises (K) that a coupler gives to the points of the boundary, NaN to others; empty where it gives none.
    pub beside: Vec<f64>,
    /// Of each of these points since it was last asked for: heat by conduction (J), conductance times time (J/K), heat by losses of contacts (J).
    pub given: Vec<[f64; 3]>,
    /// Contents of grains, and rises of groups and of the boundary's points that the contacts of the last step had, where temperature changes laws.
    felt: (Vec<f64>, Vec<Option<f64>>, Vec<f64>),
}

/// A body that takes heat: its number, and where it is a part of the boundary its two points there, with their shares.
#[derive(Clone, Copy, Debug)]
pub struct HeatTaker {
    pub(super) body: usize,
    points: Option<[(usize, f64); 2]>,
}

impl Heat {
    /// All grains at the temperature of the start.
    pub fn new(law: Option<&HeatLaw>, free: usize) -> Heat {
        law.map_or(Heat::default(), |law| {
            let held = (0..law.groups.len()).map(|group| law.held(group));
            let held = Vec::from_iter(held);
            Heat {
                contents: vec![0.0; free],
                conducted: vec![0.0; held.len()],
                half_spaces: vec![Default::default(); law.half_spaces.len()],
                felt: (Vec::new(), held.clone(), Vec::new()),
                held,
                ..Heat::default()
            }
        })
    }

    /// Takes rises (K) of points of the boundary. Returns the heat that each has taken since the last time (J), and then conductance times time of
    /// each (J/K). Where contacts gained more energy than they lost, the other points of that side make up for it, or later ones if none can.
    pub fn exchange(&mut self, bodies: &Bodies, points: &[usize], rises: &[f64]) -> Vec<f64> {
        let of = bodies.boundary_points();
        self.given.resize(of, [0.0; 3]);
        self.beside.resize(of, f64::NAN);
        let all = points.iter().zip(rises);
        all.for_each(|(point, rise)| self.beside[*point] = *rise);
        let disks = [bodies.glued(), bodies.base];
        let side = |point: usize| usize::from(bodies.surface.is_point_above(point, disks));
        let balance = |[passed, _, source]: [f64; 3]| larger(0.0, passed) + source;
        let mut sums = [[0.0; 2]; 2];
        for point in points {
            let balance = balance(self.given[*point]);
            let [gained, lost] = &mut sums[side(*point)];
            *gained += larger(0.0, balance);
            *lost += larger(0.0, -balance);
        }
        let left = sums.map(|[gained, lost]: [f64; 2]| {
            let paid = lost.min(gained);
            [gained, lost].map(|all| left_of(all, paid))
        });
        let (mut heat, mut per_kelvin) = (Vec::new(), Vec::new());
        for point in points {
            let given = std::mem::take(&mut self.given[*point]);
            let balance = balance(given);
            let [of_gained, of_lost] = left[side(*point)];
            heat.push(of_gained * larger(0.0, balance) - larger(0.0, -given[0]));
            per_kelvin.push(given[1]);
            self.given[*point][2] = -of_lost * larger(0.0, -balance);
        }
        [heat, per_kelvin].concat()
    }

    /// Every number that changes a later one.
    pub fn numbers(&self) -> impl Iterator<Item = f64> {
        let sums = self.produced.iter().chain(&self.conducted);
        let waited = [f64::from(self.waited.0), self.waited.1, self.owed];
        let exchanged = self.beside.iter().chain(self.given.iter().flatten());
        let all = self.contents.iter().chain(sums).chain(exchanged).copied();
        let held = self.held.iter().flatten();
        let held = held.filter(|_| !self.half_spaces.is_empty());
        let taken = self.half_spaces.iter().flat_map(|(waiting, memory)| {
            let remembered = memory.numbers().iter();
            std::iter::once(waiting).chain(remembered)
        });
        all.chain(waited).chain(held.chain(taken).copied())
    }

    /// Heat that the grains have gained since the start (J).
    pub fn stored(&self, bodies: &Bodies) -> f64 {
        let Some(law) = &bodies.heat else {
            return 0.0;
        };
        let grains = self.contents.iter().enumerate();
        let each = grains.map(|(grain, content)| bodies.heat_capacity(law, grain) * content);
        each.sum()
    }

    /// Temperatures of the free disks (K): those in clusters have the cluster's, NaN where no heat passes into it.
    pub fn temperatures(&self, law: &HeatLaw) -> impl Iterator<Item = f64> {
        let disks = self.contents.iter().enumerate();
        disks.map(|(disk, content)| match law.group(disk) {
            None => law.kelvins(*content),
            Some(group) => law.start + self.held[group].unwrap_or(f64::NAN),
        })
    }

    /// Mean temperature of the grains by mass, and the highest (K).
    pub fn mean_and_highest(&self, bodies: &Bodies, law: &HeatLaw) -> [f64; 2] {
        let disks = self.contents.iter().zip(&bodies.masses).enumerate();
        let grains = disks.filter(|(disk, _)| law.group(*disk).is_none());
        let [mut mass, mut sum, mut highest] = [0.0, 0.0, f64::NEG_INFINITY];
        for (_, (content, m)) in grains {
            let rise = law.capacity_factor.rise(*content);
            mass += m;
            sum += m * rise;
            highest = larger(highest, rise);
        }
        [sum / mass, highest].map(|rise| law.start + rise)
    }

    /// Its results, if there is a law of heat.
    pub fn results(&self, bodies: &Bodies, ledger: &GrainLedger) -> Vec<(String, f64)> {
        let Some(law) = &bodies.heat else {
            return Vec::new();
        };
        let [mean, _] = self.mean_and_highest(bodies, law);
        let [friction, damping, impact, bonds] = self.produced;
        let [x, y, t] = self.peak_at;
        let x = bodies.period.map_or(x, |period| period.inside(x));
        let named = [
            ("temperature_end_k", mean),
            ("temperature_peak_k", law.kelvins(self.peak)),
            ("temperature_peak_s", t),
            ("temperature_peak_x_m", x),
            ("temperature_peak_y_m", y),
            ("heat_friction_j", friction),
            ("heat_damping_j", damping),
            ("heat_impact_j", impact),
            ("heat_bonds_j", bonds),
            ("heat_stored_j", self.stored(bodies)),
            ("heat_balance_rel", self.balance_rel(bodies, ledger)),
        ];
        let to = law.groups.iter().zip(&self.conducted);
        let to = to.map(|((name, _), joules)| (format!("heat_to_{name}_j"), *joules));
        let named = named.map(|(name, value)| (name.to_string(), value));
        let surfaces = law.half_spaces.iter().filter_map(|of| {
            let name = format!("half_space_{}_k", law.groups[of.group].0);
            Some((name, law.start + self.held[of.group]?))
        });
        named.into_iter().chain(to).chain(surfaces).collect()
    }

    /// Heat produced, less stored and conducted away, and what the shares of the ledger's losses and the heat produced differ by, over the sum of their
    /// sizes; 0 without a law of heat.
    pub fn balance_rel(&self, bodies: &Bodies, ledger: &GrainLedger) -> f64 {
        let shares = bodies.heat.as_ref().map_or([0.0; 4], |law| law.sources);
        let lost = [
            ledger.friction,
            ledger.damping - self.drives,
            ledger.impact,
            ledger.cohesion,
        ];
        let booked = self.produced.iter().zip(shares.iter().zip(lost));
        let missed: f64 = booked
            .map(|(heat, (share, lost))| (heat - share * lost).abs())
            .sum();
        let stored = self.stored(bodies);
        let [gained, left] =
            [&self.produced[..], &self.conducted].map(|all| all.iter().sum::<f64>());
        let all = self.produced.iter().chain(&self.conducted).chain([&stored]);
        let size: f64 = all.map(|joules| joules.abs()).sum();
        // Written so that a NaN stays NaN.
        if size == 0.0 {
            return 0.0;
        }
        ((gained + self.owed - stored - left).abs() + missed) / size
    }

    /// Warms a body by the part of the impacts that the scheme loses in it (J), which belongs to no contact; only rigid contacts book it as impacts.
    /// It warms a body that lets no heat through as well, if `touching` grains do not take it.
    pub fn jolt(
        &mut self,
        bodies: &Bodies,
        body: usize,
        touching: impl Iterator<Item = usize> + Clone,
        joules: f64,
    ) {
        let Some(law) = bodies.heat.as_ref().filter(|_| !bodies.is_elastic()) else {
            return;
        };
        let heat = law.sources[2] * joules;
        self.produced[2] += heat;
        let count = touching.clone().count();
        // The scheme loses nothing in the boundary, which a coupler moves.
        let whole = |body| HeatTaker { body, points: None };
        if self.takes(law, whole(body)) || count == 0 {
            self.give(bodies, law, whole(body), heat);
        } else {
            touching.for_each(|grain| self.give(bodies, law, whole(grain), heat / count as f64));
        }
    }

    /// Heat (J) for a body.
    pub(super) fn give(&mut self, bodies: &Bodies, law: &HeatLaw, to: HeatTaker, joules: f64) {
        match law.group(to.body) {
            Some(group) => {
                self.conducted[group] += joules;
                let space = law.half_space(group);
                if let Some((waiting, _)) = space.map(|k| &mut self.half_spaces[k]) {
                    *waiting += joules;
                }
            }
            None => self.contents[to.body] += joules / bodies.heat_capacity(law, to.body),
        }
        for (point, share) in to.points.into_iter().flatten() {
            self.given[point][2] += share * joules;
        }
    }

    /// Heat through contacts of h (J/K) from a grain of this rise (K) into another body: each point of the boundary takes by its own rise.
    pub(super) fn pass(
        &mut self,
        (bodies, law): (&Bodies, &HeatLaw),
        to: HeatTaker,
        (h, rise, beside): (f64, f64, f64),
    ) {
        let whole = HeatTaker { points: None, ..to };
        self.give(bodies, law, whole, h * (rise - beside));
        for (point, share) in to.points.into_iter().flatten() {
            let h = share * h;
            self.given[point][0] += h * (rise - self.beside[point]);
            self.given[point][1] += h;
        }
    }

    /// A body as it takes heat from a disk with its centre here (m); `surface` are the points of the surface.
    pub(super) fn taker(
        &self,
        bodies: &Bodies,
        body: usize,
        (centre, surface): ([f64; 2], &[[f64; 2]]),
    ) -> HeatTaker {
        let glued = bodies
            .glued_index(body)
            .map(|point| [(point, 1.0), (point, 0.0)]);
        let on_segment = || {
            let segment = bodies.segment_index(body)?;
            let foot = bodies.surface.foot(segment, surface, centre);
            let foot = bodies.surface.on_boundary(foot, bodies.glued());
            let [first, second] = foot.points.map(|point| point as usize);
            Some([(first, 1.0 - foot.share), (second, foot.share)])
        };
        let given = |points: &[(usize, f64); 2]| !self.beside[points[0].0].is_nan();
        let coupled = !self.beside.is_empty();
        let points = coupled.then(|| glued.or_else(on_segment)).flatten();
        HeatTaker {
            body,
            points: points.filter(given),
        }
    }

    /// Rise of a body beside the grains (K), if heat passes into it.
    pub(super) fn beside(&self, law: &HeatLaw, of: HeatTaker) -> Option<f64> {
        beside_of(law, (&self.held, &self.beside), of)
    }

    /// Keeps the temperatures of a step's start for its contacts, where they change laws.
    pub(super) fn feel(&mut self) {
        self.felt.0.clone_from(&self.contents);
        self.felt.1.clone_from(&self.held);
        self.felt.2.clone_from(&self.beside);
    }

    /// The law of a pair that is in contact: at the mean of the temperatures of two bodies that take heat, or at the temperature of one.
    pub(super) fn softened(
        &self,
        bodies: &Bodies,
        pair: [usize; 2],
        place: ([f64; 2], &[[f64; 2]]),
    ) -> Option<Law> {
        let law = bodies.heat.as_ref()?;
        let softening = law.softening.as_ref()?;
        let (contents, held, beside) = &self.felt;
        let rise = |body: usize| match law.group(body) {
            None => {
                let content = contents.get(body).copied().unwrap_or(0.0);
                Some(law.capacity_factor.rise(content))
            }
            Some(_) => beside_of(law, (held, beside), self.taker(bodies, body, place)),
        };
        let mean = match pair.map(rise) {
            [Some(a), Some(b)] => 0.5 * (a + b),
            [a, b] => a.or(b).unwrap_or(0.0),
        };
        let cold = bodies.law_of(pair[0], pair[1]);
        Some(softening.at(cold, [law.start + mean, law.start]))
    }

    /// True for a grain, and for a body into which heat passes.
    fn takes(&self, law: &HeatLaw, body: HeatTaker) -> bool {
        law.group(body.body).is_none() || self.beside(law, body).is_some()
    }

    /// Keeps the highest temperature so far, with its place and time (s).
    pub fn see_peak(&mut self, centres: &[[f64; 2]], time: f64) {
        self.seen = time;
        for (content, [x, y]) in self.contents.iter().zip(centres) {
            if *content > self.peak {
                (self.peak, self.peak_at) = (*content, [*x, *y, time]);
            }
        }
    }

    /// Warms the bodies of the contacts of a step by their losses. A contact that the solver has not solved to the end may gain energy where others
    /// lose it. Its grains give back at most what they have gained; the other contacts make up for the rest, now or in the next steps.
    pub(super) fn warm(
        &mut self,
        bodies: &Bodies,
        law: &HeatLaw,
        contacts: &[PairHeat],
        places: [&[[f64; 2]]; 2],
    ) {
        let mut lost = 0.0;
        for of in contacts {
            let parts = of.parts(law);
            for (sum, part) in self.produced.iter_mut().zip(parts) {
                *sum += part;
            }
            let joules: f64 = parts.iter().sum();
            lost += joules.max(0.0);
            if joules < 0.0 {
                for (body, share) in self.sides(bodies, law, of, places) {
                    self.owed += self.give_back(bodies, law, body, -share * joules);
                }
            }
        }
        let paid = self.owed.min(lost);
        self.owed -= paid;
        let left = left_of(lost, paid);
        for of in contacts {
            let joules: f64 = of.parts(law).iter().sum();
            if joules > 0.0 {
                for (body, share) in self.sides(bodies, law, of, places) {
                    self.give(bodies, law, body, left * share * joules);
                }
            }
        }
    }

    /// The bodies of a contact that take heat, with the shares of its heat.
    fn sides(
        &self,
        bodies: &Bodies,
        law: &HeatLaw,
        of: &PairHeat,
        [centres, surface]: [&[[f64; 2]]; 2],
    ) -> impl Iterator<Item = (HeatTaker, f64)> + use<> {
        let place = (centres[of.pair[0] as usize], surface);
        let pair = of.pair.map(|body| self.taker(bodies, body as usize, place));
        let shares = match pair.map(|body| self.takes(law, body)) {
            [true, true] => [0.5, 0.5],
            [true, false] => [1.0, 0.0],
            [false, _] => [0.0, 1.0],
        };
        let all = pair.into_iter().zip(shares);
        all.filter(|(_, share)| *share > 0.0)
    }

    /// Takes heat (J) from a body, from a grain at most what it has gained since the start; returns what is missing.
    fn give_back(&mut self, bodies: &Bodies, law: &HeatLaw, from: HeatTaker, joules: f64) -> f64 {
        let gained = match law.group(from.body) {
            Some(_) => joules,
            None => self.contents[from.body] * bodies.heat_capacity(law, from.body),
        };
        let taken = joules.min(gained.max(0.0));
        self.give(bodies, law, from, -taken);
        joules - taken
    }
}

/// The part of a heat that is left when some of it makes up for contacts that gained energy.
fn left_of(all: f64, paid: f64) -> f64 {
    if paid > 0.0 { 1.0 - paid / all } else { 1.0 }
}

/// Rise of a body (K) by the rises of groups and of the boundary's points (K), if heat passes into it.
fn beside_of(
    law: &HeatLaw,
    (held, beside): (&[Option<f64>], &[f64]),
    of: HeatTaker,
) -> Option<f64> {
    let mean = |points: [(usize, f64); 2]| {
        let parts = points.map(|(point, share)| share * beside[point]);
        parts[0] + parts[1]
    };
    let group = law.group(of.body)?;
    of.points.map(mean).or(held[group])
}

impl Bodies {
    /// m c of a grain (J/K), m without the mass that `mass_scale` adds.
    pub fn heat_capacity(&self, law: &HeatLaw, grain: usize) -> f64 {
        law.capacity * (1.0 - self.added_mass_rel) * self.masses[grain]
    }
}
