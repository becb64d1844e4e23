//! The rigid wheel of a scenario.

use kit::wheel::WheelProgram;

use crate::element::body::Body;
use crate::mesh::{Edge, Mesh, circle_drop};

/// Mass, face, friction and damping of a wheel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WheelNumbers {
    /// Mass (kg).
    pub mass: f64,
    /// Radius of the face (m); 0 = flat.
    pub radius: f64,
    /// Coefficient of friction.
    pub friction: f64,
    /// True where friction acts before the sideways motion, too.
    pub friction_while_loading: bool,
    /// Mass damping until the sideways motion (1/s).
    pub start_damping: f64,
}

/// Wheel, its load and its friction: the data that do not change during a run.
#[derive(Clone, Debug)]
pub struct Wheel {
    /// Load and motion over time.
    pub program: WheelProgram,
    pub(super) numbers: WheelNumbers,
    /// Positions of the nodes of the upper edge (m).
    pub(super) points: Vec<[f64; 2]>,
    /// Beginning of the y components in a row of nodes.
    pub(super) stride: usize,
    /// Lowest point of the face when it just touches the undeformed body (m).
    pub(super) first_height: f64,
    /// The last step that ends before the sideways motion starts.
    pub motion_step: u64,
    pub(super) step: f64,
}

impl Wheel {
    /// The wheel of a scenario, touching the undeformed body.
    pub fn new(
        program: WheelProgram,
        numbers: WheelNumbers,
        mesh: &Mesh,
        body: &Body,
        step: f64,
    ) -> Wheel {
        let points = mesh.surface_points(Edge::Top);
        Wheel {
            numbers,
            first_height: first_height(numbers.radius, &points),
            points,
            stride: body.layout.stride,
            // With the margin, rounding does not move a start at a multiple of the step by one step.
            motion_step: (program.motion_start() / step + 1e-6) as u64,
            program,
            step,
        }
    }

    /// Mass damping that is added at the end of a step (1/s).
    pub fn damping_at(&self, step: u64) -> f64 {
        if step <= self.motion_step {
            self.numbers.start_damping
        } else {
            0.0
        }
    }

    /// Coefficient of friction at the end of a step.
    pub(super) fn friction_at(&self, step: u64) -> f64 {
        if self.numbers.friction_while_loading || step >= self.motion_step {
            self.numbers.friction
        } else {
            0.0
        }
    }

    /// Load at the end of a step (N).
    pub(super) fn load_at(&self, step: u64) -> f64 {
        self.program.load_at(step as f64 * self.step)
    }

    /// Sideways displacement D at the end of a step (m).
    pub(super) fn lateral_at(&self, step: u64) -> f64 {
        self.program.displacement_at(step as f64 * self.step)
    }
}

/// Lowest point of the face when it just touches the points (m), the wheel standing over x = 0.
fn first_height(radius: f64, points: &[[f64; 2]]) -> f64 {
    let below = points
        .iter()
        .filter(|p| radius == 0.0 || p[0].abs() < radius);
    let touching = below.map(|[x, y]| y - circle_drop(radius, *x));
    touching.fold(f64::NEG_INFINITY, f64::max)
}
