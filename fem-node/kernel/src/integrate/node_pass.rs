//! The end of a step for a row of nodes, all in one pass over whole packs.
//!
//! The pass does the operations of [`crate::element::row_forces::RowForces::assemble`] and [`super::node_row`], with the same bits; values between
//! them stay in registers. A pass that also computes the elements was tried: each pack then is one chain of 26 dependent operations, too long for a
//! processor to begin the next pack meanwhile.

use std::ops::Range;

use super::dissipation::Dissipated;
use crate::element::row_forces::RowForces;
use crate::pack::lanes::{ByPacks, InRegisters, LANES, Lanes, Pack, Registers};
use crate::pack::{packs_of, packs_of_mut};
use crate::scheme::{Damping, Rule};

/// A row of nodes whose displacements and forces are new and whose other fields are still old.
pub(super) struct NodePass<'a> {
    pub(super) rule: Rule,
    /// Numbers of a component.
    pub(super) stride: usize,
    /// Columns that end their step.
    pub(super) columns: [usize; 2],
    pub(super) forces: &'a RowForces,
    pub(super) v: &'a mut [f64],
    pub(super) a: &'a mut [f64],
    pub(super) force: &'a mut [f64],
    pub(super) load: &'a [f64],
    pub(super) mass: &'a [f64],
    pub(super) inverse_mass: &'a [f64],
    pub(super) dissipated: Dissipated<&'a mut [f64]>,
}

/// Fields of a pack that the end of a step changes, both components of each.
type Changed = [[Pack; 2]; 5];

impl NodePass<'_> {
    /// True where all energies of the pass are counted.
    pub(super) fn counts(dissipated: &Dissipated<&mut [f64]>, damping: Damping) -> bool {
        let damping_is_counted = !damping.acts() || !dissipated.mass_damping.is_empty();
        !dissipated.numerical.is_empty() && damping_is_counted
    }
}

impl InRegisters for &mut NodePass<'_> {
    #[inline(always)]
    fn run<R: Registers>(self, registers: R) {
        let [first, end] = self.columns;
        let whole = first.div_ceil(LANES)..end / LANES;
        if whole.start < whole.end {
            self.end_packs(registers, &whole);
        }
        for pack in self.edges().into_iter().flatten() {
            let kept = self.changing_of(pack);
            self.end_packs(registers.single(), &(pack..pack + 1));
            self.put_back(pack, &kept);
        }
    }
}

/// Packs of one component of a row of nodes.
struct ComponentPass<'a, const DAMPED: bool> {
    rule: Rule,
    on_nodes: [&'a [[f64; LANES]]; 4],
    loads: &'a [[f64; LANES]],
    masses: &'a [[f64; LANES]],
    inverse_masses: &'a [[f64; LANES]],
    v: &'a mut [[f64; LANES]],
    a: &'a mut [[f64; LANES]],
    forces: &'a mut [[f64; LANES]],
    numerical: &'a mut [[f64; LANES]],
    /// Empty without damping.
    mass_damping: &'a mut [[f64; LANES]],
}

impl<const DAMPED: bool> ByPacks for ComponentPass<'_, DAMPED> {
    /// Forces, acceleration, energies and velocity.
    #[inline(always)]
    fn at<R: Registers>(&mut self, registers: R, p: usize) {
        let all = |value: f64| registers.splat(value);
        let load = |packs: &[[f64; LANES]]| registers.load(packs, p);
        let (h, b) = (self.rule.scheme.step, self.rule.scheme.damping);
        let (c, c_end) = (self.rule.damping.start, self.rule.damping.end);
        let (old, new) = (all(h * (1.0 - b)), all(h * b));
        let drag = all(c_end / (1.0 + b * h * c_end));
        let (step, half, weight) = (all(h), all(0.5 * h * h), all(0.5 * b * h * h));
        let (drag_start, drag_end) = (all((1.0 - b) * c), all(b * c_end));

        let [left, right, below_left, below_right] = self.on_nodes;
        let above = load(left) + load(right);
        let force = above + (load(below_left) + load(below_right));
        let (old_v, old_a, mass) = (load(self.v), load(self.a), load(self.masses));

        let free = load(self.inverse_masses) * (load(self.loads) - force);
        let new_a = if DAMPED {
            free - drag * (old_v + (old * old_a + new * free))
        } else {
            free
        };
        let new_v = old_v + (old * old_a + new * new_a);

        let du = step * old_v + half * old_a;
        let (d_force, da) = (force - load(self.forces), new_a - old_a);
        let loss = du * d_force - weight * mass * da * da;
        (load(self.numerical) + loss).put(self.numerical, p);
        if DAMPED {
            let loss = (drag_start * old_v + drag_end * new_v) * mass * du;
            (load(self.mass_damping) + loss).put(self.mass_damping, p);
        }
        new_v.put(self.v, p);
        new_a.put(self.a, p);
        force.put(self.forces, p);
    }
}

impl NodePass<'_> {
    /// Ends the step of whole packs.
    #[inline(always)]
    fn end_packs<R: Registers>(&mut self, registers: R, packs: &Range<usize>) {
        for component in [0, self.stride] {
            if self.rule.damping.acts() {
                let mut pass = self.component::<true>(component, packs);
                pass.over(registers, packs.len());
            } else {
                let mut pass = self.component::<false>(component, packs);
                pass.over(registers, packs.len());
            }
        }
    }

    #[inline(always)]
    fn component<const DAMPED: bool>(
        &mut self,
        component: usize,
        packs: &Range<usize>,
    ) -> ComponentPass<'_, DAMPED> {
        ComponentPass {
            rule: self.rule,
            on_nodes: self.forces.on_nodes(component, packs),
            loads: packs_of(self.load, component, packs),
            masses: packs_of(self.mass, component, packs),
            inverse_masses: packs_of(self.inverse_mass, component, packs),
            v: packs_of_mut(self.v, component, packs),
            a: packs_of_mut(self.a, component, packs),
            forces: packs_of_mut(self.force, component, packs),
            numerical: packs_of_mut(self.dissipated.numerical, component, packs),
            mass_damping: if DAMPED {
                packs_of_mut(self.dissipated.mass_damping, component, packs)
            } else {
                &mut []
            },
        }
    }

    /// Packs with only some columns in the step.
    #[inline(always)]
    fn edges(&self) -> [Option<usize>; 2] {
        let cut = |column: usize| (!column.is_multiple_of(LANES)).then_some(column / LANES);
        let [first, end] = self.columns;
        [cut(first), cut(end).filter(|_| cut(end) != cut(first))]
    }

    fn changing(&mut self) -> [&mut [f64]; 5] {
        let Dissipated {
            numerical,
            mass_damping,
            ..
        } = &mut self.dissipated;
        [self.v, self.a, self.force, numerical, mass_damping]
    }

    /// The values of a pack.
    fn changing_of(&mut self, pack: usize) -> Changed {
        let at = [0, self.stride].map(|component| component + LANES * pack);
        let mut changed = Changed::default();
        for (kept, field) in changed.iter_mut().zip(self.changing()) {
            if !field.is_empty() {
                *kept = at.map(|at| Pack::load(field, at));
            }
        }
        changed
    }

    /// Restores the values of the nodes of a pack outside the columns.
    fn put_back(&mut self, pack: usize, kept: &Changed) {
        let [first, end] = self.columns;
        let outside = |lane: &usize| !(first..end).contains(&(LANES * pack + lane));
        let at = [0, self.stride].map(|component| component + LANES * pack);
        for (field, kept) in self.changing().into_iter().zip(kept) {
            if field.is_empty() {
                continue;
            }
            for (at, kept) in at.into_iter().zip(kept) {
                for lane in (0..LANES).filter(outside) {
                    field[at + lane] = kept.0[lane];
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::node_row::NodeRow;
    use super::*;
    use crate::element::body::{Body, ElementKind};
    use crate::element::corners::CornerRows;
    use crate::element::layout::Layout;
    use crate::material::Elastic;
    use crate::mesh::Mesh;
    use crate::pack::in_registers;
    use crate::scheme::NewmarkScheme;

    /// Fields of a row of nodes.
    #[derive(Clone, Debug, PartialEq)]
    struct Row {
        v: Vec<f64>,
        a: Vec<f64>,
        force: Vec<f64>,
        numerical: Vec<f64>,
        mass_damping: Vec<f64>,
    }

    fn wave(layout: Layout, phase: f64) -> Vec<f64> {
        let of = |k: usize| (0.7 * k as f64 + phase).sin();
        (0..layout.row_len()).map(of).collect()
    }

    fn rule(damping: [f64; 2]) -> Rule {
        let [start, end] = damping;
        Rule {
            scheme: NewmarkScheme {
                step: 0.3,
                damping: 0.7,
                mass_damping: end,
                stiffness_damping: 0.0,
            },
            damping: Damping { start, end },
        }
    }

    /// Ends the step of some columns of the middle row of a skewed body, in one pass or one operation after the other.
    fn ended(columns: [usize; 2], damping: [f64; 2], in_one_pass: bool) -> [Row; 2] {
        let mesh = Mesh::structured(12, 2, |i, j| [i as f64 + 0.2 * j as f64, -(j as f64)]);
        let elastic = Elastic::plane_strain(1.0, 0.3, 1.0);
        let body = Body::new(&mesh, ElementKind::Q4OnePoint, &elastic, 1.0);
        let (layout, rule) = (body.layout, rule(damping));
        let rows = [0.0, 1.0, 2.0].map(|phase| wave(layout, phase));
        let mut forces = RowForces::new(layout);
        let all = 0..layout.padded_columns();
        for row in [0, 1] {
            let u = CornerRows::between([&rows[row], &rows[row + 1]]);
            forces.advance();
            body.element_row(row, u, all.clone(), &mut forces);
        }
        let before = Row {
            v: wave(layout, 3.0),
            a: wave(layout, 4.0),
            force: wave(layout, 5.0),
            numerical: wave(layout, 6.0),
            mass_damping: wave(layout, 7.0),
        };
        let (mut row, load, own) = (before.clone(), wave(layout, 8.0), layout.row(1));
        let dissipated = Dissipated {
            numerical: &mut row.numerical[..],
            mass_damping: &mut row.mass_damping[..],
            ..Dissipated::default()
        };
        if in_one_pass {
            in_registers(&mut NodePass {
                rule,
                stride: layout.stride,
                columns,
                forces: &forces,
                v: &mut row.v,
                a: &mut row.a,
                force: &mut row.force,
                load: &load,
                mass: &body.mass[own.clone()],
                inverse_mass: &body.inverse_mass[own],
                dissipated,
            });
        } else {
            let (mut new_force, spans) = (vec![0.0; layout.row_len()], layout.spans(columns));
            forces.assemble(&mut new_force, &spans);
            let mut plain = NodeRow {
                v: &mut row.v,
                a: &mut row.a,
                force: &mut row.force,
                new_force: &new_force,
                new_a: &mut vec![0.0; layout.row_len()],
                load: &load,
                mass: &body.mass[own.clone()],
                inverse_mass: &body.inverse_mass[own],
                damping_force: &mut [],
                net: &mut [],
                dissipated,
            };
            plain.finish(&rule, layout, &spans);
        }
        [before, row]
    }

    #[test]
    fn one_pass_has_the_bits_of_one_operation_after_the_other() {
        for damping in [[0.0, 0.0], [0.2, 0.2], [0.4, 0.0]] {
            for columns in [[0, 13], [0, 16], [3, 10], [5, 7], [4, 8], [9, 13]] {
                let [before, passed] = ended(columns, damping, true);
                assert_ne!(passed, before);
                let [_, plain] = ended(columns, damping, false);
                assert_eq!(passed, plain, "{columns:?} {damping:?}");
            }
        }
    }
}
