//! The heat of a body: its vertices, the shares of its sources, and its results.

use fem_kernel::heat::{HeatBody, HeatField, HeatNumbers};
use fem_kernel::material::Elastic;
use fem_kernel::mesh::{Edge, Mesh};
use kit::ConfigError;
use kit::bounds::wider;
use kit::finding::heat_coarseness;
use kit::heat::factor_at;
use kit::keys::refuse_if;
use kit::table::LoadTable;
use protocol::larger;
use serde::{Deserialize, Serialize};

use crate::config::choice::{ContactEdge, Plane};
use crate::config::keys::FemConfig;

kit::results! {
    /// # Signals
    /// - `surface_temperature_max_k`: Highest temperature of the contact edge of a body.
    /// # Heat
    /// - `surface_temperature_peak_k`: Highest temperature that the contact edge of a body had.
    /// - `surface_temperature_peak_s`: When it had it.
    /// - `surface_temperature_peak_x_m`: Where it had it.
    /// - `heat_plastic_j`: Heat by plastic flow.
    /// - `heat_through_<edge>_j`: Heat that left a body through an edge with a condition; negative where it entered.
    /// - `heat_to_own_wheel_j`: Heat by friction that a body's own wheel took.
    /// - `heat_interface_j`: Heat that entered a body through its coupled surface.
}

/// Own steps between two steps of heat by default, at most, and the number of these steps in a run whose end is known, at least.
const EVERY: u64 = 100;
const STEPS: f64 = 100.0;

/// Share of the plastic work by default.
const PLASTIC: f64 = 0.9;

/// Layers in the first row of elements, were they equally thin.
const LAYERS: f64 = 64.0;

/// Most times of its heat that a vertex may pass on in a step of heat, where rounding takes a part of 1e-8; and most parts of a step.
const PASSED_MAX: f64 = 1e8;
const PARTS_MAX: f64 = 1e4;

/// Everything about the heat of a body that does not change.
#[derive(Clone, Debug)]
pub(crate) struct BodyHeat {
    pub(crate) body: HeatBody,
    /// The edge with its layers.
    pub(crate) surface: Edge,
    /// Temperature at the start (K).
    pub(crate) start: f64,
    /// Own steps from one step of heat to the next.
    pub(crate) every: u64,
    /// Shares of friction and of plastic flow that become heat.
    sources: [f64; 2],
    /// Share of the heat by friction that the wheel takes.
    wheel_share: f64,
    /// Factor on the yield stress over temperature.
    yields: LoadTable,
    /// Stress of an element that cannot expand, over its rise (Pa/K); 0 without expansion.
    stiffness: f64,
    edges: Vec<String>,
}

/// The heat of a body so far; nothing by default, for a body without.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct HeatState {
    pub(crate) field: HeatField,
    /// Heat by friction, the wheel's included, and by plastic flow (J).
    produced: [f64; 2],
    /// Heat that the wheel has taken (J).
    to_wheel: f64,
    /// Heat that has entered through the coupled surface (J).
    entered: f64,
    /// Heat that has come at each node of the upper edge and enters until the next exchange (J), and its rate (W).
    arriving: Vec<[f64; 2]>,
    /// Own steps up to the last step of heat, and the number of these.
    heated: u64,
    count: u64,
    /// Exchanges after the first one, own steps up to the last one, and the longest time between two (s).
    exchanges: u64,
    exchanged: u64,
    interval: f64,
    /// Temperatures of its answer (K), the largest change from one answer to the next, the lowest and the highest temperature answered.
    answered: Vec<f64>,
    jump: f64,
    range: Option<[f64; 2]>,
    /// Largest change of a factor on the yield stress in a step of heat, over what it was.
    pub(crate) yielding: f64,
    /// Loss by friction at each node of the upper edge that has become heat (J).
    slid: Vec<f64>,
    /// Loss by plastic flow since the start of the window that has become heat, by elements (J).
    #[serde(skip)]
    yielded: Vec<f64>,
}

impl BodyHeat {
    /// The heat of a body on this mesh, of this thickness (m).
    pub(super) fn new(
        config: &FemConfig,
        (mesh, elastic): (&Mesh, &Elastic),
        thickness: f64,
        total: Option<f64>,
    ) -> Result<Option<BodyHeat>, ConfigError> {
        let Some(heat) = &config.heat else {
            return Ok(None);
        };
        let (surface, row) = match config.mesh.contact_edge() {
            Some(ContactEdge::Bottom) => (Edge::Bottom, mesh.rows - 1),
            _ => (Edge::Top, 0),
        };
        let first = mesh.point(0, row)[1] - mesh.point(0, row + 1)[1];
        refuse_if(
            heat.finest_m.is_some_and(|finest| finest > first),
            "heat.finest_m",
            format!("is more than the {first:e} m of the first row of elements"),
            "lower it, or leave it out for a 64th of this row",
        )?;
        let numbers = HeatNumbers {
            conductivity: heat.conductivity_w_per_m_k,
            capacity: config.material.density_kg_per_m3 * heat.capacity_j_per_kg_k,
            thickness,
            finest: heat.finest_m.unwrap_or(first / LAYERS),
        };
        // In plane strain the expansion across the plane is held back, and pushes in the plane.
        let [c11, c12, _] = elastic.moduli();
        let across = match config.plane {
            Plane::Strain => 1.0 + config.material.poisson,
            Plane::Stress => 1.0,
        };
        let stiffness = (c11 + c12) * across * heat.alpha_per_k.unwrap_or(0.0);
        let new = match surface {
            Edge::Bottom => HeatBody::above_bottom,
            _ => HeatBody::new,
        };
        let tables = [&heat.conductivity_factor, &heat.capacity_factor];
        let tables = tables.map(|table| table.as_deref().unwrap_or_default());
        let mut body =
            new(mesh, numbers, &heat.conditions()?).over_temperature(heat.start_k, tables);
        if let Some(wheel) = &heat.wheel_half_space {
            let rise = wheel.start_k - heat.start_k;
            let wheel = [wheel.effusivity_w_s05_per_m2_k, rise];
            body = body.under_wheel((mesh, thickness), wheel);
        }
        let softening = heat.softening.as_ref();
        let hundredth = (total.unwrap_or(f64::INFINITY) / STEPS) as u64;
        let every = EVERY.min(hundredth).max(1);
        Ok(Some(BodyHeat {
            body,
            surface,
            start: heat.start_k,
            every: heat.every_steps.map_or(every, u64::from),
            sources: [
                heat.sources.friction.unwrap_or(1.0),
                heat.sources.plastic.unwrap_or(PLASTIC),
            ],
            wheel_share: heat.wheel_share,
            yields: softening.map_or_else(Vec::new, |of| of.yield_stress.clone()),
            stiffness,
            edges: heat.edges.keys().cloned().collect(),
        }))
    }

    /// Lets heat pass up to this number of own steps of this length (s), in whole intervals.
    pub(crate) fn pass(&self, state: &mut HeatState, (steps, step): (u64, f64)) {
        while steps - state.heated >= self.every {
            self.end(state, (state.heated + self.every, step));
        }
    }

    /// The same to the end, the last interval being shorter.
    pub(crate) fn end(&self, state: &mut HeatState, (steps, step): (u64, f64)) {
        if steps == state.heated {
            return;
        }
        let time = (steps - state.heated) as f64 * step;
        let upper = state.field.upper.iter_mut();
        for (waiting, [left, rate]) in upper.zip(&mut state.arriving) {
            let all = (*rate * time).abs() >= left.abs();
            let joules = if all { *left } else { *rate * time };
            *left -= joules;
            *waiting += joules;
        }
        self.body.advance(&mut state.field, time);
        (state.heated, state.count) = (steps, state.count + 1);
    }

    /// Largest change of a temperature from one exchange to the next, over the range of all, or one over the number of exchanges; 0 without heat.
    pub(crate) fn jump_rel(&self, state: &HeatState) -> f64 {
        if state.exchanges == 0 || state.entered == 0.0 {
            return 0.0;
        }
        let range = state.range.map_or(0.0, |[low, high]| high - low);
        let jump = if range > 0.0 { state.jump / range } else { 0.0 };
        larger(jump, 1.0 / state.exchanges as f64)
    }

    /// One over the number of steps of heat, 0 where each own step is one; or, if larger, the effect of a property that changed within a step.
    pub(crate) fn coarseness(&self, state: &HeatState) -> f64 {
        let (few, field) = (heat_coarseness(self.every, state.count), &state.field);
        let bent = field.bent / larger(field.extreme[0], f64::MIN_POSITIVE);
        larger(larger(few, bent), state.yielding)
    }

    /// Refuses steps of heat of this length (s) that temperatures cannot follow, or that never end.
    pub(crate) fn check_step(&self, time: f64) -> Result<(), ConfigError> {
        let [passed, parts] = self.body.swiftness(time);
        let wrong = passed.is_nan() || passed > PASSED_MAX || parts > PARTS_MAX;
        refuse_if(
            wrong,
            "heat",
            format!(
                "lets a point pass on {passed:.1e} times its heat down, and takes {parts:.1e} parts across, in a step of heat of {time:.1e} s; {PASSED_MAX:e} and {PARTS_MAX:e} are the most"
            ),
            "look at the units of conductivity, capacity, their factors and films, make heat.finest_m larger, or lower heat.every_steps",
        )
    }

    /// Takes heat (J) at these nodes of the upper edge, and returns their temperatures (K).
    pub(crate) fn exchange(
        &self,
        state: &mut HeatState,
        (nodes, heat): (&[[usize; 2]], &[f64]),
        (steps, step): (u64, f64),
    ) -> Vec<f64> {
        self.end(state, (steps, step));
        // The last interval of a run may be short, and heat of the one before still arrives then.
        let since = (steps - state.exchanged) as f64 * step;
        state.interval = larger(state.interval, since);
        state.exchanges += u64::from(steps > state.exchanged);
        state.exchanged = steps;
        state.arriving.resize(state.field.upper.len(), [0.0; 2]);
        for ([column, _], joules) in nodes.iter().zip(heat) {
            let [left, rate] = &mut state.arriving[*column];
            *left += joules;
            *rate = *left / larger(state.interval, step);
            state.entered += joules;
        }
        let rises = nodes.iter().map(|node| self.body.rise(&state.field, *node));
        let now: Vec<f64> = rises.map(|rise| self.start + rise).collect();
        for (kelvins, before) in now.iter().zip(&state.answered) {
            state.jump = larger(state.jump, (kelvins - before).abs());
        }
        for kelvins in &now {
            state.range = Some(wider(state.range, *kelvins));
        }
        state.answered.clone_from(&now);
        now
    }

    /// The factor on the yield stress of an element (column, row).
    pub(crate) fn yield_factor(&self, state: &HeatState, element: [usize; 2]) -> f64 {
        let rise = self.body.mean_rise(&state.field, element);
        factor_at(&self.yields, self.start + rise)
    }

    /// True where warmth expands the body.
    pub(crate) fn expands(&self) -> bool {
        self.stiffness != 0.0
    }

    /// Stress (Pa) that warmth would give an element (column, row) if it could not expand.
    pub(crate) fn thermal_stress(&self, state: &HeatState, element: [usize; 2]) -> f64 {
        self.stiffness * self.body.mean_rise(&state.field, element)
    }

    /// At the start.
    pub(crate) fn at_start(&self) -> HeatState {
        HeatState {
            field: self.body.at_start(),
            ..HeatState::default()
        }
    }

    /// Signals by name.
    pub(crate) fn signals(&self, state: &HeatState) -> [(String, f64); 1] {
        let upper = self.body.upper(&state.field).iter();
        let highest = upper.copied().fold(f64::NEG_INFINITY, larger);
        [("surface_temperature_max_k".into(), self.start + highest)]
    }

    /// Results by name; `lost` are the losses by friction and by plastic flow in the ledger (J).
    pub(crate) fn results(&self, state: &HeatState, lost: [f64; 2]) -> Vec<(String, f64)> {
        let [rise, x, t] = state.field.peak;
        let [friction, plastic] = state.produced;
        let into_wheel: f64 = state.field.conducted[self.edges.len()..].iter().sum();
        let named = [
            ("surface_temperature_peak_k", self.start + rise),
            ("surface_temperature_peak_s", t),
            ("surface_temperature_peak_x_m", x),
            ("heat_friction_j", friction),
            ("heat_plastic_j", plastic),
            ("heat_to_own_wheel_j", state.to_wheel + into_wheel),
            ("heat_interface_j", state.entered),
            ("heat_stored_j", self.stored(state)),
            ("heat_balance_rel", self.balance_rel(state, lost)),
        ];
        let through = self.edges.iter().zip(&state.field.conducted);
        let through = through.map(|(edge, joules)| (format!("heat_through_{edge}_j"), *joules));
        let named = named.map(|(name, value)| (name.to_string(), value));
        named.into_iter().chain(through).collect()
    }

    /// Heat that the body has gained since the start, with what waits and arrives (J).
    fn stored(&self, state: &HeatState) -> f64 {
        let field = &state.field;
        let waiting: f64 = field.upper.iter().chain(&field.inner).sum();
        let arriving: f64 = state.arriving.iter().map(|[left, _]| left).sum();
        self.body.stored(field) + waiting + arriving
    }

    /// Heat produced, less stored and conducted away, and what the shares of the losses and the heat produced differ by, over the sum of their sizes.
    pub(crate) fn balance_rel(&self, state: &HeatState, lost: [f64; 2]) -> f64 {
        let field = &state.field;
        let stored = self.stored(state);
        let conducted = field.conducted.iter().sum::<f64>() + state.to_wheel;
        let produced = state.produced.iter().sum::<f64>() + state.entered;
        let booked = (0..2).map(|k| (state.produced[k] - self.sources[k] * lost[k]).abs());
        let all = state.produced.iter().chain(&field.conducted);
        let all = all.chain([&stored, &state.to_wheel, &state.entered]);
        let size: f64 = all.map(|joules| joules.abs()).sum();
        // Written so that a NaN stays NaN.
        if size == 0.0 {
            return 0.0;
        }
        ((produced - stored - conducted).abs() + booked.sum::<f64>()) / size
    }
}

impl HeatState {
    /// Takes the losses by plastic flow in each element (J).
    pub(crate) fn yields(&mut self, heat: &BodyHeat, lost: impl ExactSizeIterator<Item = f64>) {
        let inner = &mut self.field.inner;
        inner.resize(lost.len(), 0.0);
        for (waiting, lost) in inner.iter_mut().zip(lost) {
            let joules = heat.sources[1] * lost;
            self.produced[1] += joules;
            *waiting += joules;
        }
    }

    /// Takes the losses by slip at each node since the start of the run (J), and the nodes that the wheel touches.
    pub(crate) fn rub(
        &mut self,
        heat: &BodyHeat,
        (slid, touches): (&[f64], impl Iterator<Item = bool>),
    ) {
        heat.body.meet(&mut self.field, touches);
        self.slid.resize(slid.len(), 0.0);
        let upper = self.field.upper.iter_mut();
        for ((waiting, before), slid) in upper.zip(&mut self.slid).zip(slid) {
            let joules = heat.sources[0] * (slid - *before);
            *before = *slid;
            self.produced[0] += joules;
            self.to_wheel += heat.wheel_share * joules;
            *waiting += (1.0 - heat.wheel_share) * joules;
        }
    }

    /// Numbers that can change a later bit.
    pub(crate) fn numbers(&self) -> impl Iterator<Item = &f64> {
        let sums = self.produced.iter().chain(&self.field.conducted);
        let sums = sums.chain([&self.to_wheel, &self.entered]);
        let arriving = self.arriving.iter().flatten();
        self.field.numbers().chain(sums).chain(arriving)
    }

    /// Begins a window.
    pub(crate) fn restore(&mut self, start: &HeatState) {
        self.clone_from(start);
        self.yielded.fill(0.0);
    }

    /// Takes the losses by plastic flow since the last call, in each element since the start of the window (J).
    pub(crate) fn yield_to(&mut self, heat: &BodyHeat, yielded: &[f64]) {
        let mut before = std::mem::replace(&mut self.yielded, yielded.to_vec());
        before.resize(yielded.len(), 0.0);
        let both = yielded.iter().zip(before);
        self.yields(heat, both.map(|(after, before)| after - before));
    }

    /// Takes the losses by slip at each node since the start of the run (J) with the nodes that the wheel touches, and goes on by this time (s).
    pub(crate) fn advance(
        &mut self,
        heat: &BodyHeat,
        rubbed: (&[f64], impl Iterator<Item = bool>),
        time: f64,
    ) {
        self.rub(heat, rubbed);
        heat.body.advance(&mut self.field, time);
        self.heated += heat.every;
        self.count += 1;
    }
}
