//! The row kernels against the textbook, and the two paths of plasticity against each other.

use super::*;
use crate::element::body::tests::plastic::{PlasticRow, wobbly};
use crate::element::body::{Body, ElementKind};
use crate::element::points::FLOWED;
use crate::element::shape::strain;
use crate::material::nonlinear::plain::respond;

/// A body in which no two elements are alike and no side is parallel to another.
fn distorted() -> Mesh {
    Mesh::structured(6, 4, |i, j| {
        let wobble = |k: usize| 0.2 * ((k * 7919 + 13) % 101) as f64 / 101.0;
        let k = j * 7 + i;
        [i as f64 + wobble(k), -1.3 * j as f64 + wobble(k + 50)]
    })
}

fn elastic(poisson: f64) -> Elastic {
    Elastic::plane_strain(3.0, poisson, 1.0)
}

/// Nodal forces of one element from the textbook: t A B^T D B u at the centre, and the hourglass vector (1, -1, 1, -1) / 2 less its linear part.
fn reference(p: &[[f64; 2]; 4], u: &[[f64; 2]; 4], law: &Elastic, t: f64) -> [[f64; 2]; 4] {
    let stress = law.stress(strain(p, u, [0.0, 0.0]));
    let unit = |a: usize, k: usize| {
        let mut unit = [[0.0; 2]; 4];
        unit[a][k] = 1.0;
        strain(p, &unit, [0.0, 0.0])
    };
    let slopes: Vec<[f64; 2]> = (0..4).map(|a| [unit(a, 0)[0], unit(a, 1)[1]]).collect();
    let h = [1.0, -1.0, 1.0, -1.0];
    let moment = |k: usize| (0..4).map(|a| h[a] * p[a][k]).sum::<f64>();
    let pure = |a: usize| 0.5 * (h[a] - moment(0) * slopes[a][0] - moment(1) * slopes[a][1]);
    let b2: f64 = slopes.iter().flatten().map(|b| b * b).sum();
    let volume = t * area(p);
    let q = [0, 1]
        .map(|k| 0.1 * law.c11 * volume * b2 * (0..4).map(|a| pure(a) * u[a][k]).sum::<f64>());
    [0, 1, 2, 3].map(|a| {
        let [bx, by] = slopes[a];
        [
            volume * (bx * stress[0] + by * stress[2]) + pure(a) * q[0],
            volume * (by * stress[1] + bx * stress[2]) + pure(a) * q[1],
        ]
    })
}

#[test]
fn the_row_kernel_agrees_with_the_textbook_element() {
    let (mesh, law, t) = (distorted(), elastic(0.3), 0.7);
    let body = Body::new(&mesh, ElementKind::Q4OnePoint, &law, t);
    let layout = body.layout;
    let motion = |n: [usize; 2]| [0, 1].map(|k| ((31 * n[0] + 17 * n[1] + 5 * k) as f64).sin());
    let (mut u, mut expected) = (vec![0.0; layout.len()], vec![0.0; layout.len()]);
    for j in 0..mesh.rows {
        for i in 0..mesh.columns {
            let corners = mesh.corners(i, j);
            let points = corners.map(|n| mesh.point(n[0], n[1]));
            let forces = reference(&points, &corners.map(motion), &law, t);
            for (node, force) in corners.into_iter().zip(forces) {
                for k in 0..2 {
                    u[layout.index(node, k)] = motion(node)[k];
                    expected[layout.index(node, k)] += force[k];
                }
            }
        }
    }
    let mut force = vec![0.0; layout.len()];
    body.internal_force(&u, &mut force);
    let scale = expected.iter().fold(0.0, |m: f64, f| m.max(f.abs()));
    for (computed, exact) in force.iter().zip(&expected) {
        assert!(
            (computed - exact).abs() <= 1e-12 * scale,
            "{computed} {exact}"
        );
    }
}

#[test]
fn the_hourglass_mode_of_a_square_is_resisted_as_stated() {
    let mesh = Mesh::structured(1, 1, |i, j| [i as f64, -(j as f64)]);
    let law = elastic(0.3);
    let body = Body::new(&mesh, ElementKind::Q4OnePoint, &law, 1.0);
    let layout = body.layout;
    let mut u = vec![0.0; layout.len()];
    for (node, h) in mesh.corners(0, 0).into_iter().zip([1.0, -1.0, 1.0, -1.0]) {
        u[layout.index(node, 0)] = h;
    }
    let mut force = vec![0.0; layout.len()];
    body.internal_force(&u, &mut force);
    // Bending energy of the exact field u = h xi eta: (4/3) E / (1 - nu^2) per h^2.
    let exact = 4.0 / 3.0 * 3.0 / (1.0 - 0.09);
    let work: f64 = u.iter().zip(&force).map(|(u, f)| u * f).sum();
    assert!((work / exact - 0.735).abs() < 1e-3, "{}", work / exact);
}

/// Forces f_ia = t A B_ja s_ij + G_a Q_i of a row under plasticity, with every factor as in the formula.
fn plain_row(elements: &Q4OnePoint, plastic: &J2, mut path: StrainPath, out: &mut RowForces) {
    let layout = elements.layout;
    let (padded, stride) = (layout.padded_columns(), layout.element_stride());
    let (u, du, constants) = (path.u, path.du, elements.constants.row(0));
    for i in (0..padded).step_by(LANES) {
        let constants = &constants[i / LANES];
        let [bx1, bx2, by1, by2, hx, hy, volume, hourglass] = *constants;
        let fields = [u.load(stride, i), du.load(stride, i)];
        let gradients = fields.map(|field| mean_gradient(constants, &field));
        let [modes, steps] = [0, 1].map(|k| hourglass_modes(constants, &fields[k], gradients[k]));
        let moduli = elements.elastic.moduli();
        let (stress, lost) = respond(plastic, moduli, gradients, &mut path.point(0, padded), i);
        let mut dissipated = volume * lost;
        let mut history = path.point(1, padded).load(i);
        let softened = Pack::splat(1.0 - softening(plastic));
        for k in 0..2 {
            let trial = modes[k] - history[k];
            let grows = (trial * steps[k]).if_positive(lost);
            let flow = grows.if_positive(softened * steps[k]);
            let mean = trial - Pack::splat(0.5) * (steps[k] + flow);
            dissipated = dissipated + hourglass * mean * flow;
            history[k] = history[k] + flow;
        }
        path.point(1, padded).store(i, history);
        path.count(dissipated, i);
        for k in 0..2 {
            let q = hourglass * (modes[k] - history[k]);
            let sx = volume * stress[k][0] - hx * q;
            let sy = volume * stress[k][1] - hy * q;
            let forces = CornerForces {
                first: bx1 * sx + by1 * sy,
                second: bx2 * sx + by2 * sy,
                hourglass: q,
            };
            out.store(k * stride + i, forces);
        }
    }
}

/// A row of skewed elements, some of which yield.
#[test]
fn the_short_path_of_plasticity_agrees_with_the_plain_one() {
    let row = PlasticRow::new(ElementKind::Q4OnePoint, &wobbly(9));
    let elements = Q4OnePoint::new(&wobbly(9), row.body.layout, &row.elastic, 0.7);
    let packs = row.body.layout.padded_columns() / LANES;
    let all = vec![[FLOWED; LANES]; packs];
    let short = row.run(0.2, |path, out| {
        let candidates = YieldCandidates {
            excess: &all,
            first: 0,
            factors: &[],
        };
        elements.plastic_row(&row.plastic, 0, path, candidates, out);
    });
    let plain = row.run(0.2, |path, out| {
        plain_row(&elements, &row.plastic, path, out);
    });
    assert!(short.flowed() > 0 && short.flowed() < 9);
    short.agrees_with(&plain, 1e-12);
}
