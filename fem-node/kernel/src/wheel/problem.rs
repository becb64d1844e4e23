//! Data of the contact problem of one step.

/// A node of the upper edge between t_n and t_n+1.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct NodeMotion {
    /// Position without displacement (m).
    pub(super) point: [f64; 2],
    /// Displacement at t_n (m).
    pub(super) now: [f64; 2],
    /// Displacement at t_n+1 without contact forces at t_n (m).
    pub(super) free: [f64; 2],
    /// Displacement at t_n+1 for each unit of force at t_n (m/N), zero where supported.
    pub(super) weight: [f64; 2],
}

/// The wheel between t_n and t_n+1.
#[derive(Clone, Copy, Debug)]
pub(crate) struct WheelStep {
    /// Lowest point of the face at t_n (m).
    pub(super) height: f64,
    /// Lowest point at t_n+1 without contact forces at t_n (m).
    pub(super) free_height: f64,
    /// Vertical displacement at t_n+1 for each unit of force at t_n (m/N).
    pub(super) weight: f64,
    /// Sideways displacement, or the abscissa of the centre of a rolling wheel, at t_n and t_n+1 (m).
    pub(super) lateral: [f64; 2],
    /// Length of the face that rolls off from t_n to t_n+1, towards +x, without contact forces at t_n (m).
    pub(super) turn: f64,
    /// Its change for each unit of tangential force on the nodes (m/N): 0 where the spin is prescribed.
    pub(super) turn_weight: f64,
    /// Distance along x after which the body repeats (m), if it does.
    pub(super) period: Option<f64>,
    /// Coefficient of friction.
    pub(super) friction: f64,
}
