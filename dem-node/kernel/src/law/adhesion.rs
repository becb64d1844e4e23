//! Adhesion: bodies that touch, or nearly do, attract each other with a constant force.
//!
//! ```text
//!     r_n + N_c >= 0, |r_t| <= mu (r_n + N_c)        a shift of Signorini and Coulomb (Radjai, Preechawuttipong and Peyroux 2001)
//! ```
//!
//! The attraction N_c is a load on both bodies while their gap g is below the range d, and the contact law holds for the rest of the force: no solver
//! needs a change. Its potential -N_c (d - g) is released on approach and taken up on parting, so that a pair that meets and parts has gained
//! nothing. In the step that enters the range there is no attraction yet, and in the step that leaves it the attraction acts to its end: both effects
//! of a finite step are losses.

/// The parameters of the law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Adhesion {
    /// Part of N_c that all pairs have (N).
    pub force: f64,
    /// Part of N_c over r (N/m), with r = r_1 r_2 / (r_1 + r_2), or the radius of the grain on faces.
    pub by_radius: f64,
    /// d (m).
    pub range: f64,
}

impl Adhesion {
    /// N_c (N) of a pair with this r (m) at a gap (m).
    pub fn attraction(&self, radius: f64, gap: f64) -> f64 {
        if gap < self.range {
            self.force + self.by_radius * radius
        } else {
            0.0
        }
    }

    /// Energy (J) of this attraction (N) at a gap (m), 0 out of range.
    pub fn stored(&self, attraction: f64, gap: f64) -> f64 {
        -attraction * (self.range - gap).max(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LAW: Adhesion = Adhesion {
        force: 2.0,
        by_radius: 3.0,
        range: 0.5,
    };

    #[test]
    fn it_acts_within_its_range_in_proportion_to_the_radius() {
        assert_eq!(LAW.attraction(2.0, 0.4), 8.0);
        assert_eq!(LAW.attraction(2.0, -1.0), 8.0);
        assert_eq!(LAW.attraction(2.0, 0.5), 0.0);
    }
}
