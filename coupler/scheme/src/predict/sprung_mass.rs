//! A linear participant on a boundary, in one interface motion: a glued mass, and a free mass behind a spring.

use protocol::BoundaryInertia;

/// State of the masses at the start of a window; the glued mass has the position of the interface.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Masses {
    /// Velocity of the glued mass (m/s).
    pub glued_velocity: f64,
    /// Position of the free mass (m).
    pub position: f64,
    /// Its velocity (m/s).
    pub velocity: f64,
}

/// The end of a window.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Solved {
    /// The masses at its end.
    pub masses: Masses,
    /// Force of the masses on the boundary (N).
    pub force: f64,
}

/// Motion of the boundary in a window: v_g = a_g + W_g p.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion {
    /// a_g (m/s).
    pub free: f64,
    /// W_g (1/kg); zero for a boundary with prescribed motion.
    pub compliance: f64,
}

/// The masses and their window, of length H.
#[derive(Clone, Copy, Debug)]
pub struct SprungMass {
    glued: f64,
    mass: f64,
    spring: f64,
    theta: f64,
    window_s: f64,
}

impl SprungMass {
    /// The masses behind a point, from its solver's description at the handshake.
    pub fn new(inertia: &BoundaryInertia, window_s: f64) -> SprungMass {
        // Without a spring the free mass has no effect, so that any value serves.
        let (behind, mass) = match inertia.stiffness_n_per_m {
            None => (inertia.mass_kg, 1.0),
            Some(_) => (0.0, inertia.mass_kg),
        };
        SprungMass {
            glued: inertia.glued_mass_kg + behind,
            mass,
            spring: inertia.stiffness_n_per_m.unwrap_or(0.0),
            theta: inertia.theta,
            window_s,
        }
    }

    /// One window of the theta scheme; q_0 (m) is the position of the interface at its start: m_g (v_g - v_g0) = H k
    /// (q_1 - q_0) - p and m (v - v_0) = -H k (q_1 - q_0), both positions taken at q + theta H (theta v' + (1 - theta)
    /// v) for the free mass, q + theta H v_g for the glued one, and v_g = a_g + W_g p.
    ///
    /// With v eliminated the glued mass obeys A v_g + p = R; solved in this form, a prescribed motion is met exactly.
    pub fn window(&self, start: &Masses, q_0: f64, motion: Motion) -> Solved {
        let (h, theta, k, m) = (self.window_s, self.theta, self.spring, self.mass);
        // Stretch of the spring at the start (m), and m + (theta H)^2 k (kg).
        let stretch = start.position + theta * (1.0 - theta) * h * start.velocity - q_0;
        let moved = m + theta * theta * h * h * k;
        let inertia = self.glued + theta * h * h * k * m / moved;
        let drive = self.glued * start.glued_velocity
            + h * k * (stretch + theta * theta * h * start.velocity) * m / moved;
        let p = (drive - inertia * motion.free) / (1.0 + inertia * motion.compliance);
        let v_g = motion.free + motion.compliance * p;
        let v = (m * start.velocity - h * k * stretch + theta * h * h * k * v_g) / moved;
        // Without a spring nothing holds the free mass: it stays at rest.
        let follows = if k > 0.0 { 1.0 } else { 0.0 };
        Solved {
            masses: Masses {
                glued_velocity: v_g,
                position: follows
                    * (start.position + h * (theta * v + (1.0 - theta) * start.velocity)),
                velocity: follows * v,
            },
            force: p / h,
        }
    }

    /// S = -dF/du (N/m): the resistance against an imposed motion.
    pub fn stiffness(&self) -> f64 {
        let motion = Motion {
            free: 1.0 / self.window_s,
            compliance: 0.0,
        };
        -self.window(&Masses::default(), 0.0, motion).force
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rigid_mass_resists_with_its_inertia() {
        let boundary_inertia = BoundaryInertia {
            glued_mass_kg: 1.0,
            mass_kg: 2.0,
            stiffness_n_per_m: None,
            theta: 1.0,
            may_part: false,
        };
        assert!((SprungMass::new(&boundary_inertia, 0.5).stiffness() - 12.0).abs() < 1e-12);
    }

    /// Implicit Euler: spring and inertia in series, k (m/H^2) / (k + m/H^2).
    #[test]
    fn a_mass_behind_a_spring_resists_with_both_in_series() {
        let boundary_inertia = BoundaryInertia {
            glued_mass_kg: 0.0,
            mass_kg: 2.0,
            stiffness_n_per_m: Some(8.0),
            theta: 1.0,
            may_part: false,
        };
        assert!((SprungMass::new(&boundary_inertia, 0.5).stiffness() - 4.0).abs() < 1e-12);
    }
}
