//! Problem: plane P and S waves along a periodic strip of N one-point elements, one row high and held across the direction of
//! travel. Each wave number k is a separate run.
//!
//! ```text
//!   = o---o---o---o---o---o =      u(x, t) = A Re exp i(k x - omega t)
//!   = o---o---o---o---o---o =      k dx = 2 pi n/N
//! ```
//!
//! Exact: the strip is a chain of masses rho dx and springs M/dx, with Omega = (2 c h/dx) sin(k dx/2) for a step h. In each
//! step the scheme multiplies a wave by z, z^2 - (2 - (b+1/2) Omega^2) z + 1 - (b-1/2) Omega^2 = 0, so
//!
//! ```text
//! |z|^2       = 1 - (b-1/2) Omega^2
//! cos omega h = (1 - (b+1/2) Omega^2/2) / |z|        b = 1/2: omega h = 2 asin((c h/dx) sin(k dx/2))
//! ```
//!
//! Source: Belytschko, Liu, Moran 2000, section 6.5 (b = 1/2); trace and determinant in `fem_kernel::spectrum`.
//! Tolerance: 1e-10 for the phase of a step and 1e-10 for the decay, the rounding of 400 steps.

use std::f64::consts::TAU;

use fem_node::FemNode;
use protocol::Node;
use serde_json::{Value, json};

use crate::fem_bodies::{confined_modulus, node, set_in_motion, window};

/// Elements in the strip.
pub const COLUMNS: usize = 40;

/// Size of an element (m).
pub const SIZE: f64 = 1e-4;

const DENSITY: f64 = 7800.0;

/// The direction in which the nodes move.
#[derive(Clone, Copy, Debug)]
pub enum Wave {
    /// Along the strip.
    P,
    /// Across it.
    S,
}

impl Wave {
    /// Speed of long waves (m/s).
    pub fn speed(self) -> f64 {
        let modulus = match self {
            Wave::P => confined_modulus(),
            Wave::S => 102.5e9 / 2.6,
        };
        (modulus / DENSITY).sqrt()
    }

    /// The strip in which the wave travels, with `damping` as b.
    pub fn strip(self, damping: f64) -> Value {
        let held = match self {
            Wave::P => json!({"displacement_m": ["free", 0.0]}),
            Wave::S => json!({"displacement_m": [0.0, "free"]}),
        };
        json!({
            "base": "free",
            "mesh": {"width_m": COLUMNS as f64 * SIZE, "height_m": SIZE, "size_m": SIZE, "periodic_x": true},
            "material": {"young_pa": 102.5e9, "poisson": 0.3, "density_kg_per_m3": DENSITY},
            "time": {"step_s": "auto", "damping": damping},
            "boundary": {"top": held.clone(), "bottom": held},
        })
    }

    fn component(self) -> usize {
        match self {
            Wave::P => 0,
            Wave::S => 1,
        }
    }
}

/// The factor z of a step: its modulus and minus its phase.
#[derive(Clone, Copy, Debug)]
pub struct Factor {
    pub modulus: f64,
    pub phase: f64,
}

/// Amplification factor of the wave with n periods in the strip, by the relation in the file's header.
pub fn exact(wave: Wave, periods: usize, step: f64, b: f64) -> Factor {
    let omega = rate(wave, periods) * step;
    let modulus = (1.0 - (b - 0.5) * omega * omega).sqrt();
    let cos = (1.0 - 0.5 * (b + 0.5) * omega * omega) / modulus;
    Factor {
        modulus,
        phase: cos.acos(),
    }
}

/// Frequency of the chain (1/s).
fn rate(wave: Wave, periods: usize) -> f64 {
    2.0 * wave.speed() / SIZE * (0.5 * number(periods) * SIZE).sin()
}

/// k (1/m)
pub fn number(periods: usize) -> f64 {
    TAU * periods as f64 / (COLUMNS as f64 * SIZE)
}

/// The strip with a travelling wave of the scheme. With u_n = Re z^n exp(ikx), the scheme's first line,
/// u_1 = u_0 + h v_0 - Omega^2/2 u_0, gives v_0.
pub fn travelling(wave: Wave, periods: usize, amplitude: f64, strip: Value) -> FemNode {
    let node = node(&strip);
    let scheme = node.model.scheme;
    let z = exact(wave, periods, scheme.step, scheme.damping);
    let omega = rate(wave, periods) * scheme.step;
    let start = move |[x, _]: [f64; 2]| {
        let kx = number(periods) * x;
        let next = z.modulus * (kx - z.phase).cos();
        let u = amplitude * kx.cos();
        let v = amplitude * (next - (1.0 - 0.5 * omega * omega) * kx.cos()) / scheme.step;
        match wave {
            Wave::P => [[u, 0.0], [v, 0.0]],
            Wave::S => [[0.0, u], [0.0, v]],
        }
    };
    set_in_motion(&node, start)
}

/// The sum of u_j exp(-i k x_j) over the nodes of the upper edge, each counted once.
fn projected(node: &FemNode, wave: Wave, periods: usize) -> [f64; 2] {
    let (mesh, layout) = (&node.model.mesh, node.model.body.layout);
    let mut sum = [0.0, 0.0];
    for i in 0..mesh.columns {
        let (sin, cos) = (number(periods) * mesh.point(i, 0)[0]).sin_cos();
        let u = node.state().u[layout.index([i, 0], wave.component())];
        sum = [sum[0] + u * cos, sum[1] - u * sin];
    }
    sum
}

/// The mean factor of a step, measured over 400 steps, and the exact one.
fn measured(wave: Wave, periods: usize, b: f64) -> (Factor, Factor) {
    const STEPS: u32 = 400;
    let mut node = travelling(wave, periods, 1e-9, wave.strip(b));
    let [re, im] = projected(&node, wave, periods);
    let (mut length, mut turned) = (re.hypot(im), 0.0);
    let (first, mut angle) = (length, im.atan2(re));
    for index in 0..u64::from(STEPS) {
        node.advance_alone(&window(index, 1)).expect("stable");
        let [re, im] = projected(&node, wave, periods);
        let now = im.atan2(re);
        turned += (angle - now).rem_euclid(TAU);
        (length, angle) = (re.hypot(im), now);
    }
    let steps = f64::from(STEPS);
    let mean = Factor {
        modulus: (length / first).powf(1.0 / steps),
        phase: turned / steps,
    };
    let step = node.model.scheme.step;
    (mean, exact(wave, periods, step, b))
}

#[test]
fn waves_of_any_length_obey_the_dispersion_relation() {
    for wave in [Wave::P, Wave::S] {
        for periods in [1, 2, 5, 10, 15, 19] {
            let (mean, exact) = measured(wave, periods, 0.5);
            let error = mean.phase / exact.phase - 1.0;
            assert!(error.abs() <= 1e-10, "{wave:?} {periods}: {error:e}");
            assert!((mean.modulus - 1.0).abs() <= 1e-10, "{wave:?} {periods}");
        }
    }
}

#[test]
fn damping_slows_and_shortens_waves_as_derived() {
    for b in [0.6, 0.75, 1.0] {
        for periods in [1, 2, 5] {
            let (mean, exact) = measured(Wave::P, periods, b);
            let phase = mean.phase / exact.phase - 1.0;
            let modulus = mean.modulus / exact.modulus - 1.0;
            assert!(phase.abs() <= 1e-10, "b = {b}, {periods}: {phase:e}");
            assert!(modulus.abs() <= 1e-10, "b = {b}, {periods}: {modulus:e}");
        }
    }
}

/// The relation itself: short waves lag, and at small h the shortest travels at 2/pi of the speed of sound.
#[test]
fn short_waves_are_slower_than_sound() {
    let crossing = SIZE / Wave::P.speed();
    let of_sound = |periods: usize, share: f64| {
        let step = share * crossing;
        let z = exact(Wave::P, periods, step, 0.5);
        z.phase / step / number(periods) / Wave::P.speed()
    };
    assert!((of_sound(1, 1e-3) - 1.0).abs() < 1.1e-3);
    assert!((of_sound(COLUMNS / 2, 1e-3) - 2.0 / std::f64::consts::PI).abs() < 1e-6);
    // At the limit of stability the errors of time and space cancel.
    assert!((of_sound(10, 1.0) - 1.0).abs() < 1e-12);
}
