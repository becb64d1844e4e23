//! An explicit body with its committed state and the current window.

use std::cell::OnceCell;

use fem_kernel::integrate::integrator::Integrator;
use fem_kernel::integrate::state::NodalState;
use fem_kernel::statics::history::equilibrium;
use fem_kernel::wheel::state::WheelState;
use protocol::Setting;

use crate::config::choice::Start;
use crate::config::keys::FemConfig;
use crate::error::FemError;
use crate::interface::Interface;
use crate::interface::window::WindowRun;
use crate::interface::window::committed::Committed;
use crate::interface::window::extent::WindowInput;
use crate::interface::window::team::Team;
use crate::model::Model;
use crate::model::heat::BodyHeat;
use crate::output::ledger::Ledger;
use crate::output::probe;
use crate::output::snapshot::Snapshots;

/// An elastic body in explicit dynamics.
///
/// With the fields of a snapshot NAME a body under a wheel writes `<participant>-NAME-profile.csv`: x_m, pressure_pa, shear_pa, status. The profile
/// of `hold` belongs to the moment before the wheel starts to move sideways.
pub struct FemNode {
    /// Mesh, body, scheme and loads.
    pub model: Model,
    pub(super) snapshots: Snapshots,
    /// Never the global threads: their number would ignore the setting.
    pub(super) team: Team,
    pub(super) integrator: Integrator,
    pub(crate) interface: Interface,
    pub(super) committed: Committed,
    pub(crate) run: WindowRun,
    /// Index and input of the last window, until it is committed.
    pub(super) pending: Option<(u64, WindowInput)>,
    /// Rows of nodes whose motion each report needs.
    pub(super) reported_rows: Vec<usize>,
    /// The committed state as a whole, computed at the first request while it is in pieces.
    pub(super) gathered: OnceCell<NodalState>,
}

impl FemNode {
    /// Builds the body: undeformed, at rest or with its initial velocities, or in equilibrium with its wheel.
    pub fn new(config: &FemConfig, setting: &Setting) -> Result<FemNode, FemError> {
        let model = Model::new(config, setting)?;
        let (state, wheel) = start_state(&model, config)?;
        let mut node = FemNode::starting_from(model, state, setting)?;
        node.committed.wheel = wheel;
        Ok(node)
    }

    /// A body without a wheel that starts from this state, whose internal forces follow from its displacements.
    pub fn starting_from(
        model: Model,
        mut state: NodalState,
        setting: &Setting,
    ) -> Result<FemNode, FemError> {
        let heat = model.heat.as_ref().map(BodyHeat::at_start);
        let mut heat = heat.unwrap_or_default();
        model.warm(&mut heat, &mut state);
        heat.yielding = 0.0;
        let threads = setting.threads.max(1);
        Ok(FemNode {
            snapshots: Snapshots::new(setting),
            team: Team::new(threads)?,
            integrator: Integrator::new(&model.body, model.scheme, model.law, threads),
            interface: Interface::default(),
            run: WindowRun::new(&model, &state),
            committed: Committed {
                state,
                reactions: vec![[0.0; 2]; model.motions.len()],
                heat,
                ..Committed::default()
            },
            pending: None,
            reported_rows: probe::reported_rows(&model),
            gathered: OnceCell::new(),
            model,
        })
    }

    /// The committed state.
    pub fn state(&self) -> &NodalState {
        let (partition, state) = (&self.run.partition, &self.committed.state);
        if !partition.is_ahead {
            return state;
        }
        self.gathered.get_or_init(|| partition.gathered(state))
    }

    /// Gathers the committed state from the pieces, if any.
    pub(super) fn catch_up(&mut self) {
        self.run.partition.catch_up(&mut self.committed.state);
    }

    /// The energies up to the committed state.
    pub fn ledger(&self) -> &Ledger {
        &self.committed.ledger
    }
}

/// The body undeformed and the wheel just touching it, or both in equilibrium under the full load.
fn start_state(
    model: &Model,
    config: &FemConfig,
) -> Result<(NodalState, Option<WheelState>), FemError> {
    let wheel = model.wheel.as_ref();
    if wheel.is_none() || config.start == Start::Ramp {
        let mut state = NodalState::at_rest_under(&model.body, model.law.as_ref());
        for (index, velocity) in &model.initial_velocity {
            state.v[*index] = *velocity;
        }
        model.body.layout.repeat_period(&mut state.v);
        return Ok((state, wheel.map(WheelState::at_rest)));
    }
    let start = equilibrium(&model.static_problem(), config.static_loads().as_ref())?;
    let resting = wheel.zip(start.contact).map(|(wheel, contact)| {
        WheelState::resting(wheel, contact.approach, contact.node_contacts())
    });
    Ok((start.state, resting))
}
