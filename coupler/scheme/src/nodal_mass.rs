//! Masses of a layer's points on the nodes that carry them.
//!
//! With v_g = N v and the points' masses M_p, the mass on the nodes is M_n = N^T M_p N, the same in both components.

use std::ops::Range;

use nalgebra::DMatrix;

use super::mapping::Mapping;

/// The fraction of a node's mass that must be its own: less is rounding of its neighbours' masses.
const OWN: f64 = 1e-9;

/// M_n = N^T M_p N (kg) of these nodes, from the masses (kg) of all points.
pub fn nodal_mass(mapping: &Mapping, mass_kg: &[f64], nodes: &Range<usize>) -> DMatrix<f64> {
    let own = mapping.block(&(0..mass_kg.len()), nodes);
    let size = nodes.len();
    let mut matrix = DMatrix::zeros(size, size);
    for column in 0..size {
        let mut unit = vec![0.0; 2 * size];
        unit[2 * column] = 1.0;
        let mut inertia = own.motion(&unit);
        for (pair, mass) in inertia.chunks_exact_mut(2).zip(mass_kg) {
            pair[0] *= mass;
        }
        let borne = own.force(&inertia);
        for row in 0..size {
            matrix[(row, column)] = borne[2 * row];
        }
    }
    matrix
}

/// The first node without mass of its own once the nodes before it are held: it makes the mass matrix singular.
pub fn massless_node(masses: &DMatrix<f64>) -> Option<usize> {
    let size = masses.nrows();
    let mut rest = masses.clone();
    for pivot in 0..size {
        let own = rest[(pivot, pivot)];
        if own <= OWN * masses[(pivot, pivot)] || !own.is_finite() {
            return Some(pivot);
        }
        for row in pivot + 1..size {
            let share = rest[(row, pivot)] / own;
            for column in pivot + 1..size {
                rest[(row, column)] -= share * rest[(pivot, column)];
            }
        }
    }
    None
}

/// A matrix over nodes as one over both of their components.
pub fn both_components(nodal: &DMatrix<f64>) -> DMatrix<f64> {
    DMatrix::from_fn(2 * nodal.nrows(), 2 * nodal.ncols(), |i, j| {
        let is_same = i % 2 == j % 2;
        if is_same { nodal[(i / 2, j / 2)] } else { 0.0 }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::keys::MappingKind;

    const NODES: [[f64; 2]; 3] = [[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]];

    /// 4 kg at a quarter of the way between two nodes give 4 (9, 3; 3, 1) / 16 kg.
    #[test]
    fn a_point_between_two_nodes_weighs_on_both() {
        let points = [[0.25, 0.0], [1.0, 0.0], [2.0, 0.0]];
        let mapping = Mapping::new(MappingKind::Linear, &NODES, &points, None).expect("in order");
        let masses = nodal_mass(&mapping, &[4.0, 2.0, 1.0], &(0..3));
        let exact = [2.25, 0.75, 0.0, 0.75, 2.25, 0.0, 0.0, 0.0, 1.0];
        assert!((&masses - DMatrix::from_row_slice(3, 3, &exact)).amax() < 1e-15);
        assert_eq!(massless_node(&masses), None);
        assert_eq!(both_components(&masses)[(2, 0)], 0.75);
        assert_eq!(both_components(&masses)[(2, 1)], 0.0);
    }

    #[test]
    fn two_points_do_not_hold_three_nodes() {
        let points = [[0.5, 0.0], [1.5, 0.0]];
        let mapping = Mapping::new(MappingKind::Linear, &NODES, &points, None).expect("in order");
        let masses = nodal_mass(&mapping, &[1.0, 1.0], &(0..3));
        assert_eq!(massless_node(&masses), Some(2));
    }
}
