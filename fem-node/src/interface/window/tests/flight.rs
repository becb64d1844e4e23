//! Bodies that fly or glide freely: no scenario can describe them, so their supports are removed here.

use std::collections::BTreeMap;

use fem_kernel::integrate::integrator::Integrator;
use fem_kernel::integrate::state::NodalState;
use fem_kernel::mesh::Edge;
use fem_kernel::wheel::state::WheelState;
use kit::read_config;
use protocol::Setting;
use serde_json::{Value, json};

use crate::interface::window::WindowRun;
use crate::interface::window::committed::Committed;
use crate::interface::window::extent::WindowInput;
use crate::interface::window::team::Team;
use crate::model::Model;

const YOUNG: f64 = 102.5e9;
const DENSITY: f64 = 7800.0;
const THICKNESS: f64 = 1e-3;

/// A body alone, step by step.
struct Flight {
    model: Model,
    integrator: Integrator,
    team: Team,
    run: WindowRun,
    committed: Committed,
}

impl Flight {
    /// Without the supports of the lower edge in these components.
    fn new(config: &Value, freed: &[usize]) -> Flight {
        let setting = Setting {
            participant: "bar".into(),
            seed: 0,
            thickness_m: THICKNESS,
            threads: 1,
            fields: None,
            cache: None,
        };
        let config = read_config(config).expect("the keys are valid");
        let mut model = Model::new(&config, &setting).expect("the body is valid");
        for node in model.mesh.edge(Edge::Bottom) {
            for component in freed {
                let (at, mass) = (
                    model.body.layout.index(node, *component),
                    model.body.node_mass(node),
                );
                model.body.mass[at] = mass;
                model.body.inverse_mass[at] = 1.0 / mass;
            }
        }
        let wheel = WheelState::at_rest(model.wheel.as_ref().expect("it has one"));
        Flight {
            integrator: Integrator::new(&model.body, model.scheme, None, 1),
            team: Team::new(1).expect("its own thread"),
            run: WindowRun::new(&model, &NodalState::at_rest(&model.body)),
            committed: Committed {
                state: NodalState::at_rest(&model.body),
                wheel: Some(wheel),
                ..Committed::default()
            },
            model,
        }
    }

    fn step(&mut self) {
        let input = WindowInput {
            substeps: 1,
            ..WindowInput::default()
        };
        let committed = &mut self.committed;
        self.run.run(
            &self.model,
            (&mut self.integrator, &self.team),
            committed,
            &input,
        );
        let run = self.run.wheel.as_ref().expect("it has one");
        committed.state.resume(&self.run.fields.state);
        committed.wheel = Some(run.state.clone());
        committed.steps += 1;
    }

    fn wheel(&self) -> &WheelState {
        self.committed.wheel.as_ref().expect("it has one")
    }

    fn time(&self) -> f64 {
        self.committed.steps as f64 * self.model.scheme.step
    }

    /// Mass moving in x or y (kg), and its momentum (kg m/s).
    fn momentum(&self, component: usize) -> [f64; 2] {
        let layout = self.model.body.layout;
        let moving = |at: &usize| at % layout.row_len() / layout.stride == component;
        let add = |[mass, momentum]: [f64; 2], at: usize| {
            let m = self.model.body.mass[at];
            [mass + m, momentum + m * self.committed.state.v[at]]
        };
        (0..layout.len()).filter(moving).fold([0.0, 0.0], add)
    }

    /// Mean velocity in x or y (m/s).
    fn velocity(&self, component: usize) -> f64 {
        let [mass, momentum] = self.momentum(component);
        momentum / mass
    }
}

/// Problem: an elastic bar of length L, laterally confined, flies with v0 against a rigid wall that is at rest.
///
/// ```text
///   ////////  wall (a wheel of 1000 t)
///    ______
///   |  ^   |  L, rho, M = lambda + 2 mu, c = sqrt(M/rho)
///   |__|v0_|
/// ```
///
/// Exact: contact lasts 2 L/c under the constant force rho c v0 A, then the bar flies back with -v0.
/// Source: d'Alembert's solution (Saint-Venant 1883; Johnson, Contact Mechanics, 1985, ch. 11).
/// Tolerance: the wave front is as wide as a few elements; the errors fall with their size.
fn impact(elements: usize) -> [f64; 3] {
    let (length, v0) = (1e-2, 1.0);
    let size = length / elements as f64;
    let modulus = YOUNG * 0.7 / (1.3 * 0.4);
    let c = (modulus / DENSITY).sqrt();
    let mut bar = Flight::new(
        &json!({
            "base": "roller", "sides": "fixed_x",
            "mesh": {"width_m": size, "height_m": length, "size_m": size},
            "material": {"young_pa": YOUNG, "poisson": 0.3, "density_kg_per_m3": DENSITY},
            "time": {"step_s": "auto", "damping": 0.5, "safety": 0.99},
            "wheel": {"load_n": 0.0, "mass_kg": 1e6, "ramp_s": 0.0, "hold_s": 1.0},
            "contact": {"friction": 0.0},
        }),
        &[1],
    );
    for (v, w) in bar
        .committed
        .state
        .v
        .iter_mut()
        .zip(&bar.model.body.inverse_mass)
    {
        *v = if *w > 0.0 { v0 } else { 0.0 };
    }
    let (mut last, mut impulse) = (0.0, 0.0);
    while bar.time() < 4.0 * length / c {
        bar.step();
        let force = bar.wheel().force()[1];
        if force > 0.0 {
            last = bar.time();
        }
        if (0.2..1.8).contains(&(bar.time() * c / length)) {
            impulse += force * bar.model.scheme.step;
        }
    }
    let plateau = impulse / (1.6 * length / c);
    [
        last * c / (2.0 * length) - 1.0,
        plateau / (DENSITY * c * v0 * size * THICKNESS) - 1.0,
        -bar.velocity(1) / v0 - 1.0,
    ]
}

#[test]
fn a_bar_rebounds_from_a_rigid_wall() {
    let [coarse, fine] = [impact(50), impact(200)];
    for (name, error, tolerance) in [
        ("contact time", fine[0], 1e-3),
        ("plateau", fine[1], 1e-3),
        ("rebound", fine[2], 3e-3),
    ] {
        assert!(error.abs() < tolerance, "{name}: {error:e}");
    }
    for (name, k) in [("plateau", 1), ("rebound", 2)] {
        let ratio = fine[k] / coarse[k];
        assert!(ratio.abs() < 0.4, "{name}: {ratio} on a mesh 4 times finer");
    }
}

/// Problem: a block on a smooth floor, pressed by a wheel that starts to move with the speed V.
///
/// ```text
///    ===== -> V, F      wheel, friction mu
///    |   |
///    |___|              smooth floor
/// ```
///
/// Exact: while it slides the block gains mu F t/m; at t* = m V/(mu F) it moves with the wheel. Source: Newton and Coulomb. Tolerance: the load
/// oscillates by 0.3 % when the motion starts; 1 % of V for the shear waves that remain.
#[test]
fn a_block_slides_then_follows_the_wheel() {
    let (load, friction, speed, frequency) = (10.0, 0.03, 0.1, 10.0);
    let amplitude = speed / (std::f64::consts::TAU * frequency);
    let mut block = Flight::new(
        &json!({
            "base": "roller", "sides": "free",
            "mesh": {"width_m": 4e-3, "height_m": 4e-3, "size_m": 1e-3},
            "material": {"young_pa": YOUNG, "poisson": 0.3, "density_kg_per_m3": DENSITY},
            "time": {"step_s": "auto", "damping": 0.75, "start_mass_damping_per_s": 3e5},
            "wheel": {"load_n": load, "mass_kg": 1e-3, "amplitude_m": amplitude,
                      "frequency_hz": frequency, "ramp_s": 1e-4, "hold_s": 5e-4, "cycles": 1.0},
            "contact": {"friction": friction},
        }),
        &[0],
    );
    let start = 6e-4;
    let [mass, _] = block.momentum(0);
    let follows = mass * speed / (friction * load);
    let mut until = |share: f64| {
        while block.time() < start + share * follows {
            block.step();
        }
        let wheel = block.model.wheel.as_ref().expect("it has one");
        let signals = BTreeMap::from_iter(block.wheel().signals(wheel));
        (block.time(), block.velocity(0), signals["sn_pct"])
    };
    let ((t_a, v_a, _), (t_b, v_b, sliding)) = (until(0.3), until(0.9));
    assert_eq!(sliding, 100.0);
    let error = (v_b - v_a) / (t_b - t_a) * mass / (friction * load) - 1.0;
    assert!(error.abs() < 5e-4, "{error:e}");
    let (_, v, _) = until(2.0);
    assert!((v / speed - 1.0).abs() < 0.01, "{v}");
}
