//! The way of a wheel that rolls over the grains.

use dem_kernel::bodies::Bodies;
use dem_kernel::step::state::GrainState;
use dem_kernel::step::{StepSummary, WheelTurn};
use kit::rolled::{ContactExtent, RolledPiece, RollingRecord};
use kit::wheel::WheelProgram;
use serde::{Deserialize, Serialize};

use crate::measure::rolled_layer;

/// Share of the friction limit from which a contact slides: sliding forces reach it within the tolerance of the solver.
const SLIDING: f64 = 0.999;

/// Turning of the wheel in a step from `start` to `end` (s); `loaded` is the time of its load.
pub fn turn(
    program: &WheelProgram,
    [start, end, loaded]: [f64; 3],
    step: f64,
    radius: f64,
) -> WheelTurn {
    let Some(rolling) = &program.rolling else {
        return WheelTurn::Held;
    };
    let rolled = |time| program.rolled_at(time);
    let along = rolling.direction();
    if let (Some(from), Some(to)) = (rolling.turned(rolled(start)), rolling.turned(rolled(end))) {
        return WheelTurn::Given(-along * (to - from) / step);
    }
    match (rolling.force(rolled(loaded)), rolling.inertia) {
        (Some(force), Some(inertia)) if rolled(end) > 0.0 => WheelTurn::Free {
            inverse_mass: radius * radius / inertia,
            brake: along * force,
        },
        _ => WheelTurn::Held,
    }
}

/// Record of a rolling wheel, and the losses so far by friction, dampers, bonds and the time scheme (J).
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct RolledWay {
    /// The record.
    pub record: RollingRecord,
    taken: [f64; 4],
}

impl RolledWay {
    /// Records a committed step, from `start` to `end` (s).
    pub fn record(
        &mut self,
        program: &WheelProgram,
        (bodies, state, step): (&Bodies, &GrainState, &StepSummary),
        [start, end]: [f64; 2],
    ) {
        let Some(rolling) = &program.rolling else {
            return;
        };
        let way = program.rolled_at(end) - program.rolled_at(start);
        let all = &state.ledger;
        let taken = [all.friction, all.damping, all.cohesion, all.numerical];
        let since: [f64; 4] = std::array::from_fn(|k| taken[k] - self.taken[k]);
        let [dissipated, losses @ ..] = since;
        self.taken = taken;
        if way <= 0.0 {
            return;
        }
        let along = rolling.direction();
        let slots = state.list.slots.iter();
        let on_wheel = slots.filter(|slot| bodies.is_wheel(slot.b as usize));
        let (mut creep_force, mut extent) = (0.0, ContactExtent::default());
        for slot in on_wheel {
            let [normal, tangential] = slot.pressure();
            creep_force += along * slot.force[1];
            if normal <= 0.0 {
                continue;
            }
            let x = state.centres[slot.a as usize][0];
            let before = along * rolling.apart(x, state.wheel.position[0]);
            let friction = state.law_of(bodies, [slot.a, slot.b]).friction;
            let sticks = tangential.abs() < SLIDING * friction * normal;
            extent.touch(before, normal, sticks);
        }
        let (ends, stick) = extent.ends_and_stick();
        let real = 1.0 - bodies.added_mass_rel;
        self.record.add(
            rolling,
            &RolledPiece {
                way,
                turned: -along * state.wheel.turn * (end - start),
                creep_force,
                force_x: -along * step.on_wheel[0],
                normal: step.on_wheel[1],
                dissipated,
                stick,
                ends,
                peak: None,
                layer: rolled_layer::measure(rolling, (bodies, state), ends, real),
                losses: Some(losses),
            },
        );
    }
}
