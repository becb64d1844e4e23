//! The uniform lattice in one piece, the reference for glued bars and chains: masses of
//! 1 kg and springs of 1 N/m, 1 m apart, with a pulse exp(-((x - 50) / 10)^2) m that travels right.

/// A lattice with free ends.
#[derive(Clone, Copy, Debug)]
pub struct Lattice<'a> {
    /// Masses.
    pub nodes: usize,
    /// Nodes of half the mass: a glued point has no mass, so a joint keeps the half mass of its one element.
    pub halves: &'a [usize],
    /// From this node on all nodes start at rest; the pulse is zero there to rounding.
    pub at_rest: usize,
    /// Step of the central differences (s), much shorter than the steps under test.
    pub step_s: f64,
}

impl Lattice<'_> {
    /// Displacements (m) of some nodes at these times.
    pub fn displacements<const N: usize>(&self, of: [usize; N], times: &[f64]) -> Vec<[f64; N]> {
        let (mut u, mut v) = self.start();
        let mut a = self.acceleration(&u);
        let h = self.step_s;
        let mut step = 0u64;
        let mut result = Vec::new();
        for time in times {
            while (step as f64 + 0.5) * h < *time {
                for i in 0..self.nodes {
                    u[i] += h * v[i] + 0.5 * h * h * a[i];
                }
                let next = self.acceleration(&u);
                for i in 0..self.nodes {
                    v[i] += 0.5 * h * (a[i] + next[i]);
                }
                (a, step) = (next, step + 1);
            }
            result.push(of.map(|node| u[node]));
        }
        result
    }

    /// Displacements and velocities of the pulse.
    fn start(&self) -> (Vec<f64>, Vec<f64>) {
        let moving = |i: usize| if i < self.at_rest { 1.0 } else { 0.0 };
        let both = (0..self.nodes).map(|i| (moving(i) * pulse_m(i), moving(i) * pulse_m_per_s(i)));
        both.unzip()
    }

    fn acceleration(&self, u: &[f64]) -> Vec<f64> {
        let last = self.nodes - 1;
        let of_node = |i: usize| {
            let left = if i > 0 { u[i - 1] - u[i] } else { 0.0 };
            let right = if i < last { u[i + 1] - u[i] } else { 0.0 };
            let mass = if self.halves.contains(&i) { 0.5 } else { 1.0 };
            (left + right) / mass
        };
        (0..self.nodes).map(of_node).collect()
    }
}

/// Displacement (m) of the pulse at a node.
pub fn pulse_m(i: usize) -> f64 {
    let s = (i as f64 - 50.0) / 10.0;
    (-s * s).exp()
}

/// Velocity (m/s) of the pulse at a node.
pub fn pulse_m_per_s(i: usize) -> f64 {
    let s = (i as f64 - 50.0) / 10.0;
    0.2 * s * (-s * s).exp()
}
