//! Elements without plastic flow under plasticity, and the bound that detects flow.

use crate::element::body::*;
use crate::element::linear::BoundedRow;
use crate::element::points::{FLOWED, YieldCandidates};
use crate::element::shape::{GAUSS_POINTS, jacobian, strain};
use crate::material::j2::J2;
use crate::pack::lanes::LANES;

const KINDS: [ElementKind; 3] = [
    ElementKind::Q4OnePoint,
    ElementKind::Q4Full,
    ElementKind::Q4MeanDilatation,
];
const THICKNESS: f64 = 0.7;

/// Pseudo-random numbers in -1..1.
pub(in crate::element) struct Chance(u64);

impl Chance {
    fn next(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }
}

/// One row of elements, no two alike and no side parallel to another.
pub(in crate::element) fn wobbly(columns: usize) -> Mesh {
    let mut chance = Chance(columns as u64);
    let shift: Vec<f64> = (0..4 * (columns + 1))
        .map(|_| 0.3 * chance.next())
        .collect();
    Mesh::structured(columns, 1, |i, j| {
        let k = 2 * (j * (columns + 1) + i);
        [1.3 * i as f64 + shift[k], -(j as f64) + shift[k + 1]]
    })
}

/// A row of elements under plasticity.
pub(in crate::element) struct PlasticRow {
    pub(in crate::element) body: Body,
    pub(in crate::element) elastic: Elastic,
    pub(in crate::element) plastic: J2,
    kind: ElementKind,
    mesh: Mesh,
}

/// Result of a step of a row: forces and history.
#[derive(Debug, PartialEq)]
pub(in crate::element) struct Step {
    forces: Vec<[f64; 8]>,
    history: Vec<f64>,
    dissipated: Vec<f64>,
    flowed: Vec<bool>,
}

impl Step {
    /// Number of elements that have flowed.
    pub(in crate::element) fn flowed(&self) -> usize {
        self.flowed.iter().filter(|flowed| **flowed).count()
    }

    /// Expects equality within this share of the largest number of each kind.
    pub(in crate::element) fn agrees_with(&self, other: &Step, tolerance: f64) {
        let flat = |step: &Step| step.forces.concat();
        let pairs = [
            (flat(self), flat(other)),
            (self.history.clone(), other.history.clone()),
            (self.dissipated.clone(), other.dissipated.clone()),
        ];
        for (ours, theirs) in pairs {
            let scale = theirs.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
            for (k, (a, b)) in ours.iter().zip(&theirs).enumerate() {
                assert!((a - b).abs() <= tolerance * scale, "{k}: {a:e} {b:e}");
            }
        }
    }
}

impl PlasticRow {
    pub(in crate::element) fn new(kind: ElementKind, mesh: &Mesh) -> PlasticRow {
        let elastic = Elastic::plane_strain(3.0, 0.3, 1.0);
        PlasticRow {
            body: Body::new(mesh, kind, &elastic, THICKNESS),
            plastic: J2 {
                mu: elastic.c33,
                yield_stress: 0.5,
                isotropic: 0.3,
                kinematic: 0.2,
                softens: false,
            },
            elastic,
            kind,
            mesh: mesh.clone(),
        }
    }

    /// The field of a seed, one number for each component.
    fn field(&self, seed: u64) -> Vec<f64> {
        let mut chance = Chance(seed);
        let mut u = vec![0.0; self.body.layout.len()];
        for node in self.mesh.nodes() {
            (0..2).for_each(|k| u[self.body.layout.index(node, k)] = chance.next());
        }
        u
    }

    /// A step to the field of a seed from no strain, by these forces of the row.
    pub(in crate::element) fn run(
        &self,
        scale: f64,
        forces: impl FnMut(StrainPath, &mut RowForces),
    ) -> Step {
        let u: Vec<f64> = self.field(3).iter().map(|u| scale * u).collect();
        let law = NonlinearLaw::Plastic(self.plastic);
        let history = vec![0.0; self.body.history_row_len(Some(&law))];
        self.step(&u, history, forces)
    }

    fn step(
        &self,
        u: &[f64],
        mut history: Vec<f64>,
        mut forces: impl FnMut(StrainPath, &mut RowForces),
    ) -> Step {
        let layout = self.body.layout;
        let mut out = RowForces::new(layout);
        let mut dissipated = vec![0.0; layout.padded_columns()];
        let rows = structured_row(layout, u, 0);
        let path = StrainPath {
            u: rows,
            du: rows,
            history: &mut history,
            dissipated: &mut dissipated,
        };
        forces(path, &mut out);
        let of = |i: usize| out.of_element(layout.element_stride(), i);
        let flowed = |i: usize| {
            let point = |k: usize| history[(k * HISTORY + 3) * layout.padded_columns() + i] > 0.0;
            (0..self.body.points()).any(point)
        };
        Step {
            forces: (0..layout.columns).map(of).collect(),
            flowed: (0..layout.columns).map(flowed).collect(),
            history,
            dissipated,
        }
    }

    fn plastic_step(&self, u: &[f64], history: Vec<f64>) -> Step {
        let (law, all) = (
            NonlinearLaw::Plastic(self.plastic),
            0..self.body.layout.padded_columns(),
        );
        self.step(u, history, |path, out| {
            self.body.nonlinear_row(&law, 0, path, all.clone(), out);
        })
    }

    fn virgin(&self) -> Vec<f64> {
        vec![
            0.0;
            self.body
                .history_row_len(Some(&NonlinearLaw::Plastic(self.plastic)))
        ]
    }

    /// |x_trial| over the radius of the yield surface, the largest of the points of an element that has never flowed.
    fn nearness(&self, u: &[f64], i: usize) -> f64 {
        let corners = self.mesh.corners(i, 0);
        let p = corners.map(|n| self.mesh.point(n[0], n[1]));
        let moved = corners.map(|n| [0, 1].map(|k| u[self.body.layout.index(n, k)]));
        let points: &[[f64; 2]] = if self.kind == ElementKind::Q4OnePoint {
            &[[0.0, 0.0]]
        } else {
            &GAUSS_POINTS
        };
        let norm = |natural: &[f64; 2]| {
            let [xx, yy, shear] = strain(&p, &moved, *natural);
            let mean = (xx + yy) / 3.0;
            let squares = (xx - mean).powi(2) + (yy - mean).powi(2) + mean.powi(2);
            2.0 * self.plastic.mu * (squares + 0.5 * shear * shear).sqrt()
        };
        let radius = (2.0f64 / 3.0).sqrt() * self.plastic.yield_stress;
        points.iter().map(norm).fold(0.0, f64::max) / radius
    }

    /// u f of an element.
    fn work(&self, u: &[f64], i: usize) -> f64 {
        let corners = self.mesh.corners(i, 0);
        let p = corners.map(|n| self.mesh.point(n[0], n[1]));
        let moved: [f64; 8] =
            std::array::from_fn(|r| u[self.body.layout.index(corners[r / 2], r % 2)]);
        let k = stiffness(self.kind, &p, &self.elastic, THICKNESS);
        let force = |row: &[f64; 8]| row.iter().zip(moved).map(|(k, u)| k * u).sum::<f64>();
        k.0.iter().zip(moved).map(|(row, u)| u * force(row)).sum()
    }
}

fn scaled(u: &[f64], factor: f64) -> Vec<f64> {
    u.iter().map(|u| factor * u).collect()
}

fn bits(step: &Step) -> Vec<u64> {
    step.forces.concat().iter().map(|f| f.to_bits()).collect()
}

/// Just below the yield surface the bound is exceeded in most elements, far below in none.
#[test]
fn elements_that_do_not_yield_have_the_bits_of_elastic_ones() {
    for kind in KINDS {
        let row = PlasticRow::new(kind, &wobbly(13));
        for seed in 0..50 {
            let u = row.field(seed);
            let worst = (0..13).map(|i| row.nearness(&u, i)).fold(0.0, f64::max);
            for share in [1e-3, 0.5, 1.0 - 1e-9] {
                let u = scaled(&u, share / worst);
                let plastic = row.plastic_step(&u, row.virgin());
                let all = 0..row.body.layout.padded_columns();
                let elastic = row.step(&u, row.virgin(), |path, out| {
                    row.body.element_row(0, path.u, all.clone(), out);
                });
                assert_eq!(bits(&plastic), bits(&elastic), "{kind:?} {seed} {share}");
                assert_eq!(plastic, elastic);
            }
        }
    }
}

/// An element does not depend on its pack: sending all packs through the radial return changes nothing, with any earlier flow.
#[test]
fn the_path_of_a_pack_does_not_change_a_bit() {
    for kind in KINDS {
        let row = PlasticRow::new(kind, &wobbly(13));
        let packs = row.body.layout.padded_columns() / LANES;
        let all = vec![[FLOWED; LANES]; packs];
        let (mut some, mut none) = (0, 0);
        for seed in 0..50 {
            let first = row.plastic_step(&scaled(&row.field(seed), 0.12), row.virgin());
            let u = scaled(&row.field(seed + 1000), 0.12);
            let chosen = row.plastic_step(&u, first.history.clone());
            let forced = row.step(&u, first.history.clone(), |path, out| {
                let candidates = YieldCandidates {
                    excess: &all,
                    first: 0,
                    factors: &[],
                };
                match &row.body.element {
                    Element::OnePoint(e) => e.plastic_row(&row.plastic, 0, path, candidates, out),
                    Element::FourPoint(e) => e.plastic_row(&row.plastic, 0, path, candidates, out),
                }
            });
            assert_eq!(bits(&chosen), bits(&forced), "{kind:?} {seed}");
            assert_eq!(chosen, forced);
            some += chosen.flowed();
            none += 13 - chosen.flowed();
        }
        assert!(some > 20 && none > 20, "{kind:?}: {some} {none}");
    }
}

/// Each element alone just above and just below its yield surface, in random fields.
#[test]
fn every_element_that_reaches_the_yield_surface_is_caught() {
    for kind in KINDS {
        let row = PlasticRow::new(kind, &wobbly(13));
        for (seed, i) in (0..100).flat_map(|seed| (0..13).map(move |i| (seed, i))) {
            let u = row.field(seed);
            let nearness = row.nearness(&u, i);
            let flows = |share: f64| {
                row.plastic_step(&scaled(&u, share / nearness), row.virgin())
                    .flowed[i]
            };
            assert!(flows(1.0 + 1e-9), "{kind:?} {seed} {i}");
            assert!(!flows(1.0 - 1e-9), "{kind:?} {seed} {i}");
        }
    }
}

/// The same with a factor of its own on the yield stress of each element.
#[test]
fn every_element_yields_at_its_own_surface() {
    for kind in KINDS {
        let mut row = PlasticRow::new(kind, &wobbly(13));
        row.plastic.softens = true;
        let factor = |[i, _]: [usize; 2]| 1.0 - 0.06 * i as f64;
        let mut history = row.virgin();
        row.body.soften(&mut history, factor);
        for (seed, i) in (0..10).flat_map(|seed| (0..13).map(move |i| (seed, i))) {
            let u = row.field(seed);
            let nearness = row.nearness(&u, i) / factor([i, 0]);
            let flows = |share: f64| {
                row.plastic_step(&scaled(&u, share / nearness), history.clone())
                    .flowed[i]
            };
            assert!(flows(1.0 + 1e-9), "{kind:?} {seed} {i}");
            assert!(!flows(1.0 - 1e-9), "{kind:?} {seed} {i}");
        }
    }
}

/// The field in which one point has the largest share of the work of its element, found by hill climbing.
#[test]
fn the_bound_holds_where_one_point_does_most_of_the_work() {
    for kind in KINDS {
        for shape in 0..6 {
            let row = PlasticRow::new(kind, &wobbly(1 + shape));
            let i = shape / 2;
            let share = |u: &[f64]| row.nearness(u, i).powi(2) / row.work(u, i);
            let mut chance = Chance(shape as u64);
            let mut u = row.field(shape as u64);
            let mut best = share(&u);
            for round in 0..4000 {
                let reach = 0.5 * 0.998f64.powi(round);
                let tried: Vec<f64> = u.iter().map(|u| u + reach * chance.next()).collect();
                if share(&tried) > best {
                    best = share(&tried);
                    u = tried;
                }
            }
            let nearness = row.nearness(&u, i);
            let near = scaled(&u, (1.0 + 1e-9) / nearness);
            assert!(
                row.plastic_step(&near, row.virgin()).flowed[i],
                "{kind:?} {shape}"
            );
        }
    }
}

/// The numbers of the bound themselves: the fields above would not detect a limit that is too large by less than a factor of 1.5.
#[test]
fn the_excess_of_four_points_follows_from_their_work() {
    let row = PlasticRow::new(ElementKind::Q4Full, &wobbly(13));
    let (layout, mu) = (row.body.layout, row.plastic.mu);
    let u = row.field(1);
    let mut excess = vec![[0.0; LANES]; layout.padded_columns() / LANES];
    row.step(&u, row.virgin(), |path, out| {
        let linear = LinearRow {
            u: path.u,
            stride: layout.element_stride(),
            columns: 0..layout.padded_columns(),
            out,
        };
        let bounded = BoundedRow {
            row: linear,
            plastic: &row.plastic,
            lowest: 1.0,
            excess: &mut excess,
        };
        row.body.over_linear(0, bounded);
    });
    for i in 0..13 {
        let p = row.mesh.corners(i, 0).map(|n| row.mesh.point(n[0], n[1]));
        let least = GAUSS_POINTS
            .map(|natural| jacobian(&p, natural))
            .into_iter()
            .fold(f64::INFINITY, f64::min);
        let bound = row.work(&u, i) / (mu * THICKNESS * least);
        let limit = 0.999 * (row.plastic.yield_stress / mu).powi(2) / 3.0;
        let exact = (bound - limit) * mu * THICKNESS * THICKNESS / 16.0;
        let error = (excess[i / LANES][i % LANES] - exact).abs();
        assert!(error <= 1e-12 * exact.abs(), "{i}: {error:e} of {exact:e}");
    }
}
