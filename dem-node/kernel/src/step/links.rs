//! Contacts through which heat passes, and the implicit conduction through all of them.

use crate::step::temperature::HeatTaker;

/// Residual of the conduction of a step, relative to its start. Heat is conserved to rounding at any residual.
const TOLERANCE: f64 = 1e-12;

/// Iterations after which the conduction of a step has stalled at rounding.
const ITERATIONS_MAX: usize = 1000;

/// Contacts through which heat passes.
#[derive(Clone, Debug, Default)]
pub struct Links {
    /// Two grains, or a grain and a half-space, and h H (J/K).
    pub inner: Vec<([usize; 2], f64)>,
    /// A grain, a body beside it, the body's rise (K), and h H (J/K).
    pub outer: Vec<(usize, HeatTaker, f64, f64)>,
}

impl Links {
    /// Heat that each grain and half-space receives at these rises of the temperatures (J); the bodies beside have their rises times `beside`.
    pub fn received(&self, rises: &[f64], beside: f64) -> Vec<f64> {
        let mut received = vec![0.0; rises.len()];
        for ([i, j], h) in &self.inner {
            let flow = h * (rises[*j] - rises[*i]);
            received[*i] += flow;
            received[*j] -= flow;
        }
        for (grain, _, held, h) in &self.outer {
            received[*grain] += h * (beside * held - rises[*grain]);
        }
        received
    }

    /// Capacity of each grain and half-space with all h H there (J/K), the diagonal of C + h L.
    pub fn diagonal(&self, capacities: &[f64]) -> Vec<f64> {
        let mut sums = capacities.to_vec();
        for ([i, j], h) in &self.inner {
            sums[*i] += h;
            sums[*j] += h;
        }
        self.outer.iter().for_each(|(i, .., h)| sums[*i] += h);
        sums
    }

    /// The rises after the conduction, up to [`TOLERANCE`]: T + d with (C + h L) d = -h L T, by conjugate gradients with the `diagonal`.
    pub fn conducted(&self, capacities: &[f64], diagonal: &[f64], start: &[f64]) -> Vec<f64> {
        let mut residual = self.received(start, 1.0);
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let scaled =
            |r: &[f64]| -> Vec<f64> { r.iter().zip(diagonal).map(|(r, d)| r / d).collect() };
        let mut ends = start.to_vec();
        let mut next = scaled(&residual);
        let mut direction = next.clone();
        let mut size = dot(&residual, &next);
        let enough = TOLERANCE * TOLERANCE * size;
        for _ in 0..ITERATIONS_MAX {
            if size <= enough {
                break;
            }
            let flows = self.received(&direction, 0.0);
            let stored = direction.iter().zip(capacities);
            let image = stored.zip(&flows).map(|((d, c), flow)| c * d - flow);
            let image: Vec<f64> = image.collect();
            let step = size / dot(&direction, &image);
            for ((end, r), (d, a)) in ends
                .iter_mut()
                .zip(&mut residual)
                .zip(direction.iter().zip(&image))
            {
                *end += step * d;
                *r -= step * a;
            }
            next = scaled(&residual);
            let before = std::mem::replace(&mut size, dot(&residual, &next));
            for (d, z) in direction.iter_mut().zip(&next) {
                *d = z + size / before * *d;
            }
        }
        ends
    }
}
