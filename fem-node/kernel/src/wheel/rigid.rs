//! The rigid wheel of a scenario.

use kit::rolling::nearest_image;
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
    /// Mass damping until the motion along x (1/s).
    pub start_damping: f64,
    /// Thickness of the body (m).
    pub thickness: f64,
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
    /// The last step that ends before the motion along x starts.
    pub motion_step: u64,
    pub(super) step: f64,
    /// Surfaces of the nodes of the upper edge (m2).
    pub areas: Vec<f64>,
    /// Distance along x after which the body repeats (m), if it does.
    pub(super) period: Option<f64>,
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
        let (_, lengths) = mesh.surface(Edge::Top);
        let areas = lengths.iter().map(|length| length * numbers.thickness);
        let start = program.displacement_at(0.0);
        let period = mesh.period();
        let from_start = |p: &[f64; 2]| [nearest_image(p[0] - start, period), p[1]];
        let below = points.iter().map(from_start);
        Wheel {
            numbers,
            first_height: first_height(numbers.radius, below),
            areas: areas.collect(),
            period,
            points,
            stride: body.layout.stride,
            // With the margin, rounding does not move a start at a multiple of the step by one step.
            motion_step: (program.motion_start() / step + 1e-6) as u64,
            program,
            step,
        }
    }

    /// Abscissa of its centre while it is loaded (m).
    pub fn start(&self) -> f64 {
        self.program.displacement_at(0.0)
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

    /// Sideways displacement D, or the abscissa of the centre of a rolling wheel, at the end of a step (m).
    pub(super) fn lateral_at(&self, step: u64) -> f64 {
        self.program.displacement_at(step as f64 * self.step)
    }

    /// Distance rolled at the end of a step (m).
    pub(super) fn rolled_at(&self, step: u64) -> f64 {
        self.program.rolled_at(step as f64 * self.step)
    }

    /// Length of the face that rolls off in the step that begins after `step`, towards +x (m), where the spin is prescribed.
    pub(super) fn turn_over(&self, step: u64) -> Option<f64> {
        let Some(rolling) = &self.program.rolling else {
            return Some(0.0);
        };
        let turned = |step| rolling.turned(self.rolled_at(step));
        Some(rolling.direction() * (turned(step + 1)? - turned(step)?))
    }

    /// Gap of a node at this place, seen from the lowest point of a round face (m).
    pub(super) fn gap(&self, [x, y]: [f64; 2]) -> f64 {
        let x = nearest_image(x, self.period);
        round_gap(self.numbers.radius, [x, y]).0
    }

    /// The free spin of a wheel: its mass I/R^2 (kg) at the face, and the braking force at the end of a step, towards +x (N).
    pub(super) fn spin(&self, step: u64) -> Option<[f64; 2]> {
        let rolling = self.program.rolling.as_ref()?;
        let brake = rolling.force(self.rolled_at(step))?;
        let radius = self.numbers.radius;
        Some([
            rolling.inertia? / (radius * radius),
            rolling.direction() * brake,
        ])
    }
}

/// Gap of a point, seen from the lowest point of a round face, and its distance from the centre (m): distance - radius without the cancellation on a
/// large wheel.
pub(super) fn round_gap(radius: f64, [x, y]: [f64; 2]) -> (f64, f64) {
    let distance = x.hypot(y - radius);
    let gap = (x * x + y * y - 2.0 * radius * y) / (distance + radius);
    (gap, distance)
}

/// Lowest point of the face when it just touches the points (m), the wheel standing over x = 0.
fn first_height(radius: f64, points: impl Iterator<Item = [f64; 2]>) -> f64 {
    let below = points.filter(|p| radius == 0.0 || p[0].abs() < radius);
    let touching = below.map(|[x, y]| y - circle_drop(radius, x));
    touching.fold(f64::NEG_INFINITY, f64::max)
}
