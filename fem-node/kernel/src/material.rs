//! Linear elasticity in the plane.
//!
//! - [`j2`]: plasticity with isotropic and kinematic hardening;
//! - [`nonlinear`]: nonlinear laws, and large rotations.

pub mod j2;
pub mod nonlinear;

/// Isotropic linear elasticity reduced to the plane:
/// sxx = c11 exx + c12 eyy, syy = c12 exx + c11 eyy, sxy = c33 (ux,y + uy,x), szz = out_of_plane (sxx + syy).
///
/// Plane strain (ezz = 0): c11 = lambda + 2 mu, c12 = lambda, szz = nu (sxx + syy).
/// Plane stress (szz = 0): c11 = E / (1 - nu^2), c12 = nu c11. In both c33 = mu.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Elastic {
    /// Stiffness against a strain in its own direction, the other direction held (Pa).
    pub c11: f64,
    /// Coupling of the two directions (Pa).
    pub c12: f64,
    /// Shear modulus (Pa).
    pub c33: f64,
    /// szz over (sxx + syy).
    pub out_of_plane: f64,
    /// Density (kg/m3).
    pub density: f64,
    /// True where the body is free across its plane (szz = 0), false where it is held (ezz = 0).
    pub plane_stress: bool,
}

impl Elastic {
    /// The law of plane strain: Young's modulus (Pa), Poisson's ratio, density (kg/m3).
    pub fn plane_strain(young: f64, nu: f64, density: f64) -> Elastic {
        let c33 = young / (2.0 * (1.0 + nu));
        let c12 = young * nu / ((1.0 + nu) * (1.0 - 2.0 * nu));
        Elastic {
            c11: c12 + 2.0 * c33,
            c12,
            c33,
            out_of_plane: nu,
            density,
            plane_stress: false,
        }
    }

    /// The law of plane stress from the same numbers.
    pub fn plane_stress(young: f64, nu: f64, density: f64) -> Elastic {
        let in_plane = young / (1.0 - nu * nu);
        Elastic {
            c11: in_plane,
            c12: nu * in_plane,
            out_of_plane: 0.0,
            plane_stress: true,
            ..Elastic::plane_strain(young, nu, density)
        }
    }

    /// Moduli (c11, c12, c33) (Pa).
    pub fn moduli(&self) -> [f64; 3] {
        [self.c11, self.c12, self.c33]
    }

    /// Stress (sxx, syy, sxy) (Pa) of the strain (exx, eyy, 2 exy) (1).
    pub fn stress(&self, strain: [f64; 3]) -> [f64; 3] {
        let [exx, eyy, shear] = strain;
        [
            self.c11 * exx + self.c12 * eyy,
            self.c12 * exx + self.c11 * eyy,
            self.c33 * shear,
        ]
    }

    /// Bulk modulus c12 + 2/3 c33 (Pa); in plane stress the reduced law's, without the free third direction.
    pub fn bulk(&self) -> f64 {
        self.c12 + 2.0 / 3.0 * self.c33
    }

    /// Hydrostatic pressure -tr(sigma)/3, compression positive (Pa).
    pub fn pressure(&self, stress: [f64; 3]) -> f64 {
        -(1.0 + self.out_of_plane) * (stress[0] + stress[1]) / 3.0
    }

    /// Hydrostatic pressure of an equal stress in all loaded directions (Pa): three in plane strain, two in plane stress.
    pub fn pressure_of_uniform(&self, stress: f64) -> f64 {
        if self.plane_stress {
            -2.0 / 3.0 * stress
        } else {
            -stress
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn plane_strain_gives_the_confined_modulus() {
        let elastic = Elastic::plane_strain(200.0, 0.25, 1.0);
        assert!((elastic.c11 - 240.0).abs() < 1e-12);
        assert!((elastic.c12 - 80.0).abs() < 1e-12);
        assert!((elastic.c33 - 80.0).abs() < 1e-12);
    }

    #[test]
    fn plane_stress_stretches_with_youngs_modulus() {
        let elastic = Elastic::plane_stress(200.0, 0.25, 1.0);
        let [sxx, syy, _] = elastic.stress([1e-3, -0.25e-3, 0.0]);
        assert!((sxx - 0.2).abs() < 1e-15 && syy.abs() < 1e-15);
    }

    #[test]
    fn equal_compression_in_three_directions_is_its_own_pressure() {
        let elastic = Elastic {
            out_of_plane: 0.5,
            ..Elastic::plane_strain(200.0, 0.25, 1.0)
        };
        assert!((elastic.pressure([-3.0, -3.0, 7.0]) - 3.0).abs() < 1e-15);
    }
}
